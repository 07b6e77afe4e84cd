/* The signal evaluator: value and velocity of one track at one position.
 * Source: Schulz 2013, 2.5.1 in the midpoint basis (DESIGN 4); integer form is ours (SPEC 6.3-6.5).
 * SPDX-License-Identifier: MIT */
#include "wiggly.h"
#include "fix.h"
#include "wg_mem.h"

/* Where a position falls: one segment of one run. */
typedef struct {
    const uint8_t *run;
    const uint8_t *data; /* of the run: parameters, then knots or coefficients */
    uint32_t dt_q16;     /* ticks since the segment's start, 0 .. ticks 2^16 */
    uint16_t ticks;      /* the segment's length h >= 1 */
    uint16_t index;      /* in the run */
    uint8_t kind;
    uint8_t aux;
} span;

/* A pair of basis functions in Q30: the even one and the odd one about the segment's middle. */
typedef struct {
    int32_t even, odd;
} pair;

/* The last run that starts at or before `tick`. At most 16 rounds: counts are 16 bits. */
static const uint8_t *find_run(const wg_file *file, const uint8_t *track, uint16_t tick)
{
    const uint8_t *run = file->section[WG_SECTION_RUNS].at +
                         (uint32_t)wg_rd16(track + WG_TRACK_RUN_FIRST) * WG_RUN_BYTES;
    for (uint16_t count = wg_rd16(track + WG_TRACK_RUN_COUNT); count > 1;) {
        uint16_t half = count >> 1;
        const uint8_t *middle = run + (uint32_t)half * WG_RUN_BYTES;
        if (wg_rd16(middle + WG_RUN_START) <= tick) {
            run = middle;
        }
        count = (uint16_t)(count - half);
    }
    return run;
}

/* The first segment that ends after `tick`, else the last one. The number of rounds depends on the
 * count alone, ceil(log2(segments)) <= 16, so a tick costs the same wherever it falls. */
static void find_span(const wg_file *file, uint16_t track, uint32_t position, span *at)
{
    uint16_t tick = (uint16_t)(position >> 16);
    at->run = find_run(file, file->section[WG_SECTION_TRACKS].at + (uint32_t)track * WG_TRACK_BYTES,
                       tick);
    const uint8_t *data = file->section[WG_SECTION_DATA].at;
    const uint8_t *times = data + wg_rd32(at->run + WG_RUN_TIMES);
    const uint8_t *end = times;
    for (uint16_t count = wg_rd16(at->run + WG_RUN_SEGMENTS); count > 1;) {
        uint16_t half = count >> 1;
        const uint8_t *middle = end + (uint32_t)half * 2u;
        if (wg_rd16(middle - 2) <= tick) {
            end = middle;
        }
        count = (uint16_t)(count - half);
    }
    uint16_t start = end == times ? wg_rd16(at->run + WG_RUN_START) : wg_rd16(end - 2);
    at->index = (uint16_t)((uint32_t)(end - times) >> 1);
    at->ticks = (uint16_t)(wg_rd16(end) - start);
    at->dt_q16 = position - ((uint32_t)start << 16);
    at->data = data + wg_rd32(at->run + WG_RUN_DATA);
    at->kind = wg_rd8(at->run + WG_RUN_KIND);
    at->aux = wg_rd8(at->run + WG_RUN_AUX);
}

/* dt / h as UQ32; the quotient of the constant is off by less than h 2^-32 (DESIGN 6). */
static uint32_t fraction_q32(const span *at)
{
    return fix_mulm(at->dt_q16, UINT32_C(0xffffffff) / at->ticks);
}

/* (1, x), x = 2 dt/h - 1. */
static pair unit_pair(const span *at)
{
    pair p = {INT32_C(0x40000000), (int32_t)(fraction_q32(at) >> 1) - INT32_C(0x40000000)};
    return p;
}

/* kappa ticks as UQ8.24, saturated: from 31 on the exponential is 0 anyway. */
static uint32_t decay_q24(uint32_t ticks_q16, uint32_t kappa_q24)
{
    uint64_t bits = (uint64_t)ticks_q16 * kappa_q24;
    return (uint32_t)(bits >> 48) ? UINT32_C(0xffffffff) : (uint32_t)(bits >> 16);
}

/* ((u + v)/2, 2^k (u - v)/2) with u, v decaying from the right and the left end: cosh and sinh of
 * the decay rate, neither of which can overflow however stiff the segment is. */
static pair exp_pair(const span *at, const uint8_t *param, unsigned sinh_shift)
{
    uint32_t kappa = wg_rd32(param + WG_PARAM_RATE);
    int32_t v = fix_exp2n(decay_q24(at->dt_q16, kappa));
    int32_t u = fix_exp2n(decay_q24(((uint32_t)at->ticks << 16) - at->dt_q16, kappa));
    pair p = {(int32_t)(((uint32_t)u + (uint32_t)v) >> 1), fix_shl(u - v, sinh_shift) >> 1};
    return p;
}

