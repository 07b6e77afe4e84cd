/* Coupling: each key's model rules from one switch to the next, C2 across switches and keys.
 * Source: Schulz 2013, 2.8.2; errata S8, S9. Own: values and velocities at knots are the unknowns,
 * not 4 coefficients a segment (C1 by construction); a model has a knot at its key too, where C2 is
 * a condition as well: a velocity there moves the accelerations at the switches, so that the
 * minimum alone would not have it. Each gap's switch is eliminated first (spacetime_gap.c); what
 * the keys share is banded. SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spacetime_gap.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Reciprocal condition of equilibrated systems: below, no digit is left. */
#define CONDITION_LIMIT 1e-15
/* Of equations with rows and columns of norm 1, relative to their largest term. */
#define EQUATION_LIMIT  1e-10
/* Of C2, relative to the terms of an acceleration. */
#define RESIDUAL_LIMIT  1e-8

typedef struct {
    const motion_input *in;
    motion *out;
    int d, loop;
    int gaps, nodes, size, band; /* of the system: velocity and multipliers of each node, 2 d */
    gap *gap;
    double *c; /* (gaps + 1) x d: poses in their own models' coordinates */
    double *matrix, *right;
    char *fixed;
    double worst; /* reciprocal condition */
} coupling;

/* ---- the system of the keys ------------------------------------------------------------------ */

/* A loop's keys are folded (0, last, 1, last - 1, ...), so that neighbours stay within two. */
static int unknown(const coupling *s, int key)
{
    int node = s->loop ? key % s->nodes : key;
    if (s->loop)
        node = 2 * node < s->nodes ? 2 * node : 2 * (s->nodes - node) - 1;
    return 2 * s->d * node;
}

static void add(const coupling *s, int row, int column, double value)
{
    if (!s->fixed[row])
        s->matrix[(size_t)column * (size_t)(2 * s->band + 1) + (size_t)(s->band + row - column)] +=
            value;
}

static int fix(const coupling *s, int row, double value)
{
    if (s->fixed[row])
        return fabs(s->right[row] - value) > 1e-12 * fabs(value);
    s->fixed[row] = 1;
    s->matrix[(size_t)row * (size_t)(2 * s->band + 1) + (size_t)s->band] = 1.0;
    s->right[row] = value;
    return 0;
}

static int joins(const coupling *s, int key)
{
    return s->loop || (key > 0 && key < s->gaps);
}

/* Prescribed velocities of one key and, where there are none, its multipliers. */
static int fix_key(const coupling *s, int k, bake_error *error)
{
    const space_settings *settings = s->in->settings;
    const space_key *key = &s->in->keys[k];
    const linear_model *model = s->out->term[k].model;
    int end = k > 0, failed = 0;
    int at_end = (k == 0 || k == s->gaps) && settings->end[end] == BAKE_END_VELOCITY;
    const double *v = settings->end_v[end];
    for (int i = 0; i < s->d; i++) {
        int row = unknown(s, k) + i;
        if (key->v && key->weight[1] < 0.0)
            failed |= fix(s, row, motion_project(model, i, key->v));
        if (at_end)
            failed |= fix(s, row, v ? motion_project(model, i, v) : 0.0);
        if (!joins(s, k))
            fix(s, row + s->d, 0.0);
    }
    return failed ? bake_fail(error, "the velocity at %.6g s is prescribed twice", key->time) : 0;
}

static void add_soft(const coupling *s)
{
    for (int k = 0; k <= s->gaps; k++) {
        const space_key *key = &s->in->keys[k];
        for (int i = 0; i < s->d && key->v && key->weight[1] > 0.0; i++) {
            int row = unknown(s, k) + i;
            add(s, row, row, key->weight[1]);
            if (!s->fixed[row])
                s->right[row] += key->weight[1] * motion_project(s->out->term[k].model, i, key->v);
        }
    }
}

static void add_gap(const coupling *s, int g, const double *rest)
{
    int m = 4 * s->d, width = 2 * s->d;
    for (int i = 0; i < m; i++) {
        int row = unknown(s, g + i / width) + i % width;
        if (!s->fixed[row])
            s->right[row] += rest[(size_t)m * (size_t)m + (size_t)i];
        for (int j = 0; j < m; j++)
            add(s, row, unknown(s, g + j / width) + j % width,
                rest[(size_t)j * (size_t)m + (size_t)i]);
    }
}

static int eliminate(coupling *s, bake_error *error)
{
    size_t m = 4 * (size_t)s->d;
    double *rest = bake_alloc(m * (m + 1), sizeof *rest), condition = 0.0;
    int failed = 0;
    for (int g = 0; g < s->gaps && !failed; g++) {
        gap_prepare(&s->gap[g], g ? &s->gap[g - 1] : NULL);
        failed = gap_eliminate(&s->gap[g], rest, &condition);
        s->worst = fmin(s->worst, condition);
        if (failed || !(condition >= CONDITION_LIMIT))
            failed = bake_fail(error,
                               "the models of the keys at %.6g s and %.6g s cannot be coupled "
                               "(condition %.1e)",
                               s->gap[g].time[0], s->gap[g].time[1], condition);
        else
            add_gap(s, g, rest);
    }
    free(rest);
    return failed;
}

