/* Linear dynamic models in a reduced space, and the reduced Hessian they come from.
 * Source: Schulz 2013, (2.10)-(2.12), (2.35)-(2.36). Own: the models count c from the space's
 * origin.
 *   K    d x d   V^T d2V(z) V, symmetric       Phi  d x d   K Phi = Phi diag(lambda), Phi^T Phi = 1
 * About z the coordinates u = c - Phi^T q_z obey
 *   u'' + 2 delta u' + s lambda u + s Phi^T V^T dV(z) - Phi^T V^T force = 0,
 * so that in c, inner = Phi^T V^T dV(z) - lambda Phi^T q_z and outer = -Phi^T V^T force.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "space.h"

#include <cblas.h>
#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- V^T K V ----------------------------------------------------------------------------------- */

/* Columns of V taken together: the inner loop has a constant length and vectorises. */
#define PANEL 16

typedef double panel_row[PANEL];

static int vertex_of(const body_block *block, int side)
{
    return side ? block->a : block->b;
}

/* Places of blocks in ascending order of their vertex on one side; those of one vertex stay in
 * order. */
static void sort_side(const body_blocks *K, int vertices, int side, const size_t *from, size_t *to)
{
    size_t *next = bake_alloc((size_t)vertices + 1, sizeof *next);
    for (size_t i = 0; i < K->count; i++)
        next[vertex_of(&K->at[i], side) + 1]++;
    for (int v = 0; v < vertices; v++)
        next[v + 1] += next[v];
    for (size_t i = 0; i < K->count; i++)
        to[next[vertex_of(&K->at[from[i]], side)]++] = from[i];
    free(next);
}

/* One block a pair, by rows: elements share edges and vertices, and each panel reads all blocks. */
static body_block *merged(const body_blocks *K, int vertices, size_t *count)
{
    body_block *all = bake_alloc(K->count + 1, sizeof *all);
    size_t *order = bake_alloc(2 * K->count + 1, sizeof *order), *other = order + K->count, n = 0;
    for (size_t i = 0; i < K->count; i++)
        other[i] = i;
    sort_side(K, vertices, 0, other, order);
    sort_side(K, vertices, 1, order, other);
    for (size_t i = 0; i < K->count; i++) {
        const body_block *next = &K->at[other[i]];
        if (n && all[n - 1].a == next->a && all[n - 1].b == next->b) {
            for (int k = 0; k < 9; k++)
                all[n - 1].k[k] += next->k[k];
        } else {
            all[n++] = *next;
        }
    }
    free(order);
    *count = n;
    return all;
}

/* Y = K X for rows a of Y and b of X: k, or its transpose. */
static void block_times(const double k[9], int transposed, const panel_row *X, panel_row *Y)
{
    int row = transposed ? 1 : 3, column = transposed ? 3 : 1;
    for (int i = 0; i < 3; i++) {
        double k0 = k[i * row], k1 = k[i * row + column], k2 = k[i * row + 2 * column];
        for (int j = 0; j < PANEL; j++)
            Y[i][j] += k0 * X[0][j] + k1 * X[1][j] + k2 * X[2][j];
    }
}

/* Columns `first` .. of V^T K V: V^T times the panel K V. X, Y: n rows. */
static void reduce_panel(const space *s, const body_block *at, size_t count, int first,
                         panel_row *work, double *out)
{
    int n = s->n, width = s->d - first < PANEL ? s->d - first : PANEL;
    panel_row *X = work, *Y = work + n;
    memset(work, 0, 2 * (size_t)n * sizeof *work);
    for (int j = 0; j < width; j++) {
        const double *v = s->V + (size_t)n * (size_t)(first + j);
        for (int i = 0; i < n; i++)
            X[i][j] = v[i];
    }
    for (size_t b = 0; b < count; b++) {
        const body_block *block = &at[b];
        block_times(block->k, 0, X + 3 * (size_t)block->b, Y + 3 * (size_t)block->a);
        if (block->a != block->b)
            block_times(block->k, 1, X + 3 * (size_t)block->a, Y + 3 * (size_t)block->b);
    }
    cblas_dgemm(CblasColMajor, CblasTrans, CblasTrans, s->d, width, n, 1, s->V, n, &Y[0][0], PANEL,
                0, out + (size_t)s->d * (size_t)first, s->d);
}

static void make_symmetric(double *out, size_t d)
{
    for (size_t i = 0; i < d; i++) {
        for (size_t j = 0; j < i; j++)
            out[i * d + j] = out[j * d + i] = (out[i * d + j] + out[j * d + i]) / 2;
    }
}

