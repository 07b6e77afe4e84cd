/* Block Lanczos with full reorthogonalisation and thick restarts, on a Cholesky factor.
 * Source: own, on [Grimes, Lewis, Simon 1994] (blocks, shift and invert) and [Wu, Simon 2000] (restart).
 * Blocks, because a factor serves eight right-hand sides in little more than the time of two, and because
 * modes of one frequency come in pairs and triples (a cube, a rod): a block that is wider finds them all.
 * H is made of full products with V instead of three-term recurrences, which costs products that BLAS is
 * good at and makes the restart a change of basis.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "modes_parts.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { B = LANCZOS_BLOCK };

/* A Ritz pair counts as converged at this error relative to its theta. */
#define CONVERGED 1e-12

/* Always the same sequence, so that the same mesh gives the same modes. */
static void fill(double *x, size_t count)
{
    uint64_t state = 0x9e3779b97f4a7c15u;
    for (size_t i = 0; i < count; i++) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        x[i] = (double)(state >> 11) * 0x1p-53 - 0.5;
    }
}

static double *column(const lanczos *z, int j)
{
    return z->V + (size_t)j * (size_t)z->n;
}

/* The B columns of V from `first` on: orthogonal to those before, and to each other. Twice, because once
 * leaves eps times what was cancelled. Dependent columns become others (Householder's Q is orthonormal
 * whatever comes in), which is what a restart in an invariant space needs; they must be made orthogonal to
 * V again, hence the loop. C += V^T W (first x B), R (B x B): W = V C + Q R; NULL = not wanted. */
static void orthogonalise(lanczos *z, int first, double *C, double *R)
{
    double *W = column(z, first), tau[B], G[B * B];
    double *D = bake_alloc((size_t)(first > 0 ? first : 1) * B, sizeof *D);
    for (int pass = 0; pass < 3; pass++) {
        if (first > 0) {
            cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, first, B, z->n, 1, z->V, z->n, W,
                        z->n, 0, D, first);
            cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, z->n, B, first, -1, z->V, z->n,
                        D, first, 1, W, z->n);
        }
        if (pass < 2) { /* the third only repairs columns that the second one invented */
            for (int i = 0; C && i < first * B; i++) {
                C[i] += D[i];
            }
        }
        if (pass == 0) {
            continue;
        }
        LAPACKE_dgeqrf(LAPACK_COL_MAJOR, z->n, B, W, z->n, tau);
        memset(G, 0, sizeof G);
        for (int j = 0; j < B; j++) {
            memcpy(G + B * j, W + (size_t)j * (size_t)z->n, (size_t)(j + 1) * sizeof *G);
        }
        LAPACKE_dorgqr(LAPACK_COL_MAJOR, z->n, B, B, W, z->n, tau);
        if (pass == 1 && R) {
            memcpy(R, G, sizeof G);
        }
    }
    /* G of the last pass is a change of signs, but for rounding: undone, so that W = V C + Q R holds */
    for (int j = 0; j < B; j++) {
        cblas_dscal(z->n, G[B * j + j] < 0 ? -1 : 1, W + (size_t)j * (size_t)z->n, 1);
    }
    free(D);
}

void lanczos_make(lanczos *z, int n, int wanted, const double *start, int start_count)
{
    memset(z, 0, sizeof *z);
    z->n = n;
    z->wanted = wanted;
    z->room = 2 * wanted + 16 * B < n - B ? 2 * wanted + 16 * B : n - B;
    z->V = bake_alloc((size_t)n * ((size_t)z->room + B), sizeof *z->V);
    z->H = bake_alloc((size_t)z->room * (size_t)z->room, sizeof *z->H);
    z->Z = bake_alloc((size_t)z->room * (size_t)z->room, sizeof *z->Z);
    z->theta = bake_alloc((size_t)z->room, sizeof *z->theta);
    z->error = bake_alloc((size_t)z->room, sizeof *z->error);
    z->next = bake_alloc(B * B, sizeof *z->next);
    fill(z->V, (size_t)n * B);
    for (int j = 0; j < start_count; j++) { /* beside the noise, which finds what they lack */
        cblas_dscal(n, 1e-3 / sqrt(n), column(z, j % B), j < B);
        cblas_daxpy(n, 1, start + (size_t)j * (size_t)n, 1, column(z, j % B), 1);
    }
    orthogonalise(z, 0, NULL, NULL);
}

