/* Bounded biharmonic endpoint weights: one quadratic program a bone, on the part of the shape
 * that the bone moves.
 * Source: Jacobson 2013, 6.2.3, 6.3 (the part where w > 1e-7); what is held and how values go on
 * outside that part is own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "ends_parts.h"
#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* [6.3] */
#define MOVED 1e-7

/* ---- what is held ---------------------------------------------------------------------------- */

static double distance(const double *a, const double *b)
{
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(vector_dot(d, d));
}

/* Of the held vertices of bone `k`, the one nearest to `at`; -1: there is none. */
static int nearest(const domain *d, const held *fixed, int k, const double *at)
{
    int best = -1;
    double least = HUGE_VAL;
    for (int i = 0; i < fixed->count; i++) {
        double far = distance(d->at + 3 * (size_t)fixed->vertex[i], at);
        if (fixed->value[(size_t)i * (size_t)fixed->handle_count + (size_t)k] > 0 && far < least) {
            least = far;
            best = fixed->vertex[i];
        }
    }
    return best;
}

/* The longest edge at a vertex: an end no farther away lies in an element around it. */
static double reach(const domain *d, int vertex)
{
    double longest = 0;
    for (int i = 0; i < 4 * d->element_count; i++)
        if (d->element[i / 4][i % 4] == vertex)
            for (int a = 0; a <= d->dimension; a++)
                longest = fmax(longest, distance(d->at + 3 * (size_t)d->element[i / 4][a],
                                                 d->at + 3 * (size_t)vertex));
    return longest;
}

/* Where the bone's end is outside the shape, what projects there instead: the sample nearest to
 * it is not yet the end. */
static double end_value(const domain *d, const handle *bone, int vertex, double end)
{
    const double *at = d->at + 3 * (size_t)vertex, *want = end > 0 ? bone->to : bone->from;
    return distance(at, want) <= reach(d, vertex) ? end : ends_project(bone, at);
}

static int is_flat(const domain *d)
{
    for (int v = 0; v < d->vertex_count; v++)
        if (d->at[3 * (size_t)v + 2] != 0)
            return 0;
    return d->dimension == 2;
}

/* value[v]: what vertex v has to have, or -1. Flat: linear along the bone, else 0 and 1 at its ends
 * alone.                                                                                 [6.2.2] */
static int hold_bone(const ends_problem *p, int k, const held *fixed, double *value,
                     bake_error *error)
{
    const handle *bone = &p->h->handle[k];
    int from = nearest(p->d, fixed, k, bone->from), to = nearest(p->d, fixed, k, bone->to);
    if (from < 0 || from == to)
        return bake_fail(error,
                         "%s:%d: bone '%s' holds %s of the shape: it needs two for endpoint "
                         "weights, use a smaller 'cell'",
                         p->how->origin->scene, bone->line, bone->name,
                         from < 0 ? "no vertex" : "one vertex");
    for (int v = 0; v < p->d->vertex_count; v++)
        value[v] = -1;
    for (int i = 0; i < fixed->count && is_flat(p->d); i++)
        if (fixed->value[(size_t)i * (size_t)fixed->handle_count + (size_t)k] > 0)
            value[fixed->vertex[i]] = ends_project(bone, p->d->at + 3 * (size_t)fixed->vertex[i]);
    value[from] = end_value(p->d, bone, from, 0);
    value[to] = end_value(p->d, bone, to, 1);
    return 0;
}

/* ---- the part that moves --------------------------------------------------------------------- */

typedef struct {
    domain d;
    int *of;     /* vertex of the whole -> of the part, or -1 */
    int *vertex; /* of the part -> of the whole */
} part;

static int root(int *parent, int v)
{
    while (parent[v] != v) {
        parent[v] = parent[parent[v]]; /* halves the path: it ends */
        v = parent[v];
    }
    return v;
}

/* Elements with a vertex that the bone moves, or holds: so that every such vertex has all of its
 * elements. */
static int moves(const domain *d, int e, const double *w, const double *value)
{
    for (int a = 0; a <= d->dimension; a++)
        if (w[d->element[e][a]] > MOVED || value[d->element[e][a]] >= 0)
            return 1;
    return 0;
}

/* Marks the elements that move and hang together with a held vertex: elsewhere any constant has no
 * energy. */
static char *choose(const domain *d, const double *w, const double *value)
{
    int n = d->vertex_count, *parent = bake_alloc((size_t)n, sizeof *parent);
    char *keep = bake_alloc((size_t)d->element_count, 1), *holds = bake_alloc((size_t)n, 1);
    for (int v = 0; v < n; v++)
        parent[v] = v;
    for (int e = 0; e < d->element_count; e++) {
        keep[e] = (char)moves(d, e, w, value);
        for (int a = 1; a <= d->dimension && keep[e]; a++)
            parent[root(parent, d->element[e][a])] = root(parent, d->element[e][0]);
    }
    for (int v = 0; v < n; v++)
        if (value[v] >= 0)
            holds[root(parent, v)] = 1;
    for (int e = 0; e < d->element_count; e++)
        keep[e] = keep[e] && holds[root(parent, d->element[e][0])];
    free(parent);
    free(holds);
    return keep;
}

static void add_vertex(const domain *d, int v, part *p)
{
    if (p->of[v] >= 0)
        return;
    int at = p->d.vertex_count++;
    p->of[v] = at;
    p->vertex[at] = v;
    memcpy(p->d.at + 3 * (size_t)at, d->at + 3 * (size_t)v, 3 * sizeof *d->at);
    if (d->lift)
        memcpy(p->d.lift + 3 * (size_t)at, d->lift + 3 * (size_t)v, 3 * sizeof *d->lift);
}

