/* The whole bake, stage after stage.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "build.h"
#include "fit.h"
#include "shapes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What to say of a channel that nobody wrote. */
static const char *whose(const build *b, int channel)
{
    int made = b->shapes && channel >= b->shapes->channel_first;
    for (int i = 0; made && i < b->shapes->count; i++) {
        const shape_given *g = b->shapes->mesh[i].given;
        if (g && channel >= g->channel && channel < g->channel + g->count) {
            return " (a vibration of a body: lower its `modes`, damp it, give the motion more "
                   "time, "
                   "or raise `tick_rate` or the mesh's tolerance)";
        }
    }
    return made ? " (a mesh's own channel: it follows the mesh's tolerance; of a body that moves "
                  "fast, lower `modes` or give it more time)"
                : "";
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
            return bake_fail(error, "%s:%d: clip %s, channel %s: %.600s%s", s->path, c->line,
                             s->clips[i].name, s->channels[c->channel].name, inner.text,
                             whose(b, c->channel));
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
    return build_make_shapes(s, NULL, verbose, b, error);
}

int build_make_shapes(const scene *s, const struct shapes *sh, int verbose, build *b,
                      bake_error *error)
{
    int err = 0;
    memset(b, 0, sizeof *b);
    b->scene = s;
    b->shapes = sh;
    b->clip = bake_alloc((size_t)s->clip_count, sizeof *b->clip);
    b->track = bake_alloc((size_t)s->clip_count, sizeof *b->track);
    b->frac = bake_alloc((size_t)s->channel_count, sizeof *b->frac);
    b->tolerance = bake_alloc((size_t)s->channel_count, sizeof *b->tolerance);
    b->range = bake_alloc((size_t)s->channel_count, sizeof *b->range);
    b->input = bake_alloc((size_t)s->filter_count + 1, sizeof *b->input);
    for (int i = 0; i < s->clip_count && err == 0; i++) {
        b->track[i] = bake_alloc((size_t)s->clips[i].curve_count + 1, sizeof **b->track);
        err = author_clip_make(s, i, &b->clip[i], error);
        progress(verbose, "solving", i + 1, s->clip_count);
    }
    if (err == 0) {
        err = build_scale(b, error);
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
    free(b->input);
    bytes_free(&b->file);
    memset(b, 0, sizeof *b);
}
