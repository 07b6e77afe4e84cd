/* Triangles that reach behind the viewer or far out of the picture: what is left of them inside.
 *
 * Five planes cut one after the other: the nearest depth, then four sides well outside the picture.
 * A corner that the view could project lies inside all of them by definition. An edge is cut from
 * its inner end outwards, so two triangles that share it share the cut, to the bit.
 *
 * Source: I. E. Sutherland, G. W. Hodgman, Reentrant polygon clipping, CACM 17 (1974).
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "draw.h"
#include "fix.h"

#define PLANES 5u
#define CORNERS (3u + PLANES) /* each plane adds one at the most */

typedef struct {
    int32_t at[3];
    uint8_t shade;
    uint8_t from; /* the triangle's corner that it is; 3: a cut */
    bool kept;    /* it was projected: inside all planes */
    bool edge;    /* the edge to the next corner is one of the triangle's, to be drawn */
} corner;

typedef struct {
    corner at[CORNERS];
    uint8_t count;
} polygon;

/* How far inside a plane a spot lies; |spot| <= 2^25, depth times guard < 2^25. */
static int32_t inside(const wg_view *view, const corner *c, unsigned plane)
{
    int32_t way;
    if (plane == 0) {
        way = c->at[2] - (view->distance >> 14); /* 1/16 of it, in quarters of a step */
    } else {
        int32_t across = c->at[plane >> 1 & 1u ? 0 : 1];
        way = c->at[2] * view->guard + view->edge + (plane & 1u ? across : -across);
    }
    return c->kept && way < 0 ? 0 : way;
}

/* The point where the edge from `in`, `way` inside, meets the plane `length` ways on; rounded towards
 * `in`, so that it lies inside too. */
static corner cut(const corner *in, const corner *out, int32_t way, int32_t length)
{
    uint8_t bits = wg_bits((uint32_t)length), down = bits > 15 ? (uint8_t)(bits - 15) : 0;
    unsigned whole = (unsigned)(length >> down) + (down > 0);
    uint32_t t_q32 = (uint32_t)(way >> down) * wg_inverse(whole); /* way <= length: below 2^32 */
    int32_t t = (int32_t)(t_q32 >> 1);
    corner c = {{0, 0, 0}, 0, 3, false, false};
    for (unsigned i = 0; i < 3; i++) { /* 2^26 16 2^31 / 2^32 is 8 times the way */
        int32_t whole_way = fix_shl(out->at[i] - in->at[i], 4);
        c.at[i] = in->at[i] + fix_round(fix_mulh(whole_way, t), 3);
    }
    int32_t shades = fix_shl((int32_t)out->shade - in->shade, 20);
    c.shade = (uint8_t)(in->shade + fix_round(fix_mulh(shades, t), 19));
    return c;
}

static void add(polygon *p, const corner *c)
{
    if (p->count < CORNERS) { /* always so, but for a polygon that rounding has bent */
        p->at[p->count++] = *c;
    }
}

static void cut_plane(const wg_view *view, const polygon *from, unsigned plane, polygon *to)
{
    to->count = 0;
    for (uint8_t i = 0; i < from->count; i++) { /* <= CORNERS */
        const corner *a = &from->at[i], *b = &from->at[i + 1 < from->count ? i + 1 : 0];
        int32_t in_a = inside(view, a, plane), in_b = inside(view, b, plane);
        if (in_a >= 0) {
            add(to, a);
        }
        if (in_a >= 0 && in_b < 0) {
            corner c = cut(a, b, in_a, in_a - in_b);
            add(to, &c); /* the edge that follows lies in the plane */
        } else if (in_a < 0 && in_b >= 0) {
            corner c = cut(b, a, in_b, in_b - in_a);
            c.edge = a->edge;
            add(to, &c);
        }
    }
}

static void draw_fan(const wg_canvas *canvas, const wg_triangle *triangle, const polygon *p)
{
    wg_triangle t = *triangle;
    wg_corner at[CORNERS];
    for (uint8_t i = 0; i < p->count; i++) { /* <= CORNERS */
        const corner *c = &p->at[i];
        at[i].at = c->kept ? triangle->corner[c->from].at : wg_view_seen(canvas->view, c->at);
        at[i].shade = c->shade;
    }
    for (uint8_t i = 1; i + 1 < p->count; i++) {
        t.corner[0] = at[0];
        t.corner[1] = at[i];
        t.corner[2] = at[i + 1];
        t.edges = (uint8_t)((i == 1 && p->at[0].edge ? 1u : 0) | (p->at[i].edge ? 2u : 0) |
                            (i + 2 == p->count && p->at[i + 1].edge ? 4u : 0));
        wg_draw_triangle(canvas, &t);
    }
}

void wg_draw_clipped(const wg_canvas *canvas, const wg_triangle *triangle)
{
    polygon p[2];
    int32_t at[3][3], normal[3];
    wg_triangle t = *triangle;
    p[0].count = 3;
    for (unsigned i = 0; i < 3; i++) {
        corner *c = &p[0].at[i];
        wg_view_spot(canvas->view, &t.corner[i].at, at[i]);
        memcpy(c->at, at[i], sizeof at[i]);
        c->shade = t.corner[i].shade;
        c->from = (uint8_t)i;
        c->kept = (t.corner[i].at.z & 0x8000u) == 0;
        c->edge = (unsigned)t.edges >> i & 1u;
    }
    for (unsigned i = 0; i < PLANES; i++) {
        cut_plane(canvas->view, &p[i & 1u], i, &p[~i & 1u]);
    }
    const polygon *left = &p[PLANES & 1u];
    if (left->count < 3) {
        return;
    }
    if (canvas->shading == WG_SHADING_FLAT) {
        wg_view_face(canvas->view, (const int32_t(*)[3])at, normal);
        t.normal = normal;
    }
    draw_fan(canvas, &t, left);
}
