/* The certificate's meshes.
 * Source: own (DESIGN 1, promise 4); the thesis leaves the loss of its compression open (Alexa 2002,
 * 7.4).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_shapes.h"
#include "command.h"
#include "record.h"
#include "shape_parts.h"
#include "skins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STEP_US 20000u

/* A mesh being looked at. */
typedef struct {
    const build *b;
    const wg_file *file;
    const shape_mesh *m;
    int shape;      /* in the file */
    uint16_t bases; /* how many count */
    wg_pose pose;
    int16_t *weights;
    wg_skin skin;
    wg_bone *bones;
    int32_t *values; /* a channel: raw */
    int32_t *posed;
    double *truth;
    certificate_mesh *row;
    double sum; /* of squared distances */
    long count;
} look;

/* Which shape of the file holds the positions of mesh `index`. */
static int shape_of(const shapes *sh, int index)
{
    int shape = 0;
    for (int i = 0; i < index; i++) {
        shape += 1 + sh->mesh[i].has_normals;
    }
    return shape;
}

/* Poses l->values and measures against `truth`. */
static void compare(look *l, const double *truth, int clip, int frame, double when)
{
    int n = l->m->mesh.vertex_count, at_work = 0;
    wg_pose_set(&l->pose, l->values, l->bases, NULL);
    if (l->m->skin) {
        wg_skin_set(&l->skin, l->values, NULL);
        wg_skin_vertices(&l->skin, &l->pose, 0, (uint16_t)n, l->posed);
    } else {
        wg_pose_vertices(&l->pose, 0, (uint16_t)n, l->posed);
    }
    for (int i = 0; i < n; i++) {
        double square = 0;
        for (int k = 3 * i; k < 3 * i + 3; k++) {
            double e = ldexp(l->posed[k], -(l->pose.frac + (int)WG_POSE_BITS)) - truth[k];
            square += e * e;
        }
        l->sum += square;
        if (sqrt(square) > l->row->largest) {
            l->row->largest = sqrt(square);
            l->row->clip = clip;
            l->row->frame = frame;
            l->row->vertex = i;
            l->row->when = when;
        }
    }
    l->count += n;
    for (int j = 0; j < l->m->form.basis_count; j++) {
        at_work += l->weights[j] != 0;
    }
    l->row->at_work = at_work > l->row->at_work ? at_work : l->row->at_work;
}

static void look_at_frames(look *l)
{
    const mesh *m = &l->m->mesh;
    for (int i = 0, f = 0; i < m->frames_count; i++) {
        for (int j = 0; j < m->frames[i].count; j++, f++) {
            double when = shape_frame_time(&m->frames[i], j);
            wg_clip_sample(l->file, (uint8_t)m->frames[i].clip, (uint32_t)floor(when * 1e6 + 0.5),
                           l->values, NULL);
            compare(l, l->m->frame[f], m->frames[i].clip, j, when);
        }
    }
}

/* The bones as the player's channels have them, the weights as they were solved. */
static void skin_truth(look *l)
{
    const skin *k = l->m->skin;
    int count = l->b->scene->channel_count;
    double *value = bake_alloc((size_t)count, sizeof *value);
    for (int c = 0; c < count; c++) {
        value[c] = channel_unit(l->file, c, l->values[c]);
    }
    skin_pose(&l->b->scene->rigs[k->rig], k, value, l->truth, 0, l->truth);
    free(value);
}

/* rest + sum of channel values times differences [Alexa 7.1.1], of the values as the player has
 * them: what their curves lose is the channels' own row. Then the bones. */
static void additive_truth(look *l)
{
    const mesh *m = &l->m->mesh;
    size_t rows = 3 * (size_t)m->vertex_count;
    memcpy(l->truth, m->rest, rows * sizeof *l->truth);
    for (int j = 0; j < m->shape_count; j++) {
        int channel = l->m->form.basis[j].channel;
        double value = channel_unit(l->file, channel, l->values[channel]);
        for (size_t i = 0; i < rows; i++) {
            l->truth[i] += value * (m->shape[(size_t)j * rows + i] - m->rest[i]);
        }
    }
    if (l->m->skin) {
        skin_truth(l);
    }
}

static void set_shapes(look *l, int which)
{
    for (int j = 0; j < l->m->mesh.shape_count; j++) {
        int channel = l->m->form.basis[j].channel;
        double one = 1 / channel_unit(l->file, channel, 1); /* a power of two */
        l->values[channel] = which < 0 || which == j ? (int32_t)fmin(one, WG_VALUE_LIMIT) : 0;
    }
}

