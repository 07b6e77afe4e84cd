/* A clip with every kind of joint, skin and paint, for tests that change it.
 * SPDX-License-Identifier: MIT */
#ifndef SKIN_SAMPLES_H
#define SKIN_SAMPLES_H

#include "clip_build_skin.h"

#define SAMPLE_SKIN_CHANNELS 9u
#define SAMPLE_SKIN_BONES    4u /* of the skin that has most */
#define SAMPLE_SKIN_SHAPES   5u
#define SAMPLE_SKIN_VERTICES 4u
#define SAMPLE_ONE           (INT32_C(1) << 30)

static const int16_t SAMPLE_FRAME[9] = {16384, 0, 0, 0, 16384, 0, 0, 0, 16384};

static inline void sample_bone(build *b, uint16_t parent, uint16_t value, int32_t x)
{
    const build_bone_data bone = {parent, value, 128, {x, -3 * x, 500}, 2560, SAMPLE_FRAME};
    build_bone(b, &bone);
}

static inline void sample_joint(build *b, uint8_t kind, uint16_t channel, uint32_t data)
{
    int turns = kind == WG_JOINT_TURN || kind == WG_JOINT_MOVE;
    const build_joint_data j = {kind, 0, channel, data, {0, 0, turns ? SAMPLE_ONE : 0}};
    build_joint(b, &j);
}

/* Five shapes of 4, 3, 2, 3 and 3 vertices; the first three get skins, the last one is the fourth's
 * normals. */
static inline void sample_skin_shapes(build *b)
{
    static const int16_t REST[12] = {0, 100, -200, 300, 0, 5, -400, 32767, 9, -32768, 7, 60};
    static const uint16_t VERTICES[5] = {4, 3, 2, 3, 3}, CORNERS[3] = {0, 1, 2};
    for (unsigned i = 0; i < 5; i++) {
        const build_shape_data shape = {VERTICES[i], 4, WG_ABSENT, {10, -20, 30}, REST};
        build_shape(b, &shape);
    }
    for (unsigned i = 0; i < 4; i++) {
        const build_part_data part = {
            (uint16_t)(i == 2 ? 0 : i), i == 3 ? 4 : WG_ABSENT, 1, 1, {255, 128, 0}, CORNERS};
        build_part(b, &part);
    }
}

/* LINEAR with ends: a chain of three bones with every joint but FOLLOW. */
static inline void sample_skin_chain(build *b)
{
    static const uint8_t ONE[9] = {0, 100, 0, 1, 100, 77, 2, 55, 255};
    static const uint8_t THREE[9] = {1, 255, 200, 2, 255, 3, 0, 255, 128};
    build_skin(b, 0, WG_SKIN_LINEAR, 1);
    sample_bone(b, WG_ABSENT, 0, 0);
    sample_joint(b, WG_JOINT_TURN, 0, 0x7fffffff);
    sample_joint(b, WG_JOINT_MOVE, 1, 0);
    sample_joint(b, WG_JOINT_QUATERNION, 5, 0);
    sample_bone(b, 0, WG_ABSENT, 2000);
    sample_joint(b, WG_JOINT_STRETCH, 2, 0);
    sample_joint(b, WG_JOINT_TWIST_START, 3, 1000000);
    sample_joint(b, WG_JOINT_TWIST_END, 4, 0x7fffffff);
    sample_bone(b, 1, 8, 4000);
    build_span(b, 0, 1, 3, ONE);
    build_span(b, 1, 3, 1, THREE);
}

/* DUAL: its third bone follows the second; the others are free. The joint before FOLLOW has the list of
 * it too, so that it can be made one. */
static inline void sample_skin_points(build *b)
{
    static const uint8_t DATA[48] = {0, 31,  1, 32, 2, 32, 0, 32, 1, 32, 2, 32, 0, 32, 1, 32,
                                     2, 255, 0, 0,  0, 0,  0, 0,  0, 0,  0, 0,  0, 0,  1, 0,
                                     1, 128, 0, 0,  0, 0,  0, 0,  0, 0,  0, 0,  0, 0,  0, 127};
    static const uint8_t LIST[1] = {1};
    build_skin(b, 1, WG_SKIN_DUAL, 0);
    sample_bone(b, WG_ABSENT, WG_ABSENT, 3000);
    sample_bone(b, WG_ABSENT, WG_ABSENT, -3000);
    sample_joint(b, WG_JOINT_MOVE, 1, 0);
    sample_bone(b, WG_ABSENT, WG_ABSENT, 100);
    const build_joint_data turn = {
        WG_JOINT_TURN, 1, 0, build_data(b, 1, LIST, 1), {0, 0, SAMPLE_ONE}};
    build_joint(b, &turn);
    build_follow(b, 1, LIST);
    sample_bone(b, WG_ABSENT, WG_ABSENT, 900);
    sample_joint(b, WG_JOINT_MOVE, 2, 0);
    build_span(b, 0, 3, 8, DATA);
}

static inline void sample_skin_fields(build *b)
{
    static const uint16_t FROM[2] = {0, 7}, ONE[1] = {8};
    static const uint8_t WEIGHTS[2] = {5, 250}, ALL[1] = {255};
    build_field(b, 7, 2, FROM, WEIGHTS);
    build_field(b, 8, 1, ONE, ALL);
}

static inline void sample_skin_paints(build *b)
{
    static uint8_t palette[WG_PALETTE_BYTES];
    static const uint8_t TEXELS[6] = {0, 255, 3, 4, 5, 6};
    const build_paint_data field = {0, WG_PAINT_FIELD, 0, 0, palette, NULL, 0, {0, 0}};
    const build_paint_data picture = {3, WG_PAINT_PICTURE, 2, 3, palette, TEXELS, 65536, {5, -5}};
    build_paint(b, &field);
    build_paint(b, &picture);
}

static inline uint8_t *sample_skins_file(uint32_t *size)
{
    static const uint8_t TWO[4] = {0, 255, 0, 255};
    static const int16_t KNOTS[4] = {0, 3000, -3000, 100};
    static const uint16_t ENDS[2] = {500, 1000};
    const build_run_data run = {0, 2, WG_KIND_LINEAR, 7, 0, 0, ENDS, NULL, KNOTS};
    build b = {{{0}}, 2};
    for (unsigned c = 0; c < SAMPLE_SKIN_CHANNELS; c++) {
        build_channel(&b, 8 + (int)c, WG_UNIT_NONE, (int32_t)c * 1000);
    }
    build_clip(&b, 1000, 1000, WG_END_HOLD);
    for (uint16_t c = 0; c < 7; c++) {
        build_track(&b, c);
        build_run(&b, &run);
    }
    sample_skin_shapes(&b);
    sample_skin_chain(&b);
    sample_skin_points(&b);
    build_skin(&b, 2, WG_SKIN_SHIFT, 0);
    sample_bone(&b, WG_ABSENT, WG_ABSENT, 50);
    sample_joint(&b, WG_JOINT_MOVE, 3, 0);
    build_span(&b, 0, 2, 1, TWO);
    sample_skin_fields(&b);
    sample_skin_paints(&b);
    return build_finish(&b, size);
}

#endif
