/* The lowest eigenvalues of K phi = lambda M phi by ARPACK in shift-invert mode, for tests: independent of
 * the baker's own Lanczos but for the factor.
 * SPDX-License-Identifier: MIT */
#ifndef ARPACK_ORACLE_H
#define ARPACK_ORACLE_H

#include "sparse.h"

#include <arpack/arpack.h>
#include <stdlib.h>
#include <string.h>

/* Mode 3 with the masses as inner product; sigma below all. lambda: count, ascending. Returns the solves
 * it took, or -1. */
static inline int arpack_modes(const sparse *K, const double *M, double sigma, int count,
                               double *lambda)
{
    int n = K->n, ncv = 2 * count + 20 < n ? 2 * count + 20 : n, info = 1, ido = 0, solves = 0;
    int param[11] = {1, 0, 1000, 1, 0, 0, 3}, at[14] = {0}, room = ncv * (ncv + 8);
    double *V = malloc(sizeof *V * (size_t)n * (size_t)ncv), *resid = malloc(sizeof *V * (size_t)n);
    double *work = malloc(sizeof *V * 3 * (size_t)n), *small = malloc(sizeof *V * (size_t)room);
    int *select = malloc(sizeof *select * (size_t)ncv);
    bake_error error;
    sparse_factor *f = sparse_factorise(K, -sigma, M, &error);
    for (int i = 0; i < n; i++) {
        resid[i] = 1 + 0.3 * (i * 7919 % 101) / 101.0;
    }
    while (f && ido != 99) {
        dsaupd_c(&ido, "G", n, "LM", count, 0, resid, ncv, V, n, param, at, work, small, room,
                 &info);
        double *x = work + at[0] - 1, *y = work + at[1] - 1, *Bx = work + at[2] - 1;
        for (int i = 0; i < n; i++) {
            y[i] = ido == 1 ? Bx[i] : M[i] * x[i];
        }
        if (ido == 1 || ido == -1) {
            sparse_solve(f, y, 1);
            solves++;
        } else if (ido != 2) {
            break;
        }
    }
    int converged = f && info == 0 && param[4] >= count;
    if (converged) {
        dseupd_c(1, "A", select, lambda, V, n, sigma, "G", n, "LM", count, 0, resid, ncv, V, n,
                 param, at, work, small, room, &info);
    }
    sparse_factor_free(f);
    free(V);
    free(resid);
    free(work);
    free(small);
    free(select);
    return converged && info == 0 ? solves : -1;
}

#endif
