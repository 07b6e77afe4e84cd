/* What a body does to channels that servos follow: how far a place has moved, how far it has
 * turned, a joint.
 * Source: own. Sampled as densely as the channel's tolerance asks; the player's velocity is that of
 * the curve.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STEP_MOST  0.016
#define STEP_LEAST 0.001

/* Of the tolerance, and of the range where none is given: what the curve between samples may
 * miss. */
#define BETWEEN 0.1
#define FINE    (0.1 / 8192)

static double shifted(const body_work *w, const scene_output *o, const double *x)
{
    const vertex_list *list = body_region(w, o->region);
    double from[3], to[3], sum = 0;
    body_centre(w, list, w->rest, from);
    body_centre(w, list, x, to);
    for (int k = 0; k < 3; k++) {
        sum += o->direction[k] * (to[k] - from[k]);
    }
    return sum / w->from->unit;
}

/* The angle about the axis that brings rest nearest to x, both about their centres: of the parts
 * across the axis, the sum of m r x r' over that of m r . r'. */
static double turned(const body_work *w, const scene_output *o, const double *x)
{
    const vertex_list *list = body_region(w, o->region);
    double from[3], to[3], sine = 0, cosine = 0;
    const double *a = o->direction;
    body_centre(w, list, w->rest, from);
    body_centre(w, list, x, to);
    for (int i = 0; i < list->count; i++) {
        double r[3], s[3], along_r = 0, along_s = 0, m = w->b.mass[list->vertex[i]];
        for (int k = 0; k < 3; k++) {
            r[k] = w->rest[3 * list->vertex[i] + k] - from[k];
            s[k] = x[3 * list->vertex[i] + k] - to[k];
            along_r += a[k] * r[k];
            along_s += a[k] * s[k];
        }
        for (int k = 0; k < 3; k++) {
            int p = (k + 1) % 3, q = (k + 2) % 3;
            cosine += m * (r[k] - along_r * a[k]) * (s[k] - along_s * a[k]);
            sine += m * a[k] * (r[p] * s[q] - r[q] * s[p]);
        }
    }
    return atan2(sine, cosine) / DEGREE;
}

/* A welded link turns with its parent. */
static double absolute_angle(const body_work *w, int link, const double *q)
{
    double more = 0;
    while (link >= 0 && w->links[link].stiff) {
        int parent = w->links[link].parent;
        more += w->links[link].angle - (parent >= 0 ? w->links[parent].angle : 0);
        link = parent;
    }
    return link < 0 ? more : more + q[body_link_coordinate(w, link)];
}

static double joint(const body_work *w, const scene_output *o, const double *q)
{
    int parent = w->links[o->joint].parent;
    double angle = absolute_angle(w, o->joint, q) - absolute_angle(w, o->joint, w->rest);
    if (parent >= 0) {
        angle -= absolute_angle(w, parent, q) - absolute_angle(w, parent, w->rest);
    }
    return angle / DEGREE;
}

/* A region that is a line along the axis does not turn about it. */
int body_output_check(const body_work *w, bake_error *error)
{
    for (int i = 0; i < w->from->output_count; i++) {
        const scene_output *o = &w->from->outputs[i];
        if (o->kind != OUTPUT_TURN) {
            continue;
        }
        const vertex_list *list = body_region(w, o->region);
        double centre[3], across = 0, size = 0;
        body_centre(w, list, w->rest, centre);
        for (int k = 0; k < list->count; k++) {
            double along = 0, square = 0;
            for (int a = 0; a < 3; a++) {
                double r = w->rest[3 * list->vertex[k] + a] - centre[a];
                along += o->direction[a] * r;
                square += r * r;
            }
            across = fmax(across, square - along * along);
            size = fmax(size, square);
        }
        if (across <= 1e-9 * size) {
            return body_fail(w, o->line, error,
                             "the region of this output is a line along the axis, or a point: how "
                             "far it turns cannot be seen; make it larger across the axis");
        }
    }
    return 0;
}

static double value_of(const body_work *w, const scene_output *o, const double *x)
{
    return o->kind == OUTPUT_SHIFT  ? shifted(w, o, x)
           : o->kind == OUTPUT_TURN ? turned(w, o, x)
                                    : joint(w, o, x);
}

