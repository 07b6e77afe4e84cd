/* Exact pieces of a wiggly spline as integer waves.
 * Source: SPEC 4.4, 6.3; Schulz 2013, 2.5.1 for the families. The rates are rounded first and the
 * coefficients fitted to what is stored, so that the rounding of a rate does not reach the keys.
 * The kind follows from the mode alone: the solver's HYP and SERIES segments are in the same space
 * and join the runs of their neighbours where 16 bits carry their coefficients.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Below this rate * H a hyperbolic pair is replaced by (1, x): after the coefficients are fitted
 * the two differ by at most (rate H)^2/8 = 2^-15 of the amplitude, and sinh would lose its bits in
 * u - v. */
#define FLAT (1.0 / 64)

/* Rates a tick that the format's 32 bits hold: below half a turn, below 2^8 bits. */
#define TURN_MOST  3.1
#define DECAY_MOST 170

/* What the stored integers say: rates by ticks. */
typedef struct {
    int kind;
    double kappa[2]; /* bits a tick of the exponential pairs */
    double turns;    /* turns a tick of the trigonometric pair */
    int sinh_shift[2];
} pairs;

static uint32_t stored(double value, double scale)
{
    double x = floor(value * scale + 0.5);
    return x < 0 ? 0 : x > 4294967295.0 ? 4294967295u : (uint32_t)x;
}

static void add_param(track_run *run, double rate, double rate_scale, double per_second)
{
    run->param[run->param_count++] = stored(rate, rate_scale);
    run->param[run->param_count++] = stored(per_second, 65536.0);
}

/* Largest shift that keeps (1 - 2^-(kappa h)) 2^shift below 2, so that u - v shifted fits in 32
 * bits. */
static int sinh_shift(double kappa, int longest)
{
    double reach = 1 - exp2(-kappa * longest);
    int shift = 0;
    while (shift < (int)WG_RUN_SINH_SHIFT_MAX && reach * exp2(shift + 1) < 1.9) {
        shift++;
    }
    return shift;
}

/* A run of the wave without segments: kind, base, parameters, shifts. */
static void choose(const fit_problem *p, const fit_wave *wave, track_run *run, pairs *w)
{
    const bake_segment *s = &wave->like;
    double half = 0.5 * wave->longest / p->rate, bits = 1 / (log(2.0) * p->rate);
    int flat_a = s->a * half < FLAT, flat_b = s->b * half < FLAT;
    memset(w, 0, sizeof *w);
    memset(run, 0, sizeof *run);
    run->base = (int32_t)floor(ldexp(s->rest, p->frac) + 0.5);
    run->kind = s->family == BAKE_CRIT  ? (int)WG_KIND_CRIT
                : s->family == BAKE_EXP ? (flat_b ? (int)WG_KIND_EXP0 : (int)WG_KIND_EXP)
                                        : (flat_a ? (int)WG_KIND_OSC0 : (int)WG_KIND_OSC);
    if (run->kind != (int)WG_KIND_OSC0) {
        add_param(run, s->a * bits, 16777216.0, s->a);
        w->kappa[0] = run->param[0] / 16777216.0;
        w->sinh_shift[0] = sinh_shift(w->kappa[0], wave->longest);
        run->aux = w->sinh_shift[0];
    }
    if (s->family == BAKE_OSC) {
        add_param(run, s->b / (2 * acos(-1.0) * p->rate), 4294967296.0, s->b);
        w->turns = run->param[run->param_count - 2] / 4294967296.0;
    } else if (run->kind == (int)WG_KIND_EXP) {
        add_param(run, s->b * bits, 16777216.0, s->b);
        w->kappa[1] = run->param[2] / 16777216.0;
        w->sinh_shift[1] = sinh_shift(w->kappa[1], wave->longest);
        run->aux |= w->sinh_shift[1] << 4;
    }
    w->kind = run->kind;
}

int fit_wave_head(const fit_problem *p, const fit_wave *wave)
{
    track_run run;
    pairs w;
    choose(p, wave, &run, &w);
    return (int)WG_RUN_BYTES + 4 * run.param_count;
}

