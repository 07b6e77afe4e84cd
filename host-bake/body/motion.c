/* A motion as a sum of faded terms: evaluation, energy, and the cubic it is compared with.
 * Source: Schulz 2013, 2.8, (2.37)-(2.39); errata S6, S7.
 *
 *   q    d      coordinates of the space
 *   c    d      decoupled coordinates of one term's model, q = Phi c
 *   Phi  d x d  column-major, orthogonal
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spacetime_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void motion_begin(const motion_input *in, int d, int term_count, motion *out)
{
    *out = (motion){.d = d, .term_count = term_count};
    out->from = in->keys[0].time;
    out->to = in->keys[in->key_count - 1].time;
    out->periodic = in->settings->end[0] == BAKE_END_PERIODIC;
    out->term = bake_alloc((size_t)term_count, sizeof *out->term);
    for (int j = 0; j < term_count; j++) {
        motion_term *term = &out->term[j];
        term->mode = bake_alloc((size_t)d, sizeof *term->mode);
        term->curve = bake_alloc((size_t)d, sizeof *term->curve);
        term->in[0] = term->in[1] = out->from;
        term->out[0] = term->out[1] = out->to;
    }
}

void motion_free(motion *m)
{
    for (int j = 0; j < m->term_count; j++) {
        for (int i = 0; i < m->d; i++)
            bake_curve_free(&m->term[j].curve[i]);
        free(m->term[j].curve);
        free(m->term[j].mode);
    }
    free(m->term);
    *m = (motion){0};
}

/* Erratum S7: 6 u^5 - 15 u^4 + 10 u^3, whose first two derivatives vanish at 0 and 1. Two fades
 * over one interval sum to 1 because one is 1 minus the other. */
static void add_fade(const double span[2], double t, double sign, double h[3])
{
    if (t < span[0])
        return;
    if (t >= span[1]) {
        h[0] += sign;
        return;
    }
    double length = span[1] - span[0], u = (t - span[0]) / length, r = 1.0 - u;
    h[0] += sign * u * u * u * (10.0 + u * (6.0 * u - 15.0));
    h[1] += sign * 30.0 * u * u * r * r / length;
    h[2] += sign * 60.0 * u * r * (r - u) / (length * length);
}

void motion_weight(const motion *m, const motion_term *term, double t, double h[3])
{
    h[0] = h[1] = h[2] = 0.0;
    add_fade(term->in, t, 1.0, h);
    if (term->out[0] < m->to)
        add_fade(term->out, t, -1.0, h);
}

/* h Phi c and its derivatives, added to out[0..2] where these are wanted. */
static void add_term(const motion *m, const motion_term *term, double t, double *const out[3])
{
    double h[3], c[4];
    int d = m->d;
    motion_weight(m, term, t, h);
    if (h[0] == 0.0 && h[1] == 0.0 && h[2] == 0.0)
        return;
    for (int i = 0; i < d; i++) {
        const double *column = term->model->Phi + (size_t)d * (size_t)i;
        bake_curve_eval(&term->curve[i], t, c);
        const double x[3] = {h[0] * c[0], h[1] * c[0] + h[0] * c[1],
                             h[2] * c[0] + 2.0 * h[1] * c[1] + h[0] * c[2]};
        for (int order = 0; order < 3; order++)
            for (int r = 0; out[order] && r < d; r++)
                out[order][r] += column[r] * x[order];
    }
}

void motion_eval(const motion *m, double t, double *q, double *v, double *a)
{
    double *const out[3] = {q, v, a};
    int outside = 0;
    for (int order = 0; order < 3; order++)
        if (out[order])
            memset(out[order], 0, (size_t)m->d * sizeof *q);
    if (m->periodic && (t < m->from || t > m->to)) {
        double period = m->to - m->from;
        t -= period * floor((t - m->from) / period);
    }
    if (t < m->from || t > m->to) {
        outside = 1;
        t = t < m->from ? m->from : m->to;
    }
    double *const still[3] = {q, NULL, NULL};
    for (int j = 0; j < m->term_count; j++)
        add_term(m, &m->term[j], t, outside ? still : out);
}

/* ---- energy ---------------------------------------------------------------------------------- */

typedef struct {
    const motion_gram *of;
    double *x; /* of->count: one function of each curve */
} gram_sum;

