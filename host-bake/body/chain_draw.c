/* A chain as a mesh: a bar for each link, in the x-y plane.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CORNERS = 8, SIDES = 12 };

static const unsigned char GREY[3] = {160, 160, 160};

/* Corners: bit 0 the link's end, bit 1 its left, bit 2 the front. */
static const int TRIANGLE[SIDES][3] = {{4, 5, 7}, {4, 7, 6}, {0, 2, 3}, {0, 3, 1},
                                       {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                       {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

void chain_draw(const body_work *w, const double *q, double *at)
{
    double *ends = bake_alloc(4 * (size_t)w->c.link_count, sizeof *ends);
    chain_points(&w->c, q, ends);
    for (int i = 0; i < w->c.link_count; i++) {
        const double *p = ends + 4 * i;
        double half = w->from->width / 2, length = hypot(p[2] - p[0], p[3] - p[1]);
        double along[2] = {(p[2] - p[0]) / length, (p[3] - p[1]) / length};
        for (int c = 0; c < CORNERS; c++, at += 3) {
            double side = c & 2 ? half : -half;
            at[0] = p[2 * (c & 1)] / w->from->unit - side * along[1];
            at[1] = p[2 * (c & 1) + 1] / w->from->unit + side * along[0];
            at[2] = c & 4 ? half : -half;
        }
    }
    free(ends);
}

void chain_draw_mesh(const body_work *w, mesh *m)
{
    const scene_mesh *from = &w->s->meshes[w->from->mesh];
    size_t links = (size_t)w->c.link_count;
    *m = (mesh){.vertex_count = CORNERS * w->c.link_count,
                .triangle_count = SIDES * w->c.link_count,
                .part_count = 1};
    m->rest = bake_alloc(3 * CORNERS * links, sizeof *m->rest);
    m->triangle = bake_alloc(SIDES * links, sizeof *m->triangle);
    m->part = bake_alloc(SIDES * links, sizeof *m->part);
    m->parts = bake_alloc(1, sizeof *m->parts);
    m->parts[0].name = bake_copy(from->name);
    m->parts[0].sides = from->sides == 2;
    memcpy(m->parts[0].colour, from->has_colour ? from->colour : GREY, sizeof GREY);
    chain_draw(w, w->rest, m->rest);
    for (int i = 0; i < m->triangle_count; i++) {
        for (int k = 0; k < 3; k++) {
            m->triangle[i][k] = CORNERS * (i / SIDES) + TRIANGLE[i % SIDES][k];
        }
    }
}
