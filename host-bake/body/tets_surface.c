/* What is wrong with a surface that is to be filled, said where it is. How its triangles hang
 * together is found here, what they do in space by CGAL.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"
#include "tets_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Faults of a surface's connections; those of the bridge come before. */
enum { MANY_SIDED = BRIDGE_NESTED + 1, HOLES, LOOSE, TOUCHING, FAULTS };

typedef struct {
    const char *one, *more, *which, *todo;
} fault_words;

static const fault_words words[FAULTS] = {
    [BRIDGE_FLAT] = {"a triangle without area", "triangles without area", "first",
                     "merge their corners (in Blender: Mesh > Clean Up > Degenerate Dissolve)"},
    [BRIDGE_ONE_SIDED] = {"a one-sided part", "one-sided parts", "first",
                          "a body needs an inside and an outside"},
    [BRIDGE_CROSSING] = {"a pair of triangles that cross or touch",
                         "pairs of triangles that cross or touch", "first",
                         "move what overlaps apart, or unite it (in Blender: Boolean or Remesh)"},
    [BRIDGE_NESTED] = {"a closed part inside another", "closed parts inside others", "first",
                       "remove it: a body has no cavities"},
    [MANY_SIDED] = {"an edge with more than two triangles", "edges with more than two triangles",
                    "first", "remove inner walls and doubled faces"},
    [HOLES] = {"a hole", "holes", "largest",
               "close it (in Blender: Mesh > Clean Up > Fill Holes, Merge by Distance)"},
    [LOOSE] = {"a vertex without triangles", "vertices without triangles", "first",
               "delete it (in Blender: Mesh > Clean Up > Delete Loose)"},
    [TOUCHING] = {"a vertex in which parts touch", "vertices in which parts touch", "first",
                  "give each part a vertex of its own, some way off"},
};

static int fail_fault(const surface_origin *o, int kind, const bridge_fault *f, bake_error *error)
{
    const fault_words *w = &words[kind];
    char what[200];
    if (f->count == 1) {
        snprintf(what, sizeof what, "%s", w->one);
    } else {
        snprintf(what, sizeof what, "%d %s, the %s", f->count, w->more, w->which);
    }
    return bake_fail(error, "%s:%d: mesh %s has %s at (%.6g, %.6g, %.6g); %s", o->scene, o->line,
                     o->name, what, f->at[0], f->at[1], f->at[2], w->todo);
}

/* ---- numbers ---------------------------------------------------------------------------------- */

