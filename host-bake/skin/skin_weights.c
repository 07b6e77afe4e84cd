/* Weights of a rig's handles on its domain, and from there on the mesh and on fields.
 * Source: Jacobson 2013, 4.3 (4.2)-(4.8), 4.3.3 (brush), 6.4 (endpoint weights).
 *
 *   W  domain vertices x handles, column by column
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "skin_parts.h"

#include "cache.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the domain's ----------------------------------------------------------------------------- */

/* The longest side of the box around the mesh, wherever it is. */
static double mesh_size(const mesh *m)
{
    double size = 0;
    for (int k = 0; k < 3; k++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (int i = 0; i < m->vertex_count; i++) {
            low = fmin(low, m->rest[3 * i + k]);
            high = fmax(high, m->rest[3 * i + k]);
        }
        size = fmax(size, high - low);
    }
    return size;
}

/* Vertices of the mesh in a list stand for those of the domain that carry them. */
static void brush_list(const skin_work *w, const scene_region *r, double rho, double *out)
{
    for (int i = 0; i < r->vertex_count && r->vertex[i] < w->m->mesh.vertex_count; i++) {
        const embedding *e = &w->at[r->vertex[i]];
        for (int k = 0; k < w->d.dimension + 1; k++) {
            if (e->weight[k] > 1e-9) {
                out[e->vertex[k]] = fmax(out[e->vertex[k]], rho);
            }
        }
    }
}

/* How stiff the brush is at every vertex: rho of [4.3.3], in 1 / size^2. The caller frees it. */
static double *make_brush(const skin_work *w)
{
    int n = w->d.vertex_count;
    double *rho = bake_alloc((size_t)n, sizeof *rho), size = mesh_size(&w->m->mesh);
    for (int b = 0; b < w->rig->brush_count; b++) {
        const scene_brush *p = &w->rig->brushes[b];
        double stiff = p->stiffness / (size * size);
        for (int i = 0; i < n && p->region.kind != REGION_VERTICES; i++) {
            rho[i] = skin_inside(&p->region, w->d.at + 3 * i) ? fmax(rho[i], stiff) : rho[i];
        }
        brush_list(w, &p->region, stiff, rho);
    }
    return rho;
}

static int brush(const skin_work *w, const double *length, sparse *q, bake_error *error)
{
    double *rho = make_brush(w);
    int err = w->rig->brush_count > 0 ? laplacian_brush(&w->d, length, rho, q, error) : 0;
    free(rho);
    return err;
}

static int energy(const skin_work *w, sparse *q, bake_error *error)
{
    sparse k = {0};
    double *length = bake_alloc(6 * (size_t)w->d.element_count, sizeof *length);
    double *mass = bake_alloc((size_t)w->d.vertex_count, sizeof *mass);
    int order = w->rig->weights == WEIGHTS_HARMONIC ? 1 : 2;
    laplacian_lengths(&w->d, length);
    int err = laplacian_make(&w->d, length, MASS_VORONOI, &k, mass, error);
    if (err == 0) {
        err = laplacian_energy(&k, mass, order, q, error);
    }
    if (err == 0) {
        err = brush(w, length, q, error);
    }
    sparse_free(&k);
    free(mass);
    free(length);
    return err;
}

static bounded_kind kind_of(const scene_rig *rig)
{
    return rig->weights == WEIGHTS_COUPLED   ? BOUNDED_COUPLED
           : rig->weights == WEIGHTS_BOUNDED ? BOUNDED_SEPARATE
                                             : BOUNDED_FREE;
}

