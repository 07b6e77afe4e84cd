/* One curve of a clip: its kind, oscillator, ends, keys or source.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

enum { KEYS_MAX = 65536 };

#define BIT(kind) (1u << (kind))
#define SPLINE    (BIT(CURVE_CUBIC) | BIT(CURVE_WIGGLY))
#define SMOOTH    (SPLINE | BIT(CURVE_BSPLINE))
#define KEYED     (SMOOTH | BIT(CURVE_HELD) | BIT(CURVE_LINEAR))

static const scene_word kinds[] = {{"held", CURVE_HELD},
                                   {"linear", CURVE_LINEAR},
                                   {"cubic", CURVE_CUBIC},
                                   {"bspline", CURVE_BSPLINE},
                                   {"wiggly", CURVE_WIGGLY},
                                   {"captured", CURVE_CAPTURED},
                                   {NULL, 0}};

static const char wiggly_example[] =
    "{channel: jaw, kind: wiggly, frequency: 2, damping: 0.1, keys: [...]}";
static const char key_example[] = "keys: [{time: 0, value: 0}, {time: 0.5, value: 20}]";
static const char captured_example[] =
    "{channel: hip, kind: captured, source: walk, node: LeftUpLeg, axis: x}";

/* A field that the kind ignores would be a surprise, so it is an error. */
static int check_fields(const loader *l, scene_curve_kind kind)
{
    static const struct {
        const char *field;
        unsigned kinds;
    } uses[] = {{"frequency", BIT(CURVE_WIGGLY)},
                {"damping", BIT(CURVE_WIGGLY)},
                {"lambda", BIT(CURVE_WIGGLY)},
                {"delta", BIT(CURVE_WIGGLY)},
                {"force", BIT(CURVE_WIGGLY)},
                {"regularise", SPLINE},
                {"start", SPLINE},
                {"end", SPLINE},
                {"periodic", SMOOTH},
                {"keys", KEYED},
                {"source", BIT(CURVE_CAPTURED)},
                {"node", BIT(CURVE_CAPTURED)},
                {"component", BIT(CURVE_CAPTURED)},
                {"axis", BIT(CURVE_CAPTURED)},
                {"column", BIT(CURVE_CAPTURED)},
                {"scale", BIT(CURVE_CAPTURED)},
                {"offset", BIT(CURVE_CAPTURED)},
                {"from", BIT(CURVE_CAPTURED)},
                {"to", BIT(CURVE_CAPTURED)}};
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++)
        if (loader_has(l, uses[i].field) && (uses[i].kinds & BIT(kind)) == 0)
            return loader_fail(l, uses[i].field, "a curve of kind '%s' has no '%s'",
                               kinds[kind].word, uses[i].field);
    return 0;
}

static int read_mode(const loader *l, const yaml_curve *from, bake_mode *mode)
{
    /* Above 10 the motion is slower than anything a key distance can show. */
    static const scene_measure ratio = {"a damping ratio such as 0.1", {{NULL, 0}}, 0, 10};
    if ((from->frequency != NULL) == (from->lambda != NULL))
        return loader_fail(l, from->lambda ? "lambda" : NULL,
                           "a wiggly curve needs either 'frequency' or 'lambda'%s; write for "
                           "example:  %s",
                           from->lambda ? ", not both" : "", wiggly_example);
    if (loader_number(l, "force", from->force, &scene_plain, &mode->g))
        return -1;
    if (from->lambda != NULL) {
        if (from->damping != NULL)
            return loader_fail(l, "damping",
                               "'damping' goes with 'frequency'; with 'lambda' "
                               "write 'delta' in 1/s");
        return loader_number(l, "lambda", from->lambda, &scene_plain, &mode->lambda) ||
                       loader_number(l, "delta", from->delta, &scene_positive, &mode->delta)
                   ? -1
                   : 0;
    }
    double frequency = 0, damping = 0;
    if (from->delta != NULL)
        return loader_fail(l, "delta",
                           "'delta' goes with 'lambda'; with 'frequency' write "
                           "'damping', 1 = critical");
    if (loader_number(l, "frequency", from->frequency, &scene_frequency, &frequency) ||
        loader_number(l, "damping", from->damping, &ratio, &damping))
        return -1;
    double omega = 2 * PI * frequency;
    mode->lambda = omega * omega;
    mode->delta = damping * omega;
    return 0;
}

