/* CGAL and TetGen for C: plain arrays and counts go in, an int and plain arrays come out, no
 * exception leaves. All of it may crash on what its authors did not think of: call it through
 * isolate.h.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BRIDGE_H
#define BAKE_BRIDGE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A triangle surface: indices in range, coordinates finite, three different corners a triangle. */
typedef struct {
    int vertex_count, triangle_count;
    const double *at;         /* vertex_count x 3 */
    const int (*triangle)[3]; /* triangle_count */
} bridge_surface;

/* What is wrong with a surface. */
enum {
    BRIDGE_GOOD,
    BRIDGE_FLAT,      /* triangles without area */
    BRIDGE_ONE_SIDED, /* has no inside, like Klein's bottle */
    BRIDGE_CROSSING, /* pairs of triangles with a point in common that is not a corner or edge of both */
    BRIDGE_NESTED /* closed parts inside others */
};

typedef struct {
    int count;    /* how many there are */
    double at[3]; /* where the first one is */
} bridge_fault;

/* Text for a failure that is no fault of the surface. */
typedef struct {
    char text[200];
} bridge_message;

/* BRIDGE_GOOD, BRIDGE_FLAT or -1. Exact. */
int bridge_check_flat(const bridge_surface *s, bridge_fault *fault, bridge_message *message);

/* Of a surface in which every edge has two triangles, every vertex one fan of them, and none is
 * flat:
 * BRIDGE_GOOD and the volume inside, whichever way the triangles are turned; or one of the others,
 * or -1. Exact, but for the volume's rounding. */
int bridge_check_solid(const bridge_surface *s, double *volume, bridge_fault *fault,
                       bridge_message *message);

typedef struct {
    int vertex_count, tet_count;
    double *at;    /* vertex_count x 3: the surface's vertices first, bit by bit, then inner ones */
    int (*tet)[4]; /* tet_count, volumes positive: det(b - a, c - a, d - a) > 0 */
} bridge_tets;

typedef struct {
    double volume_max; /* of a tetrahedron */
    double ratio;      /* of circumscribed radius and shortest edge, at most */
    double tolerance;  /* of the whole: what is this near to a plane lies in it */
    int added_max;     /* vertices inside */
} bridge_fill;

/* Fills a surface that the checks above find good; its triangles are the outer faces. 0, or -1 and
 * a message. */
int bridge_tetgen(const bridge_surface *s, const bridge_fill *fill, bridge_tets *out,
                  bridge_message *message);
void bridge_tets_free(bridge_tets *t);

#ifdef __cplusplus
}
#endif
#endif
