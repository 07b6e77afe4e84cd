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
    double volume_max;   /* of a tetrahedron */
    double ratio;        /* of circumscribed radius and shortest edge, at most */
    double tolerance;    /* of the whole: what is this near to a plane lies in it */
    int added_max;       /* vertices inside */
    int point_count;     /* inside the surface, apart from it and from each other: */
    const double *point; /* point_count x 3: vertices after the surface's, bit by bit */
} bridge_fill;

/* Fills a surface that the checks above find good; its triangles are the outer faces. 0, or -1 and
 * a message. */
int bridge_tetgen(const bridge_surface *s, const bridge_fill *fill, bridge_tets *out,
                  bridge_message *message);
void bridge_tets_free(bridge_tets *t);

typedef struct {
    int vertex_count, triangle_count;
    double *at;         /* vertex_count x 3 */
    int (*triangle)[3]; /* triangle_count */
} bridge_mesh;
void bridge_mesh_free(bridge_mesh *m);

/* Closed polylines: loop i is the points loop[i] .. loop[i + 1] - 1; what is inside an odd number
 * of them is the shape. No two points are in one place. */
typedef struct {
    int loop_count, point_count;
    const int *loop;
    const double *at; /* point_count x 2 */
    int inner_count;
    const double *inner; /* inner_count x 2: inside, apart from the loops and from each other */
    double longest;      /* of the edges of triangles */
    int vertices_max;    /* of triangles */
} bridge_outline;

/* Fills an outline with triangles whose angles are wider than 20 degrees where the outline's are;
 * z = 0, counter-clockwise. Its points come first, bit by bit, then the inner ones. BRIDGE_GOOD;
 * BRIDGE_CROSSING where the outline crosses or touches itself; or -1 and a message. */
int bridge_triangulate(const bridge_outline *o, bridge_mesh *out, bridge_fault *fault,
                       bridge_message *message);

/* A closed surface around triangles that may be anything: `offset` off them, and it goes in through
 * openings that a ball of radius `alpha` goes through. 0, or -1 and a message. */
int bridge_wrap(const bridge_surface *s, double alpha, double offset, bridge_mesh *out,
                bridge_message *message);

/* How deep points are inside of a surface that bridge_check_solid finds good: the distance from it,
 * negative outside. 0, or -1 and a message. */
int bridge_depth(const bridge_surface *s, const double *at, int count, double *depth,
                 bridge_message *message);

#ifdef __cplusplus
}
#endif
#endif
