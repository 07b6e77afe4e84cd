/* Rigs of a scene: what comes before meshes, and one skin after the other.
 * Source: Jacobson 2013, 4.3.4.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "skin_parts.h"

#include "rig_file.h"
#include "rig_take.h"
#include "scene_names.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int skin_fail(const skin_work *w, int line, bake_error *error, const char *format, ...)
{
    char text[sizeof error->text];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return bake_fail(error, "%s:%d: rig %s: %.900s", w->s->path, line, w->rig->name, text);
}

/* ---- joints ----------------------------------------------------------------------------------- */

/* Room for a joint at its place among the bone's. */
static scene_joint *insert_joint(scene_bone *b, int at)
{
    b->joints = bake_grow(b->joints, (size_t)b->joint_count + 1, sizeof *b->joints);
    memmove(b->joints + at + 1, b->joints + at,
            (size_t)(b->joint_count++ - at) * sizeof *b->joints);
    b->joints[at] = (scene_joint){0};
    return &b->joints[at];
}

static scene_joint *insert_move(scene_bone *b, int channel, int axis)
{
    scene_joint *j = insert_joint(b, 0);
    j->kind = (int)WG_JOINT_MOVE;
    j->channel = channel;
    j->axis[axis] = 1;
    return j;
}

/* A depth is a move along z by a channel that nothing moves: relative to the parent, which takes its
 * children with it. */
static int add_depth(scene *s, const scene_rig *rig, scene_bone *b, bake_error *error)
{
    if (b->depth == 0) {
        return 0;
    }
    if (s->channel_count >= (int)WG_CHANNELS_MAX) {
        return bake_fail(
            error,
            "%s:%d: the depth of '%s' is a channel, and there are %d already, which is "
            "what a clip holds; remove some depths, or give them to parents",
            s->path, b->line, b->name, s->channel_count);
    }
    insert_move(b, scene_add_channel(s, rig->name, b->name, "depth", b->depth), 2);
    return 0;
}

static int prepare_bone(scene *s, const scene_rig *rig, int bone, bake_error *error)
{
    scene_bone *b = &rig->bones[bone];
    for (int k = 2; k >= 0 && b->travels >= 0; k--) {
        insert_move(b, b->travels + k, k)->captured = 1;
    }
    if (add_depth(s, rig, b, error) < 0) {
        return -1;
    }
    if (b->captured >= 0) {
        scene_joint *j = insert_joint(b, b->joint_count);
        j->kind = (int)WG_JOINT_QUATERNION;
        j->channel = b->captured;
        j->captured = 1;
    }
    b->travels = b->captured = -1;
    b->depth = 0;
    return 0;
}

int skins_prepare(scene *s, bake_error *error)
{
    for (int i = 0; i < s->rig_count; i++) {
        if (s->rigs[i].file && rig_file_bones(s, i, error) < 0) {
            return -1;
        }
    }
    if (rig_takes(s, error) < 0) {
        return -1;
    }
    for (int i = 0; i < s->rig_count; i++) {
        for (int k = 0; k < s->rigs[i].bone_count; k++) {
            if (prepare_bone(s, &s->rigs[i], k, error) < 0) {
                return -1;
            }
        }
    }
    return 0;
}

/* ---- one skin --------------------------------------------------------------------------------- */

static void work_free(skin_work *w)
{
    for (int i = 0; i < w->h.count; i++) {
        free(w->vertices[i]);
    }
    free(w->vertices);
    free(w->handle);
    free(w->bone);
    free(w->facet);
    domain_free(&w->d);
    held_free(&w->held);
    free(w->at);
    free(w->w);
    free(w->e);
}

