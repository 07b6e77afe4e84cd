/* Every solve is measured before it is believed: residual, energy, overshoot, resonance.
 * Source: Schulz 2013, 2.5.2 (figure 2.6); thresholds are ours.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_parts.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

/* Backward error of the reduced systems is a few units of 1e-16; 1e-10 means the solve went wrong.
 */
#define RESIDUAL_LIMIT    1e-10
/* A curve ten times wider than its keys is hardly ever wanted; the caller is told, not stopped. */
#define OVERSHOOT_WARNING 10.0
/* Digits lost are -log10(condition): below this fewer than 6 remain, and the amplitude exceeds the
 * keys about 3e5 times. */
#define CONDITION_LIMIT   1e-11

int bake_resonant_segment(const bake_work *work)
{
    const bake_mode *mode = &work->problem->mode;
    double square = mode->lambda - mode->delta * mode->delta, nearest = 0.25;
    int found = -1;
    for (int k = 0; square > 0.0 && k < work->key_count - 1; k++) {
        double turns = sqrt(square) * (work->keys[k + 1].time - work->keys[k].time) / PI;
        double distance = fabs(turns - round(turns));
        if (turns > 0.5 && distance < nearest) {
            nearest = distance;
            found = k;
        }
    }
    return found;
}

int bake_fail_resonant(const bake_work *work, const char *what, bake_error *error)
{
    int k = bake_resonant_segment(work);
    const bake_mode *mode = &work->problem->mode;
    if (k < 0)
        return bake_fail(error,
                         "%s; prescribe more (keys, end velocities) or regularise (alpha, beta or "
                         "gamma > 0)",
                         what);
    double t0 = work->keys[k].time, t1 = work->keys[k + 1].time;
    double half = PI / sqrt(mode->lambda - mode->delta * mode->delta);
    return bake_fail(
        error,
        "%s: resonance between the keys at %.6g s and %.6g s, whose distance is %.5f "
        "half periods (%.6g s) of this mode, so that a large oscillation fits the keys; "
        "regularise (alpha, beta or gamma > 0), prescribe the end velocities, or change "
        "the frequency or the damping",
        what, t0, t1, (t1 - t0) / half, half);
}

/* Value, velocity, acceleration at both ends of a segment, and the terms they are summed from. */
typedef struct {
    double at[2][3], size[3];
} end_states;

static void find_end_states(const bake_part *part, const bake_segment *segment, end_states *ends)
{
    double unit = 1.0;
    for (int i = 0; i < 3; i++, unit /= part->H) {
        double sums[2] = {part->part[i], 0.0}, size = fabs(part->part[i]);
        for (int parity = 0; parity < 2; parity++)
            for (int which = 0; which < 2; which++) {
                int j = bake_family_index(segment->family, parity, which);
                double term = part->end[i][j] * segment->w[j];
                sums[parity] += term;
                size += fabs(term);
            }
        /* an even function has an odd derivative */
        double same = unit * sums[i & 1], opposite = unit * sums[1 - (i & 1)];
        ends->at[0][i] = same - opposite;
        ends->at[1][i] = same + opposite;
        ends->size[i] = unit * size;
    }
}

static void widen(double *worst, double violation, double size)
{
    if (!(violation <= *worst * size) && !isnan(*worst)) /* a NaN stays */
        *worst = violation / size;
}

/* Hard targets of key k against one side's state. */
static void check_key(const bake_work *work, int k, const double state[3], const double size[3],
                      double *worst)
{
    const bake_key *key = &work->keys[k];
    const bake_spline_problem *p = work->problem;
    for (int i = 0; i < 3; i++)
        if (key->weight[i] < 0.0)
            widen(worst, fabs(state[i] - key->target[i]), size[i]);
    if (k != 0 && k != work->key_count - 1)
        return;
    int end = k != 0;
    if (p->end[end] == BAKE_END_VELOCITY)
        widen(worst, fabs(state[1] - p->end_value[end]), size[1]);
    if (p->end[end] == BAKE_END_ACCELERATION)
        widen(worst, fabs(state[2] - p->end_value[end]), size[2]);
}

/* What a violation is measured against. A derivative of order i is made of values over H^i: a line
 * has an acceleration of their rounding, not 0, which must not be compared with itself. */
static void curve_size(const bake_work *work, const end_states *ends, double size[3])
{
    for (int i = 0; i < 3; i++) {
        size[i] = 1e-300;
        for (int k = 0; k < work->key_count - 1; k++)
            size[i] =
                fmax(size[i], fmax(ends[k].size[i], ends[k].size[0] / pow(work->parts[k].H, i)));
        for (int k = 0; k < work->key_count; k++)
            if (work->keys[k].weight[i] < 0.0)
                size[i] = fmax(size[i], fabs(work->keys[k].target[i]));
    }
}

