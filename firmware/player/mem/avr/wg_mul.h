/* Wide products where one instruction multiplies 8 bits by 8: by hand, in wg_mul.S. wg_mulh takes
 * 101 cycles with its return, where avr-gcc 5.4 needs 314 for the 64-bit product and its shift.
 * The same bits as mem/near/wg_mul.h: tests/test_boards.py compares them.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_MUL_H
#define WIGGLY_MUL_H

#include <stdint.h>

int32_t wg_mulh(int32_t a, int32_t b);     /* floor(a b / 2^32) */
int32_t wg_mulq(int32_t a, int16_t b);     /* floor(a b / 2^16) */
uint32_t wg_mulsm(int32_t a, int32_t b);   /* floor(a b / 2^16) modulo 2^32, b in 0 .. 2^31 - 1 */
uint32_t wg_mul29(uint32_t a, uint32_t b); /* floor(a b / 2^16), 2^29 at the most */
int32_t wg_mul17(uint32_t a, uint32_t b);  /* floor(a b / 2^17) for a b < 2^48 */
uint32_t wg_inverse(unsigned a);           /* floor((2^32 - 1) / a), a in 1 .. 65535 */
int32_t wg_shr(int32_t a, unsigned bits);  /* floor(a / 2^bits), bits in 0 .. 31 */

/* floor(a w / 2^15) for |a| <= 2^30 and w in 0 .. 32768. */
static inline int32_t wg_weigh(int32_t a, uint16_t w)
{
    return (int32_t)wg_mulsm(a, (int32_t)w << 1);
}

/* floor(a w / 2^10) for w in 0 .. 256. */
static inline int32_t wg_share(int32_t a, uint16_t w)
{
    return (int32_t)wg_mulsm(a, (int32_t)(w << 6));
}

#endif
