/* Checks a spline problem and hands it to the path that fits.
 * Source: Schulz 2013, 2.5.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int check_weights(const bake_key *key, bake_error *error)
{
    for (int i = 0; i < 3; i++) {
        if (!isfinite(key->target[i]) || !isfinite(key->weight[i]))
            return bake_fail(error, "the key at %.6g s has a value that is not a number",
                             key->time);
        if (key->weight[i] < 0.0 && key->weight[i] != BAKE_HARD)
            return bake_fail(error, "the key at %.6g s has weight %g; use >= 0, or hard", key->time,
                             key->weight[i]);
    }
    return 0;
}

static int check_keys(const bake_key *keys, int key_count, bake_error *error)
{
    if (key_count < 2)
        return bake_fail(error, "a spline needs at least two keys, not %d", key_count);
    for (int k = 0; k < key_count; k++) {
        if (!isfinite(keys[k].time))
            return bake_fail(error, "key %d has a time that is not a number", k + 1);
        if (k && !(keys[k].time > keys[k - 1].time))
            return bake_fail(error, "key %d at %.6g s is not later than the one before it, %.6g s",
                             k + 1, keys[k].time, keys[k - 1].time);
        if (check_weights(&keys[k], error))
            return -1;
    }
    return 0;
}

static int check_problem(const bake_spline_problem *p, bake_error *error)
{
    if (!isfinite(p->mode.lambda) || !isfinite(p->mode.delta) || !isfinite(p->mode.g))
        return bake_fail(error, "stiffness, damping or force is not a number");
    if (!(p->alpha >= 0.0) || !(p->beta >= 0.0) || !(p->gamma >= 0.0) ||
        !isfinite(p->alpha + p->beta + p->gamma))
        return bake_fail(error, "regulariser weights alpha, beta, gamma must be finite and >= 0");
    if ((p->end[0] == BAKE_END_PERIODIC) != (p->end[1] == BAKE_END_PERIODIC))
        return bake_fail(error, "periodic: both ends or none");
    for (int i = 0; i < 2; i++)
        if (!isfinite(p->end_value[i]))
            return bake_fail(error, "an end velocity or acceleration is not a number");
    return 0;
}

/* Then both the energy and the end conditions act on the velocities alone. */
static int is_direct(const bake_spline_problem *p, const bake_key *keys, int key_count)
{
    if (p->alpha != 0.0 || p->beta != 0.0 || p->gamma != 0.0 || p->end[0] == BAKE_END_PERIODIC)
        return 0;
    for (int k = 0; k < key_count; k++)
        if (keys[k].weight[0] != BAKE_HARD || keys[k].weight[1] != 0.0 || keys[k].weight[2] != 0.0)
            return 0;
    return 1;
}

/* Equal intervals, common in practice, share one basis evaluation. */
static void prepare(bake_work *work)
{
    for (int k = 0; k < work->key_count - 1; k++) {
        bake_segment *segment = &work->segments[k];
        double t0 = work->keys[k].time, t1 = work->keys[k + 1].time;
        bake_segment_prepare(segment, &work->problem->mode, t0, t1);
        if (k && t1 - t0 == segment[-1].t1 - segment[-1].t0)
            work->parts[k] = work->parts[k - 1];
        else
            bake_part_prepare(&work->parts[k], segment);
    }
}

int bake_spline_solve(const bake_spline_problem *problem, const bake_key *keys, int key_count,
                      bake_curve *curve, bake_spline_report *report, bake_error *error)
{
    *curve = (bake_curve){0};
    if (check_keys(keys, key_count, error) || check_problem(problem, error))
        return -1;
    size_t count = (size_t)key_count;
    bake_work work = {.problem = problem, .keys = keys, .key_count = key_count};
    work.segments = bake_alloc(count - 1, sizeof *work.segments);
    work.parts = bake_alloc(count - 1, sizeof *work.parts);
    work.w = bake_alloc(2 * count, sizeof *work.w);
    work.v = work.w + count;
    prepare(&work);
    int failed = is_direct(problem, keys, key_count) ? bake_solve_banded(&work, error)
                                                     : bake_solve_energy(&work, error);
    if (!failed)
        failed = bake_spline_check(&work, report, error);
    free(work.parts);
    free(work.w);
    if (failed) {
        free(work.segments);
        return -1;
    }
    *curve = (bake_curve){key_count - 1, work.segments};
    return 0;
}
