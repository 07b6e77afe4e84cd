/* Layer time: position, end policies, speed, and the bits at an instant whatever the ticks were.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "clip_samples.h"
#include "wiggly.h"

#define RAMP_US 100000u /* clip 0: 1000 ticks a second, 100 ticks, value = 10 x tick */

typedef struct {
    uint8_t *clip;
    wg_file file;
    wg_layer layers[2];
    wg_player player;
} stage;

static uint32_t seed = 1;

static uint32_t rnd(uint32_t below)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)seed * below) >> 32);
}

/* Clip 0: a ramp of `end` policy on channel 0. Clip 1: the sample of all kinds on channel 1, 80
 * ticks at 700 a second, so that its duration has a fraction of a microsecond. */
static void stage_open(stage *s, uint8_t end, uint8_t layers)
{
    uint32_t size;
    build b = {{{0}}, 0};
    build_channel(&b, 0, 0, -5);
    build_channel(&b, 0, 0, 77);
    build_clip(&b, 1000, 100, end);
    sample_ramp(&b, 0, 100, 1000);
    build_clip(&b, 700, 80, end);
    sample_all_kinds(&b, 1);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_layer(&b, 1, WG_MODE_OVERRIDE, WG_NONE, 32768);
    s->clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&s->file, s->clip, size), 0);
    wg_player_init(&s->player, &s->file, s->layers, layers);
    wg_player_update(&s->player, 0);
}

static int32_t value(const stage *s, unsigned channel)
{
    int32_t values[2] = {0, 0};
    wg_player_sample(&s->player, values);
    return values[channel];
}

/* The ramp at t microseconds into the clip: 1 raw unit each 100 us, to the nearest, within one. */
static void check_ramp(const stage *s, double t_us)
{
    CHECK_NEAR(value(s, 0), t_us / 100.0, 0.51 + 1e-3);
}

/* ---- pure sampling --------------------------------------------------------------------------- */

static void position_is_exact_floor_and_clamps(void)
{
    stage s;
    stage_open(&s, WG_END_HOLD, 1);
    CHECK_EQ(wg_clip_position(&s.file, 0, 0), 0);
    for (uint32_t i = 0; i < 20000; i++) {
        uint32_t t = rnd(RAMP_US);
        /* mul is within half of 2^-31 of itself, the floor takes up to one unit more */
        double want = t * 65.536;
        CHECK_NEAR(wg_clip_position(&s.file, 0, t), want - 0.5, 0.5 + want * 0x1p-31);
    }
    CHECK_EQ(wg_clip_position(&s.file, 0, RAMP_US), 100u << 16);
    CHECK_EQ(wg_clip_position(&s.file, 0, 0xffffffffu), 100u << 16);
    free(s.clip);
}

static void channels_without_a_track_rest(void)
{
    stage s;
    int32_t values[2], velocities[2] = {9, 9};
    stage_open(&s, WG_END_HOLD, 1);
    wg_clip_sample(&s.file, 0, 50000, values, velocities);
    CHECK_EQ(values[0], 500);
    CHECK_EQ(values[1], 77);
    CHECK_NEAR(velocities[0], 10000, 2);
    CHECK_EQ(velocities[1], 0);
    wg_player_play(&s.player, 0, WG_NONE);
    wg_player_update(&s.player, 5000);
    CHECK_EQ(value(&s, 0), -5);
    CHECK_EQ(wg_player_time(&s.player, 0), 0);
    CHECK(wg_player_ended(&s.player, 0));
    free(s.clip);
}

/* ---- the same bits at the same instant ------------------------------------------------------- */

static void same_state(const wg_layer *p, const wg_layer *q)
{
    CHECK(p->head == q->head);
    CHECK_EQ(p->faded_us, q->faded_us);
}