/* Beyond this ratio of half gap to rate a critical wave is no stand-in for two rates: it misses by
 * about (gap/rate)^2 / 20 of the amplitude. */
#define NEARLY_CRITICAL 0.3

int fit_wave_candidates(const fit_problem *p, fit_wave waves[FIT_WAVES_MAX])
{
    double lambda = p->mode->lambda, delta = fabs(p->mode->delta);
    double square = delta * delta - lambda, eta = sqrt(fabs(square)), fast = delta + eta;
    bake_segment like = {.family = square < 0 ? BAKE_OSC : BAKE_EXP,
                         .a = square < 0 ? delta : fast,
                         .b = square < 0 ? eta : fabs(lambda) / fast,
                         .rest = lambda == 0 ? 0 : -p->mode->g / lambda};
    int longest = 0, n = 0;
    for (int k = 0; k < p->curve->count; k++) {
        longest = (int)fmax(longest, fit_tick(p, k + 1) - fit_tick(p, k));
    }
    if (fast == 0 || fabs(ldexp(like.rest, p->frac)) > (double)WG_VALUE_LIMIT ||
        like.a > DECAY_MOST * p->rate || like.b > TURN_MOST * p->rate) {
        return 0;
    }
    double wide = square < 0 ? delta : fmax(delta, eta), gap = square < 0 ? eta : fmin(delta, eta);
    if (gap > 1e-7 * wide) {
        waves[n++] = (fit_wave){like, longest};
    }
    if (gap < NEARLY_CRITICAL * wide) {
        like.family = BAKE_CRIT;
        like.a = wide;
        like.b = 0;
        waves[n++] = (fit_wave){like, longest};
    }
    return n;
}

static void exp_pair(const pairs *w, int which, double dt, double h, double out[2])
{
    double v = exp2(-w->kappa[which] * dt), u = exp2(-w->kappa[which] * (h - dt));
    out[0] = (u + v) / 2;
    out[1] = ldexp((u - v) / 2, w->sinh_shift[which]);
}

static void unit_pair(double dt, double h, double out[2])
{
    out[0] = 1;
    out[1] = 2 * dt / h - 1;
}

/* The four functions that multiply c[0..3] (SPEC 6.3, step 4). */
static void basis(const pairs *w, double dt, double h, double out[4])
{
    double a[2], b[2];
    if (w->kind == (int)WG_KIND_OSC0) {
        unit_pair(dt, h, a);
    } else {
        exp_pair(w, 0, dt, h, a);
    }
    if (w->kind <= (int)WG_KIND_OSC0) {
        double phase = 2 * acos(-1.0) * w->turns * (dt - h / 2);
        b[0] = cos(phase);
        b[1] = sin(phase);
    } else if (w->kind == (int)WG_KIND_EXP) {
        exp_pair(w, 1, dt, h, b);
    } else {
        unit_pair(dt, h, b);
    }
    if (w->kind >= (int)WG_KIND_EXP) {
        const double sum[4] = {a[0], a[1], b[0], b[1]};
        memcpy(out, sum, sizeof sum);
    } else {
        const double product[4] = {a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]};
        memcpy(out, product, sizeof product);
    }
}

#define SAMPLES_MAX 2048

/* Samples a segment: enough for its oscillations, ends included. */
static int sample_count(const pairs *w, int h)
{
    int n = 25 + (int)(8 * w->turns * h);
    return n < SAMPLES_MAX ? n : SAMPLES_MAX;
}

/* Least squares for the coefficients from `fixed` on, the earlier ones being rounded already.
 * B: sample_count x 4 basis values, y: what is left to explain. Returns 0 when B has no full rank.
 */
