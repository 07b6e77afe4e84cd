/* Each kind of run against its closed form in doubles, from the same integer parameters. Tolerances
 * are derived: every operation of SPEC 6 adds its own rounding (see `bounded`).
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "check.h"
#include "clip_samples.h"
#include "wiggly.h"

#define LN2   0.693147180559945309
#define TAU   6.283185307179586477
#define RATE  500u
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

/* ---- one segment in a clip ---------------------------------------------------------------------- */

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

/* ---- arithmetic with bounds ---------------------------------------------------------------------- */

/* An exact number and how far the integer may be from it, both in the integer's own unit. */
typedef struct {
    double exact, error;
} bounded;

static bounded make(double exact, double error)
{
    bounded r = {exact, error};
    return r;
}

static bounded plus(bounded a, bounded b)
{
    return make(a.exact + b.exact, a.error + b.error);
}

/* floor(a b / 2^bits): both errors, and a floor of at most 1. */
static bounded times(bounded a, bounded b, int bits)
{
    double error = fabs(a.exact) * b.error + fabs(b.exact) * a.error + a.error * b.error;
    return make(ldexp(a.exact * b.exact, -bits), ldexp(error, -bits) + 1);
}

static bounded constant(double exact)
{
    return make(exact, 0);
}

/* u as UQ32, and what x = 2 u - 1 in Q30 is short by. 1/h is short by (1 + r)/h of 2^-32, r the rest
 * of its division, the product by 1, and U = u >> 1 by one more. */
static bounded fraction(double dt, uint16_t h)
{
    return make(ldexp(dt / h, 32), 3.0 + 0xffffffffu % h);
}

/* t(x) = 2 floor(U x / 2^32): the floor counts twice. */
static bounded times_u(bounded u, bounded x)
{
    bounded t = times(u, x, 32);
    t.error += 1;
    return t;
}

/* ---- pairs in Q30 ------------------------------------------------------------------------------- */

typedef struct {
    bounded even, odd;
} pair;

/* cosh and sinh about the middle, times 2^-(kappa h / 2): the bits floor by 2^-24 (2^30 LN2 2^-24 <
 * 44.4 at a slope of at most 1), exp2n is good to 2^-23.4 (< 97.1), a half floors by 1/2. */
static pair exp_pair(double dt, uint16_t h, const uint32_t *param, unsigned k)
{
    double lambda = LN2 * param[0] * 0x1p-24, each = 44.4 + 97.1;
    /* scale cosh and sinh (lambda (dt - h/2)) with scale = exp(-lambda h/2), free of overflow */
    double left = exp(-lambda * dt), right = exp(-lambda * (h - dt));
    pair p = {make(0x1p30 * (right + left) / 2, each + 0.5),
              make(ldexp(0x1p30 * (right - left) / 2, (int)k), ldexp(each, (int)k) + 0.5)};
    return p;
}

/* The phase floors by 2^-32 turn (TAU 2^-2 < 1.6), sine and cosine are good to 2^-20.7 (< 631). */
static pair trig_pair(double dt, uint16_t h, const uint32_t *param)
{
    double phase = TAU * 0x1p-32 * param[0] * (dt - h / 2.0);
    pair p = {make(0x1p30 * cos(phase), 632.6), make(0x1p30 * sin(phase), 632.6)};
    return p;
}

static pair unit_pair(double dt, uint16_t h)
{
    pair p = {constant(0x1p30), make(0x1p30 * (2 * dt / h - 1), fraction(dt, h).error / 2 + 0.5)};
    return p;
}

/* A segment of waves and the pairs and derivative pairs at one place in it. */
typedef struct {
    const build_run_data *run;
    uint16_t h;
    double dt;
    pair first, second;
} wave;

static bool has_exp(uint8_t kind)
{
    return kind != WG_KIND_OSC0;
}

static const uint32_t *second_param(const build_run_data *r)
{
    return r->params + (has_exp(r->kind) ? 2 : 0);
}

