/* Wide products where the processor, or its compiler's library, multiplies 32 bits by 32.
 * The same bits as mem/avr/wg_mul.S: tests/test_boards.py compares them.
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

/* floor(a b / 2^16) modulo 2^32 for b in 0 .. 2^31 - 1. */
static inline uint32_t wg_mulsm(int32_t a, int32_t b)
{
    return (uint32_t)(((int64_t)a * b) >> 16);
}

/* floor(a b / 2^16), 2^29 at the most. */
static inline uint32_t wg_mul29(uint32_t a, uint32_t b)
{
    uint64_t ab = (uint64_t)a * b;
    return ab >> 45 ? UINT32_C(1) << 29 : (uint32_t)(ab >> 16);
}

/* floor(a b / 2^17) for a b < 2^48. Signed: a compiler that does not know the result's sign cannot
 * go on to multiply it by a signed number in one instruction. */
static inline int32_t wg_mul17(uint32_t a, uint32_t b)
{
    return (int32_t)(((uint64_t)a * b) >> 17);
}

/* floor(a w / 2^15) for |a| <= 2^30 and w in 0 .. 32768. Two products of 32 bits cost a Cortex-M0
 * 34 instructions less than one of 64. */
static inline int32_t wg_weigh(int32_t a, uint16_t w)
{
    int32_t high = (a >> 16) * (int32_t)w * 2; /* the true sum fits */
    return high + (int32_t)(((uint32_t)a & 0xffffu) * w >> 15);
}

/* floor(a w / 2^10) for w in 0 .. 256. */
static inline int32_t wg_share(int32_t a, uint16_t w)
{
    return wg_mulh(a, (int32_t)((uint32_t)w << 22));
}

/* floor((2^32 - 1) / a) for a in 1 .. 65535. */
static inline uint32_t wg_inverse(unsigned a)
{
    return UINT32_C(0xffffffff) / a;
}

/* floor(a / 2^bits) for bits in 0 .. 31. */
static inline int32_t wg_shr(int32_t a, unsigned bits)
{
    return a >> bits;
}

#endif
