/* From the scene to exact curves.
 * Source: Schulz 2013, 2.5 through spline.h; the choice of ticks is ours.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "author.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TICKS_MAX   65535.0
#define SECONDS_MAX 4294.0 /* 2^32 us: the format's, and the device clock's, 71 minutes */

static int on_grid(double time, int rate)
{
    double ticks = time * rate;
    return fabs(ticks - floor(ticks + 0.5)) < 1e-6 * rate;
}

/* Every key, event and the end lie on multiples of 1/rate. */
static int fits(const scene_clip *clip, double duration, int rate)
{
    int good = on_grid(duration, rate);
    for (int i = 0; good && i < clip->curve_count; i++) {
        const scene_curve *c = &clip->curves[i];
        for (int k = 0; good && k < c->key_count; k++) {
            good = on_grid(c->keys[k].time, rate);
        }
        for (int k = 0; good && c->samples && k < c->samples->count; k++) {
            good = on_grid(c->samples->time[k], rate);
        }
    }
    for (int i = 0; good && i < clip->event_count; i++) {
        good = on_grid(clip->events[i].time, rate);
    }
    return good;
}

/* 0 when the clip is too long for a tick a second. */
static int choose_rate(const scene *s, const scene_clip *clip, double duration)
{
    int most = (int)fmin(SCENE_RATE_MAX, floor(TICKS_MAX / duration));
    if (s->tick_rate > 0) {
        return s->tick_rate <= most ? (int)s->tick_rate : 0;
    }
    for (int pass = 0; pass < 2; pass++) {
        for (int rate = pass == 0 && most > 1000 ? 1000 : most; rate >= 1; rate--) {
            if (fits(clip, duration, rate)) {
                return rate;
            }
        }
    }
    return most < 1000 ? most : 1000;
}

/* A C2 cubic through the samples: motion between two frames of a capture is not a corner. */
static int capture_curve(const scene *s, const scene_curve *c, bake_curve *out, bake_error *error)
{
    capture samples = {0};
    if (capture_load(s, c, &samples, error) < 0) {
        return -1;
    }
    bake_key *keys = bake_alloc((size_t)samples.count, sizeof *keys);
    for (int i = 0; i < samples.count; i++) {
        keys[i].time = samples.time[i];
        keys[i].target[0] = samples.value[i];
        keys[i].weight[0] = BAKE_HARD;
    }
    const bake_spline_problem cubic = {.end = {BAKE_END_ACCELERATION, BAKE_END_ACCELERATION}};
    int err = bake_spline_solve(&cubic, keys, samples.count, out, NULL, error);
    free(keys);
    capture_free(&samples);
    if (err < 0) {
        bake_error inner = *error;
        return bake_fail(error, "%s:%d: channel %s: %s", s->path, c->line,
                         s->channels[c->channel].name, inner.text);
    }
    return 0;
}

/* A capture that is longer than its clip ends with the clip: samples behind the first one at or
 * after the end have done their work on the spline and go, and what remains of its piece is the
 * same cubic over less time. `end` [s] is a tick. */
static void cut_capture(bake_curve *curve, double end)
{
    int last = curve->count - 1;
    while (last > 0 && curve->segment[last].t0 >= end - 1e-9) {
        last--;
    }
    curve->count = last + 1;
    bake_segment *s = &curve->segment[last];
    if (s->t1 > end) {
        double half = 0.5 * (end - s->t0), out[4];
        bake_segment_eval(s, s->t0 + half, out);
        const bake_mode none = {0};
        bake_segment_prepare(s, &none, s->t0, end);
        s->w[0] = out[0];
        s->w[1] = out[1] * half;
        s->w[2] = out[2] * half * half / 2;
        s->w[3] = out[3] * half * half * half / 6;
    }
}

/* C2 from one sample where the slope may jump to the next; natural there. */
static int spline_stretches(const scene_curve *c, const bake_key *keys, const char *kink, int count,
                            bake_curve *out, bake_error *error)
{
    int err = 0;
    *out = (bake_curve){0};
    for (int first = 0, last; first < count - 1 && err == 0; first = last) {
        bake_spline_problem p = {.end = {BAKE_END_ACCELERATION, BAKE_END_ACCELERATION}};
        bake_curve stretch;
        for (last = first + 1; last < count - 1 && !kink[last]; last++) {
        }
        if (last - first == count - 1 || c->end[0] != BAKE_END_PERIODIC) {
            p.end[0] = first == 0 ? c->end[0] : BAKE_END_ACCELERATION;
            p.end[1] = last == count - 1 ? c->end[1] : BAKE_END_ACCELERATION;
        }
        err = bake_spline_solve(&p, keys + first, last - first + 1, &stretch, NULL, error);
        if (err == 0) {
            bake_curve_append(out, &stretch);
        }
    }
    return err;
}

/* Through samples that the baker made, on the tick grid as keys are. */
static int sampled_curve(const scene_curve *c, int rate, bake_curve *out, bake_error *error)
{
    bake_key *keys = bake_alloc((size_t)c->samples->count, sizeof *keys);
    char *kink = bake_alloc((size_t)c->samples->count, 1);
    int count = 0;
    for (int i = 0; i < c->samples->count; i++) {
        double time = floor(c->samples->time[i] * rate + 0.5) / rate;
        if (count == 0 || time > keys[count - 1].time) {
            kink[count] = c->samples->kink && c->samples->kink[i];
            keys[count].time = time;
            keys[count].target[0] = c->samples->value[i];
            keys[count++].weight[0] = BAKE_HARD;
        }
    }
    int err = spline_stretches(c, keys, kink, count, out, error);
    free(keys);
    free(kink);
    return err;
}

