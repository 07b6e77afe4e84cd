/* What all mode solvers do at the end: which eigenvalues are 0, signs, residuals.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "modes_parts.h"

#include <cblas.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Above this relative residual a mode is an error. */
#define RESIDUAL_MOST 1e-8

double modes_bound(const sparse *S)
{
    double *sum = bake_alloc((size_t)S->n, sizeof *sum), most = 0;
    for (int j = 0; j < S->n; j++) {
        for (int p = S->column[j]; p < S->column[j + 1]; p++) {
            sum[j] += fabs(S->value[p]);
            sum[S->row[p]] += S->row[p] == j ? 0 : fabs(S->value[p]);
        }
    }
    for (int j = 0; j < S->n; j++) {
        most = fmax(most, sum[j]);
    }
    free(sum);
    return most;
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* What is below 64 eps of the largest eigenvalue is rounding: products with K are not more exact.
 * But of a fine, stiff mesh with soft modes these may be in there as well; then the widest gap in
 * it parts them from the rigid modes, which are as near to 0 as rounding lets them be. Returns the
 * largest |lambda| that is 0. floor: below it, gaps mean nothing. */
static double widest_gap(const double *lambda, int count, double noise, double floor)
{
    double *size = bake_alloc((size_t)count, sizeof *size), widest = 0, cut = -1;
    for (int i = 0; i < count; i++) {
        size[i] = fabs(lambda[i]);
    }
    qsort(size, (size_t)count, sizeof *size, ascending);
    for (int i = 0; i < count && size[i] <= noise; i++) {
        double above = i + 1 < count ? size[i + 1] : HUGE_VAL;
        double gap = fmax(above, floor) / fmax(size[i], floor);
        if (gap >= widest) {
            widest = gap;
            cut = size[i];
        }
    }
    free(size);
    return cut;
}

static void fix_sign(double *phi, int n)
{
    double most = 0;
    int at = 0;
    for (int i = 0; i < n; i++) {
        most = fmax(most, fabs(phi[i]));
    }
    /* a millionth less is a tie: parts that mirror each other differ by rounding */
    while (at < n - 1 && fabs(phi[at]) < (1 - 1e-6) * most) {
        at++;
    }
    if (phi[at] < 0) {
        cblas_dscal(n, -1, phi, 1);
    }
}

void modes_room(modes *out, int n, int count)
{
    memset(out, 0, sizeof *out);
    out->n = n;
    out->count = count;
    out->lambda = bake_alloc((size_t)count, sizeof *out->lambda);
    out->residual = bake_alloc((size_t)count, sizeof *out->residual);
    out->phi = bake_alloc((size_t)n * (size_t)count, sizeof *out->phi);
}

/* Returns the lambda of the softest mode that is not rigid; of rigid ones alone, the bound. */
static double classify(modes *out, double bound, double noise)
{
    double cut = widest_gap(out->lambda, out->count, noise, DBL_EPSILON * bound / 16 + DBL_MIN);
    double first = HUGE_VAL;
    out->negative = out->rigid = 0;
    for (int i = 0; i < out->count; i++) {
        if (fabs(out->lambda[i]) <= cut) {
            out->residual[i] = hypot(out->residual[i], out->lambda[i]);
            out->lambda[i] = 0;
            out->rigid++;
        } else {
            out->negative += out->lambda[i] < 0;
            first = fmin(first, fabs(out->lambda[i]));
        }
    }
    return first < HUGE_VAL ? first : bound;
}

int modes_finish(modes *out, double bound, bake_error *error)
{
    double noise = 64 * DBL_EPSILON * bound, first = classify(out, bound, noise);
    out->noise = fmin(noise, 1e-3 * first);
    for (int i = 0; i < out->count; i++) {
        double scale = fmax(fabs(out->lambda[i]), first), absolute = out->residual[i];
        fix_sign(out->phi + (size_t)i * (size_t)out->n, out->n);
        out->residual[i] = absolute > 0 ? absolute / scale : 0;
        if (!(out->residual[i] <= RESIDUAL_MOST || absolute <= noise)) {
            return bake_fail(
                error,
                "mode %d (%.6g Hz) has a residual of %.1e, which should be below %.0e: "
                "are there slivers in the mesh?",
                i + 1, sqrt(fabs(out->lambda[i])) / 6.283185307179586, out->residual[i],
                RESIDUAL_MOST);
        }
    }
    return 0;
}

void modes_free(modes *m)
{
    free(m->lambda);
    free(m->phi);
    free(m->residual);
    memset(m, 0, sizeof *m);
}
