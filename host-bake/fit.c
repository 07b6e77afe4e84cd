/* From an exact curve to the runs of a track.
 * Source: own. A wave costs 10 bytes a segment and is exact; a cubic piece costs 6 and approximates. Both
 * ways are built and the smaller one is kept.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int knot_tick(const fit_problem *p, int i)
{
    const bake_curve *c = p->curve;
    double t = i < c->count ? c->segment[i].t0 : c->segment[c->count - 1].t1;
    return (int)lround(t * p->rate);
}

/* A run of HELD or LINEAR knots at the given ticks. */
static void plain_run(const fit_problem *p, int kind, const double *value, const int *tick,
                      int segments, track_run *run)
{
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    memset(run, 0, sizeof *run);
    for (int i = 0; i <= segments; i++) {
        lo = fmin(lo, ldexp(value[i], p->frac));
        hi = fmax(hi, ldexp(value[i], p->frac));
    }
    run->kind = kind;
    run->base = (int32_t)lround((lo + hi) / 2);
    while (ldexp(32766.0, run->shift) < fmax(hi - run->base, run->base - lo) &&
           run->shift < (int)WG_RUN_SHIFT_MAX) {
        run->shift++;
    }
    run->start = tick[0];
    run->segments = segments;
    run->end = bake_alloc((size_t)segments, sizeof *run->end);
    run->value = bake_alloc((size_t)segments + 1, sizeof *run->value);
    for (int i = 0; i <= segments; i++) {
        double v = ldexp(ldexp(value[i], p->frac) - run->base, -run->shift);
        run->value[i] = (int16_t)lround(fmax(-32767, fmin(32767, v)));
        if (i > 0) {
            run->end[i - 1] = (uint16_t)tick[i];
        }
    }
}

/* One constant over [first, last]: what a curve does before it begins and after it ends. */
static void append_rest(const fit_problem *p, int first, int last, bake_track *track)
{
    double value[2], slope;
    int tick[2] = {first, last};
    track_run run;
    fit_truth(p, first, &value[0], &slope);
    value[1] = value[0];
    plain_run(p, (int)WG_KIND_HELD, value, tick, 1, &run);
    track_append(track, &run);
}

static void append_plain(const fit_problem *p, int kind, bake_track *track)
{
    int n = p->curve->count;
    double *value = bake_alloc((size_t)n + 1, sizeof *value);
    int *tick = bake_alloc((size_t)n + 1, sizeof *tick);
    for (int i = 0; i <= n; i++) {
        double out[4];
        const bake_segment *s = &p->curve->segment[i < n ? i : n - 1];
        bake_segment_eval(s, i < n ? s->t0 : s->t1, out);
        value[i] = out[0];
        tick[i] = knot_tick(p, i);
    }
    track_run run;
    plain_run(p, kind, value, tick, n, &run);
    track_append(track, &run);
    free(value);
    free(tick);
}

/* Cubic pieces over curve segments first .. last - 1; keyed curves keep their keys as knots, because
 * their third derivative jumps there. */
static int find_keyed(const fit_problem *p, int first, int last, fit_knots *all, bake_error *error)
{
    memset(all, 0, sizeof *all);
    for (int i = first; i < last; i++) {
        fit_knots k;
        if (fit_knots_find(p, knot_tick(p, i), knot_tick(p, i + 1), 0, &k, error) < 0) {
            fit_knots_free(all);
            return -1;
        }
        int skip = i > first;
        size_t n = (size_t)(all->count + k.count - skip);
        all->tick = bake_grow(all->tick, n, sizeof *all->tick);
        all->value = bake_grow(all->value, n, sizeof *all->value);
        all->slope = bake_grow(all->slope, n, sizeof *all->slope);
        memcpy(all->tick + all->count, k.tick + skip, (size_t)(k.count - skip) * sizeof *k.tick);
        memcpy(all->value + all->count, k.value + skip, (size_t)(k.count - skip) * sizeof *k.value);
        memcpy(all->slope + all->count, k.slope + skip, (size_t)(k.count - skip) * sizeof *k.slope);
        all->count = (int)n;
        fit_knots_free(&k);
    }
    return 0;
}

/* Cubic runs over curve segments first .. last - 1. A range that one set of scales cannot carry within
 * the tolerance is halved. */
