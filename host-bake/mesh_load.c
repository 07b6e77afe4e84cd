/* Loads a mesh with all that the scene asks for: rest pose, triangles, frames, shapes; then welds.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <stdlib.h>
#include <string.h>

static int add_motion(mesh_reader *r, int clip, int motion, mesh *out)
{
    const scene_motion *from = &r->s->clips[clip].motions[motion];
    out->frames = bake_grow(out->frames, (size_t)out->frames_count + 1, sizeof *out->frames);
    mesh_frames *frames = &out->frames[out->frames_count++];
    *frames = (mesh_frames){.clip = clip, .motion = motion};
    r->line = from->line;
    return mesh_read_motion(r, from, frames);
}

static int add_motions(mesh_reader *r, int index, mesh *out)
{
    const scene *s = r->s;
    for (int i = 0; i < s->clip_count; i++)
        for (int j = 0; j < s->clips[i].motion_count; j++)
            if (s->clips[i].motions[j].mesh == index && add_motion(r, i, j, out))
                return -1;
    return 0;
}

static int add_shape(mesh_reader *r, const scene_shape *shape, double *at)
{
    r->line = shape->line;
    if (shape->target != NULL)
        return mesh_read_target(r, shape->target, at);
    mesh_file f;
    if (mesh_file_open(r, shape->file, 0, &f))
        return -1;
    int err = mesh_file_same(r, &f);
    if (err == 0) {
        mesh_file_pose(&f, at);
        err = mesh_check_pose(r, shape->file, -1, at);
    }
    mesh_file_close(&f);
    return err;
}

static int add_shapes(mesh_reader *r, mesh *out)
{
    size_t values = 3 * (size_t)r->rest.id_count;
    out->shape_count = r->mesh->shape_count;
    out->shape = bake_alloc((size_t)out->shape_count * values, sizeof(double));
    for (int i = 0; i < out->shape_count; i++)
        if (add_shape(r, &r->mesh->shapes[i], out->shape + (size_t)i * values))
            return -1;
    return 0;
}

/* The file with the mesh's connectivity and rest pose; of a series, the first. */
static char *rest_path(const mesh_reader *r)
{
    mesh_series series;
    const char *path = r->mesh->file;
    if (strchr(path, '#') == NULL)
        return bake_copy(path);
    return mesh_series_find(r, path, &series) ? NULL : mesh_series_path(path, &series, 0);
}

static int read_all(mesh_reader *r, int index, mesh *out)
{
    out->vertex_count = r->rest.id_count;
    out->rest = bake_alloc((size_t)r->rest.id_count, 3 * sizeof(double));
    mesh_morph_rest(&r->rest, out->rest);
    if (mesh_check_pose(r, r->rest.path, -1, out->rest) || add_motions(r, index, out) ||
        add_shapes(r, out))
        return -1;
    r->line = r->mesh->line;
    return mesh_triangles(r, out) || mesh_weld(r, out) ? -1 : 0;
}

int mesh_load(const scene *s, int index, mesh *out, bake_error *error)
{
    mesh_reader r = {
        .s = s, .mesh = &s->meshes[index], .error = error, .line = s->meshes[index].line};
    *out = (mesh){0};
    char *path = rest_path(&r);
    if (path == NULL)
        return -1;
    int err = mesh_file_open(&r, path, 0, &r.rest);
    if (err == 0)
        err = read_all(&r, index, out);
    mesh_file_close(&r.rest);
    free(path);
    if (err)
        mesh_free(out);
    return err;
}

void mesh_free(mesh *m)
{
    for (int i = 0; i < m->part_count; i++)
        free(m->parts[i].name);
    for (int i = 0; i < m->frames_count; i++)
        free(m->frames[i].at);
    free(m->parts);
    free(m->frames);
    free(m->triangle);
    free(m->part);
    free(m->rest);
    free(m->shape);
    *m = (mesh){0};
}
