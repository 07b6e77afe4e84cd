/* The constrained minimiser: regularisers, soft and free keys, periodic ends.
 * Source: Schulz 2013, 2.5.2, (2.31), (2.32); errata S2-S4. Own: the unknowns are the values and
 * velocities at the knots (C1 by construction) instead of 4 coefficients a segment, so the 8m - 10
 * system shrinks to 4m with band width 7 (11 for periodic ends), solved by LAPACK dgbsvx.
 *
 *   per node: w, v, multiplier of C2, multiplier of a hard acceleration
 *   E = sum over segments u^T Q u + 2 r^T u + const,  u = (w0, v0, w1, v1)
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_parts.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { W, V, C2, ACCELERATION, PER_NODE };

typedef struct {
    const bake_work *work;
    int periodic, nodes, size, band;
    double *matrix; /* column-major, 2 band + 1 rows */
    double *right;
    char *fixed; /* rows that read x = target instead of stationarity */
} kkt;

/* Periodic nodes are folded (0, last, 1, last - 1, ...), so that neighbours stay within two. */
static int unknown(const kkt *s, int knot, int what)
{
    int node = s->periodic ? knot % s->nodes : knot;
    if (s->periodic)
        node = 2 * node < s->nodes ? 2 * node : 2 * (s->nodes - node) - 1;
    return PER_NODE * node + what;
}

static void add(const kkt *s, int row, int column, double value)
{
    if (!s->fixed[row])
        s->matrix[s->band + row - column + column * (2 * s->band + 1)] += value;
}

static void add_right(const kkt *s, int row, double value)
{
    if (!s->fixed[row])
        s->right[row] += value;
}

static void segment_unknowns(const kkt *s, int k, int index[4])
{
    for (int i = 0; i < 4; i++)
        index[i] = unknown(s, k + i / 2, i & 1 ? V : W);
}

/* row . (u of segment k) = right, with its multiplier in unknown `m`; may be called twice with one
 * m for a condition that spans two segments. */
static void add_constraint(const kkt *s, int m, int k, const double row[4], double right)
{
    int index[4];
    segment_unknowns(s, k, index);
    for (int i = 0; i < 4; i++) {
        add(s, m, index[i], row[i]);
        add(s, index[i], m, row[i]);
    }
    add_right(s, m, right);
}

typedef struct {
    const bake_segment *segment;
    const bake_spline_problem *problem;
    double gram[5][5];
} gram_sum;

/* Integrand of E_reg for the four functions and the particular solution (index 4). */
static void gram_visit(void *context, double s, double weight)
{
    gram_sum *sum = context;
    const bake_spline_problem *p = sum->problem;
    double b[4][5], f[5];
    bake_segment_functions(sum->segment, s, b);
    for (int i = 0; i < 5; i++)
        f[i] = b[2][i] + 2.0 * p->mode.delta * b[1][i] + p->mode.lambda * b[0][i];
    f[4] += p->mode.g;
    for (int i = 0; i < 5; i++)
        for (int j = 0; j <= i; j++)
            sum->gram[i][j] +=
                weight * (f[i] * f[j] + p->alpha * b[0][i] * b[0][j] + p->beta * b[1][i] * b[1][j] +
                          p->gamma * b[2][i] * b[2][j]);
}

/* Coefficients (and the 1 of the particular solution) as functions of (w0, v0, w1, v1, 1). */
static void coefficient_map(const bake_part *part, const bake_segment *segment, double T[5][5])
{
    memset(T, 0, 25 * sizeof T[0][0]);
    for (int column = 0; column < 5; column++) {
        bake_part plain = *part;
        bake_segment unit = *segment;
        double u[4] = {0.0};
        if (column < 4) {
            u[column] = 1.0;
            plain.part[0] = plain.part[1] = 0.0;
        }
        const double w[2] = {u[0], u[2]}, v[2] = {u[1], u[3]};
        bake_part_coefficients(&plain, w, v, &unit);
        for (int i = 0; i < 4; i++)
            T[i][column] = unit.w[i];
    }
    T[4][4] = 1.0;
}

static void transform(double gram[5][5], double T[5][5], double out[5][5])
{
    double half[5][5] = {{0.0}};
    memset(out, 0, sizeof half);
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++)
            for (int k = 0; k < 5; k++)
                half[i][j] += (k <= i ? gram[i][k] : gram[k][i]) * T[k][j];
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++)
            for (int k = 0; k < 5; k++)
                out[i][j] += T[k][i] * half[k][j];
}

