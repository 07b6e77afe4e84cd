/* Meshes of the sizes of Schulz 2013, table 2.1, for the bench of bodies.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BENCH_MESHES_H
#define BENCH_MESHES_H

#include "body_shapes.h"
#include "tets.h"

#include <stdio.h>
#include <string.h>

#define BENCH_DATA "/usr/share/doc/libcgal-dev/data.tar.gz" /* of Debian's libcgal-demo */
#define BENCH_AT   "build/cgal/data/meshes/"

static inline double body_length(const body *b)
{
    double low = HUGE_VAL, high = -HUGE_VAL, most = 0;
    for (int k = 0; k < 3; k++, low = HUGE_VAL, high = -HUGE_VAL) {
        for (int i = 0; i < b->vertex_count; i++) {
            low = fmin(low, b->rest[3 * i + k]);
            high = fmax(high, b->rest[3 * i + k]);
        }
        most = fmax(most, high - low);
    }
    return most;
}

static inline double body_distance(const body *b, int i, int j)
{
    const double *x = &b->rest[3 * i], *y = &b->rest[3 * j];
    return sqrt((x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) +
                (x[2] - y[2]) * (x[2] - y[2]));
}

/* ---- boxes -------------------------------------------------------------------------------------- */

/* The vertices on the surface of a box of tetrahedra, and its sides as triangles. */
static inline void box_surface(body *b, const double size[3], const int cells[3])
{
    body box = {0};
    box_tets(&box, size, cells);
    int *to = bake_alloc((size_t)box.vertex_count, sizeof *to), count = 0, triangles = 0;
    b->kind = BODY_SHELL;
    b->rest = bake_alloc(3 * (size_t)box.vertex_count, sizeof *b->rest);
    b->element = bake_alloc(4 * (size_t)box.element_count, sizeof *b->element);
    for (int i = 0, k = 0; i < box.vertex_count; i++) {
        const double *x = &box.rest[3 * i];
        to[i] = -1;
        for (k = 0; k < 3 && x[k] > 0 && x[k] < size[k]; k++) {
        }
        if (k < 3) {
            memcpy(&b->rest[3 * count], x, 3 * sizeof *x);
            to[i] = count++;
        }
    }
    for (int t = 0; t < 4 * box.element_count; t++) { /* the side opposite to corner t % 4 */
        int corner[3], on[6] = {0};
        for (int a = 0; a < 3; a++) {
            corner[a] = box.element[t / 4][(t + 1 + a) % 4];
            for (int k = 0; k < 3; k++) {
                on[2 * k] += box.rest[3 * corner[a] + k] <= 0;
                on[2 * k + 1] += box.rest[3 * corner[a] + k] >= size[k];
            }
        }
        for (int side = 0; side < 6; side++)
            if (on[side] == 3)
                sheet_triangle(b, to[corner[0]], to[corner[1]], to[corner[2]]);
    }
    triangles = b->element_count;
    b->vertex_count = count;
    b->element_count = triangles;
    body_free(&box);
    free(to);
}

/* 2 (8 8 + 8 10 + 10 8) + 2 = 450 vertices */
static inline void mesh_block(body *b)
{
    box_surface(b, (const double[]){0.08, 0.08, 0.1}, (const int[]){8, 8, 10});
}

/* 2 (24 27 + 27 30 + 30 24) + 2 = 4358 vertices of a box, blown up to an ellipsoid. */
static inline void mesh_bug(body *b)
{
    static const double half[3] = {0.3, 0.2, 0.1};
    box_surface(b, (const double[]){2, 2, 2}, (const int[]){24, 27, 30});
    for (int i = 0; i < b->vertex_count; i++) {
        double *x = &b->rest[3 * i], length = 0;
        for (int k = 0; k < 3; k++)
            length += (x[k] - 1) * (x[k] - 1);
        for (int k = 0; k < 3; k++)
            x[k] = half[k] * (x[k] - 1) / sqrt(length);
    }
}

/* 51 rows of 36 or 37: 1861 vertices. */
static inline void mesh_cloth(body *b)
{
    sheet_triangles(b, (const double[]){0.7, 0.7 / 35 * 50 * 0.86602540378443865},
                    (const int[]){35, 50}, 1);
}

/* ---- published surfaces -------------------------------------------------------------------------- */

