/* Weights of handles on a domain, for tests: everything from edge lengths to the solver in one
 * call, and what the tests ask of the result.
 *   w  n x m  weights, a column a handle
 * SPDX-License-Identifier: MIT */
#ifndef WEIGHTS_PROBLEM_H
#define WEIGHTS_PROBLEM_H

#include "bounded.h"
#include "check.h"
#include "domain_shapes.h"

static const surface_origin weights_origin = {"test.yaml", "shape", 1};
static const domain_options weights_how = {.origin = &weights_origin};

typedef struct {
    domain d;
    double *length, *mass;
    sparse k, q;
    held fixed;
    int n, m;
    double *w;
} weights_problem;

/* Takes d. order: 1 harmonic, 2 biharmonic. */
static inline weights_problem weights_make(domain d, const handles *h, int order)
{
    bake_error error = {""};
    weights_problem p = {.d = d, .n = d.vertex_count, .m = h->count};
    p.length = bake_alloc(6 * (size_t)d.element_count, sizeof *p.length);
    p.mass = bake_alloc((size_t)p.n, sizeof *p.mass);
    p.w = bake_alloc((size_t)p.n * (size_t)p.m, sizeof *p.w);
    laplacian_lengths(&d, p.length);
    CHECK(laplacian_make(&d, p.length, MASS_VORONOI, &p.k, p.mass, &error) == 0);
    CHECK(laplacian_energy(&p.k, p.mass, order, &p.q, &error) == 0);
    CHECK(domain_hold(&d, h, &weights_how, &p.fixed, &error) == 0);
    if (error.text[0])
        puts(error.text);
    return p;
}

static inline void weights_solve(weights_problem *p, bounded_kind kind)
{
    bake_error error = {""};
    CHECK(bounded_solve(&p->q, &p->fixed, kind, NULL, p->w, NULL, &error) == 0);
    if (error.text[0])
        puts(error.text);
}

static inline void weights_normalise(weights_problem *p)
{
    bake_error error = {""};
    CHECK(bounded_normalise(p->w, p->n, p->m, &error) == 0);
}

static inline void weights_free(weights_problem *p)
{
    shape_free(&p->d);
    sparse_free(&p->k);
    sparse_free(&p->q);
    held_free(&p->fixed);
    free(p->length);
    free(p->mass);
    free(p->w);
}

static inline double *weights_of(const weights_problem *p, int which)
{
    return p->w + (size_t)which * (size_t)p->n;
}

static inline double *weights_copy(const weights_problem *p)
{
    size_t size = (size_t)p->n * (size_t)p->m;
    return memcpy(bake_alloc(size, sizeof *p->w), p->w, size * sizeof *p->w);
}

/* 1/2 w^T Q w of one handle, or of all: which -1. */
static inline double weights_energy(const weights_problem *p, const double *w, int which)
{
    double sum = 0, *y = bake_alloc((size_t)p->n, sizeof *y);
    for (int j = 0; j < p->m; j++) {
        if (which >= 0 && j != which)
            continue;
        sparse_multiply(&p->q, w + (size_t)j * (size_t)p->n, y);
        for (int v = 0; v < p->n; v++)
            sum += 0.5 * w[(size_t)j * (size_t)p->n + (size_t)v] * y[v];
    }
    free(y);
    return sum;
}

static inline double weights_largest_difference(const double *a, const double *b, int count)
{
    double most = 0;
    for (int i = 0; i < count; i++)
        most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

static inline handle weights_point(double x, double y, double z)
{
    return (handle){.name = "point", .kind = HANDLE_POINT, .from = {x, y, z}};
}

static inline handle weights_bone(double x0, double y0, double x1, double y1)
{
    return (handle){.name = "bone", .kind = HANDLE_BONE, .from = {x0, y0, 0}, .to = {x1, y1, 0}};
}

#endif
