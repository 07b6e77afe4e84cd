/* Inside the player: the loops where the time of shapes and skins goes. kernel/plain/ has them in C,
 * kernel/dsp/ for cores with SMLAD (Cortex-M4, M7, M33); the Makefile's KERNEL picks one. The same
 * bits: tests/test_boards.py compares them.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_KERNEL_H
#define WIGGLY_KERNEL_H

#include "wiggly.h"

/* A block of two bases.
 *   acc         components sums; acc[i] += a_i w_a + b_i w_b modulo 2^32
 *   data        as in SPEC 4.15, on a multiple of 4, from an even component on
 *   weights     w_a in the lower half, w_b in the upper; each within +-32767
 *   components  whole vertices for 16 bits, a multiple of 3; any number for 8 */
void wg_kernel_pair16(int32_t *acc, const uint8_t *data, uint32_t weights, unsigned components);
void wg_kernel_pair8(int32_t *acc, const uint8_t *data, uint32_t weights, unsigned components);

/* A stretch of vertices with equally many influences of a LINEAR skin (SPEC 6.10). */
typedef struct {
    const wg_bone *bones;  /* as wg_skin_set leaves them */
    const uint8_t *frames; /* the first bone's F in the clip: one every WG_BONE_BYTES */
    const uint8_t *data;   /* bone, weight and, with ends, end of each influence */
    uint32_t influences;   /* 1..8 */
    int32_t move[3];       /* g */
} wg_kernel_skin;

/*   xyz    3 count sums of wg_pose_sums; then vertices
 *   count  >= 1 */
void wg_kernel_linear(const wg_kernel_skin *skin, int32_t *xyz, unsigned count);
void wg_kernel_ends(const wg_kernel_skin *skin, int32_t *xyz, unsigned count);

#endif
