/* Layers: modes, masks, weight ramps, cross-fades, filters, saturation.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "clip_samples.h"
#include "wiggly.h"

#define LIMIT 536870912 /* 2^29: values saturate here */

typedef struct {
    uint8_t *clip;
    wg_file file;
    wg_layer layers[3];
    wg_player player;
} stage;

static uint32_t seed = 3;

static uint32_t rnd(uint32_t below)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)seed * below) >> 32);
}

/* Three channels at rest on 100, -200, 300 and clips 0, 1, 2 that hold all of them on 10000, -3001
 * and 0; clip 3 moves only channel 1. Mask 0 is 255, 128, 0. */
static void begin(build *b)
{
    static const int32_t LEVEL[3] = {10000, -3001, 0};
    static const uint8_t MASK[3] = {255, 128, 0};
    build_channel(b, 0, 0, 100);
    build_channel(b, 0, 0, -200);
    build_channel(b, 0, 0, 300);
    for (unsigned c = 0; c < 3; c++) {
        build_clip(b, 1000, 100, WG_END_HOLD);
        for (uint16_t i = 0; i < 3; i++) {
            sample_level(b, i, 100, LEVEL[c]);
        }
    }
    build_clip(b, 1000, 100, WG_END_HOLD);
    sample_level(b, 1, 100, 777);
    build_mask(b, MASK);
}

static void finish(stage *s, build *b, uint8_t layers)
{
    uint32_t size;
    s->clip = build_finish(b, &size);
    CHECK_EQ(wg_open(&s->file, s->clip, size), 0);
    wg_player_init(&s->player, &s->file, s->layers, layers);
    wg_player_update(&s->player, 0);
}

static void check_values(const stage *s, int32_t a, int32_t b, int32_t c)
{
    int32_t values[3];
    wg_player_sample(&s->player, values);
    CHECK_EQ(values[0], a);
    CHECK_EQ(values[1], b);
    CHECK_EQ(values[2], c);
}

static int32_t first_value(const stage *s)
{
    int32_t values[3];
    wg_player_sample(&s->player, values);
    return values[0];
}

/* floor(a w / 2^15), written with a division. */
static int32_t weighed(int64_t a, int64_t w)
{
    int64_t p = a * w;
    return (int32_t)(p / 32768 - (p % 32768 < 0));
}

/* ---- modes and masks ------------------------------------------------------------------------- */

static void layers_start_as_the_clip_says(void)
{
    stage s;
    build b = {{{0}}, 0};
    begin(&b);
    build_layer(&b, 3, WG_MODE_ADD, 0, 1234);
    build_layer(&b, WG_NONE, WG_MODE_OVERRIDE, WG_NONE, 0);
    finish(&s, &b, 3);
    CHECK_EQ(s.layers[0].clip, 3);
    CHECK_EQ(s.layers[0].mode, WG_MODE_ADD);
    CHECK_EQ(s.layers[0].mask, 0);
    CHECK_EQ(s.layers[0].fade_to, 1234);
    CHECK_EQ(s.layers[0].playing, 1);
    CHECK_EQ(s.layers[1].clip, WG_NONE);
    CHECK_EQ(s.layers[1].fade_to, 0);
    CHECK_EQ(s.layers[2].clip, WG_NONE); /* the player has one more than the clip */
    CHECK_EQ(s.layers[2].mask, WG_NONE);
    CHECK_EQ(s.layers[2].fade_to, 32768);
    free(s.clip);
}

static void silent_layers_leave_rest(void)
{
    stage s;
    build b = {{{0}}, 0};
    begin(&b);
    finish(&s, &b, 3);
    check_values(&s, 100, -200, 300);
    wg_player_play(&s.player, 1, 3);
    check_values(&s, 100, 777, 300);
    free(s.clip);
}

static void override_and_add_weigh_exactly(void)
{
    static const uint16_t WEIGHT[] = {0, 1, 5000, 16384, 32767, 32768};
    static const int32_t REST[3] = {100, -200, 300};
    for (unsigned i = 0; i < 12; i++) {
        stage s;
        build b = {{{0}}, 0};
        uint16_t w = WEIGHT[i / 2];
        bool add = i % 2;
        int32_t want[3];
        begin(&b);
        build_layer(&b, 1, add ? WG_MODE_ADD : WG_MODE_OVERRIDE, WG_NONE, w);
        finish(&s, &b, 1);
        for (unsigned c = 0; c < 3; c++) {
            want[c] = REST[c] + weighed(add ? -3001 : -3001 - REST[c], w);
        }
        check_values(&s, want[0], want[1], want[2]);
        free(s.clip);
    }
}

