/* The only fixed-point arithmetic of the player and the device code: one definition an operation.
 * Source: own; the polynomials are minimax fits, regenerated and checked by
 * tests/reference/fix_oracle.py. Every operation is exact integer arithmetic with the stated
 * rounding, so the bits are the same on every target; sums that may leave int32 on a hostile clip
 * wrap through uint32 and are never undefined.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_FIX_H
#define WIGGLY_FIX_H

#include <stdint.h>

#include "wg_mem.h"
#include "wg_mul.h"

#define WG_STATIC_ASSERT_2(cond, line) extern const char wg_assert_##line[(cond) ? 1 : -1]
#define WG_STATIC_ASSERT_1(cond, line) WG_STATIC_ASSERT_2(cond, line)
#define WG_STATIC_ASSERT(cond)         WG_STATIC_ASSERT_1(cond, __LINE__)

/* What C99 leaves open and this file relies on; every compiler we build with agrees. */
WG_STATIC_ASSERT((-1 >> 1) == -1);
WG_STATIC_ASSERT((int32_t)0x80000000u == -0x7fffffff - 1);

/* Channel values saturate here (SPEC 6.1): sums of two still fit in int32. */
#define FIX_VALUE_MAX ((int32_t)1 << 29)

/* floor(a b / 2^32); |result| <= 2^30. */
static inline int32_t fix_mulh(int32_t a, int32_t b)
{
    return wg_mulh(a, b);
}

/* floor(a b / 2^16): the same bits as fix_mulh(a, b * 65536). */
static inline int32_t fix_mulq(int32_t a, int16_t b)
{
    return wg_mulq(a, b);
}

/* floor(a w / 2^15) for a weight w in 0..32768; w = 32768 gives a itself. */
static inline int32_t fix_weigh(int32_t a, uint16_t w)
{
    return wg_weigh(a, w);
}

/* floor(a w / 2^10) for a weight w in 0..256, in parts of 256: the same bits as fix_weigh(a, 32 w). */
static inline int32_t fix_share(int32_t a, uint16_t w)
{
    return wg_share(a, w);
}

/* a + b and a - b modulo 2^32: defined for every pair. */
static inline int32_t fix_add(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}

static inline int32_t fix_sub(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}

/* floor(v rate / 2^16) modulo 2^32 for rate in 0 .. 2^31 - 1: the phase of a channel's value. */
static inline uint32_t fix_phase(int32_t v, uint32_t rate)
{
    return wg_mulsm(v, (int32_t)rate);
}

/* a 2^bits modulo 2^32; bits in 0..31. */
static inline int32_t fix_shl(int32_t a, unsigned bits)
{
    return (int32_t)((uint32_t)a << bits);
}

/* round(a / 2^bits), halves up; bits in 1..30. */
static inline int32_t fix_round(int32_t a, unsigned bits)
{
    return fix_add(wg_shr(a, bits - 1), 1) >> 1;
}

static inline int32_t fix_clamp(int32_t a, int32_t lo, int32_t hi)
{
    return a < lo ? lo : a > hi ? hi : a;
}

/* Saturates a 64-bit intermediate to a channel value. */
static inline int32_t fix_value(int64_t a)
{
    return a < -FIX_VALUE_MAX ? -FIX_VALUE_MAX : a > FIX_VALUE_MAX ? FIX_VALUE_MAX : (int32_t)a;
}

/* Intermediates of a shape's affine part saturate here: three of them turned still fit (SPEC 6.8). */
#define FIX_AFFINE_MAX (INT32_C(0x3fffffff))

/* floor(a 2^bits), saturated to +-FIX_AFFINE_MAX; any bits. */
static inline int32_t fix_scale(int32_t a, int bits)
{
    if (bits < 0) {
        a = wg_shr(a, bits < -31 ? 31u : (unsigned)-bits);
        return fix_clamp(a, -FIX_AFFINE_MAX, FIX_AFFINE_MAX);
    }
    int32_t most = bits < 30 ? FIX_AFFINE_MAX >> bits : 0;
    return a < -most  ? -FIX_AFFINE_MAX
           : a > most ? FIX_AFFINE_MAX
                      : fix_shl(a, bits < 30 ? (unsigned)bits : 0);
}

/* How many bits a takes: 0 for 0, 32 from 2^31 on. */
static inline unsigned fix_bits(uint32_t a)
{
    unsigned bits = 0;
    for (unsigned step = 16; step > 0; step /= 2) { /* 5 rounds */
        if (a >> step != 0) {
            a >>= step;
            bits += step;
        }
    }
    return bits + (a != 0);
}

