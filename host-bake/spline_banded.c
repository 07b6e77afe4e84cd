/* The direct path: all values hard, one condition at each end.
 * Source: Schulz 2013, 2.5.3. Own: the 4(m-1) coefficients are reduced to the m knot velocities, so
 * the system is tridiagonal (LAPACK dgttrf, dgttrs); for prescribed end velocities it is the
 * Hessian of the energy, hence positive definite.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_parts.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>

typedef struct {
    double *below, *diagonal, *above, *right;
} tridiagonal;

/* C2 at an inner knot: acceleration from the left equals acceleration from the right. */
static void inner_row(const bake_work *work, int k, const tridiagonal *m)
{
    const bake_part *l = &work->parts[k - 1], *r = &work->parts[k];
    const double *w = &work->w[k - 1];
    m->below[k - 1] = l->right[1];
    m->diagonal[k] = l->right[3] - r->left[1];
    m->above[k] = -r->left[3];
    m->right[k] = r->left[0] * w[1] + r->left[2] * w[2] + r->shift -
                  (l->right[0] * w[0] + l->right[2] * w[1] + l->shift);
}

/* Velocity, acceleration, or the natural condition w'' + 2 delta w' + lambda w + g = 0. */
static void end_row(const bake_work *work, int side, const tridiagonal *m)
{
    int last = work->key_count - 1, k = side ? last : 0;
    const bake_spline_problem *p = work->problem;
    const bake_part *part = &work->parts[side ? last - 1 : 0];
    const double *row = side ? part->right : part->left, *w = &work->w[side ? last - 1 : 0];
    double *neighbour = side ? &m->below[last - 1] : &m->above[0];
    m->diagonal[k] = 1.0;
    *neighbour = 0.0;
    m->right[k] = p->end_value[side];
    if (p->end[side] == BAKE_END_VELOCITY)
        return;
    m->diagonal[k] = row[side ? 3 : 1];
    *neighbour = row[side ? 1 : 3];
    m->right[k] = -(row[0] * w[0] + row[2] * w[1] + part->shift);
    if (p->end[side] == BAKE_END_ACCELERATION) {
        m->right[k] += p->end_value[side];
        return;
    }
    m->diagonal[k] += 2.0 * p->mode.delta;
    m->right[k] -= p->mode.lambda * work->w[k] + p->mode.g;
}

/* Rows of norm 1, so that pivoting and the condition estimate do not depend on units. */
static double scale_rows(const tridiagonal *m, int n)
{
    double columns = 0.0;
    for (int k = 0; k < n; k++) {
        double sum = fabs(m->diagonal[k]) + (k ? fabs(m->below[k - 1]) : 0.0) +
                     (k < n - 1 ? fabs(m->above[k]) : 0.0);
        double factor = sum > 0.0 ? 1.0 / sum : 1.0;
        m->diagonal[k] *= factor;
        m->right[k] *= factor;
        if (k)
            m->below[k - 1] *= factor;
        if (k < n - 1)
            m->above[k] *= factor;
    }
    for (int k = 0; k < n; k++) {
        double sum = fabs(m->diagonal[k]) + (k ? fabs(m->above[k - 1]) : 0.0) +
                     (k < n - 1 ? fabs(m->below[k]) : 0.0);
        columns = fmax(columns, sum);
    }
    return columns;
}

/* Factorises, estimates the condition and solves in m->right; space: 3 n doubles, 2 n integers. */
static int factor_and_solve(const tridiagonal *m, int n, double *space, lapack_int *pivot,
                            double *condition)
{
    double norm = scale_rows(m, n);
    lapack_int size = n;
    *condition = 0.0;
    if (LAPACKE_dgttrf_work(size, m->below, m->diagonal, m->above, space, pivot) != 0)
        return -1;
    LAPACKE_dgtcon_work('1', size, m->below, m->diagonal, m->above, space, pivot, norm, condition,
                        space + n, pivot + n);
    LAPACKE_dgttrs_work(LAPACK_COL_MAJOR, 'N', size, 1, m->below, m->diagonal, m->above, space,
                        pivot, m->right, size);
    return 0;
}

int bake_solve_banded(bake_work *work, bake_error *error)
{
    int n = work->key_count;
    size_t count = (size_t)n;
    double *memory = bake_alloc(7 * count, sizeof *memory);
    lapack_int *pivot = bake_alloc(2 * count, sizeof *pivot);
    tridiagonal m = {memory, memory + n, memory + 2 * n, work->v};
    for (int k = 0; k < n; k++)
        work->w[k] = work->keys[k].target[0];
    end_row(work, 0, &m);
    for (int k = 1; k < n - 1; k++)
        inner_row(work, k, &m);
    end_row(work, 1, &m);
    int failed = factor_and_solve(&m, n, memory + 3 * n, pivot, &work->condition);
    free(memory);
    free(pivot);
    if (failed)
        return bake_fail_resonant(work, "the end conditions leave the curve undetermined", error);
    for (int k = 0; k < n - 1; k++)
        bake_part_coefficients(&work->parts[k], &work->w[k], &work->v[k], &work->segments[k]);
    return 0;
}
