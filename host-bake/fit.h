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
    scene_curve_kind kind; /* HELD and LINEAR have kinds of their own; CAPTURED chooses its knots freely */
    int rate;              /* ticks a second */
    int ticks;             /* of the clip */
    int frac;              /* raw = value 2^frac */
    double tolerance;      /* in the channel's unit */
} fit_problem;

/* Runs that tile [0, ticks] with |played - curve| <= tolerance at every place looked at (at least 4 a
 * segment, 8 an oscillation). Error: the curve is too fast for the tick rate or the tolerance too small. */
int fit_track(const fit_problem *p, bake_track *track, bake_error *error);

/* ---- between the files of this stage --------------------------------------------------------------- */

/* Value and its derivative by ticks at a tick. */
void fit_truth(const fit_problem *p, double tick, double *value, double *slope);

/* Largest |played - curve| of a lone run, in the channel's unit. */
double fit_run_error(const fit_problem *p, const track_run *run);

/* Knots of cubic Hermite pieces over [first, last] ticks. */
typedef struct {
    int count;
    int *tick;
    double *value, *slope; /* slope by ticks */
} fit_knots;

void fit_knots_free(fit_knots *k);

/* Fewest pieces found for which the cubics stay within `tolerance`: interpolating value and slope, or
 * (free = 1) with both chosen by least squares. */
int fit_knots_find(const fit_problem *p, int first, int last, int free_values, fit_knots *k,
                   bake_error *error);

/* Quantises knots to a CUBIC run; returns its error as the player plays it, or HUGE_VAL. */
double fit_knots_run(const fit_problem *p, const fit_knots *k, track_run *run);

/* Quantises curve segments first .. first + count - 1, all of one family, to a wave run; returns its
 * error, or HUGE_VAL if they have no common wave. *worst: the first segment over the tolerance, or -1. */
double fit_wave_run(const fit_problem *p, int first, int count, track_run *run, int *worst);

#endif
