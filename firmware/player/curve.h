/* Parts of the evaluator that value and velocity share.
 * Source: Schulz 2013, 2.5.1 in the midpoint basis (DESIGN 4); integer form is ours (SPEC 6.3).
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_CURVE_H
#define WIGGLY_CURVE_H

#include "clip.h"
#include "fix.h"

/* Where a position falls: one segment of one run. */
typedef struct {
    const uint8_t *run;
    uint32_t dt_q16; /* ticks since the segment's start, 0 .. ticks 2^16 */
    unsigned ticks;  /* the segment's length h, 1..65535 */
    unsigned index;  /* in the run */
} wg_span;

/* The last run that starts at or before `tick`. At most 16 rounds: counts are 16 bits. Where
 * `unsigned` has 16 bits so has a pointer, and no offset in an open clip wraps. */
static inline const uint8_t *wg_find_run(const wg_file *file, const uint8_t *track, unsigned tick)
{
    const uint8_t *run =
        wg_record(file, WG_SECTION_RUNS, wg_rd16(track + WG_TRACK_RUN_FIRST), WG_RUN_BYTES);
    for (unsigned count = wg_rd16(track + WG_TRACK_RUN_COUNT); count > 1;) {
        unsigned half = count >> 1;
        const uint8_t *middle = run + half * WG_RUN_BYTES;
        run = wg_rd16(middle + WG_RUN_START) <= tick ? middle : run;
        count -= half;
    }
    return run;
}

/* The first segment that ends after the position's tick, else the last one. The number of rounds
 * depends on the count alone, ceil(log2(segments)) <= 16, so a tick costs the same wherever it
 * falls. */
static inline wg_span wg_find_span(const wg_file *file, uint16_t track, uint32_t position)
{
    unsigned tick = (uint16_t)(position >> 16);
    wg_span at;
    at.run = wg_find_run(file, wg_record(file, WG_SECTION_TRACKS, track, WG_TRACK_BYTES), tick);
    const uint8_t *times = file->section[WG_SECTION_DATA].at + wg_rd32(at.run + WG_RUN_TIMES);
    const uint8_t *passed =
        times - 2; /* the last end known to have passed; none yet: still in the file */
    unsigned count = wg_rd16(at.run + WG_RUN_SEGMENTS);
    for (unsigned half = count >> 1; half > 0; half = count >> 1) {
        const uint8_t *middle = passed + 2u * half;
        passed = wg_rd16(middle) <= tick ? middle : passed;
        count -= half;
    }
    unsigned start = wg_rd16(passed < times ? at.run + WG_RUN_START : passed);
    /* unsigned first: ptrdiff_t has 16 bits on AVR */
    at.index = (unsigned)(passed + 2 - times) >> 1;
    at.ticks = wg_rd16(passed + 2) - start;
    at.dt_q16 = position - ((uint32_t)start << 16);
    return at;
}

/* dt / h as Q31, in [0, 1); the quotient of the constant is off by less than h 2^-32 (DESIGN 6). */
static inline int32_t wg_fraction_q31(const wg_span *at)
{
    return wg_mul17(at->dt_q16, wg_inverse(at->ticks));
}

/* ---- waves ----------------------------------------------------------------------------------- */

/* A pair of basis functions in Q30: the even one and the odd one about the segment's middle. */
typedef struct {
    int32_t even, odd;
} wg_pair;

/* (1, x), x = 2 dt/h - 1. */
static inline wg_pair wg_unit_pair(const wg_span *at)
{
    wg_pair p = {INT32_C(0x40000000), wg_fraction_q31(at) - INT32_C(0x40000000)};
    return p;
}

/* 2^-(kappa ticks), Q30; 0 from 31 on, so that 32 and more need no exponential. */
static inline int32_t wg_decay(uint32_t ticks_q16, uint32_t kappa_q24)
{
    uint32_t bits = wg_mul29(ticks_q16, kappa_q24);
    return bits < UINT32_C(1) << 29 ? fix_exp2n(bits) : 0;
}

/* ((u + v)/2, 2^k (u - v)/2) with u, v decaying from the right and the left end: cosh and sinh of
 * the decay rate, neither of which can overflow however stiff the segment is. */
