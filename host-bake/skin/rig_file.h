/* Rigs that a file brings along (glTF, FBX, X ...): its bones, and the weights of its
 * mesh.
 * Source: own.
 *
 * Bones are the nodes that vertices follow, and what lies between them up to the node that all have
 * above them (weightless). A bone starts where its node was when the mesh was bound, and ends where
 * its first child bone starts, at the node's first child, or half its parent's length farther on.
 * It has the node's name, with '_' for what a name cannot hold, and follows the node of that name
 * in captures.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_RIG_FILE_H
#define BAKE_RIG_FILE_H

#include "mesh.h"

/* Puts the bones of scene.rigs[rig].file before those of the scene. A bone of the scene that has
 * the name of one of them stays that one and adds what it says: a place of its own, node, joints,
 * value, depth. Captured channels of a file's bones are made where a take turns them (rig_takes): a
 * clip has few. */
int rig_file_bones(scene *s, int rig, bake_error *error);

/* The file's own weights, rows sum to 1. m: of the rig's mesh; its vertices are found by their
 * places at rest. Parts that have no weights and hang on a bone's node follow that bone. w:
 * vertex_count x bone_count, column by column. Fails, naming it, on a vertex that is not there or
 * follows nothing. */
int rig_file_weights(const scene *s, int rig, const mesh *m, double *w, bake_error *error);

#endif
