/* The firmware's loop against a clock and a bus made up here: a bus that is too slow costs frames
 * and not time, and servos are still stepped by the time that passed.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "clip_build.h"
#include "clip_samples.h"
#include "../hal/hal.h"

#define CLIP_LAYERS   1
#define CLIP_CHANNELS 1
#define CLIP_SERVOS   1
#define CLIP_TICK_US  20000ul
#define CLIP_DATA     clip_bytes
#define CLIP_BYTES    clip_size
#define BOARD_FRAMES  frames_wanted

static uint8_t *clip_bytes;
static uint32_t clip_size, frames_wanted;

#define main firmware_main
int firmware_main(void);
#include "../firmware/main.c"
#undef main

#define SENT_MAX 200
static uint32_t clock_us, write_us, slow_from, slow_to; /* what a write takes, which are slow */
static uint16_t sent;
static uint32_t sent_us[SENT_MAX];
static uint16_t sent_position[SENT_MAX];
static int late_lines, stop_code;

void hal_init(void)
{
    clock_us = 7;
    sent = 0;
    late_lines = 0;
    stop_code = -1;
}

uint32_t hal_time_us(void)
{
    return clock_us;
}

void hal_wait_until(uint32_t time_us)
{
    clock_us = (int32_t)(time_us - clock_us) > 0 ? time_us : clock_us;
}

/* Set Target of one Maestro channel: 84 id low high. */
void hal_bus_write(const uint8_t *data, uint16_t count)
{
    CHECK_EQ(count, 4);
    CHECK_EQ(data[0], WG_MAESTRO_TARGET);
    if (sent < SENT_MAX) {
        sent_us[sent] = clock_us;
        sent_position[sent] = (uint16_t)(data[2] | data[3] << 7);
        clock_us += sent >= slow_from && sent < slow_to ? write_us : 100;
        sent++;
    }
}

uint16_t hal_bus_read(uint8_t *data, uint16_t size)
{
    (void)data;
    (void)size;
    return 0;
}

int hal_i2c_write(uint8_t address, const uint8_t *data, uint16_t count)
{
    (void)address;
    (void)data;
    (void)count;
    return -1;
}

void hal_log(const char *text)
{
    late_lines += strncmp(text, "late", 4) == 0;
}

void hal_stop(int code)
{
    stop_code = code;
}

/* One servo that goes from 4000 to 8000 in 2 s, plays `count` frames. */
static void run(uint32_t count, uint32_t slow_us, uint32_t from, uint32_t to)
{
    static const build_servo_data servo = {
        WG_PROTOCOL_MAESTRO, 3, 0, 4000 << 8, 256, 0, 4000, 8000, 0, 0};
    build b = {{{0}}, 0};
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 1000, 2000, WG_END_HOLD);
    sample_ramp(&b, 0, 2000, 4000);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_servo(&b, &servo);
    clip_bytes = build_finish(&b, &clip_size);
    frames_wanted = count;
    write_us = slow_us;
    slow_from = from;
    slow_to = to;
    firmware_main();
    CHECK_EQ(stop_code, 0);
    free(clip_bytes);
}

static uint16_t position_at(uint32_t now_us)
{
    return (uint16_t)(4000 + now_us / 500u);
}

static void frames_on_time_are_all_sent(void)
{
    run(50, 19900, 0, 50);
    CHECK_EQ(sent, 50);
    CHECK_EQ(late_lines, 0);
    for (uint16_t i = 0; i < sent; i++) {
        CHECK_NEAR(sent_position[i], position_at(i * 20000u), 1);
    }
}

/* A frame that is late by less than a tick is sent for its own time and nothing is skipped. */
static void one_slow_frame_is_made_up_for(void)
{
    run(50, 39000, 10, 11);
    CHECK_EQ(sent, 50);
    CHECK_EQ(late_lines, 0);
    CHECK_EQ(sent_us[11] - sent_us[10], 39000);
    CHECK_EQ(sent_us[12] - sent_us[11], 1000);
    CHECK_NEAR(sent_position[11], position_at(11 * 20000u), 1);
}

static void slow_bus_skips_frames_and_keeps_the_time(void)
{
    run(100, 50000, 0, SENT_MAX);
    CHECK_EQ(sent, 41); /* 2 s at 50 ms each, and one more because frame 98 came due before */
    CHECK_EQ(late_lines, 1);
    for (uint16_t i = 0; i < sent; i++) {
        uint32_t at_us = sent_us[i] - sent_us[0];
        CHECK_NEAR(sent_position[i], position_at(at_us / 20000u * 20000u), 1);
    }
}

static void schedule_is_kept_after_a_long_stop(void)
{
    run(100, 500000, 10, 11);
    CHECK_EQ(late_lines, 1);
    CHECK_EQ(sent, 100 - 24); /* of frames 11 to 35 only the last: 500 ms are 25 ticks */
    CHECK_NEAR(sent_position[11], position_at(35 * 20000u), 1);
    CHECK_EQ((sent_us[12] - sent_us[0]) % 20000u, 0);
}

int main(void)
{
    TEST(frames_on_time_are_all_sent);
    TEST(one_slow_frame_is_made_up_for);
    TEST(slow_bus_skips_frames_and_keeps_the_time);
    TEST(schedule_is_kept_after_a_long_stop);
    return check_done();
}
