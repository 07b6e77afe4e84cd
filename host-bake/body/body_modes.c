/* Modes of a body as it is held somewhere, from disk when they have been solved before.
 * Source: Schulz 2013, 2.2.2, algorithm 2.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <stdlib.h>
#include <string.h>

/* Directions in which a body may move as a whole. */
#define RIGID 6

static cache_key key_of(const body_work *w, const freedom *f, const double *x, int moved)
{
    cache_key key = w->key;
    cache_key_add(&key, "modes 1", 7);
    cache_key_int(&key, moved);
    cache_key_int(&key, w->from->modes);
    cache_key_add(&key, x, (size_t)w->n * sizeof *x);
    cache_key_add(&key, f->first, (size_t)(f->vertex_count + 1) * sizeof *f->first);
    cache_key_add(&key, f->axis, (size_t)f->count * sizeof *f->axis);
    return key;
}

static void store(const cache_key *key, const modes *m)
{
    cache_blob blob = {0};
    const int heads[4] = {m->n, m->count, m->negative, m->rigid};
    cache_put(&blob, heads, sizeof heads);
    cache_put(&blob, &m->noise, sizeof m->noise);
    cache_put(&blob, m->lambda, (size_t)m->count * sizeof *m->lambda);
    cache_put(&blob, m->residual, (size_t)m->count * sizeof *m->residual);
    cache_put(&blob, m->phi, (size_t)m->count * (size_t)m->n * sizeof *m->phi);
    cache_store(key, blob.at, blob.count);
    free(blob.at);
}

static int load(const cache_key *key, modes *m)
{
    int heads[4];
    cache_blob blob = {0};
    blob.at = cache_load(key, &blob.count);
    memset(m, 0, sizeof *m);
    if (!blob.at || cache_take(&blob, heads, sizeof heads) < 0) {
        free(blob.at);
        return 0;
    }
    *m = (modes){.n = heads[0], .count = heads[1], .negative = heads[2], .rigid = heads[3]};
    size_t n = (size_t)m->n, k = (size_t)m->count;
    m->lambda = bake_alloc(k + 1, sizeof *m->lambda);
    m->residual = bake_alloc(k + 1, sizeof *m->residual);
    m->phi = bake_alloc(n * k + 1, sizeof *m->phi);
    int good = cache_take(&blob, &m->noise, sizeof m->noise) == 0 &&
               cache_take(&blob, m->lambda, k * sizeof *m->lambda) == 0 &&
               cache_take(&blob, m->residual, k * sizeof *m->residual) == 0 &&
               cache_take(&blob, m->phi, n * k * sizeof *m->phi) == 0;
    free(blob.at);
    if (!good) {
        modes_free(m);
    }
    return good;
}

/* d2V(x), or d2V at x of the potential that is at rest there. */
static int hessian(const body_work *w, const double *x, int moved, body_blocks *out,
                   bake_error *error)
{
    body other = w->b;
    if (!moved) {
        body_hessian(&w->b, x, out);
        return 0;
    }
    size_t at = (size_t)w->n * sizeof *x;
    size_t elements = (size_t)w->b.element_count * sizeof *w->b.element;
    other.rest = memcpy(bake_alloc(at, 1), x, at);
    other.element = memcpy(bake_alloc(elements, 1), w->b.element, elements);
    other.mass = NULL;
    other.elements = NULL;
    int err = body_prepare(&other, error);
    if (err == 0) {
        body_hessian(&other, x, out);
    }
    body_free(&other);
    return err;
}

/* more: beside the modes that are wanted and those that are rigid. */
static int solve(const body_work *w, const freedom *f, const body_blocks *blocks, int more,
                 modes *out, bake_error *error)
{
    sparse K;
    if (sparse_from_blocks(blocks, f, &K, error) < 0) {
        return -1;
    }
    double *M = bake_alloc((size_t)f->count, sizeof *M);
    for (int i = 0; i < f->vertex_count; i++) {
        for (int j = f->first[i]; j < f->first[i + 1]; j++) {
            M[j] = w->b.mass[i];
        }
    }
    int most = f->count - 1, count = w->from->modes + RIGID + more;
    int err = modes_solve(&K, M, count < most ? count : most, out, error);
    free(M);
    sparse_free(&K);
    return err;
}

/* Nothing holds it, and it is at rest: it has all rigid motions. One vector at a time, ARPACK finds
 * copies of an eigenvalue by rounding alone; should one be missing, a larger space finds it. */
#define MORE 6

static int floats(const body_work *w, const freedom *f, const double *x, int moved)
{
    return f->count == w->n && (moved || memcmp(x, w->rest, (size_t)w->n * sizeof *x) == 0);
}

/* k elastic modes behind the others. */
static void cut(modes *m, int k)
{
    int most = m->negative + m->rigid + k;
    m->count = m->count < most ? m->count : most;
}

/* For messages: the pose that x is. */
static const scene_pose *pose_of(const body_work *w, const double *x)
{
    size_t size = (size_t)w->n * sizeof *x;
    for (int i = 1; i < w->from->pose_count; i++) {
        if (w->pose[i] && memcmp(w->pose[i], x, size) == 0) {
            return &w->from->poses[i];
        }
    }
    return &w->from->poses[0];
}

int body_modes(const body_work *w, const freedom *f, const double *x, int moved, modes *out,
               bake_error *error)
{
    bake_error inner = {""};
    cache_key key = key_of(w, f, x, moved);
    if (load(&key, out)) {
        return 0;
    }
    if (f->count < 2) {
        return body_fail(w, w->from->line, error,
                         "%s: free more of its vertices, or give it a smaller `cell`",
                         f->count == 0 ? "everything is fixed, so that nothing can move"
                                       : "one vertex alone can move, and in one direction only");
    }
    body_progress(w, "modes");
    body_blocks blocks = {0};
    int err = hessian(w, x, moved, &blocks, &inner);
    if (err == 0) {
        err = solve(w, f, &blocks, 0, out, &inner);
    }
    if (err == 0 && floats(w, f, x, moved) && out->rigid < RIGID) {
        modes_free(out);
        err = solve(w, f, &blocks, MORE, out, &inner);
    }
    body_blocks_free(&blocks);
    if (err < 0) {
        const scene_pose *pose = pose_of(w, x);
        return body_fail(w, pose->line, error, "its modes in the pose '%s': %s", pose->name,
                         inner.text);
    }
    cut(out, w->from->modes);
    store(&key, out);
    return 0;
}

/* A chain's: all of them. */
static int chain_modes(body_work *w, bake_error *error)
{
    size_t n = (size_t)w->n;
    bake_error inner = {""};
    double *K = bake_alloc(n * n, sizeof *K), *M = bake_alloc(n * n, sizeof *M);
    chain_hessian(&w->c, w->rest, K);
    chain_mass(&w->c, w->rest, M);
    int err = modes_dense(K, M, w->n, &w->own, &inner);
    free(K);
    free(M);
    return err == 0 ? 0 : body_fail(w, w->from->line, error, "its modes: %s", inner.text);
}

int body_own_modes(body_work *w, bake_error *error)
{
    return w->own.count > 0 ? 0
           : is_chain(w)    ? chain_modes(w, error)
                            : body_modes(w, &w->held, w->rest, 0, &w->own, error);
}