static void layers_mix_in_order(void)
{
    stage s;
    build b = {{{0}}, 0};
    begin(&b);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_layer(&b, 1, WG_MODE_OVERRIDE, WG_NONE, 8192);
    build_layer(&b, 3, WG_MODE_ADD, WG_NONE, 32768);
    finish(&s, &b, 3);
    int32_t mixed = 10000 + weighed(-13001, 8192);
    check_values(&s, mixed, mixed + 777, mixed);
    free(s.clip);
}

/* 255 stands for 1 exactly, 128 for 129/256, 0 for nothing. */
static void masks_scale_channels(void)
{
    stage s;
    build b = {{{0}}, 0};
    begin(&b);
    build_layer(&b, 0, WG_MODE_OVERRIDE, 0, 32768);
    finish(&s, &b, 1);
    check_values(&s, 10000, -200 + weighed(10200, 16512), 300);
    wg_player_fade(&s.player, 0, 16384, 0);
    check_values(&s, 100 + weighed(9900, 16384), -200 + weighed(10200, 8256), 300);
    free(s.clip);
}

static void values_saturate(void)
{
    stage s;
    for (int sign = -1; sign <= 1; sign += 2) {
        build b = {{{0}}, 0};
        build_channel(&b, 0, 0, sign * (1 << 28));
        build_clip(&b, 1000, 100, WG_END_HOLD);
        sample_level(&b, 0, 100, sign * (1 << 28));
        for (unsigned i = 0; i < 3; i++) {
            build_layer(&b, 0, WG_MODE_ADD, WG_NONE, 32768);
        }
        finish(&s, &b, 1);
        CHECK_EQ(first_value(&s), sign * LIMIT);
        free(s.clip);
        build c = {{{0}}, 0};
        build_channel(&c, 0, 0, sign * (1 << 28));
        build_clip(&c, 1000, 100, WG_END_HOLD);
        sample_level(&c, 0, 100, sign * (1 << 28));
        build_layer(&c, 0, WG_MODE_ADD, WG_NONE, 32768);
        build_layer(&c, 0, WG_MODE_ADD, WG_NONE, 32768);
        build_layer(&c, 0, WG_MODE_ADD, WG_NONE, 1);
        finish(&s, &c, 3);
        CHECK_EQ(first_value(&s), sign * LIMIT);
        free(s.clip);
    }
}

/* ---- weight ramps ---------------------------------------------------------------------------- */

/* A layer of weight 32768 shows 10000 over a rest of 100; the weight itself is read from a clip of
 * one channel that holds 2^20 over a rest of 0: value = weight 32. */
static void scale_open(stage *s, uint16_t weight)
{
    build b = {{{0}}, 0};
    build_channel(&b, 0, 0, 0);
    for (int c = 0; c < 2; c++) {
        build_clip(&b, 1000, 100, WG_END_LOOP);
        sample_level(&b, 0, 100, c ? -(1 << 20) : 1 << 20);
    }
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, weight);
    build_layer(&b, WG_NONE, WG_MODE_OVERRIDE, WG_NONE, 0);
    finish(s, &b, 2);
}

static double quintic(double u)
{
    return u * u * u * (10 + u * (6 * u - 15));
}

/* Bound in units of 2^-15: u is short by < 3 (a floor each for the fraction, the quotient and what
 * scales them) where the quintic's slope is <= 15/8: < 5.7; the quintic itself by < 1.01, the last
 * floor 1. */
#define FADE_BOUND 7.8

static void check_fade(int32_t from, int32_t to, uint32_t fade_us, uint32_t step)
{
    stage s;
    scale_open(&s, (uint16_t)from);
    wg_player_fade(&s.player, 0, (uint16_t)to, fade_us);
    int32_t last = from;
    CHECK_EQ(first_value(&s), from * 32);
    for (uint64_t t = 0; t < fade_us; t += step) {
        wg_player_update(&s.player, (uint32_t)t);
        int32_t weight = first_value(&s) / 32;
        CHECK_NEAR(weight, from + (to - from) * quintic((double)t / fade_us), FADE_BOUND);
        CHECK(to > from ? weight >= last && weight <= to : weight <= last && weight >= to);
        last = weight;
    }
    wg_player_update(&s.player, fade_us);
    CHECK_EQ(first_value(&s), to * 32);
    wg_player_update(&s.player, fade_us + 1234567u);
    CHECK_EQ(first_value(&s), to * 32);
    free(s.clip);
}

static void fades_are_monotone_and_exact_at_the_ends(void)
{
    check_fade(0, 32768, 1000000, 10);
    check_fade(32768, 0, 1000000, 10);
    check_fade(1000, 20000, 32768, 1);
    check_fade(32768, 32767, 1000, 1);
    check_fade(5, 5, 1000, 7);
    check_fade(0, 32768, 1, 1);
    check_fade(0, 32768, 3, 1);
    check_fade(0, 32768, 131071, 13);
    check_fade(0, 32768, 1048320, 997); /* (2^32 - 1) / 1048320 is just below a whole number */
    check_fade(0, 32768, 10000000, 1001);
}

