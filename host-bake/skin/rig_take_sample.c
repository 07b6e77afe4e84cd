/* Captures on rigs: how bones turn and travel, at the source's own keys.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_take_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* Sources store float times: two instants closer than this are one. */
static const double same_time = 1e-6;

/* Keys further apart than this are not samples but poses, between which a node turns along the
 * shortest arc and moves on a straight line, with a corner at each: a curve of cubics through
 * samples every 2 degrees misses the arc by 1e-6. */
static const double sparse_time = 0.05, arc_step = 2 * PI / 180;

typedef struct {
    double time;
    int kink;
} moment;

typedef struct {
    int count, room;
    double start, end;
    moment *at;
} moments;

static void add_moment(moments *m, double time, int kink)
{
    if (time < m->start || time > m->end) {
        return;
    }
    if (m->count == m->room) {
        m->room = m->room ? 2 * m->room : 256;
        m->at = bake_grow(m->at, (size_t)m->room, sizeof *m->at);
    }
    m->at[m->count++] = (moment){time, kink};
}

/* How far a node turns, or whether it moves, from key i - 1 to i. Before the first and behind the
 * last key it stands still. */
static double change(const node_keys *keys, int i)
{
    if (i == 0 || i == keys->count) {
        return 0;
    }
    const double *a = keys->value + (size_t)(i - 1) * (size_t)keys->width, *b = a + keys->width;
    double sum = 0;
    for (int k = 0; k < keys->width; k++) {
        sum += keys->width == 4 ? a[k] * b[k] : fabs(b[k] - a[k]);
    }
    return keys->width == 4 ? 2 * acos(fmin(fabs(sum), 1)) : sum;
}

static int is_sparse(const moments *m, const node_keys *keys, int i)
{
    double from = i > 0 ? keys->time[i - 1] : m->start;
    return (i < keys->count ? keys->time[i] : m->end) - from > sparse_time;
}

/* At a whole millisecond, which a clip's tick is where it can be: samples move to ticks. */
static void add_between(moments *m, double time, double end)
{
    time = m->start + floor((time - m->start) * 1000 + 0.5) / 1000;
    if (time < end - same_time) {
        add_moment(m, time, 0);
    }
}

/* A corner is where a node starts or stops moving, or changes direction, beside a gap: a smooth
 * curve would go on into the gap. */
static void add_keys(moments *m, const node_keys *keys)
{
    const double least = keys->width == 4 ? 1e-4 : 0;
    for (int i = 0; i < keys->count; i++) {
        int sparse = is_sparse(m, keys, i), moves = change(keys, i) > least;
        int kink = (sparse || is_sparse(m, keys, i + 1)) && (moves || change(keys, i + 1) > least);
        int steps = sparse && moves && keys->width == 4 ? 1 + (int)(change(keys, i) / arc_step) : 1;
        for (int k = 1; k < steps; k++) {
            double way = keys->time[i] - keys->time[i - 1];
            add_between(m, keys->time[i - 1] + k * way / steps, keys->time[i]);
        }
        add_moment(m, keys->time[i], kink);
    }
}

static int by_time(const void *a, const void *b)
{
    double x = ((const moment *)a)->time, y = ((const moment *)b)->time;
    return (x > y) - (x < y);
}

/* Sorts; what is one instant becomes one moment, start and end stay. */
static void merge(moments *m)
{
    int count = 1;
    add_moment(m, m->start, 0);
    add_moment(m, m->end, 0);
    qsort(m->at, (size_t)m->count, sizeof *m->at, by_time);
    for (int i = 1; i < m->count; i++) {
        if (m->at[i].time > m->at[count - 1].time + same_time) {
            m->at[count++] = m->at[i];
        } else {
            m->at[count - 1].kink |= m->at[i].kink;
        }
    }
    m->at[0].time = m->start;
    m->at[count - 1].time = m->end;
    m->count = count;
}

/* Whether `above` is an ancestor of a node, or -1. */
static int is_above(const rig_nodes *n, int above, int node)
{
    while (node >= 0 && node != above) {
        node = n->node[node].parent;
    }
    return node == above;
}

