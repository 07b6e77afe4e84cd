/* What bodies do, as frames of meshes.
 * Source: own. The frames are what the certificate compares with, and what bases are found in when
 * the motion is not that of one linear model.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Apart at most and at least, and of the tolerance: what the curve between frames may miss. */
#define STEP_MOST  0.016
#define STEP_LEAST 0.002
#define BETWEEN    0.05

/* Frames of one clip: 1.6 GB of doubles, as mesh_read.h has it. */
#define PLACES_MAX 67108864.0

void body_surface_shift(const body_work *w, const body_target *target, const double *u, double *at)
{
    for (int i = 0; i < 3 * target->m->mesh.vertex_count; i++) {
        at[i] = target->at ? 0 : u[i]; /* its own mesh: the body's first vertices */
        for (int k = 0; k < 4 && target->at; k++) {
            const embedding *e = &target->at[i / 3];
            at[i] += e->weight[k] * u[3 * e->vertex[k] + i % 3];
        }
        at[i] /= w->from->unit;
    }
}

void body_surface(const body_work *w, const body_target *target, const double *x, double *at)
{
    if (is_chain(w)) {
        chain_draw(w, x, at);
        return;
    }
    body_surface_shift(w, target, x, at);
    for (int i = 0; i < 3 * target->m->mesh.vertex_count && target->apart; i++) {
        at[i] += target->apart[i];
    }
}

/* A body's tolerance for what is seen of it: the least of its meshes'. */
double body_tolerance(const body_work *w)
{
    double least = HUGE_VAL;
    for (int i = 0; i < w->target_count; i++) {
        const mesh *m = &w->target[i].m->mesh;
        double square = 0, given = w->s->meshes[w->target[i].m->index].tolerance;
        for (int k = 0; k < 3; k++) {
            double lo = HUGE_VAL, hi = -HUGE_VAL;
            for (int v = k; v < 3 * m->vertex_count; v += 3) {
                lo = fmin(lo, m->rest[v]);
                hi = fmax(hi, m->rest[v]);
            }
            square += (hi - lo) * (hi - lo);
        }
        least = fmin(least, given > 0 ? given : sqrt(square) / 500);
    }
    return least;
}

/* ---- how far apart ---------------------------------------------------------------------------- */

/* What the C2 spline through all frames misses in the middle between two: 1/384 h^4 f^(4). The cubic
 * through the four nearest misses 3/128 h^4 f^(4) there, which is 9 times that, and can be measured. */
static double between(const body_work *w, const body_target *target, const body_clip *c,
                      double step)
{
    size_t rows = 3 * (size_t)target->m->mesh.vertex_count;
    double *x = bake_alloc((size_t)w->n, sizeof *x), *at[5], worst = 0;
    static const double PLACE[5] = {-1.5, -0.5, 0, 0.5, 1.5};
    for (int i = 0; i < 5; i++) {
        at[i] = bake_alloc(rows, sizeof **at);
    }
    for (double t = 1.5 * step; t < c->to - 1.5 * step; t += 1.5 * step) {
        int apart = 0;
        for (int i = 0; i < c->count; i++) {
            apart |=
                fabs(c->run[i].m.from - t) < 1.6 * step || fabs(c->run[i].m.to - t) < 1.6 * step;
        }
        for (int i = 0; i < 5 && !apart; i++) {
            body_clip_eval(w, c, t + PLACE[i] * step, x);
            body_surface(w, target, x, at[i]);
        }
        for (size_t i = 0; i < rows && !apart; i++) {
            double cubic = (9 * (at[1][i] + at[3][i]) - at[0][i] - at[4][i]) / 16;
            worst = fmax(worst, fabs(cubic - at[2][i]));
        }
    }
    for (int i = 0; i < 5; i++) {
        free(at[i]);
    }
    free(x);
    return worst / 9;
}

