/* Triangles, filled, into a rectangle of pixels.
 *
 * A pixel belongs to the triangle when its centre lies inside all three edges; a centre on an edge
 * belongs to the triangle whose left or top edge that is, so that triangles side by side cover each
 * pixel once. Edges are exact: coordinates are 1/16 pixel within +-16383, so every product is below
 * 2^30 and every edge function below 2^31.
 *
 * Nearness and brightness are linear over the picture: value at pixel (0, 0) + column i + row j,
 * modulo 2^32, whatever the rectangle. They are limited to the values of the corners, because the
 * slopes of a sliver have no bound. Nearness is 1/depth in perspective, where that is what is linear
 * in the picture, and -depth in an orthographic one.
 *
 * Source: J. Pineda, A parallel algorithm for polygon rasterization, SIGGRAPH 1988; the integer
 * arithmetic is own.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "draw.h"
#include "fix.h"

/* Corners 1 and 2 seen from corner 0, as all slopes of a triangle need them. */
typedef struct {
    int32_t x[2], y[2]; /* 2^bits / 16 pixel, below 2^30 */
    wg_ratio inverse;   /* of twice the area, 1/256 pixel */
    uint8_t bits;
} span;

/* Twice the area in 1/256 pixel: positive for the front. |area| <= 2 32766^2 < 2^31. */
static int32_t area_of(const wg_triangle *t)
{
    const wg_vertex *a = &t->corner[0].at, *b = &t->corner[1].at, *c = &t->corner[2].at;
    return ((int32_t)c->x - a->x) * ((int32_t)b->y - a->y) -
           ((int32_t)b->x - a->x) * ((int32_t)c->y - a->y);
}

static int16_t least(int16_t a, int16_t b)
{
    return a < b ? a : b;
}

static int16_t most(int16_t a, int16_t b)
{
    return a > b ? a : b;
}

/* The pixels of the rectangle that the triangle may touch: those that hold a point of its box. */
static bool box_of(const wg_triangle *t, const wg_rect *rect, wg_rect *box)
{
    const wg_vertex *a = &t->corner[0].at, *b = &t->corner[1].at, *c = &t->corner[2].at;
    int16_t y0 = least(a->y, least(b->y, c->y)) >> 4, y1 = most(a->y, most(b->y, c->y)) >> 4;
    int16_t x0 = least(a->x, least(b->x, c->x)) >> 4, x1 = most(a->x, most(b->x, c->x)) >> 4;
    if (y1 < (int16_t)rect->y0 || y0 >= (int16_t)rect->y1 || x1 < (int16_t)rect->x0 ||
        x0 >= (int16_t)rect->x1) {
        return false;
    }
    box->x0 = (uint16_t)most(x0, (int16_t)rect->x0);
    box->y0 = (uint16_t)most(y0, (int16_t)rect->y0);
    box->x1 = (uint16_t)least((int16_t)(x1 + 1), (int16_t)rect->x1);
    box->y1 = (uint16_t)least((int16_t)(y1 + 1), (int16_t)rect->y1);
    return true;
}

/* The edge from a to b. A left edge (b lower) or a top one (b to the left at the same height) owns
 * the centres on it; for the others they lie just outside. */
static wg_slope edge_of(const wg_vertex *a, const wg_vertex *b, const wg_rect *box)
{
    int32_t dx = (int32_t)b->x - a->x, dy = (int32_t)b->y - a->y;
    int32_t x = 16 * (int32_t)box->x0 + 8 - a->x, y = 16 * (int32_t)box->y0 + 8 - a->y;
    int32_t at = x * dy - y * dx;
    bool owns = dy > 0 || (dy == 0 && dx < 0);
    wg_slope s = {(uint32_t)(owns ? at : at - 1), (uint32_t)(16 * dy), (uint32_t)(-16 * dx)};
    return s;
}

static span span_of(const wg_triangle *t, int32_t area)
{
    span s;
    uint32_t all = 0;
    for (unsigned i = 0; i < 2; i++) {
        s.x[i] = (int32_t)t->corner[i + 1].at.x - t->corner[0].at.x;
        s.y[i] = (int32_t)t->corner[i + 1].at.y - t->corner[0].at.y;
        all |= wg_magnitude(s.x[i]) | wg_magnitude(s.y[i]);
    }
    s.bits = (uint8_t)(30 - wg_bits(all));
    for (unsigned i = 0; i < 2; i++) {
        s.x[i] = fix_shl(s.x[i], s.bits);
        s.y[i] = fix_shl(s.y[i], s.bits);
    }
    s.inverse = wg_ratio_inverse((uint32_t)area);
    return s;
}

