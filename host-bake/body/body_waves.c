/* Bases and curves of a body whose motion is that of linear models: modal shapes, and their wiggly
 * splines as the player plays them.
 * Source: Schulz 2013, algorithm 1: x(t) = x + Phi w(t); the scale of a channel is ours.
 *   B   3 vertices x 1   what a channel value of 1 does to a mesh: the vertex that moves most moves
 *     by 1
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the tolerance: what all modes together may do that are left out. */
#define DROP_SHARE 0.2

#define CHANNELS_MOST 128

/* A mode of a group as a channel. */
typedef struct {
    int group, mode;
    double scale; /* scene units that c = 1 moves the vertex that moves most */
    double most;  /* of the channel, over all frames */
} wave;

typedef struct {
    body_work *w;
    const body_clip *clips;
    int clip_count, count;
    wave *wave;
} waves_work;

/* Where a hard velocity meets a pose between the ends, the motion is C1, its channels' splines
 * would be C2. */
static int has_stops(const body_run *r)
{
    int found = 0;
    for (int k = 1; k + 1 < r->from->key_count; k++) {
        const space_key *key = &r->key[k];
        found |= key->v && key->weight[1] < 0 && (key->rows > 0 || key->weight[0] < 0);
    }
    return found;
}

int body_waves_possible(const body_clip *clips, int count)
{
    for (int i = 0; i < count; i++) {
        int main = 0;
        for (int j = 0; j < clips[i].count; j++) {
            const body_run *r = &clips[i].run[j];
            int dynamics = r->from->dynamics;
            main += !r->from->add;
            if (dynamics == DYNAMICS_BLEND || dynamics == DYNAMICS_COUPLE || r->from->about != 0 ||
                has_stops(r)) {
                return 0;
            }
            for (int k = 0; k < j; k++) {
                if (clips[i].run[k].group == r->group) {
                    return 0; /* a channel is one spline */
                }
            }
        }
        if (main > 1) {
            return 0;
        }
    }
    return 1;
}

static const body_run *run_of(const body_clip *c, int group)
{
    for (int i = 0; i < c->count; i++) {
        if (c->run[i].group == group) {
            return &c->run[i];
        }
    }
    return NULL;
}

/* ---- bases ------------------------------------------------------------------------------------ */

/* What c = 1 does, in scene units. */
static void mode_shape(const body_work *w, const body_target *target, const wave *v, double *u,
                       double *out)
{
    const body_group *g = &w->group[v->group];
    const double *phi = g->model[0].Phi + (size_t)v->mode * (size_t)g->sp.d;
    memset(u, 0, (size_t)w->n * sizeof *u);
    for (int j = 0; j < g->sp.d; j++) {
        const double *V = g->sp.V + (size_t)j * (size_t)w->n;
        for (int i = 0; i < w->n; i++) {
            u[i] += phi[j] * V[i];
        }
    }
    body_surface_shift(w, target, u, out);
}

static void find_scale(const body_work *w, wave *v)
{
    double *u = bake_alloc((size_t)w->n, sizeof *u), most = 0;
    for (int i = 0; i < w->target_count; i++) {
        int count = w->target[i].m->mesh.vertex_count;
        double *at = bake_alloc(3 * (size_t)count, sizeof *at);
        mode_shape(w, &w->target[i], v, u, at);
        for (int k = 0; k < 3 * count; k += 3) {
            most = fmax(most, sqrt(at[k] * at[k] + at[k + 1] * at[k + 1] + at[k + 2] * at[k + 2]));
        }
        free(at);
    }
    free(u);
    v->scale = most;
}

static void find_most(waves_work *k, wave *v)
{
    for (int i = 0; i < k->clip_count; i++) {
        const body_clip *c = &k->clips[i];
        const body_run *r = run_of(c, v->group);
        double out[4];
        for (int j = 0; r && j <= 512; j++) {
            bake_curve_eval(&r->m.term[0].curve[v->mode],
                            r->m.from + (r->m.to - r->m.from) * j / 512, out);
            v->most = fmax(v->most, fabs(out[0]) * v->scale);
        }
    }
}

static void gather(waves_work *k)
{
    for (int g = 0; g < k->w->group_count; g++) {
        for (int i = 0; i < k->w->group[g].sp.d; i++) {
            k->wave = bake_grow(k->wave, (size_t)k->count + 1, sizeof *k->wave);
            wave *v = &k->wave[k->count++];
            *v = (wave){.group = g, .mode = i};
            find_scale(k->w, v);
            find_most(k, v);
        }
    }
}

/* Modes that nobody sees: the smallest ones that together stay within their share. */
static void drop(waves_work *k)
{
    double room = DROP_SHARE * body_tolerance(k->w);
    for (;;) {
        int least = -1;
        for (int i = 0; i < k->count; i++) {
            least = least < 0 || k->wave[i].most < k->wave[least].most ? i : least;
        }
        if (k->count <= 1 || (room -= k->wave[least].most) < 0) {
            return;
        }
        memmove(k->wave + least, k->wave + least + 1,
                (size_t)(--k->count - least) * sizeof *k->wave);
    }
}

