/* The skins and fields of a fuzzed clip: bones and vertices from values of every size, in ranges that
 * must agree with each other, bit for bit.
 * SPDX-License-Identifier: MIT */
#ifndef EXERCISE_SKIN_H
#define EXERCISE_SKIN_H

#include "exercise_base.h"
#include "wiggly.h"

#define EXERCISE_SKINNED 300u /* vertices at once */

/* Exact-size blocks, so that a write outside is caught. */
static void exercise_skinned(const wg_skin *skin, const wg_pose *pose, const int32_t *values,
                             uint32_t *state)
{
    uint32_t first = exercise_next(state) % pose->vertices, left = pose->vertices - first;
    uint32_t count = 1u + exercise_next(state) % EXERCISE_SKINNED, one;
    count = count < left ? count : left;
    one = exercise_next(state) % count;
    int32_t *xyz = malloc(3u * count * sizeof *xyz), alone[3];
    uint8_t *lights = malloc(count), light;
    wg_skin_vertices(skin, pose, (uint16_t)first, (uint16_t)count, xyz);
    wg_skin_vertices(skin, pose, (uint16_t)(first + one), 1, alone);
    must(memcmp(alone, xyz + 3u * one, sizeof alone) == 0);
    wg_skin_brightness(skin, values, (uint16_t)first, (uint16_t)count, lights);
    wg_skin_brightness(skin, values, (uint16_t)(first + one), 1, &light);
    must(light == lights[one]);
    free(lights);
    free(xyz);
}

static void exercise_skin(const wg_file *file, uint8_t shape, const int32_t *values,
                          const wg_rigid *camera, uint32_t *state)
{
    const wg_section *skins = &file->section[WG_SECTION_SKINS];
    int16_t weights[WG_BASES_MAX];
    wg_pose pose;
    wg_skin skin;
    wg_bone *bones = NULL;
    for (uint32_t i = 0; i < skins->count; i++) {
        const uint8_t *r = skins->at + i * WG_SKIN_BYTES;
        if (build_get(r + WG_SKIN_SHAPE, 2) == shape) {
            bones = malloc(build_get(r + WG_SKIN_BONE_COUNT, 2) * sizeof *bones);
        }
    }
    bool has = wg_skin_init(&skin, file, shape, bones);
    must(has == (bones != NULL));
    if (has) {
        wg_pose_init(&pose, file, shape, weights);
        wg_pose_set(&pose, values, WG_BASES_MAX, NULL);
        wg_skin_set(&skin, values, camera);
        for (unsigned n = 0; n < 3; n++) {
            exercise_skinned(&skin, &pose, values, state);
        }
    }
    free(bones);
}

static void exercise_skins(const wg_file *file, uint32_t *state)
{
    /* a turn about z by the 3-4-5 triangle's angle, and a way of any size */
    wg_rigid camera = {{644245094, -858993459, 0, 858993459, 644245094, 0, 0, 0, 1 << 30},
                       {0, 0, (1 << 30) - 1},
                       0};
    int32_t values[WG_CHANNELS_MAX];
    uint32_t shapes = file->section[WG_SECTION_SHAPES].count;
    for (unsigned n = 0; n < 4; n++) {
        for (unsigned c = 0; c < WG_CHANNELS_MAX; c++) {
            int32_t v = (int32_t)(exercise_number(state) % (1u << 29));
            values[c] = n == 0 ? (c & 1u ? 1 << 29 : -(1 << 29)) : c & 2u ? v : -v;
        }
        if (n == 3) {
            wg_clip_sample(file, 0, exercise_number(state), values, NULL);
        }
        wg_fields_set(file, values);
        for (unsigned c = 0; c < file->section[WG_SECTION_CHANNELS].count; c++) {
            must(values[c] >= -(1 << 29) && values[c] <= 1 << 29);
        }
        camera.centre[0] = values[0];
        camera.centre_frac = (int8_t)exercise_next(state);
        for (uint32_t s = 0; s < shapes; s++) {
            exercise_skin(file, (uint8_t)s, values, n == 1 ? &camera : NULL, state);
        }
    }
}

#endif
