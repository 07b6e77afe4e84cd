/* What the files of shells share.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SHELL_PARTS_H
#define BAKE_SHELL_PARTS_H

#include "elastic_parts.h"
#include "vector.h"

#include <math.h>

/* Two triangles with a common edge v[0] < v[1]; v[2], v[3] are opposite to it. */
typedef struct {
    int v[4];
    double angle; /* at rest */
} shell_hinge;

typedef struct {
    double area;
    double axis[2][3]; /* of its plane at rest, orthonormal */
    double g[2][2];    /* gradients of the barycentric functions of corners 1, 2 along the axes */
    int hinge[3];      /* of the side opposite to a corner; -1: border */
    double bend[3][3]; /* 1/2 sum bend[i][j] turn[hinge i] turn[hinge j]; 0 for the border */
} shell_face;

/* body.elements. One block of memory: this, faces (as many as elements), hinges. */
typedef struct {
    int hinge_count;
    shell_face *face;
    shell_hinge *hinge;
} shell;

static inline void shell_corners(const shell_hinge *hinge, const double *x, const double *at[4])
{
    for (int a = 0; a < 4; a++)
        at[a] = &x[3 * hinge->v[a]];
}

#endif
