/* Cost image: many calls of the evaluator and of one whole tick, for an emulator to count.
 *   run_board.py BOARD IMAGE --roi wg_track_value    one call of the evaluator
 *   run_board.py BOARD IMAGE --roi cost_tick         update, events and all channels: one tick
 *   run_board.py BOARD IMAGE --roi cost_frame        a tick, the limiter and the Maestro frame
 *   run_board.py BOARD IMAGE --roi cost_limiting     the same with every servo held back
 * Positions step through each track in strides that visit all parts of a segment, in no order that
 * a cache of the last segment could use.
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "wiggly.h"
#include "maestro.h"
#include "servo.h"
#include "wg_mem.h"
#include "clip.h"

#define POSITIONS 64u
#define TICK_US   20000u
#define TICKS     100u

static wg_file file;
static wg_layer layers[CLIP_LAYERS];
static wg_player player;
static int32_t values[CLIP_CHANNELS];
static wg_servo servos[CLIP_SERVOS + 1]; /* an array of none is not C */
static uint8_t bytes[WG_BUS_BYTES(CLIP_SERVOS)];
static volatile int32_t sink; /* keeps the calls whose result nobody needs */

void cost_tick(uint32_t now_us);
void cost_frame(uint32_t now_us);
void cost_limiting(uint32_t now_us);

void __attribute__((noinline)) cost_tick(uint32_t now_us)
{
    wg_event event;
    wg_player_update(&player, now_us);
    while (wg_player_event(&player, &event)) {
        sink = event.id;
    }
    wg_player_sample(&player, values);
}

static inline void __attribute__((always_inline)) whole_frame(uint32_t now_us)
{
    cost_tick(now_us);
    wg_servo_step(&file, servos, values, TICK_US);
    sink = wg_maestro_frame(&file, servos, WG_MAESTRO_COMPACT, bytes, sizeof bytes);
}

void __attribute__((noinline)) cost_frame(uint32_t now_us)
{
    whole_frame(now_us);
}

void __attribute__((noinline)) cost_limiting(uint32_t now_us)
{
    whole_frame(now_us);
    sink = 0; /* else the compiler could make one function of the two */
}

/* The clip from its beginning. */
static void restart(void)
{
    wg_player_init(&player, &file, layers, CLIP_LAYERS);
    wg_servo_init(servos, &file);
}

/* Every servo starts each frame at the end of its range and is told to go to the show at once. */
static void hold_back(void)
{
    for (uint8_t i = 0; i < CLIP_SERVOS; i++) {
        const uint8_t *record = file.section[WG_SECTION_SERVOS].at + (uint32_t)i * WG_SERVO_BYTES;
        wg_servo_start(servos, i, (int16_t)wg_rd16(record + WG_SERVO_MIN));
    }
}

static void cost_tracks(const uint8_t *clip)
{
    uint16_t first = wg_rd16(clip + WG_CLIP_TRACK_FIRST);
    uint16_t count = wg_rd16(clip + WG_CLIP_TRACK_COUNT);
    uint32_t end = (uint32_t)wg_rd16(clip + WG_CLIP_TICKS) << 16;
    uint32_t stride = end / POSITIONS * 5u / 8u * 2u + 1u; /* odd and about 5/4 of a 64th */
    for (uint16_t track = 0; track < count; track++) {
        uint32_t position = 0;
        for (uint32_t i = 0; i < POSITIONS; i++) {
            sink = wg_track_value(&file, (uint16_t)(first + track), position);
            position = position + stride < end ? position + stride : position + stride - end;
        }
        sink = wg_track_value(&file, (uint16_t)(first + track), end);
    }
}

int main(void)
{
    hal_init();
    if (wg_open(&file, CLIP_DATA, CLIP_BYTES) < 0) {
        hal_log("clip refused");
        hal_stop(1);
    }
    const wg_section *clips = &file.section[WG_SECTION_CLIPS];
    for (uint8_t clip = 0; clip < clips->count; clip++) {
        cost_tracks(clips->at + (uint32_t)clip * WG_CLIP_BYTES);
    }
    restart();
    for (uint32_t tick = 0; tick < TICKS; tick++) {
        cost_tick(tick * TICK_US);
    }
    restart();
    for (uint32_t tick = 0; tick < TICKS; tick++) {
        cost_frame(tick * TICK_US);
    }
    restart();
    for (uint32_t tick = 0; tick < TICKS; tick++) {
        hold_back();
        cost_limiting(tick * TICK_US);
    }
    hal_log("cost done");
    hal_stop(0);
    return 0;
}
