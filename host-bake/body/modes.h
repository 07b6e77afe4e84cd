/* Vibration modes: the lowest eigenpairs of  K phi = lambda M phi.             [Schulz (2.11)]
 *   K    n x n   symmetric, may be singular or indefinite
 *   M    n       diagonal, > 0
 *   Phi  n x k   column-major, Phi^T M Phi = 1
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_MODES_H
#define BAKE_MODES_H

#include "sparse.h"

typedef struct {
    int n, count;
    int negative, rigid; /* modes with lambda < 0; with lambda = 0 (both come first, ascending) */
    double *lambda;      /* count, ascending [1/s^2]; noise about 0 is exactly 0 */
    double *phi;         /* n x count */
    double *residual;    /* count: |K phi - lambda M phi| / (lambda_scale |M phi|), see modes.c */
    double noise;        /* what counts as 0 [1/s^2] */
} modes;

/* ARPACK in shift-invert mode on CHOLMOD. The shift lies below the lowest eigenvalue, found
 * by trying factors, so that they exist for free bodies and for indefinite K. Fails when an
 * eigenpair's residual is above 1e-8 (and above rounding, see modes.c) or ARPACK does not
 * converge. count <= n - 1; for n < 200 or count > n/3, LAPACK (dense). The sign of each mode is
 * fixed: its component of largest magnitude is positive (ties, to a millionth: the first), so that
 * the same mesh gives the same modes. */
int modes_solve(const sparse *K, const double *M, int count, modes *out, bake_error *error);

/* Dense K and M (n x n, symmetric, M positive definite), all n modes: for chains and reduced
 * models. */
int modes_dense(const double *K, const double *M, int n, modes *out, bake_error *error);
void modes_free(modes *m);

#endif
