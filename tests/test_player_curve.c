/* Each kind of run against its closed form in doubles, from the same integer parameters. Tolerances
 * are derived in curve_model.h; the share of them that is used is checked too.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "clip_samples.h"
#include "curve_model.h"
#include "wiggly.h"

#define TRIES 4000

static uint32_t seed = 5;

static uint32_t rnd(uint32_t below)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)seed * below) >> 32);
}

static int16_t rnd16(void)
{
    return (int16_t)((int32_t)rnd(65536) - 32768);
}

/* ---- one segment in a clip ------------------------------------------------------------------- */

typedef struct {
    uint8_t *clip;
    wg_file file;
} opened;

static void open_run(opened *o, const build_run_data *r)
{
    uint32_t size;
    build b = {{{0}}, 0};
    build_channel(&b, 0, 0, 0);
    build_clip(&b, RATE, r->ends[r->segments - 1u], WG_END_HOLD);
    build_track(&b, 0);
    build_run(&b, r);
    o->clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&o->file, o->clip, size), 0);
}

/* ---- the tests ------------------------------------------------------------------------------- */

/* Share of the bound that was used: a bound that nothing comes near to tests nothing. */
static double worst;

static double clamp(double a, double low, double high)
{
    return a < low ? low : a > high ? high : a;
}

/* Saturation brings two numbers no further apart. */
static void check_bounded(double got, bounded want, double low, double high)
{
    want.exact = clamp(want.exact, low, high);
    double share = fabs(got - want.exact) / want.error;
    worst = share > worst ? share : worst;
    CHECK_NEAR(got, want.exact, want.error);
}

static void check_both(const opened *o, uint32_t position, bounded value, bounded velocity)
{
    check_bounded(wg_track_value(&o->file, 0, position), value, -0x1p29, 0x1p29);
    check_bounded(wg_track_velocity(&o->file, 0, position, RATE), velocity, -0x1p31, 0x1p31 - 1);
}

static void check_knots(const opened *o, const build_run_data *r, uint16_t h, uint32_t position)
{
    cubic y = cubic_of(r, 0, h);
    bounded u = fraction(position / 65536.0, h);
    check_both(o, position, knots_value(r, &y, u), knots_velocity(r, &y, u, h));
}

static void check_wave(const opened *o, const build_run_data *r, uint16_t h, uint32_t position)
{
    wave w = wave_at(r, h, position / 65536.0);
    check_both(o, position, wave_value(&w), wave_velocity(&w));
}

/* Both ends, the ticks next to them, the middle and random places. */
static void check_segment(const build_run_data *r, uint16_t h)
{
    opened o;
    uint32_t end = (uint32_t)h << 16;
    uint32_t at[9] = {0, 1, 0x10000, end / 2, end - 0x10000, end - 1, end, 0, 0};
    at[7] = rnd(end);
    at[8] = rnd(end);
    open_run(&o, r);
    for (unsigned i = 0; i < 9; i++) {
        (r->kind <= WG_KIND_CUBIC ? check_knots : check_wave)(&o, r, h, at[i]);
    }
    free(o.clip);
}

static uint16_t some_length(void)
{
    static const uint16_t FIXED[] = {1, 2, 3, 255, 32768, 65533, 65534, 65535};
    return rnd(3) ? (uint16_t)(1u + rnd(400)) : FIXED[rnd(8)];
}

static int16_t values[8];

static build_run_data some_run(uint8_t kind, uint16_t *end)
{
    build_run_data r = {0, 1, kind, 0, 0, 0, end, NULL, values};
    *end = some_length();
    r.shift = (uint8_t)rnd(WG_RUN_SHIFT_MAX + 1u);
    r.base = (int32_t)rnd(2000000) - 1000000;
    for (unsigned i = 0; i < 8; i++) {
        values[i] = rnd16();
    }
    return r;
}

static void check_knot_kind(uint8_t kind, double share)
{
    uint16_t end;
    worst = 0;
    for (unsigned i = 0; i < TRIES; i++) {
        build_run_data r = some_run(kind, &end);
        if (kind == WG_KIND_CUBIC) {
            /* m = d h 2^(8 - aux) below 2^26, as large as values are, so that no sum wraps */
            double most = ldexp(32768.0 * end, 8 - 26);
            for (r.aux = 0; ldexp(1, r.aux) < most; r.aux++) {
            }
        }
        check_segment(&r, end);
    }
    CHECK(share > 0 ? worst > share : worst <= 0);
}

