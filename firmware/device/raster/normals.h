/* Normals from the triangles of a frame [Alexa 7.3.3, N5: recomputed].
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_NORMALS_H
#define WIGGLY_NORMALS_H

#include "view.h"

/* Triangles of one shape, wherever they are: all parts that have it as positions. */
typedef struct {
    const wg_file *file;
    const wg_view *view;
    const wg_vertex *vertices; /* of the shape */
    uint16_t shape, count;
} wg_surface;

/* The sum of the normals of each vertex' triangles, weighted by their areas, on a common scale that
 * the largest triangle and the most triangles around a vertex leave room for. 0 for a vertex of
 * none.
 *   normals  3 count */
void wg_normals_make(const wg_surface *surface, int16_t *normals);

#endif