static void sample(const body_work *w, const scene_output *o, const body_clip *c,
                   const body_times *times, double *value)
{
    double *x = bake_alloc((size_t)w->n, sizeof *x);
    for (int i = 0; i < times->count; i++) {
        body_clip_eval(w, c, times->time[i], x);
        value[i] = value_of(w, o, x);
        if (o->kind == OUTPUT_TURN && i > 0) { /* no jump where a half turn is passed */
            value[i] += 360 * floor((value[i - 1] - value[i]) / 360 + 0.5);
        }
    }
    free(x);
}

/* What the C2 spline through all samples misses between two: 1/384 h^4 f^(4). The cubic through the
 * two neighbours on either side misses 1/6 h^4 f^(4) of a sample, 64 times that. */
static double rough(const body_times *t, const double *value)
{
    double worst = 0;
    for (int i = 3; i + 3 < t->count; i++) {
        int kink = 0;
        for (int j = i - 2; j <= i + 2; j++) {
            kink |= t->kink[j];
        }
        double cubic = (4 * (value[i - 1] + value[i + 1]) - value[i - 2] - value[i + 2]) / 6;
        worst = kink ? worst : fmax(worst, fabs(cubic - value[i]));
    }
    return worst / 64;
}

static double limit_of(const body_work *w, const scene_output *o, const body_times *t,
                       const double *value)
{
    double lo = HUGE_VAL, hi = -HUGE_VAL, given = w->s->channels[o->channel].tolerance;
    for (int i = 0; i < t->count; i++) {
        lo = fmin(lo, value[i]);
        hi = fmax(hi, value[i]);
    }
    return given > 0 ? BETWEEN * given : FINE * (hi - lo);
}

/* Room for a curve at its place: curves ascend by channel. */
static scene_curve *insert_curve(scene_clip *clip, int channel)
{
    int at = 0;
    clip->curves = bake_grow(clip->curves, (size_t)clip->curve_count + 1, sizeof *clip->curves);
    while (at < clip->curve_count && clip->curves[at].channel < channel) {
        at++;
    }
    memmove(clip->curves + at + 1, clip->curves + at,
            (size_t)(clip->curve_count++ - at) * sizeof *clip->curves);
    return &clip->curves[at];
}

static void make_curve(const scene_output *o, const body_clip *c, const body_times *t,
                       double *value, scene *s)
{
    scene_curve *curve = insert_curve(&s->clips[c->clip], o->channel);
    int count = t->count + (c->loops && t->count > 1);
    *curve = (scene_curve){
        .line = o->line, .channel = o->channel, .kind = CURVE_SAMPLED, .source = -1, .scale = 1};
    curve->end[0] = curve->end[1] = c->loops ? BAKE_END_PERIODIC : BAKE_END_ACCELERATION;
    curve->samples = bake_alloc(1, sizeof *curve->samples);
    curve->samples->count = count;
    curve->samples->time = bake_alloc((size_t)count, sizeof(double));
    curve->samples->value = bake_alloc((size_t)count, sizeof(double));
    curve->samples->kink = bake_alloc((size_t)count, 1);
    for (int i = 0; i < count; i++) {
        curve->samples->time[i] = t->time[i];
        curve->samples->value[i] = value[i % t->count];
        curve->samples->kink[i] = i < t->count && t->kink[i];
    }
}

void body_outputs(const body_work *w, const body_clip *c, scene *s)
{
    for (int i = 0; i < w->from->output_count; i++) {
        const scene_output *o = &w->from->outputs[i];
        double *value = NULL;
        body_times times = {0};
        for (double step = STEP_MOST; step >= STEP_LEAST; step /= 2) {
            free(value);
            body_times_free(&times);
            body_clip_times(c, step, 0, &times);
            value = bake_alloc((size_t)times.count, sizeof *value);
            sample(w, o, c, &times, value);
            if (rough(&times, value) <= limit_of(w, o, &times, value)) {
                break;
            }
        }
        make_curve(o, c, &times, value, s);
        free(value);
        body_times_free(&times);
    }
}