/* (d1 a0 - d0 a1) / area, Q15 a pixel, of d in Q5 times 2^up, below 2^30 like a. */
static uint32_t quotient(const span *s, const int32_t *d, const int32_t *a, uint8_t up)
{
    int32_t top = fix_sub(fix_mulh(d[1], a[0]), fix_mulh(d[0], a[1])); /* < 2^29 */
    top = fix_mulh(fix_shl(top, 2), s->inverse.m);
    /* 32 and 30 for what these two lines leave out; 10 from Q5 to Q15; 4 from 1/16 pixels. */
    return (uint32_t)wg_scaled(top, (int16_t)(s->inverse.bits + s->bits + up - 32 - 30 - 10 - 4));
}

/* A way of so many 1/16 pixels at `a` a pixel. Whole pixels count exactly, wherever it starts. */
static uint32_t along(uint32_t a, int32_t way)
{
    uint32_t rest = (uint32_t)((int32_t)a >> 4) * (uint32_t)(way & 15);
    return a * (uint32_t)(way >> 4) + rest;
}

/* The slope of a quantity that has these values, Q5 below 2^21, in the corners. */
static wg_slope slope_of(const span *s, const wg_vertex *corner, const wg_rect *box,
                         const int32_t *values)
{
    wg_slope g = {(uint32_t)values[0] << 10, 0, 0};
    int32_t d[2] = {values[1] - values[0], values[2] - values[0]};
    uint32_t all = wg_magnitude(d[0]) | wg_magnitude(d[1]);
    if (all > 0) {
        uint8_t up = (uint8_t)(30 - wg_bits(all));
        d[0] = fix_shl(d[0], up);
        d[1] = fix_shl(d[1], up);
        g.column = quotient(s, d, s->y, up);
        g.row = 0u - quotient(s, d, s->x, up);
        g.at += along(g.column, 16 * (int32_t)box->x0 + 8 - corner->x);
        g.at += along(g.row, 16 * (int32_t)box->y0 + 8 - corner->y);
    }
    return g;
}

/* Nearness at a depth in steps, Q5: 1 or more. */
static int32_t nearness(const wg_view *view, uint16_t z)
{
    if (WG_VIEW_IS_FLAT(view)) {
        return (65535 - 2 * (int32_t)z) * 32;
    }
    /* z >= 256, so its inverse has 24 bits; the other factor has 30. */
    return fix_mulh((int32_t)(view->nearness << 5), (int32_t)wg_inverse(z));
}

static void limits_of(const int32_t *values, int32_t *low, int32_t *high)
{
    *low = *high = values[0];
    for (unsigned i = 1; i < 3; i++) {
        *low = values[i] < *low ? values[i] : *low;
        *high = values[i] > *high ? values[i] : *high;
    }
    *low >>= 5;
    *high >>= 5;
}

/* Brightness in the corners, Q5. */
static void shade_corners(const wg_canvas *canvas, const wg_triangle *t, bool back, int32_t *values)
{
    int32_t at[3][3], normal[3];
    const int32_t *front = t->normal;
    for (unsigned i = 0; i < 3; i++) {
        values[i] = (int32_t)t->corner[i].shade * 32;
    }
    if (canvas->shading != WG_SHADING_FLAT) {
        return;
    }
    if (!front) {
        for (unsigned i = 0; i < 3; i++) {
            wg_view_spot(canvas->view, &t->corner[i].at, at[i]);
        }
        wg_view_face(canvas->view, (const int32_t(*)[3])at, normal);
    } else {
        memcpy(normal, front, sizeof normal);
    }
    for (unsigned i = 0; i < 3 && back && front; i++) {
        normal[i] = -normal[i];
    }
    uint8_t shade;
    wg_view_light(canvas->view, normal, 1, &shade);
    values[0] = values[1] = values[2] = (int32_t)shade * 32;
}

uint32_t wg_near(const wg_fill *fill, uint32_t near)
{
    return (uint32_t)fix_clamp((int32_t)near >> 15, fill->near_min, fill->near_max);
}