static int read_regulariser(const loader *l, const yaml_curve *from, scene_curve *to)
{
    if (from->regularise == NULL)
        return 0;
    if (from->regularise_count != 3)
        return loader_fail(l, "regularise",
                           "'regularise' has %u numbers; write three:  "
                           "regularise: [0, 0, 1e-3]",
                           from->regularise_count);
    for (int i = 0; i < 3; i++)
        if (loader_number(l, "regularise", from->regularise[i], &scene_positive,
                          &to->regularise[i]))
            return -1;
    return 0;
}

static int read_end(loader *l, const char *field, scene_curve *to, int which)
{
    const char *example = "free, {velocity: 0} or {acceleration: 0}";
    int end = scene_tree_find(l->tree, l->node, field);
    if (end < 0)
        return 0;
    if (to->end[0] == BAKE_END_PERIODIC)
        return loader_fail(l, field, "a periodic curve has no '%s'; its ends join", field);
    const scene_node *node = &l->tree->nodes[end];
    if (node->kind == NODE_SCALAR && strcmp(node->value, "free") == 0) {
        to->end[which] = BAKE_END_FREE;
        return 0;
    }
    const scene_node *entry = node->child >= 0 ? &l->tree->nodes[node->child] : NULL;
    if (node->kind != NODE_MAPPING || node->child_count != 1 || entry->kind != NODE_SCALAR)
        return loader_fail(l, field, "'%s' must be %s", field, example);
    int order = strcmp(entry->key, "velocity") == 0       ? 1
                : strcmp(entry->key, "acceleration") == 0 ? 2
                                                          : 0;
    if (order == 0)
        return loader_fail(l, field, "'%s' must be %s, found '%.40s'", field, example, entry->key);
    to->end[which] = order == 1 ? BAKE_END_VELOCITY : BAKE_END_ACCELERATION;
    return loader_number(l, field, entry->value,
                         &scene_value[l->out->channels[to->channel].unit][order],
                         &to->end_value[which]);
}

/* The keys of an additive clip are differences, which the channel's range does not bound. */
static int check_key(const loader *l, const scene_clip *clip, const scene_curve *curve,
                     const bake_key *key)
{
    const scene_channel *channel = &l->out->channels[curve->channel];
    int derivatives = loader_has(l, "velocity") || loader_has(l, "acceleration");
    if ((BIT(curve->kind) & SPLINE) == 0 && (derivatives || loader_has(l, "weight")))
        return loader_fail(l, derivatives ? NULL : "weight",
                           "a key of a '%s' curve has a time and a value only",
                           kinds[curve->kind].word);
    if (!loader_has(l, "value") && !((BIT(curve->kind) & SPLINE) && derivatives))
        return loader_fail(l, NULL,
                           "this key has no 'value'; write for example:  {time: 0.5, "
                           "value: 20}");
    if (!clip->additive && channel->range[0] < channel->range[1] && loader_has(l, "value") &&
        (key->target[0] < channel->range[0] || key->target[0] > channel->range[1]))
        return loader_fail(l, "value", "%g lies outside the range %g .. %g of the channel '%s'",
                           key->target[0], channel->range[0], channel->range[1], channel->name);
    return 0;
}

static int read_key(const loader *l, const yaml_key *from, const scene_clip *clip,
                    const scene_curve *curve, bake_key *to)
{
    static const scene_measure soft = {"a weight such as 3", {{NULL, 0}}, 1e-9, 1e9};
    const scene_measure *value = scene_value[l->out->channels[curve->channel].unit];
    double weight = BAKE_HARD;
    if (loader_need(l, "time", from->time, "{time: 0.5, value: 20}") ||
        loader_number(l, "time", from->time, &scene_time, &to->time) ||
        loader_number(l, "value", from->value, &value[0], &to->target[0]) ||
        loader_number(l, "velocity", from->velocity, &value[1], &to->target[1]) ||
        loader_number(l, "acceleration", from->acceleration, &value[2], &to->target[2]) ||
        loader_number(l, "weight", from->weight, &soft, &weight))
        return -1;
    to->weight[0] = from->value != NULL ? weight : 0;
    to->weight[1] = from->velocity != NULL ? weight : 0;
    to->weight[2] = from->acceleration != NULL ? weight : 0;
    return check_key(l, clip, curve, to);
}

