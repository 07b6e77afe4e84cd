/* Skins of a scene: for every rig a domain, weights on it, endpoint weights, and the few bytes a
 * vertex that the clip holds.                                            [Jacobson ch. 4, 6]
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SKINS_H
#define BAKE_SKINS_H

#include "bounded.h"
#include "influence.h"
#include "shapes.h"

/* Which bone each handle is, and what the solver said of it. */
typedef struct {
    int bone;
    bounded_report report;
} skin_handle;

/* Values of all channels at moments of all clips, and at random: count x channels. What pruning is
 * judged by, and the certificate. */
typedef struct {
    int count, own; /* the first `own` are moments of clips; the others random */
    int channels;
    double *value;
} skin_poses;

/* What one rig became. Vertices are those of its mesh, in the clip's order. */
typedef struct skin {
    int rig; /* scene.rigs */
    int vertex_count, bone_count;
    double *weight;    /* vertex_count x bone_count, column by column: as solved, sums 1 */
    double *end;       /* the same, or NULL: no endpoint weights */
    influence *stored; /* vertex_count */
    double *field;     /* scene_rig.field_count x bone_count, row by row */
    int handle_count;  /* 0: weights came from a file */
    skin_handle *handle;
    int dimension, domain_vertices, domain_elements, wrapped;
    double far;       /* largest distance of a vertex from the domain [scene units] */
    double coupled;   /* largest difference that dividing by the sums made, or 0 */
    double tolerance; /* of pruning and rounding [scene units] */
    double pruned;    /* largest distance that they made in any pose looked at */
    skin_poses poses; /* those */
} skin;

/* Before meshes are loaded: bones from files, captured rotations as curves, and everything that moves
 * a bone as one of its joints. */
int skins_prepare(scene *s, bake_error *error);

/* After a mesh is decomposed: its skin. Sorts the vertices of a mesh without bases. */
int skin_make(scene *s, shape_mesh *m, int verbose, bake_error *error);
void skin_free(skin *k);

/* Vertices posed by the weights as solved (stored = 0), or by the stored ones. rest: vertex_count x 3.
 */
void skin_pose(const scene_rig *rig, const skin *k, const double *value, const double *rest,
               int stored, double *out);

#endif