/* Fields: the weights of the mesh's nearest place. d: the mesh. */
static int file_fields(skin_work *w, const domain *d, bake_error *error)
{
    int err = 0, bones = w->rig->bone_count;
    size_t rows = (size_t)w->out->vertex_count;
    w->out->field =
        bake_alloc((size_t)w->rig->field_count * (size_t)bones + 1, sizeof *w->out->field);
    for (int i = 0; i < w->rig->field_count && err == 0; i++) {
        embedding e;
        double far, *row = w->out->field + (size_t)i * (size_t)bones;
        err = domain_embed(d, w->rig->fields[i].at, 1, &e, &far, error);
        for (int j = 0; j < bones && err == 0; j++) {
            for (int k = 0; k < 3; k++) {
                row[j] += e.weight[k] * w->out->weight[(size_t)j * rows + (size_t)e.vertex[k]];
            }
        }
    }
    return err;
}

/* Endpoint weights that need no domain, of the mesh's vertices. */
static int file_ends(skin_work *w, const domain *d, bake_error *error)
{
    const scene_rig *rig = w->rig;
    const ends_filter filter = {rig->filter_count, rig->filter_x, rig->filter_y};
    size_t size = (size_t)w->out->vertex_count * (size_t)rig->bone_count;
    if (rig->ends != (int)ENDS_PROJECTION && rig->ends != (int)ENDS_DISTANCE) {
        return skin_fail(
            w, rig->line, error,
            "with `weights: file`, bones that stretch or twist need `ends: projection` "
            "or `ends: distance`, or `ends: none` if vertices shall not follow it");
    }
    w->handle = bake_alloc((size_t)rig->bone_count, sizeof *w->handle);
    for (int i = 0; i < rig->bone_count; i++) {
        const scene_bone *b = &rig->bones[i];
        handle *h = &w->handle[i];
        *h = (handle){.name = b->name,
                      .line = b->line,
                      .kind = b->kind == BONE_BONE ? HANDLE_BONE : HANDLE_POINT};
        memcpy(h->from, b->from, sizeof h->from);
        memcpy(h->to, b->to, sizeof h->to);
    }
    const handles h = {.count = rig->bone_count, .handle = w->handle};
    w->out->end = bake_alloc(size, sizeof *w->out->end);
    if (ends_make(d, &h, (ends_kind)rig->ends, NULL, &w->how, w->out->end, error) < 0) {
        return -1;
    }
    ends_apply(&filter, w->out->end, (int)size);
    return 0;
}

static int from_file(skin_work *w, bake_error *error)
{
    const mesh *m = &w->m->mesh;
    const surface s = {m->vertex_count, m->triangle_count, m->rest, (const int(*)[3])m->triangle};
    size_t size = (size_t)w->out->vertex_count * (size_t)w->rig->bone_count;
    w->origin = (surface_origin){
        .scene = w->s->path, .name = w->s->meshes[w->m->index].name, .line = w->rig->line};
    w->how = (domain_options){.origin = &w->origin};
    w->out->weight = bake_alloc(size, sizeof *w->out->weight);
    if (rig_file_weights(w->s, w->out->rig, m, w->out->weight, error) < 0 ||
        domain_surface(&s, &w->d, error) < 0 || file_fields(w, &w->d, error) < 0) {
        return -1;
    }
    return w->rig->ends == (int)ENDS_NONE ? 0 : file_ends(w, &w->d, error);
}

static int solve(skin_work *w, bake_error *error)
{
    if (skin_domain(w, error) < 0 || skin_weights(w, error) < 0) {
        return -1;
    }
    w->out->dimension = w->d.dimension;
    w->out->domain_vertices = w->d.vertex_count;
    w->out->domain_elements = w->d.element_count;
    w->out->wrapped = w->d.wrapped;
    return 0;
}

