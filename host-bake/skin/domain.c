/* Domains as arrays: surfaces as they are, and points that a domain carries.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void domain_free(domain *d)
{
    free(d->at);
    free(d->element);
    free(d->lift);
    free(d->vertex_of);
    *d = (domain){0};
}

int domain_surface(const surface *s, domain *out, bake_error *error)
{
    *out = (domain){.dimension = 2};
    for (int i = 0; i < 3 * s->triangle_count; i++)
        if (s->triangle[i / 3][i % 3] < 0 || s->triangle[i / 3][i % 3] >= s->vertex_count)
            return bake_fail(error,
                             "triangle %d of a surface has a corner %d, and there are %d "
                             "vertices; export the mesh again",
                             i / 3, s->triangle[i / 3][i % 3], s->vertex_count);
    for (size_t i = 0; i < 3 * (size_t)s->vertex_count; i++)
        if (!isfinite(s->at[i]))
            return bake_fail(error, "vertex %zu of a surface is nowhere; export the mesh again",
                             i / 3);
    out->vertex_count = s->vertex_count;
    out->element_count = s->triangle_count;
    out->at = bake_alloc((size_t)s->vertex_count + 1, 3 * sizeof *out->at);
    memcpy(out->at, s->at, 3 * (size_t)s->vertex_count * sizeof *out->at);
    out->element = bake_alloc((size_t)s->triangle_count + 1, sizeof *out->element);
    for (int i = 0; i < s->triangle_count; i++) {
        memcpy(out->element[i], s->triangle[i], sizeof s->triangle[i]);
        out->element[i][3] = -1;
    }
    return 0;
}

/* ---- points ----------------------------------------------------------------------------------- */

/* Of a weight: rounding. */
#define OUTSIDE -1e-9

/* Outside, a tetrahedron's weights are those of its linear map going on. Weights of a skin are
 * means: those of its nearest point. */
static void move_inside(const domain *d, const double *p, embedding *e)
{
    double best = HUGE_VAL, weight[4] = {0.0, 0.0, 0.0, 0.0};
    for (int skip = 0; skip < 4; skip++) {
        const double *at[3];
        double on[3];
        for (int k = 0; k < 3; k++)
            at[k] = d->at + 3 * (size_t)e->vertex[k + (k >= skip)];
        double square = tets_weigh_triangle(at, p, on);
        for (int k = 0; k < 4 && square < best; k++)
            weight[k] = k == skip ? 0.0 : on[k - (k > skip)];
        best = fmin(best, square);
    }
    memcpy(e->weight, weight, sizeof weight);
}

static void keep_means(const domain *d, const double *p, embedding *e)
{
    double least = 0.0, sum = 0.0;
    for (int k = 0; k < 4; k++)
        least = fmin(least, e->weight[k]);
    if (least < OUTSIDE && d->dimension == 3)
        move_inside(d, p, e);
    for (int k = 0; k < 4; k++) {
        e->weight[k] = fmax(e->weight[k], 0.0);
        sum += e->weight[k];
    }
    for (int k = 0; k < 4; k++)
        e->weight[k] /= sum;
}

int domain_embed(const domain *d, const double *at, int count, embedding *out, double *far,
                 bake_error *error)
{
    const body b = {.kind = d->dimension == 3 ? BODY_SOLID : BODY_SHELL,
                    .vertex_count = d->vertex_count,
                    .element_count = d->element_count,
                    .rest = d->at,
                    .element = d->element};
    if (tets_embed(&b, at, count, out, far, error))
        return -1;
    for (int i = 0; i < count; i++)
        keep_means(d, at + 3 * (size_t)i, &out[i]);
    return 0;
}

/* ---- nearest vertices ------------------------------------------------------------------------- */

static void box_of_vertex(const void *what, int i, double box[2][3])
{
    const domain_finder *f = what;
    memcpy(box[0], f->at + 3 * (size_t)i, sizeof box[0]);
    memcpy(box[1], f->at + 3 * (size_t)i, sizeof box[1]);
}

typedef struct {
    const double *at, *p;
    int best;
    double square;
} nearing;

/* Of vertices at one distance the first: the grid's order does not matter. */
static double try_vertex(void *what, int i)
{
    nearing *n = what;
    const double *a = n->at + 3 * (size_t)i;
    double square = 0.0;
    for (int k = 0; k < 3; k++)
        square += (a[k] - n->p[k]) * (a[k] - n->p[k]);
    if (n->best < 0 || square < n->square || (square == n->square && i < n->best)) {
        n->best = i;
        n->square = square;
    }
    return n->square;
}

void domain_finder_make(domain_finder *f, const double *at, int count)
{
    f->at = at;
    tets_grid_make(&f->grid, count, box_of_vertex, f);
}

void domain_finder_free(domain_finder *f)
{
    tets_grid_free(&f->grid);
}

int domain_nearest(const domain_finder *f, const double *p)
{
    nearing n = {.at = f->at, .p = p, .best = -1};
    tets_grid_near(&f->grid, p, try_vertex, &n);
    return n.best;
}

void domain_link(domain *out, const double *at, int count)
{
    domain_finder f;
    domain_finder_make(&f, out->at, out->vertex_count);
    free(out->vertex_of);
    out->from_count = count;
    out->vertex_of = bake_alloc((size_t)count + 1, sizeof *out->vertex_of);
    for (int i = 0; i < count; i++)
        out->vertex_of[i] = domain_nearest(&f, at + 3 * (size_t)i);
    domain_finder_free(&f);
}