/* All shapes at 1, each, none, and all clips. */
static void look_at_shapes(look *l)
{
    int count = l->m->mesh.shape_count;
    const scene *s = l->b->scene;
    for (int which = -1; which <= count; which++) {
        set_shapes(l, which);
        additive_truth(l);
        compare(l, l->truth, -1, which, 0);
    }
    for (int i = 0; i < s->clip_count && (count > 0 || l->m->skin); i++) {
        uint32_t end = get32(clip_record(l->file, i) + WG_CLIP_US);
        for (uint32_t t = 0; t <= end && t / STEP_US < 100000u; t += STEP_US) {
            wg_clip_sample(l->file, (uint8_t)i, t, l->values, NULL);
            additive_truth(l);
            compare(l, l->truth, i, (int)(t / STEP_US), t * 1e-6);
        }
    }
}

/* The random poses that the skin was pruned for. */
static void look_at_random(look *l)
{
    const skin_poses *p = &l->m->skin->poses;
    for (int i = p->own; i < p->count; i++) {
        for (int c = 0; c < p->channels; c++) {
            double raw =
                ldexp(p->value[(size_t)i * (size_t)p->channels + (size_t)c], l->b->frac[c]);
            raw = fmax(-(double)WG_VALUE_LIMIT, fmin((double)WG_VALUE_LIMIT, raw));
            l->values[c] = (int32_t)floor(raw + 0.5);
        }
        additive_truth(l);
        compare(l, l->truth, CERTIFY_RANDOM, i, 0);
    }
}

static void look_open(const build *b, const wg_file *file, int index, look *l)
{
    size_t rows = 3 * (size_t)b->shapes->mesh[index].mesh.vertex_count;
    memset(l, 0, sizeof *l);
    l->b = b;
    l->file = file;
    l->m = &b->shapes->mesh[index];
    l->shape = shape_of(b->shapes, index);
    l->bases = WG_BASES_MAX;
    l->weights = bake_alloc(WG_BASES_MAX, sizeof *l->weights);
    l->values = bake_alloc((size_t)b->scene->channel_count, sizeof *l->values);
    l->posed = bake_alloc(rows, sizeof *l->posed);
    l->truth = bake_alloc(rows, sizeof *l->truth);
    for (int c = 0; c < b->scene->channel_count; c++) {
        l->values[c] = (int32_t)get32(record(file, WG_SECTION_CHANNELS, c, WG_CHANNEL_BYTES) +
                                      WG_CHANNEL_REST);
    }
    wg_pose_init(&l->pose, file, (uint8_t)l->shape, l->weights);
    if (l->m->skin) {
        l->bones = bake_alloc((size_t)l->m->skin->bone_count, sizeof *l->bones);
        wg_skin_init(&l->skin, file, (uint8_t)l->shape, l->bones);
    }
}

static void look_close(look *l)
{
    free(l->weights);
    free(l->bones);
    free(l->values);
    free(l->posed);
    free(l->truth);
}

static void look_at_all(look *l)
{
    l->row->largest = l->sum = 0;
    l->count = 0;
    if (l->m->frame_count > 0) {
        look_at_frames(l);
    } else {
        look_at_shapes(l);
    }
    if (l->m->skin) {
        look_at_random(l);
    }
    l->row->rms = sqrt(l->sum / (double)l->count);
}

/* ---- bytes ------------------------------------------------------------------------------------ */

/* Of the tracks of channels first .. first + count - 1. Times that several tracks share count once:
 * for the first one seen. */
static size_t track_bytes(const wg_file *file, const int *channel, int count)
{
    size_t total = 0;
    uint32_t seen[64];
    unsigned known = 0;
    for (int t = 0; t < file->section[WG_SECTION_TRACKS].count; t++) {
        const uint8_t *track = record(file, WG_SECTION_TRACKS, t, WG_TRACK_BYTES);
        int mine = 0;
        for (int i = 0; i < count; i++) {
            mine |= get16(track + WG_TRACK_CHANNEL) == channel[i];
        }
        for (int r = 0; mine && r < get16(track + WG_TRACK_RUN_COUNT); r++) {
            const uint8_t *run =
                record(file, WG_SECTION_RUNS, get16(track + WG_TRACK_RUN_FIRST) + r, WG_RUN_BYTES);
            size_t n = (size_t)get16(run + WG_RUN_SEGMENTS);
            uint32_t times = get32(run + WG_RUN_TIMES);
            int shared = 0;
            for (unsigned i = 0; i < known && i < 64; i++) {
                shared |= seen[i] == times;
            }
            seen[known++ % 64] = times;
            total += WG_RUN_BYTES + (shared ? 0 : 2 * n) +
                     (get8(run + WG_RUN_KIND) < (int)WG_KIND_CUBIC ? 2 : 4) * (n + 1);
        }
        total += mine ? WG_TRACK_BYTES : 0;
    }
    return total + WG_CHANNEL_BYTES * (size_t)count;
}

