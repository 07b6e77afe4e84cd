/* The elastic bodies of a scene: from meshes, materials and poses to motion.      [Schulz ch. 2]
 * What follows is done once and kept on disk (cache.h): tetrahedra, modes, dragged poses, reduced
 * models. What people change while they work - times, velocities, damping, stiffness, weights - is
 * not in it and takes milliseconds.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BODIES_H
#define BAKE_BODIES_H

#include "shapes.h"

/* What the certificate says of one motion of a body. */
typedef struct {
    int clip, action; /* scene.clips[clip].actions[action] */
    int dimension;    /* of its reduced space */
    double energy;    /* E_f2 [kg m^2/s^3] */
    double cubic;     /* of the cubic spline through the same poses, -1: not comparable */
    double missed;    /* root mean square distance from partial poses [scene units], -1: none */
} body_motion_report;

typedef struct {
    int body;                            /* of the scene */
    int vertices, elements, coordinates; /* what is free */
    int rigid, mode_count;
    double
        *hertz; /* mode_count: of the elastic modes as the body is held by itself; < 0: unstable */
    double residual; /* the worst of them */
    double mass;     /* [kg] */
    double far;      /* largest distance of an attached vertex from the body [scene units] */
    int waves;       /* 1: its channels are the splines themselves; 0: frames were decomposed */
    int motion_count;
    body_motion_report *motion;
} body_report;

typedef struct bodies {
    int count;
    body_report *report;
    int given_count;
    shape_given **given; /* owned: one a body whose channels are waves */
} bodies;

/* Files of poses become shapes of their meshes, so that mesh_load reads them: before it. */
void bodies_want(scene *s);

/* After mesh_load of all meshes: fills frames, and given bases, of the meshes that bodies move, and
 * the curves of their outputs in the scene's clips. A chain's mesh is made here. */
int bodies_make(scene *s, shapes *sh, int verbose, bodies *out, bake_error *error);
void bodies_free(bodies *b);

#endif
