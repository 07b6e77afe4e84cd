/* As few influences a vertex as keep the posed surface within its tolerance: over the scene's own
 * motion and over random poses.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "skin_parts.h"

#include "author.h"
#include "shape_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- poses ------------------------------------------------------------------------------------ */

/* Moments looked at: of all clips together, and random ones. */
#define OWN_POSES    240
#define RANDOM_POSES 64

/* Numbers that repeat [Numerical Recipes' LCG]. */
static double chance(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (double)(*seed >> 8) / (double)(1u << 24);
}

static void rest_values(const scene *s, double *value)
{
    for (int c = 0; c < s->channel_count; c++) {
        value[c] = s->channels[c].rest;
    }
}

static int add_clip(const scene *s, int clip, int count, skin_poses *out, bake_error *error)
{
    author_clip a;
    size_t channels = (size_t)s->channel_count;
    if (author_clip_make(s, clip, &a, error) < 0) {
        return -1;
    }
    out->value =
        bake_grow(out->value, ((size_t)out->count + (size_t)count) * channels, sizeof *out->value);
    for (int i = 0; i < count; i++) {
        double t = (double)a.ticks / a.rate * i / (count > 1 ? count - 1 : 1);
        double *value = out->value + (size_t)out->count++ * channels;
        rest_values(s, value);
        for (int j = 0; j < a.count; j++) {
            const bake_curve *c = &a.curve[j];
            int channel = s->clips[clip].curves[j].channel;
            double end = c->segment[c->count - 1].t1, at[4];
            bake_curve_eval(c, t < end ? t : end, at);
            value[channel] = at[0] + (s->clips[clip].additive ? s->channels[channel].rest : 0);
        }
    }
    author_clip_free(&a);
    return 0;
}

/* What a channel that no clip moves may be: its range, or its limits, or a guess by what it does. */
static void reach(const scene *s, const scene_joint *j, double out[2])
{
    const scene_channel *c = &s->channels[j->channel];
    int turns = j->kind == (int)WG_JOINT_TURN || j->kind == (int)WG_JOINT_TWIST_START ||
                j->kind == (int)WG_JOINT_TWIST_END;
    double most = turns ? 45 : j->kind == (int)WG_JOINT_STRETCH ? 0.3 : 0;
    out[0] = c->rest - most;
    out[1] = c->rest + most;
    if (c->range[0] < c->range[1]) {
        memcpy(out, c->range, sizeof c->range);
    }
    for (int i = 0; i < s->filter_count; i++) {
        const scene_filter *f = &s->filters[i];
        if (f->op == (int)WG_FILTER_CLAMP && f->channel == j->channel) {
            out[0] = fmax(out[0], f->a);
            out[1] = fmin(out[1], f->b);
        }
    }
}

static int is_moved(const scene *s, int channel)
{
    for (int i = 0; i < s->clip_count; i++) {
        for (int j = 0; j < s->clips[i].curve_count; j++) {
            if (s->clips[i].curves[j].channel == channel) {
                return 1;
            }
        }
    }
    return 0;
}

/* A channel as it is at some moment of some clip. */
static void random_moment(const scene *s, int c, uint32_t *seed, skin_poses *p)
{
    size_t channels = (size_t)p->channels, moment = (size_t)(chance(seed) * p->own);
    if (c >= 0 && is_moved(s, c)) {
        p->value[(size_t)p->count * channels + (size_t)c] = p->value[moment * channels + (size_t)c];
    }
}

/* Shapes of the mesh and values of bones, each for itself. */
static void random_rest(const scene *s, const scene_rig *rig, uint32_t *seed, skin_poses *p)
{
    const scene_mesh *m = &s->meshes[rig->mesh];
    for (int i = 0; i < m->shape_count; i++) {
        random_moment(s, m->shapes[i].channel, seed, p);
    }
    for (int i = 0; i < rig->bone_count; i++) {
        random_moment(s, rig->bones[i].value, seed, p);
    }
}

/* Each bone as it is at some moment of some clip; or, where no clip moves it, anywhere in its reach. */
static void random_pose(const scene *s, const scene_rig *rig, uint32_t *seed, skin_poses *p)
{
    size_t channels = (size_t)s->channel_count;
    double *value = p->value + (size_t)p->count * channels;
    rest_values(s, value);
    for (int b = 0; b < rig->bone_count; b++) {
        const scene_bone *bone = &rig->bones[b];
        int moment = (int)(chance(seed) * p->own);
        for (int k = 0; k < bone->joint_count; k++) {
            const scene_joint *j = &bone->joints[k];
            int count = j->kind == (int)WG_JOINT_QUATERNION ? 4 : 1;
            for (int c = j->channel; c >= 0 && c < j->channel + count; c++) { /* FOLLOW: -1 */
                double lo_hi[2];
                reach(s, j, lo_hi);
                value[c] = is_moved(s, c) ? p->value[(size_t)moment * channels + (size_t)c]
                           : count == 4   ? s->channels[c].rest
                                          : lo_hi[0] + chance(seed) * (lo_hi[1] - lo_hi[0]);
            }
        }
    }
    random_rest(s, rig, seed, p);
    p->count++;
}

