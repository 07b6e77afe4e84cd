/* Each channel's power of two, from everything that may move it: clips, layers that add, filters.
 * Source: own; intervals through the filters in their order.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "build.h"

#include <math.h>
#include <stdlib.h>

/* Raw units span this many bits of a channel's range, so that a 16-bit knot has 4 bits below it and
 * coefficients of several times the range still fit (DESIGN 6). */
#define RANGE_BITS 20

/* Values stay below 2^27 raw units: the player saturates at 2^29. */
#define LARGEST_BITS 27

/* Constants of filters may cost a channel this many of its bits; a limit still farther away is an
 * error of build_pack. */
#define CONSTANT_BITS 4

/* Default tolerance: half a step of a 12-bit servo, or two raw units of values far from 0. */
#define DEFAULT_SHARE (1.0 / 8192)

/* lo, hi   values at this stage of the filters
 * clips    widest clip: 0 = none moves the channel
 * mixed    widest that a matrix makes of it
 * width    what RANGE_BITS span
 * constant largest |constant| of a filter */
typedef struct {
    double lo, hi, clips, mixed, width, largest, constant;
} reach;

static void look(const bake_segment *s, double share, double *lo, double *hi)
{
    double out[4];
    bake_segment_eval(s, s->t0 + (s->t1 - s->t0) * share, out);
    *lo = fmin(*lo, out[0]);
    *hi = fmax(*hi, out[0]);
}

/* Places in every half period, and ever nearer to both ends, where damped motion is over soon. */
static void widen(const bake_curve *curve, double *lo, double *hi)
{
    for (int i = 0; i < curve->count; i++) {
        const bake_segment *s = &curve->segment[i];
        int places = (int)fmin(4096, fmax(64, 4 * s->b * (s->t1 - s->t0)));
        for (int j = 0; j <= places; j++) {
            look(s, (double)j / places, lo, hi);
        }
        for (double share = 1.0 / 96; share > 1e-6; share *= 0.75) {
            look(s, share, lo, hi);
            look(s, 1 - share, lo, hi);
        }
    }
}

static void note_largest(reach *r)
{
    r->largest = fmax(r->largest, fmax(fabs(r->lo), fabs(r->hi)));
}

/* Rest and clips; what layers add may lie on top of either. */
static void reach_clips(const build *b, int channel, int adding_layers, reach *r)
{
    const scene *s = b->scene;
    double add[2] = {0, 0};
    *r = (reach){.lo = s->channels[channel].rest, .hi = s->channels[channel].rest};
    for (int i = 0; i < s->clip_count; i++) {
        double from = HUGE_VAL, to = -HUGE_VAL;
        for (int j = 0; j < s->clips[i].curve_count; j++) {
            if (s->clips[i].curves[j].channel == channel) {
                widen(&b->clip[i].curve[j], &from, &to);
            }
        }
        r->clips = fmax(r->clips, to - from);
        if (s->clips[i].additive) {
            add[0] = fmin(add[0], from);
            add[1] = fmax(add[1], to);
            r->largest = fmax(r->largest, fmax(-add[0], add[1]));
        } else {
            r->lo = fmin(r->lo, from);
            r->hi = fmax(r->hi, to);
        }
    }
    note_largest(r);
    r->width = r->clips;
    r->lo += adding_layers * add[0];
    r->hi += adding_layers * add[1];
}

/* The scene's own `range` counts where clips do not say it all. */
static void reach_range(const scene_channel *c, reach *r)
{
    if (c->range[0] < c->range[1]) {
        r->lo = fmin(r->lo, c->range[0]);
        r->hi = fmax(r->hi, c->range[1]);
        r->width = fmax(r->width, c->range[1] - c->range[0]);
        note_largest(r);
    }
}

