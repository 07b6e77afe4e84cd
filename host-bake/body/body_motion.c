/* From the keys of a scene to motion in reduced coordinates, and back to shapes.
 * Source: Schulz 2013, algorithm 1 and 2.8.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TICKS_MAX 65535.0

/* ---- keys ------------------------------------------------------------------------------------- */

/* Of the root, and of joints. */
static void chain_rates(const body_work *w, const scene_body_key *key, double *u)
{
    for (int i = 0; i < key->velocity_count && w->c.free_root; i++) {
        u[0] += key->velocity[i].by[0] * w->from->unit;
        u[1] += key->velocity[i].by[1] * w->from->unit;
    }
    for (int i = 0; i < key->rate_count; i++) {
        int at = body_link_coordinate(w, key->rate_link[i]);
        if (at >= 0) {
            u[at] = key->rate[i] * DEGREE;
        }
    }
}

static void key_velocity(const body_work *w, const scene_body_key *key, const double *x, double *u)
{
    for (int i = 0; i < key->velocity_count && !is_chain(w); i++) {
        body_shift(w, &key->velocity[i], x, u);
    }
    if (is_chain(w)) {
        chain_rates(w, key, u);
    }
}

/* Poses and velocities of all keys in the space: 2 d a key, in one product. */
static int project_keys(body_work *w, const body_run *r, double **out, bake_error *error)
{
    const space *sp = &w->group[r->group].sp;
    size_t n = (size_t)w->n, count = (size_t)r->from->key_count;
    double *u = bake_alloc(2 * n * count, sizeof *u);
    for (size_t k = 0; k < count; k++) {
        const scene_body_key *key = &r->from->keys[k];
        const double *x;
        if (body_pose(w, key->pose, &x, error) < 0) {
            free(u);
            return -1;
        }
        for (size_t i = 0; i < n; i++) {
            u[2 * n * k + i] = x[i] - sp->origin[i];
        }
        key_velocity(w, key, x, u + 2 * n * k + n);
    }
    *out = bake_alloc(2 * (size_t)sp->d * count, sizeof **out);
    space_project_vectors(sp, u, 2 * (int)count, *out);
    free(u);
    return 0;
}

/* Rows of the region's vertices, each weighted by the root of its mass, so that a soft pose of all
 * vertices weighs what a full one does. */
static void partial_rows(const body_work *w, const space *sp, const scene_body_key *key,
                         const double *x, space_key *out)
{
    const vertex_list *list = body_region(w, key->region);
    size_t d = (size_t)sp->d;
    double *S, *p;
    out->rows = 3 * list->count;
    out->S = S = bake_alloc((size_t)out->rows * d, sizeof *S);
    out->p = p = bake_alloc((size_t)out->rows, sizeof *p);
    for (int i = 0; i < out->rows; i++) {
        size_t at = 3 * (size_t)list->vertex[i / 3] + (size_t)(i % 3);
        double root = sqrt(w->b.mass[list->vertex[i / 3]]);
        p[i] = root * (x[at] - sp->origin[at]);
        for (size_t j = 0; j < d; j++) {
            S[(size_t)i * d + j] = root * sp->V[j * (size_t)sp->n + at];
        }
    }
}

static int make_key(body_work *w, const body_clip *c, body_run *r, int index, bake_error *error)
{
    const body_group *g = &w->group[r->group];
    const scene_body_key *from = &r->from->keys[index];
    space_key *to = &r->key[index];
    const double *q = r->projected + 2 * (size_t)g->sp.d * (size_t)index;
    *to = (space_key){
        .time = floor(from->time * c->rate + 0.5) / c->rate, .q = q, .weight = {from->weight, 0}};
    if (from->has_velocity) {
        to->v = q + g->sp.d;
        to->weight[1] = from->velocity_weight;
    }
    if (index > 0 && !(to->time > to[-1].time)) {
        return body_fail(
            w, from->line, error,
            "the keys at %g s and %g s fall into one tick of %.3g s: move them apart%s",
            from[-1].time, from->time, 1 / c->rate,
            w->s->tick_rate > 0 ? ", or raise `tick_rate`"
                                : ", or shorten the clip: it has at most 65535 ticks");
    }
    if (from->region >= 0) {
        partial_rows(w, &g->sp, from, w->pose[from->pose], to);
    }
    r->at_key[index] = body_group_model(g, from->pose);
    return 0;
}

/* A hard velocity of an outer key is its end's condition. */
static void make_end(body_run *r, int end)
{
    space_key *key = &r->key[end ? r->from->key_count - 1 : 0];
    r->settings.end[end] = r->from->end[end];
    if (r->from->end[end] != BAKE_END_VELOCITY) {
        return;
    }
    if (key->v && key->weight[1] > 0) {
        r->settings.end[end] = BAKE_END_FREE;
    } else {
        r->settings.end_v[end] = key->v;
        key->weight[1] = 0;
    }
}