static void any_tick_pattern_gives_the_same_bits(void)
{
    static const int32_t SPEEDS[] = {65536, 40000, 1, 300000, -65536, -77777, 0, 2000000000};
    for (uint8_t end = 0; end < 3; end++) {
        for (unsigned k = 0; k < 8; k++) {
            stage whole, parts;
            stage_open(&whole, end, 2);
            stage_open(&parts, end, 2);
            for (uint8_t layer = 0; layer < 2; layer++) {
                wg_player_seek(&whole.player, layer, 30000);
                wg_player_seek(&parts.player, layer, 30000);
                wg_player_speed(&whole.player, layer, SPEEDS[k]);
                wg_player_speed(&parts.player, layer, SPEEDS[k]);
                wg_player_fade(&whole.player, layer, 500, 700000);
                wg_player_fade(&parts.player, layer, 500, 700000);
            }
            uint32_t stop = 1u + rnd(900000), now = 0;
            wg_player_update(&whole.player, stop);
            while (now < stop) {
                uint32_t dt = rnd(4) ? rnd(3000) : 0;
                now = stop - now < dt ? stop : now + dt;
                wg_player_update(&parts.player, now);
            }
            same_state(&whole.layers[0], &parts.layers[0]);
            same_state(&whole.layers[1], &parts.layers[1]);
            CHECK_EQ(value(&whole, 0), value(&parts, 0));
            CHECK_EQ(value(&whole, 1), value(&parts, 1));
            free(whole.clip);
            free(parts.clip);
        }
    }
}

static void seek_back_equals_fresh_play(void)
{
    stage fresh, used;
    stage_open(&used, WG_END_LOOP, 2);
    for (unsigned i = 0; i < 500; i++) {
        uint32_t t = rnd(80000), now = used.player.now_us;
        wg_player_update(&used.player, now + rnd(1000000));
        wg_player_seek(&used.player, 1, t);
        stage_open(&fresh, WG_END_LOOP, 2);
        wg_player_update(&fresh.player, t);
        int32_t values[2], played = value(&fresh, 1);
        wg_clip_sample(&used.file, 1, t, values, NULL);
        CHECK_EQ(value(&used, 1), played);
        CHECK_EQ(values[1], played);
        free(fresh.clip);
    }
    free(used.clip);
}

static void clock_wrap_goes_unnoticed(void)
{
    stage s, plain;
    stage_open(&s, WG_END_LOOP, 2);
    stage_open(&plain, WG_END_LOOP, 2);
    wg_player_init(&s.player, &s.file, s.layers, 2);
    wg_player_update(&s.player, 0xffffffffu - 50000u);
    for (uint32_t t = 0; t < 200000; t += 777) {
        wg_player_update(&s.player, t - 50001u);
        wg_player_update(&plain.player, t);
        same_state(&s.layers[0], &plain.layers[0]);
        CHECK_EQ(value(&s, 1), value(&plain, 1));
    }
    free(s.clip);
    free(plain.clip);
}

static void first_update_only_sets_the_clock(void)
{
    stage s;
    stage_open(&s, WG_END_HOLD, 1);
    wg_player_init(&s.player, &s.file, s.layers, 1);
    wg_player_update(&s.player, 3000000000u);
    CHECK_EQ(wg_player_time(&s.player, 0), 0);
    wg_player_update(&s.player, 3000000123u);
    CHECK_EQ(wg_player_time(&s.player, 0), 123);
    free(s.clip);
}

/* ---- end policies ---------------------------------------------------------------------------- */

static void holds_at_both_ends(void)
{
    stage s;
    stage_open(&s, WG_END_HOLD, 1);
    CHECK(!wg_player_ended(&s.player, 0));
    wg_player_update(&s.player, RAMP_US - 1);
    CHECK(!wg_player_ended(&s.player, 0));
    wg_player_update(&s.player, RAMP_US);
    CHECK(wg_player_ended(&s.player, 0));
    wg_player_update(&s.player, 4000000000u);
    CHECK_EQ(value(&s, 0), 1000);
    CHECK_EQ(wg_player_time(&s.player, 0), RAMP_US);
    wg_player_speed(&s.player, 0, -WG_SPEED_ONE);
    CHECK(!wg_player_ended(&s.player, 0));
    wg_player_update(&s.player, 4000060000u);
    check_ramp(&s, 40000);
    wg_player_update(&s.player, 4000200000u);
    CHECK_EQ(value(&s, 0), 0);
    CHECK(wg_player_ended(&s.player, 0));
    free(s.clip);
}

