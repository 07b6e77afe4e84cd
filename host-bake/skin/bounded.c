/* Bounded biharmonic weights: what can be solved, who solves it, and whether it is solved.
 * Source: Jacobson 2013, 4.3 (4.2)-(4.8), 2.2.3.
 *
 *   W  n x m   of all vertices, column by column
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_parts.h"

#include <cblas.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What a residual may be, relative to the diagonal: a promise of bounded.h. */
#define RESIDUAL 1e-6

typedef struct {
    const bounded_system *s;
    double *w; /* n x m, free vertices */
    int *factors, *result;
} polishing;

static const char *name_of(const char *const *name, int j, char room[32])
{
    snprintf(room, 32, "%d", j + 1);
    return name ? name[j] : room;
}

/* ---- optimality ------------------------------------------------------------------------------- */

/* The multiplier of a row's sum: the mean of g over its weights that are not 0. */
static void multipliers(const bounded_system *s, const double *w, const double *g, double *lambda)
{
    size_t n = (size_t)s->n;
    for (size_t i = 0; i < n; i++) {
        double sum = 0;
        int count = 0;
        for (size_t j = 0; j < (size_t)s->m; j++) {
            if (w[n * j + i] > 0) {
                sum += g[n * j + i];
                count++;
            }
        }
        lambda[i] = count ? sum / count : 0;
    }
}

/* One handle; lambda: NULL unless rows sum to 1. */
static void measure(const bounded_system *s, const double *w, const double *g, const double *lambda,
                    bounded_report *r)
{
    for (int i = 0; i < s->n; i++) {
        double force = (g[i] - (lambda ? lambda[i] : 0)) / s->d[i];
        r->bounds = fmax(r->bounds, fmax(-w[i], w[i] - 1));
        if (w[i] <= 0) {
            r->dual = fmax(r->dual, -force);
            r->low++;
        } else if (w[i] >= 1 && !lambda) {
            r->dual = fmax(r->dual, force);
            r->high++;
        } else {
            r->stationarity = fmax(r->stationarity, fabs(force));
            r->high += w[i] >= 1;
        }
    }
}

/* Without bounds every vertex is free. */
static void measure_free(const bounded_system *s, const double *w, const double *g,
                         bounded_report *r)
{
    for (int i = 0; i < s->n; i++) {
        r->bounds = fmax(r->bounds, fmax(-w[i], w[i] - 1));
        r->stationarity = fmax(r->stationarity, fabs(g[i]) / s->d[i]);
    }
}

void bounded_judge(const bounded_system *s, bounded_kind kind, const double *w, bounded_report *r)
{
    size_t n = (size_t)s->n, m = (size_t)s->m;
    double *g = bake_alloc(n * m, sizeof *g);
    double *lambda = kind == BOUNDED_COUPLED ? bake_alloc(n, sizeof *lambda) : NULL;
    for (size_t j = 0; j < m; j++) {
        bounded_gradient(s, s->b + n * j, w + n * j, g + n * j);
    }
    if (lambda) {
        multipliers(s, w, g, lambda);
    }
    for (size_t j = 0; j < m; j++) {
        if (kind == BOUNDED_FREE) {
            measure_free(s, w + n * j, g + n * j, &r[j]);
        } else {
            measure(s, w + n * j, g + n * j, lambda, &r[j]);
        }
    }
    free(lambda);
    free(g);
}

static int check(const bounded_report *r, int m, bounded_kind kind, const char *const *name,
                 bake_error *error)
{
    char room[32];
    for (int j = 0; j < m; j++) {
        double outside = kind == BOUNDED_FREE ? 0 : r[j].bounds;
        if (!(r[j].stationarity <= RESIDUAL && r[j].dual <= RESIDUAL && outside <= RESIDUAL)) {
            return bake_fail(error,
                             "the weights of handle %s are not exact: residuals %.1e (free), %.1e "
                             "(bounds), expected %.0e at most; elements without volume or very "
                             "unequal ones do that: mesh anew with a larger cell",
                             name_of(name, j, room), r[j].stationarity, r[j].dual, RESIDUAL);
        }
    }
    return 0;
}

/* ---- solutions -------------------------------------------------------------------------------- */

int bounded_no_factor(const bounded_system *s, int result, bake_error *error)
{
    return result > 0 ? bake_fail(error,
                                  "the energy of %d free vertices is not positive definite: "
                                  "are there elements without volume?",
                                  s->n)
                      : bake_fail(error,
                                  "the factor of %d free vertices does not fit into memory: "
                                  "use fewer elements",
                                  s->n);
}

static void run_polish(void *context, int item, bounded_desk *desk)
{
    polishing *p = context;
    size_t n = (size_t)p->s->n, j = (size_t)item;
    p->result[j] = bounded_polish(desk, p->s, p->s->b + n * j, p->w + n * j, &p->factors[j]);
}

