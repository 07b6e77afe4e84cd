/* Sparse symmetric matrices from a Hessian's blocks, and their supernodal Cholesky factors.
 * Source: own, on CHOLMOD [Chen, Davis, Hager, Rajamanickam 2008].
 *   K   3 n x 3 n   the Hessian, as blocks of vertex pairs
 *   Z   3 n x c     directions that the vertices have left (freedom.h)
 *   A   c x c       Z^T K Z + shift diag(d)
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "sparse.h"

#include <cblas.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/cholmod.h>

/* Right-hand sides that go through the factor together. 32 of 52728 unknowns take 0.77 s one by
 * one,
 * 0.29 s by 8, 0.17 s by 16, 0.16 s by 32, and the work space is this many columns. */
#define SOLVE_COLUMNS 16

/* ---- assembly -------------------------------------------------------------------------------- */

/* One block column: the rows that vertex b meets, each with the sum of its blocks. */
typedef struct {
    int count, room;
    int *row, *slot;  /* vertices, ascending at the end; slot of a vertex, -1 = not met */
    double (*sum)[9]; /* of row[i], in the order in which they were met */
} block_column;

static void column_add(block_column *c, int a, const double k[9])
{
    if (c->slot[a] < 0) {
        if (c->count == c->room) {
            c->room = 2 * c->room + 64;
            c->row = bake_grow(c->row, (size_t)c->room, sizeof *c->row);
            c->sum = bake_grow(c->sum, (size_t)c->room, sizeof *c->sum);
        }
        c->slot[a] = c->count;
        c->row[c->count] = a;
        memset(c->sum[c->count++], 0, sizeof *c->sum);
    }
    for (int i = 0; i < 9; i++) {
        c->sum[c->slot[a]][i] += k[i];
    }
}

static int ascending(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

static double between(const double left[3], const double k[9], const double right[3])
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            sum += left[i] * k[3 * i + j] * right[j];
        }
    }
    return sum;
}

/* Appends the columns of vertex b's coordinates; count: entries so far. */
static int column_emit(const block_column *c, int b, const freedom *f, int count, sparse *out)
{
    for (int j = f->first[b]; j < f->first[b + 1]; j++) {
        for (int r = 0; r < c->count; r++) {
            int a = c->row[r];
            for (int i = a == b ? j : f->first[a]; i < f->first[a + 1]; i++) {
                out->row[count] = i;
                out->value[count++] = between(f->axis[i], c->sum[c->slot[a]], f->axis[j]);
            }
        }
        out->column[j + 1] = count;
    }
    return count;
}

/* Blocks by columns: order[first[b] ..] are those of vertex b. */
static int *sort_blocks(const body_blocks *blocks, int vertex_count, int **first)
{
    int *start = bake_alloc((size_t)vertex_count + 2, sizeof *start);
    int *order = bake_alloc(blocks->count, sizeof *order);
    for (size_t i = 0; i < blocks->count; i++) {
        start[blocks->at[i].b + 2]++;
    }
    for (int b = 0; b < vertex_count; b++) {
        start[b + 2] += start[b + 1];
    }
    for (size_t i = 0; i < blocks->count; i++) {
        order[start[blocks->at[i].b + 1]++] = (int)i;
    }
    *first = start;
    return order;
}

static int check_blocks(const body_blocks *blocks, const freedom *f, bake_error *error)
{
    if (blocks->count > INT_MAX) {
        return bake_fail(error, "a Hessian of %zu blocks is too large", blocks->count);
    }
    for (size_t i = 0; i < blocks->count; i++) {
        const body_block *block = &blocks->at[i];
        double sum = 0;
        for (int k = 0; k < 9; k++) {
            sum += fabs(block->k[k]);
        }
        if (block->b < 0 || block->b > block->a || block->a >= f->vertex_count || !isfinite(sum)) {
            return bake_fail(error, "the Hessian of vertices %d and %d is not finite", block->a,
                             block->b);
        }
    }
    return 0;
}

