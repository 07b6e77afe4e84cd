/* The only fixed-point arithmetic of the player and the device code: one definition an operation.
 * Source: own; the polynomials are minimax fits, regenerated and checked by
 * tests/reference/fix_oracle.py. Every operation is exact integer arithmetic with the stated
 * rounding, so the bits are the same on every target; sums that may leave int32 on a hostile clip
 * wrap through uint32 and are never undefined. SPDX-License-Identifier: MIT */
#ifndef WIGGLY_FIX_H
#define WIGGLY_FIX_H

#include <stdint.h>

#define WG_STATIC_ASSERT_2(cond, line) typedef char wg_assert_##line[(cond) ? 1 : -1]
#define WG_STATIC_ASSERT_1(cond, line) WG_STATIC_ASSERT_2(cond, line)
#define WG_STATIC_ASSERT(cond)         WG_STATIC_ASSERT_1(cond, __LINE__)

/* What C99 leaves open and this file relies on; every compiler we build with agrees. */
WG_STATIC_ASSERT((-1 >> 1) == -1);
WG_STATIC_ASSERT((int32_t)0x80000000u == -0x7fffffff - 1);

/* Channel values saturate here (SPEC 6.1): sums of two still fit in int32. */
#define FIX_VALUE_MAX ((int32_t)1 << 29)

/* floor(a b / 2^32): one SMULL on ARM and one MULH on RV32M; |result| <= 2^30. */
static inline int32_t fix_mulh(int32_t a, int32_t b)
{
    return (int32_t)(((int64_t)a * b) >> 32);
}

/* floor(a b / 2^16) for a 16-bit b: the same bits as fix_mulh(a, b * 65536). */
static inline int32_t fix_mulq(int32_t a, int16_t b)
{
    return fix_mulh(a, (int32_t)((uint32_t)(int32_t)b << 16));
}

/* floor(a w / 2^15) for a weight w in 0..32768; w = 32768 gives a itself. */
static inline int32_t fix_weigh(int32_t a, uint16_t w)
{
    return (int32_t)(((int64_t)a * w) >> 15);
}

/* floor(a b / 2^16) modulo 2^32, for phases and positions. */
static inline uint32_t fix_mulm(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 16);
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

/* a 2^bits modulo 2^32; bits in 0..31. */
static inline int32_t fix_shl(int32_t a, unsigned bits)
{
    return (int32_t)((uint32_t)a << bits);
}

/* round(a / 2^bits), halves up; bits in 1..30. */
static inline int32_t fix_round(int32_t a, unsigned bits)
{
    return fix_add(a >> (bits - 1), 1) >> 1;
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

int32_t fix_exp2n(uint32_t p_q24);
void fix_sincos(uint32_t phase, int32_t *sine, int32_t *cosine);

#endif
