/* From a closed surface to a tetrahedral mesh, and surfaces that move with one.
 * CGAL says what is wrong with a surface and where; TetGen, which crashes on what is wrong, runs in
 * a process of its own (isolate.h).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_TETS_H
#define BAKE_TETS_H

#include "body.h"

/* A triangle surface, in any unit of length. */
typedef struct {
    int vertex_count, triangle_count;
    const double *at;         /* vertex_count x 3 */
    const int (*triangle)[3]; /* counter-clockwise seen from outside */
} surface;

/* Where a message points: "scene:line: mesh NAME ...". */
typedef struct {
    const char *scene, *name;
    int line;
} surface_origin;

/* Fills a surface. cell: about the length of an edge of the tetrahedra; edges of the surface that
 * are longer than two of it are halved. 0 = the surface's own mean edge, or more where about 50,000
 * tetrahedra inside do. vertex_count, rest and element of `out` are set (out->rest in the surface's
 * unit): its vertices 0 .. surface->vertex_count - 1 are the surface's own, in order and unmoved.
 * It may turn its triangles any way. Fails, saying where and what to do, when the surface is open,
 * not a manifold, without volume, or crosses itself, when a part of it lies inside another; when
 * TetGen fails or makes more than a million. */
int tets_make(const surface *s, double cell, const surface_origin *origin, body *out,
              bake_error *error);

/* A point as a mean of body vertices: weights sum to 1, some negative outside. Shells: weight[3] =
 * 0. */
typedef struct {
    int vertex[4];
    double weight[4];
} embedding;

/* Of each point: the tetrahedron that contains it, or the nearest one (extrapolated; a shell: the
 * nearest triangle, without the point's offset from it). Points that coincide with a vertex get it
 * alone. at: count x 3, in the unit of b->rest. far: the largest distance of a point from the
 * body. */
int tets_embed(const body *b, const double *at, int count, embedding *out, double *far,
               bake_error *error);

#endif
