/* Where handles touch a domain: samples of bones and of cage facets, and which of them become vertices.
 * Source: Jacobson 2013, 4.3.4; distances are own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_parts.h"
#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A cell that small beside a handle is a mistake. */
#define SAMPLES_MAX 50000

const char *domain_word(const handle *h)
{
    static const char *const words[] = {[HANDLE_POINT] = "point",
                                        [HANDLE_REGION] = "region",
                                        [HANDLE_BONE] = "bone",
                                        [HANDLE_CAGE] = "cage vertex"};
    return words[h->kind];
}

/* ---- checks ----------------------------------------------------------------------------------- */

static int check_handle(const handle *h, int vertex_count, const char *scene, bake_error *error)
{
    for (int k = 0; k < 3; k++)
        if (h->kind != HANDLE_REGION &&
            (!isfinite(h->from[k]) || (h->kind == HANDLE_BONE && !isfinite(h->to[k]))))
            return bake_fail(error, "%s:%d: %s '%s' is nowhere: a coordinate is no number", scene,
                             h->line, domain_word(h), h->name);
    for (int i = 0; i < h->vertex_count && h->kind == HANDLE_REGION; i++)
        if (h->vertex[i] < 0 || h->vertex[i] >= vertex_count)
            return bake_fail(error, "%s:%d: region '%s' has a vertex %d, and there are %d", scene,
                             h->line, h->name, h->vertex[i], vertex_count);
    return 0;
}

int domain_check(const handles *h, int vertex_count, const domain_options *how, bake_error *error)
{
    const surface_origin *o = how->origin;
    for (int i = 0; i < h->count; i++)
        if (check_handle(&h->handle[i], vertex_count, o->scene, error))
            return -1;
    for (int i = 0; i < 3 * h->facet_count; i++) {
        int corner = h->facet[i / 3][i % 3];
        if (corner == -1 && i % 3 == 2)
            continue;
        if (corner < 0 || corner >= h->count || h->handle[corner].kind != HANDLE_CAGE)
            return bake_fail(error, "%s:%d: a cage's facet joins what is no vertex of a cage",
                             o->scene, o->line);
    }
    return 0;
}

/* ---- samples ---------------------------------------------------------------------------------- */

typedef struct {
    const handles *h;
    double cell;
    domain_samples *out;
    int room;
} sampler;

static domain_sample *add(sampler *s)
{
    domain_samples *out = s->out;
    if (out->count == s->room) {
        s->room = 2 * s->room + 64;
        out->at = bake_grow(out->at, (size_t)s->room, sizeof *out->at);
    }
    out->at[out->count] = (domain_sample){.handle = -1, .facet = -1};
    return &out->at[out->count++];
}

static void add_place(sampler *s, int i, double along, int needed)
{
    const handle *h = &s->h->handle[i];
    domain_sample *p = add(s);
    p->handle = i;
    p->needed = needed;
    for (int k = 0; k < 3; k++)
        p->at[k] = along == 0.0   ? h->from[k]
                   : along == 1.0 ? h->to[k]
                                  : (1.0 - along) * h->from[k] + along * h->to[k];
}

/* Two at least: both joints of a bone may be shared with others, and its middle is its own. */
static int pieces_of(const handle *h, double cell)
{
    double length = tets_distance(h->from, h->to);
    return length > 0.0 ? (int)fmax(2.0, fmin(ceil(length / cell), SAMPLES_MAX)) : 0;
}

static void add_needed(sampler *s)
{
    for (int i = 0; i < s->h->count; i++) {
        const handle *h = &s->h->handle[i];
        if (h->kind == HANDLE_REGION)
            continue;
        add_place(s, i, 0.0, 1);
        if (h->kind == HANDLE_BONE && pieces_of(h, s->cell) > 0)
            add_place(s, i, 1.0, 1);
    }
}

static void add_bones(sampler *s)
{
    for (int i = 0; i < s->h->count; i++) {
        const handle *h = &s->h->handle[i];
        int pieces = h->kind == HANDLE_BONE ? pieces_of(h, s->cell) : 0;
        for (int j = 1; j < pieces && s->out->count <= SAMPLES_MAX; j++)
            add_place(s, i, (double)j / pieces, 0);
    }
}

static void add_on_facet(sampler *s, int facet, const double *weight)
{
    domain_sample *p = add(s);
    p->facet = facet;
    for (int k = 0; k < 3; k++) {
        int corner = s->h->facet[facet][k];
        p->weight[k] = weight[k];
        for (int x = 0; x < 3 && corner >= 0; x++)
            p->at[x] += weight[k] * s->h->handle[corner].from[x];
    }
}

/* i, j, n - i - j: all but the corners, which are handles. */
static void add_facet(sampler *s, int facet)
{
    const int *corner = s->h->facet[facet], corners = corner[2] < 0 ? 2 : 3;
    double longest = 0.0;
    for (int k = 0; k < corners; k++)
        longest = fmax(longest, tets_distance(s->h->handle[corner[k]].from,
                                              s->h->handle[corner[(k + 1) % corners]].from));
    int n = (int)fmin(ceil(longest / s->cell), SAMPLES_MAX);
    for (int i = 0; i < n; i++)
        for (int j = corners == 2 ? n - i : 0; i + j <= n; j++) {
            const double weight[3] = {(double)i / n, (double)j / n, (double)(n - i - j) / n};
            if (i > 0 || (j > 0 && j < n))
                add_on_facet(s, facet, weight);
            if (s->out->count > SAMPLES_MAX)
                return;
        }
}

int domain_sample_all(const handles *h, double cell, const domain_options *how, domain_samples *out,
                      bake_error *error)
{
    sampler s = {.h = h, .cell = cell, .out = out};
    *out = (domain_samples){0};
    add_needed(&s);
    add_bones(&s);
    for (int i = 0; i < h->facet_count && out->count <= SAMPLES_MAX; i++)
        add_facet(&s, i);
    if (out->count <= SAMPLES_MAX)
        return 0;
    free(out->at);
    return bake_fail(error,
                     "%s:%d: mesh %s: the handles take more than %d vertices with a cell of %.3g; "
                     "give it a larger 'cell'",
                     how->origin->scene, how->origin->line, how->origin->name, SAMPLES_MAX, cell);
}

/* ---- which of them become vertices -------------------------------------------------------------- */

static int is_apart(const double *p, const double *point, int count, double apart)
{
    for (int i = 0; i < count; i++)
        if (tets_distance(p, point + 3 * (size_t)i) < apart)
            return 0;
    return 1;
}

int domain_choose(const domain_samples *s, const double *depth, double cell, double *point)
{
    int count = 0;
    for (int i = 0; i < s->count; i++) {
        const domain_sample *p = &s->at[i];
        double apart = (p->needed ? DOMAIN_SAME : DOMAIN_APART) * cell;
        if (depth[i] < DOMAIN_NEAR * cell || !is_apart(p->at, point, count, apart))
            continue;
        memcpy(point + 3 * (size_t)count, p->at, sizeof p->at);
        count++;
    }
    return count;
}