static part make_part(const domain *d, const char *keep)
{
    size_t n = (size_t)d->vertex_count;
    part p = {.d = {.dimension = d->dimension}};
    p.of = bake_alloc(n, sizeof *p.of);
    p.vertex = bake_alloc(n, sizeof *p.vertex);
    p.d.at = bake_alloc(3 * n, sizeof *p.d.at);
    p.d.lift = d->lift ? bake_alloc(3 * n, sizeof *p.d.lift) : NULL;
    p.d.element = bake_alloc((size_t)d->element_count, sizeof *p.d.element);
    memset(p.of, -1, n * sizeof *p.of);
    for (int e = 0; e < d->element_count; e++) {
        if (!keep[e])
            continue;
        int *corner = p.d.element[p.d.element_count++];
        corner[3] = -1;
        for (int a = 0; a <= d->dimension; a++) {
            add_vertex(d, d->element[e][a], &p);
            corner[a] = p.of[d->element[e][a]];
        }
    }
    return p;
}

static void part_free(part *p)
{
    free(p->d.at);
    free(p->d.lift);
    free(p->d.element);
    free(p->of);
    free(p->vertex);
}

/* ---- the program ----------------------------------------------------------------------------- */

static held hold_part(const part *p, const double *value)
{
    size_t n = (size_t)p->d.vertex_count;
    held h = {0, 1, bake_alloc(n, sizeof *h.vertex), bake_alloc(n, sizeof *h.value)};
    for (int i = 0; i < p->d.vertex_count; i++)
        if (value[p->vertex[i]] >= 0) {
            h.vertex[h.count] = i;
            h.value[h.count++] = value[p->vertex[i]];
        }
    return h;
}

static int solve_part(const part *p, const double *value, const char *name, double *e,
                      bake_error *error)
{
    double *length = bake_alloc((size_t)p->d.element_count * 6, sizeof *length);
    double *mass = bake_alloc((size_t)p->d.vertex_count, sizeof *mass);
    sparse k = {0}, q = {0};
    held h = hold_part(p, value);
    laplacian_lengths(&p->d, length);
    int err = laplacian_make(&p->d, length, MASS_VORONOI, &k, mass, error);
    err = err < 0 ? err : laplacian_energy(&k, mass, 2, &q, error);
    err = err < 0 ? err : bounded_solve(&q, &h, BOUNDED_SEPARATE, &name, e, NULL, error);
    free(h.vertex);
    free(h.value);
    sparse_free(&q);
    sparse_free(&k);
    free(mass);
    free(length);
    return err;
}

/* One layer of vertices without a value gets the mean of the neighbours that have one. sum,
 * count: n zeros, in and out. 0: there was no such vertex. */
static int grow(const domain *d, char *known, double *e, double *sum, int *count)
{
    int added = 0;
    for (int i = 0; i < d->element_count; i++)
        for (int a = 0; a <= d->dimension; a++)
            for (int b = 0; b <= d->dimension; b++) {
                int from = d->element[i][a], to = d->element[i][b];
                sum[to] += known[from] && !known[to] ? e[from] : 0;
                count[to] += known[from] && !known[to];
            }
    for (int v = 0; v < d->vertex_count; v++)
        if (count[v] > 0) {
            e[v] = sum[v] / count[v];
            sum[v] = count[v] = 0;
            known[v] = 1;
            added = 1;
        }
    return added;
}

/* Where w is 0, e does not matter to a pose; it does to whoever paints w anew. */
static void extend(const domain *d, const handle *bone, const part *p, double *e)
{
    size_t n = (size_t)d->vertex_count;
    char *known = bake_alloc(n, 1);
    double *sum = bake_alloc(n, sizeof *sum);
    int *count = bake_alloc(n, sizeof *count);
    for (int i = 0; i < p->d.vertex_count; i++)
        known[p->vertex[i]] = 1;
    while (grow(d, known, e, sum, count)) /* every turn adds a vertex: at most n */
        ;
    for (size_t v = 0; v < n; v++)
        if (!known[v])
            e[v] = ends_project(bone, d->at + 3 * v);
    free(count);
    free(sum);
    free(known);
}

static int solve_bone(const ends_problem *p, int k, const held *fixed, bake_error *error)
{
    const domain *d = p->d;
    size_t n = (size_t)d->vertex_count;
    double *e = p->e + (size_t)k * n, *value = bake_alloc(n, sizeof *value);
    if (hold_bone(p, k, fixed, value, error) < 0) {
        free(value);
        return -1;
    }
    char *keep = choose(d, p->w + (size_t)k * n, value);
    part moved = make_part(d, keep);
    double *solved = bake_alloc((size_t)moved.d.vertex_count, sizeof *solved);
    int err = solve_part(&moved, value, p->h->handle[k].name, solved, error);
    for (int i = 0; i < moved.d.vertex_count && err == 0; i++)
        e[moved.vertex[i]] = fmin(fmax(solved[i], 0), 1);
    if (err == 0)
        extend(d, &p->h->handle[k], &moved, e);
    free(solved);
    part_free(&moved);
    free(keep);
    free(value);
    return err;
}

int ends_bounded(const ends_problem *p, bake_error *error)
{
    held fixed = {0};
    if (domain_hold(p->d, p->h, p->how, &fixed, error) < 0)
        return -1;
    int err = 0;
    for (int k = 0; k < p->h->count && err == 0; k++)
        if (p->h->handle[k].kind == HANDLE_BONE)
            err = solve_bone(p, k, &fixed, error);
    held_free(&fixed);
    return err;
}
