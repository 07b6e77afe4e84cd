/* Closes holes of a broken surface, so that a wrap does not go in through them: the edges that have an
 * odd number of triangles are taken apart into loops, and each loop is filled.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An edge of a hole, as one of its ends has it. with: 1, its triangle goes this way, -1, the other
 * way. */
typedef struct {
    int to, edge, with;
} way;

typedef struct {
    tets_triangles *t;
    int *start; /* of each vertex, in `ways` */
    way *ways;
    char *used; /* of each edge */
    int *place; /* of each vertex in the path, or -1 */
    int length;
    way *path; /* path[i].to: its vertices; .with: of the way there */
    int loops;
} closer;

/* ---- edges ------------------------------------------------------------------------------------ */

static void add_way(closer *c, const tets_edge *e, int edge, int turned)
{
    int along = e->corner[1] % 3 == (e->corner[0] + 1) % 3 ? 1 : -1;
    int from = turned ? e->b : e->a;
    c->ways[c->start[from]++] = (way){turned ? e->a : e->b, edge, turned ? -along : along};
}

/* Goes over the edges that have an odd number of triangles: counts them in start[vertex + 1], or,
 * the second time, fills `ways`. Returns how many there are. */
static int spread(closer *c, const surface *s, const tets_edge *list)
{
    int edges = 0;
    for (int i = 0, n; i < 3 * s->triangle_count; i += n) {
        n = tets_edge_count(s, list, i);
        if (n % 2 == 0 || list[i].a == list[i].b)
            continue;
        for (int turned = 0; turned < 2; turned++) {
            if (c->ways)
                add_way(c, &list[i], edges, turned);
            else
                c->start[(turned ? list[i].b : list[i].a) + 1]++;
        }
        edges++;
    }
    return edges;
}

static int find_ways(closer *c)
{
    const surface s = tets_look(c->t);
    tets_edge *list = tets_edges(&s);
    int n = s.vertex_count;
    c->start = bake_alloc((size_t)n + 2, sizeof *c->start);
    int edges = spread(c, &s, list);
    for (int i = 0; i < n; i++)
        c->start[i + 1] += c->start[i];
    c->ways = bake_alloc(2 * (size_t)edges + 1, sizeof *c->ways);
    spread(c, &s, list);
    for (int i = n; i > 0; i--) /* filling has moved each start to the next one */
        c->start[i] = c->start[i - 1];
    c->start[0] = 0;
    free(list);
    return edges;
}

/* ---- loops ------------------------------------------------------------------------------------ */

static void add_triangle(tets_triangles *t, int p, int q, int r, int with)
{
    const int corner[3] = {with > 0 ? q : p, with > 0 ? p : q, r};
    memcpy(t->triangle[t->triangle_count++], corner, sizeof corner);
}

static int add_middle(tets_triangles *t, const way *loop, int length)
{
    double *p = t->at + 3 * (size_t)t->vertex_count;
    memset(p, 0, 3 * sizeof *p);
    for (int i = 0; i < length; i++)
        for (int k = 0; k < 3; k++)
            p[k] += t->at[3 * (size_t)loop[i].to + (size_t)k] / length;
    return t->vertex_count++;
}

/* A triangle is what was missing there; others are filled from their middle, turned like most of
 * their neighbours. with: of the way back to the first. */
static void fill_loop(closer *c, const way *loop, int length, int with)
{
    for (int i = 1; i < length; i++)
        with += loop[i].with;
    c->loops++;
    if (length == 3) {
        add_triangle(c->t, loop[0].to, loop[1].to, loop[2].to, with);
        return;
    }
    int middle = add_middle(c->t, loop, length);
    for (int i = 0; i < length; i++)
        add_triangle(c->t, loop[i].to, loop[(i + 1) % length].to, middle, with);
}

/* Of the ways on from the end of the path, the one that leads nearest to where the path came from:
 * around the smallest hole. NULL: there is none. */
static const way *choose(const closer *c)
{
    int v = c->path[c->length - 1].to;
    const double *from = c->t->at + 3 * (size_t)c->path[c->length > 1 ? c->length - 2 : 0].to;
    const way *best = NULL;
    double nearest = HUGE_VAL;
    for (int i = c->start[v]; i < c->start[v + 1]; i++) {
        double distance = tets_distance(from, c->t->at + 3 * (size_t)c->ways[i].to);
        if (c->used[c->ways[i].edge] || distance >= nearest)
            continue;
        nearest = distance;
        best = &c->ways[i];
    }
    return best;
}

/* Walks on until a vertex comes again: what lies between is a loop. Every vertex has an even
 * number of ways, so that the walk ends where it began. */
static void walk(closer *c, int first)
{
    const way *next;
    c->path[0] = (way){first, -1, 0};
    c->place[first] = 0;
    c->length = 1;
    while ((next = choose(c)) != NULL) {
        int back = c->place[next->to];
        c->used[next->edge] = 1;
        if (back < 0) {
            c->place[next->to] = c->length;
            c->path[c->length++] = *next;
            continue;
        }
        fill_loop(c, c->path + back, c->length - back, next->with);
        for (int i = back + 1; i < c->length; i++)
            c->place[c->path[i].to] = -1;
        c->length = back + 1;
    }
    c->place[first] = -1;
}

int domain_close(tets_triangles *t)
{
    closer c = {.t = t};
    int vertices = t->vertex_count, edges = find_ways(&c);
    c.used = bake_alloc((size_t)edges + 1, 1);
    c.place = bake_alloc((size_t)vertices + 1, sizeof *c.place);
    c.path = bake_alloc((size_t)edges + 2, sizeof *c.path);
    /* Every loop has three edges or more: a vertex for each at most, and a triangle an edge. */
    t->at = bake_grow(t->at, (size_t)(vertices + edges) + 1, 3 * sizeof *t->at);
    t->triangle =
        bake_grow(t->triangle, (size_t)(t->triangle_count + edges) + 1, sizeof *t->triangle);
    for (int i = 0; i < vertices; i++)
        c.place[i] = -1;
    for (int i = 0; i < vertices; i++)
        if (c.start[i] < c.start[i + 1])
            walk(&c, i);
    free(c.start);
    free(c.ways);
    free(c.used);
    free(c.place);
    free(c.path);
    return c.loops;
}
