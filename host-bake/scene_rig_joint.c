/* Joints of bones: which channels turn, move, stretch and twist them.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { JOINTS_MAX = 16, FOLLOWS_MAX = 8, NAME_MAX_LETTERS = 63 };

#define BIT(kind) (1u << (kind))
#define AXIAL     (BIT(WG_JOINT_TURN) | BIT(WG_JOINT_MOVE))
#define ANGLES    (BIT(WG_JOINT_TURN) | BIT(WG_JOINT_TWIST_START) | BIT(WG_JOINT_TWIST_END))
#define LENGTHWAY (BIT(WG_JOINT_STRETCH) | BIT(WG_JOINT_TWIST_START) | BIT(WG_JOINT_TWIST_END))

static const char joint_example[] = "{turn: z, channel: elbow}";
static const char follow_example[] = "{follow: [hip, hand]}";

/* What a joint does, by its key. */
static const scene_word kinds[] = {{"turn", WG_JOINT_TURN},
                                   {"move", WG_JOINT_MOVE},
                                   {"stretch", WG_JOINT_STRETCH},
                                   {"twist", WG_JOINT_TWIST_END},
                                   {"twist-end", WG_JOINT_TWIST_END},
                                   {"twist-start", WG_JOINT_TWIST_START},
                                   {"quaternion", WG_JOINT_QUATERNION},
                                   {"follow", WG_JOINT_FOLLOW},
                                   {NULL, 0}};

static const char *const parts[4] = {"w", "x", "y", "z"};

/* ---- channels -------------------------------------------------------------------------------- */

/* What the channel must be for what it does. */
static int check_channel(const loader *l, const char *key, const scene_joint *to)
{
    const scene_channel *c = &l->out->channels[to->channel];
    const char *where = BIT(to->kind) & AXIAL ? "channel" : key;
    if (BIT(to->kind) & ANGLES && c->unit != (int)WG_UNIT_DEGREE)
        return loader_fail(l, where, "the channel '%s' takes an angle; give it 'unit: deg'",
                           c->name);
    if (to->kind == (int)WG_JOINT_MOVE && c->unit != (int)WG_UNIT_MILLIMETRE &&
        c->unit != (int)WG_UNIT_NONE)
        return loader_fail(l, where, "the channel '%s' takes a length; give it 'unit: mm'",
                           c->name);
    if (to->kind == (int)WG_JOINT_STRETCH && (c->unit != (int)WG_UNIT_NONE || c->rest <= 0))
        return loader_fail(l, where,
                           "the channel '%s' is a bone's length over that at rest; give it 'unit: "
                           "none' and 'rest: 1'",
                           c->name);
    return 0;
}

/* Four channels of the scene's own: in a row, a rotation at rest. */
static int check_given(const loader *l, const char *name, int first)
{
    const scene *s = l->out;
    double square = 0;
    int good = first + 4 <= s->channel_count;
    for (int k = 0; good && k < 4; k++) {
        char want[128];
        const scene_channel *c = &s->channels[first + k];
        snprintf(want, sizeof want, "%s_%s", name, parts[k]);
        good = strcmp(c->name, want) == 0 && c->unit == (int)WG_UNIT_NONE;
        square += c->rest * c->rest;
    }
    if (!good)
        return loader_fail(l, "quaternion",
                           "'%s' stands for the channels '%s_w', '%s_x', '%s_y' and '%s_z', one "
                           "after the other and of 'unit: none'; remove those that there are, and "
                           "the baker makes all four",
                           name, name, name, name, name);
    return fabs(square - 1) > 0.01
               ? loader_fail(l, "quaternion",
                             "the 'rest' values of '%s_w' to '%s_z' are no rotation: their squares "
                             "sum to %g, not 1; give '%s_w' 'rest: 1'",
                             name, name, square, name)
               : 0;
}

/* Nothing has a name that one of <owner>_<what> would have. */
static int check_new(const loader *l, const char *field, const char *owner, const char *what)
{
    const scene *s = l->out;
    char name[256];
    snprintf(name, sizeof name, "%.160s_%s", owner, what);
    if (strlen(name) > NAME_MAX_LETTERS)
        return loader_fail(l, field,
                           "the channel '%s' would have more than %d characters; choose shorter "
                           "names",
                           name, NAME_MAX_LETTERS);
    scene_names channels = SCENE_NAMES(s->channels, s->channel_count);
    scene_names meshes = SCENE_NAMES(s->meshes, s->mesh_count);
    int channel = scene_names_find_macro(&channels, name);
    int mesh = scene_names_find_macro(&meshes, name);
    if (channel >= 0 || mesh >= 0)
        return loader_fail(
            l, field,
            "the bone's channel '%s' and the %s '%s' become the same C macro; change "
            "one name",
            name, channel >= 0 ? "channel" : "mesh",
            channel >= 0 ? s->channels[channel].name : s->meshes[mesh].name);
    return 0;
}

