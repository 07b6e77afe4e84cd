/* Motions of bodies in clips: poses at times, and what is between them.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ACTION_KEYS_MAX = 4096 };

/* Times are written with a few digits, so equal ones differ by rounding only. */
static const double same_time = 1e-9;

static const scene_word dynamics_words[] = {{"one-point", DYNAMICS_ONE_POINT},
                                            {"blend", DYNAMICS_BLEND},
                                            {"couple", DYNAMICS_COUPLE},
                                            {"spline", DYNAMICS_SPLINE},
                                            {NULL, 0}};

static const char action_example[] =
    "bodies: [{body: cactus, keys: [{time: 0, pose: rest}, {time: 0.4, pose: reach}]}]";
static const char key_example[] = "{time: 0.4, pose: reach}";

static const yaml_action *source(const loader *l)
{
    return &l->yaml->clips[l->clip].bodies[l->action];
}

static scene_action *current(const loader *l)
{
    return &l->out->clips[l->clip].actions[l->action];
}

/* A field that the dynamics or the body's kind ignores would be a surprise, so it is an error. */
static int check_fields(const loader *l, const scene_action *a)
{
    static const struct {
        const char *field;
        unsigned dynamics;
    } uses[] = {
        {"about", 1u << DYNAMICS_ONE_POINT},
        {"stiffness", ~(1u << DYNAMICS_SPLINE)},
        {"damping", ~(1u << DYNAMICS_SPLINE)},
        {"regularise", 1u << DYNAMICS_ONE_POINT | 1u << DYNAMICS_SPLINE | 1u << DYNAMICS_BLEND}};
    static const char *const elastic[] = {"fixed", "sliding"};
    const scene_body *b = &l->out->bodies[a->body];
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++)
        if (loader_has(l, uses[i].field) && (uses[i].dynamics & 1u << a->dynamics) == 0)
            return loader_fail(l, uses[i].field,
                               "a motion with 'dynamics: %s' has no '%s'; remove it",
                               dynamics_words[a->dynamics].word, uses[i].field);
    for (int i = 0; i < 2; i++)
        if (b->kind == SCENE_CHAIN && loader_has(l, elastic[i]))
            return loader_fail(l, elastic[i], "the body '%s' is a chain and has no '%s'; remove it",
                               b->name, elastic[i]);
    return 0;
}

static int read_held(loader *l, const yaml_action *from, scene_action *a)
{
    a->has_fixed = loader_has(l, "fixed");
    a->has_slides = loader_has(l, "sliding");
    if (scene_read_fixed(l, from->fixed, from->fixed_count, &a->fixed) ||
        scene_read_slides(l, from->sliding, from->sliding_count, &a->slides))
        return -1;
    a->fixed_count = (int)from->fixed_count;
    a->slide_count = (int)from->sliding_count;
    return 0;
}

static int read_physics(loader *l, const yaml_action *from, scene_action *a)
{
    static const scene_measure stiffness = {"a factor such as 2", {{NULL, 0}}, 1e-6, 1e6};
    const scene_body *b = &l->out->bodies[a->body];

    a->stiffness = 1;
    memcpy(a->damping, b->damping, sizeof a->damping);
    return loader_number(l, "stiffness", from->stiffness, &stiffness, &a->stiffness) ||
                   loader_numbers(l, "damping", 2, &scene_positive, a->damping) ||
                   loader_numbers(l, "regularise", 3, &scene_positive, a->regularise) ||
                   scene_read_pose_name(l, "about", from->about, b->pose_count, &a->about)
               ? -1
               : 0;
}

/* The models of several points meet hard, full poses only [Schulz 2.8]. */
static int check_multi_point(const loader *l, const scene_action *a)
{
    static const char *const fields[] = {"weight", "region", "velocity_weight"};
    int couple = a->dynamics == DYNAMICS_COUPLE; /* its velocities may be soft */
    if (a->dynamics != DYNAMICS_BLEND && !couple)
        return 0;
    for (int i = 0; i < (couple ? 2 : 3); i++)
        if (loader_has(l, fields[i]))
            return loader_fail(
                l, fields[i],
                "a key of a motion with 'dynamics: %s' is hard and of the whole body; "
                "remove '%s' or use 'dynamics: one-point'",
                dynamics_words[a->dynamics].word, fields[i]);
    return 0;
}

