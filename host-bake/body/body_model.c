/* Reduced spaces of a body and the linear dynamic models in them.
 * Source: Schulz 2013, algorithm 2 and 2.8; one-point dynamics takes the modes at its base point
 * alone.
 *   S   n x count   what the space must hold: poses and modes, as differences from its origin
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static int many_points(const scene_action *a)
{
    return a->dynamics == DYNAMICS_BLEND || a->dynamics == DYNAMICS_COUPLE;
}

/* ---- which actions go together ---------------------------------------------------------------- */

static body_holds holds_of(const scene_body *b, const scene_action *a)
{
    return (body_holds){
        a->has_fixed ? a->fixed_count : b->fixed_count, a->has_fixed ? a->fixed : b->fixed,
        a->has_slides ? a->slide_count : b->slide_count, a->has_slides ? a->slides : b->slides};
}

static int same_holds(const body_holds *a, const body_holds *b)
{
    int same = a->fixed_count == b->fixed_count && a->slide_count == b->slide_count;
    for (int i = 0; same && i < a->fixed_count; i++) {
        same = a->fixed[i] == b->fixed[i];
    }
    for (int i = 0; same && i < a->slide_count; i++) {
        same = a->slides[i].region == b->slides[i].region &&
               memcmp(a->slides[i].normal, b->slides[i].normal, sizeof a->slides[i].normal) == 0;
    }
    return same;
}

static int same_group(const scene_body *of, const scene_action *a, const scene_action *b)
{
    body_holds x = holds_of(of, a), y = holds_of(of, b);
    return a->body == b->body && a->dynamics == b->dynamics && a->about == b->about &&
           a->add == b->add && same_holds(&x, &y);
}

/* Visits the keys of all actions of the scene that belong to the group. */
typedef struct {
    const scene_action *action;
    const scene_body_key *key;
    int clip, at, next;
} key_walk;

static int next_key(const body_work *w, const scene_action *like, key_walk *k)
{
    for (; k->clip < w->s->clip_count; k->clip++, k->at = 0) {
        const scene_clip *clip = &w->s->clips[k->clip];
        for (; k->at < clip->action_count; k->at++, k->next = 0) {
            k->action = &clip->actions[k->at];
            if (k->next < k->action->key_count && same_group(w->from, like, k->action)) {
                k->key = &k->action->keys[k->next++];
                return 1;
            }
        }
    }
    return 0;
}

/* ---- vectors ---------------------------------------------------------------------------------- */

typedef struct {
    int n, count;
    double *at;
} vectors;

static double *add_vector(vectors *v)
{
    v->at = bake_grow(v->at, (size_t)v->n * (size_t)(v->count + 1), sizeof *v->at);
    double *out = v->at + (size_t)v->n * (size_t)v->count++;
    memset(out, 0, (size_t)v->n * sizeof *out);
    return out;
}

/* Poses keep what is held where it is. */
static int check_held(const body_work *w, const freedom *f, const double *u,
                      const scene_body_key *key, bake_error *error)
{
    double *y = bake_alloc((size_t)f->count + 1, sizeof *y), most = 0, size = 0;
    double *kept = bake_alloc((size_t)w->n, sizeof *kept);
    freedom_restrict(f, u, y);
    freedom_expand(f, y, kept);
    for (int i = 0; i < w->n; i++) {
        most = fmax(most, fabs(u[i] - kept[i]));
        size = fmax(size, fabs(w->rest[i]));
    }
    free(y);
    free(kept);
    return most <= 1e-6 * size
               ? 0
               : body_fail(w, key->line, error,
                           "pose '%s' moves by %.3g what the motion holds: name the pose that it "
                           "starts from in `about`, or change `fixed` and `sliding`",
                           w->from->poses[key->pose].name, most / w->from->unit);
}

static void add_modes(const freedom *f, const modes *m, vectors *v)
{
    for (int j = 0; j < m->count; j++) {
        freedom_expand(f, m->phi + (size_t)j * (size_t)m->n, add_vector(v));
    }
}

/* Velocities of what is free, for motions without physics: nothing else makes room for them. */
static void add_velocity(const body_work *w, const freedom *f, const scene_body_key *key,
                         const double *x, vectors *v)
{
    double *y = bake_alloc((size_t)f->count + 1, sizeof *y);
    for (int i = 0; i < key->velocity_count; i++) {
        double *u = add_vector(v);
        body_shift(w, &key->velocity[i], x, u);
        freedom_restrict(f, u, y);
        freedom_expand(f, y, u);
    }
    free(y);
}