/* (cos, sin) of the phase from the segment's middle. The product is at most 2^31 2^31. */
static pair trig_pair(const span *at, const uint8_t *param)
{
    int32_t middle_q16 = (int32_t)(at->dt_q16 - ((uint32_t)at->ticks << 15));
    int64_t turns = (int64_t)middle_q16 * (int32_t)wg_rd32(param + WG_PARAM_RATE);
    pair p;
    fix_sincos((uint32_t)(turns >> 16), &p.odd, &p.even);
    return p;
}

/* Which kind is made of which pairs; the parameters of the first pair come first (SPEC 4.4). */
static bool starts_with_exp(uint8_t kind)
{
    return kind != WG_KIND_OSC0;
}

static pair first_pair(const span *at)
{
    return starts_with_exp(at->kind) ? exp_pair(at, at->data, at->aux & 15u) : unit_pair(at);
}

static const uint8_t *second_param(const span *at)
{
    return at->data + (starts_with_exp(at->kind) ? WG_PARAM_BYTES : 0);
}

static pair second_pair(const span *at)
{
    if (at->kind <= WG_KIND_OSC0) {
        return trig_pair(at, second_param(at));
    }
    return at->kind == WG_KIND_EXP ? exp_pair(at, second_param(at), at->aux >> 4) : unit_pair(at);
}

static const uint8_t *coefficients(const span *at)
{
    uint32_t params = at->kind == WG_KIND_OSC || at->kind == WG_KIND_EXP ? 2u : 1u;
    return at->data + params * WG_PARAM_BYTES + (uint32_t)at->index * 8u;
}

/* The four products of a wave in coefficient units, Q12. Sums wrap; a clip by our baker stays
 * below 2^30. Products are Q14, their products with a second pair Q12. */
static int32_t contract(const uint8_t *c, uint8_t kind, pair a, pair b)
{
    int32_t p0 = fix_mulq(a.even, (int16_t)wg_rd16(c));
    if (kind >= WG_KIND_EXP) {
        int32_t sum = fix_add(p0, fix_mulq(a.odd, (int16_t)wg_rd16(c + 2)));
        sum = fix_add(sum, fix_mulq(b.even, (int16_t)wg_rd16(c + 4)));
        return fix_add(sum, fix_mulq(b.odd, (int16_t)wg_rd16(c + 6))) >> 2;
    }
    int32_t p = fix_add(p0, fix_mulq(a.odd, (int16_t)wg_rd16(c + 4)));
    int32_t q = fix_add(fix_mulq(a.even, (int16_t)wg_rd16(c + 2)),
                        fix_mulq(a.odd, (int16_t)wg_rd16(c + 6)));
    return fix_add(fix_mulh(p, b.even), fix_mulh(q, b.odd));
}

/* The cubic through a segment's two knots as y = v + t (m + t (b + t a)), Q10; LINEAR has m = the
 * difference and no more, HELD nothing at all. */
typedef struct {
    int32_t v, m, b, a;
} cubic;

/* floor(d h 2^(8 - aux)): a knot's velocity over the whole segment. |d h| < 2^31. */
static int32_t knot_slope(const uint8_t *d, const span *at)
{
    int32_t slope = (int16_t)wg_rd16(d) * (int32_t)at->ticks;
    return at->aux < 8 ? fix_shl(slope, 8u - at->aux) : slope >> (at->aux - 8u);
}

static cubic knots(const span *at)
{
    uint32_t stride = at->kind == WG_KIND_CUBIC ? 4u : 2u;
    const uint8_t *left = at->data + (uint32_t)at->index * stride;
    cubic y = {fix_shl((int16_t)wg_rd16(left), 10), 0, 0, 0};
    if (at->kind == WG_KIND_HELD) {
        return y;
    }
    int32_t rise = fix_sub(fix_shl((int16_t)wg_rd16(left + stride), 10), y.v);
    y.m = rise;
    if (at->kind == WG_KIND_CUBIC) {
        int32_t m0 = knot_slope(left + 2, at);
        int32_t m1 = knot_slope(left + 6, at);
        int32_t excess = fix_sub(fix_add(m0, m1), fix_shl(rise, 1));
        y.m = m0;
        y.b = fix_sub(fix_sub(rise, m0), excess);
        y.a = excess;
    }
    return y;
}

/* 2 floor(t c / 2^32) for t = u/2 in Q31: u c with the last bit 0. */
static int32_t times_u(int32_t half_u, int32_t c)
{
    return fix_shl(fix_mulh(half_u, c), 1);
}