/* A row may cancel what it adds up, so `largest` counts the terms. */
static void reach_matrix(const scene_filter *f, reach *all, double input[WG_MATRIX_MAX])
{
    reach in[WG_MATRIX_MAX];
    for (int j = 0; j < f->n; j++) {
        in[j] = all[f->channels[j]];
        in[j].width = fmax(in[j].width, in[j].hi - in[j].lo);
        input[j] = fmax(fabs(in[j].lo), fabs(in[j].hi));
    }
    for (int i = 0; i < f->n; i++) {
        reach *r = &all[f->channels[i]];
        double lo = 0, hi = 0, width = 0, terms = 0;
        for (int j = 0; j < f->n; j++) {
            double m = f->matrix[i][j], a = m * in[j].lo, z = m * in[j].hi;
            lo += fmin(a, z);
            hi += fmax(a, z);
            width += fabs(m) * in[j].width;
            terms += fabs(m) * input[j];
        }
        r->lo = lo;
        r->hi = hi;
        r->mixed = fmax(r->mixed, hi - lo);
        r->width = fmax(r->width, width);
        r->largest = fmax(r->largest, terms);
    }
}

static void reach_filter(const scene_filter *f, reach *r)
{
    double about = f->op == (int)WG_FILTER_GAIN ? f->b : 0;
    double a = f->op == (int)WG_FILTER_GAIN ? about + (r->lo - about) * f->a : r->lo;
    double z = f->op == (int)WG_FILTER_GAIN ? about + (r->hi - about) * f->a : r->hi;
    double least = f->op == (int)WG_FILTER_CLAMP || f->op == (int)WG_FILTER_MIN ? f->a : -HUGE_VAL;
    double most = f->op == (int)WG_FILTER_CLAMP ? f->b : HUGE_VAL;
    double shift = f->op == (int)WG_FILTER_OFFSET ? f->a : 0;
    r->lo = fmax(least, fmin(most, fmin(a, z) + shift));
    r->hi = fmax(least, fmin(most, fmax(a, z) + shift));
    r->constant = fmax(r->constant, f->op == (int)WG_FILTER_GAIN ? 0 : fabs(f->a));
    r->constant = fmax(r->constant, fabs(f->b));
    note_largest(r);
}

/* An entry of a matrix holds |m| < 8 in steps of the channels' scales. Members that other filters
 * widened later are brought within half of that; a cycle that cannot be is an error of build_pack.
 */
static void balance(const scene *s, reach *all)
{
    for (int pass = 0; pass < 8; pass++) {
        for (int k = 0; k < s->filter_count; k++) {
            const scene_filter *f = &s->filters[k];
            for (int e = 0; f->op == (int)WG_FILTER_MATRIX && e < f->n * f->n; e++) {
                int i = f->channels[e / f->n], j = f->channels[e % f->n];
                double least = fabs(f->matrix[e / f->n][e % f->n]) * all[j].width / 3.9;
                all[i].width = fmax(all[i].width, least);
            }
        }
    }
}

/* A channel that nothing moves has the size of its constants. */
static int choose_frac(const reach *r)
{
    double span = r->width > 0 ? r->width : fmax(1e-6, fmax(r->largest, r->constant));
    int frac = (int)floor(RANGE_BITS - log2(span));
    while (frac > -30 && ldexp(r->largest, frac) > ldexp(1, LARGEST_BITS)) {
        frac--;
    }
    frac = frac > 30 ? 30 : frac;
    for (int i = 0; i < CONSTANT_BITS && frac > -30; i++) {
        frac -= ldexp(r->constant, frac) > (double)WG_VALUE_LIMIT;
    }
    return frac;
}

static void reach_over(reach *r, double lo, double hi)
{
    r->lo = fmin(r->lo, lo);
    r->hi = fmax(r->hi, hi);
    r->width = fmax(r->width, hi - lo);
    note_largest(r);
}

/* What a program may set by itself: additive shapes all the way, a camera all around. */
static void reach_pictures(const scene *s, reach *all)
{
    for (int i = 0; i < s->mesh_count; i++) {
        for (int j = 0; j < s->meshes[i].shape_count; j++) {
            reach_over(&all[s->meshes[i].shapes[j].channel], 0, 1);
        }
    }
    for (int i = 0; i < s->view_count; i++) {
        const int *c = s->views[i].channel;
        double far = fabs(s->channels[c[WG_VIEW_DISTANCE]].rest);
        for (int k = (int)WG_VIEW_X; k < (int)WG_VIEW_CHANNELS; k++) {
            far = fmax(far, fabs(s->channels[c[k]].rest));
        }
        for (int k = 0; k < (int)WG_VIEW_CHANNELS; k++) {
            double wide = k < (int)WG_VIEW_X ? 180 : 2 * far;
            reach_over(&all[c[k]], -wide, wide);
        }
    }
}