static int solve_alone(bounded_system *s, const char *const *name, double *w, bounded_report *r,
                       bake_error *error)
{
    int *memory = bake_alloc(2 * (size_t)s->m, sizeof *memory), err;
    polishing p = {s, w, memory, memory + s->m};
    const bounded_work work = {run_polish, &p};
    char room[32];
    err = bounded_approach(s, 0, w, error);
    if (err == 0) {
        bounded_each(s, s->m, &work);
    }
    for (int j = 0; j < s->m && err == 0; j++) {
        r[j].factors = p.factors[j];
        if (p.result[j] > 0) {
            err = bake_fail(error,
                            "the bounds of the weights of handle %s were not found: very "
                            "unequal elements do that; mesh anew with a larger cell",
                            name_of(name, j, room));
        } else if (p.result[j] < 0) {
            err = bounded_no_factor(s, -1, error);
        }
    }
    free(memory);
    return err;
}

static int solve_coupled(bounded_system *s, double *w, bounded_report *r, bake_error *error)
{
    r[0].factors = 2; /* of Q, and of what the iterations solve with */
    return bounded_approach(s, 1, w, error);
}

/* -Q^-1 b, and once more for what is left over */
static int solve_free(bounded_system *s, double *w, bounded_report *r, bake_error *error)
{
    size_t n = (size_t)s->n, m = (size_t)s->m;
    double *x = bake_alloc(n * m, sizeof *x);
    bounded_factor f;
    int result = bounded_factor_make(s->desk, s, NULL, NULL, &f);
    for (int k = 0; k < 2 && result == 0; k++) {
        for (size_t j = 0; j < m; j++) {
            bounded_gradient(s, s->b + n * j, w + n * j, x + n * j);
        }
        result = bounded_factor_solve(s->desk, &f, x, s->m);
        for (size_t i = 0; i < n * m; i++) {
            w[i] -= x[i];
        }
    }
    for (size_t j = 0; j < m; j++) {
        r[j].factors = j == 0;
    }
    bounded_factor_free(s->desk, &f);
    free(x);
    return result == 0 ? 0 : bounded_no_factor(s, result, error);
}

/* ---- all vertices ----------------------------------------------------------------------------- */

static int check_handles(const held *hold, const char *const *name, bake_error *error)
{
    char room[32];
    for (int j = 0; j < hold->handle_count; j++) {
        double most = 0;
        for (int k = 0; k < hold->count; k++) {
            double v = hold->value[(size_t)k * (size_t)hold->handle_count + (size_t)j];
            if (!(v >= 0 && v <= 1)) {
                return bake_fail(error, "handle %s holds vertex %d at %g, expected 0 to 1",
                                 name_of(name, j, room), hold->vertex[k], v);
            }
            most = fmax(most, v);
        }
        if (most == 0) {
            return bake_fail(error,
                             "handle %s holds no vertex: it is outside the mesh, or another "
                             "handle is in the same place",
                             name_of(name, j, room));
        }
    }
    return 0;
}

/* From free vertices to all; energies. */
static void expand(const sparse *q, const held *hold, const bounded_system *s, const double *free_w,
                   double *w, bounded_report *r)
{
    size_t n = (size_t)q->n, m = (size_t)s->m;
    double *g = bake_alloc(n, sizeof *g);
    for (size_t j = 0; j < m; j++) {
        for (int k = 0; k < hold->count; k++) {
            w[n * j + (size_t)hold->vertex[k]] = hold->value[(size_t)k * m + j];
        }
        for (int i = 0; i < s->n; i++) {
            w[n * j + (size_t)s->vertex[i]] = free_w[(size_t)s->n * j + (size_t)i];
        }
        sparse_multiply(q, w + n * j, g);
        r[j].energy = 0.5 * cblas_ddot(q->n, w + n * j, 1, g, 1);
    }
    free(g);
}

int bounded_solve(const sparse *q, const held *hold, bounded_kind kind, const char *const *name,
                  double *w, bounded_report *report, bake_error *error)
{
    bounded_system s;
    openblas_set_num_threads(1); /* threads are above; sums of several have no fixed order */
    if (check_handles(hold, name, error) < 0 || bounded_system_make(q, hold, &s, error) < 0) {
        return -1;
    }
    double *x = bake_alloc((size_t)s.n * (size_t)s.m, sizeof *x);
    bounded_report *r = bake_alloc((size_t)s.m, sizeof *r);
    int err = 0;
    if (s.n > 0) {
        err = kind == BOUNDED_FREE       ? solve_free(&s, x, r, error)
              : kind == BOUNDED_SEPARATE ? solve_alone(&s, name, x, r, error)
                                         : solve_coupled(&s, x, r, error);
    }
    if (err == 0) {
        bounded_judge(&s, kind, x, r);
        expand(q, hold, &s, x, w, r);
        if (report) {
            memcpy(report, r, (size_t)s.m * sizeof *r);
        }
        err = check(r, s.m, kind, name, error);
    }
    free(x);
    free(r);
    bounded_system_free(&s);
    return err;
}

int bounded_normalise(double *w, int vertex_count, int handle_count, bake_error *error)
{
    size_t n = (size_t)vertex_count, m = (size_t)handle_count;
    for (size_t i = 0; i < n; i++) {
        double sum = 0;
        for (size_t j = 0; j < m; j++) {
            sum += w[n * j + i];
        }
        if (!(sum >= 1e-3)) {
            return bake_fail(error,
                             "the weights of vertex %zu sum to %.1e, expected 1e-3 at least: no "
                             "handle reaches it; put one nearer",
                             i, sum);
        }
        for (size_t j = 0; j < m; j++) {
            w[n * j + i] /= sum;
        }
    }
    return 0;
}