/* function: 5, of the segment's four functions and its particular solution */
static void add_products(const gram_sum *sum, const double function[5], double weight)
{
    const motion_gram *g = sum->of;
    for (int i = 0; i < g->count; i++) {
        sum->x[i] = 0.0;
        for (int k = 0; k < 5; k++)
            sum->x[i] += g->w[5 * i + k] * function[k];
    }
    for (int i = 0; i < g->count; i++)
        for (int j = 0; j < g->count; j++)
            g->gram[i * g->count + j] += weight * sum->x[i] * sum->x[j];
}

static void gram_visit(void *context, double s, double weight)
{
    const gram_sum *sum = context;
    const motion_gram *g = sum->of;
    double b[4][5], f[5];
    bake_segment_functions(g->segment, s, b);
    for (int i = 0; i < 5; i++)
        f[i] = b[2][i] + 2.0 * g->mode->delta * b[1][i] + g->mode->lambda * b[0][i];
    f[4] += g->mode->g;
    add_products(sum, f, weight);
    for (int order = 0; order < 3; order++)
        if (g->regularise[order] > 0.0)
            add_products(sum, b[order], weight * g->regularise[order]);
}

void motion_gram_add(const motion_gram *g)
{
    gram_sum sum = {g, bake_alloc((size_t)g->count, sizeof(double))};
    bake_segment_quadrature(g->segment, gram_visit, &sum);
    free(sum.x);
}

typedef struct {
    const motion *m;
    const motion_term *term;
    const bake_mode *mode;
    const bake_segment *segment;
    double middle, energy;
} force_sum;

static void force_visit(void *context, double s, double weight)
{
    force_sum *sum = context;
    double h[3], w[4], t = sum->middle + s;
    motion_weight(sum->m, sum->term, t, h);
    bake_segment_eval(sum->segment, t, w);
    double f = w[2] + 2.0 * sum->mode->delta * w[1] + sum->mode->lambda * w[0] + sum->mode->g;
    sum->energy += weight * h[0] * f * f;
}

/* The part of a segment between two places where h changes its polynomial. The rule's panels suit
 * the part as well: what is steep is steep at the ends of the segment, which it shares or lies away
 * from. */
static void integrate(force_sum *sum, double from, double to)
{
    bake_segment part = *sum->segment;
    part.t0 = from;
    part.t1 = to;
    sum->middle = 0.5 * (from + to);
    bake_segment_quadrature(&part, force_visit, sum);
}

/* Where h = 1: f'' - 2 delta f' + lambda f = 0, so that f^2 = f (y'' + 2 delta y' + lambda y), with
 * y = w + g/lambda, integrates by parts to what f y' - f' y + 2 delta f y gains. Its relative error
 * is 1e-16 terms/gain: refused above 1e-10, near free vibration and where g/lambda is large. */
static int gain(const force_sum *sum, double from, double to, double *energy)
{
    const bake_mode *m = sum->mode;
    double rest = m->g == 0.0 ? 0.0 : m->g / m->lambda, terms = 0.0;
    *energy = 0.0;
    for (int side = 0; side < 2; side++) {
        double w[4];
        bake_segment_eval(sum->segment, side ? to : from, w);
        double y = w[0] + rest, f = w[2] + 2.0 * m->delta * w[1] + m->lambda * y;
        double slope = w[3] + 2.0 * m->delta * w[2] + m->lambda * w[1];
        double size = fabs(w[2]) + fabs(2.0 * m->delta * w[1]) + fabs(m->lambda * y);
        double size_of_slope = fabs(w[3]) + fabs(2.0 * m->delta * w[2]) + fabs(m->lambda * w[1]);
        *energy += (side ? 1.0 : -1.0) * (f * w[1] - slope * y + 2.0 * m->delta * f * y);
        terms += size * (fabs(w[1]) + fabs(2.0 * m->delta * y)) + size_of_slope * fabs(y);
    }
    return isfinite(terms) && *energy > 1e-6 * terms;
}

/* solved: the curve obeys (2.22), which the cubic does not. */
static double mode_energy(const motion *m, const motion_term *term, int mode,
                          const bake_curve *curve, int solved)
{
    force_sum sum = {.m = m, .term = term, .mode = &term->mode[mode]};
    const double at[4] = {term->in[0], term->in[1], term->out[0], term->out[1]};
    for (int k = 0; k < curve->count; k++)
        for (int i = 0; i < 3; i++) {
            double from = fmax(at[i], curve->segment[k].t0), closed;
            double to = fmin(at[i + 1], curve->segment[k].t1);
            sum.segment = &curve->segment[k];
            if (!(from < to))
                continue;
            if (i == 1 && solved && gain(&sum, from, to, &closed))
                sum.energy += closed;
            else
                integrate(&sum, from, to);
        }
    return sum.energy;
}

