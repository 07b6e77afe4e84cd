/* The firmware: every 20 ms the linked-in clip becomes servo commands.
 *   hal (time) -> player (channel values) -> device (servo positions, bytes) -> hal (bus)
 *                                         -> screen (what a display shows of the clip's shapes)
 * The player is given the time a frame was scheduled for, never the time it happened to run at: the
 * bytes on the bus are the same on every board and in every run while no frame is a whole tick late
 * (a bus too slow for its servos). Frames that are get skipped: the show keeps its length.
 *
 * Servos start at their first target, because nobody knows where they stand. Call wg_servo_start
 * after wg_servo_init for a servo whose position is known, and it approaches gently (servo.h).
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "wiggly.h"

#include "dynamixel2.h"
#include "maestro.h"
#include "pca9685.h"
#include "screen.h"
#include "servo.h"

#include "clip.h" /* CLIP_*: the clip and its sizes, written by the baker */

#ifndef CLIP_FIELDS
#define CLIP_FIELDS 0 /* channels that are means of others */
#endif

#ifndef BOARD_FRAMES
#define BOARD_FRAMES 0 /* how many frames until the firmware stops; 0: it never does */
#endif

#define TICK_US     ((uint32_t)CLIP_TICK_US)
#define PWM_CHIPS   (WG_SERVOS_MAX / WG_PCA9685_CHANNELS)
#define PWM_WAKE_US 500u /* the PCA9685's oscillator starts */

static wg_file file;
static wg_layer layers[CLIP_LAYERS];
static wg_player player;
static int32_t values[CLIP_CHANNELS];
static wg_servo servos[CLIP_SERVOS + 1]; /* an array of none is not C */
static uint8_t bytes[WG_BUS_BYTES(CLIP_SERVOS)];
static const wg_pca9685 pwm = WG_PCA9685(25000000, 50);
static uint16_t maestro_options;
static uint8_t pwm_chips; /* that the clip uses; 0 when one of them did not answer */

/* `label` and a number of up to five digits. */
static void log_number(const char *label, uint16_t number)
{
    char text[32], digits[5];
    uint8_t length = 0, count = 0;
    while (*label && length < sizeof text - sizeof digits - 1) {
        text[length++] = *label++;
    }
    do {
        digits[count++] = (char)('0' + number % 10u);
        number = (uint16_t)(number / 10u);
    } while (number); /* 16 bits: five times at most */
    while (count) {
        text[length++] = digits[--count];
    }
    text[length] = 0;
    hal_log(text);
}

static void send(int count)
{
    if (count > 0) {
        hal_bus_write(bytes, (uint16_t)count);
    }
}

/* Dynamixel servos do not move before their torque is switched on; others need nothing. */
static void bus_start(void)
{
    static const uint8_t torque_on[] = {WG_DYNAMIXEL2_TORQUE_ENABLE, 0, 1};
    const wg_dynamixel2 packet = {WG_DYNAMIXEL2_BROADCAST, WG_DYNAMIXEL2_WRITE, torque_on,
                                  sizeof torque_on};
    if (wg_bus_count(&file, WG_PROTOCOL_DYNAMIXEL2) > 0) {
        send(wg_dynamixel2_packet(&packet, bytes, sizeof bytes));
    }
}

static int pwm_write(uint8_t chip, int count)
{
    return hal_i2c_write((uint8_t)(WG_PCA9685_ADDRESS + chip), bytes, (uint16_t)count);
}

/* Wakes every PCA9685 that the clip has servos on. */
static void pwm_start(void)
{
    int count, answer = 0;
    for (uint8_t chip = 0; chip < PWM_CHIPS; chip++) {
        if (wg_pca9685_frame(&file, servos, &pwm, chip, bytes) == 0) {
            continue;
        }
        for (uint8_t step = 0; (count = wg_pca9685_setup(&pwm, step, bytes, sizeof bytes)) > 0;
             step++) {
            answer |= pwm_write(chip, count);
        }
        pwm_chips = (uint8_t)(chip + 1);
    }
    if (answer < 0) {
        hal_log("no answer on I2C");
        pwm_chips = 0;
    }
    hal_wait_until(hal_time_us() + PWM_WAKE_US);
}

static void pwm_send(void)
{
    for (uint8_t chip = 0; chip < pwm_chips; chip++) {
        int count = wg_pca9685_frame(&file, servos, &pwm, chip, bytes);
        if (count > 0) {
            pwm_write(chip, count);
        }
    }
}

/* One frame: the clip at `now_us`, `dt_us` after the frame before, on the bus. */
static void frame(uint32_t now_us, uint32_t dt_us)
{
    wg_event event;
    wg_player_update(&player, now_us);
    while (wg_player_event(&player, &event)) {
        log_number("event ", event.id);
    }
    wg_player_sample(&player, values);
    if (CLIP_FIELDS) { /* the linker drops it otherwise */
        wg_fields_set(&file, values);
    }
    wg_servo_step(&file, servos, values, dt_us);
    send(wg_maestro_frame(&file, servos, maestro_options, bytes, sizeof bytes));
    send(wg_dynamixel2_frame(&file, servos, bytes, sizeof bytes));
    pwm_send();
    screen_frame(values);
}

/* Until `due_us`, making the display's picture meanwhile. */
static void wait(uint32_t due_us)
{
    while ((int32_t)(due_us - hal_time_us()) > 0 && screen_work()) { /* a tick at the longest */
    }
    hal_wait_until(due_us);
}

/* How many whole ticks have passed since `due_us`. */
static uint32_t ticks_late(uint32_t due_us)
{
    int32_t late_us = (int32_t)(hal_time_us() - due_us);
    return late_us < (int32_t)TICK_US ? 0 : (uint32_t)late_us / TICK_US;
}

/* Frames from now on, on schedule: `frame_count` of them, skipped ones included; 0: for ever. */
static void play(uint32_t frame_count)
{
    uint32_t start_us = hal_time_us();
    uint32_t now_us = 0; /* since start_us; both wrap after 71 minutes, which no frame notices */
    uint32_t skipped = 0;
    bool late = false;
    for (uint32_t count = 0; frame_count == 0 || count < frame_count; count += skipped + 1u) {
        wait(start_us + now_us);
        skipped = ticks_late(start_us + now_us);
        if (skipped && !late) {
            late = true;
            hal_log("late: frames skipped");
        }
        now_us += skipped * TICK_US;
        frame(now_us, (skipped + 1u) * TICK_US);
        now_us += TICK_US;
    }
}

/* Stops if the clip was refused. */
static void need(int error)
{
    if (error < 0) {
        log_number("clip refused: error -", (uint16_t)-error);
        hal_stop(1);
    }
}

int main(void)
{
    hal_init();
    need(wg_open(&file, CLIP_DATA, CLIP_BYTES));
    if (CLIP_FIELDS) { /* skins are checked against their shapes */
        need(wg_open_shapes(&file));
        need(wg_open_skins(&file));
    }
    log_number("opened: servos ", file.section[WG_SECTION_SERVOS].count);
    wg_player_init(&player, &file, layers, CLIP_LAYERS);
    wg_servo_init(servos, &file);
    maestro_options = wg_maestro_options(&file);
    bus_start();
    pwm_start();
    need(screen_start(&file));
    play(BOARD_FRAMES);
    screen_finish(values);
    hal_log("done");
    hal_stop(0);
    return 0;
}
