/* Frames of a mesh: numbered files and the vertex frames of MD2; others are elsewhere.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <stdlib.h>
#include <string.h>

static const double default_rate = 30;

int mesh_range(const mesh_reader *r, const char *path, int available, const scene_motion *motion,
               mesh_frames *out)
{
    int last = motion->last >= 0 ? motion->last : available - 1;
    if (last >= available || motion->first > last)
        return mesh_fail(r, path, "has %d frames, 0 to %d; 'frames' asks for %d to %d", available,
                         available - 1, motion->first, last);
    out->count = last - motion->first + 1;
    out->rate = motion->rate > 0 ? motion->rate : default_rate;
    if (out->count > MESH_FRAMES_MAX || (double)out->count * r->rest.id_count > MESH_PLACES_MAX)
        return mesh_fail(r, path,
                         "has %d frames of %d vertices, too many for one clip; name fewer with "
                         "'frames', or lower 'rate'",
                         out->count, r->rest.id_count);
    out->at = bake_alloc((size_t)out->count * (size_t)r->rest.id_count, 3 * sizeof(double));
    return 0;
}

/* One frame from a file of its own, or from one that holds many. */
static int read_frame(const mesh_reader *r, const char *path, int keyframe, int frame, double *at)
{
    mesh_file f;
    if (mesh_file_open(r, path, keyframe, &f))
        return -1;
    int err = mesh_file_same(r, &f);
    if (err == 0) {
        mesh_file_pose(&f, at);
        err = mesh_check_pose(r, path, frame, at);
    }
    mesh_file_close(&f);
    return err;
}

static int read_series(const mesh_reader *r, const char *path, const scene_motion *motion,
                       mesh_frames *out)
{
    mesh_series series;
    if (mesh_series_find(r, path, &series) || mesh_range(r, path, series.count, motion, out))
        return -1;
    for (int i = 0; i < out->count; i++) {
        char *file = mesh_series_path(path, &series, motion->first + i);
        int err = read_frame(r, file, 0, motion->first + i,
                             out->at + 3 * (size_t)i * (size_t)r->rest.id_count);
        free(file);
        if (err)
            return err;
    }
    return 0;
}

/* How many frames the header of an MD2 file promises, each of at least 40 bytes. */
static int count_frames(const mesh_reader *r, const char *path, int *count)
{
    size_t size;
    unsigned char *data = (unsigned char *)mesh_read_bytes(path, &size);
    int good = size >= 68 && memcmp(data, "IDP2", 4) == 0;
    unsigned frames = 0;
    for (int i = 0; i < 4 && good; i++)
        frames |= (unsigned)data[40 + i] << 8 * i;
    free(data);
    if (!good)
        return mesh_fail(r, path, "is no MD2 file");
    if (frames < 1 || frames > size / 40)
        return mesh_fail(r, path, "says that it has %u frames", frames);
    *count = (int)frames;
    return 0;
}

static int read_keyframes(const mesh_reader *r, const char *path, const scene_motion *motion,
                          mesh_frames *out)
{
    int count = 0;
    if (count_frames(r, path, &count) || mesh_range(r, path, count, motion, out))
        return -1;
    for (int i = 0; i < out->count; i++)
        if (read_frame(r, path, motion->first + i, motion->first + i,
                       out->at + 3 * (size_t)i * (size_t)r->rest.id_count))
            return -1;
    return 0;
}

static int read_morph(const mesh_reader *r, const char *path, const scene_motion *motion,
                      mesh_frames *out)
{
    mesh_file f;
    if (motion->file == NULL)
        return mesh_read_morph(r, &r->rest, motion, out);
    if (mesh_file_open(r, path, 0, &f))
        return -1;
    int err = mesh_file_same(r, &f) ? -1 : mesh_read_morph(r, &f, motion, out);
    mesh_file_close(&f);
    return err;
}

int mesh_read_motion(const mesh_reader *r, const scene_motion *motion, mesh_frames *out)
{
    const char *path = motion->file != NULL ? motion->file : r->mesh->file;
    if (strchr(path, '#') != NULL)
        return read_series(r, path, motion, out);
    if (mesh_ends(path, ".pc2") || mesh_ends(path, ".mdd"))
        return mesh_read_cache(r, path, motion, out);
    if (mesh_ends(path, ".md3"))
        return mesh_read_md3(r, path, motion, out);
    if (mesh_ends(path, ".md2"))
        return read_keyframes(r, path, motion, out);
    return read_morph(r, path, motion, out);
}
