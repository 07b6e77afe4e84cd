/* Where weights live: a flat shape in triangles, a surface, or a solid in tetrahedra; and the
 * handles that hold it. CGAL triangulates flat shapes and wraps broken surfaces, TetGen fills closed
 * ones; all of that runs in a process of its own (isolate.h).
 * Source: Jacobson 2013, 4.3 (handles), 4.3.4 and 4.5 (conforming domains), 4.8 (images).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_DOMAIN_H
#define BAKE_DOMAIN_H

#include "bake.h"
#include "tets.h"

/* Triangles have element[i][3] = -1; flat shapes have z = 0. */
typedef struct {
    int dimension; /* of an element: 2 triangles, 3 tetrahedra */
    int vertex_count, element_count;
    double *at;        /* vertex_count x 3 */
    int (*element)[4]; /* triangles counter-clockwise; tetrahedra of positive volume */
    double *lift;      /* vertex_count x 3: further coordinates (an image's colours), or NULL */
    int wrapped;       /* 1: the surface was broken and has been wrapped */
    double cell;    /* that it was made with; 0: handles were not sampled, each takes the vertices
                          nearest to it */
    int from_count; /* vertices of the surface or outline, where they are not the first ones: */
    int *vertex_of; /* the nearest of the domain; or NULL */
} domain;

void domain_free(domain *d);

/* What holds a shape.                                                     [Jacobson 4.1, 4.3] */
typedef enum { HANDLE_POINT, HANDLE_REGION, HANDLE_BONE, HANDLE_CAGE } handle_kind;

typedef struct {
    const char *name;
    int line; /* of the scene */
    handle_kind kind;
    double from[3], to[3]; /* a point and a cage's vertex: from; a bone: both */
    int vertex_count;      /* a region: vertices of the surface or flat shape that the domain is */
    const int *vertex;     /* made from, in its order */
} handle;

/* A cage's facets join HANDLE_CAGE handles: triangles of a solid or surface; edges of a flat shape
 * have facet[i][2] = -1. They may be closed, open or partial. Facets are no handles. */
typedef struct {
    int count, facet_count;
    const handle *handle;
    const int (*facet)[3];
} handles;

/* Closed polylines: the outer ones and holes, in any direction, not crossing one another. */
typedef struct outline {
    int loop_count, point_count;
    const int *loop;  /* loop_count + 1: where each starts in `at` */
    const double *at; /* point_count x 2 */
} outline;

typedef struct {
    double cell; /* length of an edge, about; 0: chosen, about 50,000 tetrahedra or 10,000
                                     triangles */
    const surface_origin *origin; /* for messages */
    int wrap;                     /* 1: a broken surface is wrapped, with a warning; 0: refused */
} domain_options;

/* Flat: constrained Delaunay triangles, no angle below 20 degrees where the outline allows it, near
 * `cell` large. The outline's points come first, bit by bit; samples of all handles inside are
 * vertices. A closed cage that goes around the outline is the domain's border instead. */
int domain_flat(const outline *o, const handles *h, const domain_options *how, domain *out,
                bake_error *error);

/* Solid: tetrahedra inside a surface, whose vertices come first, bit by bit (`vertex_of` is NULL
 * then); samples of bones and of cage facets, points and region vertices inside are vertices. A
 * closed cage that goes around the surface is the domain's border instead. how->wrap: a broken
 * surface is mended by merging equal vertices, then by closing holes, and else wrapped; stderr
 * says which. Of flat shapes and solids, parts that no handle touches are left out, with a
 * warning: domain_embed gives what is there the nearest part's weights. */
int domain_solid(const surface *s, const handles *h, const domain_options *how, domain *out,
                 bake_error *error);

/* The triangles of a surface as they are, or the tetrahedra of a body: handles are not sampled,
 * points and bones go to the nearest vertices. */
int domain_surface(const surface *s, domain *out, bake_error *error);

/* Values that weights have on handles: 1 and 0; 1/s at a joint that s bones share (one of them may
 * pass there, the others end); linear on cage facets. vertex: ascending, each once. */
typedef struct {
    int count, handle_count;
    int *vertex;
    double *value; /* count x handle_count, row by row */
} held;

/* All is found by place: vertices on a bone or facet (to a thousandth of a cell) are held; samples
 * that got none, because they are nearer than an eighth of a cell to the border, take the nearest
 * that is left. Fails, naming the handle, when one touches no vertex: a bone or point outside the
 * shape, or two in one place. */
int domain_hold(const domain *d, const handles *h, const domain_options *how, held *out,
                bake_error *error);
void held_free(held *h);

/* Weights at other points, as means of the domain's vertices; outside, those of the nearest point
 * of it: none is negative. far: the largest distance. at: count x 3. */
int domain_embed(const domain *d, const double *at, int count, embedding *out, double *far,
                 bake_error *error);

#endif
