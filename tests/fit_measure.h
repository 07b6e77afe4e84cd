/* What the fit is asked for and what came of it: ranges, problems as the baker states them, errors
 * as the certificate sees them.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef FIT_MEASURE_H
#define FIT_MEASURE_H

#include "fit.h"

#include <math.h>

#define RATE 1000

typedef struct {
    double range, largest; /* largest minus smallest, largest magnitude */
} extent;

static extent extent_of(const bake_curve *curve)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < curve->count; i++)
        for (int k = 0; k <= 64; k++) {
            double out[4];
            const bake_segment *s = &curve->segment[i];
            bake_segment_eval(s, s->t0 + (s->t1 - s->t0) * k / 64, out);
            low = fmin(low, out[0]);
            high = fmax(high, out[0]);
        }
    return (extent){high - low, fmax(fabs(low), fabs(high))};
}

/* The baker's choices: 20 bits for the range, less for what is far from 0; tolerance 2^-13. */
static fit_problem problem_for(const bake_curve *curve, const bake_mode *mode,
                               scene_curve_kind kind, int ticks)
{
    extent e = extent_of(curve);
    double range = e.range > 0 ? e.range : fmax(1e-6, e.largest);
    int frac = (int)floor(20 - log2(range));
    while (frac > -30 && ldexp(e.largest, frac) > ldexp(1, 27))
        frac--;
    return (fit_problem){.curve = curve,
                         .mode = mode,
                         .kind = kind,
                         .rate = RATE,
                         .ticks = ticks,
                         .frac = frac > 30 ? 30 : frac,
                         .tolerance = range / 8192};
}

/* Largest |played - exact| over ticks [first, last], at each quarter tick of the player's grid. */
static double played_error(const fit_problem *p, const replay *r, int first, int last)
{
    double worst = 0;
    for (int i = 4 * first; i < 4 * last; i++) {
        uint32_t position = (uint32_t)i << 14;
        double value, slope;
        fit_truth(p, i / 4.0, &value, &slope);
        worst = fmax(worst, fabs(ldexp(replay_value(r, position), -p->frac) - value));
    }
    return worst;
}

#endif
