/* A mesh on its way from the process that has read it to the baker.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include "isolate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COUNTS = 5, NAME_MAX_BYTES = 4096 };

static size_t values(const mesh *m, int poses)
{
    return 3 * (size_t)m->vertex_count * (size_t)poses;
}

void mesh_send(const mesh *m, FILE *to)
{
    const int count[COUNTS] = {m->vertex_count, m->triangle_count, m->part_count, m->frames_count,
                               m->shape_count};
    fwrite(count, sizeof *count, COUNTS, to);
    fwrite(m->rest, sizeof *m->rest, values(m, 1), to);
    fwrite(m->triangle, sizeof *m->triangle, (size_t)m->triangle_count, to);
    fwrite(m->part, sizeof *m->part, (size_t)m->triangle_count, to);
    fwrite(m->shape, sizeof *m->shape, values(m, m->shape_count), to);
    for (int i = 0; i < m->part_count; i++) {
        int length = (int)strlen(m->parts[i].name);
        fwrite(&m->parts[i], sizeof m->parts[i], 1, to);
        fwrite(&length, sizeof length, 1, to);
        fwrite(m->parts[i].name, 1, (size_t)length, to);
    }
    for (int i = 0; i < m->frames_count; i++) {
        fwrite(&m->frames[i], sizeof m->frames[i], 1, to);
        fwrite(m->frames[i].at, sizeof *m->frames[i].at, values(m, m->frames[i].count), to);
    }
    mesh_flat_send(m, to);
}

static double *take_values(const mesh *m, int poses, FILE *from)
{
    double *at = isolate_get(from, values(m, poses), sizeof *at);
    for (size_t i = 0; at != NULL && i < values(m, poses); i++)
        if (!isfinite(at[i])) {
            free(at);
            return NULL;
        }
    return at;
}

/* out->part_count is what has been taken, so that mesh_free is right at any time. */
static int take_parts(mesh *out, int count, FILE *from)
{
    out->parts = bake_alloc((size_t)count, sizeof *out->parts);
    while (out->part_count < count) {
        mesh_part *part = &out->parts[out->part_count];
        int length;
        if (fread(part, sizeof *part, 1, from) != 1 ||
            fread(&length, sizeof length, 1, from) != 1 || length < 0 || length > NAME_MAX_BYTES)
            return -1;
        part->name = bake_alloc((size_t)length + 1, 1);
        part->sides = part->sides != 0;
        out->part_count++;
        if (fread(part->name, 1, (size_t)length, from) != (size_t)length)
            return -1;
    }
    return 0;
}

/* A motion of the scene that shows this mesh, of no more frames than are read. */
static int is_motion(const scene *s, int index, const mesh *m, const mesh_frames *f)
{
    return f->clip >= 0 && f->clip < s->clip_count && f->motion >= 0 &&
           f->motion < s->clips[f->clip].motion_count &&
           s->clips[f->clip].motions[f->motion].mesh == index && f->count >= 1 &&
           f->count <= MESH_FRAMES_MAX && (double)f->count * m->vertex_count <= MESH_PLACES_MAX &&
           f->rate > 0 && isfinite(f->rate);
}

static int take_frames(const scene *s, int index, mesh *out, int count, FILE *from)
{
    out->frames = bake_alloc((size_t)count, sizeof *out->frames);
    while (out->frames_count < count) {
        mesh_frames *frames = &out->frames[out->frames_count];
        if (fread(frames, sizeof *frames, 1, from) != 1 || !is_motion(s, index, out, frames))
            return -1;
        frames->at = take_values(out, frames->count, from);
        if (frames->at == NULL)
            return -1;
        out->frames_count++;
    }
    return 0;
}

static int good_triangles(const mesh *m)
{
    for (int i = 0; i < m->triangle_count; i++) {
        const int *corner = m->triangle[i];
        for (int k = 0; k < 3; k++)
            if (corner[k] < 0 || corner[k] >= m->vertex_count)
                return 0;
        if (m->part[i] < 0 || m->part[i] >= m->part_count)
            return 0;
    }
    return 1;
}

static int good_counts(const int count[COUNTS], const scene *s, int index)
{
    return count[0] >= 1 && count[0] <= MESH_VERTICES_MAX && count[1] >= 1 &&
           count[1] <= MESH_VERTICES_MAX && count[2] >= 1 && count[2] <= (int)WG_PARTS_MAX &&
           count[3] >= 0 && count[3] <= s->clip_count && count[4] == s->meshes[index].shape_count;
}

int mesh_take(const scene *s, int index, FILE *from, mesh *out)
{
    int count[COUNTS];
    *out = (mesh){0};
    if (fread(count, sizeof *count, COUNTS, from) != COUNTS || !good_counts(count, s, index))
        return -1;
    out->vertex_count = count[0];
    out->triangle_count = count[1];
    out->shape_count = count[4];
    out->rest = take_values(out, 1, from);
    out->triangle = isolate_get(from, (size_t)count[1], sizeof *out->triangle);
    out->part = isolate_get(from, (size_t)count[1], sizeof *out->part);
    out->shape = take_values(out, count[4], from);
    if (out->rest && out->triangle && out->part && out->shape &&
        take_parts(out, count[2], from) == 0 && good_triangles(out) &&
        take_frames(s, index, out, count[3], from) == 0 && mesh_flat_take(out, from) == 0)
        return 0;
    mesh_free(out);
    return -1;
}