/* A triangle surface as OFF, its longest side `length` metres. */
static inline void read_off(const char *name, double length, body *b)
{
    char path[200];
    snprintf(path, sizeof path, BENCH_AT "%s.off", name);
    FILE *file = fopen(path, "r");
    if (!file && system("tar -xzf " BENCH_DATA " -C build/cgal data/meshes") == 0)
        file = fopen(path, "r");
    if (!file || fscanf(file, "%*[COF] %d %d %*d", &b->vertex_count, &b->element_count) != 2) {
        printf("%s: not there or not OFF; install libcgal-demo\n", path);
        exit(1);
    }
    b->kind = BODY_SHELL;
    b->rest = bake_alloc(3 * (size_t)b->vertex_count, sizeof *b->rest);
    b->element = bake_alloc((size_t)b->element_count, sizeof *b->element);
    for (int i = 0; i < b->vertex_count; i++)
        if (fscanf(file, "%lf %lf %lf%*[^\n]", &b->rest[3 * i], &b->rest[3 * i + 1],
                   &b->rest[3 * i + 2]) < 3)
            exit(1);
    for (int i = 0, *c; i < b->element_count; i++) {
        c = b->element[i];
        c[3] = -1;
        if (fscanf(file, "%*d %d %d %d%*[^\n]", &c[0], &c[1], &c[2]) < 3)
            exit(1);
    }
    fclose(file);
    double scale = length / body_length(b);
    for (int i = 0; i < 3 * b->vertex_count; i++)
        b->rest[i] *= scale;
}

/* A side of a triangle, from corner `corner` to the next. */
typedef struct {
    double length;
    int a, b, triangle, corner;
} bench_side;

static inline int bench_order(const void *left, const void *right)
{
    const bench_side *x = left, *y = right;
    if (x->length != y->length)
        return x->length < y->length ? 1 : -1;
    return x->a != y->a ? x->a - y->a : x->b - y->b;
}

/* Puts a vertex into the middle of the side and cuts its triangle in two. */
static inline void cut_side(body *b, const bench_side *side, int middle)
{
    int *old = b->element[side->triangle], *new = b->element[b->element_count++];
    memcpy(new, old, sizeof *b->element);
    old[(side->corner + 1) % 3] = middle;
    new[side->corner] = middle;
}

/* Halves the longest edges until there are `vertices`; in one pass no triangle is cut twice. Closed
 * surfaces only. */
static inline void refine(body *b, int vertices)
{
    b->rest = bake_grow(b->rest, 3 * (size_t)vertices, sizeof *b->rest);
    b->element = bake_grow(b->element, 2 * (size_t)vertices, sizeof *b->element);
    while (b->vertex_count < vertices) {
        int count = 3 * b->element_count;
        bench_side *side = bake_alloc((size_t)count, sizeof *side);
        char *cut = bake_alloc((size_t)count, 1);
        for (int i = 0; i < count; i++) {
            int v = b->element[i / 3][i % 3], w = b->element[i / 3][(i + 1) % 3];
            side[i] = (bench_side){body_distance(b, v < w ? v : w, v < w ? w : v), v < w ? v : w,
                                   v < w ? w : v, i / 3, i % 3};
        }
        qsort(side, (size_t)count, sizeof *side, bench_order);
        for (int i = 0; i + 1 < count && b->vertex_count < vertices; i += 2) {
            if (cut[side[i].triangle] || cut[side[i + 1].triangle])
                continue;
            cut[side[i].triangle] = cut[side[i + 1].triangle] = 1;
            for (int k = 0; k < 3; k++)
                b->rest[3 * b->vertex_count + k] =
                    (b->rest[3 * side[i].a + k] + b->rest[3 * side[i].b + k]) / 2;
            cut_side(b, &side[i], b->vertex_count);
            cut_side(b, &side[i + 1], b->vertex_count++);
        }
        free(side);
        free(cut);
    }
}

/* diplodocus.off, 23982 vertices, with its longest edges halved. */
static inline void mesh_dinosaur(body *b)
{
    read_off("diplodocus", 1.0, b);
    refine(b, 28098);
}

/* cactus.off filled with as many tetrahedra as 1691 vertices take, or nearly. */
static inline void mesh_cactus(body *b)
{
    body shell = {0};
    bake_error error;
    double low = 0, high = 0;
    read_off("cactus", 0.2, &shell);
    int(*corner)[3] = bake_alloc((size_t)shell.element_count, sizeof *corner);
    for (int i = 0; i < shell.element_count; i++)
        memcpy(corner[i], shell.element[i], sizeof *corner);
    surface s = {shell.vertex_count, shell.element_count, shell.rest, (const int(*)[3])corner};
    low = 0.002;
    high = 0.05;
    for (int i = 0; i < 14 && abs(b->vertex_count - 1691) > 16; i++) {
        double cell = sqrt(low * high);
        free(b->rest);
        free(b->element);
        if (tets_make(&s, cell, &(surface_origin){"bench", "cactus", 0}, b, &error) < 0) {
            printf("failed: %s\n", error.text);
            exit(1);
        }
        if (b->vertex_count > 1691)
            low = cell;
        else
            high = cell;
    }
    b->kind = BODY_SOLID;
    body_free(&shell);
    free(corner);
}

#endif
