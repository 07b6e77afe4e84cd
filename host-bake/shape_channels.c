/* Weights and affine motion of the meshes as channels of the scene, and their samples as curves.
 * Source: own. Between frames a curve is the C2 cubic through its samples, as captured motion is; a
 * basis of one piece is exactly 0 in the others, so that it costs a device nothing there.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_names.h"
#include "shape_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What changes by less than this share of its tolerance does not change. */
#define STILL_SHARE 0.25

/* Knots have 16 bits of a channel's range, and each is rounded. */
#define FINEST (1.0 / 16384)

/* Values of one channel in all frames of a mesh. */
typedef struct {
    const double *value; /* frame f: value[f stride] */
    int stride;
    int piece; /* -1: all */
    double tolerance;
} sampled;

static double at(const sampled *v, int f)
{
    return v->value[(size_t)f * (size_t)v->stride];
}

double shape_frame_time(const mesh_frames *frames, int i)
{
    return frames->time ? frames->time[i] : i / frames->rate;
}

int shape_loops(const scene *s, const mesh_frames *frames)
{
    return s->clips[frames->clip].end == (int)WG_END_LOOP;
}

/* ---- channels --------------------------------------------------------------------------------- */

static int add_channel(scene *s, const char *owner, const char *what, double tolerance)
{
    size_t size = strlen(owner) + strlen(what) + 2, count = (size_t)s->channel_count;
    char *name = bake_alloc(size, 1);
    snprintf(name, size, "%s_%s", owner, what);
    s->channels = bake_grow(s->channels, count + 1, sizeof *s->channels);
    scene_names known = SCENE_NAMES(s->channels, s->channel_count);
    while (count > 0 && scene_names_find_macro(&known, name) >= 0) {
        name = bake_grow(name, ++size, 1);
        strcat(name, "_");
    }
    s->channels[count] = (scene_channel){.name = name, .tolerance = tolerance};
    return s->channel_count++;
}

static scene_curve *add_curve(scene_clip *clip, int channel, int line)
{
    clip->curves = bake_grow(clip->curves, (size_t)clip->curve_count + 1, sizeof *clip->curves);
    scene_curve *c = &clip->curves[clip->curve_count++];
    *c = (scene_curve){.line = line, .channel = channel, .source = -1, .scale = 1};
    return c;
}

/* ---- curves ----------------------------------------------------------------------------------- */

static void held_curve(scene_curve *c, double value, double end)
{
    c->kind = CURVE_HELD;
    c->key_count = 2;
    c->keys = bake_alloc(2, sizeof *c->keys);
    for (int i = 0; i < 2; i++) {
        c->keys[i].time = i * end;
        c->keys[i].target[0] = value;
        c->keys[i].weight[0] = BAKE_HARD;
    }
}

/* Through samples first .. last; at an inner end the curve has come to rest at 0. Where velocities jump, so
 * does the curve's. */
static void spline_curve(scene_curve *c, const mesh_frames *frames, const double *sample,
                         const int span[3])
{
    int first = span[0], last = span[1], end = span[2];
    c->kind = CURVE_SAMPLED;
    c->samples = bake_alloc(1, sizeof *c->samples);
    c->samples->count = last - first + 1;
    c->samples->time = bake_alloc((size_t)c->samples->count, sizeof(double));
    c->samples->value = bake_alloc((size_t)c->samples->count, sizeof(double));
    c->samples->kink = bake_alloc((size_t)c->samples->count, 1);
    for (int i = first; i <= last; i++) {
        c->samples->kink[i - first] = frames->kink && i < frames->count && frames->kink[i];
        c->samples->time[i - first] = shape_frame_time(frames, i);
        c->samples->value[i - first] = sample[i];
    }
    c->end[0] = first > 0 ? BAKE_END_VELOCITY : BAKE_END_ACCELERATION;
    c->end[1] = last < end ? BAKE_END_VELOCITY : BAKE_END_ACCELERATION;
}

/* In a loop, a basis that is at work at both ends and not between them has two stretches: straight
 * lines keep the zeros between them exact. */
