/* From a mesh and its rig to a domain with handles.
 * Source: Jacobson 2013, 4.3.4, 4.5.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "skin_parts.h"

#include "mesh_picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int skin_inside(const scene_region *r, const double x[3])
{
    double square = 0;
    int in = 1;
    for (int k = 0; k < 3; k++) {
        in = in && x[k] >= r->box[0][k] && x[k] <= r->box[1][k];
        square += (x[k] - r->centre[k]) * (x[k] - r->centre[k]);
    }
    return r->kind == REGION_BOX ? in : square <= r->radius * r->radius;
}

/* ---- handles ---------------------------------------------------------------------------------- */

/* Vertices of `at` (`of[0]` of `of[1]` coordinates each) in a bone's region. A flat mesh's numbers are
 * not those of its outline's points: see hold_flat_regions. */
static int region_vertices(const scene_bone *b, const double *at, int of[2], handle *out,
                           int **list)
{
    const scene_region *r = b->region;
    *list = bake_alloc((size_t)of[0] + (size_t)r->vertex_count + 1, sizeof **list);
    for (int i = 0; i < of[0] && r->kind != REGION_VERTICES; i++) {
        double x[3] = {0};
        memcpy(x, at + (size_t)of[1] * (size_t)i, (size_t)of[1] * sizeof *x);
        if (skin_inside(r, x)) {
            (*list)[out->vertex_count++] = i;
        }
    }
    for (int i = 0; i < r->vertex_count && of[1] == 3; i++) {
        if (r->vertex[i] < of[0]) {
            (*list)[out->vertex_count++] = r->vertex[i];
        }
    }
    out->vertex = *list;
    return out->vertex_count;
}

static handle_kind kind_of(const scene_bone *b)
{
    static const handle_kind KIND[] = {[BONE_BONE] = HANDLE_BONE,
                                       [BONE_POINT] = HANDLE_POINT,
                                       [BONE_REGION] = HANDLE_REGION,
                                       [BONE_CAGE] = HANDLE_CAGE};
    return KIND[b->kind];
}

static void add_facets(skin_work *w, const int *of_bone)
{
    int count = w->rig->facet_count;
    w->facet = bake_alloc((size_t)count + 1, sizeof *w->facet);
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            int bone = w->rig->facets[i][k];
            w->facet[i][k] = bone < 0 ? -1 : of_bone[bone];
        }
    }
    w->h.facet_count = count;
    w->h.facet = (const int(*)[3])w->facet;
}

static int fail_region(const skin_work *w, const scene_bone *b, bake_error *error)
{
    return skin_fail(w, b->line, error,
                     "the region of '%s' holds no vertex of mesh %s: make it larger, or move it",
                     b->name, w->origin.name);
}

/* Until the domain is there, the outline's nearest point says which part of it the region holds. */
static int take_nearest(const scene_bone *b, const double *at, int count, handle *h, int *list)
{
    double least = HUGE_VAL;
    for (int i = 0; i < count; i++) {
        double far = hypot(at[2 * i] - b->from[0], at[2 * i + 1] - b->from[1]);
        if (far < least) {
            least = far;
            list[0] = i;
        }
    }
    h->vertex_count = 1;
    return 0;
}

/* at: what regions are looked for in: `of[0]` points of `of[1]` coordinates. */
static int add_handles(skin_work *w, const double *at, int of[2], bake_error *error)
{
    int count = w->rig->bone_count;
    int *of_bone = bake_alloc((size_t)count + 1, sizeof *of_bone);
    w->handle = bake_alloc((size_t)count + 1, sizeof *w->handle);
    w->bone = bake_alloc((size_t)count + 1, sizeof *w->bone);
    w->vertices = bake_alloc((size_t)count + 1, sizeof *w->vertices);
    w->h.handle = w->handle;
    int err = 0;
    for (int i = 0; i < count && err == 0; i++) {
        const scene_bone *b = &w->rig->bones[i];
        of_bone[i] = w->h.count;
        if (b->weightless) {
            continue;
        }
        handle *h = &w->handle[w->h.count];
        *h = (handle){.name = b->name, .line = b->line, .kind = kind_of(b)};
        memcpy(h->from, b->from, sizeof h->from);
        memcpy(h->to, b->kind == BONE_BONE ? b->to : b->from, sizeof h->to);
        w->bone[w->h.count] = i;
        w->h.count++;
        int *list = NULL;
        if (b->kind == BONE_REGION && region_vertices(b, at, of, h, &list) == 0) {
            err = of[1] == 2 ? take_nearest(b, at, of[0], h, list) : fail_region(w, b, error);
        }
        w->vertices[w->h.count - 1] = list;
    }
    add_facets(w, of_bone);
    free(of_bone);
    return err == 0 && w->h.count == 0
               ? skin_fail(w, w->rig->line, error, "every bone is `weightless`: nothing to follow")
               : err;
}