static int32_t knots_value(const span *at)
{
    cubic y = knots(at);
    int32_t half_u = (int32_t)(fraction_q32(at) >> 1);
    int32_t t = fix_add(y.b, times_u(half_u, y.a));
    t = fix_add(y.m, times_u(half_u, t));
    return fix_add(y.v, times_u(half_u, t));
}

int32_t wg_track_value(const wg_file *file, uint16_t track, uint32_t position)
{
    span at;
    find_span(file, track, position, &at);
    unsigned shift = wg_rd8(at.run + WG_RUN_SHIFT);
    int32_t y;
    if (at.kind <= WG_KIND_CUBIC) {
        y = fix_round(knots_value(&at), 10u - shift);
    } else {
        y = fix_round(contract(coefficients(&at), at.kind, first_pair(&at), second_pair(&at)),
                      12u - shift);
    }
    y += (int32_t)wg_rd32(at.run + WG_RUN_BASE);
    return fix_clamp(y, -FIX_VALUE_MAX, FIX_VALUE_MAX);
}

/* ---- velocity: the same basis, differentiated --------------------------------------------------
 */

/* One tick's fraction of the segment a second, UQ16.16. */
static uint32_t segments_per_second(const span *at, uint16_t tick_rate)
{
    return ((uint32_t)tick_rate << 16) / at->ticks;
}

static int64_t knots_velocity(const span *at, uint16_t tick_rate)
{
    cubic y = knots(at);
    int32_t half_u = (int32_t)(fraction_q32(at) >> 1);
    int32_t three_a = fix_add(y.a, fix_shl(y.a, 1));
    int32_t slope = fix_add(fix_shl(y.b, 1), times_u(half_u, three_a));
    slope = fix_add(y.m, times_u(half_u, slope));
    return ((int64_t)slope * segments_per_second(at, tick_rate)) >> 16;
}

/* What a pair's derivative is made of: `scale` times (even, odd), scale = rate 2^shift. */
typedef struct {
    pair derivative;
    uint32_t rate_q16; /* 1/s */
    unsigned shift;
} slope;

/* C' = delta S / 2^k and S' = delta 2^k C: both divided by 2^k here. */
static slope exp_slope(pair p, const uint8_t *param, unsigned sinh_shift)
{
    slope d = {{p.odd >> (2u * sinh_shift), p.even}, wg_rd32(param + WG_PARAM_PER_SEC), sinh_shift};
    return d;
}

static slope unit_slope(const span *at, uint16_t tick_rate)
{
    slope d = {{0, INT32_C(0x40000000)}, segments_per_second(at, tick_rate), 1u};
    return d;
}

static slope first_slope(const span *at, pair p, uint16_t tick_rate)
{
    return starts_with_exp(at->kind) ? exp_slope(p, at->data, at->aux & 15u)
                                     : unit_slope(at, tick_rate);
}

static slope second_slope(const span *at, pair p, uint16_t tick_rate)
{
    if (at->kind <= WG_KIND_OSC0) {
        slope d = {{-p.odd, p.even}, wg_rd32(second_param(at) + WG_PARAM_PER_SEC), 0};
        return d;
    }
    return at->kind == WG_KIND_EXP ? exp_slope(p, second_param(at), at->aux >> 4)
                                   : unit_slope(at, tick_rate);
}

static int64_t scaled(int32_t sum, const slope *d)
{
    return (((int64_t)sum * d->rate_q16) >> 16) * ((int64_t)1 << d->shift);
}

static int64_t wave_velocity(const span *at, uint16_t tick_rate)
{
    const pair none = {0, 0};
    const uint8_t *c = coefficients(at);
    pair a = first_pair(at), b = second_pair(at);
    slope da = first_slope(at, a, tick_rate), db = second_slope(at, b, tick_rate);
    bool sum = at->kind >= WG_KIND_EXP;
    int32_t by_first = contract(c, at->kind, da.derivative, sum ? none : b);
    int32_t by_second = contract(c, at->kind, sum ? none : a, db.derivative);
    return scaled(by_first, &da) + scaled(by_second, &db);
}

int32_t wg_track_velocity(const wg_file *file, uint16_t track, uint32_t position,
                          uint16_t tick_rate)
{
    span at;
    find_span(file, track, position, &at);
    unsigned shift = wg_rd8(at.run + WG_RUN_SHIFT);
    bool on_knots = at.kind <= WG_KIND_CUBIC;
    int64_t y = on_knots ? knots_velocity(&at, tick_rate) : wave_velocity(&at, tick_rate);
    y = (y * (1 << shift)) >> (on_knots ? 10 : 12);
    return y < INT32_MIN ? INT32_MIN : y > INT32_MAX ? INT32_MAX : (int32_t)y;
}