int sparse_from_blocks(const body_blocks *blocks, const freedom *f, sparse *out, bake_error *error)
{
    static const double zero[9] = {0};
    block_column c = {0};
    int *first, *order, err = 0;
    size_t room = 0;
    memset(out, 0, sizeof *out);
    if (check_blocks(blocks, f, error) < 0) {
        return -1;
    }
    order = sort_blocks(blocks, f->vertex_count, &first);
    c.slot = bake_alloc((size_t)f->vertex_count, sizeof *c.slot);
    memset(c.slot, -1, (size_t)f->vertex_count * sizeof *c.slot);
    out->n = f->count;
    out->column = bake_alloc((size_t)f->count + 1, sizeof *out->column);
    for (int b = 0, count = 0; b < f->vertex_count && err == 0; b++) {
        c.count = 0;
        column_add(&c, b, zero); /* so that the diagonal is there */
        for (int i = first[b]; i < first[b + 1]; i++) {
            column_add(&c, blocks->at[order[i]].a, blocks->at[order[i]].k);
        }
        qsort(c.row, (size_t)c.count, sizeof *c.row, ascending);
        if ((size_t)count + 9 * (size_t)c.count > room) {
            room = 2 * room + 9 * (size_t)c.count;
            out->row = bake_grow(out->row, room, sizeof *out->row);
            out->value = bake_grow(out->value, room, sizeof *out->value);
        }
        count = column_emit(&c, b, f, count, out);
        for (int i = 0; i < c.count; i++) {
            c.slot[c.row[i]] = -1;
        }
        if (count > INT_MAX / 2) {
            err = bake_fail(error, "a matrix of more than 2^30 entries is too large");
        }
    }
    free(order);
    free(first);
    free(c.row);
    free(c.slot);
    free(c.sum);
    if (err < 0) {
        sparse_free(out);
    }
    return err;
}

void sparse_free(sparse *s)
{
    free(s->column);
    free(s->row);
    free(s->value);
    memset(s, 0, sizeof *s);
}

void sparse_multiply(const sparse *s, const double *x, double *y)
{
    memset(y, 0, (size_t)s->n * sizeof *y);
    for (int j = 0; j < s->n; j++) {
        int p = s->column[j];
        double sum = s->value[p] * x[j]; /* the diagonal comes first */
        for (p++; p < s->column[j + 1]; p++) {
            y[s->row[p]] += s->value[p] * x[j];
            sum += s->value[p] * x[s->row[p]];
        }
        y[j] += sum;
    }
}

/* ---- factors --------------------------------------------------------------------------------- */

struct sparse_factor {
    cholmod_common common;
    cholmod_sparse *A; /* a copy, for residuals */
    cholmod_factor *L;
    cholmod_dense *X, *Y, *E; /* work space of cholmod_solve2 */
    double *residual;         /* n x SOLVE_COLUMNS */
};

static int no_memory(int n, bake_error *error)
{
    return bake_fail(error,
                     "the factor of a system of %d unknowns does not fit into memory: use fewer "
                     "elements",
                     n);
}

/* A copy of the matrix and the symbolic factor of its pattern. */
static int analyse(sparse_factor *f, const sparse *s, bake_error *error)
{
    size_t entries = (size_t)s->column[s->n];
    cholmod_free_sparse(&f->A, &f->common);
    cholmod_free_factor(&f->L, &f->common);
    f->common.status = CHOLMOD_OK;
    f->A = cholmod_allocate_sparse((size_t)s->n, (size_t)s->n, entries, 1, 1, -1, CHOLMOD_REAL,
                                   &f->common);
    if (f->A) {
        memcpy(f->A->p, s->column, ((size_t)s->n + 1) * sizeof *s->column);
        memcpy(f->A->i, s->row, entries * sizeof *s->row);
        memcpy(f->A->x, s->value, entries * sizeof *s->value);
        f->L = cholmod_analyze(f->A, &f->common);
    }
    return f->L && f->common.status >= 0 ? 0 : no_memory(s->n, error);
}

