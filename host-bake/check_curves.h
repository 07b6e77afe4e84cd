/* One clip's curves, authored beside played: as a picture and as a table.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_CHECK_CURVES_H
#define BAKE_CHECK_CURVES_H

#include "build.h"
#include "wiggly.h"

/* A panel a channel, with the hard keys. `file` is opened and was certified against `b`. */
int curves_png(const build *b, const wg_file *file, int clip, const char *path, bake_error *error);

/* A row every 20 ms: time [s], then "<channel> authored" and "<channel> played" of each channel the
 * clip moves, in the channels' units. "-" is stdout. */
int curves_csv(const build *b, const wg_file *file, int clip, const char *path, bake_error *error);

#endif