static wave wave_at(const build_run_data *r, uint16_t h, double dt)
{
    wave w = {r, h, dt, {{0, 0}, {0, 0}}, {{0, 0}, {0, 0}}};
    w.first = has_exp(r->kind) ? exp_pair(dt, h, r->params, r->aux & 15u) : unit_pair(dt, h);
    w.second = r->kind <= WG_KIND_OSC0  ? trig_pair(dt, h, second_param(r))
               : r->kind == WG_KIND_EXP ? exp_pair(dt, h, second_param(r), r->aux >> 4)
                                        : unit_pair(dt, h);
    return w;
}

/* y in Q12 coefficient units of the four coefficients c (SPEC 6.3 step 4). */
static bounded contract(const int16_t *c, uint8_t kind, pair a, pair b)
{
    bounded e0 = times(a.even, constant(c[0]), 16);
    if (kind >= WG_KIND_EXP) {
        bounded s = plus(plus(e0, times(a.odd, constant(c[1]), 16)),
                         plus(times(b.even, constant(c[2]), 16), times(b.odd, constant(c[3]), 16)));
        return make(s.exact / 4, s.error / 4 + 1);
    }
    bounded p = plus(e0, times(a.odd, constant(c[2]), 16));
    bounded q = plus(times(a.even, constant(c[1]), 16), times(a.odd, constant(c[3]), 16));
    return plus(times(p, b.even, 32), times(q, b.odd, 32));
}

/* round(y / 2^(bits - shift)) + base: halves go up, so 1/2 is the most. */
static bounded raw_value(bounded y, const build_run_data *r, int bits)
{
    int down = bits - r->shift;
    return make(r->base + ldexp(y.exact, -down), ldexp(y.error, -down) + 0.5);
}

static bounded wave_value(const wave *w)
{
    return raw_value(contract(w->run->values, w->run->kind, w->first, w->second), w->run, 12);
}

/* ---- derivatives -------------------------------------------------------------------------------- */

/* A pair's derivative over its scale, as the evaluator keeps it (SPEC 6.5): scale rate 2^k. */
typedef struct {
    pair over;
    bounded rate_q16;
    int k;
} slope;

/* The rate is delta or eta to the nearest 2^-16 (an error of 1/2) of the true lambda a second. */
static slope exp_slope(pair p, const uint32_t *param, unsigned k)
{
    slope d = {{make(ldexp(p.odd.exact, -2 * (int)k), ldexp(p.odd.error, -2 * (int)k) + 1), p.even},
               make(65536.0 * RATE * LN2 * 0x1p-24 * param[0], 0.5),
               (int)k};
    return d;
}

static slope trig_slope(pair p, const uint32_t *param)
{
    slope d = {{make(-p.odd.exact, p.odd.error), p.even},
               make(65536.0 * RATE * TAU * 0x1p-32 * param[0], 0.5),
               0};
    return d;
}

/* floor(RATE 2^16 / h) segments a second; x goes through 2 of its units in one. */
static bounded segment_rate(uint16_t h)
{
    return make(65536.0 * RATE / h, 1);
}

static slope unit_slope(uint16_t h)
{
    slope d = {{constant(0), constant(0x1p30)}, segment_rate(h), 1};
    return d;
}

static bounded scaled(bounded y, const slope *d)
{
    bounded v = times(y, d->rate_q16, 16);
    return make(ldexp(v.exact, d->k), ldexp(v.error, d->k));
}

static bounded wave_velocity(const wave *w)
{
    static const pair none = {{0, 0}, {0, 0}};
    const build_run_data *r = w->run;
    bool sum = r->kind >= WG_KIND_EXP;
    slope da = has_exp(r->kind) ? exp_slope(w->first, r->params, r->aux & 15u) : unit_slope(w->h);
    slope db = r->kind <= WG_KIND_OSC0  ? trig_slope(w->second, second_param(r))
               : r->kind == WG_KIND_EXP ? exp_slope(w->second, second_param(r), r->aux >> 4)
                                        : unit_slope(w->h);
    bounded v = plus(scaled(contract(r->values, r->kind, da.over, sum ? none : w->second), &da),
                     scaled(contract(r->values, r->kind, sum ? none : w->first, db.over), &db));
    int down = 12 - r->shift;
    return make(ldexp(v.exact, -down), ldexp(v.error, -down) + 1);
}

