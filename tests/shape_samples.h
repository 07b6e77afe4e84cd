/* A sample clip with shapes, parts and views.
 * SPDX-License-Identifier: MIT */
#ifndef SHAPE_SAMPLES_H
#define SHAPE_SAMPLES_H

#include "clip_samples.h"

#define SAMPLE_SHAPE_CHANNELS 20u

/* Two shapes of 5 vertices, the second as normals of the first and with the blocks of odd sizes; a
 * third of one vertex. All kinds of blocks, two parts, two views. */
static inline void sample_shapes(build *b)
{
    static const int16_t X[15] = {1, -2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 100};
    static const uint16_t CORNERS[6] = {0, 1, 2, 4, 3, 0}, DOT[3] = {0, 0, 0};
    static const uint16_t LOOK[8] = {0, 1, 2, 3, 4, 5, 6, 19};
    const build_shape_data first = {5, 4, 8, {1 << 28, -(1 << 28), 0}, X};
    const build_shape_data second = {5, 14, WG_ABSENT, {0, 0, 0}, X};
    const build_shape_data third = {1, -8, WG_ABSENT, {0, 0, 0}, X};
    const build_block_data blocks[] = {{0, 1, 1, 4, 16, X, X},
                                       {2, WG_ABSENT, 0, 5, 16, X, NULL},
                                       {0, 2, 2, 3, 8, X, X},
                                       {1, WG_ABSENT, 4, 1, 8, X, NULL}};
    const build_part_data part = {0, 1, 2, 1, {1, 2, 3}, CORNERS};
    const build_part_data dot = {2, WG_ABSENT, 1, 0, {4, 5, 6}, DOT};
    for (unsigned i = 0; i < SAMPLE_SHAPE_CHANNELS; i++) {
        build_channel(b, (int)i, WG_UNIT_NONE, 1 << 20);
    }
    build_clip(b, 60, 60, WG_END_HOLD);
    sample_ramp(b, 0, 60, 5000);
    for (unsigned s = 0; s < 2; s++) {
        build_shape(b, s == 0 ? &first : &second);
        for (uint16_t j = 0; j < 3; j++) {
            build_basis(b, (uint16_t)(j + s), 20000, (uint8_t)(1u + 7u * j));
        }
        for (unsigned k = 0; k < 4; k++) {
            build_block(b, &blocks[k]);
        }
    }
    build_shape(b, &third);
    build_part(b, &dot);
    build_view(b, WG_PERSPECTIVE, WG_SHADING_SMOOTH, LOOK);
    build_view(b, WG_ORTHOGRAPHIC, WG_SHADING_WIRE, LOOK);
    build_part(b, &part); /* its corners are the last bytes of DATA */
}

static inline uint8_t *sample_shapes_file(uint32_t *size)
{
    build b = {{{0}}, 1};
    sample_shapes(&b);
    return build_finish(&b, size);
}

#endif
