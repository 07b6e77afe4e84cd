/* Solid shapes: tetrahedra inside a surface, or inside a cage around it.
 * Source: Jacobson 2013, 4.3.4, 4.5; TetGen and CGAL behind bridge.h; what is asked of them is own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"
#include "domain_parts.h"
#include "isolate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TETS_USUAL 50000

/* A surface of few large triangles gets edges that are at most so small a part of its size: weights
 * change along a limb. */
#define COARSEST 30.0

/* ---- depths, in a process ---------------------------------------------------------------------- */

static int find_here(void *what, isolate_note *now, bake_error *error)
{
    const domain_depths *d = what;
    const bridge_surface b = {d->s->vertex_count, d->s->triangle_count, d->s->at, d->s->triangle};
    bridge_message message = {""};
    isolate_now(now, d->origin->line, d->origin->name);
    return bridge_depth(&b, d->at, d->count, d->depth, &message)
               ? bake_fail(error, "%s:%d: mesh %s: what is inside cannot be found: CGAL: %s",
                           d->origin->scene, d->origin->line, d->origin->name, message.text)
               : 0;
}

static void send_depths(const void *what, FILE *to)
{
    const domain_depths *d = what;
    fwrite(d->depth, sizeof *d->depth, (size_t)d->count, to);
}

static int take_depths(void *what, FILE *from)
{
    const domain_depths *d = what;
    if (fread(d->depth, sizeof *d->depth, (size_t)d->count, from) != (size_t)d->count)
        return -1;
    for (int i = 0; i < d->count; i++)
        if (!isfinite(d->depth[i]))
            return -1;
    return 0;
}

int domain_depth(const domain_depths *d, bake_error *error)
{
    domain_depths mine = *d;
    const isolate_words words = {
        .before = "mesh ",
        .after = "",
        .verb = "look into",
        .past = "looked into",
        .stopped = "crashes the search for what is inside of it",
        .slow_try = "give it fewer triangles",
        .large_try = "give it fewer triangles",
        .stopped_try = "simplify it",
    };
    const isolate_job job = {d->origin->scene, &mine, find_here, send_depths, take_depths};
    return d->count > 0 ? isolate_as(&job, &words, error) : 0;
}

/* What is filled. caged: the border goes around the surface, whose regions are inside. */
typedef struct {
    const surface *s, *border;
    const surface_origin *origin; /* of the border */
    const handles *h;
    const domain_options *how;
    int caged;
    double volume; /* of the border */
} filling;

/* ---- samples ---------------------------------------------------------------------------------- */

/* The samples inside the border, 3 numbers each, the caller's; how many, or -1. */
static int choose(const filling *f, const domain_samples *s, double cell, double **point,
                  bake_error *error)
{
    double *depth = bake_alloc((size_t)s->count + 1, sizeof *depth);
    double *at = bake_alloc((size_t)s->count + 1, 3 * sizeof *at);
    const domain_depths all = {f->border, f->origin, s->count, at, depth};
    *point = bake_alloc((size_t)s->count + 1, 3 * sizeof **point);
    for (int i = 0; i < s->count; i++)
        memcpy(at + 3 * (size_t)i, s->at[i].at, sizeof s->at[i].at);
    int count = domain_depth(&all, error) ? -1 : domain_choose(s, depth, cell, *point);
    free(at);
    free(depth);
    return count;
}

/* A region inside a cage is held where it is, like points. */
static void add_regions(const surface *s, const handles *h, domain_samples *out)
{
    int count = out->count;
    for (int i = 0; i < h->count; i++)
        count += h->handle[i].kind == HANDLE_REGION ? h->handle[i].vertex_count : 0;
    out->at = bake_grow(out->at, (size_t)count + 1, sizeof *out->at);
    for (int i = 0; i < h->count; i++)
        for (int j = 0; j < h->handle[i].vertex_count && h->handle[i].kind == HANDLE_REGION; j++) {
            domain_sample *p = &out->at[out->count++];
            *p = (domain_sample){.handle = i, .facet = -1, .needed = 1};
            memcpy(p->at, s->at + 3 * (size_t)h->handle[i].vertex[j], sizeof p->at);
        }
}

/* ---- filling ---------------------------------------------------------------------------------- */

static double size_of(const surface *s)
{
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (int i = 0; i < 3 * s->vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], s->at[i]);
        high[i % 3] = fmax(high[i % 3], s->at[i]);
    }
    return tets_distance(low, high);
}

static double usual_cell(const surface *border, double volume)
{
    return fmax(tets_cell(volume, TETS_USUAL),
                fmin(tets_mean_edge(border), size_of(border) / COARSEST));
}

static void give(const body *b, double cell, domain *out)
{
    *out = (domain){.dimension = 3,
                    .vertex_count = b->vertex_count,
                    .element_count = b->element_count,
                    .at = b->rest,
                    .element = b->element,
                    .cell = cell};
}

