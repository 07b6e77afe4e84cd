/* Inside the player: what skins take from shapes.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_SHAPE_H
#define WIGGLY_SHAPE_H

#include "wiggly.h"

/* S + 2^14 of vertices first .. first + count - 1 (SPEC 6.8 step 2): rest and weighted bases, to be
 * shifted right by 15. */
void wg_pose_sums(const wg_pose *pose, uint16_t first, uint16_t count, int32_t *sums);

/* Row `row` in Q30 times a column whose elements lie `stride` apart: three products rounded down to
 * multiples of 4, so at most 12 too small. */
int32_t wg_turned(const int32_t *row, const int32_t *column, unsigned stride);

#endif