static cache_key key_of(const skin_work *w)
{
    const domain *d = &w->d;
    cache_key key = cache_key_start("weights 1");
    cache_key_int(&key, d->dimension);
    cache_key_int(&key, d->vertex_count);
    cache_key_int(&key, d->element_count);
    cache_key_add(&key, d->at, 3 * (size_t)d->vertex_count * sizeof *d->at);
    cache_key_add(&key, d->element, (size_t)d->element_count * sizeof *d->element);
    if (d->lift) {
        cache_key_add(&key, d->lift, 3 * (size_t)d->vertex_count * sizeof *d->lift);
    }
    cache_key_int(&key, w->held.count);
    cache_key_int(&key, w->held.handle_count);
    cache_key_add(&key, w->held.vertex, (size_t)w->held.count * sizeof *w->held.vertex);
    cache_key_add(&key, w->held.value,
                  (size_t)w->held.count * (size_t)w->held.handle_count * sizeof *w->held.value);
    cache_key_int(&key, (int)w->rig->weights);
    if (w->rig->brush_count > 0) {
        double *rho = make_brush(w);
        cache_key_add(&key, rho, (size_t)d->vertex_count * sizeof *rho);
        free(rho);
    }
    return key;
}

/* Reports of all handles, then W. */
static int from_cache(skin_work *w, const cache_key *key, bounded_report *report)
{
    int n = w->d.vertex_count, m = w->h.count;
    size_t size = 0, of_w = (size_t)n * (size_t)m * sizeof *w->w;
    cache_blob blob = {.at = cache_load(key, &size)};
    if (blob.at == NULL) {
        return -1;
    }
    blob.count = size;
    int err = cache_take(&blob, report, (size_t)m * sizeof *report) < 0 ||
                      cache_take(&blob, w->w, of_w) < 0
                  ? -1
                  : 0;
    for (size_t i = 0; err == 0 && i < (size_t)n * (size_t)m; i++) {
        err = isfinite(w->w[i]) ? 0 : -1;
    }
    free(blob.at);
    return err;
}

static int solve(skin_work *w, bounded_report *report, bake_error *error)
{
    int n = w->d.vertex_count, m = w->h.count;
    cache_key key = key_of(w);
    if (from_cache(w, &key, report) == 0) {
        return 0;
    }
    const char **name = bake_alloc((size_t)m, sizeof *name);
    for (int i = 0; i < m; i++) {
        name[i] = w->handle[i].name;
    }
    sparse q = {0};
    int err = energy(w, &q, error);
    if (err == 0) {
        err = bounded_solve(&q, &w->held, kind_of(w->rig), name, w->w, report, error);
    }
    if (err == 0) {
        cache_blob blob = {0};
        cache_put(&blob, report, (size_t)m * sizeof *report);
        cache_put(&blob, w->w, (size_t)n * (size_t)m * sizeof *w->w);
        cache_store(&key, blob.at, blob.count);
        free(blob.at);
    }
    sparse_free(&q);
    free(name);
    return err;
}

/* ---- the mesh's ------------------------------------------------------------------------------- */

/* Means of the domain's values, a column a bone; never negative, though points outside the domain
 * are extrapolated. */
static void embed(const skin_work *w, const double *from, double *to)
{
    int n = w->out->vertex_count, rows = w->d.vertex_count;
    for (int j = 0; j < w->h.count; j++) {
        const double *column = from + (size_t)j * (size_t)rows;
        double *out = to + (size_t)w->bone[j] * (size_t)n;
        for (int i = 0; i < n; i++) {
            double sum = 0;
            for (int k = 0; k < w->d.dimension + 1; k++) {
                sum += w->at[i].weight[k] * column[w->at[i].vertex[k]];
            }
            out[i] = fmax(0, fmin(1, sum));
        }
    }
}

/* Rows with the sum 1 in the mesh too. Free weights may be negative: they are references, and what a
 * clip holds of them is cut off at 0. */
static int unite(skin_work *w, bake_error *error)
{
    int n = w->out->vertex_count;
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int j = 0; j < w->out->bone_count; j++) {
            sum += w->out->weight[(size_t)j * (size_t)n + (size_t)i];
        }
        if (!(sum > 1e-3)) {
            const double *x = w->m->mesh.rest + 3 * i;
            return skin_fail(
                w, w->rig->line, error,
                "no bone has a weight at (%.4g, %.4g, %.4g), vertex %d: add one there, "
                "or join the part to the others",
                x[0], x[1], x[2], i);
        }
        for (int j = 0; j < w->out->bone_count; j++) {
            w->out->weight[(size_t)j * (size_t)n + (size_t)i] /= sum;
        }
    }
    return 0;
}