void space_reduce_blocks(const space *s, const body_blocks *K, double *out)
{
    size_t count, d = (size_t)s->d;
    body_block *blocks = merged(K, s->n / 3, &count);
    panel_row *work = bake_alloc(2 * (size_t)s->n, sizeof *work);
    for (int first = 0; first < s->d; first += PANEL)
        reduce_panel(s, blocks, count, first, work, out);
    make_symmetric(out, d);
    free(work);
    free(blocks);
}

void space_reduce_dense(const space *s, const double *K, double *out)
{
    double *KV = bake_alloc((size_t)s->n * (size_t)s->d, sizeof *KV);
    cblas_dsymm(CblasColMajor, CblasLeft, CblasUpper, s->n, s->d, 1, K, s->n, s->V, s->n, 0, KV,
                s->n);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, s->d, s->d, s->n, 1, s->V, s->n, KV, s->n,
                0, out, s->d);
    make_symmetric(out, (size_t)s->d);
    free(KV);
}

/* ---- models ------------------------------------------------------------------------------------ */

static void allocate(int d, linear_model *out)
{
    size_t n = (size_t)d;
    out->d = d;
    out->lambda = bake_alloc(n, sizeof *out->lambda);
    out->inner = bake_alloc(n, sizeof *out->inner);
    out->outer = bake_alloc(n, sizeof *out->outer);
    out->Phi = bake_alloc(n * n, sizeof *out->Phi);
}

/* |K Phi - Phi Lambda| relative to |K|: dsyevd promises some d eps. */
static double residual(int d, const double *K, const linear_model *m)
{
    size_t n = (size_t)d;
    double most = 0, scale = 0, *P = bake_alloc(n * n, sizeof *P);
    cblas_dsymm(CblasColMajor, CblasLeft, CblasUpper, d, d, 1, K, d, m->Phi, d, 0, P, d);
    for (size_t i = 0; i < n * n; i++) {
        most = fmax(most, fabs(P[i] - m->lambda[i / n] * m->Phi[i]));
        scale = fmax(scale, fabs(K[i]));
    }
    free(P);
    return scale > 0 ? most / scale : 0;
}

/* Ascending eigenvalues, signs as in modes.h. */
static int decouple(int d, const double *K, linear_model *out, bake_error *error)
{
    size_t n = (size_t)d;
    memcpy(out->Phi, K, n * n * sizeof *K);
    for (size_t i = 0; i < n * n; i++) {
        if (!isfinite(K[i]))
            return bake_fail(error, "the stiffness of the reduced model is not a number");
    }
    int info = d ? LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'U', d, out->Phi, d, out->lambda) : 0;
    double left = info == 0 ? residual(d, K, out) : HUGE_VAL;
    if (!(left <= 64 * d * DBL_EPSILON))
        return bake_fail(error,
                         "the %d modes of the reduced model were not found (LAPACK's dsyevd "
                         "says %d, residual %.1e)",
                         d, info, left);
    for (int j = 0; j < d; j++) {
        double *phi = out->Phi + n * (size_t)j;
        if (phi[cblas_idamax(d, phi, 1)] < 0)
            cblas_dscal(d, -1, phi, 1);
    }
    return 0;
}

int linear_model_make(const linear_terms *at, linear_model *out, bake_error *error)
{
    int d = at->d;
    allocate(d, out);
    if (decouple(d, at->K, out, error) < 0) {
        linear_model_free(out);
        return -1;
    }
    double *c_z = bake_alloc((size_t)d + 1, sizeof *c_z), largest = 0;
    linear_model_project(out, at->q_z, c_z);
    linear_model_project(out, at->gradient, out->inner);
    linear_model_project(out, at->force, out->outer);
    for (int i = 0; i < d; i++)
        largest = fmax(largest, fabs(out->lambda[i]));
    /* Whatever the caller knows of K, its eigenvalues are off by some d eps |K|. */
    double noise = fmax(at->noise, d * DBL_EPSILON * largest);
    for (int i = 0; i < d; i++) {
        out->lambda[i] = fabs(out->lambda[i]) <= noise ? 0 : out->lambda[i];
        out->inner[i] -= out->lambda[i] * c_z[i];
        out->outer[i] = -out->outer[i];
    }
    free(c_z);
    return 0;
}

void linear_model_plain(int d, linear_model *out)
{
    allocate(d, out);
    for (int i = 0; i < d; i++)
        out->Phi[(size_t)i * (size_t)d + (size_t)i] = 1;
}

void linear_model_free(linear_model *m)
{
    free(m->lambda);
    free(m->inner);
    free(m->outer);
    free(m->Phi);
    memset(m, 0, sizeof *m);
}

void linear_model_project(const linear_model *m, const double *q, double *c)
{
    cblas_dgemv(CblasColMajor, CblasTrans, m->d, m->d, 1, m->Phi, m->d, q, 1, 0, c, 1);
}