/* ---- flat meshes ------------------------------------------------------------------------------ */

/* All of it lies in z = 0. */
static int is_flat(const mesh *m)
{
    double far = 0, deep = 0;
    for (int i = 0; i < 3 * m->vertex_count; i++) {
        *(i % 3 == 2 ? &deep : &far) = fmax(i % 3 == 2 ? deep : far, fabs(m->rest[i]));
    }
    return deep <= 1e-9 * far;
}

typedef struct {
    int from, to;
} border_edge;

static int by_from(const void *a, const void *b)
{
    return ((const border_edge *)a)->from - ((const border_edge *)b)->from;
}

/* Edges that one triangle has, from corner to corner as it goes round. */
static int border_edges(const mesh *m, border_edge *out)
{
    int count = 0, room = 3 * m->triangle_count;
    border_edge *all = bake_alloc((size_t)room + 1, sizeof *all);
    for (int i = 0; i < room; i++) {
        all[i] = (border_edge){m->triangle[i / 3][i % 3], m->triangle[i / 3][(i + 1) % 3]};
    }
    qsort(all, (size_t)room, sizeof *all, by_from);
    int *first = bake_alloc((size_t)m->vertex_count + 1, sizeof *first);
    for (int i = 0; i < room; i++) {
        first[all[i].from + 1] = i + 1;
    }
    for (int i = 0; i < m->vertex_count; i++) {
        first[i + 1] = first[i + 1] > first[i] ? first[i + 1] : first[i];
    }
    for (int i = 0; i < room; i++) {
        int twin = 0;
        for (int j = first[all[i].to]; j < first[all[i].to + 1]; j++) {
            twin |= all[j].to == all[i].from;
        }
        if (!twin) {
            out[count++] = all[i];
        }
    }
    free(first);
    free(all);
    return count;
}

/* The border of a flat mesh as loops. -1: it is none, because two of them touch in a vertex. */
static int trace(const mesh *m, outline *out)
{
    border_edge *edge = bake_alloc((size_t)(3 * m->triangle_count) + 1, sizeof *edge);
    int count = border_edges(m, edge), *next = bake_alloc((size_t)m->vertex_count, sizeof *next);
    int *loop = bake_alloc((size_t)count + 2, sizeof *loop), good = 1;
    double *at = bake_alloc(2 * (size_t)count + 2, sizeof *at);
    for (int i = 0; i < count; i++) {
        good = good && next[edge[i].from] == 0;
        next[edge[i].from] = edge[i].to + 1;
    }
    for (int i = 0; i < count && good; i++) {
        int v = edge[i].from;
        if (next[v] == 0) {
            continue;
        }
        while (next[v] != 0) { /* each vertex once */
            int to = next[v] - 1;
            at[2 * out->point_count] = m->rest[3 * v];
            at[2 * out->point_count++ + 1] = m->rest[3 * v + 1];
            next[v] = 0;
            v = to;
        }
        loop[++out->loop_count] = out->point_count;
    }
    out->loop = loop;
    out->at = at;
    free(edge);
    free(next);
    return good ? 0 : -1;
}

static int flat(skin_work *w, bake_error *error)
{
    outline own = {0};
    const mesh *m = &w->m->mesh;
    const outline *o = m->flat;
    int err = 0;
    if (o == NULL) {
        err = trace(m, &own);
        o = &own;
    }
    if (err < 0) {
        err =
            skin_fail(w, w->rig->line, error,
                      "the border of mesh %s touches itself in a vertex: part the two, or leave a "
                      "gap",
                      w->origin.name);
    }
    int of[2] = {o->point_count, 2};
    if (err == 0) {
        err = add_handles(w, o->at, of, error);
    }
    if (err == 0) {
        err = domain_flat(o, &w->h, &w->how, &w->d, error);
    }
    free((void *)(uintptr_t)own.loop);
    free((void *)(uintptr_t)own.at);
    return err;
}

/* The vertices of a flat domain in a region; of a mesh's vertices in a list, and where the region is
 * smaller than the domain's cells, those that carry them. */
