/* Curves: evaluation, and the plain kinds: held, linear, B-spline.
 * Source: de Boor's algorithm; phantom control points are our own choice (spline.h).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_parts.h"

#include <stdlib.h>

static const bake_mode no_mode = {0.0, 0.0, 0.0};

void bake_curve_free(bake_curve *curve)
{
    free(curve->segment);
    *curve = (bake_curve){0};
}

void bake_curve_append(bake_curve *curve, bake_curve *more)
{
    size_t count = (size_t)(curve->count + more->count);
    curve->segment = bake_grow(curve->segment, count, sizeof *curve->segment);
    for (int i = 0; i < more->count; i++) {
        curve->segment[curve->count++] = more->segment[i];
    }
    bake_curve_free(more);
}

void bake_curve_eval(const bake_curve *curve, double t, double out[4])
{
    int low = 0, high = curve->count - 1;
    double start = curve->segment[0].t0, end = curve->segment[high].t1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (t >= curve->segment[middle].t0)
            low = middle;
        else
            high = middle - 1;
    }
    int outside = t < start || t > end;
    bake_segment_eval(&curve->segment[low], t < start ? start : t > end ? end : t, out);
    for (int i = 1; outside && i < 4; i++)
        out[i] = 0.0;
}

static void set_cubic(bake_segment *segment, const double t[2], const double w[2],
                      const double v[2])
{
    bake_part part;
    bake_segment_prepare(segment, &no_mode, t[0], t[1]);
    bake_part_prepare(&part, segment);
    bake_part_coefficients(&part, w, v, segment);
}

static int check_times(const bake_key *keys, int key_count, int least, bake_error *error)
{
    if (key_count < least)
        return bake_fail(error, "this curve needs at least %d keys, not %d", least, key_count);
    for (int k = 1; k < key_count; k++)
        if (!(keys[k].time > keys[k - 1].time))
            return bake_fail(error, "key %d at %.6g s is not later than the one before it, %.6g s",
                             k + 1, keys[k].time, keys[k - 1].time);
    return 0;
}

static void allocate(bake_curve *curve, int count)
{
    curve->count = count;
    curve->segment = bake_alloc((size_t)count, sizeof *curve->segment);
}

int bake_curve_held(const bake_key *keys, int key_count, double end_time, bake_curve *curve,
                    bake_error *error)
{
    *curve = (bake_curve){0};
    if (check_times(keys, key_count, 1, error))
        return -1;
    double last = keys[key_count - 1].time;
    int hold = end_time > last;
    if (key_count == 1 && !hold)
        return bake_fail(error, "a single held key at %.6g s needs an end after it, not %.6g s",
                         last, end_time);
    allocate(curve, key_count - 1 + hold);
    for (int k = 0; k < curve->count; k++) {
        double t1 = k + 1 < key_count ? keys[k + 1].time : end_time;
        bake_segment_prepare(&curve->segment[k], &no_mode, keys[k].time, t1);
        curve->segment[k].w[0] = keys[k].target[0];
    }
    return 0;
}

int bake_curve_linear(const bake_key *keys, int key_count, bake_curve *curve, bake_error *error)
{
    *curve = (bake_curve){0};
    if (check_times(keys, key_count, 2, error))
        return -1;
    allocate(curve, key_count - 1);
    for (int k = 0; k < curve->count; k++) {
        bake_segment *segment = &curve->segment[k];
        bake_segment_prepare(segment, &no_mode, keys[k].time, keys[k + 1].time);
        segment->w[0] = 0.5 * (keys[k].target[0] + keys[k + 1].target[0]);
        segment->w[1] = 0.5 * (keys[k + 1].target[0] - keys[k].target[0]);
    }
    return 0;
}

/* Knots and control points of a cubic B-spline: span i is [knot[i + 2], knot[i + 3]] and uses
 * control points i .. i + 3 and knots i .. i + 5. */
typedef struct {
    double *knot, *control;
} control_net;

/* Cubic with n spans: every key time is a knot, the outer ones threefold. The polygon's end legs
 * carry one more control point each at a third, its Greville abscissa for even keys: there w'' = 0.
 */
static void clamped_net(const bake_key *keys, int n, const control_net *net)
{
    for (int i = -2; i <= n + 2; i++)
        net->knot[i + 2] = keys[i < 0 ? 0 : i > n ? n : i].time;
    for (int i = 0; i <= n; i++)
        net->control[i + 1] = keys[i].target[0];
    net->control[0] = keys[0].target[0];
    net->control[1] = (2.0 * keys[0].target[0] + keys[1].target[0]) / 3.0;
    net->control[n + 1] = (2.0 * keys[n].target[0] + keys[n - 1].target[0]) / 3.0;
    net->control[n + 2] = keys[n].target[0];
}

static int wrap(int i, int n)
{
    return ((i % n) + n) % n;
}

static void closed_net(const bake_key *keys, int n, const control_net *net)
{
    double period = keys[n].time - keys[0].time;
    for (int i = -2; i <= n + 2; i++) {
        int turn = (i - wrap(i, n)) / n;
        net->knot[i + 2] = keys[wrap(i, n)].time + turn * period;
    }
    for (int i = -1; i <= n + 1; i++)
        net->control[i + 1] = keys[wrap(i, n)].target[0];
}

/* Value and velocity at t of the span with knots u[0..5] and control points c[0..3]. */
static void de_boor(const double u[6], const double c[4], double t, double out[2])
{
    double d[4] = {c[0], c[1], c[2], c[3]};
    for (int level = 1; level <= 3; level++) {
        if (level == 3)
            out[1] = 3.0 * (d[1] - d[0]) / (u[3] - u[2]);
        for (int j = 0; j <= 3 - level; j++) {
            double x = (t - u[j + level - 1]) / (u[j + 3] - u[j + level - 1]);
            d[j] = (1.0 - x) * d[j] + x * d[j + 1];
        }
    }
    out[0] = d[0];
}

int bake_curve_bspline(const bake_key *keys, int key_count, int periodic, bake_curve *curve,
                       bake_error *error)
{
    *curve = (bake_curve){0};
    if (check_times(keys, key_count, 2, error))
        return -1;
    int n = key_count - 1;
    if (periodic && keys[0].target[0] != keys[n].target[0])
        return bake_fail(error, "a closed B-spline needs equal first and last keys, not %g and %g",
                         keys[0].target[0], keys[n].target[0]);
    double *memory = bake_alloc((size_t)(2 * n + 8), sizeof *memory);
    control_net net = {memory, memory + n + 5};
    (periodic ? closed_net : clamped_net)(keys, n, &net);
    allocate(curve, n);
    for (int k = 0; k < n; k++) {
        double t[2] = {keys[k].time, keys[k + 1].time}, state[2][2];
        for (int side = 0; side < 2; side++)
            de_boor(net.knot + k, net.control + k, t[side], state[side]);
        double w[2] = {state[0][0], state[1][0]}, v[2] = {state[0][1], state[1][1]};
        set_cubic(&curve->segment[k], t, w, v);
    }
    free(memory);
    return 0;
}
