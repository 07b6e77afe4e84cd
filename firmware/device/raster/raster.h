/* Triangles and lines into a band of pixels.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_RASTER_H
#define WIGGLY_RASTER_H

#include <stdbool.h>
#include <stdint.h>

#include "wiggly.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Of a picture, each at the most: coordinates of 15 bits in 1/16 pixel leave room for cutting triangles
 * off outside a picture of this size, and of few pixels more (view.c: set_limits). */
#define WG_SIDE_MAX 800u

typedef struct {
    uint16_t width, height;
} wg_size;

/* Half open: x0 <= x < x1. */
typedef struct {
    uint16_t x0, y0, x1, y1;
} wg_rect;

/* A projected vertex. z < 0x8000: x and y in 1/16 pixel, within +-16383, z the depth in the view's
 * steps. Otherwise the vertex lies too near or too far off the picture for that, and is kept as the
 * clipper wants it (wg_view_spot): x, y and the lower 13 bits of z, signed, times 8^e with e = 0..3 in
 * bits 14..13 of z. */
typedef struct {
    int16_t x, y;
    uint16_t z;
} wg_vertex;

/* A pixel is one word, so that drawing is a maximum and needs no order:
 *   bits 31..16  nearness (1/depth), 0 = background
 *   bits 15..8   brightness
 *   bits  7..0   part + 1, 0 = background */
#define WG_PIXEL_NEAR(p)  ((p) >> 16)
#define WG_PIXEL_SHADE(p) ((uint8_t)((p) >> 8))
#define WG_PIXEL_PART(p)  ((uint8_t)(p))

#ifdef __cplusplus
}
#endif
#endif
