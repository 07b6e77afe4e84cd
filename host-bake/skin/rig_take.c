/* Captures on rigs: the baker's side. What the sources say comes from a process of its own.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_take.h"
#include "rig_take_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the size of a quaternion, or of how far a root goes: float32 keys of one pose differ by less.
 */
static const double same_pose = 1e-5;

const scene_take *take_of(const scene *s, const take_track *t)
{
    return &s->clips[t->clip].takes[t->take];
}

static void free_tracks(taking *all)
{
    for (int i = 0; i < all->count; i++) {
        free(all->track[i].time);
        free(all->track[i].value);
        free(all->track[i].kink);
    }
    free(all->track);
}

static void add_track(taking *all, const take_track *track)
{
    all->track = bake_grow(all->track, (size_t)all->count + 1, sizeof *track);
    all->track[all->count++] = *track;
}

/* Bones of the scene have their channels; those of a file get them when something turns them. */
static int turns(const scene_rig *rig, const scene_bone *b)
{
    return b->node != NULL && (b->captured >= 0 || rig->file != NULL);
}

static int travels(const scene_rig *rig, const scene_bone *b)
{
    return turns(rig, b) && (b->travels >= 0 || (b->captured < 0 && b->parent < 0));
}

static int list_take(taking *all, int clip, int take, bake_error *error)
{
    const scene_take *t = &all->s->clips[clip].takes[take];
    const scene_rig *rig = &all->s->rigs[t->rig];
    int before = all->count;
    for (int i = 0; i < rig->bone_count; i++) {
        const scene_bone *b = &rig->bones[i];
        if (turns(rig, b)) {
            add_track(all, &(take_track){.clip = clip, .take = take, .bone = i, .width = 4});
        }
        if (t->travel && travels(rig, b)) {
            add_track(all, &(take_track){.clip = clip, .take = take, .bone = i, .width = 3});
        }
    }
    if (all->count == before) {
        return bake_fail(error,
                         "%s:%d: no bone of the rig '%s' follows a node of a capture; give those "
                         "that shall a 'node'",
                         all->s->path, t->line, rig->name);
    }
    return 0;
}

static int read_here(void *what, isolate_note *now, bake_error *error)
{
    return take_read(what, now, error);
}

static void send(const void *what, FILE *to)
{
    const taking *all = what;
    for (int i = 0; i < all->count; i++) {
        const take_track *t = &all->track[i];
        size_t count = (size_t)t->count;
        fwrite(&t->count, sizeof t->count, 1, to);
        fwrite(t->time, sizeof *t->time, count, to);
        fwrite(t->value, sizeof *t->value, count * (size_t)t->width, to);
        fwrite(t->kink, 1, count, to);
    }
}

/* Finite, ascending from 0, rotations of length 1. */
static int good_track(const take_track *t)
{
    for (int i = 0; i < t->count; i++) {
        const double *v = t->value + (size_t)i * (size_t)t->width;
        double square = 0;
        for (int k = 0; k < t->width; k++) {
            square += v[k] * v[k];
        }
        if (!(i == 0 ? t->time[0] == 0 : t->time[i] > t->time[i - 1]) || !isfinite(t->time[i]) ||
            !(t->width == 4 ? fabs(square - 1) < 1e-9 : square < 1e18)) {
            return 0;
        }
    }
    return 1;
}

static int take(void *what, FILE *from)
{
    taking *all = what;
    for (int i = 0; i < all->count; i++) {
        take_track *t = &all->track[i];
        int count;
        if (fread(&count, sizeof count, 1, from) != 1 || count < 0 || count == 1 ||
            count > TRACK_SAMPLES_MAX) {
            return -1;
        }
        if (count == 0) {
            continue;
        }
        t->time = isolate_get(from, (size_t)count, sizeof *t->time);
        t->value = isolate_get(from, (size_t)count * (size_t)t->width, sizeof *t->value);
        t->kink = isolate_get(from, (size_t)count, 1);
        t->count = count;
        if (t->time == NULL || t->value == NULL || t->kink == NULL || !good_track(t)) {
            return -1;
        }
    }
    return 0;
}

/* Room for a curve at its place: curves ascend by channel. The loader sees to it that none has the
 * channel of a capture. */
static scene_curve *insert_curve(scene_clip *clip, int channel)
{
    int at = 0;
    clip->curves = bake_grow(clip->curves, (size_t)clip->curve_count + 1, sizeof *clip->curves);
    while (at < clip->curve_count && clip->curves[at].channel < channel) {
        at++;
    }
    memmove(clip->curves + at + 1, clip->curves + at,
            (size_t)(clip->curve_count++ - at) * sizeof *clip->curves);
    return &clip->curves[at];
}