static inline wg_pair wg_exp_pair(const wg_span *at, const uint8_t *param, unsigned sinh_shift)
{
    uint32_t kappa = wg_rd32(param + WG_PARAM_RATE);
    int32_t v = wg_decay(at->dt_q16, kappa);
    int32_t u = wg_decay(((uint32_t)at->ticks << 16) - at->dt_q16, kappa);
    wg_pair p = {(u + v) >> 1, fix_shl(u - v, sinh_shift) >> 1};
    return p;
}

/* (cos, sin) of the phase from the segment's middle. The product is at most 2^31 2^31. */
static inline wg_pair wg_trig_pair(const wg_span *at, const uint8_t *param)
{
    int32_t middle_q16 = (int32_t)(at->dt_q16 - ((uint32_t)at->ticks << 15));
    fix_turn t = fix_sincos(wg_mulsm(middle_q16, (int32_t)wg_rd32(param + WG_PARAM_RATE)));
    wg_pair p = {t.cosine, t.sine};
    return p;
}

/* Coefficients of a segment, behind `params` parameters of the run. */
static inline const uint8_t *wg_coefficients(const wg_span *at, const uint8_t *data,
                                             unsigned params)
{
    return data + params * WG_PARAM_BYTES + at->index * 8u;
}

/* Waves in coefficient units, Q12. Sums wrap; a clip by our baker stays below 2^30. */
static inline int32_t wg_product(const uint8_t *c, wg_pair a, wg_pair b)
{
    int32_t p = fix_add(fix_mulq(a.even, (int16_t)wg_rd16(c)), /* Q14 */
                        fix_mulq(a.odd, (int16_t)wg_rd16(c + 4)));
    int32_t q = fix_add(fix_mulq(a.even, (int16_t)wg_rd16(c + 2)),
                        fix_mulq(a.odd, (int16_t)wg_rd16(c + 6)));
    return fix_add(fix_mulh(p, b.even), fix_mulh(q, b.odd));
}

static inline int32_t wg_sum(const uint8_t *c, wg_pair a, wg_pair b)
{
    int32_t p =
        fix_add(fix_mulq(a.even, (int16_t)wg_rd16(c)), fix_mulq(a.odd, (int16_t)wg_rd16(c + 2)));
    int32_t q = fix_add(fix_mulq(b.even, (int16_t)wg_rd16(c + 4)),
                        fix_mulq(b.odd, (int16_t)wg_rd16(c + 6)));
    return fix_add(p, q) >> 2;
}

/* ---- knots ----------------------------------------------------------------------------------- */

/* The cubic through a segment's two knots as y = v + t (m + t (b + t a)), Q10; LINEAR has m = the
 * difference and no more, HELD nothing at all. */
typedef struct {
    int32_t v, m, b, a;
} wg_cubic;

/* floor(d h 2^(8 - aux)): a knot's velocity over the whole segment. |d h| < 2^31. */
static inline int32_t wg_knot_slope(const uint8_t *d, unsigned ticks, unsigned aux)
{
    int32_t slope = (int16_t)wg_rd16(d) * (int32_t)ticks;
    return aux < 8 ? fix_shl(slope, 8u - aux) : slope >> (aux - 8u);
}

static inline wg_cubic wg_knots_at(const wg_span *at, const uint8_t *data, uint8_t kind)
{
    unsigned stride = kind == WG_KIND_CUBIC ? 4u : 2u;
    const uint8_t *left = data + at->index * stride;
    wg_cubic y = {fix_shl((int16_t)wg_rd16(left), 10), 0, 0, 0};
    if (kind == WG_KIND_HELD) {
        return y;
    }
    int32_t rise = fix_sub(fix_shl((int16_t)wg_rd16(left + stride), 10), y.v);
    y.m = rise;
    if (kind == WG_KIND_CUBIC) {
        unsigned aux = wg_rd8(at->run + WG_RUN_AUX);
        int32_t m0 = wg_knot_slope(left + 2, at->ticks, aux);
        int32_t m1 = wg_knot_slope(left + 6, at->ticks, aux);
        int32_t excess = fix_sub(fix_add(m0, m1), fix_shl(rise, 1));
        y.m = m0;
        y.b = fix_sub(fix_sub(rise, m0), excess);
        y.a = excess;
    }
    return y;
}

/* 2 floor(t c / 2^32) for t = u/2 in Q31: u c with the last bit 0. */
static inline int32_t wg_times_u(int32_t half_u, int32_t c)
{
    return fix_shl(fix_mulh(half_u, c), 1);
}

#endif