static int check_numbers(const surface *s, const surface_origin *o, bake_error *error)
{
    for (int i = 0; i < s->vertex_count; i++) {
        const double *p = s->at + 3 * (size_t)i;
        /* Products of three differences must be finite as well. */
        for (int k = 0; k < 3; k++)
            if (!(fabs(p[k]) <= 1e100))
                return bake_fail(error,
                                 "%s:%d: mesh %s: vertex %d is at (%g, %g, %g), which is nowhere; "
                                 "export the mesh again",
                                 o->scene, o->line, o->name, i, p[0], p[1], p[2]);
    }
    for (int i = 0; i < s->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            if (s->triangle[i][k] < 0 || s->triangle[i][k] >= s->vertex_count)
                return bake_fail(error,
                                 "%s:%d: mesh %s: triangle %d has a corner %d, and there are %d "
                                 "vertices; export the mesh again",
                                 o->scene, o->line, o->name, i, s->triangle[i][k], s->vertex_count);
    if (s->vertex_count < 4 || s->triangle_count < 4) {
        const double none[3] = {0.0, 0.0, 0.0}, *p = s->vertex_count > 0 ? s->at : none;
        return bake_fail(error,
                         "%s:%d: mesh %s has %d vertices and %d triangles, at (%.6g, %.6g, %.6g); "
                         "a body needs a closed surface, of at least 4 and 4",
                         o->scene, o->line, o->name, s->vertex_count, s->triangle_count, p[0], p[1],
                         p[2]);
    }
    return 0;
}

/* ---- connections ------------------------------------------------------------------------------ */

static int order_edges(const void *left, const void *right)
{
    const tets_edge *l = left, *r = right;
    int by = l->a != r->a ? (l->a > r->a) - (l->a < r->a) : (l->b > r->b) - (l->b < r->b);
    return by ? by : (l->corner[0] > r->corner[0]) - (l->corner[0] < r->corner[0]);
}

tets_edge *tets_edges(const surface *s)
{
    tets_edge *list = bake_alloc((size_t)s->triangle_count, 3 * sizeof *list);
    for (int i = 0; i < s->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            int next = (k + 1) % 3, a = s->triangle[i][k], b = s->triangle[i][next];
            tets_edge e = {a, b, {3 * i + k, 3 * i + next}};
            tets_edge turned = {b, a, {3 * i + next, 3 * i + k}};
            list[3 * i + k] = a < b ? e : turned;
        }
    qsort(list, 3 * (size_t)s->triangle_count, sizeof *list, order_edges);
    return list;
}

int tets_edge_count(const surface *s, const tets_edge *list, int from)
{
    int to = from + 1;
    while (to < 3 * s->triangle_count && list[to].a == list[from].a && list[to].b == list[from].b)
        to++;
    return to - from;
}

static void middle(const surface *s, const tets_edge *e, double at[3])
{
    const double *a = s->at + 3 * (size_t)e->a, *b = s->at + 3 * (size_t)e->b;
    for (int k = 0; k < 3; k++)
        at[k] = 0.5 * (a[k] + b[k]);
}

static int find_many_sided(const surface *s, const tets_edge *list, bridge_fault *out)
{
    out->count = 0;
    for (int i = 0, n; i < 3 * s->triangle_count; i += n) {
        n = tets_edge_count(s, list, i);
        if (n > 2 && out->count++ == 0)
            middle(s, &list[i], out->at);
    }
    return out->count;
}

/* Sets of what is joined; halving paths keeps them flat. */
static int root_of(int *parent, int i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/* The smaller number stays, so that results do not depend on the order. */
static void join(int *parent, int a, int b)
{
    int p = root_of(parent, a), q = root_of(parent, b);
    parent[p > q ? p : q] = p < q ? p : q;
}

static int *new_sets(int count)
{
    int *parent = bake_alloc((size_t)count, sizeof *parent);
    for (int i = 0; i < count; i++)
        parent[i] = i;
    return parent;
}

/* The edges around a hole, or around several that touch. */
typedef struct {
    int edges;
    double length, sum[3];
} rim;

static void add_to_rim(const surface *s, const tets_edge *e, rim *r)
{
    double at[3];
    middle(s, e, at);
    r->edges++;
    r->length += tets_distance(s->at + 3 * (size_t)e->a, s->at + 3 * (size_t)e->b);
    for (int k = 0; k < 3; k++)
        r->sum[k] += at[k];
}

static int find_holes(const surface *s, const tets_edge *list, bridge_fault *out)
{
    int *hole = new_sets(s->vertex_count), largest = -1;
    rim *rims = bake_alloc((size_t)s->vertex_count, sizeof *rims);
    for (int i = 0, n; i < 3 * s->triangle_count; i += n) {
        n = tets_edge_count(s, list, i);
        if (n == 1)
            join(hole, list[i].a, list[i].b);
    }
    for (int i = 0, n; i < 3 * s->triangle_count; i += n) {
        n = tets_edge_count(s, list, i);
        if (n == 1)
            add_to_rim(s, &list[i], &rims[root_of(hole, list[i].a)]);
    }
    out->count = 0;
    for (int i = 0; i < s->vertex_count; i++) {
        out->count += rims[i].edges > 0;
        if (rims[i].edges > 0 && (largest < 0 || rims[i].length > rims[largest].length))
            largest = i;
    }
    for (int k = 0; k < 3 && largest >= 0; k++)
        out->at[k] = rims[largest].sum[k] / rims[largest].edges;
    free(rims);
    free(hole);
    return out->count;
}

static int find_loose(const surface *s, bridge_fault *out)
{
    char *used = bake_alloc((size_t)s->vertex_count, 1);
    for (int i = 0; i < s->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            used[s->triangle[i][k]] = 1;
    out->count = 0;
    for (int i = 0; i < s->vertex_count; i++)
        if (!used[i] && out->count++ == 0)
            memcpy(out->at, s->at + 3 * (size_t)i, sizeof out->at);
    free(used);
    return out->count;
}

/* Every edge has two triangles: across it the corners at each of its ends belong to one fan. A
 * vertex with corners of two fans is one too many. */
static int find_touching(const surface *s, const tets_edge *list, bridge_fault *out)
{
    int corners = 3 * s->triangle_count;
    int *fan = new_sets(corners), *seen = bake_alloc((size_t)s->vertex_count, sizeof *seen);
    for (int i = 0; i < corners; i += 2)
        for (int k = 0; k < 2; k++)
            join(fan, list[i].corner[k], list[i + 1].corner[k]);
    out->count = 0;
    for (int i = 0; i < corners; i++) {
        int vertex = s->triangle[i / 3][i % 3];
        if (root_of(fan, i) == i && seen[vertex]++ == 1 && out->count++ == 0)
            memcpy(out->at, s->at + 3 * (size_t)vertex, sizeof out->at);
    }
    free(seen);
    free(fan);
    return out->count;
}

static int check_connections(const surface *s, const surface_origin *o, bake_error *error)
{
    bridge_fault fault;
    tets_edge *list = tets_edges(s);
    int kind = find_many_sided(s, list, &fault) ? MANY_SIDED
               : find_holes(s, list, &fault)    ? HOLES
               : find_loose(s, &fault)          ? LOOSE
               : find_touching(s, list, &fault) ? TOUCHING
                                                : BRIDGE_GOOD;
    free(list);
    return kind == BRIDGE_GOOD ? 0 : fail_fault(o, kind, &fault, error);
}

/* ---- all of it -------------------------------------------------------------------------------- */

static int fail_cgal(const surface_origin *o, const bridge_message *message, bake_error *error)
{
    return bake_fail(error,
                     "%s:%d: mesh %s cannot be checked: CGAL: %s; simplify the mesh, or make it "
                     "anew with a remesher",
                     o->scene, o->line, o->name, message->text);
}

int tets_check(const surface *s, const surface_origin *origin, double *volume, bake_error *error)
{
    const bridge_surface b = {s->vertex_count, s->triangle_count, s->at, s->triangle};
    bridge_message message = {""};
    bridge_fault fault;
    if (check_numbers(s, origin, error))
        return -1;
    int kind = bridge_check_flat(&b, &fault, &message);
    if (kind == BRIDGE_GOOD && check_connections(s, origin, error))
        return -1;
    if (kind == BRIDGE_GOOD)
        kind = bridge_check_solid(&b, volume, &fault, &message);
    if (kind < 0)
        return fail_cgal(origin, &message, error);
    return kind == BRIDGE_GOOD ? 0 : fail_fault(origin, kind, &fault, error);
}
