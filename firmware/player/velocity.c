/* The velocity of one track at one position: the basis of its value, differentiated.
 * Source: own (SPEC 6.5).
 * SPDX-License-Identifier: MIT */
#include "curve.h"

/* Segments a second, UQ16.16. */
static uint32_t segments_per_second(const wg_span *at, uint16_t tick_rate)
{
    return ((uint32_t)tick_rate << 16) / at->ticks;
}

static int64_t knots_velocity(const wg_span *at, const uint8_t *data, uint16_t tick_rate)
{
    wg_cubic y = wg_knots_at(at, data, wg_rd8(at->run + WG_RUN_KIND));
    int32_t half_u = wg_fraction_q31(at);
    int32_t three_a = fix_add(y.a, fix_shl(y.a, 1));
    int32_t slope = fix_add(fix_shl(y.b, 1), wg_times_u(half_u, three_a));
    slope = fix_add(y.m, wg_times_u(half_u, slope));
    return ((int64_t)slope * segments_per_second(at, tick_rate)) >> 16;
}

/* A pair's derivative: rate 2^shift times `pair`. */
typedef struct {
    wg_pair pair;
    uint32_t rate_q16; /* 1/s */
    unsigned shift;
} derivative;

/* C' = delta S / 2^k and S' = delta 2^k C: both divided by 2^k here. */
static derivative exp_derivative(wg_pair p, const uint8_t *param, unsigned sinh_shift)
{
    derivative d = {
        {p.odd >> (2u * sinh_shift), p.even}, wg_rd32(param + WG_PARAM_PER_SEC), sinh_shift};
    return d;
}

static derivative unit_derivative(const wg_span *at, uint16_t tick_rate)
{
    derivative d = {{0, INT32_C(0x40000000)}, segments_per_second(at, tick_rate), 1u};
    return d;
}

static derivative trig_derivative(wg_pair p, const uint8_t *param)
{
    derivative d = {{-p.odd, p.even}, wg_rd32(param + WG_PARAM_PER_SEC), 0};
    return d;
}

static int64_t scaled(int32_t sum, const derivative *d)
{
    return (((int64_t)sum * d->rate_q16) >> 16) * ((int64_t)1 << d->shift);
}

/* Both product rules; in a sum, the pair that is not differentiated counts as nothing. */
static int64_t wave_velocity(const wg_span *at, const uint8_t *data, uint16_t tick_rate)
{
    uint8_t kind = wg_rd8(at->run + WG_RUN_KIND);
    unsigned aux = wg_rd8(at->run + WG_RUN_AUX);
    bool first_exp = kind != WG_KIND_OSC0, trig = kind <= WG_KIND_OSC0, sum = kind >= WG_KIND_EXP;
    const uint8_t *next = first_exp ? data + WG_PARAM_BYTES : data;
    wg_pair a = first_exp ? wg_exp_pair(at, data, aux & 15u) : wg_unit_pair(at);
    wg_pair b = trig                  ? wg_trig_pair(at, next)
                : kind == WG_KIND_EXP ? wg_exp_pair(at, next, aux >> 4)
                                      : wg_unit_pair(at);
    derivative da = first_exp ? exp_derivative(a, data, aux & 15u) : unit_derivative(at, tick_rate);
    derivative db = trig                  ? trig_derivative(b, next)
                    : kind == WG_KIND_EXP ? exp_derivative(b, next, aux >> 4)
                                          : unit_derivative(at, tick_rate);
    const uint8_t *c =
        wg_coefficients(at, data, kind == WG_KIND_OSC || kind == WG_KIND_EXP ? 2 : 1);
    const wg_pair none = {0, 0};
    int32_t by_a = sum ? wg_sum(c, da.pair, none) : wg_product(c, da.pair, b);
    int32_t by_b = sum ? wg_sum(c, none, db.pair) : wg_product(c, a, db.pair);
    return scaled(by_a, &da) + scaled(by_b, &db);
}

int32_t wg_track_velocity(const wg_file *file, uint16_t track, uint32_t position,
                          uint16_t tick_rate)
{
    wg_span at = wg_find_span(file, track, position);
    unsigned shift = wg_rd8(at.run + WG_RUN_SHIFT);
    const uint8_t *data = file->section[WG_SECTION_DATA].at + wg_rd32(at.run + WG_RUN_DATA);
    bool on_knots = wg_rd8(at.run + WG_RUN_KIND) <= WG_KIND_CUBIC;
    int64_t y =
        on_knots ? knots_velocity(&at, data, tick_rate) : wave_velocity(&at, data, tick_rate);
    y = (y * (1 << shift)) >> (on_knots ? 10 : 12);
    return y < INT32_MIN ? INT32_MIN : y > INT32_MAX ? INT32_MAX : (int32_t)y;
}
