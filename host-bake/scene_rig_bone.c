/* Bones of a rig: where they are at rest and what they hang on.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <string.h>

/* Shorter than any mesh shows. */
static const double least_length = 1e-6;

static const char bone_example[] = "- {name: upper, from: [0, 90, 0], to: [40, 90, 0]}";
static const char region_example[] = "region: {ball: {centre: [0, 90, 0], radius: 5}}";

static scene_rig *current(const loader *l)
{
    return &l->out->rigs[l->rig];
}

double scene_bone_along(const scene_bone *parent, const double from[3])
{
    double square = 0, along = 0;
    for (int k = 0; k < 3; k++) {
        double way = parent->to[k] - parent->from[k];
        square += way * way;
        along += way * (from[k] - parent->from[k]);
    }
    return square > 0 ? fmin(1, fmax(0, along / square)) : 0;
}

/* The place is found later: see scene.h. */
static void leave_place(scene_bone *to)
{
    for (int k = 0; k < 3; k++)
        to->from[k] = to->to[k] = (double)NAN;
}

static int read_parent(const loader *l, const char *text, int index, scene_bone *to)
{
    char hint[SCENE_HINT_BYTES];
    scene_names before = SCENE_NAMES(current(l)->bones, index);
    to->parent = -1;
    if (text == NULL)
        return 0;
    to->parent = index > 0 ? scene_names_find(&before, text) : -1;
    if (to->parent < 0)
        return loader_fail(
            l, "parent",
            "there is no bone '%.60s' before this one, and a parent comes before its bones; %s",
            text, scene_names_hint(&before, text, hint));
    return 0;
}

/* Where `from` is absent: the parent's end. */
static int start_at_parent(const loader *l, scene_bone *to)
{
    if (to->parent < 0)
        return loader_fail(l, NULL,
                           "the bone '%s' starts nowhere: give it 'from', or a 'parent' at whose "
                           "end it starts",
                           to->name);
    const scene_bone *parent = &current(l)->bones[to->parent];
    if (isnan(parent->to[0]))
        return loader_fail(l, NULL,
                           "where '%s' ends is found later than this is read; give the bone '%s' "
                           "its own 'from'",
                           parent->name, to->name);
    memcpy(to->from, parent->to, sizeof to->from);
    return 0;
}

static int read_segment(loader *l, scene_bone *to)
{
    to->kind = BONE_BONE;
    if (loader_place(l, "to", to->to) ||
        (loader_has(l, "from") ? loader_place(l, "from", to->from) : start_at_parent(l, to)))
        return -1;
    double square = 0;
    for (int k = 0; k < 3; k++)
        square += (to->to[k] - to->from[k]) * (to->to[k] - to->from[k]);
    return square < least_length * least_length
               ? loader_fail(l, "to",
                             "the bone '%s' has no length; a point is written  {name: %s, at: [%g, "
                             "%g, %g]}",
                             to->name, to->name, to->to[0], to->to[1], to->to[2])
               : 0;
}

static int read_region(loader *l, const yaml_bone *from, scene_bone *to)
{
    int bone = l->node;
    to->kind = BONE_REGION;
    to->region = bake_alloc(1, sizeof *to->region);
    l->node = scene_tree_find(l->tree, bone, "region");
    if (scene_read_region_form(l, from->region, region_example, to->region))
        return -1;
    l->node = bone;
    leave_place(to);
    return 0;
}

/* A point, a region's turning centre, or a vertex of a cage: from = to. */
static int read_point(loader *l, const yaml_bone *from, scene_bone *to)
{
    const char *field = loader_has(l, "cage") ? "cage" : "at";
    to->kind = loader_has(l, "cage") ? BONE_CAGE : BONE_POINT;
    if (from->region != NULL && read_region(l, from, to))
        return -1;
    if (!loader_has(l, field))
        return 0;
    if (loader_place(l, field, to->from))
        return -1;
    memcpy(to->to, to->from, sizeof to->to);
    return 0;
}

static int read_kind(loader *l, const yaml_bone *from, scene_bone *to)
{
    int segment = loader_has(l, "to"), cage = loader_has(l, "cage");
    int point = loader_has(l, "at") || from->region != NULL;
    int kinds = segment + cage + point;
    if (loader_has(l, "from") && !segment)
        return loader_fail(l, "from", "a bone with 'from' needs 'to'; a point has 'at' instead");
    if (kinds == 0 && current(l)->file != NULL) {
        leave_place(to);
        return 0;
    }
    if (kinds != 1)
        return loader_fail(l, NULL,
                           "a bone is one of 'to', 'at', 'region' or 'cage'%s; write for example:  "
                           "%s",
                           kinds > 1 ? ", not several" : "", bone_example);
    return segment ? read_segment(l, to) : read_point(l, from, to);
}

static void find_along(const scene_rig *rig, scene_bone *to, int at_end)
{
    if (to->parent < 0)
        return;
    const scene_bone *parent = &rig->bones[to->parent];
    int unknown = isnan(to->from[0]) || isnan(parent->from[0]);
    to->along = unknown                               ? (double)NAN
                : at_end && parent->kind == BONE_BONE ? 1
                                                      : scene_bone_along(parent, to->from);
}

static int read_looks(loader *l, const yaml_bone *from, scene_bone *to)
{
    const scene *s = l->out;
    to->value = -1;
    if (from->node != NULL) {
        if (loader_need(l, "node", from->node, "node: LeftUpLeg"))
            return -1;
        to->node = bake_copy(from->node);
    }
    if (from->value != NULL) {
        to->value = loader_find(l, "value", "channel", from->value,
                                SCENE_NAMES(s->channels, s->channel_count));
        if (to->value < 0)
            return -1;
    }
    return loader_number(l, "depth", from->depth, &scene_way, &to->depth) ||
                   loader_flag(l, "weightless", from->weightless, &to->weightless)
               ? -1
               : 0;
}

int scene_read_bone(loader *l, int index)
{
    const yaml_rig *y = &l->yaml->rigs[l->rig];
    const yaml_bone *from = &y->bones[index];
    scene_bone *to = &current(l)->bones[index];
    to->line = scene_tree_line(l->tree, l->node, NULL);
    to->captured = to->travels = -1;
    if (loader_name(l, SCENE_NAMES(y->bones, y->bones_count), index, bone_example, &to->name) ||
        read_parent(l, from->parent, index, to) || read_kind(l, from, to) ||
        read_looks(l, from, to))
        return -1;
    find_along(current(l), to, loader_has(l, "to") && !loader_has(l, "from"));
    return scene_read_joints(l, to);
}