/* One row of a triangle of one brightness; `at`: edges, nearness and brightness at its start. */
static void fill_flat(const wg_fill *f, const uint32_t *at, uint32_t *pixel, uint16_t count)
{
    uint32_t a = at[0], b = at[1], c = at[2], near = at[3];
    uint32_t low = (uint32_t)f->shade_min << 8 | f->part;
    bool inside = false;
    for (; count > 0; count--, pixel++) {
        if ((a | b | c) >> 31 == 0) {
            uint32_t word = wg_near(f, near) << 16 | low;
            *pixel = word > *pixel ? word : *pixel;
            inside = true;
        } else if (inside) {
            return; /* what is left of the row lies outside: triangles are convex */
        }
        a += f->slope[0].column;
        b += f->slope[1].column;
        c += f->slope[2].column;
        near += f->slope[3].column;
    }
}

static void fill_smooth(const wg_fill *f, const uint32_t *at, uint32_t *pixel, uint16_t count)
{
    uint32_t a = at[0], b = at[1], c = at[2], near = at[3], shade = at[4];
    bool inside = false;
    for (; count > 0; count--, pixel++) {
        if ((a | b | c) >> 31 == 0) {
            int32_t s = fix_clamp((int32_t)shade >> 15, f->shade_min, f->shade_max);
            uint32_t word = wg_near(f, near) << 16 | (uint32_t)s << 8 | f->part;
            *pixel = word > *pixel ? word : *pixel;
            inside = true;
        } else if (inside) {
            return;
        }
        a += f->slope[0].column;
        b += f->slope[1].column;
        c += f->slope[2].column;
        near += f->slope[3].column;
        shade += f->slope[4].column;
    }
}

static void fill(const wg_canvas *canvas, const wg_fill *f)
{
    uint32_t at[WG_SLOPES];
    uint16_t width = (uint16_t)(canvas->rect.x1 - canvas->rect.x0);
    uint16_t count = (uint16_t)(f->box.x1 - f->box.x0);
    uint32_t *pixel = canvas->pixels + (uint32_t)(f->box.y0 - canvas->rect.y0) * width +
                      (f->box.x0 - canvas->rect.x0);
    for (unsigned i = 0; i < WG_SLOPES; i++) {
        at[i] = f->slope[i].at;
    }
    for (uint16_t y = f->box.y0; y < f->box.y1; y++, pixel += width) {
        if (f->shade_min == f->shade_max) {
            fill_flat(f, at, pixel, count);
        } else {
            fill_smooth(f, at, pixel, count);
        }
        for (unsigned i = 0; i < WG_SLOPES; i++) {
            at[i] += f->slope[i].row;
        }
    }
}

void wg_draw_triangle(const wg_canvas *canvas, const wg_triangle *triangle)
{
    wg_fill f;
    wg_triangle t = *triangle;
    if (!box_of(&t, &canvas->rect, &f.box)) {
        return;
    }
    int32_t area = area_of(&t), values[3];
    bool back = area < 0;
    if (area == 0 || (back && canvas->sides == 0)) {
        return;
    }
    if (back) {
        t.corner[1] = triangle->corner[2];
        t.corner[2] = triangle->corner[1];
        area = -area;
    }
    const wg_corner *c = t.corner;
    span s = span_of(&t, area);
    for (unsigned i = 0; i < 3; i++) {
        f.slope[i] = edge_of(&c[i].at, &c[i < 2 ? i + 1 : 0].at, &f.box);
        values[i] = nearness(canvas->view, c[i].at.z);
    }
    f.slope[WG_SLOPE_NEAR] = slope_of(&s, &c[0].at, &f.box, values);
    limits_of(values, &f.near_min, &f.near_max);
    shade_corners(canvas, &t, back, values);
    f.slope[WG_SLOPE_SHADE] = slope_of(&s, &c[0].at, &f.box, values);
    limits_of(values, &f.shade_min, &f.shade_max);
    f.part = canvas->part;
    if (canvas->shading == WG_SHADING_WIRE) { /* hides what lies behind, in the background's colour */
        f.part = 0;
        f.shade_min = f.shade_max = 0;
        wg_draw_edges(canvas, triangle, &f);
    }
    fill(canvas, &f);
}
