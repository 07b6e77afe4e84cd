/* The lowest vibration modes of a sparse system.                                    [Schulz (2.11)]
 * Source: ARPACK in shift-invert mode on CHOLMOD (modes_arpack.c); where the shift lies is our own.
 *   S      n x n   M^-1/2 K M^-1/2: S y = lambda y, phi = M^-1/2 y; M-norms are norms of y
 *   sigma          below the lowest eigenvalue, so that S - sigma has a Cholesky factor
 *
 * Residuals: |S y - lambda y| / max(|lambda|, lambda_first) = |K phi - lambda M phi| in the norm of
 * M^-1, relative to lambda, or for rigid modes to lambda_first, the |lambda| of the softest mode
 * that is not rigid: what a rigid mode's error weighs beside the motions one sees. They must be
 * below 1e-8, or, where that is out of reach of doubles (thin shells on fine meshes), below what
 * rounding in products with K leaves: 64 eps times a bound of the largest eigenvalue.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "modes_parts.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Below this LAPACK is faster, and needs no shift. */
#define SMALL 200

/* The first shift, relative to the largest eigenvalue: below the softest modes of solids of 1e5
 * elements, and yet so far from 0 that rounding in the others, eps times their distance over its,
 * is 1e-10. Those of thin shells are below it. */
#define FIRST_SHIFT 1e-8

/* Of modes nearer to 0 than the shift: so many are no reason for another one; what it should
 * leave. */
#define NEAR_MOST 16
#define NEAR_FEW  8

/* A look at the spectrum: how many, and how exactly, relative to their distance from the shift. */
#define LOOK_COUNT     16
#define LOOK_TOLERANCE 1e-2
#define LOOKS          4

typedef struct {
    const sparse *S;
    const double *one; /* n x 1 */
    double bound, sigma;
    sparse_factor *f;
} shifted;

/* 1 = not positive definite */
static int set_shift(shifted *s, double sigma, bake_error *error)
{
    s->sigma = sigma;
    return sparse_refactor(s->f, s->S, -sigma, s->one, error);
}

/* A first shift for which a factor exists: at -bound the diagonal dominates. */
static int find_shift(shifted *s, bake_error *error)
{
    double sigma = -FIRST_SHIFT * s->bound;
    int err = set_shift(s, sigma, error);
    while (err == 1 && sigma > -s->bound) {
        sigma *= 64;
        err = set_shift(s, sigma, error);
    }
    return err == 1
               ? bake_fail(error, "the stiffness matrix has no factor: are its numbers finite?")
               : err;
}

/* About how many modes are nearer to 0 than the shift: sum of (sigma/(lambda - sigma))^2, as the
 * mean square of what sigma (S - sigma)^-1 makes of noise says. */
static double count_near(const shifted *s)
{
    size_t n = (size_t)s->S->n;
    double *y = bake_alloc(n, sizeof *y), sum = 0;
    uint64_t state = 1;
    for (size_t i = 0; i < n; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        y[i] = state >> 63 ? 1 : -1;
    }
    sparse_solve_plain(s->f, y, 1);
    for (size_t i = 0; i < n; i++) {
        sum += y[i] * y[i];
    }
    free(y);
    return s->sigma * s->sigma * sum;
}

/* Nearer while many modes are. Their number goes with the root of lambda for thin plates, faster
 * for anything else [Weyl]. Returns 1 when there are still many: what is nearer has no factor, or
 * rounding forbids it; -1: error. */
static int jump(shifted *s, bake_error *error)
{
    double least = -64 * DBL_EPSILON * s->bound;
    for (int round = 0; round < LOOKS; round++) {
        double near = count_near(s), old = s->sigma;
        if (near <= NEAR_MOST) {
            return 0;
        }
        if (old > 4 * least) {
            return 1;
        }
        int err = set_shift(s, fmin(old * pow(NEAR_FEW / near, 2), least), error);
        if (err != 0) {
            return err == 1 && set_shift(s, old, error) == 0 ? 1 : -1;
        }
    }
    return 1;
}

/* Where the shift should be, from what a look has seen: a tenth of the softest mode below 0, or a
 * tenth of the lowest eigenvalue below it. Not nearer, and not nearer than a fraction of what is
 * stiffer: rounding in modes far from the shift is eps times their distance over its. */
static double better_shift(const shifted *s, const double *lambda, int count)
{
    double noise = 64 * DBL_EPSILON * s->bound, stiffer = lambda[count - 1];
    if (lambda[0] + LOOK_TOLERANCE * (lambda[0] - s->sigma) < -noise) {
        return 1.1 * lambda[0];
    }
    for (int i = 0; i < count; i++) {
        if (fabs(lambda[i]) > noise + LOOK_TOLERANCE * (lambda[i] - s->sigma)) {
            return -fmax(0.1 * fabs(lambda[i]), 1e-4 * stiffer);
        }
    }
    return 0.01 * s->sigma;
}

