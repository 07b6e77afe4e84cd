/* Inside the player: one layer's run along its clip.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_LAYER_H
#define WIGGLY_LAYER_H

#include "wiggly.h"

/* Moves a layer's head by `dt_us` of real time and notes the span it covered. */
void wg_layer_advance(const wg_file *file, wg_layer *l, uint32_t dt_us);

/* Clip time shown at a place of the unfolded axis: us Q16 in [0, duration]. */
uint64_t wg_layer_shown(const wg_file *file, const wg_layer *l, uint64_t at);

#endif