static int make_poses(const scene *s, const scene_rig *rig, skin_poses *out, bake_error *error)
{
    size_t channels = (size_t)s->channel_count;
    uint32_t seed = 1;
    int err = 0;
    *out = (skin_poses){.channels = s->channel_count};
    for (int i = 0; i < s->clip_count && err == 0; i++) {
        err = add_clip(s, i, OWN_POSES / s->clip_count + 2, out, error);
    }
    if (err < 0) {
        return -1;
    }
    out->own = out->count;
    out->value = bake_grow(out->value, ((size_t)out->count + RANDOM_POSES) * channels + 1,
                           sizeof *out->value);
    for (int i = 0; i < RANDOM_POSES; i++) {
        random_pose(s, rig, &seed, out);
    }
    return 0;
}

/* ---- posed vertices --------------------------------------------------------------------------- */

/* Weights of vertex i as solved, a bone each. */
static void exact_row(const skin *k, int i, double *weight, double *end)
{
    for (int j = 0; j < k->bone_count; j++) {
        size_t at = (size_t)j * (size_t)k->vertex_count + (size_t)i;
        weight[j] = k->weight[at];
        end[j] = k->end ? k->end[at] : 0;
    }
}

static void stored_row(const skin *k, const influence *v, double *weight, double *end)
{
    memset(weight, 0, (size_t)k->bone_count * sizeof *weight);
    memset(end, 0, (size_t)k->bone_count * sizeof *end);
    for (int j = 0; j < v->count; j++) {
        weight[v->bone[j]] += influence_weight(v, j);
        end[v->bone[j]] = k->end ? influence_end(v, j) : 0;
    }
}

void skin_pose(const scene_rig *rig, const skin *k, const double *value, const double *rest,
               int stored, double *out)
{
    rig_bone *bones = bake_alloc((size_t)k->bone_count, sizeof *bones);
    double *weight = bake_alloc(2 * (size_t)k->bone_count, sizeof *weight);
    double *end = weight + k->bone_count;
    rig_pose(rig, value, bones);
    for (int i = 0; i < k->vertex_count; i++) {
        if (stored) {
            stored_row(k, &k->stored[i], weight, end);
        } else {
            exact_row(k, i, weight, end);
        }
        const double point[3] = {rest[3 * i], rest[3 * i + 1], rest[3 * i + 2]};
        rig_skin(rig, bones, weight, k->end ? end : NULL, point, out + 3 * i);
    }
    free(weight);
    free(bones);
}

/* ---- choice ----------------------------------------------------------------------------------- */

/* All numbers of influences up to what the rig allows: [count - 1][vertex]. */
typedef struct {
    int most;
    influence *of[INFLUENCES_MAX];
    double *far[INFLUENCES_MAX]; /* largest distance in any pose */
    double *dim[INFLUENCES_MAX]; /* largest difference in brightness, 1 is full; NULL: no paint */
} choice;

/* Four of 256 levels: rounding weights of a few bones takes one to three. */
static const double least_seen = 4.0 / 256;

/* What a vertex shows of its bones' values [SPEC 6.11]. */
static double brightness(const scene_rig *rig, const double *weight, const double *value)
{
    double sum = 0;
    for (int j = 0; j < rig->bone_count; j++) {
        int channel = rig->bones[j].value;
        sum += channel < 0 ? 0 : weight[j] * value[channel];
    }
    return fmax(0, fmin(1, sum));
}

/* Bones that move alike may show different values. */
static void measure_paint(const skin_work *w, const double *value, const choice *c)
{
    const skin *k = w->out;
    double *weight = bake_alloc(2 * (size_t)k->bone_count, sizeof *weight);
    double *end = weight + k->bone_count;
    for (int i = 0; i < k->vertex_count && c->dim[0] != NULL; i++) {
        exact_row(k, i, weight, end);
        double want = brightness(w->rig, weight, value);
        for (int n = 0; n < c->most; n++) {
            stored_row(k, &c->of[n][i], weight, end);
            c->dim[n][i] = fmax(c->dim[n][i], fabs(brightness(w->rig, weight, value) - want));
        }
    }
    free(weight);
}

/* What the mesh's shapes make of it before the bones move it: a vertex that is near a joint at rest
 * may be far from it then, and small weights count. */