static int check_key(const loader *l, const scene_action *a, const scene_body_key *key, int index)
{
    const scene_clip *clip = &l->out->clips[l->clip];
    if (loader_has(l, "velocity_weight") && !key->has_velocity)
        return loader_fail(l, "velocity_weight",
                           "'velocity_weight' makes a 'velocity' soft, and this key has none");
    /* A tick is never shorter than 1/65535 s, and no body follows within a millisecond. */
    if (index > 0 && key->time < key[-1].time + 1e-3 * (1 - 1e-9))
        return loader_fail(l, "time", "key times must ascend by at least 1 ms: %g s follows %g s",
                           key->time, key[-1].time);
    if (clip->duration > 0 && key->time > clip->duration + same_time)
        return loader_fail(l, "time", "a key at %g s lies behind the clip's end at %g s", key->time,
                           clip->duration);
    return check_multi_point(l, a);
}

static int read_key(loader *l, int index)
{
    static const scene_measure soft = {"a weight such as 10", {{NULL, 0}}, 1e-12, 1e15};
    const yaml_body_key *from = &source(l)->keys[index];
    scene_action *a = current(l);
    const scene_body *b = &l->out->bodies[a->body];
    scene_body_key *to = &a->keys[index];
    *to = (scene_body_key){.line = scene_tree_line(l->tree, l->node, NULL),
                           .weight = BAKE_HARD,
                           .velocity_weight = BAKE_HARD,
                           .region = -1};
    if (loader_need(l, "time", from->time, key_example) ||
        loader_number(l, "time", from->time, &scene_time, &to->time) ||
        loader_need(l, "pose", from->pose, key_example) ||
        scene_read_pose_name(l, "pose", from->pose, b->pose_count, &to->pose) ||
        loader_number(l, "weight", from->weight, &soft, &to->weight) ||
        scene_read_velocity(l, to) ||
        loader_number(l, "velocity_weight", from->velocity_weight, &soft, &to->velocity_weight))
        return -1;
    if (b->kind == SCENE_CHAIN && from->region != NULL)
        return loader_fail(l, "region", "the body '%s' is a chain and has no regions", b->name);
    if (scene_read_region_name(l, from->region, 1, &to->region))
        return -1;
    return check_key(l, a, to, index);
}

static int read_keys(loader *l, const yaml_action *from, scene_action *a)
{
    if (from->keys_count < 2 || from->keys_count > ACTION_KEYS_MAX)
        return loader_fail(l, "keys",
                           "a motion takes 2 to %d keys, found %u; write for example:  %s",
                           ACTION_KEYS_MAX, from->keys_count, action_example);
    a->keys = bake_alloc(from->keys_count, sizeof *a->keys);
    a->key_count = (int)from->keys_count;
    return loader_each(l, "keys", read_key);
}

static int same(double a, double b)
{
    return !(a < b || a > b);
}

static int same_velocity(const scene_body_key *a, const scene_body_key *b)
{
    int equal = a->has_velocity == b->has_velocity && a->velocity_count == b->velocity_count &&
                a->rate_count == b->rate_count && same(a->velocity_weight, b->velocity_weight);
    for (int i = 0; equal && i < a->velocity_count; i++) {
        const scene_shift *p = &a->velocity[i], *q = &b->velocity[i];
        equal = p->region == q->region && same(p->angle, q->angle);
        for (int k = 0; equal && k < 3; k++)
            equal = same(p->by[k], q->by[k]) && same(p->axis[k], q->axis[k]);
    }
    for (int i = 0; equal && i < a->rate_count; i++)
        equal = a->rate_link[i] == b->rate_link[i] && same(a->rate[i], b->rate[i]);
    return equal;
}

static int check_periodic(const loader *l, const scene_action *a)
{
    const scene_body_key *first = &a->keys[0], *last = &a->keys[a->key_count - 1];
    if (l->out->clips[l->clip].end != WG_END_LOOP)
        return loader_fail(l, "periodic", "a periodic motion needs a clip that says 'end: loop'");
    if (first->time > 0)
        return loader_fail(l, "keys", "the first key of a periodic motion must be at time 0");
    if (a->key_count < 3)
        return loader_fail(l, "keys",
                           "a periodic motion takes at least 3 keys, the last of which repeats the "
                           "first");
    if (first->pose != last->pose || first->region != last->region ||
        !same(first->weight, last->weight) || !same_velocity(first, last))
        return loader_fail(l, "keys",
                           "the last key of a periodic motion must repeat the first, here  {time: "
                           "%g, pose: %s}",
                           last->time, l->out->bodies[a->body].poses[first->pose].name);
    return 0;
}

