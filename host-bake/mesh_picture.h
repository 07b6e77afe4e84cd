/* What a flat shape is drawn with.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_MESH_PICTURE_H
#define BAKE_MESH_PICTURE_H

/* The point (x, y) of the scene shows the texel in column corner[0] + step x, row corner[1] - step
 * y from the top, both rounded down. */
typedef struct mesh_picture {
    int width, height;
    double step, corner[2];     /* texels a scene unit; texel coordinates of (0, 0) */
    unsigned char palette[768]; /* red, green, blue of each */
    unsigned char *texel;       /* height x width; 0 is transparent */
} mesh_picture;

#endif
