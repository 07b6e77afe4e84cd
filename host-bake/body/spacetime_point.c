/* One-point dynamics: one linear model, one wiggly spline a mode.
 * Source: Schulz 2013, 2.6, algorithm 1. Partial poses are our own (spacetime_partial.c).
 *   Phi  d x d  column-major, orthogonal: q = Phi c, c = Phi^T q
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spacetime_parts.h"

#include <cblas.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define TWO_PI 6.28318530717958647693

double motion_project(const linear_model *model, int i, const double *q)
{
    const double *column = model->Phi + (size_t)model->d * (size_t)i;
    return cblas_ddot(model->d, column, 1, q, 1);
}

bake_mode motion_mode(const linear_model *model, const space_settings *settings, int mode)
{
    double lambda = settings->stiffness * model->lambda[mode];
    return (bake_mode){.lambda = lambda,
                       .delta = 0.5 * (settings->alpha + settings->beta * lambda),
                       .g = settings->stiffness * model->inner[mode] + model->outer[mode]};
}

void motion_mode_problem(const linear_model *model, const space_settings *settings, int mode,
                         bake_spline_problem *out)
{
    *out = (bake_spline_problem){.mode = motion_mode(model, settings, mode),
                                 .alpha = settings->regularise[0],
                                 .beta = settings->regularise[1],
                                 .gamma = settings->regularise[2]};
    for (int end = 0; end < 2; end++) {
        out->end[end] = settings->end[end];
        if (settings->end[end] == BAKE_END_VELOCITY && settings->end_v[end])
            out->end_value[end] = motion_project(model, mode, settings->end_v[end]);
    }
}

/* values: key_count x d as in motion_solve_term. A loop's last pose is the first one, to the bit.
 */
void motion_keys_of_mode(const motion_input *in, const linear_model *model, int mode,
                         const double *values, bake_key *out)
{
    int last = in->key_count - 1, loop = in->settings->end[0] == BAKE_END_PERIODIC;
    for (int k = 0; k <= last; k++) {
        const space_key *key = &in->keys[k], *pose = loop && k == last ? &in->keys[0] : key;
        out[k] = (bake_key){.time = key->time};
        if (key->rows > 0) {
            out[k].target[0] = values[(size_t)k * (size_t)model->d + (size_t)mode];
            out[k].weight[0] = BAKE_HARD;
        } else if (key->weight[0] != 0.0) {
            out[k].target[0] = motion_project(model, mode, pose->q);
            out[k].weight[0] = key->weight[0];
        }
        if (!key->v || key->weight[1] == 0.0)
            continue;
        out[k].target[1] = motion_project(model, mode, key->v);
        out[k].weight[1] = key->weight[1];
    }
}

void motion_mode_keys(const motion_input *in, int mode, const motion *solved, bake_key *out)
{
    const linear_model *model = solved->term[0].model;
    const space_key *keys = in->keys;
    size_t d = (size_t)model->d, last = (size_t)in->key_count - 1;
    double *values = bake_alloc((last + 1) * d, sizeof *values), c[4];
    for (size_t k = 0; k <= last; k++)
        if (keys[k].rows > 0) {
            bake_curve_eval(&solved->term[0].curve[mode], keys[k].time, c);
            values[k * d + (size_t)mode] = c[0];
        }
    if (solved->periodic && keys[0].rows > 0)
        values[last * d + (size_t)mode] = values[(size_t)mode];
    motion_keys_of_mode(in, model, mode, values, out);
    free(values);
}

/* ---- checks ---------------------------------------------------------------------------------- */

static int check_vector(const double *x, int count, double time, const char *what,
                        bake_error *error)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(x[i]))
            return bake_fail(error, "the %s at %.6g s is not a number", what, time);
    return 0;
}

