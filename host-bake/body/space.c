/* Reduced spaces: an orthonormal basis, in the mass product, of poses and modes.
 * Source: Schulz 2013, 2.7.2, algorithm 2. Own: the SVD through Gram matrices, in two passes.
 *   S   n x count       vectors, column-major
 *   R   n x n           M = R^T R: the roots of the masses, or the Cholesky factor of a dense M
 *   W   n x k           R S, columns of length 1
 *   X   n x d           orthonormal, spans what W spans; V = R^-1 X
 * A Gram matrix W^T W is off by a few eps |W|^2, so it tells singular values from noise above some
 * sqrt(eps) = 1.5e-8 of the largest, and columns divided by a singular value sigma are orthonormal
 * to eps / sigma^2 only. Hence pass 1 takes what is above 1e-4 (orthonormal to 1e-8); pass 2 does
 * the same to the rest, which has been rotated out of the first and is 1e-4 at most: its own Gram
 * matrix resolves 1e-4 sqrt(eps) = 1e-12, far below the 1e-7 where directions are dropped.
 * Cholesky's factor of the Gram matrix of all, which differs from 1 by about 1e-8, then brings them
 * to eps.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "space.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the largest singular value: where directions are dropped, and where pass 1 ends. */
#define DROPPED 1e-7
#define FIRST   1e-4

/* Vectors are differences of poses: shorter than this share of the origin, they are rounding. */
#define ROUNDING (16 * DBL_EPSILON)

#define ORTHONORMAL 1e-12

static size_t at(int rows, int column)
{
    return (size_t)rows * (size_t)column;
}

/* ---- root of the mass matrix ------------------------------------------------------------------- */

/* n roots, or the upper factor of a dense M. */
static int mass_root(const space *s, double **R, bake_error *error)
{
    size_t n = (size_t)s->n, size = s->M ? n * n : n;
    int failed = 0;
    *R = bake_alloc(size, sizeof **R);
    memcpy(*R, s->M ? s->M : s->mass, size * sizeof **R);
    if (s->M)
        failed = LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'U', s->n, *R, s->n);
    for (int i = 0; !s->M && i < s->n && !failed; i++) {
        failed = (*R)[i] > 0 ? 0 : i + 1;
        (*R)[i] = sqrt((*R)[i]);
    }
    if (failed) {
        free(*R);
        return bake_fail(error,
                         "the masses are not positive (coordinate %d of %d): a motion "
                         "without inertia has no frequency",
                         failed - 1, s->n);
    }
    return 0;
}

/* x = R x */
static void to_root(const space *s, const double *R, double *x)
{
    if (s->M)
        cblas_dtrmv(CblasColMajor, CblasUpper, CblasNoTrans, CblasNonUnit, s->n, R, s->n, x, 1);
    for (int i = 0; !s->M && i < s->n; i++)
        x[i] *= R[i];
}

/* x = R^-1 x */
static void from_root(const space *s, const double *R, double *x)
{
    if (s->M)
        cblas_dtrsv(CblasColMajor, CblasUpper, CblasNoTrans, CblasNonUnit, s->n, R, s->n, x, 1);
    for (int i = 0; !s->M && i < s->n; i++)
        x[i] /= R[i];
}

/* ---- basis ------------------------------------------------------------------------------------- */

/* W, without vectors that are rounding of the origin. Returns its columns, or -1. */
static int weigh(const space *s, const double *R, const double *S, int count, double *W)
{
    int k = 0;
    size_t bytes = (size_t)s->n * sizeof *W;
    memcpy(W, s->origin, bytes);
    to_root(s, R, W);
    double least = ROUNDING * cblas_dnrm2(s->n, W, 1);
    for (int j = 0; j < count; j++) {
        double *w = W + at(s->n, k);
        memcpy(w, S + at(s->n, j), bytes);
        to_root(s, R, w);
        double length = cblas_dnrm2(s->n, w, 1);
        if (!isfinite(length))
            return -1;
        if (length <= least)
            continue;
        for (int i = 0; i < s->n; i++)
            w[i] /= length;
        k++;
    }
    return k;
}