typedef struct {
    body_work *w;
    body_group *g;
    freedom f;
    vectors v;
    double noise; /* [1/s^2] */
    int pose_count;
    int *pose; /* different ones that keys name */
} space_work;

static int note_pose(space_work *k, int pose)
{
    for (int i = 0; i < k->pose_count; i++) {
        if (k->pose[i] == pose) {
            return 0;
        }
    }
    k->pose = bake_grow(k->pose, (size_t)k->pose_count + 1, sizeof *k->pose);
    k->pose[k->pose_count++] = pose;
    return 1;
}

static int gather_poses(space_work *k, bake_error *error)
{
    body_work *w = k->w;
    key_walk walk = {0};
    while (next_key(w, k->g->like, &walk)) {
        const double *x;
        if (body_pose(w, walk.key->pose, &x, error) < 0) {
            return -1;
        }
        if (k->g->like->dynamics == DYNAMICS_SPLINE && !is_chain(w)) {
            add_velocity(w, &k->f, walk.key, x, &k->v);
        }
        if (walk.key->region >= 0 || !note_pose(k, walk.key->pose)) {
            continue; /* a partial pose need not be in the space */
        }
        double *u = add_vector(&k->v);
        for (int i = 0; i < w->n; i++) {
            u[i] = x[i] - k->g->sp.origin[i];
        }
        if (!is_chain(w) && k->g->like->dynamics != DYNAMICS_SPLINE &&
            check_held(w, &k->f, u, walk.key, error) < 0) {
            return -1;
        }
    }
    return 0;
}

static int gather_modes(space_work *k, bake_error *error)
{
    body_work *w = k->w;
    int many = many_points(k->g->like), count = many ? k->pose_count : 1, err = 0;
    for (int i = 0; i < count && err == 0; i++) {
        modes m;
        const double *x = many ? w->pose[k->pose[i]] : k->g->sp.origin;
        err = body_modes(w, &k->f, x, many, &m, error);
        if (err == 0) {
            add_modes(&k->f, &m, &k->v);
            k->noise = fmax(k->noise, m.noise);
            modes_free(&m);
        }
    }
    return err;
}

/* ---- models ----------------------------------------------------------------------------------- */

/* V^T u */
static void reduce(const space *sp, const double *u, double *out)
{
    cblas_dgemv(CblasColMajor, CblasTrans, sp->n, sp->d, 1, sp->V, sp->n, u, 1, 0, out, 1);
}

/* V^T d2V(x) V and V^T dV(x). */
static void elastic_terms(const space_work *k, const double *x, double *K, double *gradient)
{
    body_blocks blocks = {0};
    double *dV = bake_alloc((size_t)k->w->n, sizeof *dV);
    body_hessian(&k->w->b, x, &blocks);
    space_reduce_blocks(&k->g->sp, &blocks, K);
    body_gradient(&k->w->b, x, dV);
    reduce(&k->g->sp, dV, gradient);
    free(dV);
    body_blocks_free(&blocks);
}

static void chain_terms(const space_work *k, const double *q, double *K, double *gradient)
{
    size_t n = (size_t)k->w->n;
    double *H = bake_alloc(n * n, sizeof *H), *dV = bake_alloc(n, sizeof *dV);
    chain_hessian(&k->w->c, q, H);
    space_reduce_dense(&k->g->sp, H, K);
    chain_gradient(&k->w->c, q, dV);
    reduce(&k->g->sp, dV, gradient);
    free(H);
    free(dV);
}

/* V^T f, f: the weight of each vertex; a chain's is part of its potential. */
static void reduced_force(const space_work *k, double *out)
{
    const body_work *w = k->w;
    double *f = bake_alloc((size_t)w->n, sizeof *f);
    for (int i = 0; i < w->n && !is_chain(w); i++) {
        f[i] = w->b.mass[i / 3] * w->from->gravity[i % 3];
    }
    reduce(&k->g->sp, f, out);
    free(f);
}

