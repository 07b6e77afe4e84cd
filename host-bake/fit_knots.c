/* Curves as cubic Hermite pieces with the curve's own values and slopes, and how to round knots.
 * Source: own. Greedy: each piece is made as long as the tolerance allows.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Share of the tolerance for the shape; the rest is for rounding knots to 16 bits. */
#define SHAPE_SHARE 0.92

void fit_truth(const fit_problem *p, double tick, double *value, double *slope)
{
    double out[4], t = tick / p->rate;
    const bake_segment *last = &p->curve->segment[p->curve->count - 1];
    if (t >
        last->t1 - 1e-9) { /* tick / rate may lie a rounding beyond the end, where slopes are 0 */
        bake_segment_eval(last, last->t1, out);
    } else {
        bake_curve_eval(p->curve, t, out);
    }
    *value = out[0];
    *slope = out[1] / p->rate;
}

void fit_knots_free(fit_knots *k)
{
    free(k->tick);
    free(k->value);
    free(k->slope);
    memset(k, 0, sizeof *k);
}

void fit_knots_add(fit_knots *k, int tick, double value, double slope)
{
    size_t n = (size_t)k->count + 1;
    k->tick = bake_grow(k->tick, n, sizeof *k->tick);
    k->value = bake_grow(k->value, n, sizeof *k->value);
    k->slope = bake_grow(k->slope, n, sizeof *k->slope);
    k->tick[k->count] = tick;
    k->value[k->count] = value;
    k->slope[k->count++] = slope;
}

void fit_hermite(double u, double h, double b[4])
{
    b[0] = (1 + 2 * u) * (1 - u) * (1 - u);
    b[1] = u * (1 - u) * (1 - u) * h;
    b[2] = u * u * (3 - 2 * u);
    b[3] = u * u * (u - 1) * h;
}

/* A knot: value and slope by ticks. */
typedef struct {
    double v, m;
} knot;

static knot true_knot(const fit_problem *p, int tick)
{
    knot k;
    fit_truth(p, tick, &k.v, &k.m);
    return k;
}

/* Places looked at in a piece of h ticks: every tick of short ones, 96 of long ones. */
static int look_count(int h)
{
    return h < 12 ? 24 : h < 48 ? 2 * h : 96;
}

static double piece_error(const fit_problem *p, int first, int last, knot a, knot b)
{
    double worst = 0, h = last - first;
    int n = look_count(last - first);
    for (int i = 0; i <= n; i++) {
        double f[4], value, slope;
        fit_hermite((double)i / n, h, f);
        fit_truth(p, first + h * i / n, &value, &slope);
        worst = fmax(worst, fabs(f[0] * a.v + f[1] * a.m + f[2] * b.v + f[3] * b.m - value));
    }
    return worst;
}

/* The longest piece from `first` within the tolerance: doubling, then halving the step. */
static int longest(const fit_problem *p, int first, int last, knot a)
{
    double limit = SHAPE_SHARE * p->tolerance;
    int good = 0, step = 1;
    while (first + good + step <= last) {
        knot b = true_knot(p, first + good + step);
        if (piece_error(p, first, first + good + step, a, b) > limit) {
            break;
        }
        good += step;
        step *= 2;
    }
    for (; step > 0; step /= 2) {
        int end = first + good + step;
        if (end <= last) {
            good += piece_error(p, first, end, a, true_knot(p, end)) <= limit ? step : 0;
        }
    }
    return good;
}

int fit_knots_find(const fit_problem *p, int first, int last, fit_knots *k, bake_error *error)
{
    knot a = true_knot(p, first);
    memset(k, 0, sizeof *k);
    fit_knots_add(k, first, a.v, a.m);
    while (first < last) {
        int h = longest(p, first, last, a);
        if (h == 0) {
            fit_knots_free(k);
            return bake_fail(
                error,
                "the curve changes within one tick at %.4f s by more than the tolerance %g: "
                "raise the tolerance or the tick_rate (now %d a second)",
                (double)first / p->rate, p->tolerance, p->rate);
        }
        first += h;
        a = true_knot(p, first);
        fit_knots_add(k, first, a.v, a.m);
    }
    return 0;
}

