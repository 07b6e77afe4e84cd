/* Triangles, filled, into a rectangle of pixels.
 *
 * A pixel belongs to the triangle when its centre lies inside all three edges; a centre on an edge
 * belongs to the triangle whose left or top edge that is, so that triangles side by side cover each
 * pixel once. Edges are exact: coordinates are 1/16 pixel within +-16383, so every product is below
 * 2^30 and every edge function below 2^31.
 *
 * Nearness and brightness are linear over the picture: value at pixel (0, 0) + column i + row j,
 * modulo 2^32, whatever the rectangle. They are limited to the values of the corners, because the
 * slopes of a sliver have no bound. So are texel coordinates, in the place of brightness. Nearness is
 * 1/depth in perspective, where that is what is linear in the picture, and -depth in an orthographic
 * one.
 *
 * Source: J. Pineda, A parallel algorithm for polygon rasterization, SIGGRAPH 1988; the integer
 * arithmetic is own.
 * SPDX-License-Identifier: MIT */
#include "draw.h"

#include "fix.h"

/* Edges of the triangle, from corner i to the next, and its area. */
typedef struct {
    int32_t x[3], y[3]; /* 1/16 pixel */
    int32_t area;       /* twice, 1/256 pixel: positive for the front; <= 2 32766^2 < 2^31 */
    wg_ratio over;      /* 1 / area */
} outline;

static void outline_set(outline *o, const wg_vertex *const *at)
{
    for (unsigned i = 0; i < 3; i++) {
        const wg_vertex *to = at[i < 2 ? i + 1 : 0];
        o->x[i] = (int32_t)to->x - at[i]->x;
        o->y[i] = (int32_t)to->y - at[i]->y;
    }
    o->area = o->x[0] * o->y[2] - o->x[2] * o->y[0];
}

/* Lowest and highest of three values. */
typedef struct {
    int32_t low, high;
} range;

static range range_of(const int32_t *v)
{
    range r = {v[0], v[0]};
    for (unsigned i = 1; i < 3; i++) {
        r.low = v[i] < r.low ? v[i] : r.low;
        r.high = v[i] > r.high ? v[i] : r.high;
    }
    return r;
}

/* Of from .. to - 1, the pixels that hold points of a triangle with corners at `v`; whether any. */
static bool pixels_of(const int32_t *v, uint16_t from, uint16_t to, uint16_t *box)
{
    range r = range_of(v);
    int32_t low = r.low >> 4, high = (r.high >> 4) + 1;
    low = low > from ? low : from;
    high = high < to ? high : to;
    box[0] = (uint16_t)low;
    box[1] = (uint16_t)high;
    return low < high;
}

static bool box_set(wg_rect *box, const wg_vertex *const *at, const wg_rect *rect)
{
    const int32_t x[3] = {at[0]->x, at[1]->x, at[2]->x}, y[3] = {at[0]->y, at[1]->y, at[2]->y};
    uint16_t column[2], row[2];
    if (!pixels_of(x, rect->x0, rect->x1, column) || !pixels_of(y, rect->y0, rect->y1, row)) {
        return false;
    }
    box->x0 = column[0];
    box->y0 = row[0];
    box->x1 = column[1];
    box->y1 = row[1];
    return true;
}

/* The function of the edge from a. A left edge (it goes down) or a top one (to the left, level) owns
 * the centres on it; for the others they lie just outside. */
static void edge_set(wg_slope *s, const wg_vertex *a, const wg_rect *box, int32_t dx, int32_t dy)
{
    int32_t x = 16 * (int32_t)box->x0 + 8 - a->x, y = 16 * (int32_t)box->y0 + 8 - a->y;
    bool owns = dy > 0 || (dy == 0 && dx < 0);
    s->at = (uint32_t)(x * dy - y * dx - !owns);
    s->column = (uint32_t)(16 * dy);
    s->row = (uint32_t)(-16 * dx);
}