static int make_model(space_work *k, int pose, linear_model *out, bake_error *error)
{
    const double *x = pose < 0 ? k->g->sp.origin : k->w->pose[pose];
    size_t d = (size_t)k->g->sp.d;
    double *K = bake_alloc(d * d, sizeof *K), *part = bake_alloc(3 * d, sizeof *part);
    double *q_z = part, *gradient = part + d, *force = part + 2 * d;
    bake_error inner = {""};
    space_project(&k->g->sp, x, q_z);
    if (is_chain(k->w)) {
        chain_terms(k, x, K, gradient);
    } else {
        elastic_terms(k, x, K, gradient);
    }
    reduced_force(k, force);
    const linear_terms at = {(int)d, K, q_z, gradient, force, k->noise};
    int err = linear_model_make(&at, out, &inner);
    free(K);
    free(part);
    return err == 0 ? 0 : body_fail(k->w, k->g->like->line, error, "its model: %s", inner.text);
}

static int make_models(space_work *k, bake_error *error)
{
    body_group *g = k->g;
    int err = 0, many = many_points(g->like);
    g->model_count = many ? k->pose_count : 1;
    g->model = bake_alloc((size_t)g->model_count, sizeof *g->model);
    g->pose = bake_alloc((size_t)g->model_count, sizeof *g->pose);
    for (int i = 0; i < g->model_count && err == 0; i++) {
        g->pose[i] = many ? k->pose[i] : -1;
        if (g->like->dynamics == DYNAMICS_SPLINE) {
            linear_model_plain(g->sp.d, &g->model[i]);
        } else {
            err = make_model(k, g->pose[i], &g->model[i], error);
        }
    }
    return err;
}

const linear_model *body_group_model(const body_group *g, int pose)
{
    for (int i = 0; i < g->model_count; i++) {
        if (g->pose[i] == pose) {
            return &g->model[i];
        }
    }
    return &g->model[0];
}

/* ---- on disk ---------------------------------------------------------------------------------- */

static cache_key key_of(const space_work *k)
{
    const body_work *w = k->w;
    cache_key key = w->key;
    cache_key_add(&key, "space 1", 7);
    cache_key_int(&key, (int)k->g->like->dynamics);
    cache_key_int(&key, w->from->modes);
    cache_key_add(&key, w->from->gravity, sizeof w->from->gravity);
    cache_key_add(&key, k->g->sp.origin, (size_t)w->n * sizeof(double));
    cache_key_add(&key, k->f.first, (size_t)(k->f.vertex_count + 1) * sizeof(int));
    cache_key_add(&key, k->f.axis, (size_t)k->f.count * sizeof *k->f.axis);
    cache_key_add(&key, k->pose, (size_t)k->pose_count * sizeof *k->pose);
    cache_key_add(&key, k->v.at, (size_t)k->v.count * (size_t)k->v.n * sizeof(double));
    return key;
}

static void store(const cache_key *key, const body_group *g)
{
    cache_blob blob = {0};
    size_t d = (size_t)g->sp.d;
    cache_put(&blob, &g->sp.d, sizeof(int));
    cache_put(&blob, &g->model_count, sizeof(int));
    cache_put(&blob, g->sp.V, (size_t)g->sp.n * d * sizeof(double));
    cache_put(&blob, g->pose, (size_t)g->model_count * sizeof *g->pose);
    for (int i = 0; i < g->model_count; i++) {
        const linear_model *m = &g->model[i];
        cache_put(&blob, m->lambda, d * sizeof(double));
        cache_put(&blob, m->inner, d * sizeof(double));
        cache_put(&blob, m->outer, d * sizeof(double));
        cache_put(&blob, m->Phi, d * d * sizeof(double));
    }
    cache_store(key, blob.at, blob.count);
    free(blob.at);
}

static int load_model(cache_blob *blob, int d, linear_model *m)
{
    size_t n = (size_t)d;
    linear_model_plain(d, m);
    return cache_take(blob, m->lambda, n * sizeof(double)) == 0 &&
           cache_take(blob, m->inner, n * sizeof(double)) == 0 &&
           cache_take(blob, m->outer, n * sizeof(double)) == 0 &&
           cache_take(blob, m->Phi, n * n * sizeof(double)) == 0;
}

static void forget(body_group *g)
{
    for (int i = 0; i < g->model_count && g->model; i++) {
        linear_model_free(&g->model[i]);
    }
    free(g->model);
    free(g->pose);
    free(g->sp.V);
    g->model = NULL;
    g->pose = NULL;
    g->sp.V = NULL;
    g->model_count = g->sp.d = 0;
}

