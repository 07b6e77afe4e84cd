/* Wide products where only 8 bits times 8 are one instruction: four products of 16 bits each, where the
 * compiler's 64-bit multiplication and shift take three times as long (DESIGN 6).
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_MUL_H
#define WIGGLY_MUL_H

#include <stdint.h>

int32_t wg_mulh(int32_t a, int32_t b);    /* floor(a b / 2^32) */
int32_t wg_mulq(int32_t a, int16_t b);    /* floor(a b / 2^16) */
uint32_t wg_mulm(uint32_t a, uint32_t b); /* floor(a b / 2^16) modulo 2^32 */
uint32_t wg_mulsm(int32_t a, int32_t b);  /* the same for a signed a and b in 0 .. 2^31 - 1 */
uint32_t wg_mul29(uint32_t a,
                  uint32_t b); /* floor(a b / 2^16) where that is below 2^29, else 2^29 */
int32_t wg_mul17(uint32_t a, uint32_t b); /* floor(a b / 2^17) for a b < 2^48 */

#endif
