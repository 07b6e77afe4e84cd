/* Between the files that make skins.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SKIN_PARTS_H
#define BAKE_SKIN_PARTS_H

#include "ends.h"
#include "rig.h"
#include "skins.h"

/* A rig under way. */
typedef struct {
    scene *s;
    const scene_rig *rig;
    shape_mesh *m;
    skin *out;
    handle *handle;  /* handle_count */
    int *bone;       /* of each handle */
    int (*facet)[3]; /* of handles */
    int **vertices;  /* of regions, a handle each */
    handles h;
    surface_origin origin;
    domain_options how;
    domain d;
    held held;
    embedding *at; /* of the mesh's vertices in the domain */
    double *w, *e; /* domain vertices x handles */
} skin_work;

/* skin_domain.c: domain, handles, held values, embedding. */
int skin_domain(skin_work *w, bake_error *error);

/* skin_weights.c: w and e on the domain, then on the mesh. */
int skin_weights(skin_work *w, bake_error *error);

/* skin_prune.c: stored influences; sorts vertices. */
int skin_prune(skin_work *w, bake_error *error);

/* skin_turns.c, after pruning: how exactly captured bones turn, as tolerances of their channels. */
void skin_turns(const skin_work *w);

/* Whether a point lies in a region that is a box or a ball. */
int skin_inside(const scene_region *r, const double x[3]);

/* "scene:line: rig NAME: ..." */
int skin_fail(const skin_work *w, int line, bake_error *error, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 4, 5)))
#endif
    ;

#endif
