/* Point caches over a mesh whose vertices have an order: PC2 and MDD.
 *
 *   PC2, little-endian: "POINTCACHE2\0", i32 version 1, i32 points, f32 first frame, f32 frames a
 *   sample, i32 samples; samples x points x f32 xyz.
 *   MDD, big-endian: i32 frames, i32 points; f32 time of each frame [s]; frames x points x f32 xyz.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { PC2_HEADER = 32, MDD_HEADER = 8, XYZ = 12 };

/* What PC2 counts in; the format does not say how long one is. */
static const double frames_a_second = 30;

/* As for a 'rate' in the scene. */
static const double rate_least = 1e-3;

typedef struct {
    const char *path;
    FILE *file;
    int big; /* endian */
    int64_t bytes;
    int32_t points, frames;
    int64_t header; /* bytes in front of the points */
    double rate;    /* 0: the file does not say */
} cache;

static uint32_t word(const cache *c, const unsigned char *at)
{
    return c->big ? (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3]
                  : (uint32_t)at[3] << 24 | (uint32_t)at[2] << 16 | (uint32_t)at[1] << 8 | at[0];
}

static int32_t whole(const cache *c, const unsigned char *at)
{
    uint32_t bits = word(c, at);
    int32_t value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double real(const cache *c, const unsigned char *at)
{
    uint32_t bits = word(c, at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

static int read_pc2(const mesh_reader *r, cache *c)
{
    unsigned char h[PC2_HEADER];
    if (fread(h, 1, sizeof h, c->file) != sizeof h)
        return mesh_fail(r, c->path, "is cut off: it ends in the header");
    if (memcmp(h, "POINTCACHE2", 12) != 0 || whole(c, h + 12) != 1)
        return mesh_fail(r, c->path, "is no PC2 file of version 1");
    c->points = whole(c, h + 16);
    c->frames = whole(c, h + 28);
    c->header = PC2_HEADER;
    double step = real(c, h + 24);
    c->rate = isfinite(step) && step > 0 ? frames_a_second / step : 0;
    return 0;
}

/* The rate of times that ascend evenly, 0 of others. */
static double even_rate(const cache *c, const unsigned char *times)
{
    double first = real(c, times), last = real(c, times + 4 * (size_t)(c->frames - 1));
    double step = c->frames > 1 ? (last - first) / (c->frames - 1) : 0;
    if (!(step > 0) || !isfinite(step))
        return 0;
    for (int i = 0; i < c->frames; i++) {
        double off = real(c, times + 4 * (size_t)i) - (first + step * i);
        if (!(fabs(off) < 0.01 * step)) /* floats of a few hundred seconds are off by 1e-5 */
            return 0;
    }
    return 1 / step;
}

static int read_mdd(const mesh_reader *r, cache *c, const scene_motion *motion)
{
    unsigned char h[MDD_HEADER];
    if (fread(h, 1, sizeof h, c->file) != sizeof h)
        return mesh_fail(r, c->path, "is cut off: it ends in the header");
    c->frames = whole(c, h);
    c->points = whole(c, h + 4);
    if (c->frames < 1 || 4 * (int64_t)c->frames > c->bytes)
        return mesh_fail(r, c->path, "says that it has %d frames; it has room for fewer",
                         c->frames);
    c->header = MDD_HEADER + 4 * (int64_t)c->frames;
    unsigned char *times = bake_alloc((size_t)c->frames, 4);
    size_t got = fread(times, 4, (size_t)c->frames, c->file);
    c->rate = got == (size_t)c->frames ? even_rate(c, times) : 0;
    free(times);
    if (c->rate > 0 || motion->rate > 0 || c->frames == 1)
        return 0;
    return mesh_fail(r, c->path, "has frames at uneven times; say with 'rate' how many a second");
}

static int check_size(const mesh_reader *r, const cache *c)
{
    if (c->frames < 1 || c->points < 1)
        return mesh_fail(r, c->path, "says that it has %d frames of %d points", c->frames,
                         c->points);
    if (c->points != r->rest.id_count)
        return mesh_fail(r, c->path, "has %d points, '%s' has %d vertices; they must be the same",
                         c->points, r->rest.path, r->rest.id_count);
    int64_t want = c->header + XYZ * (int64_t)c->points * c->frames;
    if (c->bytes != want)
        return mesh_fail(r, c->path, "has %lld bytes; %d frames of %d points take %lld%s",
                         (long long)c->bytes, c->frames, c->points, (long long)want,
                         c->bytes < want ? ": it is cut off" : "");
    return 0;
}

static int read_points(const mesh_reader *r, const cache *c, const scene_motion *motion,
                       mesh_frames *out)
{
    size_t points = (size_t)c->points;
    unsigned char *raw = bake_alloc(points, XYZ);
    int64_t start = c->header + XYZ * (int64_t)c->points * motion->first;
    int err = fseeko(c->file, (off_t)start, SEEK_SET);
    for (int i = 0; i < out->count && err == 0; i++) {
        double *at = out->at + 3 * points * (size_t)i;
        if (fread(raw, XYZ, points, c->file) != points)
            err = mesh_fail(r, c->path, "cannot be read to its end");
        for (size_t j = 0; j < points && err == 0; j++) {
            double point[3];
            for (size_t k = 0; k < 3; k++)
                point[k] = real(c, raw + XYZ * j + 4 * k);
            mesh_put(&r->rest.places[0], point, at + 3 * j);
        }
        if (err == 0)
            err = mesh_check_pose(r, c->path, motion->first + i, at);
    }
    free(raw);
    return err;
}

static int read_cache(const mesh_reader *r, cache *c, const scene_motion *motion, mesh_frames *out)
{
    if ((c->big ? read_mdd(r, c, motion) : read_pc2(r, c)) || check_size(r, c) ||
        mesh_range(r, c->path, c->frames, motion, out))
        return -1;
    if (motion->rate <= 0 && c->rate > 0)
        out->rate = c->rate;
    if (out->rate < rate_least || out->rate > SCENE_RATE_MAX)
        return mesh_fail(r, c->path, "has %g frames a second; say with 'rate' how many are meant",
                         out->rate);
    return read_points(r, c, motion, out);
}

int mesh_read_cache(const mesh_reader *r, const char *path, const scene_motion *motion,
                    mesh_frames *out)
{
    struct stat info;
    cache c = {.path = path, .big = mesh_ends(path, ".mdd")};
    if (!r->rest.ordered)
        return mesh_fail(r, path, "needs a mesh whose vertices have an order: OBJ, PLY or OFF");
    c.file = fopen(path, "rb");
    if (c.file == NULL || fstat(fileno(c.file), &info) != 0) {
        if (c.file != NULL)
            fclose(c.file);
        return mesh_fail(r, path, "cannot be read");
    }
    c.bytes = info.st_size;
    int err = read_cache(r, &c, motion, out);
    fclose(c.file);
    return err;
}
