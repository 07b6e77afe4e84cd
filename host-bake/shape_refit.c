/* Weights for stored bases.
 * Source: own; least squares, then for single frames reweighted towards the least largest distance
 * [Lawson 1961].
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Reweighting gains a third at most: a frame that is farther off is left alone. */
#define REWEIGHTS 8
#define HOPELESS  1.5
#define FLOOR     0.02

double shape_distance(const shape_affine *turn, const double d[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const double *a = turn ? &turn->A[3 * k] : NULL;
        double e = a ? a[0] * d[0] + a[1] * d[1] + a[2] * d[2] : d[k];
        sum += e * e;
    }
    return sqrt(sum);
}

static const shape_affine *turn_of(const shape_design *d, int f)
{
    return d->r->turn ? &d->r->turn[d->span.first + f] : NULL;
}

static double worst_of(const shape_design *d, int f, const double *e)
{
    double worst = 0;
    for (int i = 0; i < d->r->rows; i += 3) {
        worst = fmax(worst, shape_distance(turn_of(d, f), e + i));
    }
    return worst;
}

/* X += G^-1 Q^T E, E -= Q of that; nothing when the bases are not independent. */
static void least_squares(const shape_design *d, double *E, double *X)
{
    int rows = d->r->rows, k = d->used, n = d->span.count;
    double *G = bake_alloc((size_t)k * (size_t)k + 1, sizeof *G);
    double *Y = bake_alloc((size_t)k * (size_t)n + 1, sizeof *Y);
    cblas_dsyrk(CblasColMajor, CblasUpper, CblasTrans, k, rows, 1, d->Q, rows, 0, G, k);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, k, n, rows, 1, d->Q, rows, E, rows, 0, Y,
                k);
    if (LAPACKE_dposv(LAPACK_COL_MAJOR, 'U', k, n, G, k, Y, k) == 0) {
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, rows, n, k, -1, d->Q, rows, Y, k, 1,
                    E, rows);
        cblas_daxpy(k * n, 1, Y, 1, X, 1);
    }
    free(G);
    free(Y);
}

/* One frame under reweighting. seen: the bases and, behind them, the frame itself, through its turn;
 * scaled: the same under the weights. */
typedef struct {
    double *seen, *scaled, *weight, *root, *G, *x;
} lawson;

static void see(const shape_design *d, int f, const double *e, lawson *l)
{
    size_t rows = (size_t)d->r->rows;
    const shape_affine *turn = turn_of(d, f);
    memcpy(l->seen, d->Q, rows * (size_t)d->used * sizeof *e);
    memcpy(l->seen + rows * (size_t)d->used, e, rows * sizeof *e);
    for (size_t i = 0; turn && i < rows * ((size_t)d->used + 1); i += 3) {
        const double p[3] = {l->seen[i], l->seen[i + 1], l->seen[i + 2]};
        for (size_t c = 0; c < 3; c++) {
            l->seen[i + c] =
                turn->A[3 * c] * p[0] + turn->A[3 * c + 1] * p[1] + turn->A[3 * c + 2] * p[2];
        }
    }
    for (size_t i = 0; i < rows / 3; i++) {
        l->weight[i] = 1;
    }
}

/* x for the weights: the last column of G is the bases times the frame. */
static int solve(const shape_design *d, lawson *l)
{
    int k = d->used, rows = d->r->rows;
    for (int i = 0; i < rows; i++) {
        l->root[i] = sqrt(l->weight[i / 3]);
    }
    for (int j = 0; j <= k; j++) {
        const double *from = l->seen + (size_t)j * (size_t)rows;
        double *to = l->scaled + (size_t)j * (size_t)rows;
        for (int i = 0; i < rows; i++) {
            to[i] = l->root[i] * from[i];
        }
    }
    cblas_dsyrk(CblasColMajor, CblasUpper, CblasTrans, k + 1, rows, 1, l->scaled, rows, 0, l->G,
                k + 1);
    cblas_dcopy(k, l->G + (size_t)k * (size_t)(k + 1), 1, l->x, 1);
    return LAPACKE_dposv(LAPACK_COL_MAJOR, 'U', k, 1, l->G, k + 1, l->x, k) == 0;
}

/* Moves weights to where it is worst. left: room for a frame. */
static double reweigh(const shape_design *d, lawson *l, double *left)
{
    int rows = d->r->rows;
    double worst = 0;
    memcpy(left, l->seen + (size_t)rows * (size_t)d->used, (size_t)rows * sizeof *left);
    cblas_dgemv(CblasColMajor, CblasNoTrans, rows, d->used, -1, l->seen, rows, l->x, 1, 1, left, 1);
    for (int i = 0; i < rows; i += 3) {
        worst = fmax(worst, shape_distance(NULL, left + i));
    }
    for (int i = 0; i < rows && worst > 0; i += 3) {
        l->weight[i / 3] *= FLOOR + shape_distance(NULL, left + i) / worst;
    }
    return worst;
}

/* Corrects one frame that is off by `worst`; returns how far it is off then. */
static double settle(const shape_design *d, int f, double worst, double *e, double *x)
{
    size_t rows = (size_t)d->r->rows, k = (size_t)d->used;
    double *best = bake_alloc(k, sizeof *best), *left = bake_alloc(rows, sizeof *left);
    lawson l = {.seen = bake_alloc(rows * (k + 1), sizeof *l.seen),
                .scaled = bake_alloc(rows * (k + 1), sizeof *l.scaled),
                .weight = bake_alloc(rows / 3, sizeof *l.weight),
                .root = bake_alloc(rows, sizeof *l.root),
                .G = bake_alloc((k + 1) * (k + 1), sizeof *l.G),
                .x = bake_alloc(k, sizeof *l.x)};
    see(d, f, e, &l);
    for (int round = 0; round < REWEIGHTS && worst > d->limit && solve(d, &l); round++) {
        double off = reweigh(d, &l, left);
        if (off < worst) {
            worst = off;
            memcpy(best, l.x, k * sizeof *best);
        }
    }
    cblas_dgemv(CblasColMajor, CblasNoTrans, d->r->rows, d->used, -1, d->Q, d->r->rows, best, 1, 1,
                e, 1);
    cblas_daxpy(d->used, 1, best, 1, x, 1);
    free(best);
    free(left);
    free(l.seen);
    free(l.scaled);
    free(l.weight);
    free(l.root);
    free(l.G);
    free(l.x);
    return worst;
}

/* The worst frames first: one that stays beyond the limit ends it. */
static double settle_all(const shape_design *d, double *E, double *X, double *off)
{
    for (int i = 0; i < d->span.count; i++) {
        int f = (int)cblas_idamax(d->span.count, off, 1);
        double before = off[f];
        if (before <= d->limit) {
            return before;
        }
        off[f] = settle(d, f, before, E + (size_t)d->r->rows * (size_t)f,
                        X + (size_t)d->used * (size_t)f);
        if (off[f] > d->limit) {
            break;
        }
    }
    return off[cblas_idamax(d->span.count, off, 1)];
}

double shape_refit(const shape_design *d, double *E, double *X)
{
    double *off = bake_alloc((size_t)d->span.count, sizeof *off), worst = 0;
    if (d->used > 0) {
        least_squares(d, E, X);
    }
    for (int f = 0; f < d->span.count; f++) {
        off[f] = worst_of(d, f, E + (size_t)d->r->rows * (size_t)f);
        worst = fmax(worst, off[f]);
    }
    if (d->used > 0 && worst > d->limit && worst <= HOPELESS * d->limit) {
        worst = settle_all(d, E, X, off);
    }
    free(off);
    return worst;
}