static int read_keys(loader *l, const yaml_curve *from, const scene_clip *clip, scene_curve *to)
{
    static const unsigned least[] = {[CURVE_HELD] = 1,
                                     [CURVE_LINEAR] = 2,
                                     [CURVE_CUBIC] = 2,
                                     [CURVE_BSPLINE] = 4,
                                     [CURVE_WIGGLY] = 2};
    if (from->keys_count < least[to->kind] || from->keys_count > KEYS_MAX)
        return loader_fail(l, "keys",
                           "a '%s' curve takes %u to %d keys, found %u; write for "
                           "example:  %s",
                           kinds[to->kind].word, least[to->kind], KEYS_MAX, from->keys_count,
                           key_example);
    to->key_count = (int)from->keys_count;
    to->keys = bake_alloc(from->keys_count, sizeof *to->keys);
    int curve = l->node;
    l->node = l->tree->nodes[scene_tree_find(l->tree, curve, "keys")].child;
    for (int i = 0; i < to->key_count; i++, l->node = l->tree->nodes[l->node].next) {
        bake_key *key = &to->keys[i];
        if (read_key(l, &from->keys[i], clip, to, key))
            return -1;
        /* A tick is never shorter than 1/65535 s, and no servo follows within a millisecond. */
        if (i > 0 && key->time < key[-1].time + 1e-3 * (1 - 1e-9))
            return loader_fail(l, "time",
                               "key times must ascend by at least 1 ms: %g s follows "
                               "%g s",
                               key->time, key[-1].time);
        if (clip->duration > 0 && key->time > clip->duration + 1e-9)
            return loader_fail(l, "time", "a key at %g s lies behind the clip's end at %g s",
                               key->time, clip->duration);
    }
    l->node = curve;
    return 0;
}

/* What the first or last key prescribes beyond its value decides that end. */
static int apply_end_key(const loader *l, const char *field, scene_curve *curve, int which)
{
    bake_key *key = &curve->keys[which ? curve->key_count - 1 : 0];
    if (key->weight[1] == 0 && key->weight[2] == 0)
        return 0;
    if (loader_has(l, field))
        return loader_fail(l, field, "'%s' and the %s key both say how the curve %s; keep one",
                           field, which ? "last" : "first", which ? "ends" : "starts");
    int order = key->weight[1] == BAKE_HARD ? 1 : key->weight[2] == BAKE_HARD ? 2 : 0;
    curve->end[which] = order == 1   ? BAKE_END_VELOCITY
                        : order == 2 ? BAKE_END_ACCELERATION
                                     : BAKE_END_FREE;
    curve->end_value[which] = order ? key->target[order] : 0;
    if (order)
        key->weight[order] = 0;
    return 0;
}

static int check_periodic(const loader *l, const scene_clip *clip, const scene_curve *curve)
{
    const bake_key *first = &curve->keys[0], *last = &curve->keys[curve->key_count - 1];
    if (clip->end != WG_END_LOOP)
        return loader_fail(l, "periodic", "a periodic curve needs a clip that says 'end: loop'");
    if (first->time > 0)
        return loader_fail(l, "keys", "the first key of a periodic curve must be at time 0");
    if (curve->key_count < 3)
        return loader_fail(l, "keys",
                           "a periodic curve takes at least 3 keys, the last of which "
                           "repeats the first");
    for (int order = 0; order < 3; order++)
        if (first->target[order] != last->target[order] ||
            first->weight[order] != last->weight[order])
            return loader_fail(l, "keys",
                               "the last key of a periodic curve must repeat the first, "
                               "here  {time: %g, value: %g}",
                               last->time, first->target[0]);
    return 0;
}

static int read_keyed(loader *l, const yaml_curve *from, const scene_clip *clip, scene_curve *to)
{
    int periodic = 0;
    if (loader_flag(l, "periodic", from->periodic, &periodic))
        return -1;
    to->end[0] = to->end[1] = periodic ? BAKE_END_PERIODIC : BAKE_END_VELOCITY;
    if (to->kind == CURVE_WIGGLY && read_mode(l, from, &to->mode))
        return -1;
    if (read_regulariser(l, from, to) || read_end(l, "start", to, 0) || read_end(l, "end", to, 1) ||
        read_keys(l, from, clip, to))
        return -1;
    if (periodic)
        return check_periodic(l, clip, to);
    return apply_end_key(l, "start", to, 0) || apply_end_key(l, "end", to, 1) ? -1 : 0;
}