/* What is left of the equations as dgbsvx scaled them, against their terms; x loses its own scale.
 */
static double left_over(const coupling *s, char scaled, const double *columns, double *x)
{
    int n = s->size, band = s->band;
    double *r = bake_alloc((size_t)n, sizeof *r), terms = 1e-300, worst;
    for (int i = 0; i < n && (scaled == 'C' || scaled == 'B'); i++)
        x[i] /= columns[i];
    for (int i = 0; i < n; i++)
        terms = fmax(terms, fmax(fabs(x[i]), fabs(s->right[i])));
    memcpy(r, s->right, (size_t)n * sizeof *r);
    cblas_dgbmv(CblasColMajor, CblasNoTrans, n, n, band, band, -1.0, s->matrix, 2 * band + 1, x, 1,
                1.0, r, 1);
    worst = fabs(r[cblas_idamax(n, r, 1)]);
    free(r);
    return worst / terms;
}

static int solve(coupling *s)
{
    lapack_int n = s->size, band = s->band;
    size_t count = (size_t)n;
    double *factor = bake_alloc(count * (size_t)(3 * band + 1) + 3 * count, sizeof *factor);
    double *x = factor + count * (size_t)(3 * band + 1), *rows = x + n, *columns = rows + n;
    double condition = 0.0, forward = 0.0, backward = 0.0, growth = 0.0;
    lapack_int *pivot = bake_alloc(count, sizeof *pivot);
    char scaled = 'N';
    lapack_int info = LAPACKE_dgbsvx(
        LAPACK_COL_MAJOR, 'E', 'N', n, band, band, 1, s->matrix, 2 * band + 1, factor, 3 * band + 1,
        pivot, &scaled, rows, columns, s->right, n, x, n, &condition, &forward, &backward, &growth);
    memcpy(factor, x, count * sizeof *x);
    double left = left_over(s, scaled, columns, x);
    memcpy(s->right, factor, count * sizeof *x);
    s->worst = fmin(s->worst, condition);
    free(factor);
    free(pivot);
    return info != 0 || !(left <= EQUATION_LIMIT);
}

/* ---- the motion ------------------------------------------------------------------------------ */

static void take(const coupling *s)
{
    size_t width = 2 * (size_t)s->d;
    double *y = bake_alloc(2 * width, sizeof *y);
    for (int g = 0; g < s->gaps; g++) {
        for (int side = 0; side < 2; side++) {
            memcpy(y + (size_t)side * width, s->right + unknown(s, g + side), width * sizeof *y);
        }
        gap_finish(&s->gap[g], y);
        for (int i = 0; i < s->d; i++) {
            bake_curve *before = &s->out->term[g].curve[i], *after = &s->out->term[g + 1].curve[i];
            before->segment[before->count - 1] = s->gap[g].piece[0][i].segment;
            after->segment[0] = s->gap[g].piece[1][i].segment;
        }
    }
    free(y);
}

/* q'' at one end of piece `index` of the motion, two a gap; size: its largest term so far. */
static void acceleration(const coupling *s, int index, int end, double *q, double *size)
{
    const gap *g = &s->gap[index / 2];
    int side = index % 2;
    memset(q, 0, (size_t)s->d * sizeof *q);
    for (int i = 0; i < s->d; i++) {
        const bake_segment *segment = &g->piece[side][i].segment;
        double w[4], H = 0.5 * (segment->t1 - segment->t0);
        bake_segment_eval(segment, end ? segment->t1 : segment->t0, w);
        cblas_daxpy(s->d, w[2], g->model[side]->Phi + (size_t)i * (size_t)s->d, 1, q, 1);
        *size =
            fmax(*size, fabs(w[2]) + fabs(w[0]) * (1.0 / (H * H) + fabs(g->mode[side][i].lambda)));
    }
}

/* Largest jump of the acceleration at any knot against its terms. Values and velocities agree by
 * construction; that the energy is least is in the equations (left_over). */
static double residual(const coupling *s)
{
    int pieces = 2 * s->gaps;
    double *a = bake_alloc((size_t)(2 * s->d), sizeof *a), *b = a + s->d;
    double jump = 0.0, size = 1e-300;
    for (int index = s->loop ? 0 : 1; index < pieces; index++) {
        acceleration(s, index ? index - 1 : pieces - 1, 1, a, &size);
        acceleration(s, index, 0, b, &size);
        for (int i = 0; i < s->d; i++)
            jump = isnan(a[i] - b[i]) ? HUGE_VAL : fmax(jump, fabs(a[i] - b[i]));
    }
    free(a);
    return jump / size;
}

