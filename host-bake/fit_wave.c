/* Exact pieces of a wiggly spline as integer waves.
 * Source: SPEC 4.4, 6.3; Schulz 2013, 2.5.1 for the families. The rates are rounded first and the
 * coefficients fitted to what is stored, so that the rounding of a rate does not reach the keys.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Below this rate * H a hyperbolic pair is replaced by (1, x): after the coefficients are fitted the two
 * differ by at most (rate H)^2/8 = 2^-15 of the amplitude, and sinh would lose its bits in u - v. */
#define FLAT (1.0 / 64)

/* What the stored integers say: rates by ticks. */
typedef struct {
    int kind;
    double kappa[2]; /* bits a tick of the exponential pairs */
    double turns;    /* turns a tick of the trigonometric pair */
    int sinh_shift[2];
} wave;

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

/* Largest shift that keeps (1 - 2^-(kappa h)) 2^shift below 2, so that u - v shifted fits in 32 bits. */
static int sinh_shift(double kappa, int longest)
{
    double reach = 1 - exp2(-kappa * longest);
    int shift = 0;
    while (shift < (int)WG_RUN_SINH_SHIFT_MAX && reach * exp2(shift + 1) < 1.9) {
        shift++;
    }
    return shift;
}

/* Kind, parameters and shifts for a family with rates a, b [1/s] and segments of up to `longest` ticks. */
static void choose(const fit_problem *p, const bake_segment *s, int longest, track_run *run, wave *w)
{
    double half = 0.5 * longest / p->rate, bits = 1 / (log(2.0) * p->rate);
    int flat_a = s->a * half < FLAT, flat_b = s->b * half < FLAT;
    memset(w, 0, sizeof *w);
    run->param_count = 0;
    run->kind = s->family == BAKE_CRIT ? (int)WG_KIND_CRIT
                : s->family == BAKE_EXP
                    ? (flat_b ? (int)WG_KIND_EXP0 : (int)WG_KIND_EXP)
                    : (flat_a ? (int)WG_KIND_OSC0 : (int)WG_KIND_OSC);
    run->aux = 0;
    if (run->kind != (int)WG_KIND_OSC0) {
        add_param(run, s->a * bits, 16777216.0, s->a);
        w->kappa[0] = run->param[0] / 16777216.0;
        w->sinh_shift[0] = sinh_shift(w->kappa[0], longest);
        run->aux = w->sinh_shift[0];
    }
    if (s->family == BAKE_OSC) {
        add_param(run, s->b / (2 * acos(-1.0) * p->rate), 4294967296.0, s->b);
        w->turns = run->param[run->param_count - 2] / 4294967296.0;
    } else if (run->kind == (int)WG_KIND_EXP) {
        add_param(run, s->b * bits, 16777216.0, s->b);
        w->kappa[1] = run->param[2] / 16777216.0;
        w->sinh_shift[1] = sinh_shift(w->kappa[1], longest);
        run->aux |= w->sinh_shift[1] << 4;
    }
    w->kind = run->kind;
}

static void exp_pair(const wave *w, int which, double dt, double h, double out[2])
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
static void basis(const wave *w, double dt, double h, double out[4])
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
static int sample_count(const wave *w, int h)
{
    int n = 25 + (int)(8 * w->turns * h);
    return n < SAMPLES_MAX ? n : SAMPLES_MAX;
}

/* Least squares for the coefficients from `fixed` on, the earlier ones being rounded already.
 * B: sample_count x 4 basis values, y: what is left to explain. Returns 0 when B has no full rank. */
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

/* Coefficients of curve segment k in raw units: real ones, or (unit > 0) rounded to multiples of it one
 * after the other, each rounding being compensated by those still free. */