/* ---- curves ----------------------------------------------------------------------------------- */

static void still_curve(const body_clip *c, scene_curve *out)
{
    out->kind = CURVE_HELD;
    out->key_count = 2;
    out->keys = bake_alloc(2, sizeof *out->keys);
    for (int i = 0; i < 2; i++) {
        out->keys[i].time = i * c->to;
        out->keys[i].weight[0] = BAKE_HARD;
    }
}

static void wave_curve(const waves_work *k, const body_run *r, const wave *v, scene_curve *out)
{
    bake_spline_problem p;
    int n = r->from->key_count;
    const linear_model *model = &k->w->group[v->group].model[0];
    motion_mode_problem(model, &r->settings, v->mode, &p);
    out->kind = CURVE_WIGGLY;
    out->mode = p.mode;
    out->mode.g *= v->scale;
    out->key_count = n;
    out->keys = bake_alloc((size_t)n, sizeof *out->keys);
    motion_mode_keys(&r->in, v->mode, &r->m, out->keys);
    for (int i = 0; i < n; i++) {
        for (int a = 0; a < 3; a++) {
            out->keys[i].target[a] *= v->scale;
        }
    }
    for (int i = 0; i < 2; i++) {
        out->end[i] = p.end[i];
        out->end_value[i] = p.end_value[i] * v->scale;
    }
    out->regularise[0] = p.alpha;
    out->regularise[1] = p.beta;
    out->regularise[2] = p.gamma;
}

static void make_curves(const waves_work *k, shape_given *g)
{
    for (int j = 0; j < k->count; j++) {
        const wave *v = &k->wave[j];
        for (int i = 0; i < k->clip_count; i++) {
            const body_clip *c = &k->clips[i];
            const body_run *r = run_of(c, v->group);
            if (c->count == 0 || (!r && c->adds)) {
                continue;
            }
            g->curve = bake_grow(g->curve, (size_t)g->curve_count + 1, sizeof *g->curve);
            given_curve *to = &g->curve[g->curve_count++];
            *to = (given_curve){.clip = c->clip, .basis = j};
            to->curve = (scene_curve){
                .line = r ? r->from->line : c->run[0].from->line, .source = -1, .scale = 1};
            if (r) {
                wave_curve(k, r, v, &to->curve);
            } else {
                still_curve(c, &to->curve);
            }
        }
    }
}

/* ---- meshes ----------------------------------------------------------------------------------- */

/* Weights in the frames that body_show has made. */
static void make_weights(const waves_work *k, shape_mesh *m)
{
    int frames = 0;
    for (int i = 0; i < m->mesh.frames_count; i++) {
        frames += m->mesh.frames[i].count;
    }
    m->given_weight = bake_alloc((size_t)k->count * (size_t)frames + 1, sizeof(double));
    for (int j = 0; j < k->count; j++) {
        double *to = m->given_weight + (size_t)j * (size_t)frames, out[4];
        for (int i = 0; i < m->mesh.frames_count; i++) {
            const mesh_frames *f = &m->mesh.frames[i];
            const body_run *r = NULL;
            for (int c = 0; c < k->clip_count; c++) {
                r = k->clips[c].clip == f->clip ? run_of(&k->clips[c], k->wave[j].group) : r;
            }
            for (int a = 0; a < f->count; a++, to++) {
                if (r) {
                    bake_curve_eval(&r->m.term[0].curve[k->wave[j].mode], f->time[a], out);
                    *to = out[0] * k->wave[j].scale;
                }
            }
        }
    }
}

static void make_bases(const waves_work *k, const body_target *target)
{
    shape_mesh *m = target->m;
    size_t rows = 3 * (size_t)m->mesh.vertex_count;
    double *u = bake_alloc((size_t)k->w->n, sizeof *u);
    m->given_basis = bake_alloc((size_t)k->count * rows + 1, sizeof *m->given_basis);
    for (int j = 0; j < k->count; j++) {
        double *to = m->given_basis + rows * (size_t)j;
        mode_shape(k->w, target, &k->wave[j], u, to);
        for (size_t i = 0; i < rows && k->wave[j].scale > 0; i++) {
            to[i] /= k->wave[j].scale;
        }
    }
    free(u);
}

int body_waves(body_work *w, const body_clip *clips, int count, shape_given *out, bake_error *error)
{
    waves_work k = {w, clips, count, 0, NULL};
    gather(&k);
    drop(&k);
    if (k.count > CHANNELS_MOST) {
        int n = k.count;
        free(k.wave);
        return body_fail(w, w->from->line, error,
                         "its motions take %d modes, a mesh holds %d: lower `modes`, or raise the "
                         "mesh's tolerance",
                         n, CHANNELS_MOST);
    }
    *out = (shape_given){.owner = w->from->name, .count = k.count, .channel = -1};
    make_curves(&k, out);
    for (int i = 0; i < w->target_count; i++) {
        make_bases(&k, &w->target[i]);
        make_weights(&k, w->target[i].m);
        w->target[i].m->given = out;
    }
    free(k.wave);
    return 0;
}
