/* Shells: from triangles at rest to what their energy needs of them.
 *   l_i, d_ij       sides of a triangle, opposite to corner i: length, product of sides i and j
 *   bend   3 x 3    D/(4 A) (nu l_i l_j + (1 - nu) d_ij^2/(l_i l_j)): the energy in shell.c,
 *                   written in the angles; without the border's rows and columns (see unbend)
 * Source: the energy is shell.c's; this form of it is our own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shell_angle.h"
#include "shell_parts.h"

#include <limits.h>
#include <stdlib.h>

/* Twice the area of a triangle as a share of its longest side's square (equilateral: 0.87). Below
 * this, rounding of the coordinates decides more than the fourth digit of its height. */
#define FLAT 1e-12

/* A side of a triangle; corner: the one opposite to it, 0 .. 2. */
typedef struct {
    int v[2], face, corner;
} half_edge;

/* Twice the area; side[a] goes around, opposite to corner a; normal of unit length. */
static double face_sides(const double *x, const int corner[3], double side[3][3], double normal[3])
{
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            side[a][i] = x[3 * corner[(a + 2) % 3] + i] - x[3 * corner[(a + 1) % 3] + i];
    vector_cross(side[0], side[1], normal);
    double twice = sqrt(vector_dot(normal, normal));
    for (int i = 0; i < 3; i++)
        normal[i] /= twice;
    return twice;
}

static int by_vertices(const void *left, const void *right)
{
    const half_edge *a = left, *b = right;
    int order = (a->v[0] > b->v[0]) - (a->v[0] < b->v[0]);
    if (!order)
        order = (a->v[1] > b->v[1]) - (a->v[1] < b->v[1]);
    return order ? order : (a->face > b->face) - (a->face < b->face);
}

/* All sides, those of one edge next to each other, its vertices and faces in the order of indices:
 * its angle does not depend on how triangles are wound, and neighbours may disagree. */
static half_edge *sorted_sides(const body *b)
{
    int count = 3 * b->element_count;
    half_edge *sides = bake_alloc((size_t)count, sizeof *sides);
    for (int i = 0; i < count; i++) {
        const int *corner = b->element[i / 3];
        int p = corner[(i + 1) % 3], q = corner[(i + 2) % 3];
        sides[i] = (half_edge){{p < q ? p : q, p < q ? q : p}, i / 3, i % 3};
    }
    qsort(sides, (size_t)count, sizeof *sides, by_vertices);
    return sides;
}

static int same_edge(const half_edge *a, const half_edge *b)
{
    return a->v[0] == b->v[0] && a->v[1] == b->v[1];
}

static int opposite(const body *b, const half_edge *side)
{
    return b->element[side->face][side->corner];
}

/* How many edges have two triangles. */
static int count_hinges(const body *b, const half_edge *side, int *hinges, bake_error *error)
{
    *hinges = 0;
    for (int i = 0, run = 0; i < 3 * b->element_count; i++) {
        run = i > 0 && same_edge(&side[i], &side[i - 1]) ? run + 1 : 1;
        *hinges += run == 2;
        if (run == 2 && opposite(b, &side[i]) == opposite(b, &side[i - 1]))
            return bake_fail(error, "triangles %d and %d have the same vertices: remove one",
                             side[i - 1].face, side[i].face);
        if (run == 3)
            return bake_fail(error,
                             "the edge of vertices %d and %d has more than two triangles (%d, %d, "
                             "%d): a shell is one sheet; use a solid, or cut the parts apart",
                             side[i].v[0], side[i].v[1], side[i - 2].face, side[i - 1].face,
                             side[i].face);
    }
    return 0;
}

/* ---- bending --------------------------------------------------------------------------------- */

static void make_hinge(const body *b, shell *s, const half_edge side[2])
{
    shell_hinge *hinge = &s->hinge[s->hinge_count];
    const double *at[4];
    for (int k = 0; k < 2; k++) {
        hinge->v[k] = side->v[k];
        hinge->v[2 + k] = opposite(b, &side[k]);
        s->face[side[k].face].hinge[side[k].corner] = s->hinge_count;
    }
    s->hinge_count++;
    shell_corners(hinge, b->rest, at);
    hinge->angle = shell_angle(at);
}

/* A hinge's angle is signed by the order of its vertices; times this, 1 or -1, by the triangle's
 * own winding: its three angles have one sign where it bends one way. */
