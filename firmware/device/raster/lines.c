/* The edges of triangles as lines, hidden where the triangles hide them.
 *
 * A line has one pixel in every column (row) that its steeper (flatter) kind touches, from the pixel
 * of one end to that of the other: the one where it passes the column's middle. Each triangle draws
 * its own edges in its own plane, so that its interior and that of its neighbour, drawn in the same
 * nearness with brightness 0, never hide them.
 *
 * Source: own.
 * SPDX-License-Identifier: MIT */
#include "draw.h"
#include "fix.h"

/* Along the longer axis from `from` to `to`, across from `start` at `slope` Q15, in 1/16 pixel. */
typedef struct {
    int16_t from, to;
    int16_t low, high; /* of its ends, across */
    int32_t start, slope;
    bool steep; /* the longer axis is y */
} line;

static line line_of(const wg_vertex *a, const wg_vertex *b)
{
    int32_t dx = (int32_t)b->x - a->x, dy = (int32_t)b->y - a->y;
    bool steep = wg_magnitude(dy) > wg_magnitude(dx);
    if ((steep ? dy : dx) < 0) { /* the same pixels for either direction */
        const wg_vertex *swap = a;
        a = b;
        b = swap;
        dx = -dx;
        dy = -dy;
    }
    int32_t length = steep ? dy : dx, way = steep ? dx : dy;
    int16_t start = steep ? a->x : a->y, end = steep ? b->x : b->y;
    line l = {steep ? a->y : a->x,       steep ? b->y : b->x, start < end ? start : end,
              start < end ? end : start, start,               0,
              steep};
    if (length > 0) { /* |way| <= length <= 32766: at most 1 in Q15, and the product below 2^30 */
        l.slope = wg_ratio_mul(fix_shl(way, 15), wg_ratio_inverse((uint32_t)length));
    }
    return l;
}

/* Where the line is across at `along`: a pixel. */
static int16_t across(const line *l, int16_t along)
{
    int32_t way = fix_clamp(16 * (int32_t)along + 8, l->from, l->to) - l->from;
    return (int16_t)(fix_clamp(l->start + ((l->slope * way) >> 15), l->low, l->high) >> 4);
}

static void put(const wg_canvas *canvas, const wg_fill *fill, uint16_t x, uint16_t y)
{
    const wg_rect *rect = &canvas->rect;
    const wg_slope *s = &fill->slope[WG_SLOPE_NEAR];
    uint32_t near = s->at + s->column * ((uint32_t)x - fill->box.x0) +
                    s->row * ((uint32_t)y - fill->box.y0);
    uint32_t word = wg_near(fill, near) << 16 | UINT32_C(0xff00) | canvas->part;
    uint32_t *pixel = canvas->pixels +
                      (uint32_t)(y - rect->y0) * (uint32_t)(rect->x1 - rect->x0) + (x - rect->x0);
    *pixel = word > *pixel ? word : *pixel;
}

static void draw(const wg_canvas *canvas, const wg_fill *fill, const line *l)
{
    const wg_rect *box = &fill->box;
    int16_t low = (int16_t)(l->steep ? box->y0 : box->x0);
    int16_t high = (int16_t)((l->steep ? box->y1 : box->x1) - 1);
    low = (l->from >> 4) > low ? (int16_t)(l->from >> 4) : low;
    high = (l->to >> 4) < high ? (int16_t)(l->to >> 4) : high;
    for (int16_t i = low; i <= high; i++) {
        int16_t j = across(l, i);
        int16_t x = l->steep ? j : i, y = l->steep ? i : j;
        if (x >= (int16_t)box->x0 && x < (int16_t)box->x1 && y >= (int16_t)box->y0 &&
            y < (int16_t)box->y1) {
            put(canvas, fill, (uint16_t)x, (uint16_t)y);
        }
    }
}

void wg_draw_edges(const wg_canvas *canvas, const wg_triangle *triangle, const wg_fill *fill)
{
    for (unsigned i = 0; i < 3; i++) {
        if ((unsigned)triangle->edges >> i & 1u) {
            line l = line_of(&triangle->corner[i].at, &triangle->corner[i < 2 ? i + 1 : 0].at);
            draw(canvas, fill, &l);
        }
    }
}