/* Of the first `bases` bases: entries, heads of blocks, records. A block of two bases counts half
 * for each. */
static size_t form_bytes(const shape_form *form, int bases)
{
    size_t total = WG_BASIS_BYTES * (size_t)bases;
    for (int i = 0; i < form->block_count; i++) {
        const shape_block *block = &form->block[i];
        size_t n = shape_block_bytes(form, block);
        int used = (block->a < bases) + (block->b >= 0 && block->b < bases);
        total += block->b < 0 ? n * (size_t)used : n * (size_t)used / 2;
    }
    return total;
}

static size_t weight_bytes(const wg_file *file, const shape_mesh *m, int bases)
{
    int channel[WG_BASES_MAX];
    for (int j = 0; j < bases; j++) {
        channel[j] = m->form.basis[j].channel;
    }
    return m->frame_count > 0 ? track_bytes(file, channel, bases) : 0;
}

static size_t fixed_bytes(const certificate_mesh *row)
{
    return row->rest_bytes + row->affine_bytes + row->triangle_bytes;
}

static void count_bytes(const wg_file *file, const shape_mesh *m, certificate_mesh *row)
{
    int channel[WG_AFFINE_CHANNELS];
    for (int i = 0; i < (int)WG_AFFINE_CHANNELS; i++) {
        channel[i] = m->form.affine + i;
    }
    size_t rest = WG_SHAPE_BYTES + 6 * (size_t)m->mesh.vertex_count;
    row->rest_bytes = rest;
    row->basis_bytes = form_bytes(&m->form, m->form.basis_count);
    row->weight_bytes = weight_bytes(file, m, m->form.basis_count);
    row->affine_bytes =
        m->form.affine >= 0 ? track_bytes(file, channel, (int)WG_AFFINE_CHANNELS) : 0;
    row->normal_bytes = m->has_normals ? rest + form_bytes(&m->normals, m->normals.basis_count) : 0;
    row->triangle_bytes = WG_PART_BYTES * (size_t)m->mesh.part_count +
                          WG_TRIANGLE_BYTES * (size_t)m->mesh.triangle_count;
}

/* ---- the rows --------------------------------------------------------------------------------- */

void certify_mesh(const build *b, const wg_file *file, int index, certificate_mesh *row)
{
    const shape_mesh *m = &b->shapes->mesh[index];
    look l;
    memset(row, 0, sizeof *row);
    row->mesh = m->index;
    row->vertices = m->mesh.vertex_count;
    row->triangles = m->mesh.triangle_count;
    row->bases = m->form.basis_count;
    row->bits = m->form.bits;
    row->affine = m->form.affine < 0 ? 0 : 1 + m->rotated;
    row->tolerance = m->tolerance;
    look_open(b, file, index, &l);
    l.row = row;
    look_at_all(&l);
    look_close(&l);
    count_bytes(file, m, row);
}

void certify_levels(const build *b, const wg_file *file, int index, certificate_mesh *row)
{
    const shape_mesh *m = &b->shapes->mesh[index];
    certificate_mesh scratch = *row;
    look l;
    look_open(b, file, index, &l);
    l.row = &scratch;
    row->level = bake_alloc((size_t)row->bases + 1, sizeof *row->level);
    for (int k = 0; k <= row->bases && m->frame_count > 0; k++) {
        l.bases = (uint16_t)k;
        look_at_all(&l);
        row->level[k] = (certificate_level){scratch.largest, scratch.rms, fixed_bytes(row)};
        row->level[k].bytes += form_bytes(&m->form, k) + weight_bytes(file, m, k);
        if (m->has_normals) {
            int normals = m->normals.basis_count < k ? m->normals.basis_count : k;
            row->level[k].bytes += WG_SHAPE_BYTES + 6 * (size_t)m->mesh.vertex_count +
                                   form_bytes(&m->normals, normals);
        }
    }
    look_close(&l);
}

void certificate_mesh_free(certificate_mesh *m)
{
    free(m->level);
    m->level = NULL;
}