static void mark_region(const skin_work *w, const scene_region *r, char *in)
{
    const mesh *m = &w->m->mesh;
    int found = 0, listed = 0;
    for (int i = 0; i < w->d.vertex_count && r->kind != REGION_VERTICES; i++) {
        in[i] = (char)skin_inside(r, w->d.at + 3 * i);
        found |= in[i];
    }
    for (int i = 0; i < m->vertex_count && !found; i++) {
        while (listed < r->vertex_count && r->vertex[listed] < i) { /* ascending */
            listed++;
        }
        int has = r->kind == REGION_VERTICES ? listed < r->vertex_count && r->vertex[listed] == i
                                             : skin_inside(r, m->rest + 3 * i);
        for (int k = 0; k < 3 && has; k++) {
            in[w->at[i].vertex[k]] |= w->at[i].weight[k] > 1e-9;
        }
    }
}

/* All of a flat shape that is in a region follows it, not the outline alone. */
static int hold_flat_regions(skin_work *w, bake_error *error)
{
    int n = w->d.vertex_count, err = 0;
    char *in = bake_alloc((size_t)n + 1, 1);
    for (int j = 0; j < w->h.count && err == 0; j++) {
        const scene_bone *b = &w->rig->bones[w->bone[j]];
        handle *h = &w->handle[j];
        if (b->kind != BONE_REGION) {
            continue;
        }
        memset(in, 0, (size_t)n);
        mark_region(w, b->region, in);
        w->vertices[j] = bake_grow(w->vertices[j], (size_t)n + 1, sizeof *w->vertices[j]);
        h->vertex = w->vertices[j];
        h->vertex_count = 0;
        for (int i = 0; i < n; i++) {
            w->vertices[j][h->vertex_count] = i;
            h->vertex_count += in[i];
        }
        err = h->vertex_count > 0 ? 0 : fail_region(w, b, error);
    }
    free(w->d.vertex_of); /* regions name the domain's vertices now */
    w->d.vertex_of = NULL;
    free(in);
    return err;
}

/* An image's colours keep parts of other colours apart [4.8]: f times the colour, in sizes. */
static void lift(skin_work *w)
{
    const mesh_picture *p = w->m->mesh.picture;
    double size = 0;
    if (p == NULL || w->rig->lift <= 0) {
        return;
    }
    for (int i = 0; i < 3 * w->d.vertex_count; i++) {
        size = fmax(size, 2 * fabs(w->d.at[i]));
    }
    w->d.lift = bake_alloc(3 * (size_t)w->d.vertex_count, sizeof *w->d.lift);
    for (int i = 0; i < w->d.vertex_count; i++) {
        double u = p->corner[0] + p->step * w->d.at[3 * i];
        double v = p->corner[1] - p->step * w->d.at[3 * i + 1];
        int x = (int)fmax(0, fmin(p->width - 1, floor(u)));
        int y = (int)fmax(0, fmin(p->height - 1, floor(v)));
        for (int k = 0; k < 3; k++) {
            w->d.lift[3 * i + k] =
                w->rig->lift * size * p->palette[3 * p->texel[y * p->width + x] + k] / 255;
        }
    }
}

/* ---- the domain ------------------------------------------------------------------------------- */

static int solid(skin_work *w, bake_error *error)
{
    const mesh *m = &w->m->mesh;
    const surface s = {m->vertex_count, m->triangle_count, m->rest, (const int(*)[3])m->triangle};
    int of[2] = {m->vertex_count, 3};
    return add_handles(w, m->rest, of, error) < 0 ? -1
                                                  : domain_solid(&s, &w->h, &w->how, &w->d, error);
}

int skin_domain(skin_work *w, bake_error *error)
{
    const mesh *m = &w->m->mesh;
    w->origin = (surface_origin){
        .scene = w->s->path, .name = w->s->meshes[w->m->index].name, .line = w->rig->line};
    w->how = (domain_options){.cell = w->rig->cell, .origin = &w->origin, .wrap = w->rig->wrap};
    int flat_mesh = is_flat(m), err = flat_mesh ? flat(w, error) : solid(w, error);
    w->at = bake_alloc((size_t)m->vertex_count, sizeof *w->at);
    if (err == 0) {
        err = domain_embed(&w->d, m->rest, m->vertex_count, w->at, &w->out->far, error);
    }
    if (err == 0 && flat_mesh) {
        err = hold_flat_regions(w, error);
    }
    if (err == 0) {
        lift(w);
        err = domain_hold(&w->d, &w->h, &w->how, &w->held, error);
    }
    return err;
}
