/* The clip's picture on the board's display. PANEL in board.mk, or on make's command line, says which
 * directory of firmware/panel/ is the display; none has two empty functions for a board without.
 * SPDX-License-Identifier: MIT */
#ifndef SCREEN_H
#define SCREEN_H

#include "wiggly.h"

/* Checks the clip's shapes and switches the display on if the clip has something to show.
 *   returns  0, or WG_ERR_* of wg_open_shapes */
int screen_start(const wg_file *file);

/* Every tick. `values` become the next picture unless one is still being made: a picture takes as
 * long as it takes, and what moves servos does not wait for it. */
void screen_frame(const int32_t *values);

/* A slice of the picture: some vertices or a band of rows, a few milliseconds.
 *   returns  whether there is more to do */
bool screen_work(void);

/* Leaves the picture of `values` on the display, however long it takes. */
void screen_finish(const int32_t *values);

#endif
