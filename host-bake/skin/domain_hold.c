/* Which vertices a handle holds, and with which values. All is found by place: what lies on a bone or
 * facet is held by it, whether it was made for that or not; a sample that got no vertex of its own
 * takes the nearest one that is left.
 * Source: Jacobson 2013, 4.3 (joints), (4.3)-(4.4); what is nearest is own.
 *   value  rows of m handles, one for each vertex that is held
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_parts.h"
#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Facets that meet at a sharp edge have vertices in common that are on either to DOMAIN_SAME
 * alone. */
#define ALIKE 0.02

/* A surface that is taken as it is has no cell: what is the same place, in parts of its size. */
#define SAME_OF_SIZE 1e-6

typedef struct {
    const domain *d;
    const handles *h;
    const domain_options *how;
    domain_finder finder;
    double cell, same;
    int *row, *owner; /* a vertex: its row, or -1; a row: the first handle in it */
    int count, room;
    double *value, *now; /* room x m; m: a row in the making */
    int *bones;          /* m: bones at a place */
} holder;

static const double *vertex_at(const holder *w, int vertex)
{
    return w->d->at + 3 * (size_t)vertex;
}

/* ---- claims ----------------------------------------------------------------------------------- */

static int fail_conflict(const holder *w, const double *p, int one, int other, bake_error *error)
{
    const handle *a = &w->h->handle[one], *b = &w->h->handle[other];
    return bake_fail(
        error,
        "%s:%d: %s '%s' and %s '%s' are in one place, at (%.6g, %.6g, %.6g); move them "
        "apart, or let bones meet at their ends",
        w->how->origin->scene, b->line, domain_word(a), a->name, domain_word(b), b->name, p[0],
        p[1], p[2]);
}

static int differs(const holder *w, const double *row)
{
    for (int i = 0; i < w->h->count; i++)
        if (fabs(row[i] - w->now[i]) > ALIKE)
            return 1;
    return 0;
}

/* The vertex has the values `now`, the first of which that is not 0 is `owner`'s. */
static int claim(holder *w, int vertex, int owner, bake_error *error)
{
    size_t m = (size_t)w->h->count;
    if (w->row[vertex] >= 0) {
        int row = w->row[vertex];
        return differs(w, w->value + m * (size_t)row)
                   ? fail_conflict(w, vertex_at(w, vertex), w->owner[row], owner, error)
                   : 0;
    }
    if (w->count == w->room) {
        w->room = 2 * w->room + 64;
        w->value = bake_grow(w->value, (size_t)w->room, m * sizeof *w->value);
        w->owner = bake_grow(w->owner, (size_t)w->room, sizeof *w->owner);
    }
    memcpy(w->value + m * (size_t)w->count, w->now, m * sizeof *w->now);
    w->owner[w->count] = owner;
    w->row[vertex] = w->count++;
    return 0;
}

static void begin(holder *w)
{
    memset(w->now, 0, (size_t)w->h->count * sizeof *w->now);
}

static int claim_one(holder *w, int vertex, int owner, bake_error *error)
{
    begin(w);
    w->now[owner] = 1.0;
    return claim(w, vertex, owner, error);
}

/* ---- bones ------------------------------------------------------------------------------------ */

/* How far along a segment its point is that is nearest to p, 0 .. 1. */
static double along(const double *from, const double *to, const double *p)
{
    double u[3], v[3];
    for (int k = 0; k < 3; k++) {
        u[k] = to[k] - from[k];
        v[k] = p[k] - from[k];
    }
    double whole = vector_dot(u, u);
    return whole > 0.0 ? fmax(0.0, fmin(1.0, vector_dot(u, v) / whole)) : 0.0;
}

static double distance_to_bone(const handle *b, const double *p)
{
    double t = along(b->from, b->to, p), q[3];
    for (int k = 0; k < 3; k++)
        q[k] = (1.0 - t) * b->from[k] + t * b->to[k];
    return tets_distance(p, q);
}

