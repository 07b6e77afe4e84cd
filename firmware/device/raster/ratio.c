/* A mantissa and a power of two. Source: own.
 * SPDX-License-Identifier: MIT */
#include "ratio.h"

#include "fix.h"

uint8_t wg_bits(uint32_t a)
{
    uint8_t n = 0;
    for (uint8_t step = 16; step > 0; step = (uint8_t)(step >> 1)) { /* 16, 8, 4, 2, 1 */
        if (a >> step) {
            a >>= step;
            n = (uint8_t)(n + step);
        }
    }
    return (uint8_t)(n + a);
}

uint32_t wg_magnitude(int32_t a)
{
    return a < 0 ? 0u - (uint32_t)a : (uint32_t)a;
}

int32_t wg_scaled(int32_t a, int16_t bits)
{
    if (bits > 30) {
        return 0;
    }
    if (bits > 0) {
        return fix_round(a, (unsigned)bits);
    }
    int32_t limit = bits < -30 ? 0 : wg_shr(WG_FAR, (unsigned)-bits);
    if (a > limit || a < -limit) {
        return a > 0 ? WG_FAR : -WG_FAR;
    }
    return bits < -30 ? 0 : fix_shl(a, (unsigned)-bits);
}

uint16_t wg_root(uint32_t a)
{
    uint32_t root = 0;
    for (uint32_t bit = UINT32_C(1) << 30; bit > 0; bit >>= 2) { /* 16 digits */
        if (a >= root + bit) {
            a -= root + bit;
            root = (root >> 1) + bit;
        } else {
            root >>= 1;
        }
    }
    return (uint16_t)root;
}

wg_ratio wg_ratio_of(uint32_t a)
{
    uint8_t n = wg_bits(a);
    wg_ratio r = {(int32_t)(n > 31 ? a >> 1 : a << (31 - n)), (int16_t)(31 - n)};
    return r;
}

wg_ratio wg_ratio_inverse(uint32_t a)
{
    uint8_t n = wg_bits(a);
    unsigned high = (unsigned)(n > 16 ? a >> (n - 16) : a << (16 - n)); /* 2^15 .. 2^16 - 1 */
    /* floor((2^32 - 1) / high) lies in 2^16 + 1 .. 2^17 - 1; 1/a = inverse 2^(-16 - n). */
    wg_ratio r = {(int32_t)(wg_inverse(high) << 14), (int16_t)(30 + n)};
    return r;
}

wg_ratio wg_ratio_times(wg_ratio a, wg_ratio b)
{
    int32_t m = fix_mulh(a.m, b.m); /* 2^28 .. 2^30 - 1 */
    unsigned up = m < (int32_t)1 << 29 ? 2 : 1;
    wg_ratio r = {fix_shl(m, up), (int16_t)(a.bits + b.bits - 32 + (int)up)};
    return r;
}

int32_t wg_ratio_mul(int32_t a, wg_ratio r)
{
    return wg_scaled(fix_mulh(a, r.m), (int16_t)(r.bits - 32));
}
