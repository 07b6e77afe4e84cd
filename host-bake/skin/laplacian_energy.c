/* Energies of weights: products of stiffness matrices with the inverse mass between them.
 * Source: Jacobson 2013, 4.3.4 (4.8), 5.7; with K, not the thesis's L, so that odd orders are
 * positive semidefinite too.
 *   K  n x n  stiffness     M  n  masses     S  n x n  K, or what it has become so far
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "laplacian.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

static sparse copy(const sparse *s)
{
    size_t entries = (size_t)s->column[s->n];
    sparse out = {s->n, bake_alloc((size_t)s->n + 1, sizeof *out.column),
                  bake_alloc(entries, sizeof *out.row), bake_alloc(entries, sizeof *out.value)};
    memcpy(out.column, s->column, ((size_t)s->n + 1) * sizeof *out.column);
    memcpy(out.row, s->row, entries * sizeof *out.row);
    memcpy(out.value, s->value, entries * sizeof *out.value);
    return out;
}

/* Both triangles, rows ascending. */
static sparse both_triangles(const sparse *s)
{
    int n = s->n, *next = bake_alloc((size_t)n + 1, sizeof *next);
    size_t entries = 2 * (size_t)s->column[n] - (size_t)n;
    sparse out = {n, bake_alloc((size_t)n + 1, sizeof *out.column),
                  bake_alloc(entries, sizeof *out.row), bake_alloc(entries, sizeof *out.value)};
    for (int j = 0; j < n; j++)
        for (int p = s->column[j]; p < s->column[j + 1]; p++) {
            out.column[j + 1]++;
            out.column[s->row[p] + 1] += s->row[p] != j;
        }
    for (int j = 0; j < n; j++) {
        out.column[j + 1] += out.column[j];
        next[j] = out.column[j];
    }
    /* what is above the diagonal of a column comes from earlier ones, so it is there already */
    for (int j = 0; j < n; j++)
        for (int p = s->column[j]; p < s->column[j + 1]; p++) {
            int i = s->row[p];
            out.row[next[j]] = i;
            out.value[next[j]++] = s->value[p];
            if (i != j) {
                out.row[next[i]] = j;
                out.value[next[i]++] = s->value[p];
            }
        }
    free(next);
    return out;
}

static int ascending(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

/* A column in the making: the rows that were met, their sums, and whether they were: met[row] is
 * the last column that met it, counted from 1. Each n. */
typedef struct {
    int *rows, *met;
    double *sum;
} column;

/* Column j of S M^-1 K from its diagonal on: its rows, ascending; how many. */
static int product_column(const sparse *S, const sparse *K, const double *mass, int j, column *out)
{
    int count = 0;
    for (int q = K->column[j]; q < K->column[j + 1]; q++) {
        int k = K->row[q];
        double factor = K->value[q] / mass[k];
        for (int p = S->column[k + 1] - 1; p >= S->column[k] && S->row[p] >= j; p--) {
            int row = S->row[p];
            if (out->met[row] != j + 1) {
                out->met[row] = j + 1;
                out->rows[count++] = row;
            }
            out->sum[row] += S->value[p] * factor;
        }
    }
    qsort(out->rows, (size_t)count, sizeof *out->rows, ascending);
    return count;
}

/* The lower triangle of S M^-1 K, which is symmetric. S, K: both triangles. */
static int multiply(const sparse *S, const sparse *K, const double *mass, sparse *out,
                    bake_error *error)
{
    int n = K->n, err = 0;
    column c = {bake_alloc((size_t)n, sizeof *c.rows), bake_alloc((size_t)n, sizeof *c.met),
                bake_alloc((size_t)n, sizeof *c.sum)};
    size_t room = 0;
    *out = (sparse){.n = n, .column = bake_alloc((size_t)n + 1, sizeof *out->column)};
    for (int j = 0; j < n && err == 0; j++) {
        int start = out->column[j], count = product_column(S, K, mass, j, &c);
        if (start > INT_MAX / 4) {
            err = bake_fail(error, "an energy of more than 2^29 entries is too large: use fewer "
                                   "elements");
            break;
        }
        if ((size_t)start + (size_t)count > room) {
            room = 2 * room + (size_t)count;
            out->row = bake_grow(out->row, room, sizeof *out->row);
            out->value = bake_grow(out->value, room, sizeof *out->value);
        }
        for (int i = 0; i < count; i++) {
            out->row[start + i] = c.rows[i];
            out->value[start + i] = c.sum[c.rows[i]];
            c.sum[c.rows[i]] = 0;
        }
        out->column[j + 1] = start + count;
    }
    free(c.rows);
    free(c.met);
    free(c.sum);
    if (err < 0)
        sparse_free(out);
    return err;
}

int laplacian_energy(const sparse *k, const double *mass, int order, sparse *out, bake_error *error)
{
    int err = 0;
    if (order < 1 || order > 3)
        return bake_fail(error, "an energy of order %d: expected 1, 2 or 3", order);
    for (int v = 0; v < k->n; v++)
        if (!(mass[v] > 0))
            return bake_fail(error, "vertex %d has a mass of %g: expected more than 0", v, mass[v]);
    *out = copy(k);
    sparse K = both_triangles(k);
    for (int i = 1; i < order && err == 0; i++) {
        sparse S = both_triangles(out);
        sparse_free(out);
        err = multiply(&S, &K, mass, out, error);
        sparse_free(&S);
    }
    sparse_free(&K);
    return err;
}