static double residual(const bake_work *work)
{
    int count = work->key_count - 1, periodic = work->problem->end[0] == BAKE_END_PERIODIC;
    end_states *ends = bake_alloc((size_t)count, sizeof *ends);
    double size[3], worst = 0.0;
    for (int k = 0; k < count; k++)
        find_end_states(&work->parts[k], &work->segments[k], &ends[k]);
    curve_size(work, ends, size);
    for (int k = 0; k < count; k++) {
        const double *before = ends[k ? k - 1 : count - 1].at[1];
        for (int i = 0; i < 3 && (k || periodic); i++)
            widen(&worst, fabs(ends[k].at[0][i] - before[i]), size[i]);
        check_key(work, k, ends[k].at[0], size, &worst);
        check_key(work, k + 1, ends[k].at[1], size, &worst);
    }
    free(ends);
    return worst;
}

typedef struct {
    const bake_segment *segment;
    const bake_mode *mode;
    double middle, energy, farthest;
} measured;

static void measure(void *context, double s, double weight)
{
    measured *m = context;
    double b[4][5], d[3];
    bake_segment_functions(m->segment, s, b);
    for (int i = 0; i < 3; i++) {
        d[i] = b[i][4];
        for (int j = 0; j < 4; j++)
            d[i] += b[i][j] * m->segment->w[j];
    }
    double f = d[2] + 2.0 * m->mode->delta * d[1] + m->mode->lambda * d[0] + m->mode->g;
    m->energy += weight * f * f;
    m->farthest = fmax(m->farthest, fabs(d[0] - m->middle));
}

/* middle of the keys, and the amplitude their data ask for */
static void key_range(const bake_work *work, double *middle, double *amplitude)
{
    const bake_mode *mode = &work->problem->mode;
    double lowest = HUGE_VAL, highest = -HUGE_VAL, speed = 0.0;
    int last = work->key_count - 1;
    for (int k = 0; k <= last; k++) {
        const bake_key *key = &work->keys[k];
        if (key->weight[0] != 0.0) {
            lowest = fmin(lowest, key->target[0]);
            highest = fmax(highest, key->target[0]);
        }
        if (key->weight[1] != 0.0)
            speed = fmax(speed, fabs(key->target[1]));
    }
    for (int end = 0; end < 2; end++)
        if (work->problem->end[end] == BAKE_END_VELOCITY)
            speed = fmax(speed, fabs(work->problem->end_value[end]));
    if (lowest > highest)
        lowest = highest = 0.0;
    /* a constant pull of f moves w by f h^2/8 within an interval, and by f/lambda at most */
    double interval = (work->keys[last].time - work->keys[0].time) / last;
    *middle = 0.5 * (lowest + highest);
    double pull = fabs(mode->lambda * *middle + mode->g), stiffness = fabs(mode->lambda);
    *amplitude =
        0.5 * (highest - lowest) + speed * interval +
        pull * fmin(interval * interval / 8.0, stiffness > 0.0 ? 1.0 / stiffness : HUGE_VAL);
}

/* What |w - middle| cannot exceed: no basis function exceeds 1, SERIES 1.5 and P_4 2. */
static double bound(const bake_work *work, double middle)
{
    double worst = 0.0;
    for (int k = 0; k < work->key_count - 1; k++) {
        const bake_segment *segment = &work->segments[k];
        double sum = fabs(segment->rest - middle) + 2.0 * fabs(segment->drive);
        for (int j = 0; j < 4; j++)
            sum += 1.5 * fabs(segment->w[j]);
        worst = fmax(worst, sum);
    }
    return worst;
}

static void fill_report(const bake_work *work, double middle, double amplitude,
                        bake_spline_report *report)
{
    measured m = {.mode = &work->problem->mode, .middle = middle};
    for (int k = 0; k < work->key_count - 1; k++) {
        m.segment = &work->segments[k];
        bake_segment_quadrature(m.segment, measure, &m);
    }
    report->energy = m.energy;
    report->overshoot = m.farthest > 0.0 && amplitude > 0.0 ? m.farthest / amplitude : 0.0;
}

int bake_spline_check(const bake_work *work, bake_spline_report *report, bake_error *error)
{
    double middle, amplitude;
    bake_spline_report own = {.resonant_segment = -1};
    own.residual = residual(work);
    own.condition = work->condition;
    key_range(work, &middle, &amplitude);
    if (report || bound(work, middle) > OVERSHOOT_WARNING * amplitude)
        fill_report(work, middle, amplitude, &own);
    if (own.overshoot > OVERSHOOT_WARNING)
        own.resonant_segment = bake_resonant_segment(work);
    if (report)
        *report = own;
    if (!(own.condition >= CONDITION_LIMIT))
        return bake_fail_resonant(work, "the end conditions barely determine the curve", error);
    if (!(own.residual <= RESIDUAL_LIMIT))
        return bake_fail(error, "the solve left a residual of %.3g (limit %.0e): %s", own.residual,
                         RESIDUAL_LIMIT,
                         "the conditions contradict each other or scales differ by "
                         "more than double precision holds");
    if (error)
        error->text[0] = '\0';
    if (own.resonant_segment < 0 || !error)
        return 0;
    bake_fail_resonant(work, "the curve overshoots its keys more than tenfold", error);
    return 0; /* a warning: the curve is exact, but hardly what was meant */
}
