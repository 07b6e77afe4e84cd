/* Solutions on a free set that changes a little: the factor of an older one and a border of what came
 * and went. With F the factor's rows, N new ones, G those gone:
 *   | Q_FF  Q_FN  E_G | | x_F |   | r_F |
 *   | Q_NF  Q_NN   0  | | x_N | = | r_N |    S = | Q_NN 0 | - U^T V,  V = Q_FF^-1 U,  U = (Q_FN E_G)
 *   | E_G^T  0     0  | | mu  |   |  0  |        |  0   0 |
 * Source: Gill, Murray, Saunders, Wright 1990 (Schur complements for active sets).
 *
 *   V  F x c     S  c x c, positive definite in N, negative in G
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <stdlib.h>
#include <string.h>

/* Right-hand sides that go through the factor together. */
#define COLUMNS 16

static int renew(bounded_desk *desk, bounded_border *f, const char *state)
{
    const bounded_system *s = f->s;
    char *member = bake_alloc((size_t)s->n, 1);
    int count = 0;
    bounded_factor_free(desk, &f->factor);
    if (!f->list) {
        f->list = bake_alloc((size_t)s->n, sizeof *f->list);
        f->place = bake_alloc((size_t)s->n, sizeof *f->place);
        f->slot = bake_alloc((size_t)s->n, sizeof *f->slot);
    }
    for (int i = 0; i < s->n; i++) {
        member[i] = state[i] == BOUNDED_FREE_VERTEX;
        f->slot[i] = -1;
        f->place[i] = member[i] ? count : -1;
        if (member[i]) {
            f->list[count++] = i;
        }
    }
    f->count = 0;
    f->made++;
    int result = bounded_factor_make(desk, s, member, NULL, &f->factor);
    free(member);
    return result;
}

static int differs(const bounded_border *f, const char *state, int i)
{
    return (f->place[i] >= 0) != (state[i] == BOUNDED_FREE_VERTEX);
}

static void column_fill(const bounded_border *f, int i, double *u)
{
    const bounded_system *s = f->s;
    memset(u, 0, (size_t)f->factor.n * sizeof *u);
    if (f->place[i] >= 0) {
        u[f->place[i]] = 1;
        return;
    }
    for (int p = s->column[i]; p < s->column[i + 1]; p++) {
        if (f->place[s->row[p]] >= 0) {
            u[f->place[s->row[p]]] = s->value[p];
        }
    }
}

/* Columns of V for what has changed and has none yet. */
static int extend(bounded_desk *desk, bounded_border *f, const char *state)
{
    size_t n = (size_t)f->factor.n;
    int first = f->count;
    for (int i = 0; i < f->s->n; i++) {
        if (differs(f, state, i) && f->slot[i] < 0) {
            if (f->count == f->room) {
                f->room = 2 * f->room + 64;
                f->changed = bake_grow(f->changed, (size_t)f->room, sizeof *f->changed);
            }
            f->slot[i] = f->count;
            f->changed[f->count++] = i;
        }
    }
    f->V = bake_grow(f->V, n * (size_t)f->count, sizeof *f->V);
    for (int k = first; k < f->count; k++) {
        column_fill(f, f->changed[k], f->V + n * (size_t)k);
    }
    for (int k = first; k < f->count; k += COLUMNS) {
        int columns = f->count - k < COLUMNS ? f->count - k : COLUMNS;
        if (bounded_factor_solve(desk, &f->factor, f->V + n * (size_t)k, columns) < 0) {
            return -1;
        }
    }
    return 0;
}

int bounded_border_set(bounded_desk *desk, bounded_border *f, const char *state)
{
    int count = 0;
    if (!f->list) {
        return renew(desk, f, state);
    }
    for (int i = 0; i < f->s->n; i++) {
        count += differs(f, state, i) && f->slot[i] < 0;
    }
    return f->count + count > f->factor.columns ? renew(desk, f, state) : extend(desk, f, state);
}

/* u_i^T v, u_i the column of what changed at row i */
static double times(const bounded_border *f, int i, const double *v)
{
    const bounded_system *s = f->s;
    double sum = 0;
    if (f->place[i] >= 0) {
        return v[f->place[i]];
    }
    for (int p = s->column[i]; p < s->column[i + 1]; p++) {
        if (f->place[s->row[p]] >= 0) {
            sum += s->value[p] * v[f->place[s->row[p]]];
        }
    }
    return sum;
}

static double entry(const bounded_system *s, int i, int j)
{
    for (int p = s->column[i]; p < s->column[i + 1]; p++) {
        if (s->row[p] == j) {
            return s->value[p];
        }
    }
    return 0;
}

/* y = S^-1 y; at: rows that differ now. */
static int solve_border(const bounded_border *f, const int *at, int count, double *y)
{
    size_t n = (size_t)f->factor.n, c = (size_t)count;
    double *S = bake_alloc(c * c, sizeof *S);
    int *pivot = bake_alloc(c, sizeof *pivot);
    for (size_t k = 0; k < c; k++) {
        const double *v = f->V + n * (size_t)f->slot[at[k]];
        for (size_t l = k; l < c; l++) {
            int both = f->place[at[k]] < 0 && f->place[at[l]] < 0;
            S[k * c + l] = (both ? entry(f->s, at[l], at[k]) : 0) - times(f, at[l], v);
        }
    }
    int info = LAPACKE_dsysv(LAPACK_COL_MAJOR, 'L', count, 1, S, count, pivot, y, count);
    free(S);
    free(pivot);
    return info ? 1 : 0;
}

/* x: what Q x is to be on free rows; then x, 0 on others. */
int bounded_border_solve(bounded_desk *desk, bounded_border *f, const char *state, double *x)
{
    const bounded_system *s = f->s;
    size_t n = (size_t)f->factor.n;
    double *t = bake_alloc(n, sizeof *t), *y = bake_alloc((size_t)f->count, sizeof *y);
    int *at = bake_alloc((size_t)f->count, sizeof *at), count = 0, result;
    for (size_t k = 0; k < n; k++) {
        t[k] = state[f->list[k]] == BOUNDED_FREE_VERTEX ? x[f->list[k]] : 0;
    }
    result = bounded_factor_solve(desk, &f->factor, t, 1);
    for (int k = 0; k < f->count; k++) {
        int i = f->changed[k];
        if (differs(f, state, i)) {
            y[count] = (f->place[i] < 0 ? x[i] : 0) - times(f, i, t);
            at[count++] = i;
        }
    }
    if (count && result == 0) {
        result = solve_border(f, at, count, y);
    }
    memset(x, 0, (size_t)s->n * sizeof *x);
    for (int k = 0; k < count; k++) {
        cblas_daxpy((int)n, -y[k], f->V + n * (size_t)f->slot[at[k]], 1, t, 1);
        x[at[k]] = f->place[at[k]] < 0 ? y[k] : 0;
    }
    for (size_t k = 0; k < n; k++) {
        x[f->list[k]] = state[f->list[k]] == BOUNDED_FREE_VERTEX ? t[k] : 0;
    }
    free(t);
    free(y);
    free(at);
    return result;
}

void bounded_border_free(bounded_desk *desk, bounded_border *f)
{
    bounded_factor_free(desk, &f->factor);
    free(f->list);
    free(f->place);
    free(f->slot);
    free(f->changed);
    free(f->V);
    memset(f, 0, sizeof *f);
}
