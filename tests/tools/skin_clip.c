/* A clip with a skin, to measure what a vertex and a bone cost: 192 vertices, 16 bones in a chain, each
 * turned, with ends stretched and twisted too.
 *   skin_clip METHOD INFLUENCES ENDS OUT      METHOD 0 LINEAR, 1 DUAL, 2 SHIFT
 *                                             ENDS 0 without, 1 with, 2 with and twisted
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "clip_build_skin.h"

#define VERTICES 192u
#define BONES    16u
#define ANGLE    0u /* channel */
#define LONGER   1u
#define TWIST    2u

static const int16_t FRAME[9] = {9830, 13107, 0, -13107, 9830, 0, 0, 0, 16384}; /* 3-4-5 */

static void add_shape(build *b)
{
    static int16_t rest[3u * VERTICES];
    for (unsigned i = 0; i < 3u * VERTICES; i++) {
        rest[i] = (int16_t)((int)(i * 7919u % 16001u) - 8000);
    }
    const build_shape_data shape = {VERTICES, 4, WG_ABSENT, {0, 0, 0}, rest};
    build_shape(b, &shape);
}

static void add_bones(build *b, unsigned ends)
{
    for (unsigned i = 0; i < BONES; i++) {
        const build_bone_data bone = {
            (uint16_t)(i ? i - 1u : WG_ABSENT),           WG_ABSENT, 255,
            {(int32_t)i * 76800, (int32_t)i * 102400, 0}, 128000,    FRAME};
        const build_joint_data turn = {WG_JOINT_TURN, 0, ANGLE, 777777, {0, 0, 1 << 30}};
        const build_joint_data longer = {WG_JOINT_STRETCH, 0, LONGER, 0, {0, 0, 0}};
        const build_joint_data twist = {WG_JOINT_TWIST_END, 0, TWIST, 65536u * 100u, {0, 0, 0}};
        build_bone(b, &bone);
        build_joint(b, &turn);
        if (ends == 2) {
            build_joint(b, &longer);
            build_joint(b, &twist);
        }
    }
}

static void add_span(build *b, unsigned influences, unsigned ends)
{
    static uint8_t data[3u * WG_INFLUENCES_MAX * VERTICES];
    unsigned at = 0;
    for (unsigned v = 0; v < VERTICES; v++) {
        for (unsigned i = 0; i < influences; i++) {
            unsigned each = WG_WEIGHT_SUM / influences;
            data[at++] = (uint8_t)((v + 5u * i) % BONES);
            data[at++] = (uint8_t)(i ? each : WG_WEIGHT_SUM - each * (influences - 1u));
            if (ends) {
                data[at++] = (uint8_t)(v * 37u + i * 64u);
            }
        }
    }
    build_span(b, 0, VERTICES, (uint8_t)influences, data);
}

int main(int argc, char **argv)
{
    build b = {{{0}}, 2};
    uint32_t size;
    if (argc != 5) {
        return 2;
    }
    unsigned method = (unsigned)atoi(argv[1]), influences = (unsigned)atoi(argv[2]);
    unsigned ends = (unsigned)atoi(argv[3]);
    build_channel(&b, 8, WG_UNIT_DEGREE, 2560);
    build_channel(&b, 14, WG_UNIT_NONE, 17000);
    build_channel(&b, 8, WG_UNIT_DEGREE, 23040);
    build_clip(&b, 1000, 1000, WG_END_HOLD);
    add_shape(&b);
    build_skin(&b, 0, (uint8_t)method, ends != 0);
    add_bones(&b, ends);
    add_span(&b, influences, ends);
    uint8_t *clip = build_finish(&b, &size);
    FILE *out = fopen(argv[4], "wb");
    if (!out || fwrite(clip, 1, size, out) != size || fclose(out) != 0) {
        return 1;
    }
    free(clip);
    return 0;
}