static int check_room(const loader *l, const char *field, int count)
{
    const scene *s = l->out;
    return s->channel_count + count > (int)WG_CHANNELS_MAX
               ? loader_fail(
                     l, field,
                     "'%s' makes %d channels of the bone, and with the %d there are that is "
                     "more than the %u that the clip format holds",
                     field, count, s->channel_count, WG_CHANNELS_MAX)
               : 0;
}

/* Masks that there are grow with the channels. */
static int append(scene *s, const char *name, double rest, int mesh)
{
    size_t count = (size_t)s->channel_count;
    s->channels = bake_grow(s->channels, count + 1, sizeof *s->channels);
    s->channels[count] = (scene_channel){.name = bake_copy(name), .rest = rest};
    for (int i = 0; i < s->mask_count; i++) {
        scene_mask *m = &s->masks[i];
        if (m->weight == NULL)
            continue;
        m->weight = bake_grow(m->weight, count + 1, sizeof *m->weight);
        m->weight[count] = mesh >= 0 && m->mesh_weight != NULL ? m->mesh_weight[mesh] : 0;
    }
    return s->channel_count++;
}

int scene_add_channel(scene *s, const char *rig, const char *bone, const char *what, double rest)
{
    size_t size = strlen(rig) + strlen(bone) + strlen(what) + 3;
    char *name = bake_alloc(size, 1);
    scene_names known = SCENE_NAMES(s->channels, s->channel_count);
    scene_names rigs = SCENE_NAMES(s->rigs, s->rig_count);
    int owner = s->rig_count > 0 ? scene_names_find(&rigs, rig) : -1;
    snprintf(name, size, "%s_%s_%s", rig, bone, what);
    while (s->channel_count > 0 && scene_names_find_macro(&known, name) >= 0) {
        name = bake_grow(name, ++size, 1);
        strcat(name, "_");
    }
    int index = append(s, name, rest, owner >= 0 ? s->rigs[owner].mesh : -1);
    free(name);
    return index;
}

static const char *const travels[3] = {"move_x", "move_y", "move_z"};

void scene_add_captured(scene *s, const scene_rig *rig, scene_bone *bone, int travel)
{
    bone->captured = s->channel_count;
    for (int k = 0; k < 4; k++)
        scene_add_channel(s, rig->name, bone->name, parts[k], k == 0);
    bone->travels = travel ? s->channel_count : -1;
    for (int k = 0; travel && k < 3; k++)
        scene_add_channel(s, rig->name, bone->name, travels[k], 0);
}

static int add_captured(loader *l, scene_bone *bone)
{
    const scene_rig *rig = &l->out->rigs[l->rig];
    char owner[160];
    if (bone->node == NULL)
        return 0;
    if (rig->method == (int)WG_SKIN_SHIFT)
        return loader_fail(l, "node",
                           "captures turn bones, and a rig of 'method: shift' only moves them");
    int travel = bone->parent < 0 && scene_rig_travels(l, l->rig);
    snprintf(owner, sizeof owner, "%s_%s", rig->name, bone->name);
    if (check_room(l, "node", travel ? 7 : 4))
        return -1;
    for (int k = 0; k < 4; k++)
        if (check_new(l, "node", owner, parts[k]) ||
            (k < 3 && travel && check_new(l, "node", owner, travels[k])))
            return -1;
    scene_add_captured(l->out, rig, bone, travel);
    return 0;
}

/* ---- one joint ------------------------------------------------------------------------------- */

static int read_quaternion(loader *l, const char *name, scene_joint *to)
{
    scene *s = l->out;
    char first[80];
    char *checked = NULL;
    if (loader_need(l, "quaternion", name, "{quaternion: head}") ||
        loader_name(l, SCENE_NAMES(&name, 1), 0, "quaternion: head", &checked))
        return -1;
    free(checked);
    snprintf(first, sizeof first, "%s_w", name);
    scene_names channels = SCENE_NAMES(s->channels, s->channel_count);
    int found = s->channel_count > 0 ? scene_names_find(&channels, first) : -1;
    if (found >= 0) {
        to->channel = found;
        return check_given(l, name, found);
    }
    if (check_room(l, "quaternion", 4))
        return -1;
    for (int k = 0; k < 4; k++)
        if (check_new(l, "quaternion", name, parts[k]))
            return -1;
    to->channel = s->channel_count;
    for (int k = 0; k < 4; k++) {
        snprintf(first, sizeof first, "%s_%s", name, parts[k]);
        append(s, first, k == 0, -1);
    }
    return 0;
}