static int append_cubic(const fit_problem *p, int first, int last, bake_track *track,
                        bake_error *error)
{
    fit_knots k;
    track_run run;
    int captured = p->kind == CURVE_CAPTURED;
    int err = captured ? fit_knots_find(p, knot_tick(p, first), knot_tick(p, last), 1, &k, error)
                       : find_keyed(p, first, last, &k, error);
    if (err < 0) {
        return -1;
    }
    double e = fit_knots_run(p, &k, &run);
    fit_knots_free(&k);
    if (e <= p->tolerance) {
        track_append(track, &run);
        return 0;
    }
    track_run_free(&run);
    if (last - first < 2) {
        return bake_fail(error,
                         "16-bit knots reach %.3g near %.3f s but the tolerance is %.3g: raise it, or "
                         "split the channel's range",
                         e, p->curve->segment[first].t0, p->tolerance);
    }
    int middle = (first + last) / 2;
    return append_cubic(p, first, middle, track, error) < 0
               ? -1
               : append_cubic(p, middle, last, track, error);
}

static int same_wave(const bake_segment *a, const bake_segment *b)
{
    return a->family == b->family && a->a == b->a && a->b == b->b && a->rest == b->rest;
}

/* Waves wherever one stays within the tolerance, cubics between them. */
static int append_waves(const fit_problem *p, bake_track *track, bake_error *error)
{
    int n = p->curve->count, first = 0, cubic_from = 0;
    while (first < n) {
        int count = 1, worst;
        while (first + count < n &&
               same_wave(&p->curve->segment[first], &p->curve->segment[first + count])) {
            count++;
        }
        track_run run;
        double e = fit_wave_run(p, first, count, &run, &worst);
        while (e > p->tolerance && worst > first) { /* shrinks each time: at most count rounds */
            track_run_free(&run);
            count = worst - first;
            e = fit_wave_run(p, first, count, &run, &worst);
        }
        if (e > p->tolerance) {
            track_run_free(&run);
            first++;
            continue;
        }
        if (cubic_from < first && append_cubic(p, cubic_from, first, track, error) < 0) {
            track_run_free(&run);
            return -1;
        }
        track_append(track, &run);
        first += count;
        cubic_from = first;
    }
    return cubic_from < n ? append_cubic(p, cubic_from, n, track, error) : 0;
}

static size_t track_bytes(const bake_track *track)
{
    bytes runs = {0}, data = {0};
    for (int i = 0; i < track->count; i++) {
        track_put_run(&track->run[i], &runs, &data);
    }
    size_t total = runs.count + data.count;
    bytes_free(&runs);
    bytes_free(&data);
    return total;
}

/* Both ways for a curve with waves in it; cubics alone for the others. */
static int append_smooth(const fit_problem *p, bake_track *track, bake_error *error)
{
    bake_track cubic = {0}, waves = {0};
    int cubic_err = append_cubic(p, 0, p->curve->count, &cubic, error);
    int wave_err = p->kind == CURVE_WIGGLY ? append_waves(p, &waves, error) : -1;
    if (cubic_err < 0 && wave_err < 0) {
        track_free(&cubic);
        track_free(&waves);
        return -1;
    }
    int take_waves = cubic_err < 0 || (wave_err == 0 && track_bytes(&waves) <= track_bytes(&cubic));
    bake_track *best = take_waves ? &waves : &cubic;
    for (int i = 0; i < best->count; i++) {
        track_append(track, &best->run[i]);
    }
    track_free(&cubic);
    track_free(&waves);
    return 0;
}

int fit_track(const fit_problem *p, bake_track *track, bake_error *error)
{
    int first = knot_tick(p, 0), last = knot_tick(p, p->curve->count);
    memset(track, 0, sizeof *track);
    if (first > 0) {
        append_rest(p, 0, first, track);
    }
    if (p->kind == CURVE_HELD || p->kind == CURVE_LINEAR) {
        append_plain(p, p->kind == CURVE_HELD ? (int)WG_KIND_HELD : (int)WG_KIND_LINEAR, track);
    } else if (append_smooth(p, track, error) < 0) {
        track_free(track);
        return -1;
    }
    if (last < p->ticks) {
        append_rest(p, last, p->ticks, track);
    }
    return 0;
}
