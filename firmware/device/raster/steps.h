/* Inside the raster: how the vertices of a frame are made, in steps.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_STEPS_H
#define WIGGLY_STEPS_H

#include "picture.h"

/* Vertices posed at a time: 384 bytes of stack. */
#define WG_STEP_RANGE 32u

/* Stages of a mesh. */
enum {
    WG_STEP_POSITIONS, /* posed and projected */
    WG_STEP_NORMALS,   /* posed and lit */
    WG_STEP_SUMS,      /* of the triangles' normals */
    WG_STEP_LIGHTS,    /* of those sums */
    WG_STEP_DONE
};

/* The next vertices of the mesh. */
uint16_t wg_step_count(const wg_picture_work *work);

/* As many posed vertices to where they are seen; the mesh is on to its next stage after the last. */
void wg_step_positions(wg_picture *picture, const int32_t *xyz, uint16_t count);

#endif
