/* What the tests of shells share: materials, sheets, rolling, and the Hessian as a dense matrix.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef SHELL_SHEETS_H
#define SHELL_SHEETS_H

#include "body_shapes.h"
#include "check.h"

#include <stdio.h>
#include <string.h>

enum { RUBBER, STEEL, CORK, FOAM, MATERIALS };

static const body_material materials[MATERIALS] = {
    {1e6, 0.45, 1100, 0.05}, {2e11, 0.3, 7850, 2e-3}, {2e7, 0, 200, 0.02}, {5e4, -0.4, 30, 0.1}};

static inline void prepare(body *b, const body_material *m)
{
    bake_error error = {""};
    b->material = *m;
    CHECK_EQ(body_prepare(b, &error), 0);
    if (error.text[0])
        printf("%s\n", error.text);
}

static inline void make(body *b, int vertices, const double *rest, int triangles,
                        const int (*corner)[3])
{
    memset(b, 0, sizeof *b);
    b->kind = BODY_SHELL;
    b->vertex_count = vertices;
    b->element_count = triangles;
    b->rest = bake_alloc(3 * (size_t)vertices, sizeof *b->rest);
    memcpy(b->rest, rest, 3 * (size_t)vertices * sizeof *rest);
    b->element = bake_alloc((size_t)triangles, sizeof *b->element);
    for (int t = 0; t < triangles; t++) {
        memcpy(b->element[t], corner[t], sizeof corner[t]);
        b->element[t][3] = -1;
    }
}

static inline double dice(unsigned *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (*state >> 8) / 8388608.0 - 1;
}

enum { ALTERNATING, EQUILATERAL, ONE_DIAGONAL, IRREGULAR, MESHES };

/* Mirrors the odd ones of sheet_triangles' cells, of 2 triangles each. */
static inline void one_diagonal(body *b, const int cells[2])
{
    int wide = cells[0] + 1;
    for (int c = 0, t = 0; c < cells[0] * cells[1]; c++) {
        int p = c % cells[0] + wide * (c / cells[0]);
        for (int half = 0; half < 2; half++, t++) {
            b->element[t][0] = p;
            b->element[t][1] = half ? p + 1 + wide : p + 1;
            b->element[t][2] = half ? p + wide : p + 1 + wide;
        }
    }
}

/* [0, size[0]] x [0, size[1]] x 0, not prepared. Irregular: equilateral with each inner vertex
 * moved along x and y by up to a fifth of a side. */
static inline void sheet(body *b, int mesh, const double size[2], const int cells[2])
{
    sheet_triangles(b, size, cells, mesh == EQUILATERAL || mesh == IRREGULAR);
    b->mass = NULL;
    b->elements = NULL;
    if (mesh == ONE_DIAGONAL)
        one_diagonal(b, cells);
    unsigned state = 3;
    for (int v = 0; v < b->vertex_count && mesh == IRREGULAR; v++) {
        double *p = &b->rest[3 * v], shift[2] = {dice(&state), dice(&state)};
        if (p[0] > 0 && p[0] < size[0] && p[1] > 0 && p[1] < size[1])
            for (int i = 0; i < 2; i++)
                p[i] += 0.2 * size[0] / cells[0] * shift[i];
    }
}

/* Rolled about the y axis with this radius, then shaken. */
static inline double *rolled(const body *b, double radius, double shake)
{
    double *x = bake_alloc(3 * (size_t)b->vertex_count, sizeof *x);
    unsigned state = 1;
    for (int v = 0; v < b->vertex_count; v++) {
        const double *r = &b->rest[3 * v];
        double out[3] = {(radius - r[2]) * sin(r[0] / radius), r[1],
                         radius - (radius - r[2]) * cos(r[0] / radius)};
        for (int i = 0; i < 3; i++)
            x[3 * v + i] = out[i] + shake * dice(&state);
    }
    return x;
}

/* The Hessian as a dense matrix. */
static inline double *dense(const body *b, const double *x)
{
    size_t n = 3 * (size_t)b->vertex_count;
    double *H = bake_alloc(n * n, sizeof *H);
    body_blocks list = {0};
    body_hessian(b, x, &list);
    for (size_t k = 0; k < list.count; k++)
        for (size_t i = 0; i < 3; i++)
            for (size_t j = 0; j < 3; j++) {
                size_t row = 3 * (size_t)list.at[k].a + i, column = 3 * (size_t)list.at[k].b + j;
                H[row * n + column] += list.at[k].k[3 * i + j];
                if (list.at[k].a != list.at[k].b)
                    H[column * n + row] += list.at[k].k[3 * i + j];
            }
    body_blocks_free(&list);
    return H;
}

#endif
