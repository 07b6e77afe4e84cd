/* How a clip is looked at: from a VIEWS record and channel values to projected vertices and
 * brightness.                                                                          [SPEC 4.17]
 *
 * Lengths are counted so that the distance of the target is 2^24 .. 2^25 - 1 `fine` units; 4096 of
 * them are a step of depth. Everything else follows from that, so no unit of the scene and no size
 * of a picture is too small or too large.
 *
 * error   A vertex within `limit` is off by 1/32 pixel, 3 2^-15 of its way from the picture's middle
 *         and a fine unit; by half a step in depth. Depth ends at 2^15 - 1 steps, 4 to 8 times the
 *         distance: what lies farther is drawn as if its corners lay there. All of that is checked
 *         by test_device_view.c.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_VIEW_H
#define WIGGLY_VIEW_H

#include "raster.h"
#include "ratio.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    wg_rigid camera;
    int32_t distance;  /* fine units, 2^24 .. 2^25 - 1 */
    wg_ratio scale;    /* 1/16 pixel a fine unit, in the target's plane */
    wg_ratio focal;    /* 1/16 pixel: where x = depth is seen */
    int32_t inverse;   /* 2^52 / distance */
    uint32_t nearness; /* perspective: nearness times depth in steps; 0: orthographic */
    int fine_bits;     /* a fine unit is 2^-fine_bits units of length */
    int16_t x, y;      /* the picture's middle, 1/16 pixel */
    int16_t limit;     /* of a vertex' way from there, 1/16 pixel */
    int16_t guard;     /* the clipper's planes are |x|, |y| = guard depth + edge, in spots' units */
    int32_t edge;
    int8_t light[3];
    uint8_t ambient;
} wg_view;

/* Whether it is orthographic. */
#define WG_VIEW_IS_FLAT(view) ((view)->nearness == 0)

/* View `index` of the clip at the moment of `values`, for a picture of up to 800 x 800 pixels. A
 * distance or a size that is not positive counts as the smallest one. */
void wg_view_set(wg_view *view, const wg_file *file, uint8_t index, const int32_t *values,
                 wg_size size);

/* Posed vertices (wg_pose_set with view->camera) to where they are seen.
 *   frac  of the pose: xyz are units / 2^(frac + WG_POSE_BITS) */
void wg_view_project(const wg_view *view, int8_t frac, const int32_t *xyz, uint16_t count,
                     wg_vertex *vertices);

/* Brightness of vertices with these normals in the view's axes, of any length: ambient + (255 -
 * ambient) max(0, n l / |n|), within 3/4. No normal counts as one towards the viewer. */
void wg_view_light(const wg_view *view, const int32_t *normals, uint16_t count, uint8_t *shades);

/* Where a vertex is, as the clipper counts: x to the right, y up in 1/128 pixel of the target's
 * plane, depth in quarters of a step. */
void wg_view_spot(const wg_view *view, const wg_vertex *vertex, int32_t *at);

/* Where such a spot is seen. Pre: it lies inside the clipper's planes. */
void wg_view_seen(const wg_view *view, const int32_t *at, wg_vertex *vertex);

/* The normal of the triangle of three vertices, counter-clockwise seen from its end. Divided by
 * 2^returned, in a unit that all triangles of a picture share: its length is the area. */
int wg_view_face(const wg_view *view, const wg_vertex *const *vertices, int32_t *normal);

#ifdef __cplusplus
}
#endif
#endif