static void add_segment_energy(const kkt *s, int k)
{
    const bake_segment *segment = &s->work->segments[k];
    gram_sum sum = {.segment = segment, .problem = s->work->problem};
    double T[5][5], Q[5][5];
    int index[4];
    bake_segment_quadrature(segment, gram_visit, &sum);
    coefficient_map(&s->work->parts[k], segment, T);
    transform(sum.gram, T, Q);
    segment_unknowns(s, k, index);
    for (int i = 0; i < 4; i++) {
        add_right(s, index[i], -Q[i][4]);
        for (int j = 0; j < 4; j++)
            add(s, index[i], index[j], Q[i][j]);
    }
}

/* Acceleration at a knot, from the segment that starts there or, at the last, the one that ends. */
static const double *acceleration_row(const kkt *s, int knot, int *segment, double *shift)
{
    int last = knot == s->work->key_count - 1;
    *segment = last ? knot - 1 : knot;
    const bake_part *part = &s->work->parts[*segment];
    *shift = part->shift;
    return last ? part->right : part->left;
}

static void add_hard_acceleration(const kkt *s, int knot, double target)
{
    int k;
    double shift;
    const double *row = acceleration_row(s, knot, &k, &shift);
    int m = unknown(s, knot, ACCELERATION);
    s->fixed[m] = 0;
    s->matrix[s->band + m * (2 * s->band + 1)] = 0.0;
    add_constraint(s, m, k, row, target - shift);
}

static void add_soft_acceleration(const kkt *s, int knot, double target, double weight)
{
    int k, index[4];
    double shift;
    const double *row = acceleration_row(s, knot, &k, &shift);
    segment_unknowns(s, k, index);
    for (int i = 0; i < 4; i++) {
        add_right(s, index[i], weight * row[i] * (target - shift));
        for (int j = 0; j < 4; j++)
            add(s, index[i], index[j], weight * row[i] * row[j]);
    }
}

/* x = target in place of the row's stationarity; must come before anything is added to the row. */
static int fix(const kkt *s, int row, double target, double time, bake_error *error)
{
    if (s->fixed[row] && s->right[row] != target)
        return bake_fail(error, "the key at %.6g s is prescribed twice, as %.9g and as %.9g", time,
                         s->right[row], target);
    s->fixed[row] = 1;
    s->matrix[s->band + row * (2 * s->band + 1)] = 1.0;
    s->right[row] = target;
    return 0;
}

static int fix_hard(const kkt *s, bake_error *error)
{
    const bake_spline_problem *p = s->work->problem;
    const bake_key *keys = s->work->keys;
    int last = s->work->key_count - 1;
    for (int k = 0; k <= last; k++)
        for (int i = 0; i < 2; i++)
            if (keys[k].weight[i] < 0.0 &&
                fix(s, unknown(s, k, i == 0 ? W : V), keys[k].target[i], keys[k].time, error))
                return -1;
    for (int end = 0; end < 2; end++) {
        int k = end ? last : 0;
        if (p->end[end] == BAKE_END_VELOCITY &&
            fix(s, unknown(s, k, V), p->end_value[end], keys[k].time, error))
            return -1;
    }
    return 0;
}

/* One multiplier and one row per node: a second prescription must agree with the first. */
static int hard_acceleration(const kkt *s, int knot, double target, double *given,
                             bake_error *error)
{
    int m = unknown(s, knot, ACCELERATION);
    if (!s->fixed[m] && given[m] != target)
        return bake_fail(error, "the acceleration at %.6g s is prescribed twice, as %.9g and %.9g",
                         s->work->keys[knot].time, given[m], target);
    if (s->fixed[m])
        add_hard_acceleration(s, knot, target);
    given[m] = target;
    return 0;
}

static int add_accelerations(const kkt *s, bake_error *error)
{
    const bake_spline_problem *p = s->work->problem;
    int last = s->work->key_count - 1, failed = 0;
    double *given = bake_alloc((size_t)s->size, sizeof *given);
    for (int k = 0; k <= last && !failed; k++) {
        const bake_key *key = &s->work->keys[k];
        if (key->weight[2] < 0.0)
            failed = hard_acceleration(s, k, key->target[2], given, error);
        if (key->weight[2] > 0.0)
            add_soft_acceleration(s, k, key->target[2], key->weight[2]);
        int end = k != 0;
        if (!failed && (k == 0 || k == last) && p->end[end] == BAKE_END_ACCELERATION)
            failed = hard_acceleration(s, k, p->end_value[end], given, error);
    }
    free(given);
    return failed;
}