/* TETS_MANY: an error too. */
static int fill(const filling *f, domain *out, bake_error *error)
{
    tets_wish wish = {.cell = f->how->cell, .volume = f->volume};
    domain_samples s;
    double *point = NULL;
    body b;
    if (!(wish.cell > 0.0))
        wish.cell = usual_cell(f->border, f->volume);
    if (domain_sample_all(f->h, wish.cell, f->how, &s, error))
        return TETS_MANY;
    if (f->caged)
        add_regions(f->s, f->h, &s);
    wish.point_count = choose(f, &s, wish.cell, &point, error);
    wish.point = point;
    int err = wish.point_count < 0 ? -1 : tets_fill(f->border, &wish, f->origin, &b, error);
    if (err == 0) {
        give(&b, wish.cell, out);
        if (f->border != f->s)
            domain_link(out, f->s->at, f->s->vertex_count);
        if (domain_drop(out, f->h, f->how) > 0)
            domain_link(out, f->s->at, f->s->vertex_count);
    }
    free(point);
    free(s.at);
    return err;
}

/* ---- cages ------------------------------------------------------------------------------------ */

/* 1: all of the surface is inside the border, 0: not; -1: an error. */
static int goes_around(const filling *f, bake_error *error)
{
    double *depth = bake_alloc((size_t)f->s->vertex_count + 1, sizeof *depth);
    const domain_depths all = {f->border, f->origin, f->s->vertex_count, f->s->at, depth};
    int around = domain_depth(&all, error) ? -1 : 1;
    for (int i = 0; i < all.count && around == 1; i++)
        around = depth[i] > 0.0;
    free(depth);
    return around;
}

/* 1: the cage has been filled; 0: it does not go around the surface; -1: an error. */
static int fill_cage(const filling *f, domain *out, bake_error *error)
{
    domain_cage c;
    if (!domain_cage_solid(f->h, &c))
        return 0;
    const surface border = {c.vertex_count, f->h->facet_count, c.at, (const int(*)[3])c.triangle};
    const surface_origin origin = {f->origin->scene, "cage", f->h->handle[f->h->facet[0][0]].line};
    filling cage = *f;
    cage.border = &border;
    cage.origin = &origin;
    cage.caged = 1;
    int around =
        tets_check_apart(&border, &origin, &cage.volume, error) ? -1 : goes_around(&cage, error);
    if (around == 1 && fill(&cage, out, error))
        around = -1;
    domain_cage_free(&c);
    return around;
}

/* ---- broken surfaces -------------------------------------------------------------------------- */

/* Everything can be computed with it, whatever it is. */
static int check_numbers(const surface *s)
{
    for (int i = 0; i < 3 * s->vertex_count; i++)
        if (!(fabs(s->at[i]) <= 1e100))
            return -1;
    for (int i = 0; i < 3 * s->triangle_count; i++)
        if (s->triangle[i / 3][i % 3] < 0 || s->triangle[i / 3][i % 3] >= s->vertex_count)
            return -1;
    return s->triangle_count > 0 ? 0 : -1;
}

/* The message without its advice, which has been taken. */
static void warn(const char *why, const char *done)
{
    const char *end = strrchr(why, ';');
    fprintf(stderr, "%.*s: warning: %s\n", end ? (int)(end - why) : (int)strlen(why), why, done);
}

/* 0 when a surface that has been mended is good now. */
static int fill_mended(const filling *f, const tets_triangles *t, domain *out)
{
    const surface border = tets_look(t);
    filling mended = *f;
    bake_error none;
    mended.border = &border;
    return tets_check_apart(&border, f->origin, &mended.volume, &none) || fill(&mended, out, &none)
               ? -1
               : 0;
}

static int fill_wrapped(const filling *f, const tets_triangles *t, domain *out, bake_error *error)
{
    const surface closed = tets_look(t);
    const bake_error why = *error;
    domain_wrapped wrapped;
    filling around = *f;
    char done[80];
    if (domain_wrap(&closed, f->h, f->how, &wrapped, error))
        return -1;
    snprintf(done, sizeof done, "wrapped in a closed surface, %.3g off", wrapped.off);
    warn(why.text, done);
    const surface border = tets_look(&wrapped.t);
    around.border = &border;
    around.volume = wrapped.volume;
    int err = fill(&around, out, error);
    out->wrapped = err == 0;
    tets_triangles_free(&wrapped.t);
    return err;
}

/* From what changes least to what always helps. error: what is wrong. */
static int fill_broken(const filling *f, domain *out, bake_error *error)
{
    tets_triangles t;
    int err = domain_weld(f->s, &t) ? fill_mended(f, &t, out) : -1;
    if (err && domain_close(&t) > 0) {
        err = fill_mended(f, &t, out);
        if (err == 0)
            warn(error->text, "closed");
    }
    if (err)
        err = fill_wrapped(f, &t, out, error);
    tets_triangles_free(&t);
    return err;
}

/* A surface that is good in itself may still be too much for TetGen. */
int domain_solid(const surface *s, const handles *h, const domain_options *how, domain *out,
                 bake_error *error)
{
    filling f = {.s = s, .border = s, .origin = how->origin, .h = h, .how = how};
    *out = (domain){0};
    if (domain_check(h, s->vertex_count, how, error))
        return -1;
    int numbers = check_numbers(s), caged = numbers ? 0 : fill_cage(&f, out, error);
    if (caged != 0)
        return caged < 0 ? -1 : 0;
    int err = tets_check_apart(s, how->origin, &f.volume, error);
    err = err ? err : fill(&f, out, error);
    if (err == -1 && how->wrap && numbers == 0)
        err = fill_broken(&f, out, error);
    return err ? -1 : 0;
}
