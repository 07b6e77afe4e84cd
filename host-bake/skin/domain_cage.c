/* Cages that may go around something: their facets as a surface, or as loops.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_parts.h"

#include <stdlib.h>
#include <string.h>

void domain_cage_free(domain_cage *c)
{
    free(c->at);
    free(c->triangle);
    free(c->loop);
}

/* ---- solid ------------------------------------------------------------------------------------ */

/* The vertices that facets use, in the order of handles. */
static void number_vertices(const handles *h, domain_cage *out, int *number)
{
    out->at = bake_alloc((size_t)h->count + 1, 3 * sizeof *out->at);
    for (int i = 0; i < h->count; i++)
        number[i] = -1;
    for (int i = 0; i < 3 * h->facet_count; i++)
        if (h->facet[i / 3][i % 3] >= 0)
            number[h->facet[i / 3][i % 3]] = 0;
    for (int i = 0; i < h->count; i++) {
        if (number[i] < 0)
            continue;
        memcpy(out->at + 3 * (size_t)out->vertex_count, h->handle[i].from,
               sizeof h->handle[i].from);
        number[i] = out->vertex_count++;
    }
}

static int has_two_everywhere(const surface *s)
{
    tets_edge *list = tets_edges(s);
    int closed = 1;
    for (int i = 0, n; i < 3 * s->triangle_count && closed; i += n) {
        n = tets_edge_count(s, list, i);
        closed = n == 2;
    }
    free(list);
    return closed;
}

int domain_cage_solid(const handles *h, domain_cage *out)
{
    *out = (domain_cage){0};
    for (int i = 0; i < h->facet_count; i++)
        if (h->facet[i][2] < 0)
            return 0;
    if (h->facet_count < 4)
        return 0;
    int *number = bake_alloc((size_t)h->count + 1, sizeof *number);
    number_vertices(h, out, number);
    out->triangle = bake_alloc((size_t)h->facet_count, sizeof *out->triangle);
    for (int i = 0; i < 3 * h->facet_count; i++)
        out->triangle[i / 3][i % 3] = number[h->facet[i / 3][i % 3]];
    free(number);
    const surface s = {out->vertex_count, h->facet_count, out->at, (const int(*)[3])out->triangle};
    if (has_two_everywhere(&s))
        return 1;
    domain_cage_free(out);
    return 0;
}

/* ---- flat ------------------------------------------------------------------------------------- */

/* next[2 i], next[2 i + 1]: the neighbours of cage vertex i, or -1. 0: a vertex has more than two,
 * or one. */
static int join_edges(const handles *h, int *next)
{
    for (int i = 0; i < 2 * h->count; i++)
        next[i] = -1;
    for (int i = 0; i < h->facet_count; i++)
        for (int k = 0; k < 2; k++) {
            int from = h->facet[i][k], to = h->facet[i][1 - k];
            int *slot = next + 2 * (size_t)from;
            if (h->facet[i][2] >= 0 || from == to || slot[0] == to || slot[1] >= 0)
                return 0;
            slot[slot[0] >= 0] = to;
        }
    for (int i = 0; i < h->count; i++)
        if (next[2 * i] >= 0 && next[2 * i + 1] < 0)
            return 0;
    return h->facet_count > 0;
}

/* From a vertex around its loop; vertices that have been taken have no neighbours any more. */
static void take_loop(const handles *h, int first, int *next, domain_cage *out)
{
    int now = first, before = next[2 * (size_t)first + 1];
    while (next[2 * (size_t)now] >= 0) {
        int *slot = next + 2 * (size_t)now, after = slot[0] == before ? slot[1] : slot[0];
        memcpy(out->at + 2 * (size_t)out->vertex_count, h->handle[now].from, 2 * sizeof *out->at);
        out->vertex_count++;
        slot[0] = -1;
        before = now;
        now = after;
    }
    out->loop[++out->loop_count] = out->vertex_count;
}

int domain_cage_flat(const handles *h, domain_cage *out)
{
    int *next = bake_alloc(2 * (size_t)h->count + 2, sizeof *next);
    *out = (domain_cage){0};
    int closed = join_edges(h, next);
    if (closed) {
        out->at = bake_alloc((size_t)h->count, 2 * sizeof *out->at);
        out->loop = bake_alloc((size_t)h->count + 1, sizeof *out->loop);
        for (int i = 0; i < h->count; i++)
            if (next[2 * (size_t)i] >= 0)
                take_loop(h, i, next, out);
    }
    free(next);
    return closed;
}