/* A joint that no clip moves and that has no range: what a program may do with it. */
static void reach_joint(const scene *s, const scene_joint *j, reach *all)
{
    int count = j->kind == (int)WG_JOINT_QUATERNION ? 4 : j->kind == (int)WG_JOINT_FOLLOW ? 0 : 1;
    double most = count == 4 || j->kind == (int)WG_JOINT_MOVE ? 1
                  : j->kind == (int)WG_JOINT_STRETCH          ? 2
                                                              : 360;
    for (int c = j->channel; c < j->channel + count; c++) {
        if (all[c].clips <= 0 && s->channels[c].range[0] >= s->channels[c].range[1]) {
            reach_over(&all[c], -most, most);
        }
    }
}

static void reach_rigs(const scene *s, reach *all)
{
    for (int i = 0; i < s->rig_count; i++) {
        for (int b = 0; b < s->rigs[i].bone_count; b++) {
            const scene_bone *bone = &s->rigs[i].bones[b];
            for (int k = 0; k < bone->joint_count; k++) {
                reach_joint(s, &bone->joints[k], all);
            }
        }
    }
}

/* A field lies between the values that it is a mean of. */
static void reach_fields(const scene *s, reach *all)
{
    for (int i = 0; i < s->rig_count; i++) {
        const scene_rig *r = &s->rigs[i];
        for (int f = 0; f < r->field_count; f++) {
            for (int b = 0; b < r->bone_count; b++) {
                if (r->bones[b].value >= 0) {
                    const reach *from = &all[r->bones[b].value];
                    reach_over(&all[r->fields[f].channel], from->lo, from->hi);
                }
            }
        }
    }
}

static int scale_channel(build *b, int c, const reach *r, bake_error *error)
{
    const scene *s = b->scene;
    double moved = fmax(r->clips, r->mixed);
    b->range[c] = moved > 0 ? moved : fmax(1e-6, r->largest);
    b->frac[c] = choose_frac(r);
    if (!isfinite(r->largest) || b->frac[c] <= -30) {
        return bake_fail(error, "%s: channel %s reaches %g: values must stay below 1e17", s->path,
                         s->channels[c].name, r->largest);
    }
    b->tolerance[c] = s->channels[c].tolerance > 0
                          ? s->channels[c].tolerance
                          : fmax(b->range[c] * DEFAULT_SHARE, ldexp(2, -b->frac[c]));
    return 0;
}

int build_scale(build *b, bake_error *error)
{
    const scene *s = b->scene;
    reach *all = bake_alloc((size_t)s->channel_count, sizeof *all);
    int adding = 0, err = 0;
    for (int i = 0; i < s->layer_count; i++) {
        adding += s->layers[i].mode == (int)WG_MODE_ADD;
    }
    for (int c = 0; c < s->channel_count; c++) {
        reach_clips(b, c, adding, &all[c]);
        if (all[c].clips <= 0) {
            reach_range(&s->channels[c], &all[c]);
        }
    }
    reach_pictures(s, all);
    reach_rigs(s, all);
    for (int k = 0; k < s->filter_count; k++) {
        for (int i = 0; i < s->filters[k].n; i++) {
            reach_range(&s->channels[s->filters[k].channels[i]], &all[s->filters[k].channels[i]]);
        }
    }
    for (int k = 0; k < s->filter_count; k++) {
        if (s->filters[k].op == (int)WG_FILTER_MATRIX) {
            reach_matrix(&s->filters[k], all, b->input[k]);
        } else {
            reach_filter(&s->filters[k], &all[s->filters[k].channel]);
        }
    }
    balance(s, all);
    reach_fields(s, all);
    for (int c = 0; c < s->channel_count && err == 0; c++) {
        err = scale_channel(b, c, &all[c], error);
    }
    free(all);
    return err;
}
