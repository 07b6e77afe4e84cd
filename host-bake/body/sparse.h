/* Sparse symmetric systems on CHOLMOD.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SPARSE_H
#define BAKE_SPARSE_H

#include "freedom.h"

/* The lower triangle of a symmetric matrix in compressed columns, rows ascending; every column
 * begins with its diagonal entry. */
typedef struct {
    int n;
    int *column; /* n + 1 */
    int *row;
    double *value;
} sparse;

/* Z^T K Z of a Hessian's blocks. */
int sparse_from_blocks(const body_blocks *blocks, const freedom *f, sparse *out, bake_error *error);
void sparse_free(sparse *s);

/* y = S x */
void sparse_multiply(const sparse *s, const double *x, double *y);

/* A Cholesky factor of S + shift diag(d); opaque. NULL as d: of S. */
typedef struct sparse_factor sparse_factor;

/* Of matrices of one size: the order of elimination is found once, and again when the pattern has
 * changed. NULL: no memory. sparse_refactor: 0, 1 = not positive definite (try a larger shift; the
 * factor is void until then), -1. d NULL: no shift. */
sparse_factor *sparse_analyse(const sparse *s, bake_error *error);
int sparse_refactor(sparse_factor *f, const sparse *s, double shift, const double *d,
                    bake_error *error);
void sparse_factor_free(sparse_factor *f);

/* X = A^-1 B for `count` right-hand sides, column-major, in place. Refined once, so that the
 * residual is that of a backward stable solve. */
void sparse_solve(sparse_factor *f, double *x, int count);

/* Without the refinement, in half the time: for iterations that see their own error. */
void sparse_solve_plain(sparse_factor *f, double *x, int count);

#endif