/* Nothing else would say so: the certificate compares with the frames. */
static void warn_fast(const body_work *w, const body_clip *c, double step, double off)
{
    fprintf(stderr,
            "%s:%d: body %s: warning: clip %s: it swings faster than frames %.3g s apart can show: "
            "between them it is off by about %.3g, the tolerance is %.3g; give it less stiffness, "
            "fewer modes, more damping, or more time between poses\n",
            w->s->path, c->run[0].from->line, w->from->name, w->s->clips[c->clip].name, step, off,
            body_tolerance(w));
}

/* For all clips; bases need no more frames than before it was halved. */
static double choose_step(const body_work *w, const body_clip *clips, int count)
{
    double step = STEP_MOST, tolerance = body_tolerance(w), off;
    for (int i = 0; i < count; i++) {
        double tick = clips[i].count > 0 ? 1 / clips[i].rate : 0, now = fmax(step, tick);
        if (clips[i].count == 0 || clips[i].adds) {
            continue;
        }
        while ((off = between(w, &w->target[0], &clips[i], now)) > BETWEEN * tolerance &&
               step > fmax(STEP_LEAST, tick)) {
            step /= 2;
            now = fmax(step, tick);
            for (int k = 0; k < w->target_count; k++) {
                w->target[k].m->finer++;
            }
        }
        if (off > tolerance) {
            warn_fast(w, &clips[i], now, off);
        }
    }
    return step;
}

/* ---- frames ----------------------------------------------------------------------------------- */

static mesh_frames *add_frames(mesh *m, int clip, const body_times *times)
{
    size_t count = (size_t)times->count;
    m->frames = bake_grow(m->frames, (size_t)m->frames_count + 1, sizeof *m->frames);
    mesh_frames *f = &m->frames[m->frames_count++];
    *f = (mesh_frames){.clip = clip, .motion = -1, .count = times->count, .rate = 1};
    f->time = bake_alloc(count + 1, sizeof *f->time);
    f->kink = bake_alloc(count + 1, 1);
    f->at = bake_alloc(3 * (size_t)m->vertex_count * count, sizeof *f->at);
    memcpy(f->time, times->time, (count + 1) * sizeof *f->time);
    memcpy(f->kink, times->kink, count);
    return f;
}

static int show_clip(const body_work *w, const body_clip *c, double step, int kinks,
                     bake_error *error)
{
    body_times times;
    double *x = bake_alloc((size_t)w->n, sizeof *x);
    int err = 0;
    body_clip_times(c, step, kinks, &times);
    for (int i = 0; i < w->target_count && err == 0; i++) {
        mesh *m = &w->target[i].m->mesh;
        if ((double)times.count * m->vertex_count > PLACES_MAX) {
            err = body_fail(w, c->run[0].from->line, error,
                            "%d frames of %d vertices are too many: shorten the clip, or raise the "
                            "mesh's tolerance",
                            times.count, m->vertex_count);
            break;
        }
        mesh_frames *f = add_frames(m, c->clip, &times);
        for (int k = 0; k < times.count; k++) {
            body_clip_eval(w, c, times.time[k], x);
            body_surface(w, &w->target[i], x, f->at + (size_t)k * 3 * (size_t)m->vertex_count);
        }
    }
    free(x);
    body_times_free(&times);
    return err;
}

int body_show(body_work *w, const body_clip *clips, int count, double step, bake_error *error)
{
    int err = 0, kinks = step <= 0;
    body_progress(w, "frames");
    if (step <= 0 && w->target_count > 0) {
        step = choose_step(w, clips, count);
    }
    for (int i = 0; i < count && err == 0 && w->target_count > 0; i++) {
        if (clips[i].count > 0 && !clips[i].adds) {
            err = show_clip(w, &clips[i], step, kinks, error);
        }
    }
    for (int i = 0; i < w->target_count && err == 0; i++) {
        if (w->target[i].m->mesh.frames_count == 0) {
            err = body_fail(w, w->from->line, error,
                            "it moves in additive clips alone, or in none: a mesh needs one clip "
                            "that is not additive");
        }
    }
    return err;
}