/* A capture that ends as it begins, in a clip that loops: a curve without a corner there. */
static int closes(const scene_clip *clip, const take_track *t)
{
    const double *last = t->value + (size_t)(t->count - 1) * (size_t)t->width;
    double apart = 0, size = 0;
    for (int k = 0; k < t->width; k++) {
        apart = fmax(apart, fabs(last[k] - t->value[k]));
        size = fmax(size, fabs(t->value[k]));
    }
    return clip->end == (int)WG_END_LOOP && apart <= same_pose * size &&
           (clip->duration == 0 || fabs(clip->duration - t->time[t->count - 1]) < 1e-6);
}

/* Component k of a track. */
static void add_curve(scene *s, const take_track *t, int channel, int k)
{
    int loops = closes(&s->clips[t->clip], t);
    scene_curve *curve = insert_curve(&s->clips[t->clip], channel + k);
    *curve = (scene_curve){.line = take_of(s, t)->line,
                           .channel = channel + k,
                           .kind = CURVE_SAMPLED,
                           .source = -1,
                           .scale = 1};
    curve->end[0] = curve->end[1] = loops ? BAKE_END_PERIODIC : BAKE_END_ACCELERATION;
    curve->samples = bake_alloc(1, sizeof *curve->samples);
    curve->samples->count = t->count;
    curve->samples->time = bake_alloc((size_t)t->count, sizeof(double));
    curve->samples->value = bake_alloc((size_t)t->count, sizeof(double));
    curve->samples->kink = bake_alloc((size_t)t->count, 1);
    memcpy(curve->samples->time, t->time, (size_t)t->count * sizeof(double));
    memcpy(curve->samples->kink, t->kink, (size_t)t->count);
    for (int i = 0; i < t->count; i++) {
        curve->samples->value[i] = t->value[(loops && i == t->count - 1 ? 0 : i) * t->width + k];
    }
}

/* Whether anything differs from rest: less than this, as a part of a quaternion, turns a bone by
 * less than a tenth of what a channel's default tolerance does. */
static int moves(const take_track *t)
{
    double most = 0;
    for (int i = 0; i < t->count * t->width; i++) {
        most = fmax(most, t->width == 4 && i % 4 == 0 ? 0 : fabs(t->value[i]));
    }
    return most > 1e-5;
}

static int add_channels(scene *s, const scene_rig *rig, scene_bone *b, int travel,
                        bake_error *error)
{
    if (s->channel_count + 4 + 3 * travel > (int)WG_CHANNELS_MAX) {
        return bake_fail(
            error,
            "%s:%d: the captures turn so many bones of '%s' that '%s' is one too many: "
            "a bone takes 4 channels, and a clip has %u; use a file or a capture with "
            "fewer bones, without fingers for example",
            s->path, rig->line, rig->file, b->name, WG_CHANNELS_MAX);
    }
    scene_add_captured(s, rig, b, travel);
    return 0;
}

/* Channels of bones that a file brought along and something turns. */
static int need_channels(scene *s, const taking *all, bake_error *error)
{
    for (int i = 0; i < all->count; i++) {
        const take_track *t = &all->track[i];
        const scene_rig *rig = &s->rigs[take_of(s, t)->rig];
        scene_bone *b = &rig->bones[t->bone];
        if (b->captured >= 0 || !moves(t)) {
            continue;
        }
        int travel = 0;
        for (int k = 0; k < all->count; k++) {
            const take_track *other = &all->track[k];
            travel |= other->width == 3 && other->bone == t->bone &&
                      take_of(s, other)->rig == take_of(s, t)->rig;
        }
        if (add_channels(s, rig, b, travel, error)) {
            return -1;
        }
    }
    return 0;
}

static void add_curves(scene *s, const taking *all)
{
    for (int i = 0; i < all->count; i++) {
        const take_track *t = &all->track[i];
        const scene_bone *b = &s->rigs[take_of(s, t)->rig].bones[t->bone];
        int channel = t->width == 4 ? b->captured : b->travels;
        for (int k = 0; k < t->width && t->count > 0 && channel >= 0; k++) {
            add_curve(s, t, channel, k);
        }
    }
}

int rig_takes(scene *s, bake_error *error)
{
    taking all = {.s = s};
    int err = 0;
    for (int i = 0; i < s->clip_count; i++) {
        for (int k = 0; k < s->clips[i].take_count && err == 0; k++) {
            err = list_take(&all, i, k, error);
        }
    }
    if (err == 0 && all.count > 0) {
        const isolate_job job = {s->path, &all, read_here, send, take};
        err = isolate(&job, error);
    }
    if (err == 0) {
        err = need_channels(s, &all, error);
    }
    if (err == 0) {
        add_curves(s, &all);
    }
    free_tracks(&all);
    return err;
}
