/* Loads a mesh with all that the scene asks for: rest pose, triangles, frames, shapes; then welds.
 * All of that happens in a process of its own, because files may be damaged.
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

/* Each motion is within the limit when it is read. */
static int check_total(const mesh_reader *r, const mesh *m)
{
    double frames = 0;
    for (int i = 0; i < m->frames_count; i++)
        frames += m->frames[i].count;
    return frames * r->rest.id_count <= MESH_PLACES_MAX
               ? 0
               : mesh_fail(r, r->rest.path,
                           "is shown with %.0f frames of %d vertices in all clips; a bake holds "
                           "%.0f: name fewer with 'frames', or lower 'rate'",
                           frames, r->rest.id_count, MESH_PLACES_MAX / r->rest.id_count);
}

static int add_motions(mesh_reader *r, int index, mesh *out)
{
    const scene *s = r->s;
    for (int i = 0; i < s->clip_count; i++)
        for (int j = 0; j < s->clips[i].motion_count; j++)
            if (s->clips[i].motions[j].mesh == index &&
                (add_motion(r, i, j, out) || check_total(r, out)))
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
    if ((double)r->mesh->shape_count * r->rest.id_count > MESH_PLACES_MAX)
        return mesh_fail(r, r->rest.path, "has %d vertices, too many for %d shapes: reduce it",
                         r->rest.id_count, r->mesh->shape_count);
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

typedef struct {
    const scene *s;
    int index;
    mesh *out;
} loading;

static int load_file(mesh_reader *r, const loading *l)
{
    char *path = rest_path(r);
    if (path == NULL)
        return -1;
    int err = mesh_file_open(r, path, 0, &r->rest);
    if (err == 0)
        err = read_all(r, l->index, l->out);
    mesh_file_close(&r->rest);
    free(path);
    return err;
}

static int load_here(void *what, isolate_note *now, bake_error *error)
{
    const loading *l = what;
    const scene_mesh *from = &l->s->meshes[l->index];
    mesh_reader r = {.s = l->s, .mesh = from, .error = error, .line = from->line, .now = now};
    int err = mesh_is_flat(from->file) ? mesh_flat_load(&r, l->index, l->out) : load_file(&r, l);
    if (err)
        mesh_free(l->out);
    return err;
}

static void send(const void *what, FILE *to)
{
    mesh_send(((const loading *)what)->out, to);
}

static int take(void *what, FILE *from)
{
    const loading *l = what;
    return mesh_take(l->s, l->index, from, l->out);
}

int mesh_load(const scene *s, int index, mesh *out, bake_error *error)
{
    loading l = {s, index, out};
    const isolate_job job = {s->path, &l, load_here, send, take};
    *out = (mesh){0};
    int err = isolate(&job, error);
    if (err == 0 && out->specks > 0)
        fprintf(stderr,
                "%s:%d: mesh %s: warning: '%s' has %d spots or holes that are too small to show; "
                "they are left out\n",
                s->path, s->meshes[index].line, s->meshes[index].name, s->meshes[index].file,
                out->specks);
    return err;
}

void mesh_frames_free(mesh_frames *f)
{
    free(f->at);
    free(f->time);
    free(f->kink);
}

void mesh_free(mesh *m)
{
    for (int i = 0; i < m->part_count; i++)
        free(m->parts[i].name);
    for (int i = 0; i < m->frames_count; i++)
        mesh_frames_free(&m->frames[i]);
    free(m->parts);
    free(m->frames);
    free(m->triangle);
    free(m->part);
    free(m->rest);
    free(m->shape);
    mesh_flat_free(m);
    *m = (mesh){0};
}
