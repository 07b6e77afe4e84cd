/* The certificate's meshes: every vertex of every frame, posed by the real player from the finished
 * file, against the frames that were loaded.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_CERTIFY_SHAPES_H
#define BAKE_CERTIFY_SHAPES_H

#include "build.h"

/* The first `bases` of a mesh alone: a level of detail. Distances in the scene's unit. */
typedef struct {
    double largest, rms;
    size_t bytes; /* of everything the mesh needs then */
} certificate_level;

/* `clip` of a place in a random pose of a rig. */
#define CERTIFY_RANDOM (-2)

typedef struct {
    int mesh; /* scene.meshes */
    int vertices, triangles, bases, bits;
    int affine; /* 0 none, 1 affine, 2 rotations */
    double tolerance, largest, rms;
    int clip, frame,
        vertex;  /* where the largest is; clip -1: shapes set one by one, frame says which */
    double when; /* [s] in that clip */
    size_t rest_bytes, basis_bytes, weight_bytes, affine_bytes, normal_bytes, triangle_bytes;
    int at_work;              /* the most bases whose weights are not 0 in any one frame */
    certificate_level *level; /* bases + 1 of them, or NULL */
} certificate_mesh;

/* One mesh of b->shapes, without levels; what the file holds must be a bake of them. */
void certify_mesh(const build *b, const wg_file *file, int index, certificate_mesh *out);

/* Adds the levels. */
void certify_levels(const build *b, const wg_file *file, int index, certificate_mesh *out);
void certificate_mesh_free(certificate_mesh *m);

#endif