static int solve(const body_work *w, body_run *r, bake_error *error)
{
    bake_error inner = {""};
    int err = r->from->dynamics == DYNAMICS_BLEND ? motion_blend(r->at_key, &r->in, &r->m, &inner)
              : r->from->dynamics == DYNAMICS_COUPLE
                  ? motion_couple(r->at_key, &r->in, &r->m, &inner)
                  : motion_one_point(r->at_key[0], &r->in, &r->m, &inner);
    if (err < 0) {
        return body_fail(w, r->from->line, error, "%s", inner.text);
    }
    if (inner.text[0]) {
        fprintf(stderr, "%s:%d: body %s: warning: %s\n", w->s->path, r->from->line, w->from->name,
                inner.text);
    }
    return 0;
}

/* ---- report ----------------------------------------------------------------------------------- */

static double missed(const body_work *w, const body_run *r)
{
    const space *sp = &w->group[r->group].sp;
    double sum = 0, *q = bake_alloc((size_t)sp->d, sizeof *q);
    double *x = bake_alloc((size_t)w->n, sizeof *x);
    int count = 0;
    for (int k = 0; k < r->from->key_count; k++) {
        const scene_body_key *key = &r->from->keys[k];
        const vertex_list *list = key->region < 0 ? NULL : body_region(w, key->region);
        motion_eval(&r->m, r->key[k].time, q, NULL, NULL);
        space_expand(sp, q, x);
        for (int i = 0; list && i < list->count; i++, count++) {
            for (int a = 0; a < 3; a++) {
                double e = x[3 * list->vertex[i] + a] - w->pose[key->pose][3 * list->vertex[i] + a];
                sum += e * e;
            }
        }
    }
    free(q);
    free(x);
    return count > 0 ? sqrt(sum / count) / w->from->unit : -1;
}

static int comparable(const body_run *r)
{
    int good = r->from->dynamics != DYNAMICS_SPLINE;
    for (int i = 0; i < r->from->key_count; i++) {
        good = good && r->key[i].weight[0] == BAKE_HARD && r->key[i].rows == 0;
    }
    return good;
}

static void report(const body_work *w, body_run *r)
{
    bake_error inner = {""};
    r->report.dimension = w->group[r->group].sp.d;
    r->report.energy = motion_energy(&r->m);
    r->report.cubic = -1;
    r->report.missed = is_chain(w) ? -1 : missed(w, r);
    if (comparable(r) && motion_cubic_energy(&r->m, &r->in, &r->report.cubic, &inner) < 0) {
        r->report.cubic = -1; /* a C2 cubic has no freedom for velocities at inner keys */
    }
}

/* ---- one action, one clip --------------------------------------------------------------------- */

static int make_run(body_work *w, body_clip *c, int action, bake_error *error)
{
    const scene_action *a = &w->s->clips[c->clip].actions[action];
    body_run *r = &c->run[c->count++];
    *r = (body_run){.from = a, .group = body_group_of(w, a, error)};
    r->report.clip = c->clip;
    r->report.action = action;
    if (r->group < 0) {
        return -1;
    }
    r->key = bake_alloc((size_t)a->key_count, sizeof *r->key);
    r->at_key = bake_alloc((size_t)a->key_count, sizeof *r->at_key);
    if (a->dynamics != DYNAMICS_SPLINE) {
        r->settings.alpha = a->damping[0];
        r->settings.beta = a->damping[1];
    }
    r->settings.stiffness = a->stiffness;
    memcpy(r->settings.regularise, a->regularise, sizeof a->regularise);
    if (project_keys(w, r, &r->projected, error) < 0) {
        return -1;
    }
    for (int k = 0; k < a->key_count; k++) {
        if (make_key(w, c, r, k, error) < 0) {
            return -1;
        }
    }
    make_end(r, 0);
    make_end(r, 1);
    r->in = (motion_input){&r->settings, r->key, a->key_count};
    if (solve(w, r, error) < 0) {
        return -1;
    }
    report(w, r);
    return 0;
}

static double longest(const body_work *w, const scene_clip *clip)
{
    double end = 0;
    for (int i = 0; i < clip->action_count; i++) {
        const scene_action *a = &clip->actions[i];
        if (a->body == w->index) {
            end = fmax(end, a->keys[a->key_count - 1].time);
        }
    }
    return end;
}

int body_clip_make(body_work *w, int clip, body_clip *out, bake_error *error)
{
    const scene_clip *from = &w->s->clips[clip];
    double end = longest(w, from), duration = fmax(end, from->duration);
    *out = (body_clip){.clip = clip,
                       .run = bake_alloc((size_t)from->action_count + 1, sizeof *out->run),
                       .loops = from->end == (int)WG_END_LOOP,
                       .adds = from->additive};
    if (end == 0) {
        return 0;
    }
    out->rate =
        w->s->tick_rate > 0 ? w->s->tick_rate : fmax(1, fmin(1000, floor(TICKS_MAX / duration)));
    out->to = floor((out->loops ? duration : end) * out->rate + 0.5) / out->rate;
    for (int i = 0; i < from->action_count; i++) {
        if (from->actions[i].body == w->index && make_run(w, out, i, error) < 0) {
            return -1;
        }
    }
    return 0;
}