static void loops_without_a_seam(void)
{
    stage s;
    stage_open(&s, WG_END_LOOP, 1);
    for (uint32_t t = 0; t < 10 * RAMP_US; t += 990) {
        wg_player_update(&s.player, t);
        CHECK_EQ(wg_player_time(&s.player, 0), t % RAMP_US);
        check_ramp(&s, t % RAMP_US);
        CHECK(!wg_player_ended(&s.player, 0));
    }
    wg_player_seek(&s.player, 0, 1000);
    wg_player_speed(&s.player, 0, -WG_SPEED_ONE);
    wg_player_update(&s.player, s.player.now_us + 3 * RAMP_US + 1500);
    CHECK_EQ(wg_player_time(&s.player, 0), RAMP_US - 500);
    free(s.clip);
}

static void pingpong_turns_at_both_ends(void)
{
    stage s;
    stage_open(&s, WG_END_PINGPONG, 1);
    for (uint32_t t = 0; t < 10 * RAMP_US; t += 990) {
        uint32_t m = t % (2 * RAMP_US);
        wg_player_update(&s.player, t);
        CHECK_EQ(wg_player_time(&s.player, 0), m > RAMP_US ? 2 * RAMP_US - m : m);
        check_ramp(&s, m > RAMP_US ? 2 * RAMP_US - m : m);
    }
    free(s.clip);
}

/* 80 ticks at 700 Hz last 114285.714 us: after 7 loops the head is 800000 us on, not 7 x 114285. */
static void fractional_durations_do_not_drift(void)
{
    stage s;
    stage_open(&s, WG_END_LOOP, 2);
    for (uint32_t n = 1; n <= 3500; n++) {
        wg_player_update(&s.player, n * 800000u);
    }
    /* D is rounded to 1/65536 us (here down), so 3500 x 7 loops are off by less than 0.19 us. */
    CHECK(s.layers[1].head < 0.19 * 65536);
    free(s.clip);
}

/* ---- speed, pause, end policy ---------------------------------------------------------------- */

static void speeds_scale_time(void)
{
    static const int32_t SPEEDS[] = {32768, 65536, 98304, 1, 6553, -65536, -32768, 0};
    for (unsigned i = 0; i < 8; i++) {
        stage s;
        stage_open(&s, WG_END_HOLD, 1);
        wg_player_seek(&s.player, 0, 50000);
        wg_player_speed(&s.player, 0, SPEEDS[i]);
        wg_player_update(&s.player, 20000);
        double want = 50000 + 20000 * (SPEEDS[i] / 65536.0);
        CHECK_NEAR(wg_player_time(&s.player, 0), want - 0.5, 0.5);
        check_ramp(&s, want);
        free(s.clip);
    }
}

static void survives_the_fastest_ticks(void)
{
    for (uint8_t end = 0; end < 3; end++) {
        stage s;
        stage_open(&s, end, 1);
        uint64_t period = (uint64_t)RAMP_US << 16 << (end == WG_END_PINGPONG);
        wg_player_speed(&s.player, 0, INT32_MAX);
        wg_player_update(&s.player, UINT32_MAX);
        uint64_t step = (uint64_t)UINT32_MAX * INT32_MAX;
        CHECK(s.layers[0].head == (end ? step % period : period));
        wg_player_seek(&s.player, 0, 0);
        wg_player_speed(&s.player, 0, INT32_MIN);
        wg_player_update(&s.player, UINT32_MAX - 1u);
        step = (uint64_t)UINT32_MAX << 31;
        CHECK(s.layers[0].head == (end ? (period - step % period) % period : 0));
        free(s.clip);
    }
}

static void pause_stops_time_but_not_fades(void)
{
    stage s;
    stage_open(&s, WG_END_LOOP, 1);
    wg_player_update(&s.player, 30000);
    wg_player_pause(&s.player, 0, true);
    wg_player_fade(&s.player, 0, 0, 1000);
    wg_player_update(&s.player, 90000);
    CHECK_EQ(wg_player_time(&s.player, 0), 30000);
    CHECK_EQ(value(&s, 0), -5);
    wg_player_fade(&s.player, 0, 32768, 0);
    wg_player_pause(&s.player, 0, false);
    wg_player_update(&s.player, 90010);
    CHECK_EQ(wg_player_time(&s.player, 0), 30010);
    free(s.clip);
}