static int near_end(const holder *w, const handle *b, const double *p)
{
    return fmin(tets_distance(b->from, p), tets_distance(b->to, p)) <= 2.0 * w->same;
}

/* The bones at a place; how many. */
static int find_bones(holder *w, const double *p)
{
    int count = 0;
    for (int i = 0; i < w->h->count; i++) {
        const handle *b = &w->h->handle[i];
        if (b->kind == HANDLE_BONE && distance_to_bone(b, p) <= w->same)
            w->bones[count++] = i;
    }
    return count;
}

/* Bones share a joint when all of them end there but one: a bone may begin along another. */
static int check_joint(const holder *w, const double *p, int count, bake_error *error)
{
    int through = -1;
    for (int i = 0; i < count; i++) {
        if (near_end(w, &w->h->handle[w->bones[i]], p))
            continue;
        if (through >= 0)
            return fail_conflict(w, p, through, w->bones[i], error);
        through = w->bones[i];
    }
    return 0;
}

/* The bones that are at p share the vertex. */
static int claim_bones(holder *w, int vertex, const double *p, bake_error *error)
{
    int count = find_bones(w, p);
    if (count == 0)
        return 0;
    if (check_joint(w, p, count, error))
        return -1;
    begin(w);
    for (int i = 0; i < count; i++)
        w->now[w->bones[i]] = 1.0 / count;
    return claim(w, vertex, w->bones[0], error);
}

/* ---- facets ----------------------------------------------------------------------------------- */

/* Barycentric coordinates of the point of a facet that is nearest to p; its distance. */
static double weigh_facet(const handles *h, const int *facet, const double *p, double weight[3])
{
    const double *at[3];
    for (int k = 0; k < 3; k++)
        at[k] = h->handle[facet[k] < 0 ? facet[0] : facet[k]].from;
    double square = tets_weigh_triangle(at, p, weight);
    if (facet[2] < 0) {
        weight[0] += weight[2];
        weight[2] = 0.0;
    }
    return sqrt(square);
}

static int claim_facet(holder *w, int vertex, const int *facet, const double *weight,
                       bake_error *error)
{
    begin(w);
    for (int k = 0; k < 3; k++)
        if (facet[k] >= 0)
            w->now[facet[k]] += weight[k];
    return claim(w, vertex, facet[0], error);
}

static int in_box(const holder *w, const int *facet, const double *p)
{
    for (int x = 0; x < 3; x++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (int k = 0; k < 3; k++) {
            double at = w->h->handle[facet[k] < 0 ? facet[0] : facet[k]].from[x];
            low = fmin(low, at);
            high = fmax(high, at);
        }
        if (p[x] < low - w->same || p[x] > high + w->same)
            return 0;
    }
    return 1;
}

static int hold_facet(holder *w, const int *facet, bake_error *error)
{
    double weight[3];
    for (int v = 0; v < w->d->vertex_count; v++)
        if (in_box(w, facet, vertex_at(w, v)) &&
            weigh_facet(w->h, facet, vertex_at(w, v), weight) <= w->same &&
            claim_facet(w, v, facet, weight, error))
            return -1;
    return 0;
}

/* ---- what is held where it is ------------------------------------------------------------------- */

static int hold_region(holder *w, int index, bake_error *error)
{
    const handle *h = &w->h->handle[index];
    for (int i = 0; i < h->vertex_count; i++) {
        int vertex = w->d->vertex_of ? w->d->vertex_of[h->vertex[i]] : h->vertex[i];
        if (claim_one(w, vertex, index, error))
            return -1;
    }
    return 0;
}

