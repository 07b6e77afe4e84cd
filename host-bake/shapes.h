/* Deformable shapes: frames of meshes become a rest shape, a few bases and channels that weigh
 * them.
 *                                                                               [Alexa ch. 7]
 * shapes_make loads every mesh of the scene, decomposes it and appends what it needs to the scene:
 * channels, the curves that move them in each clip, masks. From there on they are channels like any
 * others. shapes_bake does the whole bake and repeats it with less room for the parts while the
 * finished file, played by the real player, misses a mesh's tolerance.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SHAPES_H
#define BAKE_SHAPES_H

#include "build.h"
#include "mesh.h"
#include "shape_affine.h"

/* Bases that are known beforehand and have curves of their own: the modes of an elastic body,
 * shared by all meshes that it moves. A channel value of 1 moves the vertex that moves most by
 * 1. */
typedef struct {
    int clip, basis;   /* ascending basis, then clip */
    scene_curve curve; /* without its channel; owned */
} given_curve;

typedef struct {
    const char *owner; /* channels are named <owner>_0 and so on */
    int count, curve_count;
    given_curve *curve;
    int channel; /* the first of `count` of the scene, -1: not attached */
} shape_given;

/* One basis as the file will hold it. */
typedef struct {
    int channel;    /* of the scene */
    int given;      /* which of shape_given's, or -1 */
    int piece;      /* the piece of the sequence that it serves, or -1: all of it */
    double scale;   /* how far a channel value of 1 moves the vertex that moves most [unit] */
    int16_t *entry; /* 3 vertex_count: 32767 (127 * 256 in 8 bits) stands for `scale` */
    double *weight; /* a frame: the channel's value; NULL: the channel is the scene's own */
} shape_basis;

/* A stretch of vertices moved by basis a, or by a and b (SPEC 4.15). */
typedef struct {
    int a, b; /* b = -1: none */
    int first, count;
} shape_block;

/* An array of vectors: positions or normals. */
typedef struct {
    int vertex_count, frac, bits; /* frac: raw = value 2^frac; bits of the bases */
    double origin[3];
    int16_t *rest; /* 3 vertex_count, from the origin */
    int affine;    /* the first of 12 channels, -1 = none */
    int basis_count, block_count;
    shape_basis *basis;
    shape_block *block;
} shape_form;

/* Shares of a mesh's tolerance: what the bases may leave, and what the curves of weights and of the
 * whole's motion may add. The rest is the integers'. */
typedef struct {
    double bases, curves;
} shape_aim;

/* What one mesh became. Its vertices have moved in their arrays: those that a basis moves first. */
typedef struct {
    int index; /* scene.meshes */
    mesh mesh;
    shape_aim aim;
    int stale, tries;     /* to be decomposed again, with another aim; how often that happened */
    double tolerance;     /* [unit] */
    int frame_count;      /* of all its motions, one behind the other */
    int finer;            /* frames are 2^finer times denser than bases need */
    const double **frame; /* a frame: 3 vertex_count, in mesh */
    shape_affine *turn;   /* a frame; NULL: nothing moves the mesh as a whole */
    int rotated; /* the turns are rotations: some frame is mirrored, or badly conditioned */
    int piece_count;
    int *piece; /* a frame: which piece of the sequence it is in */
    shape_form form, normals;
    double left;        /* largest distance in any frame before curves and integers [unit] */
    shape_given *given; /* a body's, or NULL: bases are found */
    double *
        given_basis; /* given->count x 3 vertex_count, in the order of mesh.rest as it was loaded */
    double *given_weight; /* given->count x frame_count */
    int has_normals;
    int channel_first, channel_count; /* that this mesh appended to the scene */
    struct skin *skin;                /* of a mesh with a rig, else NULL */
    int shown_count;                  /* poses of the rig that views are fitted to ... */
    double *shown;                    /* ... x vertex_count x 3 */
} shape_mesh;

typedef struct shapes {
    int count;
    shape_mesh *mesh;
    int channel_first; /* channels of the scene from here on were made by meshes */
    struct bodies *bodies;
} shapes;

/* Loads and decomposes every mesh of `s`, appends channels and curves to it, fits its views. The
 * scene must outlive `out`; shapes_free leaves it as it is. */
int shapes_make(scene *s, shapes *out, int verbose, bake_error *error);
void shapes_free(shapes *sh);

/* The whole bake of a scene, with or without meshes. Free `b` before `out`. */
int shapes_bake(scene *s, int verbose, shapes *out, build *b, bake_error *error);

/* Bits that a basis takes: those of the form, or 16 in a form of 8 where entries are not multiples
 * of
 * 256. */
int shape_basis_bits(const shape_form *form, int basis);

/* Bytes of a form's block data, as packed; bits of its components. */
int shape_block_bits(const shape_form *form, const shape_block *block);
size_t shape_block_bytes(const shape_form *form, const shape_block *block);

/* What the player makes of a form's stored integers, in doubles and before the affine part:
 * origin + rest + the weighted bases, of basis_count or fewer `bases`. value: a channel's each
 * basis. y: 3 vertex_count. */
void shape_form_eval(const shape_form *form, const double *value, int bases, double *y);

#endif