/* In an additive clip everything adds, whether it says so or not. */
static int read_add(loader *l, const yaml_action *from, scene_action *a)
{
    const scene_clip *clip = &l->out->clips[l->clip];
    a->add = clip->additive;
    if (loader_flag(l, "add", from->add, &a->add))
        return -1;
    if (clip->additive && !a->add)
        return loader_fail(l, "add", "the clip '%s' is additive, so its motions add; remove 'add'",
                           clip->name);
    return 0;
}

static int read_action(loader *l, int index)
{
    const scene *s = l->out;
    l->action = index;
    const yaml_action *from = source(l);
    scene_action *a = current(l);
    int dynamics = DYNAMICS_ONE_POINT, periodic = 0;
    a->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_need(l, "body", from->body, action_example) ||
        loader_reference(l, "body", from->body, SCENE_NAMES(s->bodies, s->body_count), &a->body) ||
        loader_word(l, "dynamics", from->dynamics, dynamics_words, &dynamics))
        return -1;
    l->body = a->body;
    a->dynamics = (scene_dynamics)dynamics;
    if (check_fields(l, a) || read_add(l, from, a) || read_held(l, from, a) ||
        read_physics(l, from, a) || read_keys(l, from, a) ||
        loader_flag(l, "periodic", from->periodic, &periodic) ||
        scene_read_action_ends(l, periodic, a))
        return -1;
    return periodic ? check_periodic(l, a) : 0;
}

/* Motions of one body that do not add take over from each other. */
static int check_sequence(const loader *l, const scene_clip *clip)
{
    for (int i = 0; i < clip->action_count; i++) {
        const scene_action *a = &clip->actions[i], *before = NULL;
        for (int j = 0; j < i && !a->add; j++)
            if (clip->actions[j].body == a->body && !clip->actions[j].add)
                before = &clip->actions[j];
        if (before == NULL)
            continue;
        const scene_body_key *first = &a->keys[0], *last = &before->keys[before->key_count - 1];
        const scene_body *b = &l->out->bodies[a->body];
        if (fabs(first->time - last->time) > same_time || first->pose != last->pose)
            return bake_fail(
                l->error,
                "%s:%d: this motion of '%s' must begin where the one in line %d ends:  "
                "{time: %g, pose: %s}; motions laid over others have 'add: true'",
                l->tree->path, first->line, b->name, before->line, last->time,
                b->poses[last->pose].name);
    }
    return 0;
}

/* An output follows its body, so no curve of the same clip may move it. */
static int check_outputs(const loader *l, const scene_clip *clip)
{
    for (int i = 0; i < clip->action_count; i++) {
        const scene_body *b = &l->out->bodies[clip->actions[i].body];
        for (int j = 0; j < b->output_count; j++)
            for (int k = 0; k < clip->curve_count; k++)
                if (clip->curves[k].channel == b->outputs[j].channel)
                    return bake_fail(l->error,
                                     "%s:%d: the channel '%s' is an output of the body '%s', which "
                                     "this clip moves in line %d; remove one",
                                     l->tree->path, clip->curves[k].line,
                                     l->out->channels[clip->curves[k].channel].name, b->name,
                                     clip->actions[i].line);
    }
    return 0;
}

int scene_read_actions(loader *l, int clip)
{
    const yaml_clip *from = &l->yaml->clips[clip];
    scene_clip *to = &l->out->clips[clip];
    if (from->bodies_count == 0)
        return 0;
    l->clip = clip;
    to->actions = bake_alloc(from->bodies_count, sizeof *to->actions);
    to->action_count = (int)from->bodies_count;
    return loader_each(l, "bodies", read_action) || check_sequence(l, to) || check_outputs(l, to)
               ? -1
               : 0;
}

int scene_check_actions(const loader *l, const scene_clip *clip, double length)
{
    for (int i = 0; i < clip->action_count; i++) {
        const scene_action *a = &clip->actions[i];
        double last = a->keys[a->key_count - 1].time;
        if (a->end[0] == BAKE_END_PERIODIC && fabs(last - length) > same_time)
            return bake_fail(
                l->error,
                "%s:%d: a periodic motion must last as long as its clip, %g s; its last "
                "key is at %g s",
                l->tree->path, a->line, length, last);
    }
    return 0;
}