static int read_axis(loader *l, scene_curve *to)
{
    static const scene_word letters[] = {{"x", 0}, {"y", 1}, {"z", 2}, {NULL, 0}};
    static const scene_measure part = {"a number such as 0.7", {{NULL, 0}}, -1e6, 1e6};
    int axis = scene_tree_find(l->tree, l->node, "axis");
    if (axis < 0)
        return loader_fail(l, NULL, "a captured joint needs an 'axis'; write for example:  %s",
                           captured_example);
    const scene_node *node = &l->tree->nodes[axis];
    if (node->kind == NODE_SCALAR) {
        int letter = 0;
        if (loader_word(l, "axis", node->value, letters, &letter))
            return -1;
        to->axis[letter] = 1;
        return 0;
    }
    if (node->kind != NODE_SEQUENCE || node->child_count != 3)
        return loader_fail(l, "axis", "'axis' must be x, y, z or three numbers [0, 0.7, 0.7]");
    int i = 0;
    for (int child = node->child; child >= 0; child = l->tree->nodes[child].next, i++)
        if (l->tree->nodes[child].kind != NODE_SCALAR ||
            loader_number(l, "axis", l->tree->nodes[child].value, &part, &to->axis[i]))
            return l->tree->nodes[child].kind == NODE_SCALAR
                       ? -1
                       : loader_fail(l, "axis", "'axis' must be x, y, z or three numbers");
    double length =
        sqrt(to->axis[0] * to->axis[0] + to->axis[1] * to->axis[1] + to->axis[2] * to->axis[2]);
    if (length < 1e-6)
        return loader_fail(l, "axis", "'axis' has no direction: its numbers are all 0");
    for (i = 0; i < 3; i++)
        to->axis[i] /= length;
    return 0;
}

int scene_is_csv(const char *file)
{
    size_t length = strlen(file);
    return length >= 4 &&
           (strcmp(file + length - 4, ".csv") == 0 || strcmp(file + length - 4, ".CSV") == 0);
}

static int read_place(loader *l, const yaml_curve *from, scene_curve *to)
{
    static const scene_word parts[] = {
        {"rotation", CAPTURE_ROTATION}, {"translation", CAPTURE_TRANSLATION}, {NULL, 0}};
    const char *file = l->out->sources[to->source].file;
    if (scene_is_csv(file)) {
        if (loader_has(l, "node") || loader_has(l, "axis") || loader_has(l, "component"))
            return loader_fail(l, NULL,
                               "a curve from a CSV file has a 'column', no 'node', 'axis' "
                               "or 'component'");
        if (loader_need(l, "column", from->column,
                        "{channel: hip, kind: captured, source: log, column: 2}"))
            return -1;
        to->column = bake_copy(from->column);
        return 0;
    }
    if (loader_has(l, "column"))
        return loader_fail(l, "column", "'column' is for CSV files; '%s' needs 'node' and 'axis'",
                           file);
    int component = CAPTURE_ROTATION;
    if (loader_need(l, "node", from->node, captured_example) ||
        loader_word(l, "component", from->component, parts, &component) || read_axis(l, to))
        return -1;
    to->component = (capture_component)component;
    to->node = bake_copy(from->node);
    return 0;
}

static int read_captured(loader *l, const yaml_curve *from, scene_curve *to)
{
    const scene *s = l->out;
    if (loader_need(l, "source", from->source, captured_example) ||
        loader_reference(l, "source", from->source, SCENE_NAMES(s->sources, s->source_count),
                         &to->source) ||
        read_place(l, from, to) ||
        loader_number(l, "scale", from->scale, &scene_plain, &to->scale) ||
        loader_number(l, "offset", from->offset, &scene_value[s->channels[to->channel].unit][0],
                      &to->offset) ||
        loader_number(l, "from", from->from, &scene_time, &to->from) ||
        loader_number(l, "to", from->to, &scene_time, &to->to))
        return -1;
    if (from->to != NULL && to->to <= to->from)
        return loader_fail(l, "to", "'to' is %g s; it must be after 'from', %g s", to->to,
                           to->from);
    return 0;
}

int scene_read_curve(loader *l, int clip, int index)
{
    const yaml_curve *from = &l->yaml->clips[clip].curves[index];
    scene *s = l->out;
    scene_curve *to = &s->clips[clip].curves[index];
    *to = (scene_curve){.line = scene_tree_line(l->tree, l->node, NULL), .source = -1, .scale = 1};
    int kind = CURVE_LINEAR;
    if (loader_need(l, "channel", from->channel, wiggly_example) ||
        loader_reference(l, "channel", from->channel, SCENE_NAMES(s->channels, s->channel_count),
                         &to->channel) ||
        loader_need(l, "kind", from->kind, wiggly_example) ||
        loader_word(l, "kind", from->kind, kinds, &kind) || check_fields(l, (scene_curve_kind)kind))
        return -1;
    to->kind = (scene_curve_kind)kind;
    return to->kind == CURVE_CAPTURED ? read_captured(l, from, to)
                                      : read_keyed(l, from, &s->clips[clip], to);
}
