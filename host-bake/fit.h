/* From an exact curve to the runs of a track, within a tolerance on what the player plays.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_FIT_H
#define BAKE_FIT_H

#include "scene.h"
#include "spline.h"
#include "track.h"

/* What is to be fitted. Times of the curve's knots are multiples of 1/rate. */
typedef struct {
    const bake_curve *curve;
    const bake_mode *mode; /* WIGGLY: the oscillator of the curve, else not looked at */
    scene_curve_kind
        kind;         /* HELD and LINEAR have kinds of their own; CAPTURED has no knots to keep */
    int rate;         /* ticks a second */
    int ticks;        /* of the clip */
    int frac;         /* raw = value 2^frac */
    double tolerance; /* in the channel's unit */
} fit_problem;

/* Runs that tile [0, ticks] with |played - curve| <= tolerance at every quarter tick (of long
 * clips: at 200,000 places, the ones `certify` looks at). Error: the curve is too fast for the tick
 * rate or the tolerance too small. */
int fit_track(const fit_problem *p, bake_track *track, bake_error *error);

/* Largest |played - curve| at those places. */
double fit_track_error(const fit_problem *p, const bake_track *track);

/* ---- between the files of this stage
 * --------------------------------------------------------------- */

/* Tick at which curve segment i begins; i = curve->count: where the last one ends. */
int fit_tick(const fit_problem *p, int i);

/* Value and its derivative by ticks at a tick. */
void fit_truth(const fit_problem *p, double tick, double *value, double *slope);

/* Largest |played - curve| of a lone run, in the channel's unit. */
double fit_run_error(const fit_problem *p, const track_run *run);

/* Cubic Hermite basis at u for a piece of h ticks: of v0, m0 (by ticks), v1, m1. */
void fit_hermite(double u, double h, double b[4]);

/* Knots of cubic Hermite pieces over [first, last] ticks. */
typedef struct {
    int count;
    int *tick;
    double *value, *slope; /* slope by ticks */
} fit_knots;

void fit_knots_free(fit_knots *k);
void fit_knots_add(fit_knots *k, int tick, double value, double slope);

/* Pieces over [first, last] that take the curve's value and slope at their ends, each as long as
 * the tolerance allows. */
int fit_knots_find(const fit_problem *p, int first, int last, fit_knots *k, bake_error *error);

/* Fewer pieces: places, values and slopes chosen together; ends keep their value. -1 when none was
 * found that beats `most` pieces. */
int fit_knots_least(const fit_problem *p, int first, int last, int most, fit_knots *k);

/* Quantises knots to a CUBIC run; returns its error as the player plays it, or HUGE_VAL. */
double fit_knots_run(const fit_problem *p, const fit_knots *k, track_run *run);

/* A wave that the whole curve may be made of: family (OSC, CRIT, EXP), rates and rest of `like`. */
#define FIT_WAVES_MAX 2
typedef struct {
    bake_segment like;
    int longest; /* ticks of the longest segment: decides how sinh is scaled */
} fit_wave;

/* The waves of p->mode, best first; returns how many. */
int fit_wave_candidates(const fit_problem *p, fit_wave waves[FIT_WAVES_MAX]);

/* Bytes of a wave run before its segments. */
int fit_wave_head(const fit_problem *p, const fit_wave *wave);

/* Bit s is set when curve segment k, quantised with run shift s, stays within the tolerance. */
unsigned fit_wave_shifts(const fit_problem *p, const fit_wave *wave, int k);

/* Curve segments first .. first + count - 1 as one run. */
void fit_wave_run(const fit_problem *p, const fit_wave *wave, int first, int count, track_run *run);

/* The cheapest way through the curve: way[k] = run shift of a wave, or FIT_CUBIC. pieces[k]: of
 * segment k as cubics, 0 = impossible; shifts[k] as above. Returns the bytes, or -1. */
#define FIT_CUBIC ((int)WG_RUN_SHIFT_MAX + 1)
long fit_path(const int *pieces, const unsigned *shifts, int count, int wave_head, int *way);

#endif
