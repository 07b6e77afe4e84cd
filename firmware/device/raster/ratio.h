/* Numbers of any size in 32 bits: a mantissa and a power of two, for the few quantities of a picture
 * whose size nobody knows beforehand. What has a known format uses fix.h.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_RATIO_H
#define WIGGLY_RATIO_H

#include <stdint.h>

/* m / 2^bits, m in 2^30 .. 2^31 - 1. */
typedef struct {
    int32_t m;
    int16_t bits;
} wg_ratio;

/* Results below saturate here. */
#define WG_FAR ((int32_t)1 << 30)

/* Position of the highest 1, counted from 1; 0 for 0. */
uint8_t wg_bits(uint32_t a);

/* |a| of any int32. */
uint32_t wg_magnitude(int32_t a);

/* round(a / 2^bits), halves up, for any bits; 0 above 30. */
int32_t wg_scaled(int32_t a, int16_t bits);

/* floor(sqrt(a)). */
uint16_t wg_root(uint32_t a);

/* `a` itself, 1..2^32 - 1; its lowest bit is lost from 2^31 on. */
wg_ratio wg_ratio_of(uint32_t a);

/* 1/a within 2^-15 of it, from a's 16 upper bits; a in 1..2^32 - 1. */
wg_ratio wg_ratio_inverse(uint32_t a);

/* a b within 2^-28 of it. */
wg_ratio wg_ratio_times(wg_ratio a, wg_ratio b);

/* a r, off by less than 1/2 + 2^(31 - r.bits). */
int32_t wg_ratio_mul(int32_t a, wg_ratio r);

#endif
