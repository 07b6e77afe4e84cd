/* From an exact curve to the runs of a track.
 * Source: own. A wave costs 10 bytes a segment and is exact; a cubic piece costs 6 and
 * approximates. The cheapest mixture is kept, and what is kept is played and measured before it
 * counts.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int fit_tick(const fit_problem *p, int i)
{
    const bake_curve *c = p->curve;
    double t = i < c->count ? c->segment[i].t0 : c->segment[c->count - 1].t1;
    return (int)lround(t * p->rate);
}

/* A run of HELD or LINEAR knots. Their slopes are not looked at. */
static void plain_run(const fit_problem *p, int kind, const fit_knots *k, track_run *run)
{
    const double *value = k->value;
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    int segments = k->count - 1;
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
    run->start = k->tick[0];
    run->segments = segments;
    run->end = bake_alloc((size_t)segments, sizeof *run->end);
    run->value = bake_alloc((size_t)segments + 1, sizeof *run->value);
    for (int i = 0; i <= segments; i++) {
        double v = ldexp(ldexp(value[i], p->frac) - run->base, -run->shift);
        run->value[i] = (int16_t)lround(fmax(-32767, fmin(32767, v)));
        if (i > 0) {
            run->end[i - 1] = (uint16_t)k->tick[i];
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
    const fit_knots k = {2, tick, value, NULL};
    plain_run(p, (int)WG_KIND_HELD, &k, &run);
    track_append(track, &run);
}

/* HELD and LINEAR keys; the constants before and after them are two more knots. */
static void append_plain(const fit_problem *p, int kind, bake_track *track)
{
    int n = p->curve->count;
    fit_knots k = {0};
    for (int i = -1; i <= n + 1; i++) {
        double out[4];
        const bake_segment *s = &p->curve->segment[i < 0 ? 0 : i < n ? i : n - 1];
        int at = i < 0 ? 0 : i > n ? p->ticks : fit_tick(p, i);
        if (k.count > 0 && at <= k.tick[k.count - 1]) {
            continue;
        }
        bake_segment_eval(s, i < n ? s->t0 : s->t1, out);
        fit_knots_add(&k, at, out[0], 0);
    }
    track_run run;
    plain_run(p, kind, &k, &run);
    track_append(track, &run);
    fit_knots_free(&k);
}

/* Pieces over curve segments first .. last - 1 with their ends as knots: keyed curves keep their
 * keys, because their third derivative jumps there. */
static int find_keyed(const fit_problem *p, int first, int last, fit_knots *all, bake_error *error)
{
    memset(all, 0, sizeof *all);
    for (int i = first; i < last; i++) {
        fit_knots k;
        if (fit_knots_find(p, fit_tick(p, i), fit_tick(p, i + 1), &k, error) < 0) {
            fit_knots_free(all);
            return -1;
        }
        for (int j = i > first; j < k.count; j++) {
            fit_knots_add(all, k.tick[j], k.value[j], k.slope[j]);
        }
        fit_knots_free(&k);
    }
    return 0;
}

/* The curve holds its end values outside: where it begins or ends the clip, a piece that does so
 * costs less than a run, if the curve has come to rest: a slope m dies over h ticks with a bump of
 * 4/27 m h. */
static void add_rests(const fit_problem *p, int first, int last, fit_knots *k)
{
    fit_knots all = {0};
    int n = k->count, before = k->tick[0], after = p->ticks - k->tick[n - 1];
    double most = 0.1 * p->tolerance * 27 / 4;
    if (first == 0 && before > 0 && fabs(k->slope[0]) * before < most) {
        fit_knots_add(&all, 0, k->value[0], 0);
    }
    for (int i = 0; i < n; i++) {
        fit_knots_add(&all, k->tick[i], k->value[i], k->slope[i]);
    }
    if (last == p->curve->count && after > 0 && fabs(k->slope[n - 1]) * after < most) {
        fit_knots_add(&all, p->ticks, k->value[n - 1], 0);
    }
    fit_knots_free(k);
    *k = all;
}

/* Knots first .. last as one run, or as several where one set of scales cannot carry them within
 * the tolerance (a steep stretch beside a long flat one). Returns 0, or the error of a piece that
 * fails. */
static double append_knots(const fit_problem *p, const fit_knots *k, int first, int last,
                           bake_track *track)
{
    const fit_knots part = {last - first + 1, k->tick + first, k->value + first, k->slope + first};
    track_run run;
    double e = fit_knots_run(p, &part, &run);
    if (e <= p->tolerance) {
        track_append(track, &run);
        return 0;
    }
    track_run_free(&run);
    if (last - first < 2) {
        return e;
    }
    int middle = (first + last) / 2;
    e = append_knots(p, k, first, middle, track);
    return e > 0 ? e : append_knots(p, k, middle, last, track);
}

/* The fewest pieces, or nothing. What rounding knots to 16 bits adds is not known before it is
 * done: the shape gets all of the tolerance, then less. */
static int append_least(const fit_problem *p, int first, int last, int most, bake_track *track)
{
    static const double SHARE[] = {0.995, 0.97, 0.85};
    for (int i = 0; i < 3; i++) {
        fit_problem aim = *p;
        fit_knots k;
        track_run run;
        aim.tolerance *= SHARE[i];
        if (fit_knots_least(&aim, fit_tick(p, first), fit_tick(p, last), most, &k) < 0) {
            return -1;
        }
        add_rests(p, first, last, &k);
        double e = fit_knots_run(p, &k, &run);
        fit_knots_free(&k);
        if (e <= p->tolerance) {
            track_append(track, &run);
            return 0;
        }
        track_run_free(&run);
    }
    return -1;
}

/* Cubic runs over curve segments first .. last - 1: the fewest pieces, else pieces between keys. */
static int append_cubic(const fit_problem *p, int first, int last, bake_track *track,
                        bake_error *error)
{
    fit_knots k;
    int from = fit_tick(p, first), captured = p->kind == CURVE_CAPTURED;
    if ((captured ? fit_knots_find(p, from, fit_tick(p, last), &k, error)
                  : find_keyed(p, first, last, &k, error)) < 0) {
        return -1;
    }
    int pieces = k.count - 1, exact = !captured && pieces == last - first;
    int most = exact ? pieces * 3 / 4 : pieces - 1; /* exact curves stay so unless much is saved */
    if (exact && p->kind == CURVE_SAMPLED) {
        most = pieces * 2 / 3; /* knots at the frames share their times: 4 bytes instead of 6 */
    }
    if (most > 0 && append_least(p, first, last, most, track) == 0) {
        fit_knots_free(&k);
        return 0;
    }
    add_rests(p, first, last, &k);
    double e = append_knots(p, &k, 0, k.count - 1, track);
    fit_knots_free(&k);
    double time = p->curve->segment[first].t0;
    return e == 0 ? 0
           : isinf(e)
               ? bake_fail(error,
                           "after %.3f s the curve goes too far within a tick: give it more time, "
                           "or raise the tick_rate (now %d a second)",
                           time, p->rate)
               : bake_fail(
                     error,
                     "16-bit knots reach %.3g after %.3f s but the tolerance is %.3g: raise it", e,
                     time, p->tolerance);
}

/* Waves and cubics along `way`. */
static int append_way(const fit_problem *p, const fit_wave *wave, const int *way, bake_track *track,
                      bake_error *error)
{
    int n = p->curve->count;
    for (int first = 0, last; first < n; first = last) {
        track_run run;
        for (last = first + 1; last < n && way[last] == way[first];) {
            last++;
        }
        if (way[first] == FIT_CUBIC) {
            if (append_cubic(p, first, last, track, error) < 0) {
                return -1;
            }
            continue;
        }
        run.shift = way[first];
        fit_wave_run(p, wave, first, last - first, &run);
        track_append(track, &run);
    }
    return 0;
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

/* The cheapest mixture of cubics and one kind of wave. pieces[k]: of segment k as cubics. */
static int append_mixture(const fit_problem *p, const int *pieces, bake_track *track,
                          bake_error *error)
{
    int n = p->curve->count;
    fit_wave waves[FIT_WAVES_MAX];
    unsigned *shifts = bake_alloc((size_t)n, sizeof *shifts);
    int *way = bake_alloc((size_t)n, sizeof *way), count = fit_wave_candidates(p, waves), err = -1;
    for (int i = 0; i <= count; i++) { /* count: no wave at all */
        for (int k = 0; k < n; k++) {
            shifts[k] = i == count ? 0 : fit_wave_shifts(p, &waves[i], k);
        }
        long cost = fit_path(pieces, shifts, n, i == count ? 0 : fit_wave_head(p, &waves[i]), way);
        bake_track one = {0};
        if (cost < 0 || (err == 0 && cost > 2 * (long)track_bytes(track))) {
            continue; /* free knots save less than half */
        }
        if (append_way(p, &waves[i == count ? 0 : i], way, &one, error) == 0 &&
            (err < 0 || track_bytes(&one) < track_bytes(track))) {
            bake_track other = *track;
            *track = one;
            one = other;
            err = 0;
        }
        track_free(&one);
    }
    free(shifts);
    free(way);
    return err;
}

static int append_wiggly(const fit_problem *p, bake_track *track, bake_error *error)
{
    int n = p->curve->count, err;
    int *pieces = bake_alloc((size_t)n, sizeof *pieces);
    for (int k = 0; k < n; k++) {
        fit_knots knots;
        if (fit_knots_find(p, fit_tick(p, k), fit_tick(p, k + 1), &knots, error) == 0) {
            pieces[k] = knots.count - 1;
            fit_knots_free(&knots);
        }
    }
    err = append_mixture(p, pieces, track, error);
    free(pieces);
    return err;
}

/* Velocities differ by more than rounding where segment i begins. */
#define SMOOTH 1e-6

static int is_kink(const bake_curve *curve, int i)
{
    double before[4], after[4];
    const bake_segment *s = &curve->segment[i];
    bake_segment_eval(s - 1, s->t0, before);
    bake_segment_eval(s, s->t0, after);
    double speed = fabs(before[1]) + fabs(after[1]) + fabs(before[0]) / (s->t1 - s->t0);
    return fabs(before[1] - after[1]) > SMOOTH * speed;
}

/* From one kink to the next a run of its own, because knots share their velocity. */
static int append_smooth(const fit_problem *p, bake_track *track, bake_error *error)
{
    int n = p->curve->count, err = 0;
    for (int first = 0, last; first < n && err == 0; first = last) {
        for (last = first + 1; last < n && !is_kink(p->curve, last);) {
            last++;
        }
        const bake_curve up_to = {last, p->curve->segment}; /* its end has the velocity before */
        fit_problem part = *p;
        part.curve = &up_to;
        part.ticks = last < n ? fit_tick(p, last) : p->ticks;
        err = append_cubic(&part, first, last, track, error);
    }
    return err;
}

static int try_track(const fit_problem *p, bake_track *track, bake_error *error)
{
    int err = 0;
    memset(track, 0, sizeof *track);
    if (p->kind == CURVE_HELD || p->kind == CURVE_LINEAR) {
        append_plain(p, p->kind == CURVE_HELD ? (int)WG_KIND_HELD : (int)WG_KIND_LINEAR, track);
        return 0;
    }
    err = p->kind == CURVE_WIGGLY ? append_wiggly(p, track, error) : append_smooth(p, track, error);
    if (err < 0) {
        track_free(track);
        return -1;
    }
    bake_track whole = {0};
    const track_run *end = &track->run[track->count - 1];
    int last = end->end[end->segments - 1];
    if (track->run[0].start > 0) {
        append_rest(p, 0, track->run[0].start, &whole);
    }
    for (int i = 0; i < track->count; i++) {
        track_append(&whole, &track->run[i]);
    }
    track_free(track);
    *track = whole;
    if (last < p->ticks) {
        append_rest(p, last, p->ticks, track);
    }
    return 0;
}

#define PLACES_MOST 200000

double fit_track_error(const fit_problem *p, const bake_track *track)
{
    int places = 4 * p->ticks < PLACES_MOST ? 4 * p->ticks : PLACES_MOST;
    double worst = 0;
    replay r;
    replay_open(&r, track);
    for (int i = 0; i < places; i++) {
        uint32_t position = (uint32_t)(65536.0 * p->ticks * i / places);
        double value, slope;
        fit_truth(p, position / 65536.0, &value, &slope);
        worst = fmax(worst, fabs(ldexp(replay_value(&r, position), -p->frac) - value));
    }
    replay_close(&r);
    return worst;
}

/* Stages look at fewer places than the certificate does: what slips through is fitted again, aiming
 * a little lower. */
#define ROUNDS 4

int fit_track(const fit_problem *p, bake_track *track, bake_error *error)
{
    fit_problem aim = *p;
    bake_error inner = {""}; /* alternatives that fail leave no message */
    double e = 0;
    for (int round = 0; round < ROUNDS; round++) {
        if (try_track(&aim, track, &inner) < 0) {
            *error = inner;
            return -1;
        }
        e = fit_track_error(p, track);
        if (e <= p->tolerance) {
            return 0;
        }
        track_free(track);
        aim.tolerance *= fmax(0.5, 0.97 * p->tolerance / e);
    }
    return bake_fail(error,
                     "it is missed by %.3g; the tolerance is %.3g: raise it, or the tick_rate", e,
                     p->tolerance);
}
