/* Pictures as clips hold them: texels and a palette.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_TEXTURE_H
#define BAKE_TEXTURE_H

#include "mesh_picture.h"
#include "bitmap.h"

/* Where a picture is in the scene: the part of it that shows, lower, then upper corner, in pixels;
 * the middle of that is at (0, 0), y upwards. */
typedef struct {
    double box[4];
    double unit; /* scene units a pixel */
    int texels;  /* a side, at most */
} picture_place;

/* What shows of `p`, and a texel more on each side, in at most 255 colours. Texel 0 is transparent;
 * around what is opaque, four texels repeat the nearest colour. */
int picture_make(const pixels *p, const picture_place *where, mesh_picture *out, bake_error *error);

#endif
