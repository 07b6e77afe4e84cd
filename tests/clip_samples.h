/* Sample clips for tests: one with every section and every kind of run, and single curves.
 * SPDX-License-Identifier: MIT */
#ifndef CLIP_SAMPLES_H
#define CLIP_SAMPLES_H

#include "clip_build.h"

/* A track of one LINEAR segment from 0 to `last`. */
static inline void sample_ramp(build *b, uint16_t channel, uint16_t ticks, int16_t last)
{
    uint16_t ends[1];
    int16_t values[2] = {0, 0};
    ends[0] = ticks;
    values[1] = last;
    build_run_data run = {0, 1, WG_KIND_LINEAR, 0, 0, 0, ends, NULL, values};
    build_track(b, channel);
    build_run(b, &run);
}

/* A track of `ticks` ticks on which the channel keeps one value. */
static inline void sample_level(build *b, uint16_t channel, uint16_t ticks, int32_t value)
{
    uint16_t ends[1];
    const int16_t values[2] = {0, 0};
    ends[0] = ticks;
    build_run_data run = {0, 1, WG_KIND_HELD, 0, 0, value, ends, NULL, values};
    build_track(b, channel);
    build_run(b, &run);
}

/* A track of 8 runs of two 5-tick segments, one run of every kind: 80 ticks. */
static inline void sample_all_kinds(build *b, uint16_t channel)
{
    static const uint32_t PARAMS[4] = {1u << 20, 65536u * 43u, 1u << 25, 65536u * 49u};
    static const uint32_t TRIG[2] = {1u << 26, 65536u * 98u};
    static const int16_t VALUES[8] = {900, -700, 500, -300, 400, 200, -600, 800};
    build_track(b, channel);
    for (uint8_t kind = 0; kind < WG_KIND_COUNT; kind++) {
        uint16_t start = (uint16_t)(kind * 10u), ends[2];
        ends[0] = (uint16_t)(start + 5u);
        ends[1] = (uint16_t)(start + 10u);
        build_run_data run = {start, 2, kind, 2, 0, 1000, ends, PARAMS, VALUES};
        run.params = kind == WG_KIND_OSC0 ? TRIG : PARAMS;
        run.aux = kind == WG_KIND_CUBIC ? 6 : kind == WG_KIND_EXP ? 0x21 : kind == WG_KIND_OSC;
        build_run(b, &run);
    }
}

static inline void sample_cubic(build *b, uint16_t channel, uint16_t ticks)
{
    static const int16_t KNOTS[6] = {0, 100, 3000, -50, -2000, 70};
    uint16_t ends[2];
    ends[0] = (uint16_t)(ticks / 3u);
    ends[1] = ticks;
    build_run_data run = {0, 2, WG_KIND_CUBIC, 1, 5, -400, ends, NULL, KNOTS};
    build_track(b, channel);
    build_run(b, &run);
}

static inline void sample_filters(build *b)
{
    static const uint16_t CHANNELS[2] = {0, 2};
    static const int16_t MATRIX[4] = {0, 4096, 4096, 0};
    build_filter(b, WG_FILTER_OFFSET, 0, 25, 0);
    build_filter(b, WG_FILTER_GAIN, 1, 49152, 100);
    build_filter(b, WG_FILTER_CLAMP, 2, -3000, 3000);
    build_filter(b, WG_FILTER_MIN, 1, -800, 0);
    build_matrix(b, 2, CHANNELS, MATRIX);
}

static inline void sample_servos(build *b)
{
    static const build_servo_data MAESTRO = {
        WG_PROTOCOL_MAESTRO, 3, 0, 6000 * 256, 512, 4, 4000, 8000, 4000, 2000};
    static const build_servo_data DYNAMIXEL = {
        WG_PROTOCOL_DYNAMIXEL2, 7, 1, 2048 * 256, -300, 2, 0, 4095, 0, 3000};
    static const build_servo_data PCA9685 = {
        WG_PROTOCOL_PCA9685, 15, 2, 6000 * 256, 512, 4, 4000, 8000, 0, 0};
    build_servo(b, &MAESTRO);
    build_servo(b, &DYNAMIXEL);
    build_servo(b, &PCA9685);
}

/* Every section, every kind of run, filter and servo: 3 channels, 2 clips, 2 layers, an unknown
 * section. Three channels, so that the masks' bytes end off a multiple of 4. */
static inline void sample_everything(build *b)
{
    static const uint8_t MASKS[2][3] = {{255, 128, 0}, {0, 255, 77}};
    build_channel(b, 4, WG_UNIT_DEGREE, 100);
    build_channel(b, -2, WG_UNIT_NONE, -50);
    build_channel(b, 10, WG_UNIT_MICROSECOND, 7);
    build_clip(b, 1000, 80, WG_END_LOOP);
    sample_all_kinds(b, 0);
    sample_ramp(b, 1, 80, 1600);
    build_event(b, 0, 1);
    build_event(b, 40, 2);
    build_event(b, 79, 0);
    build_clip(b, 700, 40, WG_END_PINGPONG);
    sample_cubic(b, 1, 40);
    sample_cubic(b, 2, 40);
    build_event(b, 9, 1);
    build_mask(b, MASKS[0]);
    build_mask(b, MASKS[1]);
    build_layer(b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_layer(b, 1, WG_MODE_ADD, 1, 20000);
    sample_filters(b);
    build_trigger(b, 2, 1, 1, 10);
    sample_servos(b);
    build_name(b, "arm");
    build_name(b, "");
    build_name(b, "blink");
    build_add(b, WG_SECTION_KNOWN + 1u, 4, 0x12345678u);
}

static inline uint8_t *sample_everything_file(uint32_t *size)
{
    build b = {{{0}}, 0};
    sample_everything(&b);
    return build_finish(&b, size);
}

#endif
