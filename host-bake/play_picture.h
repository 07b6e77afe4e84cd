/* wiggly play --png for clips with parts.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_PLAY_PICTURE_H
#define BAKE_PLAY_PICTURE_H

#include "painter_options.h"
#include "stage.h"

/* A sheet of SHEET_COLUMNS x SHEET_ROWS pictures over the whole performance, each above its time. A
 * cell is SHEET_GAP wider than a picture and SHEET_GAP + SHEET_LABEL higher, and there is a gap at
 * the left and at the top. */
#define SHEET_COLUMNS 4
#define SHEET_ROWS    4
#define SHEET_GAP     6
#define SHEET_LABEL   (IMAGE_TEXT_HEIGHT + 4)

/* Whether `path` names a series ("frame_%03d.png"): 1, 0, or -1 and a message. */
int series_check(const char *path, bake_error *error);

/* One picture with --at, a series with --fps (10), else a sheet. It lasts --seconds, or the longest
 * clip once. */
int play_pictures(stage *g, const option *options, const char *path, bake_error *error);

#endif