/* Keys of the nodes from one up to below `above`. */
static void add_chain(const take_work *w, int node, int above, int travels, moments *m)
{
    for (int i = node; i != above && i >= 0; i = w->nodes.node[i].parent) {
        if (!travels || i != node) {
            add_keys(m, &w->nodes.node[i].keys[1]);
        }
        if (travels) {
            add_keys(m, &w->nodes.node[i].keys[0]);
        }
    }
}

static void find_moments(const take_work *w, const take_track *t, moments *m)
{
    int node = w->node[t->bone], above = w->above[t->bone];
    int parent = t->width == 4 && above >= 0 ? w->node[above] : -1;
    *m = (moments){.start = w->start, .end = w->end};
    if (is_above(&w->nodes, parent, node)) {
        add_chain(w, node, parent, t->width == 3, m);
    } else {
        add_chain(w, node, -1, 0, m);
        add_chain(w, parent, -1, 0, m);
    }
    merge(m);
}

/* R: how a bone is turned at `time`. */
static int turn_of(const take_work *w, int bone, double time, double r[4])
{
    affine now, moved;
    double q[4];
    rig_nodes_pose(&w->nodes, w->node[bone], time, &now);
    moved = affine_product(&now, &w->unbind[bone]);
    if (affine_rotation(&moved, q)) {
        return take_fail(w, "the node '%.60s' of '%s' has no size, or is mirrored, at %g s",
                         w->rig->bones[bone].node, w->s->sources[w->take->source].file, time);
    }
    quaternion_product(q, w->align[bone], r);
    return 0;
}

/* R_p^-1 R, on the side of the sample before. */
static int rotation_at(const take_work *w, int bone, double time, const double *before, double *out)
{
    double r[4], parent[4] = {1, 0, 0, 0}, square = 0, dot = 0;
    if (turn_of(w, bone, time, r) ||
        (w->above[bone] >= 0 && turn_of(w, w->above[bone], time, parent))) {
        return -1;
    }
    for (int k = 1; k < 4; k++) {
        parent[k] = -parent[k];
    }
    quaternion_product(parent, r, out);
    for (int k = 0; k < 4; k++) {
        square += out[k] * out[k];
        dot += before ? before[k] * out[k] : k == 0 ? out[0] : 0;
    }
    for (int k = 0; k < 4; k++) {
        out[k] /= (dot < 0 ? -1 : 1) * sqrt(square);
    }
    return 0;
}

/* From where the node is when the take begins, so that the character starts where it stands; of a rig's
 * own file from its bind pose, which is where it stands. */
static int travel_at(const take_work *w, int bone, double time, double *out)
{
    affine now, first = w->nodes.node[w->node[bone]].bind;
    rig_nodes_pose(&w->nodes, w->node[bone], time, &now);
    if (!w->own) {
        rig_nodes_pose(&w->nodes, w->node[bone], w->start, &first);
    }
    for (int k = 0; k < 3; k++) {
        out[k] = w->scale * (now.at[k][3] - first.at[k][3]);
        if (!(fabs(out[k]) < 1e8)) {
            return take_fail(w, "the node '%.60s' of '%s' is too far away at %g s; use 'scale'",
                             w->rig->bones[bone].node, w->s->sources[w->take->source].file, time);
        }
    }
    return 0;
}

static int fill(const take_work *w, const moments *m, take_track *t)
{
    t->time = bake_alloc((size_t)m->count, sizeof *t->time);
    t->kink = bake_alloc((size_t)m->count, 1);
    t->value = bake_alloc((size_t)m->count * (size_t)t->width, sizeof *t->value);
    for (int i = 0; i < m->count; i++) {
        double *value = t->value + (size_t)i * (size_t)t->width;
        t->time[i] = m->at[i].time - w->start;
        t->kink[i] = (char)m->at[i].kink;
        if (t->width == 4 ? rotation_at(w, t->bone, m->at[i].time, i > 0 ? value - 4 : NULL, value)
                          : travel_at(w, t->bone, m->at[i].time, value)) {
            return -1;
        }
        t->count = i + 1;
    }
    return 0;
}

int take_sample(const take_work *w, take_track *t)
{
    moments m;
    find_moments(w, t, &m);
    int err = m.count > TRACK_SAMPLES_MAX
                  ? take_fail(w, "'%s' has %d keys there; choose fewer with 'from' and 'to'",
                              w->s->sources[w->take->source].file, m.count)
                  : fill(w, &m, t);
    free(m.at);
    return err;
}
