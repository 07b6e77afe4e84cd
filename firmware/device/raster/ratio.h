/* Numbers of any size in 32 bits: a mantissa and a power of two, for the few quantities of a picture
 * whose size nobody knows beforehand. What has a known format uses fix.h.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_RATIO_H
#define WIGGLY_RATIO_H

#include <stdint.h>

/* m / 2^bits, m in 2^30 .. 2^31 - 1. */
typedef struct {
    int32_t m;
    int bits;
} wg_ratio;

/* Results below saturate here. */
#define WG_FAR ((int32_t)1 << 30)

/* Position of the highest 1, counted from 1; 0 for 0. */
int wg_bits(uint32_t a);

/* |a| of any int32. */
uint32_t wg_magnitude(int32_t a);

/* wg_bits of the longest of three. */
int wg_bits_3(const int32_t *a);

/* round(a / 2^bits), halves up, for any bits; 0 above 30. */
int32_t wg_scaled(int32_t a, int bits);

/* floor(sqrt(a)). */
uint16_t wg_root(uint32_t a);

/* r = a, 1 .. 2^31 - 1: exactly. */
void wg_ratio_set(wg_ratio *r, uint32_t a);

/* r = r / a within 2^-14.9 of it, from the 16 upper bits of a; a in 1 .. 2^32 - 1. */
void wg_ratio_divide(wg_ratio *r, uint32_t a);

/* r = r b within 2^-28 of it. */
void wg_ratio_times(wg_ratio *r, const wg_ratio *b);

/* round(a r), off by another 2^(32 - r.bits) at the most: the product is cut to 32 bits. */
int32_t wg_ratio_mul(int32_t a, const wg_ratio *r);

#endif
