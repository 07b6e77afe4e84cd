/* What every panel does for screen.c, and panel.h says beside it:
 *   PANEL_WIDTH, PANEL_HEIGHT    pixels
 *   PANEL_ALIGN_X, PANEL_ALIGN_Y what is sent begins and ends on multiples of these, or at the edge
 *   PANEL_ROWS                   of a band: 4 bytes of RAM a pixel of it. Fewer are slower; where 1
 *                                is possible, board.mk can have CFLAGS := -DPANEL_ROWS=2
 *   PANEL_HEAD                   bytes before the pixels that panel_draw may write, a multiple of 4
 * For another glass with the same chip copy the directory, and say its chip in board.mk:
 *   PANEL := mine   PANEL_mine := st7789
 * SPDX-License-Identifier: MIT */
#ifndef PANEL_CALLS_H
#define PANEL_CALLS_H

#include "pixels.h"

/* Switches the display on. After hal_init. */
void panel_start(void);

/* Packs the pixels of `rect` in place and sends them. */
void panel_draw(const wg_picture *picture, wg_rect rect, uint32_t *pixels);

/* Every tick, whether anything is drawn or not. */
void panel_frame(void);

#endif
