/* Wide products where the processor, or its compiler's library, multiplies 32 bits by 32.
 * The same bits as mem/avr/wg_mul.c: tests/test_player_mul.c compares them.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_MUL_H
#define WIGGLY_MUL_H

#include <stdint.h>

/* floor(a b / 2^32): one SMULL on ARM, one MULH on RV32M. */
static inline int32_t wg_mulh(int32_t a, int32_t b)
{
    return (int32_t)(((int64_t)a * b) >> 32);
}

/* floor(a b / 2^16) for a 16-bit b. */
static inline int32_t wg_mulq(int32_t a, int16_t b)
{
    return wg_mulh(a, (int32_t)((uint32_t)(int32_t)b << 16));
}

/* floor(a b / 2^16) modulo 2^32. */
static inline uint32_t wg_mulm(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 16);
}

/* The same for a signed a and b below 2^31. */
static inline uint32_t wg_mulsm(int32_t a, int32_t b)
{
    return (uint32_t)(((int64_t)a * b) >> 16);
}

/* floor(a b / 2^16) where that is below 2^29, else 2^29. */
static inline uint32_t wg_mul29(uint32_t a, uint32_t b)
{
    uint64_t ab = (uint64_t)a * b;
    return ab >> 45 ? UINT32_C(1) << 29 : (uint32_t)(ab >> 16);
}

/* floor(a b / 2^17) for a b < 2^48. Not wg_mulm >> 1: a compiler that knows the result's sign goes on to
 * multiply signed by unsigned, in three instructions. */
static inline int32_t wg_mul17(uint32_t a, uint32_t b)
{
    return (int32_t)(((uint64_t)a * b) >> 17);
}

#endif
