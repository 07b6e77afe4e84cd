/* From a scene's entry to a discretised body: what it is made of, where it is held, what it moves.
 * Source: Schulz 2013, 2.3; embedding of other meshes is our own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int body_fail(const body_work *w, int line, bake_error *error, const char *format, ...)
{
    char text[sizeof error->text];
    va_list rest;
    va_start(rest, format);
    vsnprintf(text, sizeof text, format, rest);
    va_end(rest);
    return bake_fail(error, "%s:%d: body %s: %.800s", w->s->path, line, w->from->name, text);
}

void body_progress(const body_work *w, const char *what)
{
    if (w->verbose && isatty(2)) {
        fprintf(stderr, "\rbody %s: %s\033[K%s", w->from->name, what, *what ? "" : "\r\033[K");
    }
}

/* ---- elements --------------------------------------------------------------------------------- */

static void make_shell(body_work *w, const mesh *m)
{
    body *b = &w->b;
    b->kind = BODY_SHELL;
    b->vertex_count = m->vertex_count;
    b->element_count = m->triangle_count;
    b->rest = bake_alloc(3 * (size_t)m->vertex_count, sizeof *b->rest);
    b->element = bake_alloc((size_t)m->triangle_count, sizeof *b->element);
    memcpy(b->rest, m->rest, 3 * (size_t)m->vertex_count * sizeof *b->rest);
    for (int t = 0; t < m->triangle_count; t++) {
        memcpy(b->element[t], m->triangle[t], sizeof m->triangle[t]);
        b->element[t][3] = -1;
    }
}

static int load_tets(const cache_key *key, body *b)
{
    size_t size = 0;
    cache_blob blob = {cache_load(key, &size), 0, 0, 0};
    blob.count = size;
    int good = blob.at && cache_take(&blob, &b->vertex_count, sizeof(int)) == 0 &&
               cache_take(&blob, &b->element_count, sizeof(int)) == 0;
    if (good) {
        size_t at = 3 * (size_t)b->vertex_count * sizeof *b->rest;
        size_t elements = (size_t)b->element_count * sizeof *b->element;
        b->rest = bake_alloc(at, 1);
        b->element = bake_alloc(elements, 1);
        good = cache_take(&blob, b->rest, at) == 0 && cache_take(&blob, b->element, elements) == 0;
    }
    free(blob.at);
    if (!good) {
        body_free(b);
    }
    return good;
}

static void store_tets(const cache_key *key, const body *b)
{
    cache_blob blob = {0};
    cache_put(&blob, &b->vertex_count, sizeof(int));
    cache_put(&blob, &b->element_count, sizeof(int));
    cache_put(&blob, b->rest, 3 * (size_t)b->vertex_count * sizeof *b->rest);
    cache_put(&blob, b->element, (size_t)b->element_count * sizeof *b->element);
    cache_store(key, blob.at, blob.count);
    free(blob.at);
}

static int make_solid(body_work *w, const mesh *m, bake_error *error)
{
    const surface around = {m->vertex_count, m->triangle_count, m->rest,
                            (const int(*)[3])m->triangle};
    const surface_origin origin = {w->s->path, w->s->meshes[w->from->mesh].name, w->from->line};
    cache_key key = cache_key_start("tets 1");
    cache_key_real(&key, w->from->cell);
    cache_key_add(&key, m->rest, 3 * (size_t)m->vertex_count * sizeof *m->rest);
    cache_key_add(&key, m->triangle, (size_t)m->triangle_count * sizeof *m->triangle);
    if (!load_tets(&key, &w->b)) {
        body_progress(w, "tetrahedra");
        if (tets_make(&around, w->from->cell, &origin, &w->b, error) < 0) {
            return -1;
        }
        store_tets(&key, &w->b);
    }
    w->b.kind = BODY_SOLID;
    return 0;
}

static int make_elements(body_work *w, const mesh *m, bake_error *error)
{
    const scene_body *from = w->from;
    bake_error inner = {""};
    if (from->kind == SCENE_SHELL) {
        make_shell(w, m);
    } else if (make_solid(w, m, error) < 0) {
        return -1;
    }
    w->b.material = (body_material){from->young, from->poisson, from->density, from->thickness};
    for (int i = 0; i < 3 * w->b.vertex_count; i++) {
        w->b.rest[i] *= from->unit;
    }
    if (body_prepare(&w->b, &inner) < 0) {
        return body_fail(w, from->line, error, "%s", inner.text);
    }
    w->n = 3 * w->b.vertex_count;
    w->rest = bake_alloc((size_t)w->n, sizeof *w->rest);
    memcpy(w->rest, w->b.rest, (size_t)w->n * sizeof *w->rest);
    w->key = cache_key_start("body 2");
    cache_key_int(&w->key, (int)w->b.kind);
    cache_key_add(&w->key, &w->b.material, sizeof w->b.material);
    cache_key_add(&w->key, w->b.rest, (size_t)w->n * sizeof *w->rest);
    cache_key_add(&w->key, w->b.element, (size_t)w->b.element_count * sizeof *w->b.element);
    return 0;
}

