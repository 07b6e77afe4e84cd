/* Directions for a tolerance on the largest error.
 * Source: own, on Alexa 2002, 7.2.1. Principal components leave the least sum of squares; what is
 * asked for here is the least largest distance, and that sits in few vertices of few frames. These
 * gain weight round by round [Lawson 1961, for rows and columns of a matrix]: as many bases then
 * leave less, or fewer as much. Bases are no longer orthonormal, nor need they be: whoever stores
 * them fits the weights anew.
 *   E   rows x q   leading principal components     C   q x n   their weights: F = E C
 *   u   a vertex   w  a frame                       M   q x q   E^T diag(u^2) E = L L^T
 *   P   q x t      leading left singular vectors of L^T C diag(w)
 *   B   rows x t   E L^-T P                          W   t x n   P^T L^T C: F = B W for t = q
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Most of what rounds gain is gained in the first ones. */
#define WEIGHINGS 12

/* Components that no column has more of than this share of the limit are left out, and those beyond
 * so many. */
#define NEGLECTED  0.02
#define COMPONENTS 256

/* A round multiplies a weight by (FLOOR + its error's share of the largest)^PACE. */
#define FLOOR 0.3
#define PACE  0.3

typedef struct {
    const shape_reduction *r;
    shape_span span;
    int rank, most;  /* q, t */
    const double *E; /* as above, column-major */
    double *C, *u, *w;
    double *B, *W;          /* of the last round */
    double *vertex, *frame; /* largest errors */
    double *rest;           /* a column */
} weighing;

/* Largest error with the first k directions; of each vertex and frame. */
static double look(weighing *g, int k)
{
    const shape_reduction *r = g->r;
    size_t rows = (size_t)r->rows;
    double worst = 0;
    memset(g->vertex, 0, rows / 3 * sizeof *g->vertex);
    for (int f = 0; f < g->span.count; f++) {
        int column = g->span.first + f;
        memcpy(g->rest, r->residual + rows * (size_t)column, rows * sizeof *g->rest);
        if (k > 0) {
            cblas_dgemv(CblasColMajor, CblasNoTrans, r->rows, k, -1, g->B, r->rows,
                        g->W + (size_t)f * (size_t)g->most, 1, 1, g->rest, 1);
        }
        g->frame[f] = 0;
        for (size_t i = 0; i < rows / 3; i++) {
            double e = shape_distance(r->turn ? &r->turn[column] : NULL, g->rest + 3 * i);
            g->vertex[i] = fmax(g->vertex[i], e);
            g->frame[f] = fmax(g->frame[f], e);
        }
        worst = fmax(worst, g->frame[f]);
    }
    return worst;
}

/* L of M, lower; 0 when rounding made M indefinite. */
static int weigh_rows(const weighing *g, double *L)
{
    size_t rows = (size_t)g->r->rows;
    double *scaled = bake_alloc(rows * (size_t)g->rank, sizeof *scaled);
    for (size_t i = 0; i < rows * (size_t)g->rank; i++) {
        scaled[i] = g->u[i % rows / 3] * g->E[i];
    }
    cblas_dsyrk(CblasColMajor, CblasLower, CblasTrans, g->rank, g->r->rows, 1, scaled, g->r->rows,
                0, L, g->rank);
    free(scaled);
    return LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'L', g->rank, L, g->rank) == 0;
}

/* P: the leading eigenvectors of D diag(w^2) D^T, D = L^T C, the largest last. */
static int lead(const weighing *g, const double *D, double *P)
{
    int q = g->rank, n = g->span.count, found;
    size_t size = (size_t)q * (size_t)n;
    double *scaled = bake_alloc(size, sizeof *scaled), *lambda = bake_alloc((size_t)q, sizeof *P);
    double *G = bake_alloc((size_t)q * (size_t)q, sizeof *G);
    int *support = bake_alloc(2 * (size_t)q, sizeof *support);
    for (size_t i = 0; i < size; i++) {
        scaled[i] = g->w[i / (size_t)q] * D[i];
    }
    cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, q, n, 1, scaled, q, 0, G, q);
    int info = LAPACKE_dsyevr(LAPACK_COL_MAJOR, 'V', 'I', 'L', q, G, q, 0, 0, q - g->most + 1, q, 0,
                              &found, lambda, P, q, support);
    free(scaled);
    free(lambda);
    free(G);
    free(support);
    return info == 0 && found == g->most;
}

/* B and W of the weights; 0 when LAPACK gives up. */
static int directions(weighing *g)
{
    int q = g->rank, n = g->span.count, t = g->most, good;
    double *L = bake_alloc((size_t)q * (size_t)q, sizeof *L);
    double *D = bake_alloc((size_t)q * (size_t)n, sizeof *D);
    double *P = bake_alloc((size_t)q * (size_t)q, sizeof *P);
    memcpy(D, g->C, (size_t)q * (size_t)n * sizeof *D);
    good = weigh_rows(g, L);
    cblas_dtrmm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, q, n, 1, L, q, D,
                q);
    good = good && lead(g, D, P);
    for (int i = 0; good && i < t / 2; i++) { /* the largest first */
        cblas_dswap(q, P + (size_t)i * (size_t)q, 1, P + (size_t)(t - 1 - i) * (size_t)q, 1);
    }
    if (good) {
        cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, t, n, q, 1, P, q, D, q, 0, g->W, t);
        cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasTrans, CblasNonUnit, q, t, 1, L, q,
                    P, q);
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, g->r->rows, t, q, 1, g->E,
                    g->r->rows, P, q, 0, g->B, g->r->rows);
    }
    free(L);
    free(D);
    free(P);
    return good;
}

