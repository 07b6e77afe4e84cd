/* What can be mended in a broken surface without a new one: corners in one place become one vertex,
 * triangles without area and doubled ones go.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_parts.h"
#include "vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const double *at;
    int index;
} place;

static int order_places(const void *left, const void *right)
{
    const place *l = left, *r = right;
    for (int k = 0; k < 3; k++)
        if (l->at[k] != r->at[k])
            return l->at[k] > r->at[k] ? 1 : -1;
    return (l->index > r->index) - (l->index < r->index);
}

/* first[i]: the first vertex in the place of vertex i. */
static void find_first(const surface *s, int *first)
{
    place *list = bake_alloc((size_t)s->vertex_count + 1, sizeof *list);
    for (int i = 0; i < s->vertex_count; i++)
        list[i] = (place){s->at + 3 * (size_t)i, i};
    qsort(list, (size_t)s->vertex_count, sizeof *list, order_places);
    for (int i = 0; i < s->vertex_count; i++) {
        int same = i > 0;
        for (int k = 0; k < 3; k++)
            same = same && list[i].at[k] == list[i - 1].at[k];
        first[list[i].index] = same ? first[list[i - 1].index] : list[i].index;
    }
    free(list);
}

/* Corners in ascending order, which say which triangles are the same, and its number. */
typedef struct {
    int corner[3], index;
} key;

static int order_keys(const void *left, const void *right)
{
    const key *l = left, *r = right;
    for (int k = 0; k < 3; k++)
        if (l->corner[k] != r->corner[k])
            return l->corner[k] > r->corner[k] ? 1 : -1;
    return (l->index > r->index) - (l->index < r->index);
}

static key key_of(const int *c, int index)
{
    int low = c[0] < c[1] ? c[0] : c[1], high = c[0] < c[1] ? c[1] : c[0];
    key k = {{low < c[2] ? low : c[2], 0, high > c[2] ? high : c[2]}, index};
    k.corner[1] = low > c[2] ? low : high < c[2] ? high : c[2];
    return k;
}

/* Marks triangles with three corners that no earlier one has. */
static void mark_kept(const int (*triangle)[3], int count, char *kept)
{
    key *list = bake_alloc((size_t)count + 1, sizeof *list);
    for (int i = 0; i < count; i++)
        list[i] = key_of(triangle[i], i);
    qsort(list, (size_t)count, sizeof *list, order_keys);
    for (int i = 0; i < count; i++) {
        const int *c = list[i].corner;
        int doubled = i > 0 && memcmp(c, list[i - 1].corner, sizeof list[i].corner) == 0;
        kept[list[i].index] = !doubled && c[0] != c[1] && c[1] != c[2];
    }
    free(list);
}

/* Twice the area over the square of the longest edge. A triangle that is thin, but no fault,
 * leaves a hole of three edges, and domain_close puts it back. */
#define FLAT 1e-12

static int is_flat(const surface *s, const int *c)
{
    const double *p[3];
    double u[3], v[3], n[3], longest = 0.0;
    for (int k = 0; k < 3; k++)
        p[k] = s->at + 3 * (size_t)c[k];
    for (int k = 0; k < 3; k++) {
        u[k] = p[1][k] - p[0][k];
        v[k] = p[2][k] - p[0][k];
        longest = fmax(longest, tets_distance(p[k], p[(k + 1) % 3]));
    }
    vector_cross(u, v, n);
    return sqrt(vector_dot(n, n)) <= FLAT * longest * longest;
}

/* Numbers the vertices that are used, in their order. */
static void number_used(const surface *s, tets_triangles *out)
{
    int *number = bake_alloc((size_t)s->vertex_count + 1, sizeof *number);
    for (int i = 0; i < 3 * out->triangle_count; i++)
        number[out->triangle[i / 3][i % 3]] = 1;
    for (int i = 0; i < s->vertex_count; i++) {
        if (number[i] == 0)
            continue;
        memcpy(out->at + 3 * (size_t)out->vertex_count, s->at + 3 * (size_t)i, 3 * sizeof *s->at);
        number[i] = out->vertex_count++;
    }
    for (int i = 0; i < 3 * out->triangle_count; i++)
        out->triangle[i / 3][i % 3] = number[out->triangle[i / 3][i % 3]];
    free(number);
}

int domain_weld(const surface *s, tets_triangles *out)
{
    int *first = bake_alloc((size_t)s->vertex_count + 1, sizeof *first);
    char *kept = bake_alloc((size_t)s->triangle_count + 1, 1);
    *out = (tets_triangles){0};
    out->at = bake_alloc((size_t)s->vertex_count + 1, 3 * sizeof *out->at);
    out->triangle = bake_alloc((size_t)s->triangle_count + 1, sizeof *out->triangle);
    find_first(s, first);
    for (int i = 0; i < 3 * s->triangle_count; i++)
        out->triangle[i / 3][i % 3] = first[s->triangle[i / 3][i % 3]];
    mark_kept((const int(*)[3])out->triangle, s->triangle_count, kept);
    for (int i = 0; i < s->triangle_count; i++)
        if (kept[i] && !is_flat(s, out->triangle[i]))
            memmove(out->triangle[out->triangle_count++], out->triangle[i], sizeof *out->triangle);
    number_used(s, out);
    free(kept);
    free(first);
    return out->vertex_count < s->vertex_count || out->triangle_count < s->triangle_count;
}