/* X = W U, columns along the principal axes of W, of lengths sigma, descending. */
static int rotate(const double *W, int n, int k, double *X, double *sigma)
{
    double *U = bake_alloc((size_t)k * (size_t)k, sizeof *U);
    cblas_dsyrk(CblasColMajor, CblasUpper, CblasTrans, k, n, -1, W, n, 0, U, k);
    int failed = LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'U', k, U, k, sigma);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, k, k, 1, W, n, U, k, 0, X, n);
    for (int i = 0; i < k; i++)
        sigma[i] = sqrt(fmax(-sigma[i], 0)); /* of -W^T W, so that they descend */
    free(U);
    return failed;
}

/* Columns with sigma above `least` get length 1; returns how many. */
static int normalise(double *X, int n, int k, const double *sigma, double least)
{
    int kept = 0;
    while (kept < k && sigma[kept] > least)
        kept++;
    for (int j = 0; j < kept; j++)
        cblas_dscal(n, 1 / sigma[j], X + at(n, j), 1);
    return kept;
}

/* Takes the span of A (n x a, orthonormal) out of B (n x b). */
static void project_out(const double *A, int n, int a, double *B, int b)
{
    double *C = bake_alloc((size_t)a * (size_t)b, sizeof *C);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, a, b, n, 1, A, n, B, n, 0, C, a);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, b, a, -1, A, n, C, a, 1, B, n);
    free(C);
}

/* X from W, which is overwritten; d, or -1 when LAPACK fails. */
static int orthonormalise(double *W, int n, int k, double *X)
{
    double *sigma = bake_alloc((size_t)k + 1, sizeof *sigma);
    int failed = rotate(W, n, k, X, sigma);
    double largest = sigma[0];
    int a = normalise(X, n, k, sigma, FIRST * largest), d = a;
    if (!failed && a < k) {
        double *rest = X + at(n, a);
        project_out(X, n, a, rest, k - a);
        failed = rotate(rest, n, k - a, W, sigma);
        d = a + normalise(W, n, k - a, sigma, DROPPED * largest);
        memcpy(rest, W, at(n, d - a) * sizeof *W);
    }
    cblas_dsyrk(CblasColMajor, CblasUpper, CblasTrans, d, n, 1, X, n, 0, W, d);
    failed = failed || LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'U', d, W, d);
    if (!failed)
        cblas_dtrsm(CblasColMajor, CblasRight, CblasUpper, CblasNoTrans, CblasNonUnit, n, d, 1, W,
                    d, X, n);
    free(sigma);
    return failed ? -1 : d;
}

/* max |V^T M V - 1|; work: n x d */
static double deviation(const space *s, const double *R, double *work)
{
    double most = 0, *G = bake_alloc((size_t)s->d * (size_t)s->d, sizeof *G);
    memcpy(work, s->V, at(s->n, s->d) * sizeof *work);
    for (int j = 0; j < s->d; j++)
        to_root(s, R, work + at(s->n, j));
    cblas_dsyrk(CblasColMajor, CblasUpper, CblasTrans, s->d, s->n, 1, work, s->n, 0, G, s->d);
    for (int j = 0; j < s->d; j++) {
        for (int i = 0; i <= j; i++)
            most = fmax(most, fabs(G[at(s->d, j) + (size_t)i] - (i == j)));
    }
    free(G);
    return most;
}

/* As in modes.h: the component of largest magnitude is positive, ties: the first. */
static void fix_sign(double *v, int n)
{
    if (v[cblas_idamax(n, v, 1)] < 0)
        cblas_dscal(n, -1, v, 1);
}