static int solve(const double *B, const double *y, int n, int fixed, double c[4])
{
    static double A[SAMPLES_MAX * 4], r[SAMPLES_MAX];
    double scale[4] = {0};
    int m = 4 - fixed;
    for (int i = 0; i < n; i++) {
        r[i] = y[i];
        for (int j = 0; j < 4; j++) {
            scale[j] = fmax(scale[j], fabs(B[4 * i + j]));
            r[i] -= j < fixed ? c[j] * B[4 * i + j] : 0;
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = fixed; j < 4; j++) {
            A[i * m + j - fixed] = B[4 * i + j] / (scale[j] > 0 ? scale[j] : 1);
        }
    }
    if (LAPACKE_dgels(LAPACK_ROW_MAJOR, 'N', n, m, 1, A, m, r, 1) != 0) {
        return 0;
    }
    for (int j = fixed; j < 4; j++) {
        c[j] = r[j - fixed] / (scale[j] > 0 ? scale[j] : 1);
    }
    return 1;
}

/* Coefficients of curve segment k in raw units: real ones, or (unit > 0) rounded to multiples of it
 * one after the other, each rounding being compensated by those still free. */
static int coefficients(const fit_problem *p, const fit_wave *wave, int k, double unit, double c[4])
{
    static double B[SAMPLES_MAX * 4], y[SAMPLES_MAX];
    const bake_segment *s = &p->curve->segment[k];
    int t0 = fit_tick(p, k), h = fit_tick(p, k + 1) - t0;
    track_run run;
    pairs w;
    choose(p, wave, &run, &w);
    int n = sample_count(&w, h);
    for (int i = 0; i < n; i++) {
        double dt = (double)h * i / (n - 1), out[4];
        bake_segment_eval(s, (t0 + dt) / p->rate, out);
        y[i] = ldexp(out[0], p->frac) - run.base;
        basis(&w, dt, h, &B[4 * i]);
    }
    for (int fixed = 0; fixed < 4; fixed++) {
        if (!solve(B, y, n, fixed, c)) {
            return 0;
        }
        if (unit <= 0) {
            break;
        }
        c[fixed] = floor(c[fixed] / unit + 0.5) * unit;
    }
    return isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]) && isfinite(c[3]);
}

/* Smallest shift that lets the coefficients of a segment fit in 16 bits, with room for
 * compensation. */
static int least_shift(const double c[4])
{
    double largest = fmax(fmax(fabs(c[0]), fabs(c[1])), fmax(fabs(c[2]), fabs(c[3])));
    int shift = 0;
    while (shift <= (int)WG_RUN_SHIFT_MAX && largest > ldexp(32700.0, shift)) {
        shift++;
    }
    return shift;
}

void fit_wave_run(const fit_problem *p, const fit_wave *wave, int first, int count, track_run *run)
{
    pairs w;
    int shift = run->shift;
    choose(p, wave, run, &w);
    run->shift = shift;
    run->start = fit_tick(p, first);
    run->segments = count;
    run->end = bake_alloc((size_t)count, sizeof *run->end);
    run->value = bake_alloc((size_t)count * 4, sizeof *run->value);
    for (int k = 0; k < count; k++) {
        double unit = ldexp(1, shift), c[4] = {0};
        coefficients(p, wave, first + k, unit, c);
        for (int j = 0; j < 4; j++) {
            double q = fmax(-32767, fmin(32767, c[j] / unit));
            run->value[4 * k + j] = (int16_t)lround(q);
        }
        run->end[k] = (uint16_t)fit_tick(p, first + k + 1);
    }
}

unsigned fit_wave_shifts(const fit_problem *p, const fit_wave *wave, int k)
{
    unsigned shifts = 0;
    double c[4] = {0};
    if (!coefficients(p, wave, k, 0, c)) {
        return 0;
    }
    for (int shift = least_shift(c); shift <= (int)WG_RUN_SHIFT_MAX; shift++) {
        track_run run = {.shift = shift};
        fit_wave_run(p, wave, k, 1, &run);
        double e = fit_run_error(p, &run);
        track_run_free(&run);
        if (e > p->tolerance) {
            break; /* a coarser unit would not be better */
        }
        shifts |= 1u << shift;
    }
    return shifts;
}
