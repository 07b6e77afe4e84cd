/* Modes of small and of dense systems, all of them at once, on LAPACK.
 *   K, M   n x n   symmetric, M positive definite, M = L L^T
 *   S      n x n   L^-1 K L^-T
 *   Y      n x n   S Y = Y Lambda, Phi = L^-T Y
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "modes_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The lowest out->count pairs of S into lambda and phi (as y), with |S y - lambda y|. S is n x n,
 * its lower triangle counts. Returns the largest |lambda| of all, or -1. */
static double decompose(const double *S, modes *out, bake_error *error)
{
    int n = out->n, count = out->count;
    size_t size = (size_t)n * (size_t)n;
    if (!isfinite(cblas_dasum(n * n, S, 1))) { /* LAPACK would complain on its own */
        return bake_fail(error, "the eigenvalues of %d x %d numbers: not all are finite", n, n);
    }
    double *Y = bake_alloc(size, sizeof *Y), *w = bake_alloc((size_t)n, sizeof *w), most;
    double *R = bake_alloc((size_t)n * (size_t)count, sizeof *R);
    memcpy(Y, S, size * sizeof *Y);
    int info = LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'L', n, Y, n, w);
    memcpy(out->lambda, w, (size_t)count * sizeof *w);
    memcpy(out->phi, Y, (size_t)n * (size_t)count * sizeof *Y);
    most = fmax(fabs(w[0]), fabs(w[n - 1]));
    cblas_dsymm(CblasColMajor, CblasLeft, CblasLower, n, count, 1, S, n, Y, n, 0, R, n);
    for (int j = 0; j < count; j++) {
        double *r = R + (size_t)j * (size_t)n;
        cblas_daxpy(n, -w[j], Y + (size_t)j * (size_t)n, 1, r, 1);
        out->residual[j] = cblas_dnrm2(n, r, 1);
    }
    free(Y);
    free(w);
    free(R);
    return info == 0 ? most
                     : bake_fail(error, "the eigenvalues of %d x %d numbers: LAPACK failed with %d",
                                 n, n, info);
}

int modes_dense_scaled(const sparse *S, int count, modes *out, bake_error *error)
{
    int n = S->n;
    double *full = bake_alloc((size_t)n * (size_t)n, sizeof *full);
    modes_room(out, n, count);
    for (int j = 0; j < n; j++) {
        for (int p = S->column[j]; p < S->column[j + 1]; p++) {
            full[(size_t)j * (size_t)n + (size_t)S->row[p]] = S->value[p];
        }
    }
    double most = decompose(full, out, error);
    free(full);
    return most < 0 ? -1 : 0;
}

/* S from K, L from M; both n x n. */
static int reduce(double *K, double *M, int n, bake_error *error)
{
    int info = LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', n, M, n);
    if (info != 0) {
        return bake_fail(error, "the mass matrix is not positive definite: row %d of %d", info, n);
    }
    info = LAPACKE_dsygst(LAPACK_COL_MAJOR, 1, 'L', n, K, n, M, n);
    return info == 0 ? 0 : bake_fail(error, "dividing by the mass matrix failed with %d", info);
}

int modes_dense(const double *K, const double *M, int n, modes *out, bake_error *error)
{
    size_t size = (size_t)n * (size_t)n;
    double *S = bake_alloc(size, sizeof *S), *L = bake_alloc(size, sizeof *L);
    memcpy(S, K, size * sizeof *S);
    memcpy(L, M, size * sizeof *L);
    modes_room(out, n, n);
    int err = reduce(S, L, n, error);
    double most = err < 0 ? -1 : decompose(S, out, error);
    if (most >= 0) {
        cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, n, n, 1, L, n,
                    out->phi, n);
        err = modes_finish(out, most, error);
    }
    if (most < 0 || err < 0) {
        modes_free(out);
        err = -1;
    }
    free(S);
    free(L);
    return err;
}
