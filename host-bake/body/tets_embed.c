/* Finds the tetrahedron or triangle that carries a point.
 * Source: own; the nearest point of a triangle after Ericson, Real-Time Collision Detection, 5.1.5.
 *   element  what can carry a point: tetrahedra; a shell's triangles
 *   face     the triangles of the body's surface: where the nearest point of it is sought
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "tets_parts.h"
#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the body's size: a point that near to a vertex is the vertex. */
#define SAME 1e-9

/* Of a weight: rounding may put a point on a face outside of both its tetrahedra. Distances are
 * equal within it when the nearest point is on an edge. */
#define ROUNDING 1e-12

typedef struct {
    const body *b;
    int face_count;
    tets_face *face;
    tets_grid elements, faces;
    double size;
} finder;

static const double *place(const body *b, int vertex)
{
    return b->rest + 3 * (size_t)vertex;
}

/* ---- the surface ------------------------------------------------------------------------------ */

static int order_faces(const void *left, const void *right)
{
    const tets_face *l = left, *r = right;
    for (int k = 0; k < 3; k++)
        if (l->corner[k] != r->corner[k])
            return l->corner[k] > r->corner[k] ? 1 : -1;
    return (l->element > r->element) - (l->element < r->element);
}

static void exchange(int *a, int *b)
{
    int least = *a < *b ? *a : *b, most = *a < *b ? *b : *a;
    *a = least;
    *b = most;
}

static tets_face sorted_face(const int *corner, int skip, int element)
{
    tets_face f = {{0, 0, 0}, element};
    for (int k = 0, n = 0; n < 3; k++)
        if (k != skip)
            f.corner[n++] = corner[k];
    exchange(&f.corner[0], &f.corner[1]);
    exchange(&f.corner[1], &f.corner[2]);
    exchange(&f.corner[0], &f.corner[1]);
    return f;
}

static int same_face(const tets_face *a, const tets_face *b)
{
    return memcmp(a->corner, b->corner, sizeof a->corner) == 0;
}

/* The faces of one tetrahedron alone; all triangles of a shell. */
static tets_face *find_faces(const body *b, int *count)
{
    int sides = b->kind == BODY_SHELL ? 1 : 4, all = sides * b->element_count, kept = 0;
    tets_face *list = bake_alloc((size_t)all, sizeof *list);
    for (int i = 0; i < all; i++)
        list[i] = sorted_face(b->element[i / sides], 3 - i % sides, i / sides);
    if (sides == 4)
        qsort(list, (size_t)all, sizeof *list, order_faces);
    for (int i = 0; i < all; i++) {
        int alone = sides == 1 || ((i == 0 || !same_face(&list[i], &list[i - 1])) &&
                                   (i == all - 1 || !same_face(&list[i], &list[i + 1])));
        if (alone)
            list[kept++] = list[i];
    }
    *count = kept;
    return list;
}

/* ---- weights ---------------------------------------------------------------------------------- */

/* Barycentric; their sum is 1 to rounding, because the last is what the others leave. */
static void weigh_tet(const body *b, int element, const double *p, double *weight)
{
    const double *at[4];
    for (int k = 0; k < 4; k++)
        at[k] = place(b, b->element[element][k]);
    double whole = tets_det(at[0], at[1], at[2], at[3]);
    weight[1] = tets_det(at[0], p, at[2], at[3]) / whole;
    weight[2] = tets_det(at[0], at[1], p, at[3]) / whole;
    weight[3] = tets_det(at[0], at[1], at[2], p) / whole;
    weight[0] = 1.0 - weight[1] - weight[2] - weight[3];
}

/* Of the point of the segment from corner i to j that is nearest. */
static void weigh_edge(const double *const at[3], int i, int j, const double *p, double *weight)
{
    double along[3], to[3];
    for (int k = 0; k < 3; k++) {
        along[k] = at[j][k] - at[i][k];
        to[k] = p[k] - at[i][k];
    }
    double whole = vector_dot(along, along), t = whole > 0.0 ? vector_dot(along, to) / whole : 0.0;
    t = fmax(0.0, fmin(1.0, t));
    weight[0] = weight[1] = weight[2] = 0.0;
    weight[i] = 1.0 - t;
    weight[j] = t;
}

static double distance_of(const double *const at[3], const double *weight, const double *p)
{
    double to[3];
    for (int k = 0; k < 3; k++)
        to[k] = weight[0] * (at[0][k] - p[k]) + weight[1] * (at[1][k] - p[k]) +
                weight[2] * (at[2][k] - p[k]);
    return vector_dot(to, to);
}

double tets_weigh_triangle(const double *const at[3], const double *p, double *weight)
{
    double u[3], v[3], to[3], best = HUGE_VAL;
    for (int k = 0; k < 3; k++) {
        u[k] = at[1][k] - at[0][k];
        v[k] = at[2][k] - at[0][k];
        to[k] = p[k] - at[0][k];
    }
    double uu = vector_dot(u, u), uv = vector_dot(u, v), vv = vector_dot(v, v),
           whole = uu * vv - uv * uv;
    weight[1] = (vv * vector_dot(u, to) - uv * vector_dot(v, to)) / whole;
    weight[2] = (uu * vector_dot(v, to) - uv * vector_dot(u, to)) / whole;
    weight[0] = 1.0 - weight[1] - weight[2];
    if (whole > 0.0 && weight[0] >= 0.0 && weight[1] >= 0.0 && weight[2] >= 0.0)
        return distance_of(at, weight, p);
    for (int k = 0; k < 3; k++) {
        double tried[3];
        weigh_edge(at, k, (k + 1) % 3, p, tried);
        double distance = distance_of(at, tried, p);
        if (distance < best) {
            best = distance;
            memcpy(weight, tried, sizeof tried);
        }
    }
    return best;
}