/* floor(sqrt(a)), a bit of the root a round. */
static inline uint16_t fix_sqrt(uint32_t a)
{
    uint32_t root = 0;
    for (uint32_t bit = UINT32_C(1) << 30; bit > 0; bit >>= 2) { /* 16 rounds */
        uint32_t square = root + bit;
        root >>= 1;
        if (a >= square) {
            a -= square;
            root += bit;
        }
    }
    return (uint16_t)root;
}

/* round(2^(30 - i/32)), i = 0..31, but 2^30 - 1 for i = 0, so that the sum of two exponentials is
 * an int32; read through wg_rd32. */
extern const int32_t fix_exp2_table[32];

/* 2^-p, p in UQ8.24 below 32, as Q30; 0 from p = 31 on. Error <= 2^-23.4 of 1 (the fit has
 * 2^-23.9). With z = 32 frac: 1 - 2^(-z/32) = z (a1 - a2 z); the constants are a1 2^33 and
 * a2 2^34. */
static inline int32_t fix_exp2n(uint32_t p_q24)
{
    int32_t step = (int32_t)wg_rd32(&fix_exp2_table[(uint8_t)(p_q24 >> 16) >> 3]);
    int32_t z_q31 = (int32_t)((p_q24 & UINT32_C(0x7ffff)) << 12);
    int32_t drop_q32 = fix_mulh(z_q31, INT32_C(0x0b170939) - fix_mulh(z_q31, INT32_C(0x003ce234)));
    return wg_shr(step - fix_mulh(step, drop_q32), (unsigned)(p_q24 >> 24));
}

/* Cosine and sine in Q30. */
typedef struct {
    int32_t cosine, sine;
} fix_turn;

/* Of a phase in turns / 2^32. Error <= 2^-20.7 (sine) and 2^-24 (cosine) before the quadrant swaps
 * them. z in [-1, 1) is the phase from the nearest quarter turn in eighths:
 * sin = z (s0 - y (s1 - y s2)), cos = 1 - y (c1 - y (c2 - y c3)) with y = z^2 in Q30. */
static inline fix_turn fix_sincos(uint32_t phase)
{
    uint32_t quarter = phase + UINT32_C(0x20000000); /* the quadrant in its two upper bits */
    int32_t z = (int32_t)(phase << 2);               /* the quadrant's bits fall off */
    int32_t y = fix_mulh(z, z);
    int32_t odd =
        INT32_C(1686621276) - fix_mulh(y, INT32_C(693327967) - fix_mulh(y, INT32_C(83394718)));
    int32_t even =
        INT32_C(1324673091) - fix_mulh(y, INT32_C(272307757) - fix_mulh(y, INT32_C(21932517)));
    int32_t c = INT32_C(0x40000000) - fix_mulh(y, even), s = fix_mulh(z, odd);
    /* Odd quarters: (c, s) becomes (-s, c); the upper ones change both signs. Without a branch. */
    int32_t odd_quarter = (int32_t)(quarter << 1) >> 31, upper = (int32_t)quarter >> 31;
    int32_t swap = (c ^ s) & odd_quarter, minus = odd_quarter ^ upper;
    fix_turn t = {((c ^ swap) ^ minus) - minus, ((s ^ swap) ^ upper) - upper};
    return t;
}

/* Cosine and sine in Q14. */
typedef struct {
    int16_t cosine, sine;
} fix_turn14;

/* round(2^14 sin(2 pi j / 256)), j = 0..319; read through wg_rd16. */
extern const int16_t fix_sine_table[320];

/* Of a phase in turns / 2^32: the nearest of 256 directions, and from there along the tangent, so
 * that the length is at most (pi / 256)^2 / 2 = 7.6e-5 too large. 105414357 is 2 pi 2^24. */
static inline fix_turn14 fix_turn16(uint32_t phase)
{
    uint8_t j = (uint8_t)((phase + UINT32_C(0x00800000)) >> 24);
    int32_t d_q32 = fix_mulh((int32_t)(phase << 8), INT32_C(105414357)); /* < 2^26 */
    int32_t s = (int16_t)wg_rd16(&fix_sine_table[j]);
    int32_t c = (int16_t)wg_rd16(&fix_sine_table[j + 64u]);
    fix_turn14 t = {(int16_t)(c + fix_round(fix_mulh(-2 * s, d_q32), 1)),
                    (int16_t)(s + fix_round(fix_mulh(2 * c, d_q32), 1))};
    return t;
}

#endif