static void linear_curve(scene_curve *c, const mesh_frames *frames, const double *sample, int count)
{
    c->kind = CURVE_LINEAR;
    c->keys = bake_alloc((size_t)count, sizeof *c->keys);
    for (int i = 0; i < count; i++) {
        int inside = i > 0 && i + 1 < count && sample[i - 1] == 0 && sample[i + 1] == 0;
        if (!inside || sample[i] != 0) {
            bake_key *k = &c->keys[c->key_count++];
            k->time = shape_frame_time(frames, i);
            k->target[0] = sample[i];
            k->weight[0] = BAKE_HARD;
        }
    }
}

/* count samples, the one behind the last frame included when the clip loops. */
static void moving_curve(scene_curve *c, const mesh_frames *frames, const double *sample,
                         const int counts[2])
{
    int count = counts[0], loops = counts[1], first = 0, last = count - 1;
    while (sample[first] == 0 && first + 1 < count && sample[first + 1] == 0) {
        first++;
    }
    while (sample[last] == 0 && last > 0 && sample[last - 1] == 0) {
        last--;
    }
    int gap = 0;
    for (int i = first + 1; i < last; i++) {
        gap |= sample[i] == 0 && sample[i + 1] == 0;
    }
    if (loops && gap) {
        linear_curve(c, frames, sample, count);
        return;
    }
    const int span[3] = {first, last, count - 1};
    spline_curve(c, frames, sample, span);
    if (loops && first == 0 && last == count - 1) {
        c->end[0] = c->end[1] = BAKE_END_PERIODIC;
    }
}

static int frames_line(const scene_clip *clip, const mesh_frames *frames)
{
    return frames->motion < 0 ? clip->line : clip->motions[frames->motion].line;
}

/* One channel in one motion, whose first frame is `offset`. */
static void motion_curve(scene *s, const shape_mesh *m, const mesh_frames *frames, int offset,
                         const sampled *v, int channel)
{
    scene_clip *clip = &s->clips[frames->clip];
    int loops = shape_loops(s, frames), count = frames->count + loops;
    double *sample = bake_alloc((size_t)count, sizeof *sample), lo = HUGE_VAL, hi = -HUGE_VAL;
    for (int i = 0; i < count; i++) {
        int f = offset + i % frames->count;
        sample[i] = v->piece < 0 || v->piece == m->piece[f] ? at(v, f) : 0;
        lo = fmin(lo, sample[i]);
        hi = fmax(hi, sample[i]);
    }
    scene_curve *c = add_curve(clip, channel, frames_line(clip, frames));
    if (hi - lo <= STILL_SHARE * v->tolerance) {
        double end = shape_frame_time(frames, count > 1 ? count - 1 : 1);
        held_curve(c, lo <= 0 && hi >= 0 ? 0 : (lo + hi) / 2, end);
    } else {
        const int counts[2] = {count, loops};
        moving_curve(c, frames, sample, counts);
    }
    free(sample);
}

/* A channel that the frames move. What is the same in all of them is its rest value and has no
 * curve. */
static int sampled_channel(scene *s, const shape_mesh *m, const char *what, sampled *v)
{
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    for (int f = 0; f < m->frame_count; f++) {
        lo = fmin(lo, at(v, f));
        hi = fmax(hi, at(v, f));
    }
    v->tolerance = fmax(v->tolerance, FINEST * (hi - lo));
    int channel = add_channel(s, s->meshes[m->index].name, what, v->tolerance);
    int still = hi - lo <= STILL_SHARE * v->tolerance;
    s->channels[channel].rest = still ? (lo + hi) / 2 : at(v, 0);
    for (int i = 0, f = 0; i < m->mesh.frames_count && !still; f += m->mesh.frames[i++].count) {
        motion_curve(s, m, &m->mesh.frames[i], f, v, channel);
    }
    return channel;
}

/* ---- tolerances ------------------------------------------------------------------------------- */

