/* Animated meshes as plain arrays: one connectivity, any number of frames.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_MESH_H
#define BAKE_MESH_H

#include "scene.h"

/* Triangles of one colour: a material, or a mesh of the file. */
typedef struct {
    char *name;
    unsigned char colour[3]; /* sRGB */
    int sides;               /* 0 the front, 1 both */
} mesh_part;

/* The frames of one entry of clips[clip].meshes, evenly spaced; or of what a body does in a clip,
 * at any times. */
typedef struct {
    int clip, motion; /* scene.clips[clip].motions[motion]; -1: a body's */
    int count;        /* frames, >= 1 */
    double rate;      /* frames a second */
    double *time; /* count + 1, ascending [s]: the last is where a loop meets its first frame again;
                         NULL: frame i is shown at i / rate */
    char *kink;   /* count: velocities may jump at this frame; NULL: nowhere */
    double *at;   /* count x vertex_count x 3 */
} mesh_frames;

/* All of a mesh: scaled, y up, welded (vertices that coincide in the rest pose and in every frame
 * and shape are one), degenerate triangles dropped, unused vertices dropped. */
typedef struct {
    int vertex_count, triangle_count, part_count, frames_count, shape_count;
    double *rest;       /* vertex_count x 3: the file's pose without animation */
    int (*triangle)[3]; /* counter-clockwise seen from outside */
    int *part;          /* of each triangle */
    mesh_part *parts;
    mesh_frames *frames;  /* every motion of the scene that moves this mesh, by clip */
    double *shape;        /* shape_count x vertex_count x 3: the additive shapes, absolute */
    struct outline *flat; /* of a picture or drawing, in scene units; else NULL */
    struct mesh_picture *picture; /* mesh_picture.h; or NULL */
    int specks;                   /* loops that the outline leaves out */
} mesh;

/* Loads scene.meshes[index] with all its motions and shapes. Errors name the scene's line and the
 * mesh file: another connectivity or vertex count in some frame (which), a file that Assimp cannot
 * read, a frame or target that is not there. */
int mesh_load(const scene *s, int index, mesh *out, bake_error *error);
void mesh_free(mesh *m);
void mesh_frames_free(mesh_frames *f);

#endif