/* ---- knots -------------------------------------------------------------------------------------- */

/* The cubic of a segment, Q10: v + u (m + u (b + u a)). */
typedef struct {
    double v, m, b, a;
} cubic;

/* The integers of SPEC 6.3 step 3 are exact up to here: m0, m1 floor as the text says. */
static cubic cubic_of(const build_run_data *r, unsigned index, uint16_t h)
{
    unsigned stride = r->kind == WG_KIND_CUBIC ? 2 : 1;
    const int16_t *left = r->values + index * stride;
    cubic y = {1024.0 * left[0], 0, 0, 0};
    double rise = 1024.0 * left[stride] - y.v;
    if (r->kind == WG_KIND_LINEAR) {
        y.m = rise;
    } else if (r->kind == WG_KIND_CUBIC) {
        double m0 = floor(ldexp((double)left[1] * h, 8 - r->aux));
        double m1 = floor(ldexp((double)left[3] * h, 8 - r->aux));
        y.m = m0;
        y.a = m0 + m1 - 2 * rise;
        y.b = rise - m0 - y.a;
    }
    return y;
}

static bounded knots_value(const build_run_data *r, const cubic *y, bounded u)
{
    bounded t = plus(constant(y->b), times_u(u, constant(y->a)));
    t = plus(constant(y->m), times_u(u, t));
    return raw_value(plus(constant(y->v), times_u(u, t)), r, 10);
}

static bounded knots_velocity(const build_run_data *r, const cubic *y, bounded u, uint16_t h)
{
    bounded t = plus(constant(2 * y->b), times_u(u, constant(3 * y->a)));
    t = times(plus(constant(y->m), times_u(u, t)), segment_rate(h), 16);
    int down = 10 - r->shift;
    return make(ldexp(t.exact, -down), ldexp(t.error, -down) + 1);
}

/* ---- the tests ---------------------------------------------------------------------------------- */

static double
    worst; /* share of the bound that was used: a bound nothing comes near to tests nothing */

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

/* kappa so that a segment decays by up to some bits, or at once; k as large as keeps sinh below 1. */
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

/* ---- search ------------------------------------------------------------------------------------- */

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

/* ---- limits ------------------------------------------------------------------------------------- */

static void values_saturate_at_2_to_29(void)
{
    static const int16_t KNOTS[4] = {32767, 32767, -32768, -32768};
    uint16_t end = 7;
    for (int sign = -1; sign <= 1; sign += 2) {
        opened o;
        build_run_data r = {0, 1, WG_KIND_LINEAR, 9, 0, sign * (1 << 28), &end, NULL, KNOTS};
        r.values = sign > 0 ? KNOTS : KNOTS + 2;
        open_run(&o, &r);
        /* 2^28 + 2^24 does not saturate; a cubic that overshoots does */
        CHECK_EQ(wg_track_value(&o.file, 0, 0), sign * (1 << 28) + r.values[0] * 512);
        free(o.clip);
    }
    /* 2^24 + 2^28 for the bump between two steep knots, on a base of 2^28 */
    static const int16_t STEEP[2][4] = {{32767, 32767, 32767, -32767},
                                        {-32768, -32767, -32768, 32767}};
    end = 65535;
    for (int down = 0; down < 2; down++) {
        opened o;
        build_run_data r = {0,    1,    WG_KIND_CUBIC, 9, 8, down ? -(1 << 28) : 1 << 28,
                            &end, NULL, STEEP[down]};
        open_run(&o, &r);
        CHECK_EQ(wg_track_value(&o.file, 0, 32768u << 16), down ? -(1 << 29) : 1 << 29);
        free(o.clip);
    }
}

static void velocity_saturates(void)
{
    static const int16_t KNOTS[4] = {-32768, 32767, -32768, 32767};
    uint16_t end = 1;
    for (unsigned i = 0; i < 2; i++) {
        opened o;
        build_run_data r = {0, 1, WG_KIND_LINEAR, 9, 0, 0, &end, NULL, KNOTS + i};
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
    TEST(values_saturate_at_2_to_29);
    TEST(velocity_saturates);
    return check_done();
}