/* How much the affine part may stretch what a basis does. */
static double stretch(const shape_mesh *m)
{
    double most = m->turn ? 0 : 1;
    for (int f = 0; m->turn && f < m->frame_count; f++) {
        most = fmax(most, shape_stretch(m->turn[f].A));
    }
    return most;
}

/* How far vertices lie from the affine part's origin along axis k. */
static double extent(const shape_mesh *m, int k)
{
    double most = 0;
    for (int f = 0; f < m->frame_count; f++) {
        for (int i = 0; i < m->mesh.vertex_count; i++) {
            double y[3];
            shape_affine_undo(&m->turn[f], &m->frame[f][3 * i], 1, y);
            most = fmax(most, fabs(y[k] - m->form.origin[k]));
        }
    }
    return most;
}

static void attach_weights(scene *s, shape_mesh *m, double share)
{
    double wide = stretch(m);
    for (int j = 0; j < m->form.basis_count; j++) {
        char what[16];
        shape_basis *b = &m->form.basis[j];
        sampled v = {b->weight, 1, b->piece, share / wide};
        snprintf(what, sizeof what, "%d", j);
        b->channel = sampled_channel(s, m, what, &v);
        if (m->normals.basis_count > 0) {
            m->normals.basis[j].channel = b->channel;
        }
    }
}

static scene_curve *copy_curve(scene_clip *clip, const scene_curve *from, int channel)
{
    scene_curve *c = add_curve(clip, channel, from->line);
    *c = *from;
    c->channel = channel;
    c->keys = bake_alloc((size_t)from->key_count, sizeof *c->keys);
    memcpy(c->keys, from->keys, (size_t)from->key_count * sizeof *c->keys);
    return c;
}

/* The first mesh of a body makes its channels, the others share them. */
static void attach_given(scene *s, shape_mesh *m, double share)
{
    shape_given *g = m->given;
    int first = g->channel < 0 ? s->channel_count : g->channel;
    for (int j = 0, k = 0; j < g->count && g->channel < 0; j++) {
        char what[16];
        snprintf(what, sizeof what, "%d", j);
        int channel = add_channel(s, g->owner, what, share);
        for (; k < g->curve_count && g->curve[k].basis == j; k++) {
            copy_curve(&s->clips[g->curve[k].clip], &g->curve[k].curve, channel);
        }
    }
    g->channel = first;
    for (int j = 0; j < m->form.basis_count; j++) {
        shape_basis *b = &m->form.basis[j];
        b->channel = first + b->given;
        s->channels[b->channel].tolerance = fmin(s->channels[b->channel].tolerance, share);
        if (m->normals.basis_count > 0) {
            m->normals.basis[j].channel = b->channel;
        }
    }
    m->channel_first = first;
    m->channel_count = g->count;
}

/* X = A (y - origin) + (c + A origin): the player's shape has its origin at 0 then (SPEC 6.8). */
static void attach_turns(scene *s, shape_mesh *m, double share)
{
    static const char *const NAME[WG_AFFINE_CHANNELS] = {"xx", "xy", "xz", "yx", "yy", "yz",
                                                         "zx", "zy", "zz", "x",  "y",  "z"};
    enum { PARTS = (int)WG_AFFINE_CHANNELS };
    double *value = bake_alloc((size_t)m->frame_count * PARTS, sizeof *value), far[3];
    for (int f = 0; f < m->frame_count; f++) {
        memcpy(value + PARTS * f, m->turn[f].A, sizeof m->turn[f].A);
        shape_affine_apply(&m->turn[f], m->form.origin, 1, value + PARTS * f + 9);
    }
    for (int k = 0; k < 3; k++) {
        far[k] = extent(m, k);
    }
    m->form.affine = s->channel_count;
    for (int i = 0; i < PARTS; i++) {
        sampled v = {value + i, PARTS, -1, i < 9 ? share / far[i % 3] : share};
        sampled_channel(s, m, NAME[i], &v);
    }
    free(value);
}

/* Without a duration a clip lasts as long as its frames, moved by some curve or not. Frames that it
 * has no time for would be cut off, and a loop would not meet its beginning. */
