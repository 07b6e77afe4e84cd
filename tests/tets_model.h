/* For the tests of tets.h: surfaces in numbers, and what must be true of every filling.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef TETS_MODEL_H
#define TETS_MODEL_H

#include "check.h"
#include "tets_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 30000 };
static double at[ROOM][3];
static int triangle[2 * ROOM][3];
static int vertices, triangles;

static const surface_origin origin = {"scene.yaml", "thing", 7};
static bake_error error;
static body b;

static inline surface whole(void)
{
    surface s = {vertices, triangles, at[0], (const int(*)[3])triangle};
    return s;
}

static inline int fill(double cell)
{
    surface s = whole();
    error.text[0] = 0;
    return tets_make(&s, cell, &origin, &b, &error);
}

static inline void drop(void)
{
    free(b.rest);
    free(b.element);
    b = (body){.kind = BODY_SOLID};
}

static inline int add_vertex(double x, double y, double z)
{
    const double p[3] = {x, y, z};
    memcpy(at[vertices], p, sizeof p);
    return vertices++;
}

static inline void add_triangle(int a, int second, int c)
{
    const int corner[3] = {a, second, c};
    memcpy(triangle[triangles++], corner, sizeof corner);
}

/* From `low` to `low` + edge; vertex x + 2 y + 4 z. */
static inline void add_cube(double low, double edge)
{
    static const int corner[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                      {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                      {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    int from = vertices;
    for (int i = 0; i < 8; i++)
        add_vertex(low + (i & 1 ? edge : 0), low + (i & 2 ? edge : 0), low + (i & 4 ? edge : 0));
    for (int i = 0; i < 12; i++)
        add_triangle(from + corner[i][0], from + corner[i][1], from + corner[i][2]);
}

static inline void make_cube(void)
{
    vertices = triangles = 0;
    add_cube(-1.0, 2.0);
}

/* Of radius 1: rings of `around` vertices between two poles. */
static inline void make_sphere(int rings, int around)
{
    const double pi = acos(-1.0);
    vertices = triangles = 0;
    for (int i = 1; i < rings; i++)
        for (int j = 0; j < around; j++) {
            double from_pole = pi * i / rings, angle = 2 * pi * j / around;
            add_vertex(sin(from_pole) * cos(angle), sin(from_pole) * sin(angle), cos(from_pole));
        }
    int north = add_vertex(0, 0, 1), south = add_vertex(0, 0, -1);
    for (int j = 0; j < around; j++) {
        int next = (j + 1) % around, last = (rings - 2) * around;
        add_triangle(north, j, next);
        add_triangle(south, last + next, last + j);
        for (int i = 0; i < last; i += around) {
            add_triangle(i + j, i + j + around, i + next);
            add_triangle(i + next, i + j + around, i + next + around);
        }
    }
}

/* By the divergence theorem: no tetrahedron is looked at. */
static inline double volume_inside(void)
{
    const double none[3] = {0, 0, 0};
    double sum = 0;
    for (int i = 0; i < triangles; i++)
        sum += tets_det(none, at[triangle[i][0]], at[triangle[i][1]], at[triangle[i][2]]) / 6;
    return sum;
}

/* All volumes are positive; the surface's vertices come first, to the bit; no vertex is unused. The sum of
 * n products of coordinates up to `size` is exact to n 2^-53 size^3 on both sides. */
static inline void check_filled(double volume)
{
    double sum = 0, size = 0;
    char *used = bake_alloc((size_t)b.vertex_count, 1);
    CHECK(b.kind == BODY_SOLID);
    CHECK(b.vertex_count >= vertices && memcmp(b.rest, at, sizeof *at * (size_t)vertices) == 0);
    for (int i = 0; i < b.element_count; i++) {
        const double *p[4];
        for (int k = 0; k < 4; k++) {
            used[b.element[i][k]] = 1;
            p[k] = b.rest + 3 * b.element[i][k];
        }
        double det = tets_det(p[0], p[1], p[2], p[3]);
        CHECK(det > 0);
        sum += det / 6;
    }
    for (int i = 0; i < b.vertex_count; i++) {
        CHECK(used[i]);
        for (int k = 0; k < 3; k++)
            size = fmax(size, fabs(b.rest[3 * i + k]));
    }
    CHECK_NEAR(sum, volume, (b.element_count + triangles) * 4.0 * ldexp(size * size * size, -53));
    free(used);
}

#endif
