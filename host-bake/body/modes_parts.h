/* What the files of the mode solver share.
 *   S     n x n   M^-1/2 K M^-1/2, so that S y = lambda y and phi = M^-1/2 y
 *   Y     n x k   orthonormal, column-major; M-norms of phi and residuals are plain norms of y
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_MODES_PARTS_H
#define BAKE_MODES_PARTS_H

#include "modes.h"

/* ---- modes_lanczos.c: the largest eigenpairs of (S - sigma)^-1 ----------------------------------- */

typedef struct {
    int n, wanted, room; /* room: columns of V */
    int size;            /* columns of V in H; the block after them is in V, too */
    double *V;           /* n x room, orthonormal */
    double *H;           /* room x room: V^T (S - sigma)^-1 V */
    double *theta;       /* room: eigenvalues of H, descending, after lanczos_look */
    double *Z;           /* room x room: eigenvectors of H, columns in that order */
    double *error;       /* room: |(S - sigma)^-1 y - theta y| of each */
    double *next; /* LANCZOS_BLOCK x LANCZOS_BLOCK: what couples the last block with the next */
    int solves;
} lanczos;

#define LANCZOS_BLOCK 8

/* start: n x start_count, what the wanted modes may look like; NULL = none. */
void lanczos_make(lanczos *z, int n, int wanted, const double *start, int start_count);
void lanczos_free(lanczos *z);
void lanczos_step(lanczos *z, sparse_factor *f); /* one more block; restarts when V is full */
void lanczos_look(lanczos *z);                   /* theta, Z, error */
int lanczos_done(const lanczos *z);              /* after a look: the wanted ones have converged */
/* Y = V Z: the first `count` of them. */
void lanczos_vectors(const lanczos *z, int count, double *Y);

/* ---- modes_finish.c ------------------------------------------------------------------------------ */

/* An upper bound of the largest |lambda| of S [Gershgorin]. */
double modes_bound(const sparse *S);

void modes_room(modes *out, int n, int count);

/* The caller has set lambda (ascending), phi, and as residual the norms |S y - lambda y|. Makes noise 0,
 * counts, fixes signs, relates the residuals to their scale, and fails when one is too large. */
int modes_finish(modes *out, double bound, bake_error *error);

/* ---- modes_dense.c ------------------------------------------------------------------------------- */

/* All of S as a full matrix; y, not phi, in out->phi. */
int modes_dense_scaled(const sparse *S, int count, modes *out, bake_error *error);

#endif
