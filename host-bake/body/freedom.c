/* Directions that vertices may move in.
 *   A    k x 3   orthonormal axes of one vertex, k <= 3
 * Source: own; the constraints are linear and concern one vertex each [Schulz 2.2.1, 2.7.3], so
 * that they can be projected out exactly. Until freedom_finish first[i] counts the axes of vertex
 * i, which are at axis[3 i]; then they are packed.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "freedom.h"
#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A normal within this angle [rad] of those already taken is one of them in fewer digits. */
#define SAME_NORMAL 1e-4

void freedom_make(int vertex_count, freedom *out)
{
    size_t n = (size_t)vertex_count;
    *out = (freedom){.vertex_count = vertex_count, .count = 3 * vertex_count};
    out->first = bake_alloc(n + 1, sizeof *out->first);
    out->axis = bake_alloc(3 * n, sizeof *out->axis);
    for (size_t i = 0; i < n; i++) {
        out->first[i] = 3;
        for (int k = 0; k < 3; k++)
            out->axis[3 * i + (size_t)k][k] = 1;
    }
}

static int normalise(double v[3])
{
    double length = hypot(hypot(v[0], v[1]), v[2]);
    if (!(length > 0) || !isfinite(length))
        return 0;
    for (int i = 0; i < 3; i++)
        v[i] /= length;
    return 1;
}

/* From all of space: two axes of the plane, those of the coordinates where it is one of theirs. */
static void leave_plane(const double n[3], double axis[3][3])
{
    int least = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(n[i]) < fabs(n[least]))
            least = i;
    double e[3] = {0};
    e[least] = 1;
    vector_cross(n, e, axis[0]);
    normalise(axis[0]);
    vector_cross(axis[0], n, axis[1]);
    normalise(axis[1]);
}

/* From a plane: the direction in it on which n is perpendicular. */
static void leave_line(const double n[3], double axis[3][3])
{
    double c0 = vector_dot(axis[0], n), c1 = vector_dot(axis[1], n), left[3];
    for (int i = 0; i < 3; i++)
        left[i] = c0 * axis[1][i] - c1 * axis[0][i];
    normalise(left);
    memcpy(axis[0], left, sizeof left);
}

void freedom_slide(freedom *f, int vertex, const double normal[3])
{
    double n[3] = {normal[0], normal[1], normal[2]}, (*axis)[3] = &f->axis[3 * (size_t)vertex];
    int *had = &f->first[vertex];
    double inside = 0;
    if (!normalise(n))
        return;
    for (int k = 0; k < *had; k++)
        inside = hypot(inside, vector_dot(axis[k], n));
    if (inside <= SAME_NORMAL)
        return;
    if (*had == 3)
        leave_plane(n, axis);
    else if (*had == 2)
        leave_line(n, axis);
    (*had)--;
    f->count--;
}

void freedom_fix(freedom *f, int vertex)
{
    f->count -= f->first[vertex];
    f->first[vertex] = 0;
}

void freedom_finish(freedom *f)
{
    int next = 0;
    for (int i = 0; i < f->vertex_count; i++) {
        int had = f->first[i];
        memmove(&f->axis[next], &f->axis[3 * (size_t)i], (size_t)had * sizeof *f->axis);
        f->first[i] = next;
        next += had;
    }
    f->first[f->vertex_count] = next;
}

void freedom_free(freedom *f)
{
    free(f->first);
    free(f->axis);
    *f = (freedom){0};
}

void freedom_expand(const freedom *f, const double *y, double *u)
{
    memset(u, 0, 3 * (size_t)f->vertex_count * sizeof *u);
    for (int i = 0; i < f->vertex_count; i++)
        for (int k = f->first[i]; k < f->first[i + 1]; k++)
            for (int j = 0; j < 3; j++)
                u[3 * i + j] += f->axis[k][j] * y[k];
}

void freedom_restrict(const freedom *f, const double *u, double *y)
{
    for (int i = 0; i < f->vertex_count; i++)
        for (int k = f->first[i]; k < f->first[i + 1]; k++)
            y[k] = vector_dot(f->axis[k], &u[3 * i]);
}
