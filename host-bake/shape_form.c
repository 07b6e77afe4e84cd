/* Rest and bases as the integers of the file.
 * Source: own; SPEC 4.13-4.15, 6.8.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* p of SPEC 6.8 is 16 bits; the sum of rounded weights and entries may pass it by a few units. */
#define LARGEST 32700.0

/* Vertices end up below 2^31 in 1/256 raw units: half of that for |origin| 2^8, a quarter for the
 * affine part's translation, which saturates at 2^30. */
#define ORIGIN_BITS    22
#define TRANSLATE_BITS 21

void shape_scale(shape_form *form, const double lo[3], const double hi[3], double way)
{
    double half = 0, far = 0;
    for (int k = 0; k < 3; k++) {
        form->origin[k] = (lo[k] + hi[k]) / 2;
        half = fmax(half, (hi[k] - lo[k]) / 2);
        far = fmax(far, fabs(form->origin[k]));
    }
    double frac = floor(log2(LARGEST / fmax(half, 1e-12)));
    frac = fmin(frac, way > 0 ? TRANSLATE_BITS - ceil(log2(way)) : 100);
    frac = fmin(frac, way <= 0 && far > 0 ? ORIGIN_BITS - ceil(log2(far)) : 100);
    frac = fmin(frac, WG_SHAPE_FRAC_MAX);
    form->frac = (int)fmax(frac, WG_SHAPE_FRAC_MIN);
    for (int k = 0; k < 3; k++) {
        form->origin[k] = ldexp(floor(ldexp(form->origin[k], form->frac) + 0.5), -form->frac);
    }
}

void shape_round_rest(shape_form *form, const double *rest)
{
    int rows = 3 * form->vertex_count;
    form->rest = bake_alloc((size_t)rows, sizeof *form->rest);
    for (int i = 0; i < rows; i++) {
        double raw = floor(ldexp(rest[i] - form->origin[i % 3], form->frac) + 0.5);
        form->rest[i] = (int16_t)fmax(-32767, fmin(32767, raw));
    }
}

void shape_form_eval(const shape_form *form, const double *value, int bases, double *y)
{
    int rows = 3 * form->vertex_count;
    for (int i = 0; i < rows; i++) {
        y[i] = form->origin[i % 3] + ldexp(form->rest[i], -form->frac);
    }
    for (int j = 0; j < bases && j < form->basis_count; j++) {
        const shape_basis *b = &form->basis[j];
        for (int i = 0; i < rows; i++) {
            y[i] += value[j] * b->scale * shape_entry(form->bits, b->entry[i]);
        }
    }
}

void shape_form_free(shape_form *form)
{
    for (int j = 0; j < form->basis_count; j++) {
        free(form->basis[j].entry);
        free(form->basis[j].weight);
    }
    free(form->basis);
    free(form->block);
    free(form->rest);
    memset(form, 0, sizeof *form);
}

int shape_basis_bits(const shape_form *form, int basis)
{
    int bits = form->bits;
    for (int i = 0; i < 3 * form->vertex_count && bits == 8; i++) {
        bits = form->basis[basis].entry[i] % 256 != 0 ? 16 : 8;
    }
    return bits;
}

/* A track's own record, a run's and its last knot; knots of 4 bytes, their times being shared by the
 * tracks of a clip. What does not change takes a HELD run. */
#define TRACK_BYTES 30
#define KNOT_BYTES  4

static size_t track_bytes(const shape_mesh *m, const double *value, int stride)
{
    size_t total = 0;
    for (int i = 0, f = 0; i < m->mesh.frames_count; f += m->mesh.frames[i++].count) {
        size_t n = (size_t)m->mesh.frames[i].count, moving = 0;
        for (size_t j = 1; j < n; j++) {
            moving += value[((size_t)f + j) * (size_t)stride] !=
                      value[((size_t)f + j - 1) * (size_t)stride];
        }
        total += TRACK_BYTES + KNOT_BYTES * (moving + 1);
    }
    return total;
}

size_t shape_estimate(const shape_mesh *m, const shape_mesh *way)
{
    const shape_form *form = &way->form;
    size_t moving = 0, total = 0;
    for (int i = 0; i < form->vertex_count; i++) {
        int moves = 0;
        for (int j = 0; j < form->basis_count && !moves; j++) {
            const int16_t *e = form->basis[j].entry + 3 * i;
            moves = e[0] || e[1] || e[2];
        }
        moving += (size_t)moves;
    }
    for (int j = 0; j < form->basis_count; j++) {
        size_t bits = (size_t)shape_basis_bits(form, j);
        total += WG_BASIS_BYTES + WG_BLOCK_BYTES / 2 + moving * 3 * bits / 8;
        total += WG_CHANNEL_BYTES + track_bytes(m, form->basis[j].weight, 1);
    }
    for (int i = 0; way->turn && i < (int)WG_AFFINE_CHANNELS; i++) {
        const double *first = &way->turn[0].A[0] + i;
        total += WG_CHANNEL_BYTES + track_bytes(m, first, (int)(sizeof *way->turn / sizeof *first));
    }
    return total + 1;
}