/* Any length up to 71 minutes; the sharpest are those just above a power of two. */
static void long_fades_do_not_jump(void)
{
    check_fade(0, 32768, 600000000u, 100003u);
    check_fade(0, 32768, 2147483648u, 300007u);
    check_fade(32768, 0, 2200000000u, 300007u);
    check_fade(0, 32768, 4294967295u, 300007u);
}

/* C2: the first difference over 1 % of the ramp starts and ends near zero as u^3 does, and the
 * second one too, which a cubic smoothstep's (6 / 100^2 of the way) does not. */
static void fades_start_and_end_without_a_jerk(void)
{
    stage s;
    int32_t w[101];
    scale_open(&s, 0);
    wg_player_fade(&s.player, 0, 32768, 100000);
    for (uint32_t i = 0; i <= 100; i++) {
        wg_player_update(&s.player, i * 1000u);
        w[i] = first_value(&s) / 32;
    }
    CHECK_NEAR(w[1] - w[0], 0, 2);
    CHECK_NEAR(w[2] - 2 * w[1] + w[0], 0, 4);
    CHECK_NEAR(w[100] - w[99], 0, 8);
    CHECK_NEAR(w[100] - 2 * w[99] + w[98], 0, 10); /* smoothstep: 20 */
    CHECK_NEAR(w[50], 16384, FADE_BOUND);
    free(s.clip);
}

static void interrupted_fade_continues_from_its_weight(void)
{
    stage s;
    scale_open(&s, 0);
    wg_player_fade(&s.player, 0, 32768, 100000);
    uint32_t now = 0;
    for (unsigned i = 0; i < 200; i++) {
        now += rnd(40000);
        wg_player_update(&s.player, now);
        int32_t before = first_value(&s);
        wg_player_fade(&s.player, 0, (uint16_t)rnd(32769), 1u + rnd(100000));
        CHECK_EQ(first_value(&s), before);
        wg_player_update(&s.player, now);
        CHECK_EQ(first_value(&s), before);
    }
    free(s.clip);
}

static void crossfade_covers_and_uncovers(void)
{
    stage s;
    scale_open(&s, 32768);
    CHECK_EQ(first_value(&s), 1 << 20);
    wg_player_crossfade(&s.player, 0, 1, 100000);
    CHECK_EQ(first_value(&s), 1 << 20);
    CHECK_EQ(s.layers[1].clip, 1);
    int32_t last = 1 << 20;
    for (uint32_t t = 0; t <= 100000; t += 500) {
        wg_player_update(&s.player, t);
        CHECK(first_value(&s) <= last);
        last = first_value(&s);
    }
    CHECK_EQ(last, -(1 << 20));
    wg_player_crossfade(&s.player, 0, 0, 100000); /* back: the lower gets the clip */
    CHECK_EQ(first_value(&s), -(1 << 20));
    CHECK_EQ(s.layers[0].clip, 0);
    for (uint32_t t = 0; t <= 100000; t += 500) {
        wg_player_update(&s.player, 100000 + t);
        CHECK(first_value(&s) >= last);
        last = first_value(&s);
    }
    CHECK_EQ(last, 1 << 20);
    wg_player_crossfade(&s.player, 0, 1, 0);
    CHECK_EQ(first_value(&s), -(1 << 20));
    free(s.clip);
}

static void crossfade_from_silence_fades_from_rest(void)
{
    stage s;
    build b = {{{0}}, 0};
    begin(&b);
    build_layer(&b, WG_NONE, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_layer(&b, WG_NONE, WG_MODE_OVERRIDE, WG_NONE, 32768);
    finish(&s, &b, 2);
    wg_player_crossfade(&s.player, 0, 0, 1000);
    check_values(&s, 100, -200, 300);
    wg_player_update(&s.player, 1000);
    check_values(&s, 10000, 10000, 10000);
    free(s.clip);
}

/* ---- filters --------------------------------------------------------------------------------- */

/* One filter over channel 0 at `value`. */
static int32_t filtered(int32_t value, uint8_t op, int32_t p, int32_t q)
{
    stage s;
    build b = {{{0}}, 0};
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 1000, 100, WG_END_HOLD);
    sample_level(&b, 0, 100, value);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_filter(&b, op, 0, p, q);
    finish(&s, &b, 1);
    int32_t result = first_value(&s);
    free(s.clip);
    return result;
}