/* A held curve keeps its last key until the clip ends. */
static int keyed_curve(const scene_curve *c, bake_key *keys, int i, author_clip *a,
                       bake_error *error)
{
    int periodic = c->end[0] == BAKE_END_PERIODIC;
    bake_curve *out = &a->curve[i];
    switch (c->kind) {
    case CURVE_HELD:
        return bake_curve_held(keys, c->key_count, (double)a->ticks / a->rate, out, error);
    case CURVE_LINEAR:
        return bake_curve_linear(keys, c->key_count, out, error);
    case CURVE_BSPLINE:
        return bake_curve_bspline(keys, c->key_count, periodic, out, error);
    default: {
        bake_spline_problem p = {.mode = c->mode};
        memcpy(p.end, c->end, sizeof p.end);
        memcpy(p.end_value, c->end_value, sizeof p.end_value);
        p.alpha = c->regularise[0];
        p.beta = c->regularise[1];
        p.gamma = c->regularise[2];
        return bake_spline_solve(&p, keys, c->key_count, out, &a->report[i], error);
    }
    }
}

/* Key times move to the tick grid before the spline is solved, so that it hits its keys there. */
static int make_curve(const scene *s, const scene_clip *clip, int i, author_clip *a,
                      bake_error *error)
{
    const scene_curve *c = &clip->curves[i];
    if (c->kind == CURVE_CAPTURED) { /* made earlier: the duration depends on it */
        cut_capture(&a->curve[i], (double)a->ticks / a->rate);
        return 0;
    }
    bake_key *keys = bake_alloc((size_t)c->key_count, sizeof *keys);
    int err = 0;
    for (int k = 0; k < c->key_count && err == 0; k++) {
        keys[k] = c->keys[k];
        keys[k].time = floor(c->keys[k].time * a->rate + 0.5) / a->rate;
        if (k > 0 && keys[k].time <= keys[k - 1].time) {
            err = bake_fail(error,
                            "keys %d and %d fall on the same tick of 1/%d s: move one, or set a "
                            "higher tick_rate",
                            k, k + 1, a->rate);
        }
    }
    if (err == 0 && c->kind == CURVE_SAMPLED) {
        err = sampled_curve(c, a->rate, &a->curve[i], error);
        if (err == 0) {
            cut_capture(&a->curve[i], (double)a->ticks / a->rate);
        }
    } else if (err == 0) {
        err = keyed_curve(c, keys, i, a, error);
    }
    free(keys);
    if (err < 0) {
        bake_error inner = *error;
        return bake_fail(error, "%s:%d: channel %s: %s", s->path, c->line,
                         s->channels[c->channel].name, inner.text);
    }
    if (error->text[0]) { /* solved, but near resonance */
        fprintf(stderr, "%s:%d: channel %s: warning: %s\n", s->path, c->line,
                s->channels[c->channel].name, error->text);
        error->text[0] = 0;
    }
    return 0;
}

static double longest(const scene_clip *clip, const author_clip *a)
{
    double end = clip->shown;
    for (int i = 0; i < clip->curve_count; i++) {
        const scene_curve *c = &clip->curves[i];
        if (c->kind == CURVE_CAPTURED) {
            end = fmax(end, a->curve[i].segment[a->curve[i].count - 1].t1);
        } else if (c->kind == CURVE_SAMPLED) {
            end = fmax(end, c->samples->time[c->samples->count - 1]);
        } else {
            end = fmax(end, c->keys[c->key_count - 1].time);
        }
    }
    return end;
}

static int choose_ticks(const scene *s, const scene_clip *clip, author_clip *out, bake_error *error)
{
    double duration = clip->duration > 0 ? clip->duration : longest(clip, out);
    out->rate = duration > 0 && duration < SECONDS_MAX ? choose_rate(s, clip, duration) : 0;
    if (out->rate == 0) {
        return bake_fail(error,
                         "%s:%d: clip %s lasts %g s: a clip has 1 to %g ticks and less than "
                         "%g s, so set a duration or a lower tick_rate, or split it",
                         s->path, clip->line, clip->name, duration, TICKS_MAX, SECONDS_MAX);
    }
    out->ticks = (int)fmax(1, floor(duration * out->rate + 0.5));
    return scene_check_events(s, clip, duration, error);
}

int author_clip_make(const scene *s, int index, author_clip *out, bake_error *error)
{
    const scene_clip *clip = &s->clips[index];
    int err = 0;
    memset(out, 0, sizeof *out);
    out->count = clip->curve_count;
    out->curve = bake_alloc((size_t)clip->curve_count + 1, sizeof *out->curve);
    out->report = bake_alloc((size_t)clip->curve_count + 1, sizeof *out->report);
    for (int i = 0; i < clip->curve_count && err == 0; i++) {
        if (clip->curves[i].kind == CURVE_CAPTURED) {
            err = capture_curve(s, &clip->curves[i], &out->curve[i], error);
        }
    }
    if (err == 0) {
        err = choose_ticks(s, clip, out, error);
    }
    for (int i = 0; i < clip->curve_count && err == 0; i++) {
        err = make_curve(s, clip, i, out, error);
    }
    if (err < 0) {
        author_clip_free(out);
    }
    return err;
}

void author_clip_free(author_clip *c)
{
    for (int i = 0; i < c->count; i++) {
        bake_curve_free(&c->curve[i]);
    }
    free(c->curve);
    free(c->report);
    memset(c, 0, sizeof *c);
}