static int coefficients(const fit_problem *p, int k, const wave *w, double unit, double c[4])
{
    static double B[SAMPLES_MAX * 4], y[SAMPLES_MAX];
    const bake_segment *s = &p->curve->segment[k];
    int t0 = (int)lround(s->t0 * p->rate), h = (int)lround(s->t1 * p->rate) - t0;
    int n = sample_count(w, h);
    for (int i = 0; i < n; i++) {
        double dt = (double)h * i / (n - 1), out[4];
        bake_segment_eval(s, (t0 + dt) / p->rate, out);
        y[i] = ldexp(out[0] - s->rest, p->frac);
        basis(w, dt, h, &B[4 * i]);
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

/* Smallest shift that lets every coefficient of the run fit in 16 bits, with room for compensation. */
static int common_shift(const fit_problem *p, int first, int count, const wave *w)
{
    double largest = 0;
    for (int k = first; k < first + count; k++) {
        double c[4] = {0};
        if (!coefficients(p, k, w, 0, c)) {
            return -1;
        }
        for (int j = 0; j < 4; j++) {
            largest = fmax(largest, fabs(c[j]));
        }
    }
    for (int shift = 0; shift <= (int)WG_RUN_SHIFT_MAX; shift++) {
        if (largest <= ldexp(32700.0, shift)) {
            return shift;
        }
    }
    return -1;
}

static double segment_error(const fit_problem *p, const replay *r, int k)
{
    const bake_segment *s = &p->curve->segment[k];
    int t0 = (int)lround(s->t0 * p->rate), t1 = (int)lround(s->t1 * p->rate);
    int n = 33 + 2 * (t1 - t0 < 1000 ? t1 - t0 : 1000);
    double worst = 0;
    for (int i = 0; i < n; i++) {
        uint32_t position = (uint32_t)(65536.0 * (t0 + (double)(t1 - t0) * i / n));
        double out[4];
        bake_segment_eval(s, position / 65536.0 / p->rate, out);
        worst = fmax(worst, fabs(ldexp(replay_value(r, position), -p->frac) - out[0]));
    }
    return worst;
}

/* Replays the run segment by segment. */
static double check(const fit_problem *p, int first, int count, track_run *run, int *worst)
{
    bake_track lone = {1, run};
    replay r;
    double largest = 0;
    *worst = -1;
    replay_open(&r, &lone);
    for (int k = first; k < first + count; k++) {
        double e = segment_error(p, &r, k);
        largest = fmax(largest, e);
        if (e > p->tolerance && *worst < 0) {
            *worst = k;
        }
    }
    replay_close(&r);
    return largest;
}

double fit_wave_run(const fit_problem *p, int first, int count, track_run *run, int *worst)
{
    const bake_segment *s = &p->curve->segment[first];
    int longest = 0;
    wave w;
    memset(run, 0, sizeof *run);
    *worst = first;
    for (int k = first; k < first + count; k++) {
        const bake_segment *t = &p->curve->segment[k];
        int h = (int)lround(t->t1 * p->rate) - (int)lround(t->t0 * p->rate);
        longest = h > longest ? h : longest;
    }
    double base = floor(ldexp(s->rest, p->frac) + 0.5);
    if ((s->family != BAKE_OSC && s->family != BAKE_CRIT && s->family != BAKE_EXP) ||
        fabs(base) > WG_VALUE_LIMIT) {
        return HUGE_VAL;
    }
    choose(p, s, longest, run, &w);
    run->shift = common_shift(p, first, count, &w);
    if (run->shift < 0) {
        return HUGE_VAL;
    }
    run->base = (int32_t)base;
    run->start = (int)lround(s->t0 * p->rate);
    run->segments = count;
    run->end = bake_alloc((size_t)count, sizeof *run->end);
    run->value = bake_alloc((size_t)count * 4, sizeof *run->value);
    for (int k = 0; k < count; k++) {
        double unit = ldexp(1, run->shift), c[4] = {0};
        coefficients(p, first + k, &w, unit, c);
        for (int j = 0; j < 4; j++) {
            double q = fmax(-32767, fmin(32767, c[j] / unit));
            run->value[4 * k + j] = (int16_t)lround(q);
        }
        run->end[k] = (uint16_t)lround(p->curve->segment[first + k].t1 * p->rate);
    }
    return check(p, first, count, run, worst);
}