static int hinge_sign(const shell_hinge *hinge, const int corner[3], int i)
{
    int forward = corner[(i + 1) % 3] == hinge->v[0], first = corner[i] == hinge->v[2];
    return forward == first ? 1 : -1;
}

/* Minimises over the angle at side i: the border turns as it likes, as no moment acts on it.
 * Without this a border's triangle would take curvature across it for a part of what it is. A
 * second pivot that is rounding, of borders that are nearly parallel, has a column that is rounding
 * too. */
static void unbend(double bend[3][3], int i)
{
    double pivot = bend[i][i], column[3] = {bend[0][i], bend[1][i], bend[2][i]};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            if (pivot > 0)
                bend[a][b] -= column[a] * column[b] / pivot;
            if (a == i || b == i)
                bend[a][b] = 0;
        }
}

static void make_bend(const body *b, const shell *s, int f)
{
    const body_material *m = &b->material;
    shell_face *face = &s->face[f];
    double side[3][3], normal[3], length[3], nu = m->poisson, h = m->thickness;
    double twice = face_sides(b->rest, b->element[f], side, normal);
    double weight = m->young * h * h * h / (12 * (1 - nu * nu)) / (2 * twice);
    for (int i = 0; i < 3; i++)
        length[i] = sqrt(vector_dot(side[i], side[i]));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double ll = length[i] * length[j], d = vector_dot(side[i], side[j]);
            face->bend[i][j] = weight * (nu * ll + (1 - nu) * d * d / ll);
        }
    for (int i = 0; i < 3; i++)
        if (face->hinge[i] < 0)
            unbend(face->bend, i);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (face->hinge[i] >= 0 && face->hinge[j] >= 0)
                face->bend[i][j] *= hinge_sign(&s->hinge[face->hinge[i]], b->element[f], i) *
                                    hinge_sign(&s->hinge[face->hinge[j]], b->element[f], j);
}

/* ---- faces ----------------------------------------------------------------------------------- */

static int make_face(body *b, const shell *s, int f, bake_error *error)
{
    const int *corner = b->element[f];
    const double *at = &b->rest[3 * corner[0]];
    double side[3][3], normal[3], longest = 0, twice;
    twice = face_sides(b->rest, corner, side, normal);
    for (int a = 0; a < 3; a++)
        longest = fmax(longest, vector_dot(side[a], side[a]));
    if (!(twice > FLAT * longest))
        return bake_fail(error, "triangle %d at (%g, %g, %g) m has no area", f, at[0], at[1],
                         at[2]);
    shell_face *face = &s->face[f];
    double base = sqrt(vector_dot(side[2], side[2])), height = twice / base;
    for (int i = 0; i < 3; i++)
        face->axis[0][i] = side[2][i] / base;
    vector_cross(normal, face->axis[0], face->axis[1]);
    face->area = 0.5 * twice;
    face->g[0][0] = 1 / base;
    face->g[0][1] = vector_dot(side[1], face->axis[0]) / (base * height);
    face->g[1][0] = 0;
    face->g[1][1] = 1 / height;
    for (int a = 0; a < 3; a++) {
        face->hinge[a] = -1;
        b->mass[corner[a]] += b->material.density * b->material.thickness * twice / 6;
    }
    return 0;
}

static int make_sorted(body *b, const half_edge *side, bake_error *error)
{
    int hinges, sides = 3 * b->element_count;
    size_t faces = (size_t)b->element_count;
    if (count_hinges(b, side, &hinges, error))
        return -1;
    shell *s = b->elements = bake_alloc(1, sizeof(shell) + faces * sizeof(shell_face) +
                                               (size_t)hinges * sizeof(shell_hinge));
    s->face = (shell_face *)(void *)(s + 1);
    s->hinge = (shell_hinge *)(void *)(s->face + faces);
    for (int f = 0; f < b->element_count; f++)
        if (make_face(b, s, f, error))
            return -1;
    for (int i = 1; i < sides; i++)
        if (same_edge(&side[i - 1], &side[i]))
            make_hinge(b, s, &side[i - 1]);
    for (int f = 0; f < b->element_count; f++)
        make_bend(b, s, f);
    return 0;
}

int shell_prepare(body *b, bake_error *error)
{
    if (b->element_count > INT_MAX / 3)
        return bake_fail(error, "%d triangles are too many", b->element_count);
    half_edge *sides = sorted_sides(b);
    int failed = make_sorted(b, sides, error);
    free(sides);
    return failed;
}