static int set_lengths(const scene *s, const shape_mesh *m, bake_error *error)
{
    for (int i = 0; i < m->mesh.frames_count; i++) {
        const mesh_frames *f = &m->mesh.frames[i];
        scene_clip *clip = &s->clips[f->clip];
        double end = shape_frame_time(f, f->count - 1 + shape_loops(s, f));
        clip->shown = fmax(clip->shown, f->count > 1 ? end : shape_frame_time(f, 1));
        if (clip->duration > 0 && clip->duration < end - 1e-9) {
            return bake_fail(error,
                             "%s:%d: clip %s lasts %g s, the frames of mesh %s take %g s: leave "
                             "out the duration, or show fewer `frames`",
                             s->path, frames_line(clip, f), clip->name, clip->duration,
                             s->meshes[m->index].name, end);
        }
    }
    return 0;
}

/* Many small errors of either sign do not add up but their squares do: each curve gets the curves'
 * share over the root of their number. The certificate measures what comes of it. */
static int attach(scene *s, shape_mesh *m, bake_error *error)
{
    int parts = (m->given ? m->given->count : m->form.basis_count) +
                (m->turn ? (int)WG_AFFINE_CHANNELS : 0);
    const scene_mesh *from = &s->meshes[m->index];
    double share = m->aim.curves * m->tolerance / sqrt(parts > 0 ? parts : 1);
    m->channel_first = s->channel_count;
    if (m->frame_count == 0) {
        return 0;
    }
    if (set_lengths(s, m, error) < 0) {
        return -1;
    }
    if (s->channel_count + parts > (int)WG_CHANNELS_MAX) {
        return bake_fail(error,
                         "%s:%d: mesh %s takes %d channels, and the scene has %d without them; at "
                         "most %u: raise its tolerance or lower `bases`",
                         s->path, from->line, from->name, parts, s->channel_count, WG_CHANNELS_MAX);
    }
    if (m->given) {
        attach_given(s, m, share);
        return 0;
    }
    attach_weights(s, m, share);
    if (m->turn) {
        attach_turns(s, m, share);
    }
    m->channel_count = s->channel_count - m->channel_first;
    return 0;
}

/* A mesh's weight in a mask counts for all of its channels. */
static void extend_masks(scene *s, const shapes *sh)
{
    for (int i = 0; i < s->mask_count; i++) {
        scene_mask *mask = &s->masks[i];
        mask->weight = bake_grow(mask->weight, (size_t)s->channel_count, sizeof *mask->weight);
        for (int j = 0; j < sh->count; j++) {
            const shape_mesh *m = &sh->mesh[j];
            for (int c = 0; c < m->channel_count; c++) {
                mask->weight[m->channel_first + c] =
                    mask->mesh_weight ? mask->mesh_weight[m->index] : 0;
            }
        }
    }
}

int shapes_attach(scene *s, shapes *sh, bake_error *error)
{
    sh->channel_first = s->channel_count;
    int err = 0;
    for (int i = 0; i < sh->count && err == 0; i++) {
        err = attach(s, &sh->mesh[i], error);
    }
    extend_masks(s, sh);
    if (err < 0) {
        shapes_detach(s, sh);
    }
    return err;
}

/* Curves of made channels are the last of their clip, because these channels are. */
void shapes_detach(scene *s, shapes *sh)
{
    for (int i = 0; i < s->clip_count; i++) {
        scene_clip *clip = &s->clips[i];
        while (clip->curve_count > 0 &&
               clip->curves[clip->curve_count - 1].channel >= sh->channel_first) {
            scene_curve *c = &clip->curves[--clip->curve_count];
            free(c->keys);
            if (c->samples) {
                capture_free(c->samples);
                free(c->samples);
            }
        }
    }
    while (s->channel_count > sh->channel_first) {
        free(s->channels[--s->channel_count].name);
    }
    for (int i = 0; i < sh->count; i++) {
        if (sh->mesh[i].given) {
            sh->mesh[i].given->channel = -1;
        }
    }
}
