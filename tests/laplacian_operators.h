/* Stiffness and masses of a domain in one call, for tests.
 * SPDX-License-Identifier: MIT */
#ifndef LAPLACIAN_OPERATORS_H
#define LAPLACIAN_OPERATORS_H

#include "check.h"
#include "domain_shapes.h"
#include "laplacian.h"

typedef struct {
    domain d;
    double *length, *mass;
    sparse k;
} operators;

/* Takes d. */
static inline operators make(domain d, mass_kind kind)
{
    bake_error error;
    operators o = {.d = d};
    o.length = bake_alloc(6 * (size_t)d.element_count, sizeof *o.length);
    o.mass = bake_alloc((size_t)d.vertex_count, sizeof *o.mass);
    laplacian_lengths(&d, o.length);
    int err = laplacian_make(&d, o.length, kind, &o.k, o.mass, &error);
    if (err < 0)
        puts(error.text);
    CHECK(err == 0);
    return o;
}

static inline void release(operators *o)
{
    shape_free(&o->d);
    sparse_free(&o->k);
    free(o->length);
    free(o->mass);
}

static inline double *dense(const sparse *s)
{
    double *a = bake_alloc((size_t)s->n * (size_t)s->n, sizeof *a);
    for (int j = 0; j < s->n; j++)
        for (int p = s->column[j]; p < s->column[j + 1]; p++)
            a[s->row[p] * s->n + j] = a[j * s->n + s->row[p]] = s->value[p];
    return a;
}

#endif
