/* What the files of the mode solver share.
 *   S     n x n   M^-1/2 K M^-1/2, so that S y = lambda y and phi = M^-1/2 y
 *   Y     n x k   orthonormal, column-major; M-norms of phi and residuals are plain norms of y
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_MODES_PARTS_H
#define BAKE_MODES_PARTS_H

#include "modes.h"

/* ---- modes_arpack.c: eigenpairs of S nearest above a shift ------------------------------------ */

typedef struct {
    int n, count;
    sparse_factor *factor; /* of S - sigma, positive definite */
    double sigma;
    double tolerance; /* of 1/(lambda - sigma), relative; 0 = what doubles reach */
} arpack_problem;

/* lambda: count, ascending; Y: n x count. */
int modes_arpack(const arpack_problem *p, double *lambda, double *Y, bake_error *error);

/* ---- modes_finish.c -------------------------------------------------------------------------- */

/* An upper bound of the largest |lambda| of S [Gershgorin]. */
double modes_bound(const sparse *S);

void modes_room(modes *out, int n, int count);

/* The caller has set lambda (ascending), phi, and as residual the norms |S y - lambda y|. Makes
 * noise 0, counts, fixes signs, relates the residuals to their scale, and fails when one is too
 * large. */
int modes_finish(modes *out, double bound, bake_error *error);

/* ---- modes_dense.c --------------------------------------------------------------------------- */

/* All of S as a full matrix; y, not phi, in out->phi. */
int modes_dense_scaled(const sparse *S, int count, modes *out, bake_error *error);

#endif
