/* Which nodes of a file are bones, and what they are called.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_file_parts.h"
#include "scene_names.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

affine file_world(const scene_mesh *m)
{
    double s = m->scale;
    return m->up == 'z' ? (affine){{{s, 0, 0, 0}, {0, 0, s, 0}, {0, -s, 0, 0}}}
                        : (affine){{{s, 0, 0, 0}, {0, s, 0, 0}, {0, 0, s, 0}}};
}

int file_name_longest(const scene_rig *rig)
{
    return FILE_NAME_BYTES - 1 - (int)strlen(rig->name) - (int)strlen("__move_x");
}

/* The only node directly below one that has bones in it, or -1. */
static int only_below(const rig_nodes *n, const char *in, int node)
{
    int found = -1;
    for (int i = node + 1; i < n->count; i++) {
        if (n->node[i].parent == node && in[i]) {
            if (found >= 0) {
                return -1;
            }
            found = i;
        }
    }
    return found;
}

/* Nodes that vertices follow and all above them up to the one they have in common; not the file's
 * root, which is above all that there is. */
static char *choose(const rig_nodes *n)
{
    char *in = bake_alloc((size_t)n->count, 1);
    for (int i = n->count - 1; i >= 0; i--) {
        in[i] = in[i] || n->node[i].skinned;
        if (in[i] && n->node[i].parent >= 0) {
            in[n->node[i].parent] = 1;
        }
    }
    for (int i = 0; i >= 0 && in[i] && !n->node[i].skinned;) {
        int below = only_below(n, in, i);
        in[i] = below < 0 && i > 0;
        i = below;
    }
    return in;
}

/* A name as the scene has them: begins with a letter, goes on with letters, digits, '_' and '-'; no
 * other of the list makes the same C macro. */
static void make_name(const char *node, const file_bones *before, int longest, char *out)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    static const char others[] = "0123456789_-";
    int first = node[0] == '\0' || strchr(letters, node[0]) == NULL, tail = 0;
    snprintf(out, (size_t)longest + 1, "%s%s", first ? "b" : "", node);
    for (int i = 0; out[i] != '\0'; i++) {
        if (strchr(letters, out[i]) == NULL && strchr(others, out[i]) == NULL) {
            out[i] = '_';
        }
    }
    scene_names names = SCENE_NAMES(before->bone, before->count);
    size_t length = strlen(out);
    while (before->count > 0 && scene_names_find_macro(&names, out) >= 0) {
        char number[12];
        int digits = snprintf(number, sizeof number, "_%d", ++tail + 1);
        size_t room = (size_t)(longest - digits);
        snprintf(out + (length < room ? length : room), (size_t)digits + 1, "%s", number);
    }
}

/* The first bone that is not in the same place. */
static void find_children(const rig_nodes *n, file_bones *b)
{
    for (int i = b->count - 1; i > 0; i--) {
        int parent = b->bone[i].parent;
        double apart = 0, size = 0;
        for (int k = 0; k < 3 && parent >= 0; k++) {
            double a = n->node[b->bone[parent].node].bind.at[k][3];
            double c = n->node[b->bone[i].node].bind.at[k][3];
            apart += fabs(c - a);
            size += fabs(c) + fabs(a);
        }
        if (parent >= 0 && apart > 1e-6 * size) {
            b->bone[parent].child = i;
        }
    }
}

void file_bones_list(const rig_nodes *n, int longest, file_bones *out)
{
    char *in = choose(n);
    int *bone = bake_alloc((size_t)n->count, sizeof *bone); /* of each node, from 1 */
    *out = (file_bones){.bone = bake_alloc((size_t)n->count, sizeof *out->bone)};
    for (int i = 0; i < n->count; i++) {
        if (in[i]) {
            file_bone *b = &out->bone[out->count];
            *b = (file_bone){.node = i, .parent = -1, .child = -1};
            if (n->node[i].parent >= 0) {
                b->parent = bone[n->node[i].parent] - 1;
            }
            make_name(n->node[i].name, out, longest, b->text);
            b->name = b->text;
            bone[i] = ++out->count;
        }
    }
    find_children(n, out);
    free(bone);
    free(in);
}

void file_bones_free(file_bones *b)
{
    free(b->bone);
    *b = (file_bones){0};
}