static void held_keeps_its_value(void)
{
    check_knot_kind(WG_KIND_HELD, 0);
}

static void linear_matches_a_line(void)
{
    check_knot_kind(WG_KIND_LINEAR, 0.2);
}

static void cubic_matches_hermite(void)
{
    check_knot_kind(WG_KIND_CUBIC, 0.2);
}

/* kappa so that a segment decays by up to some bits, or at once; k as large as keeps sinh < 1. */
static unsigned some_decay(uint32_t *param, uint16_t h)
{
    double bits = rnd(8) ? ldexp(1 + rnd(1000), -(int)rnd(18)) : 4000000.0;
    double kappa = bits / h * 0x1p24;
    param[0] = kappa < 4294967295.0 ? (uint32_t)kappa : 4294967295u;
    param[1] = (uint32_t)fmin(RATE * LN2 * 0x1p-24 * param[0] * 65536 + 0.5, 4294967295.0);
    unsigned k = 0;
    while (k < WG_RUN_SINH_SHIFT_MAX &&
           ldexp(1 - exp2(-0x1p-24 * param[0] * h), (int)k + 1) < 0.99) {
        k++;
    }
    return k;
}

static void some_turn(uint32_t *param)
{
    param[0] = rnd(2) ? rnd(1u << 31) : rnd(1u << 24);
    param[1] = (uint32_t)(RATE * TAU * 0x1p-32 * param[0] * 65536 + 0.5);
}

static void check_wave_kind(uint8_t kind)
{
    uint16_t end;
    uint32_t params[4];
    worst = 0;
    for (unsigned i = 0; i < TRIES; i++) {
        build_run_data r = some_run(kind, &end);
        r.params = params;
        unsigned k = 0, k2 = 0;
        if (has_exp(kind)) {
            k = some_decay(params, end);
        }
        if (kind <= WG_KIND_OSC0) {
            some_turn(params + (kind == WG_KIND_OSC ? 2 : 0));
        } else if (kind == WG_KIND_EXP) {
            k2 = some_decay(params + 2, end);
        }
        /* delta above 2^16 does not fit its word: such a decay has no velocity to compare */
        if (has_exp(kind) &&
            (params[1] == UINT32_MAX || params[3 * (kind == WG_KIND_EXP)] == UINT32_MAX)) {
            continue;
        }
        r.aux = (uint8_t)(k | k2 << 4);
        check_segment(&r, end);
    }
    CHECK(worst > 0.2);
}

static void osc_matches_cosh_times_cos(void)
{
    check_wave_kind(WG_KIND_OSC);
}

static void osc0_matches_line_times_cos(void)
{
    check_wave_kind(WG_KIND_OSC0);
}

static void crit_matches_cosh_times_line(void)
{
    check_wave_kind(WG_KIND_CRIT);
}

static void exp_matches_two_hyperbolas(void)
{
    check_wave_kind(WG_KIND_EXP);
}

static void exp0_matches_hyperbola_and_line(void)
{
    check_wave_kind(WG_KIND_EXP0);
}

/* ---- search ---------------------------------------------------------------------------------- */

static uint16_t ends[65535];
static int16_t numbers[65536];

/* `segments` HELD segments of value = index in `runs` runs, random lengths. */
static void open_search(opened *o, uint16_t segments, uint16_t runs, uint16_t longest)
{
    uint32_t size, end = 0;
    build b = {{{0}}, 0};
    for (uint32_t i = 0; i < segments; i++) {
        end += 1u + (longest > 1 ? rnd(longest) : 0);
        ends[i] = (uint16_t)end;
        numbers[i] = (int16_t)i;
    }
    build_channel(&b, 0, 0, 0);
    build_clip(&b, RATE, (uint16_t)end, WG_END_HOLD);
    build_track(&b, 0);
    for (uint32_t i = 0, first = 0; i < runs; i++) {
        uint32_t next =
            i + 1u == runs ? segments : first + 1u + rnd((segments - first) - (runs - i - 1u));
        build_run_data r = {(uint16_t)(first ? ends[first - 1] : 0),
                            (uint16_t)(next - first),
                            WG_KIND_HELD,
                            0,
                            0,
                            0,
                            ends + first,
                            NULL,
                            numbers + first};
        build_run(&b, &r);
        first = next;
    }
    o->clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&o->file, o->clip, size), 0);
}