/* (d1 a0 + d0 a1) / area, Q15 a pixel, of d in Q5 times 2^up, below 2^30, and a in 1/16 pixel. */
static uint32_t quotient(const int32_t *d, int32_t a0, int32_t a1, const wg_ratio *over)
{
    /* Each product is below 2^60, their sum over 2^32 below 2^29. */
    int32_t top = fix_mulh(d[1], a0 * 32768) + fix_mulh(d[0], a1 * 32768);
    return (uint32_t)wg_ratio_mul(fix_shl(top, 2), over);
}

/* A way of so many 1/16 pixels at `a` a pixel. Whole pixels count exactly, wherever it starts. */
static uint32_t along(uint32_t a, int32_t way)
{
    uint32_t rest = (uint32_t)((int32_t)a >> 4) * (uint32_t)(way & 15);
    return a * (uint32_t)(way >> 4) + rest;
}

/* What has these values, within +-2^21, in the corners: 2^10 times finer. */
static void slope_set(wg_slope *s, const outline *o, const wg_vertex *corner, const wg_rect *box,
                      const int32_t *values)
{
    int32_t d[2] = {values[1] - values[0], values[2] - values[0]};
    uint32_t all = wg_magnitude(d[0]) | wg_magnitude(d[1]);
    s->at = (uint32_t)values[0] << 10;
    s->column = s->row = 0;
    if (all == 0) {
        return;
    }
    int up = 30 - wg_bits(all);
    wg_ratio over = o->over;
    over.bits += up - 29; /* 32 - 15 - 2 as above, then Q5 to Q15, and 16 */
    d[0] = fix_shl(d[0], (unsigned)up);
    d[1] = fix_shl(d[1], (unsigned)up);
    s->column = quotient(d, o->y[0], o->y[2], &over);
    s->row = 0u - quotient(d, o->x[0], o->x[2], &over);
    s->at += along(s->column, 16 * (int32_t)box->x0 + 8 - corner->x) +
             along(s->row, 16 * (int32_t)box->y0 + 8 - corner->y);
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

/* The brightness of a face, seen from the front or from behind. */
static uint8_t face_shade(const wg_canvas *canvas, const wg_triangle *t, bool back)
{
    int32_t normal[3];
    uint8_t shade;
    const int32_t *front = t->normal;
    if (!front) {
        wg_view_face(canvas->view, t->at, normal);
        front = normal;
    }
    for (unsigned i = 0; i < 3; i++) {
        normal[i] = back ? -front[i] : front[i];
    }
    wg_view_light(canvas->view, normal, 1, &shade);
    return shade;
}

uint32_t wg_near(const wg_fill *fill, uint32_t near)
{
    return (uint32_t)fix_clamp((int32_t)near >> 15, fill->low[0], fill->high[0]);
}

/* One row. */
static void fill_row(const wg_fill *f, uint32_t *pixel, uint_fast16_t count)
{
    uint32_t a = f->slope[0].at, b = f->slope[1].at, c = f->slope[2].at, near = f->slope[3].at;
    uint32_t shade = f->slope[4].at;
    bool inside = false;
    for (; count > 0; count--, pixel++) {
        if ((int32_t)(a | b | c) >= 0) {
            int32_t s = fix_clamp((int32_t)shade >> 15, f->low[1], f->high[1]);
            uint32_t word = wg_near(f, near) << 16 | (uint32_t)s << 8 | f->part;
            if (word > *pixel) {
                *pixel = word;
            }
            inside = true;
        } else if (inside) {
            return; /* what is left of the row lies outside: triangles are convex */
        }
        a += f->slope[0].column;
        b += f->slope[1].column;
        c += f->slope[2].column;
        near += f->slope[3].column;
        shade += f->slope[4].column;
    }
}

static void fill(const wg_canvas *canvas, wg_fill *f)
{
    uint_fast16_t width = (uint_fast16_t)(canvas->rect.x1 - canvas->rect.x0);
    uint_fast16_t count = (uint_fast16_t)(f->box.x1 - f->box.x0);
    uint32_t *pixel = wg_canvas_pixel(canvas, f->box.x0, f->box.y0);
    for (uint_fast16_t y = f->box.y0; y < f->box.y1; y++, pixel += width) {
        fill_row(f, pixel, count);
        for (unsigned i = 0; i < WG_SLOPES - 1u; i++) {
            f->slope[i].at += f->slope[i].row;
        }
    }
}

/* Nearness (0), brightness (1) or texel coordinates (1, 2) of the corners: a slope and limits. */
static void quantity_set(wg_fill *f, unsigned which, const outline *o, const wg_vertex *corner,
                         const int32_t *values)
{
    range r = range_of(values);
    f->low[which] = (uint16_t)(r.low >> 5);
    f->high[which] = (uint16_t)(r.high >> 5);
    slope_set(&f->slope[WG_SLOPE_NEAR + which], o, corner, &f->box, values);
}

/* Texels that the corners lie in, inside the picture. */
static void limit_texels(wg_fill *f, unsigned which, const int32_t *values, uint16_t count)
{
    range r = range_of(values);
    f->low[which] = (uint16_t)fix_clamp(r.low >> 10, 0, (int32_t)count - 1);
    f->high[which] = (uint16_t)fix_clamp(r.high >> 10, 0, (int32_t)count - 1);
}

/* `back`: the corners run the other way round. */
static void quantities_set(wg_fill *f, const outline *o, const wg_canvas *canvas,
                           const wg_triangle *t, bool back)
{
    const wg_texture *texture = canvas->texture;
    int32_t near[3], first[3], second[3];
    bool flat = canvas->shading == WG_SHADING_FLAT && !texture;
    uint8_t face = flat ? face_shade(canvas, t, back) : 0;
    for (unsigned i = 0; i < 3; i++) {
        unsigned k = back && i > 0 ? 3 - i : i;
        near[i] = nearness(canvas->view, t->at[k]->z);
        first[i] = texture ? t->texel[k][0] : (int32_t)(flat ? face : t->shade[k]) * 32;
        second[i] = t->texel[k][1];
    }
    quantity_set(f, 0, o, t->at[0], near);
    quantity_set(f, 1, o, t->at[0], first);
    if (texture) {
        quantity_set(f, 2, o, t->at[0], second);
        limit_texels(f, 1, first, texture->width);
        limit_texels(f, 2, second, texture->height);
    }
}

void wg_draw_triangle(const wg_canvas *canvas, const wg_triangle *triangle)
{
    wg_fill f;
    outline o;
    const wg_vertex *at[3] = {triangle->at[0], triangle->at[1], triangle->at[2]};
    if (!box_set(&f.box, at, &canvas->rect)) {
        return;
    }
    outline_set(&o, at);
    bool back = o.area < 0;
    if (o.area == 0 || (back && canvas->sides == 0)) {
        return;
    }
    if (back) {
        at[1] = triangle->at[2];
        at[2] = triangle->at[1];
        outline_set(&o, at);
    }
    o.over.m = WG_FAR;
    o.over.bits = 30;
    wg_ratio_divide(&o.over, (uint32_t)o.area);
    for (unsigned i = 0; i < 3; i++) {
        edge_set(&f.slope[i], at[i], &f.box, o.x[i], o.y[i]);
    }
    quantities_set(&f, &o, canvas, triangle, back);
    f.part = canvas->part;
    if (canvas->shading ==
        WG_SHADING_WIRE) { /* hides what lies behind, in the background's colour */
        wg_draw_edges(canvas, triangle, &f);
        f.part = 0;
        f.low[1] = f.high[1] = 0;
    }
    if (canvas->texture) {
        wg_fill_texels(canvas, &f);
    } else {
        fill(canvas, &f);
    }
}