/* The channel's clamp filter, behind those that the scene lists: one a channel. */
static int add_clamp(const loader *l, const scene_joint *to, const double limits[2])
{
    scene *s = l->out;
    for (int i = (int)l->yaml->filters_count; i < s->filter_count; i++) {
        const scene_filter *f = &s->filters[i];
        if (f->channel != to->channel)
            continue;
        if (fabs(f->a - limits[0]) + fabs(f->b - limits[1]) > 0)
            return loader_fail(
                l, "limits",
                "the channel '%s' has the limits [%g, %g] already; a channel has one "
                "pair",
                s->channels[to->channel].name, f->a, f->b);
        return 0;
    }
    if (s->filter_count >= (int)WG_FILTERS_MAX)
        return loader_fail(l, "limits",
                           "limits are filters, and the clip format holds %u; remove one",
                           WG_FILTERS_MAX);
    s->filters = bake_grow(s->filters, (size_t)s->filter_count + 1, sizeof *s->filters);
    s->filters[s->filter_count++] = (scene_filter){
        .op = WG_FILTER_CLAMP, .channel = to->channel, .a = limits[0], .b = limits[1]};
    return 0;
}

static int read_limits(const loader *l, const scene_joint *to)
{
    double limits[2];
    if (!loader_has(l, "limits"))
        return 0;
    if (to->kind == (int)WG_JOINT_QUATERNION || to->kind == (int)WG_JOINT_FOLLOW)
        return loader_fail(l, "limits", "'limits' are of one channel; remove them here");
    const scene_channel *c = &l->out->channels[to->channel];
    if (loader_numbers(l, "limits", 2, &scene_value[c->unit][0], limits))
        return -1;
    if (limits[0] >= limits[1])
        return loader_fail(l, "limits", "'limits' must ascend, as in  limits: [-10, 140]");
    if (c->rest < limits[0] || c->rest > limits[1])
        return loader_fail(l, "limits",
                           "the channel '%s' rests at %g, outside its limits; change its 'rest' or "
                           "the limits",
                           c->name, c->rest);
    return add_clamp(l, to, limits);
}

static int read_channel(loader *l, const char *key, scene_joint *to)
{
    const scene *s = l->out;
    const char *text, *field = BIT(to->kind) & AXIAL ? "channel" : key;
    if (loader_scalar(l, field, &text) || loader_need(l, field, text, joint_example))
        return -1;
    to->channel =
        loader_find(l, field, "channel", text, SCENE_NAMES(s->channels, s->channel_count));
    return to->channel < 0 ? -1 : check_channel(l, key, to);
}

/* Exactly one of the words of `kinds` is a key of the joint; -1: see the message. */
static int find_kind(const loader *l)
{
    int found = -1, count = 0;
    for (int i = 0; kinds[i].word != NULL; i++)
        if (loader_has(l, kinds[i].word)) {
            found = i;
            count++;
        }
    if (count == 1)
        return found;
    return loader_fail(l, NULL,
                       "a joint is one of 'turn', 'move', 'stretch', 'twist', 'twist-start', "
                       "'quaternion' and 'follow'%s; write for example:  %s",
                       count > 1 ? ", not several" : "", joint_example);
}

/* What the rig's method and the bone's kind allow. */
static int check_kind(const loader *l, const scene_bone *bone, const char *key, int kind)
{
    const scene_rig *rig = &l->out->rigs[l->rig];
    if (rig->method == (int)WG_SKIN_SHIFT && kind != (int)WG_JOINT_MOVE)
        return loader_fail(l, key,
                           "bones of a rig with 'method: shift' only move; remove '%s', or use "
                           "'method: linear'",
                           key);
    if (BIT(kind) & LENGTHWAY && bone->kind != BONE_BONE)
        return loader_fail(l, key, "'%s' is along a bone, and '%s' has no length: give it 'to'",
                           key, bone->name);
    if (loader_has(l, "channel") && (BIT(kind) & AXIAL) == 0)
        return loader_fail(l, "channel", "'%s' names its channel itself; remove 'channel'", key);
    return 0;
}

