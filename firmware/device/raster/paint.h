/* Parts with a palette [SPEC 4.23]: which one, and the picture on a part's triangles.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_PAINT_H
#define WIGGLY_PAINT_H

#include "raster.h"

/* A picture on the triangles of one part. */
typedef struct {
    const uint8_t *texels; /* height rows of width */
    const uint8_t *rest;   /* of the shape: where its vertices lie on the picture */
    int32_t step;          /* texels a raw unit, Q26 */
    int32_t corner[2];     /* of raw (0, 0), Q10 */
    uint16_t width, height;
} wg_texture;

/* Texel coordinates of corners, Q10, are limited to this, twice the largest picture: planes through
 * them may overshoot by as much before they wrap. */
#define WG_TEXEL_LIMIT ((INT32_C(1) << 21) - 1)

/* The record among the first `paints` that says how a part is painted, or NULL. */
const uint8_t *wg_paint_of(const wg_file *file, uint8_t paints, uint16_t part);

/* Pre: `paint` is a PICTURE on a part of `shape`. */
void wg_texture_set(wg_texture *texture, const wg_file *file, const uint8_t *paint, uint16_t shape);

/* Texel coordinates of a vertex, Q10. */
void wg_texture_at(const wg_texture *texture, uint16_t vertex, int32_t *texel);

#endif
