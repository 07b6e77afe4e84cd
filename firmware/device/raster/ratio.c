/* A mantissa and a power of two. Source: own.
 * SPDX-License-Identifier: MIT */
#include "ratio.h"

#include "fix.h"

int wg_bits(uint32_t a)
{
    int n = 0;
    for (int step = 16; step > 0; step >>= 1) { /* 16, 8, 4, 2, 1 */
        if (a >> step) {
            a >>= step;
            n += step;
        }
    }
    return n + (int)a;
}

uint32_t wg_magnitude(int32_t a)
{
    return a < 0 ? 0u - (uint32_t)a : (uint32_t)a;
}

int wg_bits_3(const int32_t *a)
{
    return wg_bits(wg_magnitude(a[0]) | wg_magnitude(a[1]) | wg_magnitude(a[2]));
}

int32_t wg_scaled(int32_t a, int bits)
{
    if (bits > 0) {
        return bits > 30 ? 0 : fix_round(a, (unsigned)bits);
    }
    unsigned up = bits < -30 ? 31 : (unsigned)-bits;
    int32_t limit = wg_shr(WG_FAR, up);
    if (a > limit || a < -limit) {
        return a > 0 ? WG_FAR : -WG_FAR;
    }
    return fix_shl(a, up);
}

uint16_t wg_root(uint32_t a)
{
    uint32_t root = 0;
    for (uint32_t bit = UINT32_C(1) << 30; bit > 0; bit >>= 2) { /* 16 digits */
        uint32_t digit = root + bit;
        root >>= 1;
        if (a >= digit) {
            a -= digit;
            root += bit;
        }
    }
    return (uint16_t)root;
}

void wg_ratio_set(wg_ratio *r, uint32_t a)
{
    int up = 31 - wg_bits(a);
    r->m = (int32_t)(a << up);
    r->bits = up;
}

void wg_ratio_times(wg_ratio *r, const wg_ratio *b)
{
    int32_t m = fix_mulh(r->m, b->m); /* 2^28 .. 2^30 - 1 */
    int up = m < (int32_t)1 << 29 ? 2 : 1;
    r->m = fix_shl(m, (unsigned)up);
    r->bits += b->bits - 32 + up;
}

void wg_ratio_divide(wg_ratio *r, uint32_t a)
{
    int n = wg_bits(a);
    unsigned high = (unsigned)(n > 16 ? a >> (n - 16) : a << (16 - n)); /* 2^15 .. 2^16 - 1 */
    /* floor((2^32 - 1) / high) lies in 2^16 + 1 .. 2^17 - 1; 1/a = inverse 2^(-16 - n). */
    const wg_ratio inverse = {(int32_t)(wg_inverse(high) << 14), 30 + n};
    wg_ratio_times(r, &inverse);
}

int32_t wg_ratio_mul(int32_t a, const wg_ratio *r)
{
    return wg_scaled(fix_mulh(a, r->m), r->bits - 32);
}
