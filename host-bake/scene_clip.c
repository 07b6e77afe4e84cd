/* Clips of a scene: length, end, events, and what their curves must agree on.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { EVENTS_MAX = 65535, TICKS_MAX = 65535 };

/* Times are written with a few digits, so equal ones differ by rounding only. */
static const double same_time = 1e-9;

/* The index of an event's name, which the first use adds. */
static int event_id(scene *s, const char *name)
{
    scene_names names = SCENE_NAMES(s->event_names, s->event_name_count);
    int id = s->event_name_count > 0 ? scene_names_find(&names, name) : -1;
    if (id >= 0)
        return id;
    id = s->event_name_count++;
    s->event_names = bake_grow(s->event_names, (size_t)s->event_name_count, sizeof(char *));
    s->event_names[id] = bake_copy(name);
    return id;
}

static int read_mark(loader *l, const yaml_mark *from, scene_event *to)
{
    const char *example = "events: [{time: 0.5, name: blink}]";
    scene_names known = SCENE_NAMES(l->out->event_names, l->out->event_name_count);
    char *checked = NULL;
    if (loader_name(l, SCENE_NAMES(from, 1), 0, example, &checked))
        return -1;
    int same = known.count > 0 ? scene_names_find_macro(&known, checked) : -1;
    to->id = event_id(l->out, checked);
    free(checked);
    if (same >= 0 && same != to->id)
        return loader_fail(l, "name",
                           "the events '%s' and '%s' become the same C macro; change one",
                           l->out->event_names[same], l->out->event_names[to->id]);
    to->line = scene_tree_line(l->tree, l->node, "time");
    if (loader_need(l, "time", from->time, example) ||
        loader_number(l, "time", from->time, &scene_time, &to->time))
        return -1;
    return 0;
}

static int by_time(const void *a, const void *b)
{
    double ta = ((const scene_event *)a)->time, tb = ((const scene_event *)b)->time;
    return (ta > tb) - (ta < tb);
}

static int read_events(loader *l, const yaml_clip *from, scene_clip *to)
{
    if (from->events_count == 0)
        return 0;
    if (from->events_count > EVENTS_MAX)
        return loader_fail(l, "events", "a clip holds at most %d events", EVENTS_MAX);
    to->event_count = (int)from->events_count;
    to->events = bake_alloc(from->events_count, sizeof *to->events);
    int clip = l->node;
    l->node = l->tree->nodes[scene_tree_find(l->tree, clip, "events")].child;
    for (int i = 0; i < to->event_count; i++, l->node = l->tree->nodes[l->node].next)
        if (read_mark(l, &from->events[i], &to->events[i]))
            return -1;
    l->node = clip;
    qsort(to->events, (size_t)to->event_count, sizeof *to->events, by_time);
    return 0;
}

static int by_channel(const void *a, const void *b)
{
    return ((const scene_curve *)a)->channel - ((const scene_curve *)b)->channel;
}

static int check_twice(const loader *l, const scene_clip *clip)
{
    for (int i = 1; i < clip->curve_count; i++) {
        const scene_curve *a = &clip->curves[i - 1], *b = &clip->curves[i];
        if (a->channel == b->channel)
            return bake_fail(l->error,
                             "%s:%d: the clip '%s' moves the channel '%s' twice, also in line %d; "
                             "keep one curve",
                             l->tree->path, a->line > b->line ? a->line : b->line, clip->name,
                             l->out->channels[a->channel].name,
                             a->line < b->line ? a->line : b->line);
    }
    return 0;
}

static int read_curves(loader *l, const yaml_clip *from, int index)
{
    scene_clip *to = &l->out->clips[index];
    if (from->curves_count == 0 && from->meshes_count + from->bodies_count + from->rigs_count > 0)
        return 0;
    if (from->curves_count == 0)
        return loader_fail(l, "curves",
                           "the clip '%s' has no curves; write for example:  curves: "
                           "[{channel: jaw, kind: linear, keys: [...]}]",
                           to->name);
    to->curve_count = (int)from->curves_count;
    to->curves = bake_alloc(from->curves_count, sizeof *to->curves);
    int clip = l->node;
    l->node = l->tree->nodes[scene_tree_find(l->tree, clip, "curves")].child;
    for (int i = 0; i < to->curve_count; i++, l->node = l->tree->nodes[l->node].next)
        if (scene_read_curve(l, index, i))
            return -1;
    l->node = clip;
    qsort(to->curves, (size_t)to->curve_count, sizeof *to->curves, by_channel);
    return check_twice(l, to);
}

