/* What the files of tets.h share.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_TETS_PARTS_H
#define BAKE_TETS_PARTS_H

#include "tets.h"

/* 0 and the volume inside, in the surface's unit; or -1 and what is wrong, where, and what to
 * do. */
int tets_check(const surface *s, const surface_origin *origin, double *volume, bake_error *error);

/* The same in a process of its own. */
int tets_check_apart(const surface *s, const surface_origin *origin, double *volume,
                     bake_error *error);

/* What is asked of a filling. */
typedef struct {
    double cell, volume; /* volume: what tets_check found */
    int point_count;     /* inside the surface, apart from it and from each other: */
    const double *point; /* point_count x 3: vertices too, bit by bit */
} tets_wish;

/* tets_make() for a surface that has been checked, with a cell. TETS_MANY: an error too, which
 * another cell helps against, but no other surface. */
enum { TETS_MANY = -2 };
int tets_fill(const surface *s, const tets_wish *wish, const surface_origin *origin, body *out,
              bake_error *error);

/* The cell with which a volume takes about so many tetrahedra. */
double tets_cell(double volume, int count);

/* The mean of the edges of a surface. */
double tets_mean_edge(const surface *s);

/* An edge of one triangle of a surface. */
typedef struct {
    int a, b;      /* a < b */
    int corner[2]; /* of a and of b: 3 triangle + 0 .. 2 */
} tets_edge;

/* 3 triangle_count, the caller's: those of one edge side by side, in the order of vertices. */
tets_edge *tets_edges(const surface *s);

/* How many of the edges from here on are the same one. */
int tets_edge_count(const surface *s, const tets_edge *list, int from);

double tets_distance(const double *a, const double *b);

/* A surface of one's own. */
typedef struct {
    int vertex_count, triangle_count;
    double *at;         /* vertex_count x 3 */
    int (*triangle)[3]; /* triangle_count */
} tets_triangles;

/* The same surface with all edges that are longer than `longest` halved until none is; its first
 * vertices are those of `s`. The caller frees it. -1: more than triangles_max of them. */
int tets_split(const surface *s, double longest, int triangles_max, tets_triangles *out);
surface tets_look(const tets_triangles *t);
void tets_triangles_free(tets_triangles *t);

/* Weights, 0 to 1, of the triangle's point that is nearest to p; the square of its distance. */
double tets_weigh_triangle(const double *const at[3], const double *p, double *weight);

/* Six times the volume of the tetrahedron a b c d. */
double tets_det(const double *a, const double *b, const double *c, const double *d);

/* A triangle of a body's surface: its corners in ascending order, and what it is a side of. */
typedef struct {
    int corner[3], element;
} tets_face;

/* A uniform grid of cubes over `count` boxes: the boxes of cell i are item[start[i]] ..
 * item[start[i + 1] - 1].
 */
typedef struct {
    double low[3], high[3], edge;
    int cells[3];
    size_t *start;
    int *item;
} tets_grid;

/* The box around item i: its smallest and largest coordinates. */
typedef void tets_grid_box(const void *what, int i, double box[2][3]);

void tets_grid_make(tets_grid *g, int count, tets_grid_box *box, const void *what);
void tets_grid_free(tets_grid *g);

/* Visits what may contain p. */
void tets_grid_at(const tets_grid *g, const double *p, void (*visit)(void *, int), void *what);

/* Visits what may be nearest to p, some of it more than once. `visit` returns the square of the
 * smallest distance so far. */
void tets_grid_near(const tets_grid *g, const double *p, double (*visit)(void *, int), void *what);

#endif
