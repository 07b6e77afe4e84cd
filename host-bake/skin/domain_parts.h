/* What the files of domain.h share.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_DOMAIN_PARTS_H
#define BAKE_DOMAIN_PARTS_H

#include "domain.h"
#include "tets_parts.h"

/* In cells. A sample that is nearer than that to the border gets no vertex of its own: a vertex of
 * the border, the nearest one, stands for it. One that is that far outside still counts. */
#define DOMAIN_NEAR 0.125

/* Samples are that far apart, or one is left out, ... */
#define DOMAIN_APART 0.25

/* ... but for joints and points, which are two if they are that far apart. What is nearer is in the
 * same place, and on a bone or facet. */
#define DOMAIN_SAME 1e-3

/* A place where a handle touches the domain. */
typedef struct {
    double at[3];
    int handle, facet; /* one of them is -1 */
    int needed;        /* 1: a point, an end of a bone, a vertex of a cage */
    double weight[3];  /* of the facet's corners */
} domain_sample;

typedef struct {
    int count;
    domain_sample *at; /* needed ones first; the caller frees it */
} domain_samples;

/* Of bones and facets, not more than a cell apart; every bone has three. */
int domain_sample_all(const handles *h, double cell, const domain_options *how, domain_samples *out,
                      bake_error *error);

/* Those which become vertices: `depth` inside the border, and apart. Returns how many there are;
 * point: theirs, 3 each. */
int domain_choose(const domain_samples *s, const double *depth, double cell, double *point);

/* Numbers that are finite, facets of cage vertices, vertices that a region can have. */
int domain_check(const handles *h, int vertex_count, const domain_options *how, bake_error *error);

/* "bone". */
const char *domain_word(const handle *h);

/* The nearest of many vertices. */
typedef struct {
    const double *at; /* 3 a vertex */
    tets_grid grid;
} domain_finder;

void domain_finder_make(domain_finder *f, const double *at, int count);
void domain_finder_free(domain_finder *f);
int domain_nearest(const domain_finder *f, const double *p);

/* Sets out->vertex_of: for each of `count` points the nearest vertex. */
void domain_link(domain *out, const double *at, int count);

/* Drops parts that no handle touches, with a warning: what they carry follows what is nearest.
 * Returns how many there were. */
int domain_drop(domain *d, const handles *h, const domain_options *how);

/* A cage's facets as a surface or outline of their own. */
typedef struct {
    int vertex_count;
    double *at;            /* solid: vertex_count x 3; flat: x 2 */
    int (*triangle)[3];    /* solid: facet_count */
    int loop_count, *loop; /* flat: as an outline has them */
} domain_cage;

/* 1: every edge (flat: every vertex) has two facets, so that they may go around something; then
 * `out` is made. */
int domain_cage_solid(const handles *h, domain_cage *out);
int domain_cage_flat(const handles *h, domain_cage *out);
void domain_cage_free(domain_cage *c);

/* How deep points are inside a surface that has been checked. */
typedef struct {
    const surface *s;
    const surface_origin *origin;
    int count;
    const double *at; /* count x 3 */
    double *depth;    /* count */
} domain_depths;

/* In a process of its own. */
int domain_depth(const domain_depths *d, bake_error *error);

/* The surface without vertices in one place, triangles without area, and doubles. 1: there were
 * some. The caller frees it. */
int domain_weld(const surface *s, tets_triangles *out);

/* Fills holes, however badly. Returns how many there were. */
int domain_close(tets_triangles *t);

typedef struct {
    tets_triangles t;
    double off, volume;
} domain_wrapped;

/* How large a surface is, without what is far off and small; box: where most of it is. 0: it has no
 * area. */
double domain_measure(const surface *s, double box[2][3]);

/* Places that a surface goes around, as far as it is one. */
typedef struct {
    int bones, count; /* of bones, which come first; all */
    double *at;       /* count x 3; the caller frees it */
} domain_places;

void domain_places_find(const surface *s, const handles *h, const double box[2][3],
                        domain_places *out);

/* A closed surface around a broken one, checked; how far off it is, and its volume. -1, and no new
 * message: there is nothing with an area. */
int domain_wrap(const surface *s, const handles *h, const domain_options *how, domain_wrapped *out,
                bake_error *error);

#endif