static void set_terms(const coupling *s, const linear_model *const *models)
{
    const space_key *keys = s->in->keys;
    for (int j = 0; j <= s->gaps; j++) {
        motion_term *term = &s->out->term[j];
        int again = s->loop && j == s->gaps;
        term->model = models[again ? 0 : j];
        for (int i = 0; i < s->d; i++) {
            term->mode[i] = motion_mode(term->model, s->in->settings, i);
            s->c[j * s->d + i] = motion_project(term->model, i, keys[again ? 0 : j].q);
            term->curve[i].count = j == 0 || j == s->gaps ? 1 : 2;
            term->curve[i].segment = bake_alloc(2, sizeof *term->curve[i].segment);
        }
        if (j < s->gaps)
            for (int i = 0; i < 2; i++)
                term->out[i] = term[1].in[i] = 0.5 * (keys[j].time + keys[j + 1].time);
    }
}

static void set_gaps(const coupling *s)
{
    for (int g = 0; g < s->gaps; g++) {
        s->gap[g].d = s->d;
        s->gap[g].regularise = s->in->settings->regularise;
        for (int side = 0; side < 2; side++) {
            s->gap[g].model[side] = s->out->term[g + side].model;
            s->gap[g].mode[side] = s->out->term[g + side].mode;
            s->gap[g].pose[side] = s->c + (g + side) * s->d;
            s->gap[g].time[side] = s->in->keys[g + side].time;
            s->gap[g].joins[side] = joins(s, g + side);
        }
    }
}

static void allocate(coupling *s)
{
    s->nodes = s->gaps + 1 - s->loop;
    s->size = 2 * s->d * s->nodes;
    s->band = 2 * s->d * (s->loop ? 3 : 2) - 1;
    if (s->band > s->size - 1)
        s->band = s->size - 1;
    size_t size = (size_t)s->size;
    s->gap = bake_alloc((size_t)s->gaps, sizeof *s->gap);
    s->c = bake_alloc((size_t)((s->gaps + 1) * s->d), sizeof *s->c);
    s->matrix = bake_alloc(size * (size_t)(2 * s->band + 1), sizeof *s->matrix);
    s->right = bake_alloc(size, sizeof *s->right);
    s->fixed = bake_alloc(size, 1);
    s->worst = 1.0;
}

static void release(coupling *s)
{
    for (int g = 0; g < s->gaps; g++)
        gap_free(&s->gap[g]);
    free(s->gap);
    free(s->c);
    free(s->matrix);
    free(s->right);
    free(s->fixed);
}

/* A velocity that is met exactly between poses leaves the acceleration there to what happens at the
 * switches, and damping hides them from it. */
static int fail_condition(const coupling *s, bake_error *error)
{
    for (int k = 1; k < s->gaps; k++)
        if (s->in->keys[k].v && s->in->keys[k].weight[1] < 0.0)
            return bake_fail(error,
                             "the velocity at %.6g s cannot be met without a jump in acceleration "
                             "(condition %.1e): give it a `velocity_weight`, less damping or fewer "
                             "modes, or use `blend`",
                             s->in->keys[k].time, s->worst);
    return bake_fail(error,
                     "these poses and ends barely determine the coupled motion (condition %.1e): "
                     "large vibrations fit the poses; prescribe velocities at the ends, add "
                     "damping, or change the times",
                     s->worst);
}

static int find_motion(coupling *s, bake_error *error)
{
    for (int k = 0; k <= s->gaps; k++)
        if (fix_key(s, k, error))
            return -1;
    if (eliminate(s, error))
        return -1;
    add_soft(s);
    if (solve(s) || !(s->worst >= CONDITION_LIMIT))
        return fail_condition(s, error);
    take(s);
    double left = residual(s);
    if (!(left <= RESIDUAL_LIMIT))
        return bake_fail(error, "the coupled solve left a residual of %.3g (limit %.0e)", left,
                         RESIDUAL_LIMIT);
    return 0;
}

int motion_couple(const linear_model *const *models, const motion_input *in, motion *out,
                  bake_error *error)
{
    int key_count = in->key_count;
    coupling s = {.in = in, .out = out, .d = models[0]->d, .gaps = key_count - 1};
    *out = (motion){0};
    if (motion_check(in, s.d, 1, error))
        return -1;
    motion_begin(in, s.d, key_count, out);
    s.loop = out->periodic;
    allocate(&s);
    set_terms(&s, models);
    set_gaps(&s);
    int failed = find_motion(&s, error);
    release(&s);
    if (failed) {
        motion_free(out);
        return -1;
    }
    if (error)
        error->text[0] = '\0';
    return 0;
}