/* V from W, which is overwritten. */
static int make_basis(space *s, const double *R, double *W, int k, bake_error *error)
{
    s->V = bake_alloc(at(s->n, k), sizeof *s->V);
    s->d = orthonormalise(W, s->n, k, s->V);
    if (s->d < 0)
        return bake_fail(error,
                         "no basis of %d poses and modes: the eigenvectors of their Gram "
                         "matrix were not found",
                         k);
    for (int j = 0; j < s->d; j++) {
        from_root(s, R, s->V + at(s->n, j));
        fix_sign(s->V + at(s->n, j), s->n);
    }
    double off = deviation(s, R, W);
    return off <= ORTHONORMAL ? 0
                              : bake_fail(error,
                                          "the basis of %d poses and modes is orthonormal to %.1e "
                                          "only: the masses differ too much",
                                          k, off);
}

int space_make(space *s, const double *vectors, int count, bake_error *error)
{
    double *R, *W;
    s->V = NULL;
    s->d = 0;
    if (mass_root(s, &R, error) < 0)
        return -1;
    W = bake_alloc(at(s->n, count + 1), sizeof *W);
    int k = weigh(s, R, vectors, count, W), err;
    if (k > 0)
        err = make_basis(s, R, W, k, error);
    else
        err = bake_fail(error, k < 0 ? "a pose or mode is not a number"
                                     : "nothing moves: all poses are alike and there are no modes");
    free(R);
    free(W);
    if (err < 0) {
        free(s->V);
        s->V = NULL;
        s->d = 0;
    }
    return err;
}

void space_free(space *s)
{
    free(s->origin);
    free(s->M);
    free(s->mass);
    free(s->V);
    memset(s, 0, sizeof *s);
}

/* ---- between a body and its space -------------------------------------------------------------- */

/* Rows at a time: what is weighed by masses stays in the cache. */
#define CHUNK 2048

/* q += V^T M u over rows first .. first + rows - 1, for diagonal masses. */
static void project_chunk(const space *s, const double *u, int count, const int span[2], double *q)
{
    size_t n = (size_t)s->n, first = (size_t)span[0], rows = (size_t)span[1];
    double *p = bake_alloc(rows * (size_t)count, sizeof *p);
    for (size_t k = 0; k < (size_t)count; k++)
        for (size_t i = 0; i < rows; i++)
            p[rows * k + i] = s->mass[first + i] * u[n * k + first + i];
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, s->d, count, span[1], 1, s->V + first,
                s->n, p, span[1], 1, q, s->d);
    free(p);
}

void space_project_vectors(const space *s, const double *u, int count, double *q)
{
    size_t n = (size_t)s->n;
    memset(q, 0, (size_t)s->d * (size_t)count * sizeof *q);
    for (int first = 0; first < s->n && !s->M; first += CHUNK) {
        const int span[2] = {first, s->n - first < CHUNK ? s->n - first : CHUNK};
        project_chunk(s, u, count, span, q);
    }
    double *p = bake_alloc(s->M ? n : 1, sizeof *p);
    for (size_t k = 0; k < (size_t)count && s->M; k++) {
        cblas_dsymv(CblasColMajor, CblasUpper, s->n, 1, s->M, s->n, u + n * k, 1, 0, p, 1);
        cblas_dgemv(CblasColMajor, CblasTrans, s->n, s->d, 1, s->V, s->n, p, 1, 0,
                    q + (size_t)s->d * k, 1);
    }
    free(p);
}

void space_project_vector(const space *s, const double *u, double *q)
{
    space_project_vectors(s, u, 1, q);
}

void space_project(const space *s, const double *x, double *q)
{
    double *u = bake_alloc((size_t)s->n, sizeof *u);
    for (int i = 0; i < s->n; i++)
        u[i] = x[i] - s->origin[i];
    space_project_vector(s, u, q);
    free(u);
}

void space_expand(const space *s, const double *q, double *x)
{
    memcpy(x, s->origin, (size_t)s->n * sizeof *x);
    cblas_dgemv(CblasColMajor, CblasNoTrans, s->n, s->d, 1, s->V, s->n, q, 1, 1, x, 1);
}