static int hold_exactly(holder *w, bake_error *error)
{
    for (int i = 0; i < w->h->count; i++)
        if (w->h->handle[i].kind == HANDLE_REGION && hold_region(w, i, error))
            return -1;
    for (int i = 0; i < w->h->count; i++) {
        const handle *h = &w->h->handle[i];
        int vertex = domain_nearest(&w->finder, h->from);
        if ((h->kind == HANDLE_POINT || h->kind == HANDLE_CAGE) &&
            tets_distance(vertex_at(w, vertex), h->from) <= w->same &&
            claim_one(w, vertex, i, error))
            return -1;
    }
    for (int i = 0; i < w->h->facet_count; i++)
        if (hold_facet(w, w->h->facet[i], error))
            return -1;
    for (int v = 0; v < w->d->vertex_count; v++)
        if (claim_bones(w, v, vertex_at(w, v), error))
            return -1;
    return 0;
}

/* ---- what takes the nearest vertex --------------------------------------------------------------- */

/* 1: inside, or so little outside that it counts. A surface is never far from what it is held by.
 * */
static char *find_inside(const holder *w, const domain_samples *s, bake_error *error)
{
    char *inside = bake_alloc((size_t)s->count + 1, 1);
    double *at = bake_alloc((size_t)s->count + 1, 3 * sizeof *at), far;
    embedding *e = bake_alloc((size_t)s->count + 1, sizeof *e);
    for (int i = 0; i < s->count; i++)
        memcpy(at + 3 * (size_t)i, s->at[i].at, sizeof s->at[i].at);
    int err = domain_embed(w->d, at, s->count, e, &far, error);
    for (int i = 0; i < s->count && err == 0; i++) {
        double q[3] = {0.0, 0.0, 0.0};
        for (int k = 0; k < 4; k++)
            for (int x = 0; x < 3; x++)
                q[x] += e[i].weight[k] * vertex_at(w, e[i].vertex[k])[x];
        inside[i] =
            !(w->d->cell > 0.0) || tets_distance(q, s->at[i].at) <= DOMAIN_NEAR * w->cell + w->same;
    }
    free(e);
    free(at);
    if (err == 0)
        return inside;
    free(inside);
    return NULL;
}

/* A place that is needed and not free is left to whoever has it, but for a point, which has no
 * other. */
static int hold_sample(holder *w, const domain_sample *s, bake_error *error)
{
    int vertex = domain_nearest(&w->finder, s->at);
    const handle *h = s->handle < 0 ? NULL : &w->h->handle[s->handle];
    if (h && h->kind == HANDLE_POINT)
        return claim_one(w, vertex, s->handle, error);
    if (w->row[vertex] >= 0)
        return 0;
    if (h && h->kind == HANDLE_CAGE)
        return claim_one(w, vertex, s->handle, error);
    return h ? claim_bones(w, vertex, s->at, error)
             : claim_facet(w, vertex, w->h->facet[s->facet], s->weight, error);
}

static int hold_nearest(holder *w, bake_error *error)
{
    domain_samples s;
    if (domain_sample_all(w->h, w->cell, w->how, &s, error))
        return -1;
    char *inside = find_inside(w, &s, error);
    int err = inside == NULL ? -1 : 0;
    for (int i = 0; i < s.count && err == 0; i++)
        if (inside[i])
            err = hold_sample(w, &s.at[i], error);
    free(inside);
    free(s.at);
    return err;
}

/* ---- what must be true of it ------------------------------------------------------------------- */

/* Of the place of it that is nearest to the domain, of nine. */
static double distance_outside(const holder *w, const handle *h, double at[3])
{
    double least = HUGE_VAL;
    for (int i = 0; i <= 8; i++) {
        embedding e;
        bake_error none;
        double p[3], far;
        for (int k = 0; k < 3; k++)
            p[k] = h->kind == HANDLE_BONE ? h->from[k] + i / 8.0 * (h->to[k] - h->from[k])
                                          : h->from[k];
        if (domain_embed(w->d, p, 1, &e, &far, &none) || far >= least)
            continue;
        least = far;
        memcpy(at, p, sizeof p);
    }
    return least;
}