static double last_time(const scene_curve *curve)
{
    return curve->key_count > 0 ? curve->keys[curve->key_count - 1].time : 0;
}

/* Length of the clip as far as the scene says: captured curves, those of rigs and frames of meshes are
 * not read here. */
static double known_length(const scene_clip *clip, int *captured)
{
    double length = 0;
    *captured = clip->motion_count + clip->take_count > 0;
    for (int i = 0; i < clip->curve_count; i++) {
        *captured |= clip->curves[i].kind == CURVE_CAPTURED;
        length = fmax(length, last_time(&clip->curves[i]));
    }
    for (int i = 0; i < clip->action_count; i++)
        length = fmax(length, clip->actions[i].keys[clip->actions[i].key_count - 1].time);
    return clip->duration > 0 ? clip->duration : length;
}

int scene_check_events(const scene *s, const scene_clip *clip, double length, bake_error *error)
{
    if (clip->event_count == 0)
        return 0;
    const scene_event *last = &clip->events[clip->event_count - 1]; /* they ascend */
    if (last->time <= length + same_time)
        return 0;
    return bake_fail(error, "%s:%d: the event '%s' at %g s lies behind the clip's end at %g s",
                     s->path, last->line, s->event_names[last->id], last->time, length);
}

static int check_length(const loader *l, const scene_clip *clip)
{
    int captured;
    double length = known_length(clip, &captured);
    if (length <= 0 && !captured)
        return loader_fail(l, NULL,
                           "the clip '%s' has no length: its last key is at 0; write for "
                           "example:  duration: 2",
                           clip->name);
    if ((!captured || clip->duration > 0) && scene_check_events(l->out, clip, length, l->error))
        return -1;
    if (l->out->tick_rate * length > TICKS_MAX)
        return loader_fail(l, "duration",
                           "the clip '%s' has %.0f ticks; the format holds %d: lower 'tick_rate'",
                           clip->name, l->out->tick_rate * length, TICKS_MAX);
    if ((!captured || clip->duration > 0) && scene_check_actions(l, clip, length))
        return -1;
    for (int i = 0; i < clip->curve_count; i++) {
        const scene_curve *curve = &clip->curves[i];
        int periodic = curve->end[0] == BAKE_END_PERIODIC;
        if (periodic && (!captured || clip->duration > 0) &&
            fabs(last_time(curve) - length) > same_time)
            return bake_fail(l->error,
                             "%s:%d: a periodic curve must last as long as its clip, %g s; its "
                             "last key is at %g s",
                             l->tree->path, curve->line, length, last_time(curve));
    }
    return 0;
}

int scene_read_clip(loader *l, int index)
{
    static const scene_word ends[] = {
        {"hold", WG_END_HOLD}, {"loop", WG_END_LOOP}, {"pingpong", WG_END_PINGPONG}, {NULL, 0}};
    const yaml_scene *y = l->yaml;
    const yaml_clip *from = &y->clips[index];
    scene_clip *to = &l->out->clips[index];
    to->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_name(l, SCENE_NAMES(y->clips, y->clips_count), index,
                    "- {name: nod, duration: 4, curves: [...]}", &to->name) ||
        loader_number(l, "duration", from->duration, &scene_time, &to->duration) ||
        loader_word(l, "end", from->end, ends, &to->end) ||
        loader_flag(l, "additive", from->additive, &to->additive))
        return -1;
    if (strcmp(to->name, "none") == 0)
        return loader_fail(l, "name", "a clip may not be called 'none', which means no clip");
    if (from->duration != NULL && to->duration <= 0)
        return loader_fail(l, "duration",
                           "'duration' must be above 0; leave it out for the longest curve");
    return read_events(l, from, to) || read_curves(l, from, index) ||
                   scene_read_motions(l, index) || scene_read_actions(l, index) ||
                   scene_read_takes(l, index) || check_length(l, to)
               ? -1
               : 0;
}
