/* The scene file as a tree with line numbers. libcyaml checks and loads the schema but keeps no
 * lines, and it has no type for "a word or a mapping" and for mappings with free keys; both come
 * from here.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SCENE_TREE_H
#define BAKE_SCENE_TREE_H

#include "bake.h"

typedef enum { NODE_SCALAR, NODE_MAPPING, NODE_SEQUENCE } scene_node_kind;

/* Children are a list: child is the first, next the sibling, -1 = none. */
typedef struct {
    scene_node_kind kind;
    int line; /* where it starts; of the key for a child of a mapping */
    int parent, child, last, next, child_count;
    char *key;   /* NULL inside a sequence */
    char *value; /* scalars only */
} scene_node;

typedef struct {
    char *path;
    unsigned char *text; /* the whole file */
    size_t size;
    int count, room;
    scene_node *nodes; /* [0] is the root, a mapping */
} scene_tree;

/* Reads a file of at most 16 MiB. Refuses what a scene never needs: anchors and aliases, several
 * documents, a key twice, keys that are not words, more than 16 levels, more than 2^20 nodes,
 * more than 512 keys in one mapping. */
int scene_tree_load(const char *path, scene_tree *tree, bake_error *error);
void scene_tree_free(scene_tree *tree);

/* The child of a mapping with this key, or -1; -1 also when `node` is -1 or no mapping. */
int scene_tree_find(const scene_tree *tree, int node, const char *key);

/* The line of a mapping's field, or the mapping's own when the field is absent or NULL. */
int scene_tree_line(const scene_tree *tree, int node, const char *field);

#endif