double motion_energy(const motion *m)
{
    double total = 0.0;
    for (int j = 0; j < m->term_count; j++)
        for (int i = 0; i < m->d; i++)
            total += mode_energy(m, &m->term[j], i, &m->term[j].curve[i], 1);
    return total;
}

/* ---- the cubic ------------------------------------------------------------------------------- */

typedef struct {
    const motion_input *in;
    int d;
    const double *poses; /* key_count x d: the motion's own, where soft and partial keys took it */
} cubic_problem;

/* Component r of q of the C2 cubic through the motion's poses at the keys, with the hard velocities
 * and the ends that it was given. */
static int solve_cubic(const cubic_problem *c, int r, bake_curve *out, bake_error *error)
{
    const motion_input *in = c->in;
    bake_key *keys = bake_alloc((size_t)in->key_count, sizeof *keys);
    bake_spline_problem p = {.end = {in->settings->end[0], in->settings->end[1]}};
    int last = in->key_count - 1, loop = p.end[0] == BAKE_END_PERIODIC;
    for (int end = 0; end < 2; end++)
        if (in->settings->end_v[end])
            p.end_value[end] = in->settings->end_v[end][r];
    for (int k = 0; k <= last; k++) {
        const space_key *key = &in->keys[k];
        keys[k].time = key->time;
        keys[k].target[0] = c->poses[(loop && k == last ? 0 : k) * c->d + r];
        keys[k].weight[0] = BAKE_HARD;
        if (!key->v || key->weight[1] >= 0.0)
            continue;
        keys[k].target[1] = key->v[r];
        keys[k].weight[1] = BAKE_HARD;
    }
    int failed = bake_spline_solve(&p, keys, in->key_count, out, NULL, error);
    free(keys);
    return failed;
}

/* Cubics are linear in their coefficients: c_i = sum_r Phi_ri q_r. */
static void turn_cubics(const linear_model *model, const bake_curve *q, bake_curve *c)
{
    int d = model->d, count = q[0].count;
    for (int i = 0; i < d; i++) {
        c[i].count = count;
        c[i].segment = bake_alloc((size_t)count, sizeof *c[i].segment);
        for (int k = 0; k < count; k++) {
            bake_segment *s = &c[i].segment[k];
            *s = q[0].segment[k];
            memset(s->w, 0, sizeof s->w);
            for (int r = 0; r < d; r++)
                for (int l = 0; l < 4; l++)
                    s->w[l] += model->Phi[(size_t)d * (size_t)i + (size_t)r] * q[r].segment[k].w[l];
        }
    }
}

static void free_curves(bake_curve *curves, int count)
{
    for (int i = 0; i < count; i++)
        bake_curve_free(&curves[i]);
    free(curves);
}

static double cubic_energy_of(const motion *m, const bake_curve *q)
{
    double total = 0.0;
    for (int j = 0; j < m->term_count; j++) {
        bake_curve *c = bake_alloc((size_t)m->d, sizeof *c);
        turn_cubics(m->term[j].model, q, c);
        for (int i = 0; i < m->d; i++)
            total += mode_energy(m, &m->term[j], i, &c[i], 0);
        free_curves(c, m->d);
    }
    return total;
}

int motion_cubic_energy(const motion *m, const motion_input *in, double *energy, bake_error *error)
{
    int d = m->d, failed = 0;
    double *poses = bake_alloc((size_t)(in->key_count * d), sizeof *poses);
    bake_curve *q = bake_alloc((size_t)d, sizeof *q);
    const cubic_problem c = {in, d, poses};
    for (int k = 0; k < in->key_count; k++)
        motion_eval(m, in->keys[k].time, poses + k * d, NULL, NULL);
    for (int r = 0; r < d && !failed; r++)
        failed = solve_cubic(&c, r, &q[r], error);
    if (!failed)
        *energy = cubic_energy_of(m, q);
    free_curves(q, d);
    free(poses);
    return failed;
}
