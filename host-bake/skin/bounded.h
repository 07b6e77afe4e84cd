/* Bounded biharmonic weights: for every handle the quadratic program
 *   min 1/2 w^T Q w,  w = held values on held vertices,  0 <= w <= 1
 * with one Q for all. ADMM on one factor of Q + rho diag(Q) for all handles at once finds most of the
 * bounds that are met; a primal-dual active set then makes each handle's weights exact.
 * Source: Jacobson 2013, 4.3 (4.2)-(4.8), 2.2.3; the solver is own.
 *
 *   Q  n x n, lower triangle     W  n x m, column by column
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BOUNDED_H
#define BAKE_BOUNDED_H

#include "laplacian.h"

/* The optimality of one handle's weights: everything relative to diag(Q). With g = Q w and d the
 * diagonal of the free block:
 *   stationarity  largest |g_i| / d_i where 0 < w_i < 1
 *   dual          largest wrong sign: -g_i / d_i where w_i = 0, g_i / d_i where w_i = 1
 *   bounds        largest way of w outside 0 .. 1 */
typedef struct {
    double energy; /* 1/2 w^T Q w */
    double stationarity, dual, bounds;
    int low, high; /* vertices at 0 and at 1 that are not held */
    int factors;   /* factorisations that it took */
} bounded_report;

typedef enum {
    BOUNDED_SEPARATE, /* each handle alone; weights divided by their sums afterwards [4.3.4] */
    BOUNDED_COUPLED,  /* sum to 1 as a constraint [4.5]: one problem of all handles */
    BOUNDED_FREE /* no bounds: biharmonic (or harmonic) weights, which sum to 1 by themselves */
} bounded_kind;

/* Weights to a KKT residual of 1e-6 and better: every weight within 1e-4 of the exact minimiser. Of a
 * handle that does not get there: an error that names it (`name`: handle_count, or NULL). SEPARATE:
 * weights are as solved; bounded_normalise divides. report: handle_count, or NULL. COUPLED: `low` and
 * residuals are of the coupled problem with its multipliers for the sums. */
int bounded_solve(const sparse *q, const held *held, bounded_kind kind, const char *const *name,
                  double *w, bounded_report *report, bake_error *error);

/* w_j / sum of w: fails, naming the vertex, where the sum is below 1e-3. */
int bounded_normalise(double *w, int vertex_count, int handle_count, bake_error *error);

#endif
