/* Halves the long edges of a surface, so that tetrahedra of the size asked for fit under it.
 * Source: own. TetGen would do it too, but then it wants good angles between all triangles as well,
 * and takes 20 times as many tetrahedra for a scanned animal.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "tets_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double tets_distance(const double *a, const double *b)
{
    return sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]) +
                (b[2] - a[2]) * (b[2] - a[2]));
}

surface tets_look(const tets_triangles *g)
{
    surface s = {g->vertex_count, g->triangle_count, g->at, (const int(*)[3])g->triangle};
    return s;
}

/* The edge between its corners, counted as 3 triangle + its first corner. */
static int slot(const tets_edge *e)
{
    return e->corner[1] % 3 == (e->corner[0] + 1) % 3 ? e->corner[0] : e->corner[1];
}

static int add_middle(tets_triangles *g, int a, int b)
{
    double *at = g->at + 3 * (size_t)g->vertex_count;
    for (int k = 0; k < 3; k++)
        at[k] = 0.5 * g->at[3 * (size_t)a + (size_t)k] + 0.5 * g->at[3 * (size_t)b + (size_t)k];
    return g->vertex_count++;
}

/* Adds the middle of every edge that is too long; middle[3 triangle + k] is that of the edge from
 * corner k to the next, or -1. Returns how many there are. */
static int add_middles(tets_triangles *g, double longest, int *middle)
{
    const surface s = tets_look(g);
    tets_edge *list = tets_edges(&s);
    int before = g->vertex_count;
    g->at = bake_grow(g->at, (size_t)before + 3 * (size_t)g->triangle_count, 3 * sizeof *g->at);
    for (int i = 0, n; i < 3 * s.triangle_count; i += n) {
        const double *a = g->at + 3 * (size_t)list[i].a, *b = g->at + 3 * (size_t)list[i].b;
        int added = tets_distance(a, b) > longest ? add_middle(g, list[i].a, list[i].b) : -1;
        n = tets_edge_count(&s, list, i);
        for (int j = i; j < i + n; j++)
            middle[slot(&list[j])] = added;
    }
    free(list);
    return g->vertex_count - before;
}

static void add_triangle(tets_triangles *g, int a, int b, int c)
{
    const int corner[3] = {a, b, c};
    memcpy(g->triangle[g->triangle_count++], corner, sizeof corner);
}

/* Corners c with edge middles m, turned so that one middle is m[0], and two are m[0] and m[1]. Two
 * middles leave a quadrangle, which is cut along its shorter diagonal. */
static void cut_triangle(tets_triangles *g, const int c[3], const int m[3])
{
    int added = (m[0] >= 0) + (m[1] >= 0) + (m[2] >= 0);
    if (added == 3) {
        add_triangle(g, c[0], m[0], m[2]);
        add_triangle(g, c[1], m[1], m[0]);
        add_triangle(g, c[2], m[2], m[1]);
        add_triangle(g, m[0], m[1], m[2]);
    } else if (added == 2) {
        const double *a = g->at + 3 * (size_t)c[0], *b = g->at + 3 * (size_t)m[1];
        const double *d = g->at + 3 * (size_t)m[0], *e = g->at + 3 * (size_t)c[2];
        int first = tets_distance(a, b) < tets_distance(d, e);
        add_triangle(g, m[0], c[1], m[1]);
        add_triangle(g, c[0], m[0], first ? m[1] : c[2]);
        add_triangle(g, first ? c[0] : m[0], m[1], c[2]);
    } else if (added == 1) {
        add_triangle(g, c[0], m[0], c[2]);
        add_triangle(g, m[0], c[1], c[2]);
    } else {
        add_triangle(g, c[0], c[1], c[2]);
    }
}

static void cut_triangles(tets_triangles *g, const int *middle)
{
    int count = g->triangle_count, (*old)[3] = g->triangle;
    g->triangle = bake_alloc((size_t)count, 4 * sizeof *g->triangle);
    g->triangle_count = 0;
    for (int i = 0; i < count; i++) {
        const int *m = middle + 3 * (size_t)i;
        int from = 0; /* what is cut, or not, comes first */
        while (from < 2 && !(m[from] >= 0 && m[(from + 2) % 3] < 0))
            from++;
        const int c[3] = {old[i][from], old[i][(from + 1) % 3], old[i][(from + 2) % 3]};
        const int turned[3] = {m[from], m[(from + 1) % 3], m[(from + 2) % 3]};
        cut_triangle(g, c, turned);
    }
    free(old);
}

void tets_triangles_free(tets_triangles *t)
{
    free(t->at);
    free(t->triangle);
}

int tets_split(const surface *s, double longest, int triangles_max, tets_triangles *out)
{
    int added = 1;
    out->vertex_count = s->vertex_count;
    out->triangle_count = s->triangle_count;
    out->at = bake_grow(NULL, (size_t)s->vertex_count, 3 * sizeof *out->at);
    out->triangle = bake_grow(NULL, (size_t)s->triangle_count, sizeof *out->triangle);
    memcpy(out->at, s->at, 3 * (size_t)s->vertex_count * sizeof *out->at);
    memcpy(out->triangle, s->triangle, (size_t)s->triangle_count * sizeof *out->triangle);
    while (added > 0 && out->triangle_count <= triangles_max) {
        int *middle = bake_alloc((size_t)out->triangle_count, 3 * sizeof *middle);
        added = add_middles(out, longest, middle);
        if (added > 0)
            cut_triangles(out, middle);
        free(middle);
    }
    if (added == 0)
        return 0;
    tets_triangles_free(out);
    return -1;
}
