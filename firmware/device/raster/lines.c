/* The edges of triangles as lines, hidden where the triangles hide them.
 *
 * A line has one pixel in every row, if it is steep, or else in every column, from the pixel of one
 * end to that of the other: the one where it passes the row's middle. Each triangle draws its own
 * edges in its own plane, so that its interior and that of its neighbour, drawn in the same nearness
 * with brightness 0, never hide them.
 *
 * Source: own.
 * SPDX-License-Identifier: MIT */
#include "draw.h"
#include "fix.h"

static void put(const wg_canvas *canvas, const wg_fill *fill, int_fast16_t x, int_fast16_t y)
{
    const wg_slope *s = &fill->slope[WG_SLOPE_NEAR];
    const wg_rect *box = &fill->box;
    if (x < (int_fast16_t)box->x0 || x >= (int_fast16_t)box->x1 || y < (int_fast16_t)box->y0 ||
        y >= (int_fast16_t)box->y1) {
        return;
    }
    uint32_t near = s->at + s->column * ((uint32_t)x - box->x0) + s->row * ((uint32_t)y - box->y0);
    uint32_t word = wg_near(fill, near) << 16 | UINT32_C(0xff00) | canvas->part;
    uint32_t *pixel = wg_canvas_pixel(canvas, (uint_fast16_t)x, (uint_fast16_t)y);
    *pixel = word > *pixel ? word : *pixel;
}

static void draw(const wg_canvas *canvas, const wg_fill *fill, const wg_vertex *a,
                 const wg_vertex *b)
{
    int32_t dx = (int32_t)b->x - a->x, dy = (int32_t)b->y - a->y;
    bool steep = wg_magnitude(dy) > wg_magnitude(dx);
    if ((steep ? dy : dx) < 0) { /* the same pixels for either direction */
        const wg_vertex *swap = a;
        a = b;
        b = swap;
    }
    /* Along the line from..to, across it start..end, in 1/16 pixel. */
    int16_t from = steep ? a->y : a->x, to = steep ? b->y : b->x;
    int16_t start = steep ? a->x : a->y, end = steep ? b->x : b->y;
    int32_t slope = 0;
    if (to > from) { /* Q15, rounded towards 0: no point of the line lies beyond its end */
        uint32_t way = wg_magnitude((int32_t)end - start); /* <= to - from: the product < 2^32 */
        slope = (int32_t)(way * wg_inverse((unsigned)((int32_t)to - from)) >> 17);
        slope = end < start ? -slope : slope;
    }
    int_fast16_t low = (int_fast16_t)(steep ? fill->box.y0 : fill->box.x0), i = from >> 4;
    int_fast16_t high = (int_fast16_t)(steep ? fill->box.y1 : fill->box.x1) - 1, last = to >> 4;
    for (i = i > low ? i : low, last = last < high ? last : high; i <= last; i++) {
        int32_t way = fix_clamp(16 * (int32_t)i + 8, from, to) - from;
        int_fast16_t j = (int_fast16_t)((start + (slope * way >> 15)) >> 4);
        put(canvas, fill, steep ? j : i, steep ? i : j);
    }
}

void wg_draw_edges(const wg_canvas *canvas, const wg_triangle *triangle, const wg_fill *fill)
{
    for (unsigned i = 0; i < 3; i++) {
        if ((unsigned)triangle->edges >> i & 1u) {
            draw(canvas, fill, triangle->at[i], triangle->at[i < 2 ? i + 1 : 0]);
        }
    }
}
