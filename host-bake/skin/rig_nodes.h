/* The nodes of a file as a flat list: where they are at rest, when its meshes were bound to them,
 * and at any time of an animation. For the process that reads files (isolate.h).
 * Source: own.
 *
 *   own, bind  3 x 4: from the node's axes to its parent's, to the world's
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_RIG_NODES_H
#define BAKE_RIG_NODES_H

#include "bake.h"

#include <assimp/scene.h>

typedef struct {
    double at[3][4];
} affine;

affine affine_identity(void);
affine affine_of(const struct aiMatrix4x4 *m);
affine affine_product(const affine *a, const affine *b);

/* -1: it has no inverse. */
int affine_inverse(const affine *a, affine *out);

/* The rotation (w, x, y, z) nearest to the left 3 x 3 block; -1 when that is singular or mirrors.
 */
int affine_rotation(const affine *a, double q[4]);

/* w x y z */
void quaternion_product(const double a[4], const double b[4], double out[4]);
void quaternion_turn(const double q[4], const double v[3], double out[3]);

/* The keys of a channel in seconds: finite, strictly ascending. Rotations are unit quaternions,
 * each on the side of the one before. */
typedef struct {
    int count, width; /* numbers a key: 3 or 4 */
    double *time, *value;
} node_keys;

typedef struct {
    const char *name;
    int parent;  /* an earlier one; -1: the root */
    int skinned; /* vertices of the file follow it */
    affine own, bind;
    double still[3][4]; /* own in parts, for what no channel moves: position, rotation, scaling */
    node_keys keys[3];  /* of the same, where there are any */
} rig_node;

/* node: parents first; the children of one node follow each other in the file's order. world: from
 * the file's axes to the scene's. */
typedef struct {
    int count;
    rig_node *node;
    affine world;
} rig_nodes;

/* A node that vertices are bound to is at its bind pose
 * where they say, others where their parent takes them. */
void rig_nodes_make(const struct aiScene *file, const affine *world, rig_nodes *out);
void rig_nodes_free(rig_nodes *n);

/* Index of the first node of that name, or -1. */
int rig_nodes_find(const rig_nodes *n, const char *name);

/* The node of the first child that is not in the same place at bind, and the way there; -1: none.
 */
int rig_nodes_child(const rig_nodes *n, int node, double way[3]);

/* Takes the keys of an animation. The name of a node with a key that is no number, or NULL. */
const char *rig_nodes_animate(rig_nodes *n, const struct aiAnimation *animation);

/* Where a node is at `time` [s]; before the first key and behind the last one as there. */
void rig_nodes_pose(const rig_nodes *n, int node, double time, affine *out);

/* Opens a file as captures and meshes are read: the same nodes and names. NULL: it cannot be read.
 */
const struct aiScene *rig_nodes_open(const char *path);

#endif