/* ---- regions ---------------------------------------------------------------------------------- */

static int inside(const scene_region *r, const double x[3])
{
    double square = 0;
    int in = 1;
    for (int k = 0; k < 3; k++) {
        in = in && x[k] >= r->box[0][k] && x[k] <= r->box[1][k];
        square += (x[k] - r->centre[k]) * (x[k] - r->centre[k]);
    }
    return r->kind == REGION_BOX ? in : square <= r->radius * r->radius;
}

static int fail_empty(const body_work *w, const scene_region *r, bake_error *error)
{
    double box[2][3] = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (int i = 0; i < w->n; i++) {
        box[0][i % 3] = fmin(box[0][i % 3], w->b.rest[i] / w->from->unit);
        box[1][i % 3] = fmax(box[1][i % 3], w->b.rest[i] / w->from->unit);
    }
    return body_fail(
        w, r->line, error,
        "the region '%s' holds none of the %d vertices, which lie between (%.4g, %.4g, "
        "%.4g) and (%.4g, %.4g, %.4g); make it larger, or move it",
        r->name, w->b.vertex_count, box[0][0], box[0][1], box[0][2], box[1][0], box[1][1],
        box[1][2]);
}

static int fill_region(body_work *w, const scene_region *r, vertex_list *out, bake_error *error)
{
    int vertices = w->b.vertex_count, outer = w->target[0].m->mesh.vertex_count;
    out->vertex = bake_alloc((size_t)vertices + (size_t)r->vertex_count, sizeof *out->vertex);
    for (int i = 0; i < vertices && r->kind != REGION_VERTICES; i++) {
        double at[3];
        for (int k = 0; k < 3; k++) {
            at[k] = w->b.rest[3 * i + k] / w->from->unit;
        }
        if (inside(r, at)) {
            out->vertex[out->count++] = i;
        }
    }
    for (int i = 0; i < r->vertex_count; i++) {
        if (r->vertex[i] >= outer) {
            return body_fail(
                w, r->line, error,
                "the region '%s' names vertex %d; the mesh has 0 to %d once vertices in "
                "one place are joined",
                r->name, r->vertex[i], outer - 1);
        }
        out->vertex[out->count++] = r->vertex[i];
    }
    return out->count > 0 ? 0 : fail_empty(w, r, error);
}

static int make_regions(body_work *w, bake_error *error)
{
    int count = w->from->region_count;
    w->region = bake_alloc((size_t)count + 1, sizeof *w->region);
    for (int i = 0; i < count; i++) {
        if (fill_region(w, &w->from->regions[i], &w->region[i], error) < 0) {
            return -1;
        }
    }
    vertex_list *all = &w->region[count];
    all->count = w->b.vertex_count;
    all->vertex = bake_alloc((size_t)all->count + 1, sizeof *all->vertex);
    for (int i = 0; i < all->count; i++) {
        all->vertex[i] = i;
    }
    return 0;
}

const vertex_list *body_region(const body_work *w, int region)
{
    return &w->region[region < 0 ? w->from->region_count : region];
}

void body_hold(const body_work *w, const body_holds *holds, freedom *out)
{
    freedom_make(w->b.vertex_count, out);
    for (int i = 0; i < holds->slide_count; i++) {
        const vertex_list *list = body_region(w, holds->slides[i].region);
        for (int j = 0; j < list->count; j++) {
            freedom_slide(out, list->vertex[j], holds->slides[i].normal);
        }
    }
    for (int i = 0; i < holds->fixed_count; i++) {
        const vertex_list *list = body_region(w, holds->fixed[i]);
        for (int j = 0; j < list->count; j++) {
            freedom_fix(out, list->vertex[j]);
        }
    }
    freedom_finish(out);
}

/* ---- chains ----------------------------------------------------------------------------------- */

static int make_chain(body_work *w, bake_error *error)
{
    const scene_body *from = w->from;
    bake_error inner = {""};
    w->links = bake_alloc((size_t)from->link_count, sizeof *w->links);
    for (int i = 0; i < from->link_count; i++) {
        const scene_link *l = &from->links[i];
        w->links[i] = (chain_link){.parent = l->parent,
                                   .stiff = l->stiff,
                                   .length = l->length * from->unit,
                                   .angle = l->angle * DEGREE,
                                   .end_mass = l->mass,
                                   .density = {l->density[0], l->density[1]},
                                   .spring = l->spring};
    }
    w->c = (chain){.link_count = from->link_count,
                   .link = w->links,
                   .free_root = from->free_root,
                   .root_mass = from->root_mass,
                   .gravity = -from->gravity[1]};
    if (chain_check(&w->c, &inner) < 0) {
        return body_fail(w, from->line, error, "%s", inner.text);
    }
    w->n = chain_size(&w->c);
    w->rest = bake_alloc((size_t)w->n, sizeof *w->rest);
    chain_rest(&w->c, w->rest);
    return 0;
}

