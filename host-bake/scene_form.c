/* Free forms of a scene: what may be written in several ways, read from the tree.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include <math.h>
#include <string.h>

static const scene_measure part = {"a number such as 0.7", {{NULL, 0}}, -1e6, 1e6};

int loader_find(const loader *l, const char *field, const char *what, const char *text,
                scene_names names)
{
    char hint[SCENE_HINT_BYTES];
    int found = names.count > 0 ? scene_names_find(&names, text) : -1;
    if (found < 0)
        return loader_fail(l, field, "there is no %s '%.60s'; %s", what, text,
                           scene_names_hint(&names, text, hint));
    return found;
}

int loader_numbers(const loader *l, const char *field, int count, const scene_measure *measure,
                   double *out)
{
    const char *example = count == 3 ? "[0, 10, 0]" : "[0.5, 0.002]";
    int node = scene_tree_find(l->tree, l->node, field), i = 0;
    if (node < 0)
        return 0;
    const scene_node *list = &l->tree->nodes[node];
    int good = list->kind == NODE_SEQUENCE;
    if (good && list->child_count != count)
        return loader_fail(l, field, "'%s' has %d numbers; write %d:  %s: %s", field,
                           list->child_count, count, field, example);
    for (int child = list->child; good && child >= 0; child = l->tree->nodes[child].next, i++) {
        const scene_node *entry = &l->tree->nodes[child];
        good = entry->kind == NODE_SCALAR;
        if (good && loader_number(l, field, entry->value, measure, &out[i]))
            return -1;
    }
    return good ? 0
                : loader_fail(l, field, "'%s' must be %d numbers:  %s: %s", field, count, field,
                              example);
}

int loader_place(const loader *l, const char *field, double out[3])
{
    int flat = loader_list_count(l, field) == 2;
    if (flat)
        out[2] = 0;
    return loader_numbers(l, field, flat ? 2 : 3, &scene_way, out);
}

int loader_scalar(const loader *l, const char *field, const char **text)
{
    int node = scene_tree_find(l->tree, l->node, field);
    *text = NULL;
    if (node < 0)
        return 0;
    if (l->tree->nodes[node].kind != NODE_SCALAR)
        return loader_fail(l, field, "'%s' must be a single value", field);
    *text = l->tree->nodes[node].value;
    return 0;
}

int loader_known(const loader *l, const char *const *keys)
{
    scene_names names = {keys, sizeof *keys, 0};
    while (keys[names.count] != NULL)
        names.count++;
    for (int i = l->tree->nodes[l->node].child; i >= 0; i = l->tree->nodes[i].next) {
        char hint[SCENE_HINT_BYTES];
        const char *key = l->tree->nodes[i].key;
        if (scene_names_find(&names, key) < 0)
            return loader_fail(l, key, "unknown key '%.60s'; %s", key,
                               scene_names_hint(&names, key, hint));
    }
    return 0;
}

int loader_direction(const loader *l, const char *field, const char *example, double out[3])
{
    static const scene_word letters[] = {{"x", 0}, {"y", 1}, {"z", 2}, {NULL, 0}};
    int node = scene_tree_find(l->tree, l->node, field), letter = 0;
    if (node < 0)
        return loader_fail(l, field, "'%s' is missing; write for example:  %s", field, example);
    memset(out, 0, 3 * sizeof *out);
    if (l->tree->nodes[node].kind == NODE_MAPPING)
        return loader_fail(l, field, "'%s' must be x, y, z or three numbers [0, 0.7, 0.7]", field);
    if (l->tree->nodes[node].kind == NODE_SCALAR) {
        if (loader_word(l, field, l->tree->nodes[node].value, letters, &letter))
            return -1;
        out[letter] = 1;
        return 0;
    }
    if (loader_numbers(l, field, 3, &part, out))
        return -1;
    double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    if (length < 1e-6)
        return loader_fail(l, field, "'%s' has no direction: its numbers are all 0", field);
    for (int i = 0; i < 3; i++)
        out[i] /= length;
    return 0;
}

int loader_list_count(const loader *l, const char *field)
{
    int node = scene_tree_find(l->tree, l->node, field);
    return node >= 0 && l->tree->nodes[node].kind == NODE_SEQUENCE
               ? l->tree->nodes[node].child_count
               : 0;
}

int loader_list(loader *l, const char *field, const char *example,
                int (*read)(loader *l, int index))
{
    int node = scene_tree_find(l->tree, l->node, field);
    if (node < 0)
        return 0;
    int good = l->tree->nodes[node].kind == NODE_SEQUENCE;
    for (int i = l->tree->nodes[node].child; good && i >= 0; i = l->tree->nodes[i].next)
        good = l->tree->nodes[i].kind == NODE_MAPPING;
    if (!good)
        return loader_fail(l, field, "'%s' must be a list; write for example:  %s", field, example);
    return loader_each(l, field, read);
}
