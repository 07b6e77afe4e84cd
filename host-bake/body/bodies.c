/* All bodies of a scene, one after the other.
 * Source: own, on Schulz 2013, chapter 2.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void bodies_want(scene *s)
{
    for (int i = 0; i < s->body_count; i++) {
        const scene_body *b = &s->bodies[i];
        for (int k = 0; k < b->pose_count; k++) {
            if (b->poses[k].file && b->mesh >= 0) {
                scene_mesh *m = &s->meshes[b->mesh];
                m->shapes = bake_grow(m->shapes, (size_t)m->shape_count + 1, sizeof *m->shapes);
                m->shapes[m->shape_count++] = (scene_shape){
                    .line = b->poses[k].line, .channel = -1, .file = bake_copy(b->poses[k].file)};
            }
        }
    }
}

/* The poses are the bodies' now. No channel moves them, so nothing else may find them. */
static void forget_wanted(scene *s)
{
    for (int i = 0; i < s->body_count; i++) {
        scene_mesh *m = s->bodies[i].mesh >= 0 ? &s->meshes[s->bodies[i].mesh] : NULL;
        for (int k = 0; m && k < m->shape_count; k++) {
            free(m->shapes[k].file);
        }
        if (m) {
            free(m->shapes);
            m->shapes = NULL;
            m->shape_count = 0;
        }
    }
}

static void report_modes(const body_work *w, body_report *r)
{
    const modes *m = &w->own;
    r->rigid = m->rigid;
    r->mode_count = m->count - m->rigid;
    r->hertz = bake_alloc((size_t)r->mode_count + 1, sizeof *r->hertz);
    for (int i = 0, k = 0; i < m->count; i++) {
        r->residual = fmax(r->residual, m->residual[i]);
        if (m->lambda[i] != 0) {
            double hertz = sqrt(fabs(m->lambda[i])) / (2 * acos(-1));
            r->hertz[k++] = m->lambda[i] < 0 ? -hertz : hertz;
        }
    }
}

static int fill_report(body_work *w, const body_clip *clips, int count, body_report *r,
                       bake_error *error)
{
    *r = (body_report){.body = w->index,
                       .vertices = is_chain(w) ? w->c.link_count + 1 : w->b.vertex_count,
                       .elements = is_chain(w) ? w->c.link_count : w->b.element_count,
                       .coordinates = is_chain(w) ? w->n : w->held.count,
                       .far = w->far};
    if (body_own_modes(w, error) < 0) {
        return -1;
    }
    report_modes(w, r);
    for (int i = 0; i < w->b.vertex_count; i++) {
        r->mass += w->b.mass[i];
    }
    for (int i = 0; i < w->c.link_count; i++) {
        const chain_link *l = &w->links[i];
        r->mass += l->end_mass + l->length * (l->density[0] + l->density[1]) / 2;
    }
    r->mass += is_chain(w) ? w->c.root_mass : 0;
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < clips[i].count; j++) {
            r->motion = bake_grow(r->motion, (size_t)r->motion_count + 1, sizeof *r->motion);
            r->motion[r->motion_count++] = clips[i].run[j].report;
        }
    }
    return 0;
}

/* Frames of a mesh 20 ms apart are enough where they only check what is known. */
#define CHECK_STEP 0.02

static int show(body_work *w, const body_clip *clips, int count, bodies *out, bake_error *error)
{
    body_report *r = &out->report[out->count - 1];
    int adds = 0;
    r->waves = !is_chain(w) && body_waves_possible(clips, count);
    for (int i = 0; i < count; i++) {
        adds |= clips[i].adds && clips[i].count > 0;
    }
    if (w->target_count == 0) {
        return 0;
    }
    if (!r->waves && adds) {
        return body_fail(
            w, w->from->line, error,
            "an additive clip moves it, so its shapes must be the modes of models at rest "
            "in every clip: no blend or couple, no `about`, nothing that follows something "
            "else in one clip, no chain with a mesh");
    }
    if (body_show(w, clips, count, r->waves ? CHECK_STEP : 0, error) < 0) {
        return -1;
    }
    if (r->waves) {
        shape_given *given = bake_alloc(1, sizeof *given);
        out->given = bake_grow(out->given, (size_t)out->given_count + 1, sizeof *out->given);
        out->given[out->given_count++] = given;
        return body_waves(w, clips, count, given, error);
    }
    return 0;
}

static int move(body_work *w, scene *s, bodies *out, bake_error *error)
{
    body_clip *clips = bake_alloc((size_t)s->clip_count, sizeof *clips);
    int err = body_output_check(w, error), count = 0;
    for (; count < s->clip_count && err == 0; count++) {
        body_progress(w, s->clips[count].name);
        err = body_clip_make(w, count, &clips[count], error);
    }
    if (err == 0) {
        err = fill_report(w, clips, count, &out->report[out->count - 1], error);
    }
    if (err == 0) {
        err = show(w, clips, count, out, error);
    }
    for (int i = 0; i < count && err == 0; i++) {
        if (clips[i].count > 0) {
            body_outputs(w, &clips[i], s);
        }
    }
    for (int i = 0; i < count; i++) {
        body_clip_free(&clips[i]);
    }
    free(clips);
    return err;
}

int bodies_make(scene *s, shapes *sh, int verbose, bodies *out, bake_error *error)
{
    int err = 0;
    *out = (bodies){.report = bake_alloc((size_t)s->body_count + 1, sizeof *out->report)};
    for (int i = 0; i < s->body_count && err == 0; i++) {
        body_work w = {.s = s, .from = &s->bodies[i], .index = i, .verbose = verbose};
        out->count++;
        err = body_make(&w, sh, error);
        if (err == 0) {
            err = move(&w, s, out, error);
        }
        body_progress(&w, "");
        body_work_free(&w);
    }
    forget_wanted(s);
    return err;
}

void bodies_free(bodies *b)
{
    for (int i = 0; i < b->count; i++) {
        free(b->report[i].hertz);
        free(b->report[i].motion);
    }
    for (int i = 0; i < b->given_count; i++) {
        for (int k = 0; k < b->given[i]->curve_count; k++) {
            free(b->given[i]->curve[k].curve.keys);
        }
        free(b->given[i]->curve);
        free(b->given[i]);
    }
    free(b->report);
    free(b->given);
    *b = (bodies){0};
}