static int fail_nothing(const holder *w, const handle *h, bake_error *error)
{
    const surface_origin *o = w->how->origin;
    double at[3] = {h->from[0], h->from[1], h->from[2]};
    if (h->kind == HANDLE_REGION)
        return bake_fail(error, "%s:%d: region '%s' has no vertices of mesh %s", o->scene, h->line,
                         h->name, o->name);
    double far = distance_outside(w, h, at);
    if (far > 0.0)
        return bake_fail(
            error,
            "%s:%d: %s '%s' holds nothing: at (%.6g, %.6g, %.6g) it is outside of mesh "
            "%s, %.3g away; move it inside",
            o->scene, h->line, domain_word(h), h->name, at[0], at[1], at[2], o->name, far);
    return bake_fail(error,
                     "%s:%d: %s '%s' holds nothing: all vertices near (%.6g, %.6g, %.6g) are held "
                     "by others; move it, or give mesh %s a smaller 'cell'",
                     o->scene, h->line, domain_word(h), h->name, at[0], at[1], at[2], o->name);
}

static int check_all(const holder *w, bake_error *error)
{
    size_t m = (size_t)w->h->count;
    for (size_t i = 0; i < m; i++) {
        int holds = 0;
        for (int row = 0; row < w->count && !holds; row++)
            holds = w->value[m * (size_t)row + i] > 0.0;
        if (!holds)
            return fail_nothing(w, &w->h->handle[i], error);
    }
    return 0;
}

/* ---- all of it -------------------------------------------------------------------------------- */

/* By ascending vertices. */
static void give(const holder *w, held *out)
{
    size_t m = (size_t)w->h->count;
    out->handle_count = w->h->count;
    out->vertex = bake_alloc((size_t)w->count + 1, sizeof *out->vertex);
    out->value = bake_alloc((size_t)w->count + 1, m * sizeof *out->value);
    for (int v = 0; v < w->d->vertex_count; v++) {
        if (w->row[v] < 0)
            continue;
        memcpy(out->value + m * (size_t)out->count, w->value + m * (size_t)w->row[v],
               m * sizeof *out->value);
        out->vertex[out->count++] = v;
    }
}

static double mean_edge(const domain *d)
{
    double sum = 0.0;
    for (int i = 0; i < d->element_count; i++)
        for (int k = 0; k < 3; k++)
            sum += tets_distance(d->at + 3 * (size_t)d->element[i][k],
                                 d->at + 3 * (size_t)d->element[i][(k + 1) % 3]);
    return sum / (3.0 * d->element_count);
}

static void set_scale(holder *w)
{
    const tets_grid *g = &w->finder.grid;
    w->cell = w->d->cell > 0.0 ? w->d->cell : mean_edge(w->d);
    w->same =
        w->d->cell > 0.0 ? DOMAIN_SAME * w->cell : SAME_OF_SIZE * tets_distance(g->low, g->high);
}

int domain_hold(const domain *d, const handles *h, const domain_options *how, held *out,
                bake_error *error)
{
    holder w = {.d = d, .h = h, .how = how};
    int from_count = d->vertex_of ? d->from_count : d->vertex_count;
    *out = (held){0};
    if (domain_check(h, from_count, how, error))
        return -1;
    domain_finder_make(&w.finder, d->at, d->vertex_count);
    set_scale(&w);
    w.row = bake_alloc((size_t)d->vertex_count + 1, sizeof *w.row);
    w.now = bake_alloc((size_t)h->count + 1, sizeof *w.now);
    w.bones = bake_alloc((size_t)h->count + 1, sizeof *w.bones);
    for (int i = 0; i < d->vertex_count; i++)
        w.row[i] = -1;
    int err = hold_exactly(&w, error) || hold_nearest(&w, error) || check_all(&w, error) ? -1 : 0;
    if (err == 0)
        give(&w, out);
    domain_finder_free(&w.finder);
    free(w.row);
    free(w.owner);
    free(w.value);
    free(w.now);
    free(w.bones);
    return err;
}

void held_free(held *h)
{
    free(h->vertex);
    free(h->value);
    *h = (held){0};
}