static int load(const cache_key *key, body_group *g)
{
    cache_blob blob = {0};
    int good;
    blob.at = cache_load(key, &blob.count);
    good = blob.at && cache_take(&blob, &g->sp.d, sizeof(int)) == 0 &&
           cache_take(&blob, &g->model_count, sizeof(int)) == 0;
    if (good) {
        size_t size = (size_t)g->sp.n * (size_t)g->sp.d * sizeof(double);
        g->sp.V = bake_alloc(size + 1, 1);
        g->model = bake_alloc((size_t)g->model_count, sizeof *g->model);
        g->pose = bake_alloc((size_t)g->model_count, sizeof *g->pose);
        good = cache_take(&blob, g->sp.V, size) == 0 &&
               cache_take(&blob, g->pose, (size_t)g->model_count * sizeof *g->pose) == 0;
        for (int i = 0; i < g->model_count && good; i++) {
            good = load_model(&blob, g->sp.d, &g->model[i]);
        }
    }
    free(blob.at);
    if (!good) {
        forget(g);
    }
    return good;
}

/* ----------------------------------------------------------------------------------------------- */

static void set_mass(const body_work *w, space *sp)
{
    size_t n = (size_t)w->n;
    if (is_chain(w)) {
        sp->M = bake_alloc(n * n, sizeof *sp->M);
        chain_mass(&w->c, sp->origin, sp->M);
        return;
    }
    sp->mass = bake_alloc(n, sizeof *sp->mass);
    for (size_t i = 0; i < n; i++) {
        sp->mass[i] = w->b.mass[i / 3];
    }
}

/* A chain's space is all of its coordinates. */
static void gather_all(space_work *k)
{
    k->v.count = 0;
    for (int i = 0; i < k->w->n; i++) {
        add_vector(&k->v)[i] = 1;
    }
}

static int make_space(space_work *k, bake_error *error)
{
    const scene_action *a = k->g->like;
    bake_error inner = {""};
    if (gather_poses(k, error) < 0) {
        return -1;
    }
    cache_key key = {0};
    if (is_chain(k->w)) {
        if (body_own_modes(k->w, error) < 0) {
            return -1;
        }
        k->noise = k->w->own.noise;
        gather_all(k);
    } else {
        key = key_of(k);
        if (load(&key, k->g)) {
            return 0;
        }
        if (a->dynamics != DYNAMICS_SPLINE && gather_modes(k, error) < 0) {
            return -1;
        }
    }
    if (space_make(&k->g->sp, k->v.at, k->v.count, &inner) < 0) {
        return body_fail(k->w, a->line, error, "%s", inner.text);
    }
    if (k->g->sp.d == 0) {
        return body_fail(k->w, a->line, error,
                         "none of its poses differs from rest and no key has a velocity: nothing "
                         "moves");
    }
    if (make_models(k, error) < 0) {
        return -1;
    }
    if (!is_chain(k->w)) {
        store(&key, k->g);
    }
    return 0;
}

static int make_group(body_work *w, const scene_action *a, body_group *g, bake_error *error)
{
    const double *origin;
    space_work k = {.w = w, .g = g, .v = {.n = w->n}};
    *g = (body_group){.like = a};
    if (body_pose(w, a->about, &origin, error) < 0) {
        return -1;
    }
    g->sp.n = w->n;
    g->sp.origin = bake_alloc((size_t)w->n, sizeof *g->sp.origin);
    memcpy(g->sp.origin, origin, (size_t)w->n * sizeof *origin);
    set_mass(w, &g->sp);
    if (!is_chain(w)) {
        body_holds holds = holds_of(w->from, a);
        body_hold(w, &holds, &k.f);
    }
    int err = make_space(&k, error);
    freedom_free(&k.f);
    free(k.v.at);
    free(k.pose);
    return err;
}

int body_group_of(body_work *w, const scene_action *a, bake_error *error)
{
    for (int i = 0; i < w->group_count; i++) {
        if (same_group(w->from, a, w->group[i].like)) {
            return i;
        }
    }
    w->group = bake_grow(w->group, (size_t)w->group_count + 1, sizeof *w->group);
    int err = make_group(w, a, &w->group[w->group_count++], error);
    return err < 0 ? -1 : w->group_count - 1;
}

void body_group_free(body_group *g)
{
    forget(g);
    space_free(&g->sp);
}
