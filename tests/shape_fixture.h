/* Clips for the tests of shapes: bases' channels first, then those of an affine part.
 * SPDX-License-Identifier: MIT */
#ifndef SHAPE_FIXTURE_H
#define SHAPE_FIXTURE_H

#include <math.h>
#include <stdlib.h>

#include "check.h"
#include "shape_model.h"
#include "wiggly.h"

#define AFFINE    MODEL_BASES /* the first affine channel of the clips here */
#define CHANNELS  (MODEL_BASES + WG_AFFINE_CHANNELS)
#define ENTRY     18 /* frac of the entries' channels */
#define WAY       10 /* frac of the translation's channels */
#define FRAC      7  /* of the shapes */
#define ONE_ENTRY (1 << ENTRY)

/* A clip with one or more shapes, opened, with channel values. */
typedef struct {
    uint8_t *clip;
    wg_file file;
    int32_t values[CHANNELS];
    int16_t weights[WG_BASES_MAX];
} fixture;

static inline void begin(build *b)
{
    for (unsigned i = 0; i < CHANNELS; i++) {
        build_channel(b, i < AFFINE ? 0 : i < AFFINE + 9u ? ENTRY : WAY, WG_UNIT_NONE, 0);
    }
    build_clip(b, 60, 60, WG_END_HOLD);
}

static inline void open_fixture(fixture *f, build *b)
{
    uint32_t size;
    f->clip = build_finish(b, &size);
    CHECK_EQ(wg_open(&f->file, f->clip, size), 0);
    CHECK_EQ(wg_open_shapes(&f->file), 0);
    for (unsigned i = 0; i < CHANNELS; i++) {
        f->values[i] = i >= AFFINE && i < AFFINE + 9u && (i - AFFINE) % 4u == 0 ? ONE_ENTRY : 0;
    }
}

/* Exactly 3 count values on the heap: a write outside is caught. */
static inline int32_t *posed(const wg_pose *pose, unsigned first, unsigned count)
{
    int32_t *xyz = malloc(3u * count * sizeof *xyz + (count == 0));
    wg_pose_vertices(pose, (uint16_t)first, (uint16_t)count, xyz);
    return xyz;
}

/* ---- three vertices, no bases ----------------------------------------------- */

static const int16_t POINTS[] = {4000, -3000, 2000, -32768, 32767, -32768, 1, 0, -1};
#define POINT_COUNT 3u

static inline void open_points(fixture *f, uint16_t affine, const int32_t *origin)
{
    build_shape_data shape = {POINT_COUNT, FRAC, affine, {0, 0, 0}, POINTS};
    build b = {{{0}}, 1};
    memcpy(shape.origin, origin, sizeof shape.origin);
    begin(&b);
    build_shape(&b, &shape);
    shape.affine = WG_ABSENT; /* the same points once more: as normals */
    build_shape(&b, &shape);
    open_fixture(f, &b);
}

static inline void set_entries(fixture *f, const double *entry)
{
    for (unsigned i = 0; i < 9; i++) {
        f->values[AFFINE + i] = (int32_t)lrint(ldexp(entry[i], ENTRY));
    }
}

#endif
