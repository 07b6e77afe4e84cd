/* Inside the player: the loops over a block of two bases, where a shape's time goes. kernel/plain/
 * has them in C, kernel/dsp/ for cores with SMLAD (Cortex-M4, M7, M33); the Makefile's KERNEL picks
 * one. The same bits: tests/test_boards.py compares them.
 *   acc         components sums; acc[i] += a_i w_a + b_i w_b modulo 2^32
 *   data        as in SPEC 4.15, on a multiple of 4, from an even component on
 *   weights     w_a in the lower half, w_b in the upper; each within +-32767
 *   components  whole vertices for 16 bits, a multiple of 3; any number for 8
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_KERNEL_H
#define WIGGLY_KERNEL_H

#include <stdint.h>

void wg_kernel_pair16(int32_t *acc, const uint8_t *data, uint32_t weights, unsigned components);
void wg_kernel_pair8(int32_t *acc, const uint8_t *data, uint32_t weights, unsigned components);

#endif
