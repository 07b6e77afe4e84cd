/* The value of one track at one position.
 * Source: Schulz 2013, 2.5.1 in the midpoint basis (DESIGN 4); integer form is ours (SPEC 6.3).
 * SPDX-License-Identifier: MIT */
#include "curve.h"

static int32_t knots_value(const wg_span *at, const uint8_t *data, uint8_t kind)
{
    wg_cubic y = wg_knots_at(at, data, kind);
    int32_t half_u = wg_fraction_q31(at);
    int32_t t = fix_add(y.b, wg_times_u(half_u, y.a));
    t = fix_add(y.m, wg_times_u(half_u, t));
    return fix_add(y.v, wg_times_u(half_u, t));
}

/* What each kind is made of (SPEC 6.3, step 4); the parameters of the first pair come first.
 * Blocks, so that the cases share their stack. */
static int32_t wave_value(const wg_span *at, const uint8_t *data, uint8_t kind)
{
    unsigned aux = wg_rd8(at->run + WG_RUN_AUX);
    const uint8_t *next = data + WG_PARAM_BYTES;
    switch (kind) {
    case WG_KIND_OSC: {
        wg_pair a = wg_exp_pair(at, data, aux), b = wg_trig_pair(at, next);
        return wg_product(wg_coefficients(at, data, 2), a, b);
    }
    case WG_KIND_OSC0: {
        wg_pair a = wg_unit_pair(at), b = wg_trig_pair(at, data);
        return wg_product(wg_coefficients(at, data, 1), a, b);
    }
    case WG_KIND_CRIT: {
        wg_pair a = wg_exp_pair(at, data, aux), b = wg_unit_pair(at);
        return wg_product(wg_coefficients(at, data, 1), a, b);
    }
    case WG_KIND_EXP: {
        wg_pair a = wg_exp_pair(at, data, aux & 15u), b = wg_exp_pair(at, next, aux >> 4);
        return wg_sum(wg_coefficients(at, data, 2), a, b);
    }
    default: { /* WG_KIND_EXP0 */
        wg_pair a = wg_exp_pair(at, data, aux), b = wg_unit_pair(at);
        return wg_sum(wg_coefficients(at, data, 1), a, b);
    }
    }
}

int32_t wg_track_value(const wg_file *file, uint16_t track, uint32_t position)
{
    wg_span at = wg_find_span(file, track, position);
    uint8_t kind = wg_rd8(at.run + WG_RUN_KIND);
    unsigned shift = wg_rd8(at.run + WG_RUN_SHIFT);
    const uint8_t *data = file->section[WG_SECTION_DATA].at + wg_rd32(at.run + WG_RUN_DATA);
    int32_t y = kind <= WG_KIND_CUBIC ? fix_round(knots_value(&at, data, kind), 10u - shift)
                                      : fix_round(wave_value(&at, data, kind), 12u - shift);
    return y + (int32_t)wg_rd32(at.run + WG_RUN_BASE); /* 2^28 each: shift is 7 at the most */
}