void body_clip_free(body_clip *c)
{
    for (int i = 0; i < c->count; i++) {
        body_run *r = &c->run[i];
        for (int k = 0; r->key && k < r->from->key_count; k++) {
            free((void *)r->key[k].S);
            free((void *)r->key[k].p);
        }
        free(r->key);
        free(r->projected);
        free(r->at_key);
        motion_free(&r->m);
    }
    free(c->run);
    *c = (body_clip){0};
}

/* ---- shapes ----------------------------------------------------------------------------------- */

/* Of those that do not add: the one that is at work at t; at the border of two, the later. */
static const body_run *run_at(const body_clip *c, double t)
{
    const body_run *best = NULL;
    for (int i = 0; i < c->count; i++) {
        const body_run *r = &c->run[i];
        if (!r->from->add && (!best || (r->m.from <= t && r->m.from > best->m.from) ||
                              (best->m.from > t && r->m.from < best->m.from))) {
            best = r;
        }
    }
    return best;
}

/* Adds its difference from rest. */
static void add_run(const body_work *w, const body_run *r, double t, double *x)
{
    const space *sp = &w->group[r->group].sp;
    double *q = bake_alloc((size_t)sp->d, sizeof *q);
    motion_eval(&r->m, t, q, NULL, NULL);
    for (int i = 0; i < w->n; i++) {
        x[i] += sp->origin[i] - w->rest[i];
    }
    for (int j = 0; j < sp->d; j++) {
        for (int i = 0; i < w->n; i++) {
            x[i] += q[j] * sp->V[(size_t)j * (size_t)w->n + (size_t)i];
        }
    }
    free(q);
}

void body_clip_eval(const body_work *w, const body_clip *c, double t, double *x)
{
    const body_run *main = run_at(c, t);
    memcpy(x, w->rest, (size_t)w->n * sizeof *x);
    for (int i = 0; i < c->count; i++) {
        if (c->run[i].from->add || &c->run[i] == main) {
            add_run(w, &c->run[i], t, x);
        }
    }
}

/* ---- times ------------------------------------------------------------------------------------ */

/* How far a tick is from where the nearest action begins or ends. */
static int border_distance(const body_clip *c, int tick)
{
    double least = HUGE_VAL;
    for (int i = 0; i < c->count; i++) {
        least = fmin(least, fabs(c->run[i].m.from * c->rate - tick));
        least = fmin(least, fabs(c->run[i].m.to * c->rate - tick));
    }
    return (int)floor(fmin(least, TICKS_MAX) + 0.5);
}

/* A loop whose end does not join its start: the jump is in the last tick. */
static int has_seam(const body_clip *c)
{
    int joins = 1;
    for (int i = 0; i < c->count; i++) {
        joins = joins && c->run[i].m.periodic;
    }
    return c->loops && !joins;
}

/* Ticks apart: towards borders, where what is damped most decays, an eighth of what it is
 * elsewhere. */
static int spacing(int every, int distance, int finer)
{
    int part = !finer || distance >= 4 * every ? 1 : distance >= 2 * every ? 2 : 4;
    part *= part == 4 && distance < every ? 2 : 1;
    return every / part < 1 ? 1 : every / part;
}

void body_clip_times(const body_clip *c, double step, int finer, body_times *out)
{
    int ticks = (int)floor(c->to * c->rate + 0.5), every = (int)floor(step * c->rate + 0.5);
    int seam = has_seam(c) ? ticks - 1 : -1;
    every = every < 1 ? 1 : every;
    out->count = 0;
    out->time = bake_alloc((size_t)ticks + 3, sizeof *out->time);
    out->kink = bake_alloc((size_t)ticks + 3, 1);
    for (int i = 0; i <= ticks; i++) {
        int apart = border_distance(c, i), border = apart == 0 || i == seam;
        int own = spacing(every, apart, finer), least = seam < 0 ? apart : abs(seam - i);
        least = least < apart ? least : apart;
        if ((i % own == 0 && least > own / 3) || border || i == ticks) {
            out->kink[out->count] = (char)(border && i > 0 && i < ticks);
            out->time[out->count++] = i / c->rate;
        }
    }
    if (c->loops && out->count > 1) {
        out->count--; /* the end is where it begins again */
    } else {
        out->time[out->count] = c->to + step;
    }
}

void body_times_free(body_times *t)
{
    free(t->time);
    free(t->kink);
}
