/* Captures on rigs: the process that reads sources, one file after the other.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_take_parts.h"
#include "scene_names.h"
#include "vector.h"

#include <assimp/cimport.h>

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Sources store float times: two instants closer than this are one. */
static const double same_time = 1e-6;

int take_fail(const take_work *w, const char *format, ...)
{
    char what[800];
    va_list list;
    va_start(list, format);
    vsnprintf(what, sizeof what, format, list);
    va_end(list);
    return bake_fail(w->error, "%s:%d: %s", w->s->path, w->take->line, what);
}

/* ---- bones and nodes ------------------------------------------------------------------------- */

/* A file names all its bones as nodes; a capture need not have every finger of them. */
static int may_lack(const scene_rig *rig, const scene_bone *b)
{
    return rig->file != NULL && b->captured < 0;
}

static int fail_node(const take_work *w, const char *wanted)
{
    char hint[SCENE_HINT_BYTES];
    scene_names_hint(&SCENE_NAMES(w->nodes.node, w->nodes.count), wanted, hint);
    return take_fail(w, "'%s' has no node '%.60s'; %s", w->s->sources[w->take->source].file, wanted,
                     hint);
}

static int find_nodes(take_work *w)
{
    const char *missing = "";
    int found = 0;
    for (int i = 0; i < w->rig->bone_count; i++) {
        const scene_bone *b = &w->rig->bones[i];
        w->node[i] = b->node != NULL ? rig_nodes_find(&w->nodes, b->node) : -1;
        found += w->node[i] >= 0;
        w->above[i] = b->parent;
        while (w->above[i] >= 0 && w->node[w->above[i]] < 0) {
            w->above[i] = w->rig->bones[w->above[i]].parent;
        }
        if (b->node != NULL && w->node[i] < 0) {
            missing = b->node;
            if (!may_lack(w->rig, b)) {
                return fail_node(w, missing);
            }
        }
    }
    return found > 0 ? 0 : fail_node(w, missing);
}

/* The node of a bone that begins where bone i ends. */
static int next_node(const take_work *w, int i)
{
    const scene_bone *b = &w->rig->bones[i];
    for (int k = i + 1; k < w->rig->bone_count; k++) {
        const scene_bone *c = &w->rig->bones[k];
        double apart = 0, size = 0;
        for (int a = 0; a < 3; a++) {
            apart += fabs(c->from[a] - b->to[a]);
            size += fabs(b->to[a]) + fabs(b->from[a]);
        }
        if (c->parent == i && w->node[k] >= 0 && apart <= 1e-6 * size) {
            return w->node[k];
        }
    }
    return -1;
}

/* Which way a bone's node points at bind; 0: no way. */
static int node_way(const take_work *w, int i, double way[3])
{
    const rig_node *n = w->nodes.node;
    int next = next_node(w, i);
    double square = 0;
    for (int k = 0; k < 3 && next >= 0; k++) {
        way[k] = n[next].bind.at[k][3] - n[w->node[i]].bind.at[k][3];
        square += way[k] * way[k];
    }
    return square > 0 || rig_nodes_child(&w->nodes, w->node[i], way) >= 0;
}

/* The shortest rotation that makes the direction of a that of b. */
static void shortest_arc(const double a[3], const double b[3], double q[4])
{
    double lengths = sqrt(vector_dot(a, a) * vector_dot(b, b));
    q[0] = 1 + vector_dot(a, b) / lengths;
    vector_cross(a, b, q + 1);
    for (int k = 1; k < 4; k++) {
        q[k] /= lengths;
    }
    if (q[0] < 1e-12) { /* opposite: about any axis across, the one farthest from a */
        int least = fabs(a[0]) < fabs(a[1]) ? 0 : 1;
        least = fabs(a[2]) < fabs(a[least]) ? 2 : least;
        double axis[3] = {0};
        axis[least] = 1;
        q[0] = 0;
        vector_cross(a, axis, q + 1);
    }
    double length = sqrt(q[0] * q[0] + vector_dot(q + 1, q + 1));
    for (int k = 0; k < 4; k++) {
        q[k] /= length;
    }
}

static void align_bone(take_work *w, int i)
{
    const scene_bone *b = &w->rig->bones[i];
    double rest[3], way[3];
    for (int k = 0; k < 3; k++) {
        rest[k] = b->to[k] - b->from[k];
    }
    if (vector_dot(rest, rest) > 0 && node_way(w, i, way)) {
        shortest_arc(rest, way, w->align[i]);
    } else if (w->above[i] >= 0) {
        memcpy(w->align[i], w->align[w->above[i]], sizeof *w->align);
    } else {
        w->align[i][0] = 1;
    }
}