sparse_factor *sparse_analyse(const sparse *s, bake_error *error)
{
    sparse_factor *f = bake_alloc(1, sizeof *f);
    openblas_set_num_threads(1); /* sums of several threads have no fixed order */
    cholmod_start(&f->common);
    f->common.print = 0;
    /* The simplicial factor that CHOLMOD may choose is L D L^T, which exists for indefinite
     * matrices too: the supernodal one is the test that the shift search needs. */
    f->common.supernodal = CHOLMOD_SUPERNODAL;
    f->common.quick_return_if_not_posdef = 1;
    f->residual = bake_alloc((size_t)s->n * SOLVE_COLUMNS, sizeof *f->residual);
    if (analyse(f, s, error) < 0) {
        sparse_factor_free(f);
        return NULL;
    }
    return f;
}

static int same_pattern(const sparse_factor *f, const sparse *s)
{
    return (int)f->A->nrow == s->n &&
           memcmp(f->A->p, s->column, ((size_t)s->n + 1) * sizeof *s->column) == 0 &&
           memcmp(f->A->i, s->row, (size_t)s->column[s->n] * sizeof *s->row) == 0;
}

int sparse_refactor(sparse_factor *f, const sparse *s, double shift, const double *d,
                    bake_error *error)
{
    if (s->n != (int)f->L->n) {
        return bake_fail(error, "a factor of %zu unknowns, a matrix of %d", f->L->n, s->n);
    }
    if (!same_pattern(f, s) && analyse(f, s, error) < 0) {
        return -1;
    }
    double *value = f->A->x;
    memcpy(value, s->value, (size_t)s->column[s->n] * sizeof *value);
    for (int j = 0; j < s->n && d; j++) {
        value[s->column[j]] += shift * d[j];
    }
    f->common.status = CHOLMOD_OK;
    cholmod_factorize(f->A, f->L, &f->common);
    if (f->common.status < 0) {
        return no_memory(s->n, error);
    }
    return f->common.status == CHOLMOD_NOT_POSDEF || f->L->minor < f->L->n;
}

void sparse_factor_free(sparse_factor *f)
{
    if (!f) {
        return;
    }
    cholmod_free_sparse(&f->A, &f->common);
    cholmod_free_factor(&f->L, &f->common);
    cholmod_free_dense(&f->X, &f->common);
    cholmod_free_dense(&f->Y, &f->common);
    cholmod_free_dense(&f->E, &f->common);
    cholmod_finish(&f->common);
    free(f->residual);
    free(f);
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

/* f->X = A^-1 B */
static const double *solve(sparse_factor *f, cholmod_dense *B)
{
    if (!cholmod_solve2(CHOLMOD_A, f->L, B, NULL, &f->X, NULL, &f->Y, &f->E, &f->common)) {
        fprintf(stderr, "out of memory: %zu right-hand sides of %zu numbers\n", B->ncol, B->nrow);
        exit(EXIT_FAILURE);
    }
    return f->X->x;
}

void sparse_solve_plain(sparse_factor *f, double *x, int count)
{
    int n = (int)f->A->nrow;
    for (int i = 0; i < count; i += SOLVE_COLUMNS) {
        int columns = count - i < SOLVE_COLUMNS ? count - i : SOLVE_COLUMNS;
        double *at = x + (size_t)i * (size_t)n;
        cholmod_dense B = dense(n, columns, at);
        memcpy(at, solve(f, &B), (size_t)columns * (size_t)n * sizeof *x);
    }
}

void sparse_solve(sparse_factor *f, double *x, int count)
{
    int n = (int)f->A->nrow;
    double one[2] = {1, 0}, minus[2] = {-1, 0};
    for (int i = 0; i < count; i += SOLVE_COLUMNS) {
        int columns = count - i < SOLVE_COLUMNS ? count - i : SOLVE_COLUMNS;
        double *at = x + (size_t)i * (size_t)n;
        size_t size = (size_t)columns * (size_t)n;
        cholmod_dense B = dense(n, columns, at), R = dense(n, columns, f->residual);
        memcpy(f->residual, at, size * sizeof *x);
        memcpy(at, solve(f, &B), size * sizeof *x);
        cholmod_sdmult(f->A, 0, minus, one, &B, &R, &f->common); /* R = B - A X */
        const double *correction = solve(f, &R);
        for (size_t k = 0; k < size; k++) {
            at[k] += correction[k];
        }
    }
}
