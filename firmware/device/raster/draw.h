/* Inside the raster: one triangle into a rectangle of pixels.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_DRAW_H
#define WIGGLY_DRAW_H

#include "paint.h"
#include "view.h"

/* Where and how the triangles of one part are drawn. */
typedef struct {
    const wg_view *view;
    uint32_t *pixels; /* of `rect`, row by row */
    wg_rect rect;
    uint8_t shading;           /* WG_SHADING_* */
    uint8_t part;              /* + 1: what a pixel holds */
    uint8_t sides;             /* 0: the front alone */
    const wg_texture *texture; /* pixels hold its texels; NULL: brightness */
} wg_canvas;

/* X, Y in the rectangle. */
static inline uint32_t *wg_canvas_pixel(const wg_canvas *c, uint_fast16_t x, uint_fast16_t y)
{
    return c->pixels + (uint32_t)(y - c->rect.y0) * (uint32_t)(c->rect.x1 - c->rect.x0) +
           (x - c->rect.x0);
}

/* Edge i leads from corner i to the next one. */
#define WG_EDGES 7u
typedef struct {
    const wg_vertex *at[3]; /* in the picture: z < 0x8000 */
    const int32_t *normal;  /* flat shading: of the front; NULL: that of the corners */
    uint8_t shade[3];
    uint8_t edges;       /* wireframe: bit i = edge i is drawn */
    int32_t texel[3][2]; /* with a texture: coordinates, Q10 */
} wg_triangle;

/* A quantity that is linear over the picture, modulo 2^32. */
typedef struct {
    uint32_t at;          /* in some pixel */
    uint32_t column, row; /* how much more in the next one */
} wg_slope;

/* The three edges, not negative inside; then nearness and brightness, Q15, or nearness and texel
 * coordinates, Q20. */
#define WG_SLOPE_NEAR 3u
#define WG_SLOPES     6u

/* A triangle ready to be drawn: slopes start at pixel (box.x0, box.y0). */
typedef struct {
    wg_rect box; /* the part of the rectangle to look at */
    wg_slope slope[WG_SLOPES];
    uint16_t low[3], high[3]; /* of the corners */
    uint8_t part;
} wg_fill;

/* Draws it if it is to be seen and touches the rectangle. */
void wg_draw_triangle(const wg_canvas *canvas, const wg_triangle *triangle);

/* The same for one with corners outside (z >= 0x8000): what the view can see of it. */
void wg_draw_clipped(const wg_canvas *canvas, const wg_triangle *triangle);

/* The edges of a triangle that is seen. `fill`: its nearness. */
void wg_draw_edges(const wg_canvas *canvas, const wg_triangle *triangle, const wg_fill *fill);

/* The pixels of a triangle with a texture. */
void wg_fill_texels(const wg_canvas *canvas, wg_fill *fill);

/* A pixel's nearness, limited to what the corners have. */
uint32_t wg_near(const wg_fill *fill, uint32_t near);

#endif
