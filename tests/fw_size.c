/* Footprint image: everything a stand-alone puppet calls and nothing of a board: player, limiter
 * and one servo protocol, the 16 channels and 2 layers of the RAM budget. It is linked, never run.
 * tests/tools/budget.py subtracts `_start` and reads the sizes below.
 * SPDX-License-Identifier: MIT */
#include "maestro.h"
#include "servo.h"
#include "wiggly.h"

/* The certificate's RAM figure is made of these (host-bake/certify.c). */
#define ASSERT_SIZE(type, bytes) typedef char size_of_##type[sizeof(type) == (bytes) ? 1 : -1]
ASSERT_SIZE(wg_file, 288);
ASSERT_SIZE(wg_player, 16);
ASSERT_SIZE(wg_layer, 48);
ASSERT_SIZE(wg_servo, 12);

#define CHANNELS 16
#define LAYERS   2

/* All the RAM there is, in one object whose size is the figure. The frame goes out at once. */
struct {
    wg_file file;
    wg_layer layers[LAYERS];
    wg_player player;
    int32_t values[CHANNELS];
    wg_servo servos[CHANNELS];
    uint8_t frame[WG_BUS_BYTES(CHANNELS)];
} size_ram;

extern const uint32_t clip_words[];
extern volatile uint32_t clock_us;
extern volatile int bus;
void _start(void);

void _start(void)
{
    wg_event event;
    if (wg_open(&size_ram.file, clip_words, 65536) < 0) {
        return;
    }
    wg_player_init(&size_ram.player, &size_ram.file, size_ram.layers, LAYERS);
    wg_servo_init(size_ram.servos, &size_ram.file);
    wg_servo_start(size_ram.servos, 0, 6000);
    wg_player_crossfade(&size_ram.player, 0, 1, 1000);
    wg_player_seek(&size_ram.player, 0, clock_us);
    wg_player_speed(&size_ram.player, 0, 5);
    wg_player_pause(&size_ram.player, 0, true);
    for (;;) {
        wg_player_update(&size_ram.player, clock_us);
        while (wg_player_event(&size_ram.player, &event)) {
            bus = event.id;
        }
        wg_player_sample(&size_ram.player, size_ram.values);
        wg_servo_step(&size_ram.file, size_ram.servos, size_ram.values, 20000);
        bus = wg_maestro_frame(&size_ram.file, size_ram.servos, wg_maestro_options(&size_ram.file),
                               size_ram.frame, sizeof size_ram.frame);
    }
}