void lanczos_free(lanczos *z)
{
    free(z->V);
    free(z->H);
    free(z->Z);
    free(z->theta);
    free(z->error);
    free(z->next);
    memset(z, 0, sizeof *z);
}

/* Keeps the Ritz vectors that matter, and the block that comes next. H of them is diagonal; what couples
 * them with the next block appears when that block's column of H is computed. */
static void restart(lanczos *z)
{
    int keep = z->wanted + 2 * B < z->size - B ? z->wanted + 2 * B : z->size - B;
    double *Y = bake_alloc((size_t)z->n * (size_t)keep, sizeof *Y);
    lanczos_look(z);
    lanczos_vectors(z, keep, Y);
    memcpy(column(z, keep), column(z, z->size), (size_t)z->n * B * sizeof *z->V);
    memcpy(z->V, Y, (size_t)z->n * (size_t)keep * sizeof *z->V);
    memset(z->H, 0, (size_t)z->room * (size_t)z->room * sizeof *z->H);
    for (int j = 0; j < keep; j++) {
        z->H[(size_t)j * (size_t)z->room + (size_t)j] = z->theta[j];
    }
    z->size = keep;
    free(Y);
}

void lanczos_step(lanczos *z, sparse_factor *f)
{
    if (z->size + B > z->room) {
        restart(z);
    }
    int first = z->size, all = first + B;
    double *C = bake_alloc((size_t)all * B, sizeof *C);
    memcpy(column(z, all), column(z, first), (size_t)z->n * B * sizeof *z->V);
    sparse_solve_plain(f, column(z, all), B);
    z->solves += B;
    z->size = all;
    orthogonalise(z, all, C, z->next);
    for (int j = 0; j < B; j++) {
        for (int i = 0; i < all; i++) {
            double h = C[(size_t)j * (size_t)all + (size_t)i];
            z->H[(size_t)(first + j) * (size_t)z->room + (size_t)i] = h;
            z->H[(size_t)i * (size_t)z->room + (size_t)(first + j)] = h;
        }
    }
    free(C);
}

void lanczos_look(lanczos *z)
{
    int size = z->size, room = z->room;
    double *w = bake_alloc((size_t)size, sizeof *w),
           *A = bake_alloc((size_t)size * (size_t)size, 8);
    for (int j = 0; j < size; j++) {
        memcpy(A + (size_t)j * (size_t)size, z->H + (size_t)j * (size_t)room,
               (size_t)size * sizeof *A);
    }
    int info = LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'U', size, A, size, w);
    for (int i = 0; i < size; i++) {
        const double *from = A + (size_t)(size - 1 - i) * (size_t)size;
        double sum = 0;
        memcpy(z->Z + (size_t)i * (size_t)room, from, (size_t)size * sizeof *from);
        z->theta[i] = w[size - 1 - i];
        for (int r = 0; r < B; r++) { /* |R z|, z the rows of the last block */
            double row = 0;
            for (int c = r; c < B; c++) {
                row += z->next[B * c + r] * from[size - B + c];
            }
            sum += row * row;
        }
        z->error[i] = info == 0 ? sqrt(sum) : HUGE_VAL;
    }
    free(A);
    free(w);
}

int lanczos_done(const lanczos *z)
{
    if (z->size < z->wanted) {
        return 0;
    }
    for (int i = 0; i < z->wanted; i++) {
        /* no product is more exact than eps times the largest eigenvalue */
        if (!(z->error[i] <= CONVERGED * fabs(z->theta[i]) + 8 * DBL_EPSILON * z->theta[0])) {
            return 0;
        }
    }
    return 1;
}

void lanczos_vectors(const lanczos *z, int count, double *Y)
{
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, z->n, count, z->size, 1, z->V, z->n,
                z->Z, z->room, 0, Y, z->n);
}
