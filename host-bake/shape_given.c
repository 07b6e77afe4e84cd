/* A mesh whose bases are known: the modes of an elastic body, moved by curves that are known too.
 * Source: own, on Schulz 2013, 2.6: x(t) = x + Phi w(t) is a shape in the sense of Alexa 2002,
 * 7.1.1. What is left to decide is how wide each basis is stored.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of what the bases may leave: rounding to 8 bits may take so much if all of it met in one
 * vertex. */
#define NARROW_SHARE 0.5

static double largest_weight(const shape_mesh *m, int basis)
{
    double most = 0;
    for (int f = 0; f < m->frame_count; f++) {
        size_t at = (size_t)basis * (size_t)m->frame_count + (size_t)f;
        most = fmax(most, fabs(m->given_weight[at]));
    }
    return most;
}

/* wide[j]: basis j takes 16 bits. Those that move least are rounded most. */
static void choose_widths(const shape_mesh *m, int bits, double limit, char *wide)
{
    int count = m->given->count;
    double *most = bake_alloc((size_t)count + 1, sizeof *most), spent = 0;
    for (int j = 0; j < count; j++) {
        most[j] = largest_weight(m, j);
        wide[j] = bits != 8;
    }
    for (int i = 0; i < count && bits == 0; i++) {
        int least = -1;
        for (int j = 0; j < count; j++) {
            least = wide[j] && (least < 0 || most[j] < most[least]) ? j : least;
        }
        spent += most[least] * sqrt(3) / 254; /* half a step of 127 in each axis */
        if (spent > NARROW_SHARE * limit) {
            break;
        }
        wide[least] = 0;
    }
    free(most);
}

static void make_bases(shape_mesh *m, int bits, double limit)
{
    size_t rows = 3 * (size_t)m->mesh.vertex_count, n = (size_t)m->frame_count;
    shape_form *form = &m->form;
    char *wide = bake_alloc((size_t)m->given->count + 1, 1);
    choose_widths(m, bits, limit, wide);
    form->bits = bits == 16 ? 16 : 8;
    form->basis_count = m->given->count;
    form->basis = bake_alloc((size_t)form->basis_count + 1, sizeof *form->basis);
    for (int j = 0; j < form->basis_count; j++) {
        shape_basis *b = &form->basis[j];
        const double *vector = m->given_basis + rows * (size_t)j;
        b->piece = -1;
        b->given = j;
        b->entry = bake_alloc(rows, sizeof *b->entry);
        b->scale = bits == 16 ? shape_quantise(vector, (int)rows, 16, b->entry)
                              : shape_quantise_mixed(vector, (int)rows, wide[j], b->entry);
        b->weight = bake_alloc(n, sizeof *b->weight);
        memcpy(b->weight, m->given_weight + n * (size_t)j, n * sizeof *b->weight);
    }
    free(wide);
}

/* The largest |w| of SPEC 6.8. */
static double most_raw(const shape_mesh *m)
{
    double most = 0;
    for (int j = 0; j < m->form.basis_count; j++) {
        most = fmax(most, m->form.basis[j].scale * largest_weight(m, m->form.basis[j].given));
    }
    return ldexp(most, m->form.frac);
}

static double left(const shape_mesh *m)
{
    const shape_form *form = &m->form;
    size_t rows = 3 * (size_t)m->mesh.vertex_count;
    double *y = bake_alloc(rows, sizeof *y), worst = 0;
    double *value = bake_alloc((size_t)form->basis_count + 1, sizeof *value);
    for (int f = 0; f < m->frame_count; f++) {
        for (int j = 0; j < form->basis_count; j++) {
            value[j] = form->basis[j].weight[f];
        }
        shape_form_eval(form, value, form->basis_count, y);
        for (size_t i = 0; i < rows; i += 3) {
            const double *x = m->frame[f] + i;
            double d[3] = {y[i] - x[0], y[i + 1] - x[1], y[i + 2] - x[2]};
            worst = fmax(worst, shape_distance(NULL, d));
        }
    }
    free(y);
    free(value);
    return worst;
}

int shape_solve_given(const scene *s, shape_mesh *m, bake_error *error)
{
    const scene_mesh *from = &s->meshes[m->index];
    double lo[3], hi[3];
    if (shape_stack(s, m, error) < 0) {
        return -1;
    }
    m->form.vertex_count = m->mesh.vertex_count;
    m->form.affine = -1;
    shape_reach(m->frame, m, lo, hi);
    for (int k = 0; k < 3; k++) {
        lo[k] -= m->tolerance;
        hi[k] += m->tolerance;
    }
    shape_scale(&m->form, lo, hi, 0);
    make_bases(m, from->bits, m->aim.bases * m->tolerance);
    while (most_raw(m) > 32000 && m->form.frac > (int)WG_SHAPE_FRAC_MIN) {
        m->form.frac--;
    }
    shape_round_rest(&m->form, m->mesh.rest);
    m->left = left(m);
    shape_order_bases(m, &m->form);
    shape_order_vertices(m, 0);
    shape_make_blocks(&m->form);
    return 0;
}
