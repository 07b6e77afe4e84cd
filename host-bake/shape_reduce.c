/* As few stored bases as a tolerance takes.
 * Source: own, on Alexa 2002, 7.2.1. A basis is rounded to 8 or 16 bits before the next one is
 * found: the next one is the leading direction of what is left, rounding included, so that what a
 * basis lost is a later one's to give back.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of power iteration. The start is a principal component of the original frames or a frame that is
 * badly off; with singular values a ratio q apart the wrong part shrinks by q^32. Directions closer
 * together than that are as good as each other. */
#define ITERATIONS 16

double shape_entry(int bits, int16_t entry)
{
    return entry / (bits == 8 ? 127.0 * 256 : 32767.0);
}

double shape_quantise(const double *vector, int rows, int bits, int16_t *entry)
{
    double top = 0, steps = bits == 8 ? 127 : 32767;
    for (int i = 0; i < rows; i++) {
        top = fmax(top, fabs(vector[i]));
    }
    for (int i = 0; i < rows; i++) {
        double e = top > 0 ? floor(vector[i] / top * steps + 0.5) : 0;
        entry[i] = (int16_t)(bits == 8 ? 256 * e : e);
    }
    return top;
}

static double *column(const shape_reduction *r, int f)
{
    return r->residual + (size_t)f * (size_t)r->rows;
}

static double distance(const shape_affine *turn, const double d[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double e = turn ? cblas_ddot(3, &turn->A[3 * k], 1, d, 1) : d[k];
        sum += e * e;
    }
    return sqrt(sum);
}

static double column_worst(const shape_reduction *r, int f)
{
    double worst = 0;
    for (int i = 0; i < r->rows; i += 3) {
        worst = fmax(worst, distance(r->turn ? &r->turn[f] : NULL, column(r, f) + i));
    }
    return worst;
}

double shape_reduction_worst(const shape_reduction *r, shape_span span)
{
    double worst = 0;
    for (int f = span.first; f < span.first + span.count; f++) {
        worst = fmax(worst, column_worst(r, f));
    }
    return worst;
}

/* The leading direction of the columns first, first + every, ... of the span, from a start. 0 when
 * nothing is left. */
static int leading(const shape_reduction *r, shape_span span, double *direction)
{
    int kept = (span.count + r->every - 1) / r->every, stride = r->rows * r->every;
    double *inner = bake_alloc((size_t)kept, sizeof *inner), norm = 0;
    for (int i = 0; i < ITERATIONS; i++) {
        cblas_dgemv(CblasColMajor, CblasTrans, r->rows, kept, 1, column(r, span.first), stride,
                    direction, 1, 0, inner, 1);
        cblas_dgemv(CblasColMajor, CblasNoTrans, r->rows, kept, 1, column(r, span.first), stride,
                    inner, 1, 0, direction, 1);
        norm = cblas_dnrm2(r->rows, direction, 1);
        if (!(norm > 0)) {
            break;
        }
        cblas_dscal(r->rows, 1 / norm, direction, 1);
    }
    free(inner);
    return norm > 0;
}

/* The stored basis, with 1 where it is largest. */
static void stored(const shape_reduction *r, const shape_basis *b, double *vector)
{
    for (int i = 0; i < r->rows; i++) {
        vector[i] = shape_entry(r->bits, b->entry[i]);
    }
}

static void subtract(shape_reduction *r, shape_span span, const double *direction, int piece)
{
    shape_basis *b = &r->basis[r->count++];
    double *vector = bake_alloc((size_t)r->rows, sizeof *vector);
    b->piece = piece;
    b->scale = 1;
    b->entry = bake_alloc((size_t)r->rows, sizeof *b->entry);
    b->weight = bake_alloc((size_t)r->columns, sizeof *b->weight);
    shape_quantise(direction, r->rows, r->bits, b->entry);
    stored(r, b, vector);
    double square = cblas_ddot(r->rows, vector, 1, vector, 1);
    for (int f = span.first; f < span.first + span.count; f++) {
        b->weight[f] = cblas_ddot(r->rows, vector, 1, column(r, f), 1) / square;
        cblas_daxpy(r->rows, -b->weight[f], vector, 1, column(r, f), 1);
    }
    free(vector);
}

/* The frame that is farthest off, for where the principal components end. */
static void worst_column(const shape_reduction *r, shape_span span, double *direction)
{
    int at = span.first;
    double most = -1;
    for (int f = span.first; f < span.first + span.count; f += r->every) {
        double w = column_worst(r, f);
        at = w > most ? f : at;
        most = fmax(w, most);
    }
    memcpy(direction, column(r, at), (size_t)r->rows * sizeof *direction);
}

/* Weights of all bases that serve the span, by least squares: G x = Q^T residual corrects them. */
static void refit(shape_reduction *r, shape_span span, int piece)
{
    int used = 0, *which = bake_alloc((size_t)r->count + 1, sizeof *which);
    size_t rows = (size_t)r->rows;
    double *Q = bake_alloc(rows * ((size_t)r->count + 1), sizeof *Q);
    for (int j = 0; j < r->count; j++) {
        if (r->basis[j].piece < 0 || r->basis[j].piece == piece) {
            stored(r, &r->basis[j], Q + rows * (size_t)used);
            which[used++] = j;
        }
    }
    double *G = bake_alloc((size_t)used * (size_t)used + 1, sizeof *G);
    double *X = bake_alloc((size_t)used * (size_t)span.count + 1, sizeof *X);
    if (used > 0) {
        cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, used, used, r->rows, 1, Q, r->rows, Q,
                    r->rows, 0, G, used);
        cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, used, span.count, r->rows, 1, Q,
                    r->rows, column(r, span.first), r->rows, 0, X, used);
    }
    if (used > 0 && LAPACKE_dposv(LAPACK_COL_MAJOR, 'U', used, span.count, G, used, X, used) == 0) {
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, r->rows, span.count, used, -1, Q,
                    r->rows, X, used, 1, column(r, span.first), r->rows);
        for (int i = 0; i < used * span.count; i++) {
            r->basis[which[i % used]].weight[span.first + i / used] += X[i];
        }
    }
    free(which);
    free(Q);
    free(G);
    free(X);
}

int shape_reduce(shape_reduction *r, shape_span span, int piece, double limit, bake_error *error)
{
    shape_pca pca;
    double *direction = bake_alloc((size_t)r->rows, sizeof *direction);
    int start = 0, before = r->count;
    if (shape_reduction_worst(r, span) <= limit || r->count >= r->most) {
        free(direction);
        return 0;
    }
    if (shape_pca_make(column(r, span.first), r->rows, span.count, r->every, &pca, error) < 0) {
        free(direction);
        return -1;
    }
    while (r->count < r->most && shape_reduction_worst(r, span) > limit) {
        if (start < pca.rank) {
            cblas_dcopy(r->rows, pca.B + (size_t)start++ * (size_t)r->rows, 1, direction, 1);
        } else {
            worst_column(r, span, direction);
        }
        if (!leading(r, span, direction)) {
            break; /* with `every`, the frames between may keep something */
        }
        subtract(r, span, direction, piece);
    }
    if (r->count > before) {
        refit(r, span, piece);
    }
    shape_pca_free(&pca);
    free(direction);
    return 0;
}

void shape_reduction_free(shape_reduction *r)
{
    for (int i = 0; i < r->count; i++) {
        free(r->basis[i].entry);
        free(r->basis[i].weight);
    }
    free(r->basis);
    free(r->residual);
    memset(r, 0, sizeof *r);
}