double fit_run_error(const fit_problem *p, const track_run *run)
{
    bake_track lone = {1, (track_run *)run};
    replay r;
    double worst = 0;
    replay_open(&r, &lone);
    for (int k = 0, start = run->start; k < run->segments; start = run->end[k++]) {
        int h = run->end[k] - start, n = 33 + 2 * (h < 1000 ? h : 1000);
        for (int i = 0; i < n; i++) {
            uint32_t position = (uint32_t)(65536.0 * (start + (double)h * i / n));
            double value, slope;
            fit_truth(p, position / 65536.0, &value, &slope);
            worst = fmax(worst, fabs(ldexp(replay_value(&r, position), -p->frac) - value));
        }
    }
    replay_close(&r);
    return worst;
}

/* Smallest shift for values within `reach` of the base; slopes over a whole piece stay below 2^19
 * units, so that the player's sums of them stay below 2^31 (SPEC 6.3: Q10). */
static int value_shift(const fit_problem *p, const fit_knots *k, double reach)
{
    double swing = 0;
    int shift = 0;
    for (int i = 0; i + 1 < k->count; i++) {
        double h = k->tick[i + 1] - k->tick[i];
        swing = fmax(swing, h * fmax(fabs(k->slope[i]), fabs(k->slope[i + 1])));
    }
    swing = ldexp(swing, p->frac);
    while (shift <= (int)WG_RUN_SHIFT_MAX &&
           (ldexp(32766.0, shift) < reach || ldexp(524288.0, shift) < swing)) {
        shift++;
    }
    return shift;
}

/* Base, shift and velocity shift that use the 16 bits of knots fully. */
static int choose_scales(const fit_problem *p, const fit_knots *k, track_run *run)
{
    double lo = HUGE_VAL, hi = -HUGE_VAL, fastest = 0;
    for (int i = 0; i < k->count; i++) {
        lo = fmin(lo, ldexp(k->value[i], p->frac));
        hi = fmax(hi, ldexp(k->value[i], p->frac));
        fastest = fmax(fastest, fabs(ldexp(k->slope[i], p->frac)));
    }
    double base = floor((lo + hi) / 2 + 0.5);
    if (fabs(base) > WG_VALUE_LIMIT) {
        return 0;
    }
    run->base = (int32_t)base;
    run->shift = value_shift(p, k, fmax(hi - base, base - lo));
    run->aux = (int)WG_RUN_VELOCITY_SHIFT_MAX;
    while (run->aux > 0 && fastest * ldexp(1, 2 + run->aux - run->shift) > 32766.0) {
        run->aux--;
    }
    while (fastest * ldexp(1, 2 - run->shift) > 32766.0 && run->shift <= (int)WG_RUN_SHIFT_MAX) {
        run->shift++; /* a steep piece of small range: values are coarser so that velocities fit */
    }
    return run->shift <= (int)WG_RUN_SHIFT_MAX;
}

double fit_knots_run(const fit_problem *p, const fit_knots *k, track_run *run)
{
    memset(run, 0, sizeof *run);
    run->kind = (int)WG_KIND_CUBIC;
    run->start = k->tick[0];
    run->segments = k->count - 1;
    if (!choose_scales(p, k, run)) {
        return HUGE_VAL;
    }
    run->end = bake_alloc((size_t)run->segments, sizeof *run->end);
    run->value = bake_alloc((size_t)k->count * 2, sizeof *run->value);
    for (int i = 0; i < k->count; i++) {
        double v = ldexp(k->value[i], p->frac) - run->base;
        double d = ldexp(k->slope[i], p->frac + 2 + run->aux - run->shift);
        run->value[2 * i] = (int16_t)lround(ldexp(v, -run->shift));
        run->value[2 * i + 1] = (int16_t)lround(d);
        if (i > 0) {
            run->end[i - 1] = (uint16_t)k->tick[i];
        }
    }
    return fit_run_error(p, run);
}