/* As far as this outside of the shape, in sizes of it, a place is a slip of the pen. */
#define FIELD_FAR 0.05

static int field_place(const skin_work *w, const scene_field *f, embedding *out, bake_error *error)
{
    double far, size = 0;
    for (int i = 0; i < 3 * w->d.vertex_count; i++) {
        size = fmax(size, fabs(w->d.at[i] - w->d.at[i % 3]));
    }
    if (domain_embed(&w->d, f->at, 1, out, &far, error) < 0) {
        return -1;
    }
    return far <= FIELD_FAR * size
               ? 0
               : skin_fail(
                     w, f->line, error,
                     "the field %s at (%.4g, %.4g, %.4g) lies %.3g outside of the mesh: move it "
                     "inside",
                     w->s->channels[f->channel].name, f->at[0], f->at[1], f->at[2], far);
}

static int fields(skin_work *w, bake_error *error)
{
    int count = w->rig->field_count, bones = w->out->bone_count;
    embedding *place = bake_alloc((size_t)count + 1, sizeof *place);
    int err = 0;
    for (int i = 0; i < count && err == 0; i++) {
        err = field_place(w, &w->rig->fields[i], &place[i], error);
    }
    w->out->field = bake_alloc((size_t)count * (size_t)bones + 1, sizeof *w->out->field);
    for (int i = 0; i < count && err == 0; i++) {
        double *row = w->out->field + (size_t)i * (size_t)bones, sum = 0;
        for (int j = 0; j < w->h.count; j++) {
            const double *column = w->w + (size_t)j * (size_t)w->d.vertex_count;
            for (int k = 0; k < w->d.dimension + 1; k++) {
                row[w->bone[j]] += place[i].weight[k] * column[place[i].vertex[k]];
            }
            row[w->bone[j]] = fmax(0, row[w->bone[j]]);
            sum += row[w->bone[j]];
        }
        for (int j = 0; j < bones; j++) {
            row[j] /= sum;
        }
    }
    free(place);
    return err;
}

static void keep_reports(skin_work *w, const bounded_report *report)
{
    w->out->handle_count = w->h.count;
    w->out->handle = bake_alloc((size_t)w->h.count, sizeof *w->out->handle);
    for (int i = 0; i < w->h.count; i++) {
        w->out->handle[i] = (skin_handle){w->bone[i], report[i]};
    }
}

static int endpoint_weights(skin_work *w, bake_error *error)
{
    size_t size = (size_t)w->d.vertex_count * (size_t)w->h.count;
    const ends_filter filter = {w->rig->filter_count, w->rig->filter_x, w->rig->filter_y};
    w->e = bake_alloc(size, sizeof *w->e);
    if (ends_make(&w->d, &w->h, (ends_kind)w->rig->ends, w->w, &w->how, w->e, error) < 0) {
        return -1;
    }
    w->out->end =
        bake_alloc((size_t)w->out->vertex_count * (size_t)w->out->bone_count, sizeof *w->out->end);
    embed(w, w->e, w->out->end);
    ends_apply(&filter, w->out->end, w->out->vertex_count * w->out->bone_count);
    return 0;
}

int skin_weights(skin_work *w, bake_error *error)
{
    int n = w->d.vertex_count, m = w->h.count;
    bounded_report *report = bake_alloc((size_t)m, sizeof *report);
    w->w = bake_alloc((size_t)n * (size_t)m, sizeof *w->w);
    w->out->weight = bake_alloc((size_t)w->out->vertex_count * (size_t)w->out->bone_count,
                                sizeof *w->out->weight);
    int err = solve(w, report, error);
    if (err == 0) {
        keep_reports(w, report);
        err = kind_of(w->rig) == BOUNDED_SEPARATE ? bounded_normalise(w->w, n, m, error) : 0;
    }
    if (err == 0) {
        embed(w, w->w, w->out->weight);
        err = unite(w, error);
    }
    if (err == 0 && w->rig->ends != (int)ENDS_NONE) {
        err = endpoint_weights(w, error);
    }
    if (err == 0) {
        err = fields(w, error);
    }
    free(report);
    return err;
}
