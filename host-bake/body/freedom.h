/* What parts of a body may do: each vertex is free, slides in a plane or on a line, or is fixed.
 * Linear constraints without multipliers: u = Z y, where Z has orthonormal columns, each of them a
 * direction of one vertex. M stays diagonal in y because a vertex has one mass for all directions.
 *                                                                             [Schulz 2.2.1, 2.7.3]
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_FREEDOM_H
#define BAKE_FREEDOM_H

#include "body.h"

typedef struct {
    int vertex_count, count; /* count: coordinates y */
    int *first; /* vertex_count + 1: coordinates of vertex i are first[i] .. first[i+1] - 1 */
    double (*axis)[3]; /* count: the direction of each, unit length */
} freedom;

/* All vertices free. */
void freedom_make(int vertex_count, freedom *out);

/* Takes the direction `normal` (any length) from a vertex; a direction that it has not is no error.
 * Rebuilds from what the vertex had: two normals leave a line, three nothing. */
void freedom_slide(freedom *f, int vertex, const double normal[3]);
void freedom_fix(freedom *f, int vertex);

/* After the calls above, and before anything below. */
void freedom_finish(freedom *f);
void freedom_free(freedom *f);

void freedom_expand(const freedom *f, const double *y, double *u);   /* u = Z y */
void freedom_restrict(const freedom *f, const double *u, double *y); /* y = Z^T u */

#endif
