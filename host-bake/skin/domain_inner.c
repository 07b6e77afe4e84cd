/* How large a broken surface is, and places that it goes around as far as it is a surface: where its
 * wrap must not be hollow.
 * Source: winding numbers: Jacobson 2013, ch. 8; the places are own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_parts.h"
#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Triangles times places: a tenth of a second. */
#define PRODUCTS 4e6

/* A grid of them, an axis. */
enum { GRID_LEAST = 4, GRID_MOST = 10, BONE_PLACES = 3 };

/* In standard deviations of the area: most of any shape, and no more of the box than that. */
#define SPREAD 2.2

/* Solid angle of a triangle over 4 pi, seen from p (van Oosterom and Strackee). */
static double turns_around(const surface *s, int i, const double *p)
{
    double v[3][3], n[3], length[3];
    for (int k = 0; k < 3; k++) {
        for (int x = 0; x < 3; x++)
            v[k][x] = s->at[3 * (size_t)s->triangle[i][k] + (size_t)x] - p[x];
        length[k] = sqrt(vector_dot(v[k], v[k]));
    }
    vector_cross(v[1], v[2], n);
    double below = length[0] * length[1] * length[2] + vector_dot(v[0], v[1]) * length[2] +
                   vector_dot(v[1], v[2]) * length[0] + vector_dot(v[2], v[0]) * length[1];
    return atan2(vector_dot(v[0], n), below) / (2.0 * acos(-1.0));
}

/* Whichever way the triangles are turned, all but a few of them the same way. */
static int goes_around(const surface *s, const double *p)
{
    double sum = 0.0;
    for (int i = 0; i < s->triangle_count; i++)
        sum += turns_around(s, i, p);
    return fabs(sum) > 0.5;
}

/* ---- size ------------------------------------------------------------------------------------- */

typedef struct {
    double low[3], high[3];
    double area, sum[3], square[3]; /* sums over triangles of area times place */
} moments;

static void add_triangle(const surface *s, int i, moments *m)
{
    const double *p[3];
    double u[3], v[3], n[3];
    for (int k = 0; k < 3; k++)
        p[k] = s->at + 3 * (size_t)s->triangle[i][k];
    for (int k = 0; k < 3; k++) {
        u[k] = p[1][k] - p[0][k];
        v[k] = p[2][k] - p[0][k];
    }
    vector_cross(u, v, n);
    double area = sqrt(vector_dot(n, n));
    m->area += area;
    for (int k = 0; k < 3; k++) {
        double middle = (p[0][k] + p[1][k] + p[2][k]) / 3.0;
        m->sum[k] += area * middle;
        m->square[k] += area * middle * middle;
        m->low[k] = fmin(m->low[k], fmin(p[0][k], fmin(p[1][k], p[2][k])));
        m->high[k] = fmax(m->high[k], fmax(p[0][k], fmax(p[1][k], p[2][k])));
    }
}

/* Four times the mean distance from the middle is 0.88 of the box's diagonal or more for animals,
 * and specks that are far off count as little as they weigh. */
double domain_measure(const surface *s, double box[2][3])
{
    moments m = {
        {HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, 0.0, {0.0}, {0.0}};
    double all = 0.0;
    for (int i = 0; i < s->triangle_count; i++)
        add_triangle(s, i, &m);
    if (!(m.area > 0.0))
        return 0.0;
    for (int k = 0; k < 3; k++) {
        double middle = m.sum[k] / m.area;
        double variance = fmax(0.0, m.square[k] / m.area - middle * middle);
        box[0][k] = fmax(m.low[k], middle - SPREAD * sqrt(variance));
        box[1][k] = fmin(m.high[k], middle + SPREAD * sqrt(variance));
        all += variance;
    }
    return fmin(tets_distance(m.low, m.high), 4.0 * sqrt(all));
}

/* ---- places ----------------------------------------------------------------------------------- */

static void add_place(const surface *s, const double *p, domain_places *out)
{
    if (!goes_around(s, p))
        return;
    memcpy(out->at + 3 * (size_t)out->count, p, 3 * sizeof *p);
    out->count++;
}

static void add_bones(const surface *s, const handles *h, domain_places *out)
{
    for (int i = 0; i < BONE_PLACES * h->count; i++) {
        const handle *b = &h->handle[i / BONE_PLACES];
        double p[3], t = (i % BONE_PLACES + 1.0) / (BONE_PLACES + 1.0);
        for (int k = 0; k < 3; k++)
            p[k] = (1.0 - t) * b->from[k] + t * b->to[k];
        if (b->kind == HANDLE_BONE)
            add_place(s, p, out);
    }
    out->bones = out->count;
}

void domain_places_find(const surface *s, const handles *h, const double box[2][3],
                        domain_places *out)
{
    int grid = (int)fmax(GRID_LEAST, fmin(GRID_MOST, floor(cbrt(PRODUCTS / s->triangle_count))));
    int all = grid * grid * grid;
    *out = (domain_places){0};
    out->at = bake_alloc((size_t)(BONE_PLACES * h->count + all), 3 * sizeof *out->at);
    add_bones(s, h, out);
    for (int i = 0; i < all; i++) {
        const int cell[3] = {i % grid, i / grid % grid, i / grid / grid};
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = box[0][k] + (cell[k] + 0.5) / grid * (box[1][k] - box[0][k]);
        add_place(s, p, out);
    }
}
