/* ARPACK about a shift: the eigenpairs of S that lie nearest above it.
 *   S   n x n   symmetric;   S y = lambda y,   (S - sigma)^-1 y = y / (lambda - sigma)
 * Source: implicitly restarted Lanczos [Lehoucq, Sorensen, Yang, ARPACK users' guide], mode 3, on a
 * Cholesky factor of S - sigma. The start vector is fixed, so that the same matrix gives the same
 * bits.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "modes_parts.h"

#include <arpack/arpack.h>
#include <stdlib.h>
#include <string.h>

#define RESTARTS 1000

typedef struct {
    int n, count, vectors, room;
    double *V, *start, *work, *small;
    int param[11], at[14];
} arpack;

static void make(arpack *a, int n, int count)
{
    *a = (arpack){.n = n, .count = count, .vectors = 2 * count + 20};
    a->vectors = a->vectors < n ? a->vectors : n;
    a->room = a->vectors * (a->vectors + 8);
    a->V = bake_alloc((size_t)n * (size_t)a->vectors, sizeof *a->V);
    a->start = bake_alloc((size_t)n, sizeof *a->start);
    a->work = bake_alloc(3 * (size_t)n, sizeof *a->work);
    a->small = bake_alloc((size_t)a->room, sizeof *a->small);
    a->param[0] = 1; /* its own shifts within a restart */
    a->param[2] = RESTARTS;
    a->param[3] = 1;
    a->param[6] = 3;
    for (int i = 0; i < n; i++) { /* not orthogonal to any smooth mode */
        a->start[i] = 1 + 0.3 * (double)(i * 7919LL % 101) / 101.0;
    }
}

static void drop(arpack *a)
{
    free(a->V);
    free(a->start);
    free(a->work);
    free(a->small);
}

/* Its reverse communication: 0 when all have converged. */
static int iterate(arpack *a, sparse_factor *f, double tolerance)
{
    int ido = 0, info = 1;
    while (ido != 99) {
        dsaupd_c(&ido, "I", a->n, "LM", a->count, tolerance, a->start, a->vectors, a->V, a->n,
                 a->param, a->at, a->work, a->small, a->room, &info);
        if (ido == 1 || ido == -1) {
            double *y = a->work + a->at[1] - 1;
            memcpy(y, a->work + a->at[0] - 1, (size_t)a->n * sizeof *y);
            sparse_solve_plain(f, y, 1);
        } else if (ido != 99) {
            return -1;
        }
    }
    return info == 0 && a->param[4] >= a->count ? 0 : -1;
}

/* Ascending, by insertion: they nearly are. */
static void sort(int n, int count, double *lambda, double *Y)
{
    double *moved = bake_alloc((size_t)n, sizeof *moved);
    size_t size = (size_t)n * sizeof *Y;
    for (int j = 1; j < count; j++) {
        for (int i = j; i > 0 && lambda[i] < lambda[i - 1]; i--) {
            double *y = Y + (size_t)i * (size_t)n, *before = y - n, other = lambda[i];
            lambda[i] = lambda[i - 1];
            lambda[i - 1] = other;
            memcpy(moved, y, size);
            memcpy(y, before, size);
            memcpy(before, moved, size);
        }
    }
    free(moved);
}

int modes_arpack(const arpack_problem *p, double *lambda, double *Y, bake_error *error)
{
    arpack a;
    make(&a, p->n, p->count);
    int info = 0, err = iterate(&a, p->factor, p->tolerance);
    int *select = bake_alloc((size_t)a.vectors, sizeof *select);
    if (err == 0) {
        dseupd_c(1, "A", select, lambda, a.V, a.n, p->sigma, "I", a.n, "LM", a.count, p->tolerance,
                 a.start, a.vectors, a.V, a.n, a.param, a.at, a.work, a.small, a.room, &info);
        memcpy(Y, a.V, (size_t)a.n * (size_t)a.count * sizeof *Y);
        sort(a.n, a.count, lambda, Y);
    }
    int converged = a.param[4];
    free(select);
    drop(&a);
    return err == 0 && info == 0
               ? 0
               : bake_fail(error,
                           "%d of %d modes of %d unknowns converged (ARPACK): is the body much too "
                           "thin for its size, or are there slivers in its mesh?",
                           converged, p->count, p->n);
}