static int read_joint(loader *l, scene_bone *bone)
{
    scene_joint *to = &bone->joints[bone->joint_count];
    int found = find_kind(l);
    if (found < 0 || check_kind(l, bone, kinds[found].word, kinds[found].value))
        return -1;
    const char *key = kinds[found].word, *text;
    to->kind = kinds[found].value;
    to->channel = -1;
    bone->joint_count++;
    if (to->kind == (int)WG_JOINT_FOLLOW)
        return read_limits(l, to); /* the rest: scene_read_follows */
    if (BIT(to->kind) & AXIAL && loader_direction(l, key, joint_example, to->axis))
        return -1;
    if (to->kind == (int)WG_JOINT_QUATERNION)
        return loader_scalar(l, key, &text) || read_quaternion(l, text, to) || read_limits(l, to)
                   ? -1
                   : 0;
    return read_channel(l, key, to) || read_limits(l, to) ? -1 : 0;
}

int scene_read_joints(loader *l, scene_bone *bone)
{
    int node = l->node, list = scene_tree_find(l->tree, node, "joints");
    int count = loader_list_count(l, "joints");
    if (count > JOINTS_MAX)
        return loader_fail(l, "joints", "'joints' has %d entries; a bone has at most %d", count,
                           JOINTS_MAX);
    bone->joints = bake_alloc((size_t)count, sizeof *bone->joints);
    int child = list >= 0 ? l->tree->nodes[list].child : -1;
    for (; child >= 0; child = l->tree->nodes[child].next) {
        l->node = child;
        if (bone->joint_count > 0 &&
            bone->joints[bone->joint_count - 1].kind == (int)WG_JOINT_FOLLOW)
            return loader_fail(l, NULL, "'follow' is the last joint of a bone; move it to the end");
        if (read_joint(l, bone))
            return -1;
    }
    l->node = node;
    return add_captured(l, bone);
}

/* ---- points that follow others --------------------------------------------------------------- */

/* Neither a bone with length, nor part of a tree. */
static int check_free(const loader *l, const scene_rig *rig, int bone)
{
    const scene_bone *b = &rig->bones[bone];
    if (b->kind == BONE_BONE)
        return loader_fail(l, "follow", "'follow' joins points, and '%s' is a bone with length",
                           b->name);
    if (b->parent >= 0)
        return loader_fail(l, "follow", "'follow' joins points without parent; '%s' has one",
                           b->name);
    for (int i = 0; i < rig->bone_count; i++)
        if (rig->bones[i].parent == bone)
            return loader_fail(l, "follow",
                               "'follow' joins points that are no parents; '%s' is that of '%s'",
                               b->name, rig->bones[i].name);
    return 0;
}

static int read_follow(loader *l, const scene_rig *rig, int bone, scene_joint *to)
{
    int list = scene_tree_find(l->tree, l->node, "follow"), count = loader_list_count(l, "follow");
    if (count < 1 || count > FOLLOWS_MAX)
        return loader_fail(l, "follow",
                           "'follow' is a list of 1 to %d points; write for example:  "
                           "%s",
                           FOLLOWS_MAX, follow_example);
    to->follow = bake_alloc((size_t)count, sizeof *to->follow);
    for (int i = l->tree->nodes[list].child; i >= 0; i = l->tree->nodes[i].next) {
        const scene_node *entry = &l->tree->nodes[i];
        if (entry->kind != NODE_SCALAR)
            return loader_fail(l, "follow", "'follow' is a list of names:  %s", follow_example);
        int other = loader_find(l, "follow", "bone", entry->value,
                                SCENE_NAMES(rig->bones, rig->bone_count));
        if (other < 0 || check_free(l, rig, other))
            return -1;
        for (int k = 0; k < to->follow_count; k++)
            if (to->follow[k] == other)
                return loader_fail(l, "follow", "'follow' names '%s' twice", entry->value);
        if (other == bone)
            return loader_fail(l, "follow", "'%s' cannot follow itself", entry->value);
        to->follow[to->follow_count++] = other;
    }
    return 0;
}

int scene_read_follows(loader *l, int index)
{
    const scene_rig *rig = &l->out->rigs[l->rig];
    scene_bone *b = &rig->bones[index];
    int last = b->joint_count - 1;
    if (last < 0 || b->joints[last].kind != (int)WG_JOINT_FOLLOW)
        return 0;
    l->node = l->tree->nodes[scene_tree_find(l->tree, l->node, "joints")].last;
    if (b->node != NULL)
        return loader_fail(l, "follow",
                           "the bone '%s' turns as its 'node' does; remove 'follow' or 'node'",
                           b->name);
    return check_free(l, rig, index) || read_follow(l, rig, index, &b->joints[last]) ? -1 : 0;
}