static void reweigh(double *weight, const double *error, int count, double worst)
{
    for (int i = 0; i < count; i++) {
        weight[i] *= pow(FLOOR + error[i] / worst, PACE);
    }
}

/* Fewer directions than `need` round by round, those of the best round in `best`. */
static int tighten(weighing *g, int need, double limit, double *best)
{
    for (int round = 0; round < WEIGHINGS && need > 0; round++) {
        double worst = look(g, need - 1);
        while (worst <= limit && need > 0) {
            memcpy(best, g->B, (size_t)g->r->rows * (size_t)g->most * sizeof *best);
            need--;
            worst = need > 0 ? look(g, need - 1) : 0;
        }
        if (need == 0) {
            break;
        }
        reweigh(g->u, g->vertex, g->r->rows / 3, worst);
        reweigh(g->w, g->frame, g->span.count, worst);
        if (!directions(g)) {
            break;
        }
    }
    return need;
}

/* The fewest plain components, or most + 1. */
static int enough(weighing *g, double limit)
{
    int low = 0, high = g->most + 1;
    while (low < high) {
        int k = (low + high) / 2;
        if (k <= g->most && look(g, k) > limit) {
            low = k + 1;
        } else {
            high = k;
        }
    }
    return low;
}

/* How many components count. */
static int components(const shape_reduction *r, shape_span span, const shape_pca *pca, double limit)
{
    int q = pca->rank < COMPONENTS ? pca->rank : COMPONENTS;
    double *left = bake_alloc((size_t)span.count, sizeof *left);
    for (double most = 0; q > 1; q--) {
        for (int f = 0; f < span.count; f++) {
            double w = pca->W[(size_t)(q - 1) + (size_t)f * (size_t)pca->rank];
            double wide = r->turn ? shape_stretch(r->turn[span.first + f].A) : 1;
            left[f] += w * w * wide * wide;
            most = fmax(most, left[f]);
        }
        if (most > NEGLECTED * NEGLECTED * limit * limit) {
            break;
        }
    }
    free(left);
    return q;
}

static void weighing_open(weighing *g, const shape_reduction *r, shape_span span,
                          const shape_pca *pca)
{
    size_t n = (size_t)span.count, q = (size_t)g->rank;
    g->r = r;
    g->span = span;
    g->E = pca->B;
    g->C = bake_alloc(q * n, sizeof *g->C);
    g->u = bake_alloc((size_t)r->rows / 3, sizeof *g->u);
    g->w = bake_alloc(n, sizeof *g->w);
    g->B = bake_alloc((size_t)r->rows * (size_t)g->most, sizeof *g->B);
    g->W = bake_alloc((size_t)g->most * n, sizeof *g->W);
    g->vertex = bake_alloc((size_t)r->rows / 3, sizeof *g->vertex);
    g->frame = bake_alloc(n, sizeof *g->frame);
    g->rest = bake_alloc((size_t)r->rows, sizeof *g->rest);
    for (int i = 0; i < r->rows / 3; i++) {
        g->u[i] = 1;
    }
    for (size_t f = 0; f < n; f++) { /* frames that are only projected stay at 0 */
        g->w[f] = f % (size_t)r->every == 0;
        memcpy(g->C + q * f, pca->W + (size_t)pca->rank * f, q * sizeof *g->C);
        memcpy(g->W + (size_t)g->most * f, pca->W + (size_t)pca->rank * f,
               (size_t)g->most * sizeof *g->W);
    }
    memcpy(g->B, pca->B, (size_t)r->rows * (size_t)g->most * sizeof *g->B);
}

static void weighing_close(weighing *g)
{
    free(g->C);
    free(g->u);
    free(g->w);
    free(g->B);
    free(g->W);
    free(g->vertex);
    free(g->frame);
    free(g->rest);
}

int shape_weigh(const shape_reduction *r, shape_span span, double limit, shape_directions *out,
                bake_error *error)
{
    shape_pca pca;
    weighing g;
    if (shape_pca_make(r->residual + (size_t)span.first * (size_t)r->rows, r->rows, span.count,
                       r->every, &pca, error) < 0) {
        return -1;
    }
    g.rank = components(r, span, &pca, limit);
    g.most = r->most - r->count < g.rank ? r->most - r->count : g.rank;
    weighing_open(&g, r, span, &pca);
    size_t size = (size_t)r->rows * (size_t)g.most;
    int plain = enough(&g, limit);
    out->count = g.most;
    out->B = bake_alloc(size, sizeof *out->B);
    memcpy(out->B, g.B, size * sizeof *out->B);
    out->enough = tighten(&g, plain, limit, out->B);
    weighing_close(&g);
    shape_pca_free(&pca);
    return 0;
}
