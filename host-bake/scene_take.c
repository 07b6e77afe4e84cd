/* Captured motion of rigs in clips, and what no clip may move because a rig does.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <string.h>

static const char take_example[] = "rigs: [{rig: man, source: walk, from: 6 s, to: 14 s}]";

/* The clips are not read yet when rigs are: this looks at what they will say. */
int scene_rig_travels(const loader *l, int rig)
{
    const char *name = l->yaml->rigs[rig].name;
    for (unsigned i = 0; i < l->yaml->clips_count; i++)
        for (unsigned j = 0; j < l->yaml->clips[i].rigs_count; j++) {
            const yaml_take *t = &l->yaml->clips[i].rigs[j];
            if (t->rig != NULL && t->travel != NULL && strcmp(t->rig, name) == 0 &&
                (strcmp(t->travel, "true") == 0 || strcmp(t->travel, "yes") == 0))
                return 1;
        }
    return 0;
}

static int has_node(const scene_rig *rig)
{
    for (int i = 0; i < rig->bone_count; i++)
        if (rig->bones[i].node != NULL)
            return 1;
    return rig->file != NULL; /* its bones are the nodes */
}

static int check_take(const loader *l, const scene_clip *clip, const scene_take *to, int index)
{
    const scene *s = l->out;
    const scene_rig *rig = &s->rigs[to->rig];
    for (int i = 0; i < index; i++)
        if (clip->takes[i].rig == to->rig)
            return loader_fail(l, "rig", "the clip '%s' moves the rig '%s' already, in line %d",
                               clip->name, rig->name, clip->takes[i].line);
    if (!has_node(rig))
        return loader_fail(l, "rig",
                           "no bone of the rig '%s' has a 'node' that it turns as; write for "
                           "example:  {name: thigh, ..., node: LeftUpLeg}",
                           rig->name);
    if (rig->method ==
        (int)WG_SKIN_SHIFT) /* bones with a 'node' have been refused; those of a file */
        return loader_fail(l, "rig",
                           "captures turn bones, and the rig '%s' with 'method: shift' only moves "
                           "them",
                           rig->name);
    return scene_is_csv(s->sources[to->source].file)
               ? loader_fail(l, "source",
                             "the source '%s' is a table without joints; a rig takes BVH, glTF, "
                             "FBX and the like",
                             s->sources[to->source].name)
               : 0;
}

static int read_take(loader *l, const yaml_take *from, scene_clip *clip, int index)
{
    static const scene_measure scale = {"a factor such as 0.5", {{NULL, 0}}, 1e-6, 1e6};
    const scene *s = l->out;
    scene_take *to = &clip->takes[index];
    *to = (scene_take){.line = scene_tree_line(l->tree, l->node, NULL), .scale = 1};
    if (loader_need(l, "rig", from->rig, take_example) ||
        loader_reference(l, "rig", from->rig, SCENE_NAMES(s->rigs, s->rig_count), &to->rig) ||
        loader_need(l, "source", from->source, take_example) ||
        loader_reference(l, "source", from->source, SCENE_NAMES(s->sources, s->source_count),
                         &to->source) ||
        check_take(l, clip, to, index) ||
        loader_number(l, "from", from->from, &scene_time, &to->from) ||
        loader_number(l, "to", from->to, &scene_time, &to->to) ||
        loader_number(l, "scale", from->scale, &scale, &to->scale) ||
        loader_flag(l, "travel", from->travel, &to->travel))
        return -1;
    if (from->to != NULL && to->to <= to->from)
        return loader_fail(l, "to", "'to' is %g s; it must be after 'from', %g s", to->to,
                           to->from);
    return from->scale != NULL && !to->travel
               ? loader_fail(l, "scale",
                             "'scale' is of the way that roots go; write 'travel: true', or remove "
                             "'scale'")
               : 0;
}

int scene_read_takes(loader *l, int clip)
{
    const yaml_clip *from = &l->yaml->clips[clip];
    scene_clip *to = &l->out->clips[clip];
    if (from->rigs_count == 0)
        return 0;
    if (to->additive)
        return loader_fail(l, "rigs",
                           "the clip '%s' is additive; captured rotations are no differences",
                           to->name);
    to->takes = bake_alloc(from->rigs_count, sizeof *to->takes);
    to->take_count = (int)from->rigs_count;
    int mapping = l->node;
    l->node = l->tree->nodes[scene_tree_find(l->tree, mapping, "rigs")].child;
    for (int i = 0; i < to->take_count; i++, l->node = l->tree->nodes[l->node].next)
        if (read_take(l, &from->rigs[i], to, i))
            return -1;
    l->node = mapping;
    return 0;
}

/* The bone whose captures fill the channel, or NULL. */
static const scene_bone *captures(const scene_rig *rig, int channel)
{
    for (int i = 0; i < rig->bone_count; i++) {
        const scene_bone *b = &rig->bones[i];
        if ((b->captured >= 0 && channel >= b->captured && channel < b->captured + 4) ||
            (b->travels >= 0 && channel >= b->travels && channel < b->travels + 3))
            return b;
    }
    return NULL;
}

static int check_curve(const loader *l, const scene_clip *clip, const scene_curve *curve)
{
    const scene *s = l->out;
    const char *name = s->channels[curve->channel].name;
    for (int i = 0; i < s->rig_count; i++)
        for (int j = 0; j < s->rigs[i].field_count; j++)
            if (s->rigs[i].fields[j].channel == curve->channel)
                return bake_fail(l->error,
                                 "%s:%d: the channel '%s' is a field of the rig '%s', in line %d, "
                                 "and has no curves; move the 'value' channels of the bones",
                                 l->tree->path, curve->line, name, s->rigs[i].name,
                                 s->rigs[i].fields[j].line);
    for (int i = 0; i < clip->take_count; i++) {
        const scene_bone *b = captures(&s->rigs[clip->takes[i].rig], curve->channel);
        if (b != NULL)
            return bake_fail(l->error,
                             "%s:%d: the channel '%s' is what the capture in line %d fills of the "
                             "bone '%s'; remove the curve or the bone's 'node'",
                             l->tree->path, curve->line, name, clip->takes[i].line, b->name);
    }
    return 0;
}

int scene_check_takes(const loader *l)
{
    const scene *s = l->out;
    for (int i = 0; i < s->clip_count; i++)
        for (int j = 0; j < s->clips[i].curve_count; j++)
            if (check_curve(l, &s->clips[i], &s->clips[i].curves[j]))
                return -1;
    return 0;
}