static void end_policy_change_keeps_the_place(void)
{
    for (uint8_t from = 0; from < 3; from++) {
        for (uint8_t to = 0; to < 3; to++) {
            stage s;
            stage_open(&s, from, 1);
            wg_player_update(&s.player, from == WG_END_PINGPONG ? 160000 : 40000);
            int32_t before = value(&s, 0);
            wg_player_end(&s.player, 0, to);
            CHECK_EQ(value(&s, 0), before);
            CHECK_EQ(wg_player_time(&s.player, 0), 40000);
            wg_player_update(&s.player, s.player.now_us + 70000);
            CHECK_EQ(wg_player_time(&s.player, 0), to == WG_END_HOLD   ? RAMP_US
                                                   : to == WG_END_LOOP ? 10000
                                                                       : 90000);
            free(s.clip);
        }
    }
}

static void seek_clamps_to_the_clip(void)
{
    static const uint32_t WANT[] = {RAMP_US, 0, RAMP_US};
    for (uint8_t end = 0; end < 3; end++) {
        stage s;
        stage_open(&s, end, 1);
        wg_player_seek(&s.player, 0, RAMP_US - 1);
        CHECK_EQ(wg_player_time(&s.player, 0), RAMP_US - 1);
        wg_player_seek(&s.player, 0, RAMP_US);
        CHECK_EQ(wg_player_time(&s.player, 0), WANT[end]);
        wg_player_seek(&s.player, 0, UINT32_MAX);
        CHECK_EQ(wg_player_time(&s.player, 0), WANT[end]);
        free(s.clip);
    }
}

static void play_restarts_at_speed_one_with_the_clips_end(void)
{
    stage s;
    stage_open(&s, WG_END_LOOP, 1);
    wg_player_speed(&s.player, 0, -3);
    wg_player_end(&s.player, 0, WG_END_HOLD);
    wg_player_pause(&s.player, 0, true);
    wg_player_update(&s.player, 70000);
    wg_player_play(&s.player, 0, 0);
    wg_player_update(&s.player, 70000 + RAMP_US + 1000);
    CHECK_EQ(wg_player_time(&s.player, 0), 1000);
    free(s.clip);
}

/* A copy of player and layers continues as the original does, whatever happens to the original. */
static void snapshot_is_a_memcpy(void)
{
    stage s, copy;
    stage_open(&s, WG_END_PINGPONG, 2);
    wg_player_fade(&s.player, 1, 1000, 300000);
    wg_player_speed(&s.player, 0, -45678);
    wg_player_update(&s.player, 123456);
    copy = s;
    copy.player.layers = copy.layers;
    int32_t first[50][2];
    for (uint32_t i = 0; i < 50; i++) {
        wg_player_update(&s.player, 123456 + i * 7919);
        wg_player_sample(&s.player, first[i]);
    }
    wg_player_seek(&s.player, 0, 5);
    for (uint32_t i = 0; i < 50; i++) {
        int32_t again[2];
        wg_player_update(&copy.player, 123456 + i * 7919);
        wg_player_sample(&copy.player, again);
        CHECK(memcmp(first[i], again, sizeof again) == 0);
    }
    free(s.clip);
}

int main(void)
{
    TEST(position_is_exact_floor_and_clamps);
    TEST(channels_without_a_track_rest);
    TEST(any_tick_pattern_gives_the_same_bits);
    TEST(seek_back_equals_fresh_play);
    TEST(clock_wrap_goes_unnoticed);
    TEST(first_update_only_sets_the_clock);
    TEST(holds_at_both_ends);
    TEST(loops_without_a_seam);
    TEST(pingpong_turns_at_both_ends);
    TEST(fractional_durations_do_not_drift);
    TEST(speeds_scale_time);
    TEST(survives_the_fastest_ticks);
    TEST(pause_stops_time_but_not_fades);
    TEST(end_policy_change_keeps_the_place);
    TEST(seek_clamps_to_the_clip);
    TEST(play_restarts_at_speed_one_with_the_clips_end);
    TEST(snapshot_is_a_memcpy);
    return check_done();
}
