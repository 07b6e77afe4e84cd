/* Broken surfaces: a closed one around whatever is there.
 * Source: CGAL's alpha_wrap_3 behind bridge.h; how tight the wrap is made is own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bridge.h"
#include "domain_parts.h"
#include "isolate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The wrap goes in through what a ball of that part of the surface's size goes through. The first
 * keeps fingers apart; the others are for shapes with so many triangles missing that the wrap goes
 * through the skin and is hollow. */
static const double TIGHT[] = {80.0, 40.0, 20.0};
enum { TRIES = sizeof TIGHT / sizeof *TIGHT };

/* How far the wrap is off, in parts of the size. Sheets and ears become twice that thick. */
#define OFF 600.0

/* So much of what is inside may be outside of the wrap before a looser one is tried. */
#define HOLLOW 0.25

#define WRAP_MAX 2000000

typedef struct {
    const surface *s;
    const surface_origin *origin;
    double alpha, offset;
    tets_triangles *out;
} job;

/* ---- in the process --------------------------------------------------------------------------- */

static int wrap_here(void *what, isolate_note *now, bake_error *error)
{
    job *j = what;
    const bridge_surface b = {j->s->vertex_count, j->s->triangle_count, j->s->at, j->s->triangle};
    bridge_message message = {""};
    bridge_mesh made;
    isolate_now(now, j->origin->line, j->origin->name);
    int err = bridge_wrap(&b, j->alpha, j->offset, &made, &message);
    *j->out = (tets_triangles){made.vertex_count, made.triangle_count, made.at, made.triangle};
    return err ? bake_fail(error, "%s:%d: mesh %s cannot be wrapped: CGAL: %s", j->origin->scene,
                           j->origin->line, j->origin->name, message.text)
               : 0;
}

static void send_wrap(const void *what, FILE *to)
{
    const tets_triangles *m = ((const job *)what)->out;
    const int count[2] = {m->vertex_count, m->triangle_count};
    fwrite(count, sizeof count, 1, to);
    fwrite(m->at, 3 * sizeof *m->at, (size_t)m->vertex_count, to);
    fwrite(m->triangle, sizeof *m->triangle, (size_t)m->triangle_count, to);
}

/* ---- in the baker ----------------------------------------------------------------------------- */

/* tets_check looks at the rest. */
static int take_wrap(void *what, FILE *from)
{
    job *j = what;
    tets_triangles *m = j->out;
    int count[2];
    if (fread(count, sizeof count, 1, from) != 1 || count[0] < 4 || count[1] < 4 ||
        count[0] > WRAP_MAX || count[1] > WRAP_MAX)
        return -1;
    m->vertex_count = count[0];
    m->triangle_count = count[1];
    m->at = isolate_get(from, (size_t)count[0], 3 * sizeof *m->at);
    m->triangle = isolate_get(from, (size_t)count[1], sizeof *m->triangle);
    if (m->at != NULL && m->triangle != NULL)
        return 0;
    tets_triangles_free(m);
    return -1;
}

static int wrap(job *j, bake_error *error)
{
    const isolate_words words = {
        .before = "mesh ",
        .after = "",
        .verb = "wrap",
        .past = "wrapped",
        .stopped = "is broken, and crashes what wraps it",
        .slow_try = "give it fewer triangles, or close its surface",
        .large_try = "give it fewer triangles, or close its surface",
        .stopped_try = "close its surface",
    };
    const isolate_job wrapped = {j->origin->scene, j, wrap_here, send_wrap, take_wrap};
    return isolate_as(&wrapped, &words, error);
}

/* ---- all of it -------------------------------------------------------------------------------- */

/* 0: everything that should be inside is, or nearly; else how much of it is not. Bones count more.
 * -1: an error. */
static double hollow(const surface *wrapped, const surface_origin *origin, const domain_places *in,
                     bake_error *error)
{
    double *depth = bake_alloc((size_t)in->count + 1, sizeof *depth), out[2] = {0.0, 0.0};
    const domain_depths all = {wrapped, origin, in->count, in->at, depth};
    int err = domain_depth(&all, error);
    for (int i = 0; i < in->count && err == 0; i++)
        out[i >= in->bones] += depth[i] <= 0.0;
    free(depth);
    out[1] = fmax(0.0, out[1] / fmax(1.0, in->count - in->bones) - HOLLOW);
    return err ? -1.0 : out[0] + out[1];
}

/* Wraps, checks, looks inside; what does not succeed leaves nothing behind. */
static double try_wrap(job *j, const domain_places *in, double *volume, bake_error *error)
{
    if (wrap(j, error))
        return -1.0;
    const surface s = tets_look(j->out);
    double bad =
        tets_check_apart(&s, j->origin, volume, error) ? -1.0 : hollow(&s, j->origin, in, error);
    if (bad < 0.0)
        tets_triangles_free(j->out);
    return bad;
}

/* The tightest of those that are hollow the least. first: what is wrapped, and how far off. */
static int wrap_best(const job *first, double size, const domain_places *in, domain_wrapped *best,
                     bake_error *error)
{
    double least = -1.0;
    for (int i = 0; i < TRIES && least != 0.0; i++) {
        domain_wrapped made = {.off = first->offset};
        job j = *first;
        j.alpha = size / TIGHT[i];
        j.out = &made.t;
        double bad = try_wrap(&j, in, &made.volume, error);
        if (bad < 0.0)
            continue;
        int better = least < 0.0 || bad < least;
        domain_wrapped worse = better ? *best : made;
        *best = better ? made : *best;
        least = better ? bad : least;
        tets_triangles_free(&worse.t);
    }
    return least < 0.0 ? -1 : 0;
}

int domain_wrap(const surface *s, const handles *h, const domain_options *how, domain_wrapped *out,
                bake_error *error)
{
    double box[2][3], size = domain_measure(s, box);
    const job first = {.s = s, .origin = how->origin, .offset = size / OFF};
    domain_places in;
    *out = (domain_wrapped){.volume = 0.0};
    if (!(size > 0.0))
        return -1;
    domain_places_find(s, h, (const double(*)[3])box, &in);
    int err = wrap_best(&first, size, &in, out, error);
    free(in.at);
    return err;
}
