/* A mesh with additive base shapes, or one that does not deform.
 * Source: Alexa 2002, 7.1.1: V = V_0 + sum of r_i (V_i - V_0), r_i a channel of the scene. No affine
 * normalisation: the sum of two shapes must be the sum of their differences.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a channel may be: from 0 to 1, and what its range and its keys say beyond. */
static void reach(const scene *s, int channel, double *lo, double *hi)
{
    const scene_channel *c = &s->channels[channel];
    *lo = fmin(0, fmin(c->rest, c->range[0]));
    *hi = fmax(1, fmax(c->rest, c->range[1]));
    for (int i = 0; i < s->clip_count; i++) {
        for (int j = 0; j < s->clips[i].curve_count; j++) {
            const scene_curve *curve = &s->clips[i].curves[j];
            for (int k = 0; k < curve->key_count && curve->channel == channel; k++) {
                if (curve->keys[k].weight[0] != 0) {
                    *lo = fmin(*lo, curve->keys[k].target[0]);
                    *hi = fmax(*hi, curve->keys[k].target[0]);
                }
            }
        }
    }
}

/* Differences from rest; those too small to see are none, so that the vertex stands outside. */
static double *differences(const shape_mesh *m, double still)
{
    int rows = 3 * m->mesh.vertex_count;
    double *d = bake_alloc((size_t)m->mesh.shape_count * (size_t)rows + 1, sizeof *d);
    for (int j = 0; j < m->mesh.shape_count; j++) {
        const double *to = m->mesh.shape + (size_t)j * (size_t)rows;
        double *out = d + (size_t)j * (size_t)rows;
        for (int i = 0; i < rows; i += 3) {
            double square = 0;
            for (int k = i; k < i + 3; k++) {
                out[k] = to[k] - m->mesh.rest[k];
                square += out[k] * out[k];
            }
            for (int k = i; k < i + 3 && square <= still * still; k++) {
                out[k] = 0;
            }
        }
    }
    return d;
}

/* The box of everything that the channels' reach allows. */
static void widest(const scene *s, const shape_mesh *m, const double *d, double box[2][3])
{
    const scene_mesh *from = &s->meshes[m->index];
    int rows = 3 * m->mesh.vertex_count;
    for (int i = 0; i < rows; i++) {
        double at[2] = {m->mesh.rest[i], m->mesh.rest[i]};
        for (int j = 0; j < m->mesh.shape_count; j++) {
            double lo, hi, e = d[(size_t)j * (size_t)rows + (size_t)i];
            reach(s, from->shapes[j].channel, &lo, &hi);
            at[0] += fmin(lo * e, hi * e);
            at[1] += fmax(lo * e, hi * e);
        }
        box[0][i % 3] = i < 3 ? at[0] : fmin(box[0][i % 3], at[0]);
        box[1][i % 3] = i < 3 ? at[1] : fmax(box[1][i % 3], at[1]);
    }
}

static void make_bases(const scene *s, const shape_mesh *m, const double *d, shape_form *form)
{
    int rows = 3 * m->mesh.vertex_count;
    form->basis_count = m->mesh.shape_count;
    form->basis = bake_alloc((size_t)form->basis_count + 1, sizeof *form->basis);
    for (int j = 0; j < form->basis_count; j++) {
        shape_basis *b = &form->basis[j];
        b->channel = s->meshes[m->index].shapes[j].channel;
        b->piece = -1;
        b->entry = bake_alloc((size_t)rows, sizeof *b->entry);
        b->scale = shape_quantise(d + (size_t)j * (size_t)rows, rows, form->bits, b->entry);
    }
}

/* Largest distance when all shapes are lost by their rounding at once, with channels at 1. */
static double left(const shape_mesh *m, const shape_form *form, const double *d)
{
    int rows = 3 * m->mesh.vertex_count;
    double worst = 0;
    for (int i = 0; i < rows; i += 3) {
        double sum = ldexp(0.866, -form->frac); /* rest, rounded to half a unit in each axis */
        for (int j = 0; j < form->basis_count; j++) {
            const shape_basis *b = &form->basis[j];
            double square = 0;
            for (int k = i; k < i + 3; k++) {
                double e = b->scale * shape_entry(form->bits, b->entry[k]) -
                           d[(size_t)j * (size_t)rows + (size_t)k];
                square += e * e;
            }
            sum += sqrt(square);
        }
        worst = fmax(worst, sum);
    }
    return worst;
}

/* |w| of SPEC 6.8 stays within 16 bits over the channels' reach. */
static int weights_fit(const scene *s, const shape_form *form)
{
    for (int j = 0; j < form->basis_count; j++) {
        double lo, hi;
        reach(s, form->basis[j].channel, &lo, &hi);
        if (ldexp(fmax(-lo, hi) * form->basis[j].scale, form->frac) > 32000) {
            return 0;
        }
    }
    return 1;
}

void shape_solve_shapes(const scene *s, shape_mesh *m)
{
    const scene_mesh *from = &s->meshes[m->index];
    double box[2][3], size = 0;
    double *d = differences(m, 0);
    widest(s, m, d, box);
    for (int k = 0; k < 3; k++) {
        size += (box[1][k] - box[0][k]) * (box[1][k] - box[0][k]);
    }
    m->tolerance = from->tolerance > 0 ? from->tolerance : sqrt(size) / 500;
    free(d);
    d = differences(m, m->aim.bases * m->tolerance / (16 * fmax(1, m->mesh.shape_count)));
    for (int bits = from->bits == 16 ? 16 : 8; bits <= (from->bits == 8 ? 8 : 16); bits += 8) {
        shape_form_free(&m->form);
        m->form.vertex_count = m->mesh.vertex_count;
        m->form.bits = bits;
        m->form.affine = -1;
        shape_scale(&m->form, box[0], box[1], 0);
        make_bases(s, m, d, &m->form);
        while (!weights_fit(s, &m->form) && m->form.frac > (int)WG_SHAPE_FRAC_MIN) {
            m->form.frac--;
        }
        shape_round_rest(&m->form, m->mesh.rest);
        m->left = left(m, &m->form, d);
        if (m->left <= m->aim.bases * m->tolerance) {
            break;
        }
    }
    shape_order_vertices(m, 1);
    shape_make_blocks(&m->form);
    free(d);
}
