/* Triangles that reach behind the viewer or far out of the picture: what is left of them inside.
 *
 * Five planes cut one after the other: the nearest depth, then four sides well outside the picture.
 * A corner that the view could project lies inside all of them by definition. An edge is cut from
 * its inner end outwards, so two triangles that share it share the cut, to the bit.
 *
 * Source: I. E. Sutherland, G. W. Hodgman, Reentrant polygon clipping, CACM 17 (1974).
 * SPDX-License-Identifier: MIT */
#include <stddef.h>

#include "draw.h"
#include "fix.h"

#define PLANES  5u
#define CORNERS (3u + PLANES) /* each plane adds one at the most */

/* A spot, and brightness or texel coordinates: differences below 2^25. */
#define PARTS 5u
typedef struct {
    int32_t at[PARTS];
    const wg_vertex *kept; /* where the view sees it: inside all planes; NULL: not known yet */
    bool edge;             /* the edge to the next corner is one of the triangle's, to be drawn */
} corner;

typedef struct {
    corner at[CORNERS + 1u]; /* one more, should rounding ever bend a polygon */
    unsigned count;
} polygon;

/* How far inside a plane a spot lies; |spot| <= 2^24, depth times guard < 2^25. */
static int32_t inside(const wg_view *view, const corner *c, unsigned plane)
{
    int32_t way = c->at[2] * view->guard + view->edge;
    if (plane == 0) {
        way = c->at[2] - (view->distance >> 14); /* 1/16 of it, in quarters of a step */
    } else if (plane & 1u) {
        way += c->at[plane >> 1];
    } else {
        way -= c->at[(plane >> 1) - 1u];
    }
    return c->kept && way < 0 ? 0 : way;
}

/* Appends the point where the edge from `in`, `way` inside, meets the plane, `length` being the whole
 * edge's way; rounded towards `in`, so that it lies inside too. */
static void cut(polygon *p, const corner *in, const corner *out, int32_t way, int32_t length)
{
    int bits = wg_bits((uint32_t)length);
    unsigned down = bits > 15 ? (unsigned)bits - 15u : 0;
    unsigned whole = (unsigned)wg_shr(length, down) + (down > 0);
    uint32_t t_q32 = (uint32_t)wg_shr(way, down) * wg_inverse(whole); /* way <= length: < 2^32 */
    corner *c = &p->at[p->count++];
    for (unsigned i = 0; i < PARTS; i++) { /* 2^25 16 2^31 / 2^32 is 8 times the way */
        int32_t delta = fix_mulh((out->at[i] - in->at[i]) * 16, (int32_t)(t_q32 >> 1));
        c->at[i] = in->at[i] + fix_round(delta, 3);
    }
    c->kept = NULL;
    c->edge = false;
}

static void cut_plane(const wg_view *view, const polygon *from, unsigned plane, polygon *to)
{
    to->count = 0;
    const corner *a = &from->at[from->count - 1];
    int32_t in_a = inside(view, a, plane);
    for (const corner *b = from->at; b < from->at + from->count; b++) { /* <= CORNERS */
        int32_t in_b = inside(view, b, plane);
        if (to->count >= CORNERS) {
            return; /* what is left of it lies outside */
        }
        if (in_a >= 0 && in_b < 0) {
            cut(to, a, b, in_a, in_a - in_b); /* the edge that follows lies in the plane */
        } else if (in_a < 0 && in_b >= 0) {
            cut(to, b, a, in_b, in_b - in_a);
            to->at[to->count - 1].edge = a->edge;
        }
        if (in_b >= 0) {
            to->at[to->count++] = *b;
        }
        a = b;
        in_a = in_b;
    }
}

static void draw_fan(const wg_canvas *canvas, wg_triangle *t, polygon *p)
{
    wg_vertex seen[CORNERS + 1u];
    for (unsigned i = 0; i < p->count; i++) {
        corner *c = &p->at[i];
        if (!c->kept) {
            wg_view_seen(canvas->view, c->at, &seen[i]);
            c->kept = &seen[i];
        }
    }
    for (unsigned i = 1; i + 1 < p->count; i++) {
        const corner *c[3] = {&p->at[0], &p->at[i], &p->at[i + 1]};
        for (unsigned k = 0; k < 3; k++) {
            t->at[k] = c[k]->kept;
            t->shade[k] = (uint8_t)c[k]->at[3];
            t->texel[k][0] = c[k]->at[3];
            t->texel[k][1] = c[k]->at[4];
        }
        t->edges = (uint8_t)((i == 1 && c[0]->edge ? 1u : 0) | (c[1]->edge ? 2u : 0) |
                             (i + 2 == p->count && c[2]->edge ? 4u : 0));
        wg_draw_triangle(canvas, t);
    }
}

void wg_draw_clipped(const wg_canvas *canvas, const wg_triangle *triangle)
{
    polygon p[2];
    int32_t normal[3];
    wg_triangle t = *triangle;
    p[0].count = 3;
    for (unsigned i = 0; i < 3; i++) {
        corner *c = &p[0].at[i];
        wg_view_spot(canvas->view, t.at[i], c->at);
        c->at[3] = canvas->texture ? t.texel[i][0] : t.shade[i];
        c->at[4] = t.texel[i][1];
        c->kept = t.at[i]->z & 0x8000u ? NULL : t.at[i];
        c->edge = true;
    }
    for (unsigned i = 0; i < PLANES; i++) {
        cut_plane(canvas->view, &p[i & 1u], i, &p[~i & 1u]);
        if (p[~i & 1u].count == 0) {
            return;
        }
    }
    wg_view_face(canvas->view, t.at, normal);
    t.normal = normal;
    draw_fan(canvas, &t, &p[PLANES & 1u]);
}