/* Brings the shift near the lowest eigenvalues, where counting did not. */
static int approach(shifted *s, int count, bake_error *error)
{
    int look = count < LOOK_COUNT ? count : LOOK_COUNT, err = 0, more = 1;
    double *lambda = bake_alloc((size_t)look, sizeof *lambda);
    double *Y = bake_alloc((size_t)s->S->n * (size_t)look, sizeof *Y);
    for (int round = 0; round < LOOKS && more && err == 0; round++) {
        const arpack_problem p = {s->S->n, look, s->f, s->sigma, LOOK_TOLERANCE};
        err = modes_arpack(&p, lambda, Y, error);
        double old = s->sigma, better = err == 0 ? better_shift(s, lambda, look) : old;
        more = old < 4 * better;
        if (err == 0 && more) {
            err = set_shift(s, better, error);
            if (err == 1) { /* too near: back to where it worked, to stay there */
                err = set_shift(s, old, error) == 0 ? 0 : -1;
                more = 0;
            }
        }
    }
    free(lambda);
    free(Y);
    return err;
}

/* Rayleigh-Ritz in the space of the columns of out->phi: lambda, phi, |S y - lambda y|. */
static int rotate(const sparse *S, modes *out, bake_error *error)
{
    int n = S->n, k = out->count, info;
    size_t size = (size_t)n * (size_t)k;
    double *Y = out->phi, *R = bake_alloc(size, sizeof *R), *old = bake_alloc(size, sizeof *old);
    double *H = bake_alloc((size_t)k * (size_t)k, sizeof *H), *tau = bake_alloc((size_t)k, 8);
    LAPACKE_dgeqrf(LAPACK_COL_MAJOR, n, k, Y, n, tau);
    LAPACKE_dorgqr(LAPACK_COL_MAJOR, n, k, k, Y, n, tau);
    for (int j = 0; j < k; j++) {
        sparse_multiply(S, Y + (size_t)j * (size_t)n, R + (size_t)j * (size_t)n);
    }
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, k, k, n, 1, Y, n, R, n, 0, H, k);
    info = LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'L', k, H, k, out->lambda);
    memcpy(old, Y, size * sizeof *Y);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, k, k, 1, old, n, H, k, 0, Y, n);
    memcpy(old, R, size * sizeof *R);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, k, k, 1, old, n, H, k, 0, R, n);
    for (int j = 0; j < k; j++) {
        double *r = R + (size_t)j * (size_t)n;
        cblas_daxpy(n, -out->lambda[j], Y + (size_t)j * (size_t)n, 1, r, 1);
        out->residual[j] = cblas_dnrm2(n, r, 1);
    }
    free(R);
    free(old);
    free(H);
    free(tau);
    return info == 0 ? 0 : bake_fail(error, "the eigenvalues of %d modes failed with %d", k, info);
}

static int sparse_modes(const sparse *S, double bound, int count, modes *out, bake_error *error)
{
    shifted s = {.S = S, .bound = bound, .f = sparse_analyse(S, error)};
    double *one = bake_alloc((size_t)S->n, sizeof *one);
    for (int i = 0; i < S->n; i++) {
        one[i] = 1;
    }
    s.one = one;
    modes_room(out, S->n, count);
    int err = !s.f || find_shift(&s, error) < 0 ? -1 : jump(&s, error);
    if (err == 1) {
        err = approach(&s, count, error);
    }
    if (err == 0) {
        const arpack_problem p = {S->n, count, s.f, s.sigma, 0};
        err = modes_arpack(&p, out->lambda, out->phi, error);
    }
    if (err == 0) {
        /* One inverse iteration more takes out what rounding left of the stiffest modes, which
         * weigh most in K phi. */
        sparse_solve_plain(s.f, out->phi, count);
        err = rotate(S, out, error);
    }
    sparse_factor_free(s.f);
    free(one);
    return err;
}

/* root[i] = sqrt(M_i) */
static int scale(const sparse *K, const double *M, double *root, sparse *S, bake_error *error)
{
    size_t entries = (size_t)K->column[K->n];
    for (int i = 0; i < K->n; i++) {
        if (!(M[i] > 0 && M[i] < HUGE_VAL)) {
            return bake_fail(error, "coordinate %d has a mass of %g kg", i, M[i]);
        }
        root[i] = sqrt(M[i]);
    }
    *S = *K; /* the pattern is shared */
    S->value = bake_alloc(entries, sizeof *S->value);
    for (int j = 0; j < K->n; j++) {
        for (int p = K->column[j]; p < K->column[j + 1]; p++) {
            S->value[p] = K->value[p] / (root[j] * root[K->row[p]]);
        }
    }
    return 0;
}

int modes_solve(const sparse *K, const double *M, int count, modes *out, bake_error *error)
{
    sparse S = {0};
    int n = K->n, err;
    memset(out, 0, sizeof *out);
    if (count < 1 || count >= n) {
        return bake_fail(error, "%d modes of a body with %d coordinates: at most %d", count, n,
                         n - 1);
    }
    double *root = bake_alloc((size_t)n, sizeof *root), bound = 0;
    err = scale(K, M, root, &S, error);
    if (err == 0) {
        bound = modes_bound(&S);
        err = n < SMALL || count > n / 3 ? modes_dense_scaled(&S, count, out, error)
                                         : sparse_modes(&S, bound, count, out, error);
    }
    for (int j = 0; err == 0 && j < count; j++) {
        for (int i = 0; i < n; i++) {
            out->phi[(size_t)j * (size_t)n + (size_t)i] /= root[i];
        }
    }
    err = err == 0 ? modes_finish(out, bound, error) : err;
    if (err < 0) {
        modes_free(out);
    }
    free(S.value);
    free(root);
    return err;
}
