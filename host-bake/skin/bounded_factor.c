/* Supernodal Cholesky factors of parts of one matrix, that many threads may make and use at a time.
 * Source: own, on CHOLMOD [Chen, Davis, Hager, Rajamanickam 2008].
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_parts.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Samples of the diagonal of an inverse: each is off by a quarter, which a step's metric forgives. */
#define SAMPLES 32
/* Of 0.03, 0.1, 0.3 and 1: fewest iterations and factors on three bodies in tetrahedra. */
#define STEP    0.3

void bounded_desk_make(bounded_desk *desk)
{
    memset(desk, 0, sizeof *desk);
    cholmod_start(&desk->common);
    desk->common.print = 0;
    desk->common.supernodal = CHOLMOD_SUPERNODAL; /* fails where it is not positive definite */
    desk->common.quick_return_if_not_posdef = 1;
    desk->common.nmethods = 1;
    desk->common.method[0].ordering = CHOLMOD_NATURAL; /* rows are in the order of elimination */
    desk->common.postorder = 1;
}

void bounded_desk_free(bounded_desk *desk)
{
    cholmod_free_dense(&desk->X, &desk->common);
    cholmod_free_dense(&desk->Y, &desk->common);
    cholmod_free_dense(&desk->E, &desk->common);
    cholmod_finish(&desk->common);
}

/* The lower triangle of the rows and columns that are in. */
static cholmod_sparse *part(bounded_desk *desk, const bounded_system *s, const int *place, int n)
{
    size_t entries = 0;
    for (int i = 0; i < s->n; i++) {
        for (int p = s->column[i]; place[i] >= 0 && p < s->column[i + 1]; p++) {
            entries += place[s->row[p]] >= place[i];
        }
    }
    cholmod_sparse *A = cholmod_allocate_sparse((size_t)n, (size_t)n, entries, 1, 1, -1,
                                                CHOLMOD_REAL, &desk->common);
    if (!A) {
        return NULL;
    }
    int *column = A->p, *row = A->i, count = 0;
    double *value = A->x;
    for (int i = 0; i < s->n; i++) {
        if (place[i] >= 0) {
            column[place[i]] = count;
            for (int p = s->column[i]; p < s->column[i + 1]; p++) {
                if (place[s->row[p]] >= place[i]) {
                    row[count] = place[s->row[p]];
                    value[count++] = s->value[p];
                }
            }
        }
    }
    column[n] = count;
    return A;
}

static int factorise(bounded_desk *desk, cholmod_sparse *A, bounded_factor *out)
{
    cholmod_common *common = &desk->common;
    common->status = CHOLMOD_OK;
    out->L = cholmod_analyze(A, common);
    if (!out->L || common->status < 0) {
        return -1;
    }
    /* a factor runs at about twice the speed of solutions in groups */
    double columns = common->fl / (4 * common->lnz + 1) / 2;
    out->columns = columns > 1000 ? 1000 : (int)columns;
    cholmod_factorize(A, out->L, common);
    if (common->status < 0) {
        return -1;
    }
    return common->status == CHOLMOD_NOT_POSDEF || out->L->minor < out->L->n;
}

int bounded_factor_make(bounded_desk *desk, const bounded_system *s, const char *member,
                        const double *add, bounded_factor *out)
{
    int *place = bake_alloc((size_t)s->n, sizeof *place), result = 0;
    memset(out, 0, sizeof *out);
    for (int i = 0; i < s->n; i++) {
        place[i] = !member || member[i] ? out->n++ : -1;
    }
    if (out->n > 0) {
        cholmod_sparse *A = part(desk, s, place, out->n);
        for (int i = 0; i < s->n && A && add; i++) {
            if (place[i] >= 0) {
                ((double *)A->x)[((int *)A->p)[place[i]]] +=
                    add[i]; /* rows ascend: it comes first */
            }
        }
        result = A ? factorise(desk, A, out) : -1;
        cholmod_free_sparse(&A, &desk->common);
    }
    if (result != 0) {
        bounded_factor_free(desk, out);
    }
    free(place);
    return result;
}

void bounded_factor_free(bounded_desk *desk, bounded_factor *f)
{
    if (f->L) {
        cholmod_free_factor(&f->L, &desk->common);
    }
    memset(f, 0, sizeof *f);
}

static int solve(bounded_desk *desk, const bounded_factor *f, int system, cholmod_dense *B)
{
    return cholmod_solve2(system, f->L, B, NULL, &desk->X, NULL, &desk->Y, &desk->E, &desk->common)
               ? 0
               : -1;
}

static cholmod_dense dense(int n, int count, double *x)
{
    return (cholmod_dense){.nrow = (size_t)n,
                           .ncol = (size_t)count,
                           .nzmax = (size_t)n * (size_t)count,
                           .d = (size_t)n,
                           .x = x,
                           .xtype = CHOLMOD_REAL,
                           .dtype = CHOLMOD_DOUBLE};
}

int bounded_factor_solve(bounded_desk *desk, const bounded_factor *f, double *x, int count)
{
    if (f->n == 0 || count == 0) {
        return 0;
    }
    cholmod_dense B = dense(f->n, count, x);
    if (solve(desk, f, CHOLMOD_A, &B) < 0) {
        return -1;
    }
    memcpy(x, desk->X->x, (size_t)f->n * (size_t)count * sizeof *x);
    return 0;
}

/* Sums of twelve numbers of [0, 1): variance 1, always the same ones. */
static double noise(uint64_t *state)
{
    double sum = -6;
    for (int i = 0; i < 12; i++) {
        *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        sum += (double)(*state >> 40) * 0x1p-24;
    }
    return sum;
}

int bounded_metric(bounded_desk *desk, bounded_system *s, const bounded_factor *of_q)
{
    size_t n = (size_t)s->n;
    double *z = bake_alloc(n * SAMPLES, sizeof *z);
    const int *order = of_q->L->Perm;
    uint64_t state = 1;
    for (size_t i = 0; i < n * SAMPLES; i++) {
        z[i] = noise(&state);
    }
    cholmod_dense Z = dense(s->n, SAMPLES, z);
    int err = solve(desk, of_q, CHOLMOD_Lt, &Z);
    s->metric = bake_alloc(n, sizeof *s->metric);
    for (size_t i = 0; i < n && err == 0; i++) {
        double sum = 0;
        for (size_t k = 0; k < SAMPLES; k++) {
            double x = ((const double *)desk->X->x)[n * k + i];
            sum += x * x;
        }
        s->metric[order[i]] = STEP * SAMPLES / sum;
    }
    free(z);
    return err;
}