int body_link_coordinate(const body_work *w, int link)
{
    int at = w->c.free_root ? 2 : 0;
    for (int i = 0; i < link; i++) {
        at += !w->links[i].stiff;
    }
    return w->links[link].stiff ? -1 : at;
}

/* ---- meshes ----------------------------------------------------------------------------------- */

static shape_mesh *find_mesh(shapes *sh, int index)
{
    for (int i = 0; i < sh->count; i++) {
        if (sh->mesh[i].index == index) {
            return &sh->mesh[i];
        }
    }
    return NULL;
}

static int embed(body_work *w, body_target *target, bake_error *error)
{
    const mesh *m = &target->m->mesh;
    bake_error inner = {""};
    size_t rows = 3 * (size_t)m->vertex_count;
    double *at = bake_alloc(rows, sizeof *at), far = 0;
    for (size_t i = 0; i < rows; i++) {
        at[i] = m->rest[i] * w->from->unit;
    }
    target->at = bake_alloc((size_t)m->vertex_count, sizeof *target->at);
    int err = tets_embed(&w->b, at, m->vertex_count, target->at, &far, &inner);
    if (err == 0) { /* a point beside a shell keeps its distance; in a solid this is rounding */
        body_surface_shift(w, target, w->rest, at);
        for (size_t i = 0; i < rows; i++) {
            at[i] = m->rest[i] - at[i];
        }
    }
    target->apart = at;
    w->far = fmax(w->far, far / w->from->unit);
    return err == 0 ? 0 : body_fail(w, w->from->line, error, "%s", inner.text);
}

static int make_targets(body_work *w, shapes *sh, bake_error *error)
{
    const scene_body *from = w->from;
    for (int i = 0; i < from->attached_count && w->b.vertex_count > 0; i++) {
        body_target *target = &w->target[w->target_count++];
        target->m = find_mesh(sh, from->attached[i]);
        if (embed(w, target, error) < 0) {
            return -1;
        }
    }
    return 0;
}

/* Poses from files came as shapes of the mesh; from here on it has none. */
static void take_file_poses(body_work *w, mesh *m)
{
    size_t rows = 3 * (size_t)m->vertex_count, next = 0;
    for (int i = 0; i < w->from->pose_count; i++) {
        if (w->from->poses[i].file && next < (size_t)m->shape_count) {
            w->file_pose[i] = bake_alloc(rows, sizeof(double));
            memcpy(w->file_pose[i], m->shape + rows * next++, rows * sizeof(double));
        }
    }
    m->shape_count = 0;
}

int body_make(body_work *w, shapes *sh, bake_error *error)
{
    const scene_body *from = w->from;
    int err = 0;
    w->pose = bake_alloc((size_t)from->pose_count, sizeof *w->pose);
    w->file_pose = bake_alloc((size_t)from->pose_count, sizeof *w->file_pose);
    w->target = bake_alloc((size_t)from->attached_count + 1, sizeof *w->target);
    if (is_chain(w)) {
        err = make_chain(w, error);
    }
    if (err == 0 && from->mesh >= 0) {
        shape_mesh *own = find_mesh(sh, from->mesh);
        w->target[w->target_count++].m = own;
        if (is_chain(w)) {
            chain_draw_mesh(w, &own->mesh);
        } else {
            take_file_poses(w, &own->mesh);
            err = make_elements(w, &own->mesh, error);
        }
    }
    if (err == 0 && !is_chain(w)) {
        err = make_regions(w, error) < 0 ? -1 : make_targets(w, sh, error);
    }
    if (err == 0 && !is_chain(w)) {
        const body_holds holds = {from->fixed_count, from->fixed, from->slide_count, from->slides};
        body_hold(w, &holds, &w->held);
    }
    return err;
}

void body_work_free(body_work *w)
{
    for (int i = 0; w->region && i <= w->from->region_count; i++) {
        free(w->region[i].vertex);
    }
    for (int i = 0; i < w->from->pose_count; i++) {
        free(w->pose[i]);
        free(w->file_pose[i]);
    }
    for (int i = 0; i < w->target_count; i++) {
        free(w->target[i].at);
        free(w->target[i].apart);
    }
    for (int i = 0; i < w->group_count; i++) {
        body_group_free(&w->group[i]);
    }
    free(w->group);
    free(w->region);
    free(w->pose);
    free(w->file_pose);
    free(w->target);
    free(w->rest);
    free(w->links);
    freedom_free(&w->held);
    modes_free(&w->own);
    body_free(&w->b);
}
