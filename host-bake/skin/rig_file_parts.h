/* Between the files that read rigs: for the process that reads files.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_RIG_FILE_PARTS_H
#define BAKE_RIG_FILE_PARTS_H

#include "rig_nodes.h"
#include "scene.h"

#define FILE_NAME_BYTES 64 /* of a bone */

typedef struct {
    const char *name; /* `text` */
    char text[FILE_NAME_BYTES];
    int node, parent; /* parent: an earlier one, -1: none */
    int child;        /* the first bone that hangs on it and is elsewhere; -1: none */
} file_bone;

typedef struct {
    int count;
    file_bone *bone;
} file_bones;

/* From a file's axes to the scene's: the mesh's `up` and `scale`. */
affine file_world(const scene_mesh *m);

/* The nodes that are bones, parents first; none where no vertex follows a node. longest: letters
 * that a name may have. */
void file_bones_list(const rig_nodes *n, int longest, file_bones *out);
void file_bones_free(file_bones *b);

/* Letters that the bones of a rig have for their names: channels are <rig>_<bone>_move_x. */
int file_name_longest(const scene_rig *rig);

#endif
