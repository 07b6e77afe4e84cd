/* The clip's picture on the board's display. PANEL in board.mk, or on make's command line, says which
 * directory of firmware/panel/ is the display; none has two empty functions for a board without.
 * SPDX-License-Identifier: MIT */
#ifndef SCREEN_H
#define SCREEN_H

#include "wiggly.h"

/* Checks the clip's shapes and switches the display on if the clip has something to show.
 *   returns  0, or WG_ERR_* of wg_open_shapes */
int screen_start(const wg_file *file);

/* The picture of `values`, as far as it differs from the one before. */
void screen_frame(const int32_t *values);

#endif
