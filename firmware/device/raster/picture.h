/* A clip as a picture: everything a display needs a frame, from channel values to pixels.
 *
 *   static wg_picture picture;
 *   static wg_vertex vertices[CLIP_VERTICES + 1];        // 6 bytes each: CLIP_* from <clip>.h
 *   static uint8_t shades[CLIP_VERTICES + 1];            // smooth shading; or NULL
 *   static int16_t weights[CLIP_BASES + 1];
 *   static uint32_t band[WIDTH * ROWS];                  // down to one line
 *
 *   const wg_picture_memory memory = {vertices, shades, NULL, weights}; // NULL: see CLIP_NORMALS
 *   const wg_size size = {WIDTH, HEIGHT}, align = {2, 1};
 *   wg_picture_init(&picture, &file, size, &memory);     // after wg_open_shapes
 *   for (;;) {
 *       wg_player_sample(&player, values);
 *       wg_picture_set(&picture, values);                // every vertex, once
 *       wg_rect dirty = wg_picture_dirty(&picture, align);       // what may have changed
 *       for (each band of rows in dirty) {
 *           wg_picture_band(&picture, rect, band);       // the same pixels for every band height
 *           bytes = wg_pixels_grey4(..., band);          // pixels.h; may be in place
 *       }
 *   }
 *
 * Clips with skins, or with paints on parts: see picture_skin.h too.
 *
 * Source: own; perspective and shading as in SPEC 4.17. Integers only, no division a pixel.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_PICTURE_H
#define WIGGLY_PICTURE_H

#include "normals.h"
#include "raster.h"
#include "view.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a picture works in; the caller's.
 *   vertices  one a vertex of every shape that a part has as positions (CLIP_VERTICES)
 *   shades    the same number, or NULL: smooth parts are drawn flat
 *   normals   3 the same number: for smooth parts without normals, which are then recomputed from
 *             the posed triangles; or NULL: such parts are drawn flat. CLIP_NORMALS is not 0 if
 *             the clip has some
 *   weights   the most bases any shape has (CLIP_BASES), or one */
typedef struct {
    wg_vertex *vertices;
    uint8_t *shades;
    int16_t *normals;
    int16_t *weights;
} wg_picture_memory;

/* Of all vertices, 1/16 pixel; both ends belong to it. */
typedef struct {
    int16_t low[2], high[2]; /* x, y */
} wg_box;

/* A shape that parts have as positions, and where its vertices start. */
typedef struct {
    uint16_t shape, count;
    uint32_t first;
} wg_picture_mesh;

/* What skins take (picture_skin.h): bones[CLIP_BONES], of the skin that has most. */
typedef struct {
    wg_skin skin;
    wg_bone *bones;
} wg_picture_skins;

/* How far the vertices of a frame are. */
typedef struct {
    const int32_t *values;
    wg_picture_mesh mesh;
    wg_pose pose;
    wg_normals normals;
    uint32_t vertex; /* of the mesh: the next one */
    uint8_t stage;
    uint8_t renew;   /* the frame gets new shades */
    uint8_t skinned; /* the mesh follows bones */
} wg_picture_work;

typedef struct {
    const wg_file *file;
    wg_picture_memory memory;
    wg_view view;
    wg_size size;
    wg_picture_work work;
    wg_box covers, covered; /* this frame's vertices and the last one's */
    wg_picture_skins *skins;
    uint16_t bases;        /* level of detail: how many bases of each shape count */
    uint16_t lit;          /* bit i: shape i's vertices have a brightness, */
    uint16_t fields;       /* or that of a field */
    uint8_t index;         /* the view */
    uint8_t shading;       /* WG_SHADING_*, from the view */
    uint8_t normals_every; /* shades are renewed every so many frames: 1 */
    uint8_t frame;         /* frames since they were */
    uint8_t fresh;         /* not 0: nothing of this view has been sent yet, all is dirty */
    uint8_t paints;        /* so many of the clip's are looked at */
} wg_picture;

/* Of a clip that has a view: view 0, all bases, the view's shading. Change `bases`, `shading`, `normals_every` afterwards at
 * will, or the view with wg_picture_look. */
void wg_picture_init(wg_picture *picture, const wg_file *file, wg_size size,
                     const wg_picture_memory *memory);
void wg_picture_look(wg_picture *picture, uint8_t view);

/* From now on parts are painted as the clip says [SPEC 4.23]. Pre: wg_open_skins. No light falls on a
 * painted part, and a wireframe has the parts' own colours. Texels are linear in the picture between
 * the corners of a triangle: exact in an orthographic view, and where it faces the camera.
 *   skins  for wg_picture_step_skinned (picture_skin.h), the picture's from now on; or NULL */
void wg_picture_paint(wg_picture *picture, wg_picture_skins *skins);

/* The frame: vertices projected, shades computed. */
void wg_picture_set(wg_picture *picture, const int32_t *values);

/* The same in slices, for a firmware that has servos to serve in between: begin, then step until it
 * returns false. A step is 32 vertices or 32 triangles; `values` must stay as they are. */
void wg_picture_begin(wg_picture *picture, const int32_t *values);
bool wg_picture_step(wg_picture *picture);

/* The smallest rectangle, on multiples of align.width and align.height pixels (or the picture's
 * edge), outside which this frame and the one before are both background. The whole picture after
 * init and look. Empty (x0 == x1): nothing to send. */
wg_rect wg_picture_dirty(const wg_picture *picture, wg_size align);

/* The pixels of one rectangle of the frame, row by row, (x1 - x0)(y1 - y0) of them. Every pixel is
 * the same whatever rectangle it is asked for in, and whatever the order of the triangles. */
void wg_picture_band(const wg_picture *picture, wg_rect rect, uint32_t *pixels);

#ifdef __cplusplus
}
#endif
#endif