static void search_equals_a_linear_scan(void)
{
    for (uint16_t segments = 1; segments <= 300; segments++) {
        opened o;
        uint16_t runs = (uint16_t)(1u + rnd(segments < 20 ? segments : 20u));
        open_search(&o, segments, runs, 9);
        uint32_t index = 0;
        for (uint32_t tick = 0; tick <= ends[segments - 1u]; tick++) {
            index += index + 1u < segments && ends[index] <= tick;
            CHECK_EQ(wg_track_value(&o.file, 0, tick << 16), (int32_t)index);
            if (tick > 0) {
                uint32_t before = index - (index > 0 && ends[index - 1u] == tick);
                CHECK_EQ(wg_track_value(&o.file, 0, (tick << 16) - 1u), (int32_t)before);
            }
        }
        free(o.clip);
    }
}

static void searches_the_most_segments_and_runs(void)
{
    static const uint16_t RUNS[] = {1, 2, 300, 32768, 65535};
    for (unsigned i = 0; i < 5; i++) {
        opened o;
        open_search(&o, 65535, RUNS[i], 1);
        for (uint32_t tick = 0; tick < 65535; tick++) {
            CHECK_EQ(wg_track_value(&o.file, 0, tick << 16 | 0x8000u), (int16_t)tick);
        }
        CHECK_EQ(wg_track_value(&o.file, 0, 0xffff0000u), (int16_t)65534);
        free(o.clip);
    }
}

/* ---- limits ---------------------------------------------------------------------------------- */

/* No check of coefficients is needed: shift <= 7 leaves at most 2^31 2^-3 beside the base. */
static void values_stay_within_2_to_29(void)
{
    static const int16_t TOP[2] = {32767, 32767};
    uint16_t end;
    uint32_t params[4];
    for (unsigned i = 0; i < TRIES; i++) {
        opened o;
        build_run_data r = some_run((uint8_t)rnd(WG_KIND_COUNT), &end);
        for (unsigned k = 0; k < 4; k++) {
            params[k] = rnd(1u << 31);
        }
        r.params = params;
        r.shift = WG_RUN_SHIFT_MAX;
        r.base = rnd(2) ? 1 << 28 : -(1 << 28);
        r.aux = r.kind == WG_KIND_CUBIC ? (uint8_t)rnd(25) : 0;
        open_run(&o, &r);
        int32_t value = wg_track_value(&o.file, 0, rnd((uint32_t)end << 16));
        CHECK(value >= -(1 << 29) && value <= 1 << 29);
        free(o.clip);
    }
    opened o;
    build_run_data r = {0, 1, WG_KIND_LINEAR, WG_RUN_SHIFT_MAX, 0, 1 << 28, &end, NULL, TOP};
    open_run(&o, &r);
    CHECK_EQ(wg_track_value(&o.file, 0, 0), (1 << 28) + 32767 * 128);
    free(o.clip);
}

static void velocity_saturates(void)
{
    static const int16_t KNOTS[4] = {-32768, 32767, -32768, 32767};
    uint16_t end = 1;
    for (unsigned i = 0; i < 2; i++) {
        opened o;
        build_run_data r = {0, 1, WG_KIND_LINEAR, 7, 0, 0, &end, NULL, KNOTS + i};
        open_run(&o, &r);
        CHECK_EQ(wg_track_velocity(&o.file, 0, 0x8000, 65535), i ? INT32_MIN : INT32_MAX);
        free(o.clip);
    }
}

int main(void)
{
    TEST(held_keeps_its_value);
    TEST(linear_matches_a_line);
    TEST(cubic_matches_hermite);
    TEST(osc_matches_cosh_times_cos);
    TEST(osc0_matches_line_times_cos);
    TEST(crit_matches_cosh_times_line);
    TEST(exp_matches_two_hyperbolas);
    TEST(exp0_matches_hyperbola_and_line);
    TEST(search_equals_a_linear_scan);
    TEST(searches_the_most_segments_and_runs);
    TEST(values_stay_within_2_to_29);
    TEST(velocity_saturates);
    return check_done();
}
