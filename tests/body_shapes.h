/* Bodies with regular meshes for tests: boxes of tetrahedra, sheets of triangles.
 * Filled: kind, vertex_count, element_count, rest, element. The caller sets the material, then
 * calls body_prepare; body_free releases everything.
 * SPDX-License-Identifier: MIT */
#ifndef BODY_SHAPES_H
#define BODY_SHAPES_H

#include "body.h"

#include <math.h>
#include <stdlib.h>

/* The vertex (i, j, k) of a box of `cells`; x is counted fastest. */
static inline int box_vertex(const int cells[3], int i, int j, int k)
{
    return i + (cells[0] + 1) * (j + (cells[1] + 1) * k);
}

/* Kuhn's six tetrahedra of one cell: paths from corner to corner along the axes in every order.
 * Odd cells are mirrored, so that with even counts the mesh has every symmetry of the box. */
static inline void box_cell(body *b, const int cells[3], const int at[3])
{
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},  /* even permutations */
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}; /* odd ones */
    for (int p = 0; p < 6; p++) {
        int corner[3], turned = p >= 3, *e = b->element[b->element_count++];
        for (int k = 0; k < 3; k++) {
            corner[k] = at[k] + at[k] % 2;
            turned ^= at[k] % 2;
        }
        e[0] = box_vertex(cells, corner[0], corner[1], corner[2]);
        for (int s = 0; s < 3; s++) {
            int k = order[p][s];
            corner[k] += at[k] % 2 ? -1 : 1;
            e[s + 1] = box_vertex(cells, corner[0], corner[1], corner[2]);
        }
        if (turned) {
            int swap = e[1];
            e[1] = e[2];
            e[2] = swap;
        }
    }
}

/* [0, size[0]] x [0, size[1]] x [0, size[2]] */
static inline void box_tets(body *b, const double size[3], const int cells[3])
{
    b->kind = BODY_SOLID;
    b->vertex_count = (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1);
    b->element_count = 0;
    b->rest = malloc(sizeof *b->rest * 3 * (size_t)b->vertex_count);
    b->element =
        malloc(sizeof *b->element * 6 * (size_t)cells[0] * (size_t)cells[1] * (size_t)cells[2]);
    for (int k = 0; k <= cells[2]; k++) {
        for (int j = 0; j <= cells[1]; j++) {
            for (int i = 0; i <= cells[0]; i++) {
                double *x = &b->rest[3 * box_vertex(cells, i, j, k)];
                x[0] = size[0] * i / cells[0];
                x[1] = size[1] * j / cells[1];
                x[2] = size[2] * k / cells[2];
                if (i < cells[0] && j < cells[1] && k < cells[2]) {
                    box_cell(b, cells, (const int[3]){i, j, k});
                }
            }
        }
    }
}

static inline void sheet_triangle(body *b, int a, int c, int d)
{
    int *e = b->element[b->element_count++];
    e[0] = a;
    e[1] = c;
    e[2] = d;
    e[3] = -1;
}

/* Triangles between two rows of vertices, below and above, each from left to right: next comes the
 * one with the shorter new edge; where they are equal, `lean` decides. Normals are +z. */
static inline void sheet_row(body *b, const int first[2], const int count[2], int lean)
{
    for (int i = 0, j = 0; i + 1 < count[0] || j + 1 < count[1];) {
        int up = i + 1 == count[0];
        if (!up && j + 1 < count[1]) {
            double below = b->rest[3 * (first[0] + i + 1)] - b->rest[3 * (first[1] + j)];
            double above = b->rest[3 * (first[1] + j + 1)] - b->rest[3 * (first[0] + i)];
            double difference = fabs(above) - fabs(below), small = 1e-9 * (above + below);
            up = fabs(difference) <= small ? (i + lean) % 2 : difference < 0;
        }
        if (up) {
            sheet_triangle(b, first[0] + i, first[1] + j + 1, first[1] + j);
            j++;
        } else {
            sheet_triangle(b, first[0] + i, first[0] + i + 1, first[1] + j);
            i++;
        }
    }
}

/* [0, size[0]] x [0, size[1]] x 0. Right-angled: cells cut alternately along one diagonal and the
 * other. `equilateral`: odd rows are shifted by half a cell (their ends are not, so half triangles
 * fill the border); sides are equal if size[1] / cells[1] = sqrt(3)/2 size[0] / cells[0]. */
static inline void sheet_triangles(body *b, const double size[2], const int cells[2],
                                   int equilateral)
{
    size_t most = (size_t)(cells[0] + 2) * (size_t)(cells[1] + 1);
    b->kind = BODY_SHELL;
    b->vertex_count = b->element_count = 0;
    b->rest = malloc(sizeof *b->rest * 3 * most);
    b->element = malloc(sizeof *b->element * 2 * most);
    for (int j = 0, below[2] = {0, 0}; j <= cells[1]; j++) {
        int shifted = equilateral && j % 2, count = cells[0] + 1 + shifted;
        int first = b->vertex_count;
        for (int i = 0; i < count; i++) {
            double *x = &b->rest[3 * b->vertex_count++];
            x[0] = size[0] * fmin(fmax(i - 0.5 * shifted, 0), cells[0]) / cells[0];
            x[1] = size[1] * j / cells[1];
            x[2] = 0;
        }
        if (j > 0) {
            sheet_row(b, (int[2]){below[0], first}, (int[2]){below[1], count}, j % 2);
        }
        below[0] = first;
        below[1] = count;
    }
}

#endif