static void blend(const shape_mesh *m, const double *value, double *out)
{
    size_t rows = 3 * (size_t)m->mesh.vertex_count;
    memcpy(out, m->mesh.rest, rows * sizeof *out);
    for (int j = 0; j < m->mesh.shape_count; j++) {
        const double *shape = m->mesh.shape + (size_t)j * rows;
        for (size_t i = 0; i < rows; i++) {
            out[i] += value[m->form.basis[j].channel] * (shape[i] - m->mesh.rest[i]);
        }
    }
}

static void measure_pose(skin_work *w, const double *value, choice *c)
{
    skin *k = w->out;
    size_t rows = 3 * (size_t)k->vertex_count;
    double *exact = bake_alloc(3 * rows, sizeof *exact), *stored = exact + rows;
    double *base = stored + rows;
    blend(w->m, value, base);
    skin_pose(w->rig, k, value, base, 0, exact);
    for (int n = 0; n < c->most; n++) {
        k->stored = c->of[n];
        skin_pose(w->rig, k, value, base, 1, stored);
        for (int i = 0; i < k->vertex_count; i++) {
            const double *a = exact + 3 * i, *b = stored + 3 * i;
            c->far[n][i] = fmax(c->far[n][i], hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
        }
    }
    k->stored = NULL;
    free(exact);
    measure_paint(w, value, c);
}

/* The fewest influences that nobody sees, or all. */
static void choose(skin *k, const choice *c)
{
    k->stored = bake_alloc((size_t)k->vertex_count, sizeof *k->stored);
    for (int i = 0; i < k->vertex_count; i++) {
        int n = 0;
        while (n < c->most - 1 &&
               (c->far[n][i] > k->tolerance || (c->dim[n] != NULL && c->dim[n][i] > least_seen))) {
            n++;
        }
        k->stored[i] = c->of[n][i];
        k->pruned = fmax(k->pruned, c->far[n][i]);
    }
}

/* ---- order ------------------------------------------------------------------------------------ */

static void permute_columns(double *at, const int *order, int rows, int columns)
{
    double *copy = bake_alloc((size_t)rows, sizeof *copy);
    for (int j = 0; at && j < columns; j++) {
        double *column = at + (size_t)j * (size_t)rows;
        memcpy(copy, column, (size_t)rows * sizeof *copy);
        for (int i = 0; i < rows; i++) {
            column[i] = copy[order[i]];
        }
    }
    free(copy);
}

/* Vertices with as many influences together, so that a span says the number once. */
static void sort(skin_work *w)
{
    skin *k = w->out;
    int n = k->vertex_count, next = 0, *order = bake_alloc((size_t)n, sizeof *order);
    influence *copy = bake_alloc((size_t)n, sizeof *copy);
    for (int count = 1; count <= INFLUENCES_MAX; count++) {
        for (int i = 0; i < n; i++) {
            if (k->stored[i].count == count) {
                order[next++] = i;
            }
        }
    }
    memcpy(copy, k->stored, (size_t)n * sizeof *copy);
    for (int i = 0; i < n; i++) {
        k->stored[i] = copy[order[i]];
    }
    shape_reorder(&w->m->mesh, order);
    shape_form_reorder(&w->m->form, order);
    permute_columns(k->weight, order, n, k->bone_count);
    permute_columns(k->end, order, n, k->bone_count);
    free(copy);
    free(order);
}

/* ---- along bones ------------------------------------------------------------------------------ */

/* The largest distance of a vertex from where a bone that moves it starts, in one pose, as far as the
 * bone's stretch carries it. at: the mesh before the bones. */
static double reach_along(const skin_work *w, const rig_bone *bones, const double *at)
{
    const skin *k = w->out;
    double far = 0;
    for (int i = 0; i < k->vertex_count; i++) {
        const influence *v = &k->stored[i];
        for (int j = 0; j < v->count; j++) {
            const double *o = w->rig->bones[v->bone[j]].from, *x = at + 3 * i;
            double way = hypot(hypot(x[0] - o[0], x[1] - o[1]), x[2] - o[2]);
            far = fmax(far, way + fabs(bones[v->bone[j]].stretch) * influence_end(v, j));
        }
    }
    return far;
}

/* What endpoint weights need: places along bones, in pairs of raw units, have 16 bits (SPEC 6.10). */
static double farthest_along(const skin_work *w)
{
    const skin_poses *p = &w->out->poses;
    rig_bone *bones = bake_alloc((size_t)w->out->bone_count, sizeof *bones);
    double *at = bake_alloc(3 * (size_t)w->out->vertex_count, sizeof *at), far = 0;
    for (int i = 0; i < p->count; i++) {
        const double *value = p->value + (size_t)i * (size_t)p->channels;
        rig_pose(w->rig, value, bones);
        blend(w->m, value, at);
        far = fmax(far, reach_along(w, bones, at));
    }
    free(at);
    free(bones);
    return far;
}

/* Places of bones fit their records (SPEC 4.18), and o of 6.10 times 2^6 its 32 bits. */
static int places_fit(const skin_work *w, int frac)
{
    int good = 1;
    for (int i = 0; i < 3 * w->rig->bone_count; i++) {
        double x = w->rig->bones[i / 3].from[i % 3], o = x - w->m->form.origin[i % 3];
        good = good && ldexp(fabs(x), frac + (int)WG_POSE_BITS) < (double)WG_BONE_PLACE &&
               ldexp(fabs(o), frac + (int)WG_POSE_BITS) < (double)(1L << 25);
    }
    return good;
}

/* A coarser unit of the shape where bones need it. */
static void make_room(skin_work *w)
{
    double far = w->out->end ? farthest_along(w) : 0;
    shape_form *form = &w->m->form;
    int frac = form->frac;
    while (frac > (int)WG_SHAPE_FRAC_MIN &&
           (ldexp(far, frac - 1) > 32000 || !places_fit(w, frac))) {
        frac--;
    }
    if (frac < form->frac) {
        form->frac = frac;
        for (int k = 0; k < 3; k++) { /* whole units again */
            form->origin[k] = ldexp(floor(ldexp(form->origin[k], frac) + 0.5), -frac);
        }
        free(form->rest);
        shape_round_rest(form, w->m->mesh.rest);
    }
}

/* What the player keeps a stretch in (SPEC 6.9). */
#define STRETCH_MOST 9

static void warn_stretch(const skin_work *w)
{
    const skin_poses *p = &w->out->poses;
    for (int b = 0; b < w->rig->bone_count; b++) {
        const scene_bone *bone = &w->rig->bones[b];
        for (int k = 0; k < bone->joint_count; k++) {
            double lo = 1, hi = 1;
            for (int i = 0; i < p->own && bone->joints[k].kind == (int)WG_JOINT_STRETCH; i++) {
                double v = p->value[i * p->channels + bone->joints[k].channel];
                lo = fmin(lo, v);
                hi = fmax(hi, v);
            }
            if (lo < 0 || hi > STRETCH_MOST) {
                fprintf(stderr,
                        "%s:%d: rig %s: warning: %s is stretched to %.3g .. %.3g of its length, of "
                        "which the player keeps 0 .. %d; a wiggly curve swings about 0 unless its "
                        "`force` moves that\n",
                        w->s->path, bone->line, w->rig->name, bone->name, lo, hi, STRETCH_MOST);
            }
        }
    }
}

/* Some of the poses, for views to be fitted to. */
#define SHOWN 32

static void show(skin_work *w)
{
    const skin_poses *p = &w->out->poses;
    int count = p->own < SHOWN ? p->own : SHOWN;
    size_t rows = 3 * (size_t)w->out->vertex_count;
    w->m->shown = bake_alloc((size_t)count * rows + 1, sizeof *w->m->shown);
    w->m->shown_count = count;
    for (int i = 0; i < count; i++) {
        int pose = count > 1 ? i * (p->own - 1) / (count - 1) : 0;
        skin_pose(w->rig, w->out, p->value + (size_t)pose * (size_t)p->channels, w->m->mesh.rest, 1,
                  w->m->shown + (size_t)i * rows);
    }
}

int skin_prune(skin_work *w, bake_error *error)
{
    skin *k = w->out;
    const int size[2] = {k->vertex_count, k->bone_count};
    choice c = {.most = w->rig->influences};
    int err = make_poses(w->s, w->rig, &k->poses, error);
    for (int n = 0; n < c.most && err == 0; n++) {
        c.of[n] = bake_alloc((size_t)k->vertex_count, sizeof *c.of[n]);
        c.far[n] = bake_alloc((size_t)k->vertex_count, sizeof *c.far[n]);
        c.dim[n] = w->rig->paint ? bake_alloc((size_t)k->vertex_count, sizeof *c.dim[n]) : NULL;
        err = influence_make(k->weight, k->end, size, n + 1, c.of[n], error);
    }
    for (int i = 0; i < k->poses.count && err == 0; i++) {
        measure_pose(w, k->poses.value + (size_t)i * (size_t)k->poses.channels, &c);
    }
    if (err == 0) {
        choose(k, &c);
        if (w->m->form.basis_count == 0) {
            sort(w);
        }
        make_room(w);
        warn_stretch(w);
        show(w);
    }
    for (int n = 0; n < c.most; n++) {
        free(c.of[n]);
        free(c.far[n]);
        free(c.dim[n]);
    }
    return err;
}
