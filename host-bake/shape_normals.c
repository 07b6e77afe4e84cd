/* Normals of a mesh: one set for all poses, or bases of their own on the positions' channels.
 * Source: Alexa 2002, 7.3.3: fixed normals are "surprisingly good"; interpolated ones are linear in
 * the weights and normalised by who lights them. The fit of normal bases to given weights is ours.
 *   N   3 m x n       unit normals of the normalised frames
 *   W   (k + 1) x n   the positions' weights, with a row of ones on top
 *   C   3 m x (k + 1) least squares: C W is nearest to N; column 0 is the rest
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Unit normals in steps of 2^-13: sums of bases may reach 4 before 16 bits end. */
#define NORMAL_FRAC 13
#define NORMAL_MOST 3.9
#define NORMAL_BITS 8

/* Each triangle counts by its area. A vertex whose triangles cancel out looks up. */
void shape_vertex_normals(const mesh *m, const double *at, double *normal)
{
    memset(normal, 0, 3 * (size_t)m->vertex_count * sizeof *normal);
    for (int t = 0; t < m->triangle_count; t++) {
        const double *a = at + 3 * m->triangle[t][0];
        double u[3], v[3];
        for (int k = 0; k < 3; k++) {
            u[k] = at[3 * m->triangle[t][1] + k] - a[k];
            v[k] = at[3 * m->triangle[t][2] + k] - a[k];
        }
        for (int c = 0; c < 3; c++) {
            double *n = normal + 3 * m->triangle[t][c];
            for (int k = 0; k < 3; k++) {
                n[k] += u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
            }
        }
    }
    for (int i = 0; i < m->vertex_count; i++) {
        double *n = normal + 3 * i, length = cblas_dnrm2(3, n, 1);
        for (int k = 0; k < 3; k++) {
            n[k] = length > 0 ? n[k] / length : k == 1;
        }
    }
}

/* Normals of every frame before the affine part: those of its normalised triangles. */
static double *frame_normals(const shape_mesh *m)
{
    size_t rows = 3 * (size_t)m->mesh.vertex_count;
    double *N = bake_alloc(rows * (size_t)m->frame_count, sizeof *N);
    double *y = bake_alloc(rows, sizeof *y);
    for (int f = 0; f < m->frame_count; f++) {
        memcpy(y, m->frame[f], rows * sizeof *y);
        if (m->turn) {
            shape_affine_undo(&m->turn[f], m->frame[f], m->mesh.vertex_count, y);
        }
        shape_vertex_normals(&m->mesh, y, N + rows * (size_t)f);
    }
    free(y);
    return N;
}

/* C, column by column. Where the weights do not tell their bases apart it is the shortest solution. */
static double *fit(const shape_mesh *m, const double *N, int k)
{
    int n = m->frame_count, rows = 3 * m->mesh.vertex_count, tall = n > k + 1 ? n : k + 1;
    double *W = bake_alloc((size_t)n * (size_t)(k + 1), sizeof *W);
    double *C = bake_alloc((size_t)tall * (size_t)rows, sizeof *C);
    int rank, *pivot = bake_alloc((size_t)k + 1, sizeof *pivot);
    for (int f = 0; f < n; f++) {
        W[f] = 1;
        for (int j = 0; j < k; j++) {
            W[f + n * (j + 1)] = m->form.basis[j].weight[f];
        }
        for (int i = 0; i < rows; i++) {
            C[(size_t)f + (size_t)tall * (size_t)i] = N[(size_t)f * (size_t)rows + (size_t)i];
        }
    }
    LAPACKE_dgelsy(LAPACK_COL_MAJOR, n, k + 1, rows, W, n, C, tall, pivot, 1e-6, &rank);
    double *out = bake_alloc((size_t)(k + 1) * (size_t)rows, sizeof *out);
    for (int j = 0; j <= k; j++) {
        for (int i = 0; i < rows; i++) {
            out[(size_t)j * (size_t)rows + (size_t)i] = C[(size_t)j + (size_t)tall * (size_t)i];
        }
    }
    free(W);
    free(C);
    free(pivot);
    return out;
}

static double most_weight(const shape_mesh *m, const shape_basis *b)
{
    double most = b->weight ? 0 : 1;
    for (int f = 0; b->weight && f < m->frame_count; f++) {
        most = fmax(most, fabs(b->weight[f]));
    }
    return most;
}

/* The bases of the positions with other entries. One that would pass 16 bits stays 0. */
static void add_bases(shape_mesh *m, double *C)
{
    int rows = 3 * m->mesh.vertex_count;
    shape_form *form = &m->normals;
    form->basis_count = m->form.basis_count;
    form->basis = bake_alloc((size_t)form->basis_count + 1, sizeof *form->basis);
    for (int j = 0; j < form->basis_count; j++) {
        shape_basis *b = &form->basis[j];
        double *column = C + (size_t)j * (size_t)rows;
        b->piece = m->form.basis[j].piece;
        b->entry = bake_alloc((size_t)rows, sizeof *b->entry);
        b->scale = shape_quantise(column, rows, NORMAL_BITS, b->entry);
        if (b->scale * most_weight(m, &m->form.basis[j]) > NORMAL_MOST) {
            memset(b->entry, 0, (size_t)rows * sizeof *b->entry);
        }
    }
}

/* Differences of the additive shapes' normals, behind those of rest. */
static double *shape_normals(const shape_mesh *m)
{
    size_t rows = 3 * (size_t)m->mesh.vertex_count;
    double *C = bake_alloc(rows * (size_t)(m->mesh.shape_count + 1), sizeof *C);
    shape_vertex_normals(&m->mesh, m->mesh.rest, C);
    for (int j = 0; j < m->mesh.shape_count; j++) {
        double *to = C + rows * (size_t)(j + 1);
        shape_vertex_normals(&m->mesh, m->mesh.shape + rows * (size_t)j, to);
        for (size_t i = 0; i < rows; i++) {
            to[i] -= C[i];
        }
    }
    return C;
}

void shape_solve_normals(const scene *s, shape_mesh *m)
{
    scene_normals kind = s->meshes[m->index].normals;
    int k = kind == NORMALS_INTERPOLATED ? m->form.basis_count : 0;
    double *C;
    if (kind == NORMALS_NONE || m->mesh.triangle_count == 0) {
        return;
    }
    if (m->frame_count > 0) {
        double *N = frame_normals(m);
        C = fit(m, N, k);
        free(N);
    } else {
        C = shape_normals(m);
    }
    m->has_normals = 1;
    m->normals.vertex_count = m->mesh.vertex_count;
    m->normals.frac = NORMAL_FRAC;
    m->normals.bits = NORMAL_BITS;
    m->normals.affine = -1;
    shape_round_rest(&m->normals, C);
    if (k > 0) {
        add_bases(m, C + 3 * (size_t)m->mesh.vertex_count);
    }
    shape_make_blocks(&m->normals);
    free(C);
}