int take_align(take_work *w)
{
    size_t count = (size_t)w->rig->bone_count;
    w->node = bake_alloc(count, sizeof *w->node);
    w->above = bake_alloc(count, sizeof *w->above);
    w->align = bake_alloc(count, sizeof *w->align);
    w->unbind = bake_alloc(count, sizeof *w->unbind);
    if (find_nodes(w)) {
        return -1;
    }
    for (int i = 0; i < w->rig->bone_count; i++) {
        if (w->node[i] < 0) {
            continue;
        }
        align_bone(w, i);
        if (affine_inverse(&w->nodes.node[w->node[i]].bind, &w->unbind[i])) {
            return take_fail(w, "the node '%.60s' of '%s' has no size in its bind pose",
                             w->rig->bones[i].node, w->s->sources[w->take->source].file);
        }
    }
    return 0;
}

/* ---- one take -------------------------------------------------------------------------------- */

/* From the first key to the last one of any node. */
static int find_span(take_work *w)
{
    double first = HUGE_VAL, last = -HUGE_VAL;
    for (int i = 0; i < 3 * w->nodes.count; i++) {
        const node_keys *keys = &w->nodes.node[i / 3].keys[i % 3];
        if (keys->count > 0) {
            first = fmin(first, keys->time[0]);
            last = fmax(last, keys->time[keys->count - 1]);
        }
    }
    const char *file = w->s->sources[w->take->source].file;
    if (!(last > first)) {
        return take_fail(w, "animation %d of '%s' moves no node",
                         w->s->sources[w->take->source].animation, file);
    }
    w->start = w->take->from > 0 ? w->take->from : first;
    w->end = w->take->to > 0 ? w->take->to : last;
    if (w->start < first - same_time || w->end > last + same_time ||
        w->end - w->start < same_time) {
        return take_fail(w,
                         "the capture is asked for %g .. %g s of '%s', which lasts from %g to %g "
                         "s; change 'from' or 'to'",
                         w->start, w->end, file, first, last);
    }
    return 0;
}

/* A rig's own file has the axes and the scale of its mesh. */
static affine world_of(take_work *w)
{
    affine world = affine_identity();
    const scene_mesh *m = w->rig->mesh >= 0 ? &w->s->meshes[w->rig->mesh] : NULL;
    const char *source = w->s->sources[w->take->source].file;
    int own = m != NULL && ((w->rig->file != NULL && strcmp(w->rig->file, source) == 0) ||
                            (m->file != NULL && strcmp(m->file, source) == 0));
    w->own = own;
    w->scale = w->take->scale * (own ? m->scale : 1);
    if (own && m->up == 'z') {
        world = (affine){{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}}};
    }
    return world;
}

static int read_take(take_work *w, const struct aiScene *file, taking *all)
{
    affine world = world_of(w);
    rig_nodes_make(file, &world, &w->nodes);
    const scene_source *source = &w->s->sources[w->take->source];
    const char *bad = rig_nodes_animate(&w->nodes, file->mAnimations[source->animation]);
    if (bad != NULL) {
        return take_fail(w, "a key of '%.60s' in '%s' is no finite number", bad, source->file);
    }
    if (find_span(w) || take_align(w)) {
        return -1;
    }
    for (int i = 0; i < all->count; i++) {
        take_track *t = &all->track[i];
        if (take_of(w->s, t) == w->take && w->node[t->bone] >= 0 && take_sample(w, t)) {
            return -1;
        }
    }
    return 0;
}

static void free_work(take_work *w)
{
    rig_nodes_free(&w->nodes);
    free(w->node);
    free(w->above);
    free(w->align);
    free(w->unbind);
}

static int check_source(const take_work *w, const struct aiScene *file)
{
    const scene_source *source = &w->s->sources[w->take->source];
    if (file == NULL) {
        return take_fail(w, "'%s' cannot be read: %s", source->file, aiGetErrorString());
    }
    if (file->mNumAnimations == 0 || file->mRootNode == NULL) {
        return take_fail(w, "'%s' has no animation; a capture needs one", source->file);
    }
    if ((unsigned)source->animation >= file->mNumAnimations) {
        return take_fail(w, "'%s' has %u animations; 'animation' counts from 0 and is %d",
                         source->file, file->mNumAnimations, source->animation);
    }
    return 0;
}

/* All takes of one source. */
static int read_source(taking *all, int source, isolate_note *now, bake_error *error)
{
    const struct aiScene *file = NULL;
    const scene_take *done = NULL;
    int err = 0;
    for (int i = 0; i < all->count && err == 0; i++) {
        const scene_take *take = take_of(all->s, &all->track[i]);
        if (take->source != source || take == done) {
            continue;
        }
        take_work w = {.s = all->s, .take = take, .rig = &all->s->rigs[take->rig], .error = error};
        isolate_now(now, take->line, all->s->sources[source].file);
        if (done == NULL) {
            file = rig_nodes_open(all->s->sources[source].file);
        }
        err = check_source(&w, file) || read_take(&w, file, all) ? -1 : 0;
        done = take;
        free_work(&w);
    }
    if (file != NULL) {
        aiReleaseImport(file);
    }
    return err;
}

int take_read(taking *all, isolate_note *now, bake_error *error)
{
    for (int i = 0; i < all->s->source_count; i++) {
        if (read_source(all, i, now, error)) {
            return -1;
        }
    }
    return 0;
}