static void add_soft(const kkt *s)
{
    for (int k = 0; k < s->work->key_count; k++)
        for (int i = 0; i < 2; i++) {
            const bake_key *key = &s->work->keys[k];
            int row = unknown(s, k, i == 0 ? W : V);
            if (key->weight[i] <= 0.0)
                continue;
            add(s, row, row, key->weight[i]);
            add_right(s, row, key->weight[i] * key->target[i]);
        }
}

static void add_c2(const kkt *s)
{
    const bake_part *parts = s->work->parts;
    for (int knot = s->periodic ? 0 : 1; knot < s->work->key_count - 1; knot++) {
        int before = (knot ? knot : s->work->key_count - 1) - 1, m = unknown(s, knot, C2);
        double minus[4];
        for (int i = 0; i < 4; i++)
            minus[i] = -parts[knot].left[i];
        s->fixed[m] = 0;
        s->matrix[s->band + m * (2 * s->band + 1)] = 0.0;
        add_constraint(s, m, before, parts[before].right, -parts[before].shift);
        add_constraint(s, m, knot, minus, parts[knot].shift);
    }
}

static int build(const kkt *s, bake_error *error)
{
    for (int row = 0; row < s->size; row++)
        if (row % PER_NODE >= C2)
            fix(s, row, 0.0, 0.0, error);
    if (fix_hard(s, error))
        return -1;
    for (int k = 0; k < s->work->key_count - 1; k++)
        add_segment_energy(s, k);
    add_c2(s);
    add_soft(s);
    return add_accelerations(s, error);
}

/* Equilibrates, factorises, refines and estimates the condition; the solution replaces s->right. */
static int solve(const kkt *s, double *condition)
{
    lapack_int n = s->size, band = s->band;
    size_t count = (size_t)s->size;
    double *factor = bake_alloc(count * (size_t)(3 * s->band + 1) + 3 * count, sizeof *factor);
    double *x = factor + count * (size_t)(3 * s->band + 1), *rows = x + n, *columns = rows + n;
    double forward = 0.0, backward = 0.0, growth = 0.0;
    lapack_int *pivot = bake_alloc(count, sizeof *pivot);
    char scaled = 'N';
    *condition = 0.0;
    lapack_int info = LAPACKE_dgbsvx(
        LAPACK_COL_MAJOR, 'E', 'N', n, band, band, 1, s->matrix, 2 * band + 1, factor, 3 * band + 1,
        pivot, &scaled, rows, columns, s->right, n, x, n, condition, &forward, &backward, &growth);
    if (info == 0)
        memcpy(s->right, x, count * sizeof *x);
    free(factor);
    free(pivot);
    return info != 0; /* n + 1: singular to working precision */
}

static void take(const kkt *s, bake_work *work)
{
    for (int k = 0; k < work->key_count; k++) {
        work->w[k] = s->right[unknown(s, k, W)];
        work->v[k] = s->right[unknown(s, k, V)];
    }
    for (int k = 0; k < work->key_count - 1; k++)
        bake_part_coefficients(&work->parts[k], &work->w[k], &work->v[k], &work->segments[k]);
}

int bake_solve_energy(bake_work *work, bake_error *error)
{
    kkt s = {.work = work, .periodic = work->problem->end[0] == BAKE_END_PERIODIC};
    s.nodes = work->key_count - s.periodic;
    s.size = PER_NODE * s.nodes;
    /* neighbours lie one node apart, two when folded */
    s.band = PER_NODE * (s.periodic ? 2 : 1) + PER_NODE - 1;
    s.matrix = bake_alloc((size_t)s.size * (size_t)(2 * s.band + 1), sizeof *s.matrix);
    s.right = bake_alloc((size_t)s.size, sizeof *s.right);
    s.fixed = bake_alloc((size_t)s.size, 1);
    int failed = build(&s, error);
    if (!failed && solve(&s, &work->condition))
        failed = bake_fail_resonant(work,
                                    "these keys and ends do not determine the curve, or "
                                    "contradict each other",
                                    error);
    if (!failed)
        take(&s, work);
    free(s.matrix);
    free(s.right);
    free(s.fixed);
    return failed;
}