/* A region turns about the middle of its vertices unless the scene says where. */
static int place_region(const scene *s, const scene_rig *rig, scene_bone *b, const mesh *m,
                        bake_error *error)
{
    double box[2][3];
    int count = 0;
    for (int i = 0; i < m->vertex_count; i++) {
        const double *x = m->rest + 3 * i;
        int in = b->region->kind != REGION_VERTICES && skin_inside(b->region, x);
        for (int v = 0; v < b->region->vertex_count; v++) {
            in |= b->region->vertex[v] == i;
        }
        for (int k = 0; k < 3 && in; k++) {
            box[0][k] = count > 0 ? fmin(box[0][k], x[k]) : x[k];
            box[1][k] = count > 0 ? fmax(box[1][k], x[k]) : x[k];
        }
        count += in;
    }
    if (count == 0) {
        return bake_fail(error,
                         "%s:%d: rig %s: the region of '%s' holds no vertex of the mesh: make it "
                         "larger, or move it",
                         s->path, b->line, rig->name, b->name);
    }
    for (int k = 0; k < 3; k++) {
        b->from[k] = b->to[k] = (box[0][k] + box[1][k]) / 2;
    }
    return 0;
}

static int place_regions(const scene *s, const scene_rig *rig, const mesh *m, bake_error *error)
{
    for (int i = 0; i < rig->bone_count; i++) {
        scene_bone *b = &rig->bones[i];
        if (b->region && b->region->kind == REGION_VERTICES && m->shape_count > 0) {
            return bake_fail(error,
                             "%s:%d: rig %s: '%s' names vertices, which `shapes` of the mesh have "
                             "sorted anew: give its region as a box or a ball",
                             s->path, b->line, rig->name, b->name);
        }
        int listed = b->region ? b->region->vertex_count : 0;
        if (listed > 0 && b->region->vertex[listed - 1] >= m->vertex_count) { /* ascending */
            return bake_fail(error,
                             "%s:%d: rig %s: '%s' names the vertex %d, and the mesh has %d, which "
                             "count from 0",
                             s->path, b->line, rig->name, b->name, b->region->vertex[listed - 1],
                             m->vertex_count);
        }
        if (b->region && isnan(b->from[0]) && place_region(s, rig, b, m, error) < 0) {
            return -1;
        }
        if (b->parent >= 0 && isnan(b->along)) {
            b->along = scene_bone_along(&rig->bones[b->parent], b->from);
        }
    }
    return 0;
}

/* Errors of solvers know no scene. */
static void say_where(const skin_work *w, bake_error *error)
{
    const bake_error what = *error;
    if (strncmp(what.text, w->s->path, strlen(w->s->path)) != 0) {
        skin_fail(w, w->rig->line, error, "%s", what.text);
    }
}

int skin_make(scene *s, shape_mesh *m, int verbose, bake_error *error)
{
    int rig = scene_rig_of_mesh(s, m->index);
    if (rig < 0) {
        return 0;
    }
    if (place_regions(s, &s->rigs[rig], &m->mesh, error) < 0) {
        return -1;
    }
    m->skin = bake_alloc(1, sizeof *m->skin);
    *m->skin = (skin){
        .rig = rig, .vertex_count = m->mesh.vertex_count, .bone_count = s->rigs[rig].bone_count};
    skin_work w = {.s = s, .rig = &s->rigs[rig], .m = m, .out = m->skin};
    if (verbose && isatty(2)) {
        fprintf(stderr, "\rrig %s: weights\033[K", w.rig->name);
    }
    m->skin->tolerance = w.rig->tolerance > 0 ? w.rig->tolerance : 0.9 * m->tolerance;
    int err = w.rig->weights == WEIGHTS_FILE ? from_file(&w, error) : solve(&w, error);
    if (err == 0) {
        err = skin_prune(&w, error);
    }
    if (err == 0) {
        skin_turns(&w);
    }
    if (err < 0) {
        say_where(&w, error);
    }
    work_free(&w);
    return err;
}

void skin_free(skin *k)
{
    if (k) {
        free(k->weight);
        free(k->end);
        free(k->stored);
        free(k->field);
        free(k->handle);
        free(k->poses.value);
    }
    free(k);
}