/* ---- what is asked for each point ------------------------------------------------------------- */

typedef struct {
    const finder *f;
    const double *p;
    int element;   /* -1: none yet */
    double value;  /* inside: its least weight; outside: the square of the distance */
    double spread; /* outside: the largest weight, which is how much a deformation is enlarged */
    double weight[4];
} search;

static void try_inside(void *what, int element)
{
    search *s = what;
    double weight[4];
    weigh_tet(s->f->b, element, s->p, weight);
    double least = fmin(fmin(weight[0], weight[1]), fmin(weight[2], weight[3]));
    if (s->element < 0 || least > s->value) {
        s->element = element;
        s->value = least;
        memcpy(s->weight, weight, sizeof weight);
    }
}

/* Faces that share the nearest point compete by their spread. */
static double try_face(void *what, int face)
{
    search *s = what;
    const body *b = s->f->b;
    const tets_face *t = &s->f->face[face];
    const int *corner = b->kind == BODY_SHELL ? b->element[t->element] : t->corner;
    const double *const at[3] = {place(b, corner[0]), place(b, corner[1]), place(b, corner[2])};
    double weight[4] = {0.0, 0.0, 0.0, 0.0}, spread = 1.0;
    double distance = tets_weigh_triangle(at, s->p, weight);
    if (s->element >= 0 && distance > s->value * (1.0 + ROUNDING))
        return s->value;
    if (b->kind == BODY_SOLID) {
        weigh_tet(b, t->element, s->p, weight);
        for (int k = 0; k < 4; k++)
            spread = fmax(spread, fabs(weight[k]));
    }
    if (s->element < 0 || distance < s->value * (1.0 - ROUNDING) || spread < s->spread) {
        s->value = s->element < 0 ? distance : fmin(distance, s->value);
        s->element = t->element;
        s->spread = spread;
        memcpy(s->weight, weight, sizeof weight);
    }
    return s->value;
}

/* A point that coincides with a corner gets it alone. */
static void give(const search *s, embedding *out)
{
    const finder *f = s->f;
    int corners = f->b->kind == BODY_SHELL ? 3 : 4;
    for (int k = 0; k < 4; k++) {
        out->vertex[k] = f->b->element[s->element][k < corners ? k : 0];
        out->weight[k] = k < corners ? s->weight[k] : 0.0;
    }
    for (int k = 0; k < corners; k++)
        if (tets_distance(s->p, place(f->b, out->vertex[k])) <= SAME * f->size) {
            memset(out->weight, 0, sizeof out->weight);
            out->weight[k] = 1.0;
            return;
        }
}

/* Returns the point's distance from the body. */
static double embed(const finder *f, const double *p, embedding *out)
{
    search s = {.f = f, .p = p, .element = -1};
    if (f->b->kind == BODY_SOLID)
        tets_grid_at(&f->elements, p, try_inside, &s);
    int inside = s.element >= 0 && s.value >= -ROUNDING;
    if (!inside) {
        s.element = -1;
        tets_grid_near(&f->faces, p, try_face, &s);
    }
    give(&s, out);
    return inside ? 0.0 : sqrt(s.value);
}

/* ---- all of it -------------------------------------------------------------------------------- */

static void box_of(const body *b, const int *corner, int corners, double box[2][3])
{
    for (int k = 0; k < 3; k++) {
        box[0][k] = HUGE_VAL;
        box[1][k] = -HUGE_VAL;
        for (int i = 0; i < corners; i++) {
            box[0][k] = fmin(box[0][k], place(b, corner[i])[k]);
            box[1][k] = fmax(box[1][k], place(b, corner[i])[k]);
        }
    }
}

static void box_of_element(const void *what, int i, double box[2][3])
{
    const finder *f = what;
    box_of(f->b, f->b->element[i], 4, box);
}

static void box_of_face(const void *what, int i, double box[2][3])
{
    const finder *f = what;
    box_of(f->b, f->face[i].corner, 3, box);
}

static int check(const body *b, const double *at, int count, bake_error *error)
{
    int corners = b->kind == BODY_SHELL ? 3 : 4;
    if (b->element_count < 1)
        return bake_fail(error, "a body without elements carries no points");
    for (int i = 0; i < b->element_count; i++)
        for (int k = 0; k < corners; k++)
            if (b->element[i][k] < 0 || b->element[i][k] >= b->vertex_count)
                return bake_fail(error, "element %d of a body has a corner %d, of %d", i,
                                 b->element[i][k], b->vertex_count);
    for (int i = 0; i < count; i++)
        if (!isfinite(vector_dot(at + 3 * (size_t)i, at + 3 * (size_t)i)))
            return bake_fail(error, "vertex %d, which a body is to carry, is at (%g, %g, %g)", i,
                             at[3 * (size_t)i], at[3 * (size_t)i + 1], at[3 * (size_t)i + 2]);
    return 0;
}

int tets_embed(const body *b, const double *at, int count, embedding *out, double *far,
               bake_error *error)
{
    finder f = {.b = b};
    if (check(b, at, count, error))
        return -1;
    f.face = find_faces(b, &f.face_count);
    if (b->kind == BODY_SOLID)
        tets_grid_make(&f.elements, b->element_count, box_of_element, &f);
    tets_grid_make(&f.faces, f.face_count, box_of_face, &f);
    f.size = tets_distance(f.faces.low, f.faces.high);
    *far = 0.0;
    for (int i = 0; i < count; i++)
        *far = fmax(*far, embed(&f, at + 3 * (size_t)i, &out[i]));
    tets_grid_free(&f.elements);
    tets_grid_free(&f.faces);
    free(f.face);
    return 0;
}