static int check_key(const space_key *key, int d, int whole, bake_error *error)
{
    if (whole && (key->rows > 0 || key->weight[0] != BAKE_HARD))
        return bake_fail(error,
                         "the key at %.6g s is soft or asks for a part of its pose; with several "
                         "models each key needs a whole pose (or use dynamics: one-point)",
                         key->time);
    for (int i = 0; i < 2; i++)
        if (!(key->weight[i] >= 0.0 || key->weight[i] == BAKE_HARD) || isinf(key->weight[i]))
            return bake_fail(error, "the key at %.6g s has weight %g; use >= 0, or hard", key->time,
                             key->weight[i]);
    if (key->rows > 0 && key->weight[0] == 0.0)
        return bake_fail(error, "the partial key at %.6g s has weight 0", key->time);
    if (key->rows > 0 && (check_vector(key->p, key->rows, key->time, "partial pose", error) ||
                          check_vector(key->S, key->rows * d, key->time, "partial pose", error)))
        return -1;
    if (key->rows == 0 && key->weight[0] != 0.0 &&
        check_vector(key->q, d, key->time, "pose", error))
        return -1;
    return key->v ? check_vector(key->v, d, key->time, "velocity", error) : 0;
}

/* The same vector, but for what arithmetic did to it. */
static int same(const double *a, const double *b, int count)
{
    double largest = 0.0, apart = 0.0;
    for (int i = 0; i < count; i++) {
        largest = fmax(largest, fmax(fabs(a[i]), fabs(b[i])));
        apart = fmax(apart, fabs(a[i] - b[i]));
    }
    return apart <= 1e-9 * largest;
}

static int check_loop(const motion_input *in, int d, bake_error *error)
{
    const space_key *a = &in->keys[0], *b = &in->keys[in->key_count - 1];
    int equal = a->rows == b->rows && a->weight[0] == b->weight[0];
    if (equal && a->rows > 0)
        equal = same(a->p, b->p, a->rows) && same(a->S, b->S, a->rows * d);
    else if (equal && a->weight[0] != 0.0)
        equal = same(a->q, b->q, d);
    return equal ? 0
                 : bake_fail(error,
                             "a periodic motion ends where it starts: the last key, at %.6g s, "
                             "must repeat the first",
                             b->time);
}

static int check_settings(const space_settings *s, bake_error *error)
{
    if (!(s->stiffness > 0.0) || !isfinite(s->stiffness))
        return bake_fail(error, "stiffness must be > 0, not %g", s->stiffness);
    if (!isfinite(s->alpha) || !isfinite(s->beta))
        return bake_fail(error, "damping is not a number");
    for (int i = 0; i < 3; i++)
        if (!(s->regularise[i] >= 0.0) || !isfinite(s->regularise[i]))
            return bake_fail(error, "regularise must be >= 0, not %g", s->regularise[i]);
    if ((s->end[0] == BAKE_END_PERIODIC) != (s->end[1] == BAKE_END_PERIODIC))
        return bake_fail(error, "periodic: both ends or none");
    for (int end = 0; end < 2; end++)
        if (s->end[end] == BAKE_END_ACCELERATION)
            return bake_fail(error, "an end of a motion is free, has a velocity or is periodic");
    return 0;
}

int motion_check(const motion_input *in, int d, int whole, bake_error *error)
{
    const space_key *keys = in->keys;
    if (in->key_count < 2)
        return bake_fail(error, "a motion needs at least two keys, not %d", in->key_count);
    if (check_settings(in->settings, error))
        return -1;
    for (int k = 0; k < in->key_count; k++) {
        if (!isfinite(keys[k].time) || (k && !(keys[k].time > keys[k - 1].time)))
            return bake_fail(error, "key %d at %.6g s is not later than the one before it", k + 1,
                             keys[k].time);
        if (check_key(&keys[k], d, whole, error))
            return -1;
    }
    for (int end = 0; end < 2; end++) {
        const double *v = in->settings->end_v[end];
        if (v && check_vector(v, d, keys[end ? in->key_count - 1 : 0].time, "end velocity", error))
            return -1;
    }
    return in->settings->end[0] == BAKE_END_PERIODIC ? check_loop(in, d, error) : 0;
}

/* ---- solving --------------------------------------------------------------------------------- */

