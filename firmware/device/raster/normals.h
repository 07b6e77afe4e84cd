/* Normals from the triangles of a frame [Alexa 7.3.3, N5: recomputed].
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_NORMALS_H
#define WIGGLY_NORMALS_H

#include "view.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Triangles of one shape, wherever they are: all parts that have it as positions. */
typedef struct {
    const wg_file *file;
    const wg_view *view;
    const wg_vertex *vertices; /* of the shape */
    uint16_t shape, count;
} wg_surface;

/* How far the sums are. {0} is the beginning. */
typedef struct {
    uint16_t part, triangle; /* the next one */
    int16_t scale;
    uint8_t bits; /* of the longest component of a normal */
    bool adding;  /* the second pass: sums; the first one counts triangles around vertices */
} wg_normals;

/* The sum of the normals of each vertex' triangles, weighted by their areas, on a common scale that
 * the largest triangle and the most triangles around a vertex leave room for. 0 for a vertex of
 * none. A step looks at 32 triangles; the sums are there when it returns false.
 *   normals  3 count */
bool wg_normals_step(const wg_surface *surface, wg_normals *at, int16_t *normals);

#ifdef __cplusplus
}
#endif
#endif
