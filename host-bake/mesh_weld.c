/* Makes one vertex of those that stand in one place in every pose, and drops what is not seen.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    int count, vertices;
    double **at; /* of rest, every frame, every shape: vertices x 3 */
} poses;

static poses list_poses(const mesh *m)
{
    poses p = {.count = 1 + m->shape_count, .vertices = m->vertex_count};
    for (int i = 0; i < m->frames_count; i++)
        p.count += m->frames[i].count;
    p.at = bake_alloc((size_t)p.count, sizeof *p.at);
    size_t values = 3 * (size_t)m->vertex_count;
    int used = 0;
    p.at[used++] = m->rest;
    for (int i = 0; i < m->frames_count; i++)
        for (int j = 0; j < m->frames[i].count; j++)
            p.at[used++] = m->frames[i].at + (size_t)j * values;
    for (int i = 0; i < m->shape_count; i++)
        p.at[used++] = m->shape + (size_t)i * values;
    return p;
}

static int same_vertex(const poses *p, int a, int b)
{
    for (int i = 0; i < p->count; i++)
        if (memcmp(p->at[i] + 3 * (size_t)a, p->at[i] + 3 * (size_t)b, 3 * sizeof(double)) != 0)
            return 0;
    return 1;
}

/* FNV-1a over the bits of a vertex's places; -0 was made 0. */
static uint64_t hash(const poses *p, int vertex)
{
    uint64_t h = UINT64_C(14695981039346656037);
    for (int i = 0; i < p->count; i++)
        for (int j = 0; j < 3; j++) {
            uint64_t bits;
            memcpy(&bits, p->at[i] + 3 * (size_t)vertex + j, sizeof bits);
            h = (h ^ bits) * UINT64_C(1099511628211);
            h ^= h >> 29;
        }
    return h;
}

/* The first vertex that coincides with each. */
static int *find_first(const poses *p)
{
    size_t slots = 16;
    while (slots < 2 * (size_t)p->vertices)
        slots *= 2;
    int *table = bake_alloc(slots, sizeof *table); /* vertex + 1 */
    int *first = bake_alloc((size_t)p->vertices, sizeof *first);
    for (int i = 0; i < p->vertices; i++) {
        size_t slot = (size_t)hash(p, i) & (slots - 1);
        while (table[slot] != 0 && !same_vertex(p, table[slot] - 1, i))
            slot = (slot + 1) & (slots - 1);
        if (table[slot] == 0)
            table[slot] = i + 1;
        first[i] = table[slot] - 1;
    }
    free(table);
    return first;
}

/* Keeps the triangles with three different corners. */
static void keep_triangles(mesh *m, const int *first)
{
    int kept = 0;
    for (int i = 0; i < m->triangle_count; i++) {
        int a = first[m->triangle[i][0]], b = first[m->triangle[i][1]],
            c = first[m->triangle[i][2]];
        if (a == b || b == c || c == a)
            continue;
        m->triangle[kept][0] = a;
        m->triangle[kept][1] = b;
        m->triangle[kept][2] = c;
        m->part[kept++] = m->part[i];
    }
    m->triangle_count = kept;
}

/* Numbers what the triangles use, in the file's order; returns how many. The rest become -1. */
static int number(const mesh *m, int *to)
{
    int count = 0;
    for (int i = 0; i < m->vertex_count; i++)
        to[i] = -1;
    for (int i = 0; i < 3 * m->triangle_count; i++)
        to[m->triangle[i / 3][i % 3]] = 0;
    for (int i = 0; i < m->vertex_count; i++)
        to[i] = to[i] == 0 ? count++ : -1;
    return count;
}

/* Moves the kept vertices of poses that lie behind each other together: none moves to a later
 * place. */
static void pack_poses(const mesh *m, const int *to, int kept, double *at, int count)
{
    for (int i = 0; i < count; i++) {
        double *into = at + 3 * (size_t)i * (size_t)kept;
        const double *from = at + 3 * (size_t)i * (size_t)m->vertex_count;
        for (int v = 0; v < m->vertex_count; v++)
            if (to[v] >= 0)
                memmove(into + 3 * (size_t)to[v], from + 3 * (size_t)v, 3 * sizeof(double));
    }
}

static void pack(mesh *m, const int *to, int kept)
{
    for (int i = 0; i < 3 * m->triangle_count; i++)
        m->triangle[i / 3][i % 3] = to[m->triangle[i / 3][i % 3]];
    pack_poses(m, to, kept, m->rest, 1);
    for (int i = 0; i < m->frames_count; i++)
        pack_poses(m, to, kept, m->frames[i].at, m->frames[i].count);
    pack_poses(m, to, kept, m->shape, m->shape_count);
    m->vertex_count = kept;
}

/* Parts that have lost all their triangles go. */
static void keep_parts(mesh *m)
{
    int *to = bake_alloc((size_t)m->part_count, sizeof *to), kept = 0;
    for (int i = 0; i < m->triangle_count; i++)
        to[m->part[i]] = 1;
    for (int i = 0; i < m->part_count; i++) {
        if (to[i] == 0) {
            free(m->parts[i].name);
            continue;
        }
        to[i] = kept;
        m->parts[kept++] = m->parts[i];
    }
    for (int i = 0; i < m->triangle_count; i++)
        m->part[i] = to[m->part[i]];
    m->part_count = kept;
    free(to);
}

int mesh_weld(const mesh_reader *r, mesh *m)
{
    poses p = list_poses(m);
    int *first = find_first(&p);
    keep_triangles(m, first);
    int count = number(m, first); /* its old contents are used up */
    pack(m, first, count);
    keep_parts(m);
    free(first);
    free(p.at);
    if (m->triangle_count == 0)
        return mesh_fail(r, r->rest.path, "has no triangle with three different corners");
    if (m->vertex_count > MESH_VERTICES_MAX || m->triangle_count > MESH_VERTICES_MAX)
        return mesh_fail(
            r, r->rest.path,
            "has %d vertices and %d triangles; a shape holds %d of each: reduce it, or "
            "split it into several meshes",
            m->vertex_count, m->triangle_count, MESH_VERTICES_MAX);
    return 0;
}