static void filters_of_every_kind(void)
{
    const int32_t big = 1 << 28;
    CHECK_EQ(filtered(1000, WG_FILTER_OFFSET, -1500, 0), -500);
    CHECK_EQ(filtered(big, WG_FILTER_OFFSET, big, 0), LIMIT);
    CHECK_EQ(filtered(-big, WG_FILTER_OFFSET, -big, 0), -LIMIT);
    CHECK_EQ(filtered(1000, WG_FILTER_GAIN, 65536, 0), 1000);
    CHECK_EQ(filtered(1000, WG_FILTER_GAIN, -65536, 0), -1000);
    CHECK_EQ(filtered(1000, WG_FILTER_GAIN, 32768, 2000), 1500);
    CHECK_EQ(filtered(1001, WG_FILTER_GAIN, 32768, 0), 500); /* floors */
    CHECK_EQ(filtered(-1001, WG_FILTER_GAIN, 32768, 0), -501);
    CHECK_EQ(filtered(big, WG_FILTER_GAIN, big, -big), LIMIT);
    CHECK_EQ(filtered(-big, WG_FILTER_GAIN, big, big), -LIMIT);
    CHECK_EQ(filtered(70, WG_FILTER_CLAMP, -50, 50), 50);
    CHECK_EQ(filtered(-70, WG_FILTER_CLAMP, -50, 50), -50);
    CHECK_EQ(filtered(7, WG_FILTER_CLAMP, -50, 50), 7);
    CHECK_EQ(filtered(7, WG_FILTER_CLAMP, 50, -50), 50); /* a comes first */
    CHECK_EQ(filtered(7, WG_FILTER_MIN, 9, 0), 9);
    CHECK_EQ(filtered(9, WG_FILTER_MIN, 7, 0), 9);
}

static void filters_apply_in_order(void)
{
    stage s;
    build b = {{{0}}, 0};
    begin(&b);
    build_filter(&b, WG_FILTER_OFFSET, 0, 11, 0);
    build_filter(&b, WG_FILTER_GAIN, 0, 131072, 0);
    build_filter(&b, WG_FILTER_OFFSET, 2, 1, 0);
    finish(&s, &b, 1);
    check_values(&s, 222, -200, 301);
    free(s.clip);
}

static void matrix_swaps_channels(void)
{
    static const uint16_t CHANNELS[2] = {2, 0};
    static const int16_t SWAP[4] = {0, 4096, 4096, 0};
    stage s;
    build b = {{{0}}, 0};
    begin(&b);
    build_matrix(&b, 2, CHANNELS, SWAP);
    finish(&s, &b, 1);
    check_values(&s, 300, -200, 100);
    free(s.clip);
}

/* The largest matrix: r'_i = floor(sum_j M_ij r_j / 2^12), against a sum in 64 bits; and one that
 * saturates both ways. */
static void matrix_of_eight_channels(void)
{
    uint16_t channels[8];
    int16_t m[64];
    int32_t rest[8], values[8];
    for (unsigned round = 0; round < 200; round++) {
        bool huge = round % 2;
        stage s;
        build b = {{{0}}, 0};
        for (unsigned i = 0; i < 8; i++) {
            channels[i] = (uint16_t)(7u - i);
            rest[i] = (int32_t)rnd(huge ? 1u << 29 : 20000) - (huge ? 1 << 28 : 10000);
            build_channel(&b, 0, 0, rest[i]);
        }
        for (unsigned i = 0; i < 64; i++) {
            m[i] = (int16_t)((int32_t)rnd(65536) - 32768);
        }
        build_clip(&b, 1000, 100, WG_END_HOLD);
        build_matrix(&b, 8, channels, m);
        finish(&s, &b, 1);
        wg_player_sample(&s.player, values);
        for (unsigned i = 0; i < 8; i++) {
            int64_t sum = 0;
            for (unsigned j = 0; j < 8; j++) {
                sum += (int64_t)m[8 * i + j] * rest[channels[j]];
            }
            sum = sum / 4096 - (sum % 4096 < 0);
            CHECK_EQ(values[channels[i]], sum > LIMIT ? LIMIT : sum < -LIMIT ? -LIMIT : sum);
        }
        free(s.clip);
    }
}

int main(void)
{
    TEST(layers_start_as_the_clip_says);
    TEST(silent_layers_leave_rest);
    TEST(override_and_add_weigh_exactly);
    TEST(layers_mix_in_order);
    TEST(masks_scale_channels);
    TEST(values_saturate);
    TEST(fades_are_monotone_and_exact_at_the_ends);
    TEST(long_fades_do_not_jump);
    TEST(fades_start_and_end_without_a_jerk);
    TEST(interrupted_fade_continues_from_its_weight);
    TEST(crossfade_covers_and_uncovers);
    TEST(crossfade_from_silence_fades_from_rest);
    TEST(filters_of_every_kind);
    TEST(filters_apply_in_order);
    TEST(matrix_swaps_channels);
    TEST(matrix_of_eight_channels);
    return check_done();
}
