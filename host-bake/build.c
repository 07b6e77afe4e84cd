/* The whole bake, stage after stage.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "build.h"
#include "fit.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Raw units span this many bits of a channel's range, so that a 16-bit knot has 4 bits below it and
 * coefficients of several times the range still fit (DESIGN 6). */
#define RANGE_BITS 20

/* Default tolerance: half a step of a 12-bit servo, or two raw units of values far from 0. */
#define DEFAULT_SHARE (1.0 / 8192)

static void widen(const bake_curve *curve, double *lo, double *hi)
{
    for (int i = 0; i < curve->count; i++) {
        const bake_segment *s = &curve->segment[i];
        for (int j = 0; j <= 64; j++) {
            double out[4];
            bake_segment_eval(s, s->t0 + (s->t1 - s->t0) * j / 64, out);
            *lo = fmin(*lo, out[0]);
            *hi = fmax(*hi, out[0]);
        }
    }
}

/* A channel's range over all clips decides its scale. */
static int scale_channels(build *b, bake_error *error)
{
    const scene *s = b->scene;
    for (int c = 0; c < s->channel_count; c++) {
        double lo = s->channels[c].rest, hi = lo, widest = 0;
        for (int i = 0; i < s->clip_count; i++) {
            double from = HUGE_VAL, to = -HUGE_VAL;
            for (int j = 0; j < s->clips[i].curve_count; j++) {
                if (s->clips[i].curves[j].channel == c) {
                    widen(&b->clip[i].curve[j], &from, &to);
                }
            }
            lo = fmin(lo, from);
            hi = fmax(hi, to);
            widest = fmax(widest, to - from);
        }
        double largest = fmax(fabs(lo), fabs(hi));
        b->range[c] = widest > 0 ? widest : fmax(1e-6, largest);
        int frac = (int)floor(RANGE_BITS - log2(b->range[c]));
        while (frac > -30 && ldexp(largest, frac) > ldexp(1, 27)) {
            frac--;
        }
        b->frac[c] = frac > 30 ? 30 : frac;
        if (!isfinite(largest) || b->frac[c] <= -30) {
            return bake_fail(error, "%s: channel %s reaches %g: values must stay below 1e17",
                             s->path, s->channels[c].name, largest);
        }
        b->tolerance[c] = s->channels[c].tolerance > 0
                              ? s->channels[c].tolerance
                              : fmax(b->range[c] * DEFAULT_SHARE, ldexp(2, -b->frac[c]));
    }
    return 0;
}

static int fit_clip(build *b, int i, bake_error *error)
{
    const scene *s = b->scene;
    for (int j = 0; j < s->clips[i].curve_count; j++) {
        const scene_curve *c = &s->clips[i].curves[j];
        const fit_problem p = {&b->clip[i].curve[j],    &c->mode,         c->kind,
                               b->clip[i].rate,         b->clip[i].ticks, b->frac[c->channel],
                               b->tolerance[c->channel]};
        if (fit_track(&p, &b->track[i][j], error) < 0) {
            bake_error inner = *error;
            return bake_fail(error, "%s:%d: clip %s, channel %s: %s", s->path, c->line,
                             s->clips[i].name, s->channels[c->channel].name, inner.text);
        }
    }
    return 0;
}

static void progress(int verbose, const char *what, int i, int n)
{
    if (verbose && isatty(2)) {
        fprintf(stderr, "\r%-8s %d/%d\033[K%s", what, i, n, i == n ? "\r\033[K" : "");
    }
}

int build_make(const scene *s, int verbose, build *b, bake_error *error)
{
    int err = 0;
    memset(b, 0, sizeof *b);
    b->scene = s;
    b->clip = bake_alloc((size_t)s->clip_count, sizeof *b->clip);
    b->track = bake_alloc((size_t)s->clip_count, sizeof *b->track);
    b->frac = bake_alloc((size_t)s->channel_count, sizeof *b->frac);
    b->tolerance = bake_alloc((size_t)s->channel_count, sizeof *b->tolerance);
    b->range = bake_alloc((size_t)s->channel_count, sizeof *b->range);
    for (int i = 0; i < s->clip_count && err == 0; i++) {
        b->track[i] = bake_alloc((size_t)s->clips[i].curve_count + 1, sizeof **b->track);
        err = author_clip_make(s, i, &b->clip[i], error);
        progress(verbose, "solving", i + 1, s->clip_count);
    }
    if (err == 0) {
        err = scale_channels(b, error);
    }
    for (int i = 0; i < s->clip_count && err == 0; i++) {
        err = fit_clip(b, i, error);
        progress(verbose, "fitting", i + 1, s->clip_count);
    }
    if (err == 0) {
        err = build_pack(b, error);
    }
    if (err < 0) {
        build_free(b);
    }
    return err;
}

void build_free(build *b)
{
    for (int i = 0; b->clip && i < b->scene->clip_count; i++) {
        for (int j = 0; b->track[i] && j < b->scene->clips[i].curve_count; j++) {
            track_free(&b->track[i][j]);
        }
        free(b->track[i]);
        author_clip_free(&b->clip[i]);
    }
    free(b->clip);
    free(b->track);
    free(b->frac);
    free(b->tolerance);
    free(b->range);
    bytes_free(&b->file);
    memset(b, 0, sizeof *b);
}
