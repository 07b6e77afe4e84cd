/* Vertex frames of MD3 files. Assimp 5.2.5 takes the number of a frame and delivers the first one
 * whichever it is, so the positions are read here and the rest comes from Assimp: it repeats the
 * vertices of each triangle in the file's order, and lists the surfaces backwards.
 *
 *   header: i32 frames at 76, surfaces at 84, offset of the first surface at 100
 *   surface: i32 vertices at 80, triangles at 84, offsets from its start: of the triangles at 88,
 *   of the positions at 100, of the next surface at 104; a triangle is i32[3], a position i16
 *   xyz / 64 and two bytes for a normal, vertices of frame after frame.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

enum { HEADER = 108, FRAME = 56, TRIANGLE = 12, POSITION = 8 };

typedef struct {
    const char *path;
    unsigned char *data;
    int64_t size;
    int64_t frames, surfaces, start;
} md3;

typedef struct {
    int64_t vertices, triangles, corners, positions, next; /* the last three: offsets in the file */
} surface;

static int64_t word(const md3 *f, int64_t at)
{
    const unsigned char *p = f->data + at;
    uint32_t bits =
        (uint32_t)p[3] << 24 | (uint32_t)p[2] << 16 | (uint32_t)p[1] << 8 | (uint32_t)p[0];
    return bits < UINT32_C(0x80000000) ? (int64_t)bits : (int64_t)bits - INT64_C(0x100000000);
}

static int inside(const md3 *f, int64_t at, int64_t bytes)
{
    return at >= 0 && bytes >= 0 && at <= f->size && bytes <= f->size - at;
}

static int read_surface(const md3 *f, int64_t at, surface *out)
{
    if (!inside(f, at, HEADER))
        return -1;
    out->vertices = word(f, at + 80);
    out->triangles = word(f, at + 84);
    out->corners = at + word(f, at + 88);
    out->positions = at + word(f, at + 100);
    out->next = at + word(f, at + 104);
    return out->vertices > 0 && out->triangles > 0 &&
                   inside(f, out->corners, TRIANGLE * out->triangles) &&
                   inside(f, out->positions, POSITION * f->frames * out->vertices)
               ? 0
               : -1;
}

static double coordinate(const md3 *f, int64_t at)
{
    int bits = f->data[at] | f->data[at + 1] << 8;
    return (bits < 0x8000 ? bits : bits - 0x10000) / 64.0;
}

static int put_surface(const mesh_reader *r, const md3 *f, const surface *s, int64_t frame,
                       double *at, const mesh_place *place)
{
    if ((int64_t)place->mesh->mNumVertices != 3 * s->triangles)
        return -1;
    for (int64_t i = 0; i < 3 * s->triangles; i++) {
        int64_t vertex = word(f, s->corners + 4 * i);
        if (vertex < 0 || vertex >= s->vertices)
            return -1;
        int64_t from = s->positions + POSITION * (frame * s->vertices + vertex);
        double point[3] = {coordinate(f, from), coordinate(f, from + 2), coordinate(f, from + 4)};
        mesh_put(place, point, at + 3 * (size_t)r->rest.id[place->first + (int)i]);
    }
    return 0;
}

static int put_frame(const mesh_reader *r, const md3 *f, int64_t frame, double *at)
{
    int64_t where = f->start;
    if (f->surfaces != r->rest.place_count)
        return -1;
    for (int i = r->rest.place_count - 1; i >= 0; i--) {
        surface s;
        if (read_surface(f, where, &s) || put_surface(r, f, &s, frame, at, &r->rest.places[i]))
            return -1;
        where = s.next;
    }
    return 0;
}

/* The first frame is what Assimp has read, or the corners were mixed up. */
static int check_first(const mesh_reader *r, const md3 *f)
{
    size_t values = 3 * (size_t)r->rest.id_count;
    double *mine = bake_alloc(values, sizeof *mine), *theirs = bake_alloc(values, sizeof *theirs);
    int err = put_frame(r, f, 0, mine);
    mesh_file_pose(&r->rest, theirs);
    for (size_t i = 0; i < values && err == 0; i++)
        err = fabs(mine[i] - theirs[i]) > 0 ? -1 : 0;
    free(mine);
    free(theirs);
    return err ? mesh_fail(r, f->path, "has surfaces that are damaged, or others than '%s'",
                           r->rest.path)
               : 0;
}

static int read_frames(const mesh_reader *r, md3 *f, const scene_motion *motion, mesh_frames *out)
{
    if (f->size < HEADER || word(f, 0) != INT64_C(0x33504449)) /* "IDP3" */
        return mesh_fail(r, f->path, "is no MD3 file");
    f->frames = word(f, 76);
    f->surfaces = word(f, 84);
    f->start = word(f, 100);
    if (f->frames < 1 || f->frames > f->size / FRAME)
        return mesh_fail(r, f->path, "says that it has %lld frames", (long long)f->frames);
    if (check_first(r, f) || mesh_range(r, f->path, (int)f->frames, motion, out))
        return -1;
    for (int i = 0; i < out->count; i++) {
        double *at = out->at + 3 * (size_t)i * (size_t)r->rest.id_count;
        if (put_frame(r, f, motion->first + i, at))
            return mesh_fail(r, f->path, "is damaged in frame %d", motion->first + i);
        if (mesh_check_pose(r, f->path, motion->first + i, at))
            return -1;
    }
    return 0;
}

int mesh_read_md3(const mesh_reader *r, const char *path, const scene_motion *motion,
                  mesh_frames *out)
{
    size_t size;
    md3 f = {.path = path, .data = (unsigned char *)mesh_read_bytes(path, &size)};
    f.size = (int64_t)size;
    int err = read_frames(r, &f, motion, out);
    free(f.data);
    return err;
}