void motion_mode_name(const linear_model *model, const space_settings *settings, int mode,
                      char name[64])
{
    bake_mode m = motion_mode(model, settings, mode);
    if (m.lambda > 0.0)
        snprintf(name, 64, "mode %d (%.4g Hz)", mode + 1, sqrt(m.lambda) / TWO_PI);
    else
        snprintf(name, 64, "mode %d (%s)", mode + 1, m.lambda < 0.0 ? "unstable" : "rigid");
}

void motion_warn(motion_warnings *all, const char *who, const bake_error *one)
{
    if (all->count++ == 0)
        snprintf(all->first.text, sizeof all->first.text, "%s: %.900s", who, one->text);
}

void motion_warned(const motion_warnings *all, bake_error *error)
{
    if (!error)
        return;
    error->text[0] = '\0';
    if (all->count == 1)
        snprintf(error->text, sizeof error->text, "%s", all->first.text);
    if (all->count > 1)
        snprintf(error->text, sizeof error->text, "%.960s (and %d more modes like it)",
                 all->first.text, all->count - 1);
}

/* The first key after `from` that has both a hard value and a hard velocity, or the last one. */
static int next_stop(const bake_key *keys, int from, int key_count)
{
    int k = from + 1;
    while (k < key_count - 1 && !(keys[k].weight[0] < 0.0 && keys[k].weight[1] < 0.0))
        k++;
    return k;
}

int motion_solve_mode(const bake_spline_problem *problem, const bake_key *keys, int key_count,
                      bake_curve *curve, bake_error *error)
{
    int stop, failed = 0;
    error->text[0] = '\0';
    if (problem->end[0] == BAKE_END_PERIODIC)
        return bake_spline_solve(problem, keys, key_count, curve, NULL, error);
    *curve = (bake_curve){0};
    for (int from = 0; from < key_count - 1 && !failed; from = stop) {
        bake_spline_problem own = *problem;
        bake_error one = {""};
        bake_curve part;
        stop = next_stop(keys, from, key_count);
        for (int side = 0; side < 2; side++) {
            int k = side ? stop : from;
            if (k == 0 || k == key_count - 1)
                continue;
            own.end[side] = BAKE_END_VELOCITY;
            own.end_value[side] = keys[k].target[1];
        }
        failed = bake_spline_solve(&own, keys + from, stop - from + 1, &part, NULL, &one);
        if (failed || !error->text[0]) /* the first warning, or what went wrong */
            *error = one;
        bake_curve_append(curve, &part);
    }
    if (failed)
        bake_curve_free(curve);
    return failed;
}

int motion_solve_term(const motion_input *in, const double *values, motion_term *term,
                      motion_warnings *warnings, bake_error *error)
{
    bake_key *keys = bake_alloc((size_t)in->key_count, sizeof *keys);
    const linear_model *model = term->model;
    int failed = 0;
    for (int i = 0; i < model->d && !failed; i++) {
        bake_spline_problem problem;
        bake_error own = {""};
        char name[64];
        motion_mode_problem(model, in->settings, i, &problem);
        term->mode[i] = problem.mode;
        motion_keys_of_mode(in, model, i, values, keys);
        failed = motion_solve_mode(&problem, keys, in->key_count, &term->curve[i], &own);
        if (!own.text[0])
            continue;
        motion_mode_name(model, in->settings, i, name);
        if (failed)
            bake_fail(error, "%s: %.900s", name, own.text);
        else
            motion_warn(warnings, name, &own);
    }
    free(keys);
    return failed;
}

int motion_one_point(const linear_model *model, const motion_input *in, motion *out,
                     bake_error *error)
{
    motion_warnings warnings = {0};
    double *values = NULL;
    *out = (motion){0};
    if (motion_check(in, model->d, 0, error) || motion_partial_values(in, model, &values, error))
        return -1;
    motion_begin(in, model->d, 1, out);
    out->term->model = model;
    int failed = motion_solve_term(in, values, out->term, &warnings, error);
    free(values);
    if (failed) {
        motion_free(out);
        return -1;
    }
    motion_warned(&warnings, error);
    return 0;
}
