/* Determinism image: everything the player says about the linked clip, and its pictures where memory
 * allows, hashed to one number that must be the same on every target, compiler and optimisation
 * level. Builds like firmware/main.c.
 *   logs "hash XXXXXXXX" (FNV-1a, 32 bits, over little-endian bytes) and stops with 0
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "picture_skin.h"
#include "pixels.h"
#include "wg_mem.h"
#include "clip.h"

#include <stddef.h>

#define PURE_STEP_US 10000u
#define PLAY_TICK_US 20000u
#define PLAY_TICKS   150u /* 3 s */
#define POSE_TIMES   5u   /* of each clip */
#define POSE_RANGE   64u  /* vertices at once; or 7, so that ranges start and end anywhere */

#define PICTURE_WIDTH  32u
#define PICTURE_HEIGHT 24u
#ifndef CLIP_SKINS
#define CLIP_SKINS  0
#define CLIP_BONES  0
#define CLIP_FIELDS 0
#define CLIP_PAINTS 0
#endif
#define HAS_SKINS   (CLIP_SKINS || CLIP_FIELDS || CLIP_PAINTS)
/* What a board of 8 KB has memory for, and then every board: bones, pictures, recomputed normals. */
#define PICTURE_RAM 5600u
#define BONES_RAM   (UINT32_C(64) * CLIP_BONES)
#define BONES       (CLIP_SKINS > 0 && BONES_RAM <= PICTURE_RAM / 2u)
#define PICTURES    (UINT32_C(7) * CLIP_VERTICES + BONES_RAM <= PICTURE_RAM)
#define NORMALS     (CLIP_NORMALS > 0 && UINT32_C(13) * CLIP_VERTICES + BONES_RAM <= PICTURE_RAM)

static wg_file file;
static wg_layer layers[CLIP_LAYERS];
static wg_player player;
static int32_t values[CLIP_CHANNELS];
static int32_t velocities[CLIP_CHANNELS];
static int16_t weights[WG_BASES_MAX];
static int32_t xyz[3u * POSE_RANGE]; /* of a pose; or a band of pixels */
static wg_picture picture;
static wg_vertex vertices[PICTURES ? CLIP_VERTICES + 1u : 1u];
static uint8_t shades[PICTURES ? CLIP_VERTICES + 1u : 1u];
static int16_t made[NORMALS ? 3u * CLIP_NORMALS : 1u]; /* normals */
static wg_bone bones[BONES ? CLIP_BONES : 1u];
static wg_picture_skins skins;

static uint32_t hash_u32(uint32_t hash, uint32_t word)
{
    for (uint8_t byte = 0; byte < 4; byte++) {
        hash = (hash ^ (word & 0xffu)) * UINT32_C(16777619);
        word >>= 8;
    }
    return hash;
}

static uint32_t hash_values(uint32_t hash, const int32_t *v)
{
    for (uint16_t channel = 0; channel < CLIP_CHANNELS; channel++) {
        hash = hash_u32(hash, (uint32_t)v[channel]);
    }
    return hash;
}

static void set_fields(void)
{
    if (CLIP_FIELDS) { /* the linker drops it otherwise */
        wg_fields_set(&file, values);
    }
}

/* Every clip from its start to one step past its end. */
static uint32_t hash_clips(uint32_t hash)
{
    const wg_section *clips = &file.section[WG_SECTION_CLIPS];
    for (uint8_t clip = 0; clip < clips->count; clip++) {
        uint32_t last_us = wg_rd32(clips->at + (uint32_t)clip * WG_CLIP_BYTES + WG_CLIP_US);
        for (uint32_t steps = last_us / PURE_STEP_US + 2u, i = 0; i < steps; i++) {
            wg_clip_sample(&file, clip, i * PURE_STEP_US, values, velocities);
            hash = hash_values(hash_values(hash, values), velocities);
        }
    }
    return hash;
}

/* What an application does with layers, at fixed ticks: ramps, a cross-fade, reverse play, a seek.
 */
static void act(uint32_t tick)
{
    switch (tick) {
    case 30:
        wg_player_fade(&player, 0, WG_WEIGHT_ONE / 3u, 700000u);
        break;
    case 60:
        wg_player_speed(&player, CLIP_LAYERS - 1, -WG_SPEED_ONE / 2 * 3);
        break;
    case 80:
        if (CLIP_LAYERS > 1) {
            wg_player_crossfade(&player, 0, CLIP_CLIPS - 1, 450000u);
        }
        break;
    case 110:
        wg_player_seek(&player, 0, 123456u);
        break;
    default:
        break;
    }
}

static uint32_t hash_player(uint32_t hash)
{
    wg_event event;
    wg_player_init(&player, &file, layers, CLIP_LAYERS);
    for (uint32_t tick = 0; tick < PLAY_TICKS; tick++) {
        act(tick);
        wg_player_update(&player, tick * PLAY_TICK_US);
        while (wg_player_event(&player, &event)) {
            hash = hash_u32(hash, (uint32_t)event.id << 16 | event.layer);
        }
        wg_player_sample(&player, values);
        set_fields();
        hash = hash_values(hash, values);
    }
    return hash;
}

/* `skin`: that the pose goes through, or NULL. */
static uint32_t hash_vertices(uint32_t hash, const wg_pose *pose, const wg_skin *skin,
                              uint16_t range)
{
    for (uint32_t first = 0; first < pose->vertices; first += range) {
        uint32_t left = pose->vertices - first;
        uint16_t count = (uint16_t)(left < range ? left : range);
        if (BONES && skin) {
            wg_skin_vertices(skin, pose, (uint16_t)first, count, xyz);
        } else {
            wg_pose_vertices(pose, (uint16_t)first, count, xyz);
        }
        for (uint16_t i = 0; i < 3u * count; i++) {
            hash = hash_u32(hash, (uint32_t)xyz[i]);
        }
    }
    return hash;
}

static const wg_rigid CAMERA = {{INT32_C(644245094), INT32_C(-858993459), 0, INT32_C(858993459),
                                 INT32_C(644245094), 0, 0, 0, INT32_C(1) << 30},
                                {INT32_C(12345), INT32_C(-6789), INT32_C(101112)},
                                10};

/* A shape that follows bones, by itself and before a camera; as a field. */
static uint32_t hash_skin(uint32_t hash, uint8_t shape)
{
    wg_skin *skin = &skins.skin;
    wg_pose pose;
    if (!wg_skin_init(skin, &file, shape, bones)) {
        return hash;
    }
    wg_pose_init(&pose, &file, shape, weights);
    wg_pose_set(&pose, values, WG_BASES_MAX, 0);
    wg_skin_set(skin, values, 0);
    hash = hash_vertices(hash, &pose, skin, POSE_RANGE);
    hash = hash_vertices(hash, &pose, skin, 7);
    wg_skin_set(skin, values, &CAMERA);
    hash = hash_vertices(hash, &pose, skin, POSE_RANGE);
    for (uint32_t i = 0; i < pose.vertices; i++) {
        uint8_t bright;
        wg_skin_brightness(skin, values, (uint16_t)i, 1, &bright);
        hash = hash_u32(hash, bright);
    }
    return hash;
}

/* A shape by itself, before a camera with all but one basis, and as its own normals. */
static uint32_t hash_shape(uint32_t hash, uint8_t shape)
{
    wg_pose pose, normals;
    wg_pose_init(&pose, &file, shape, weights);
    wg_pose_set(&pose, values, WG_BASES_MAX, 0);
    hash = hash_vertices(hash, &pose, NULL, POSE_RANGE);
    hash = hash_vertices(hash, &pose, NULL, 7);
    uint16_t bases = wg_rd16(pose.record + WG_SHAPE_BASIS_COUNT);
    wg_pose_set(&pose, values, (uint16_t)(bases > 0 ? bases - 1u : 0), &CAMERA);
    hash = hash_vertices(hash, &pose, NULL, POSE_RANGE);
    wg_pose_init(&normals, &file, shape, weights);
    wg_pose_set_normals(&normals, values, WG_BASES_MAX, &pose);
    return hash_vertices(hash, &normals, NULL, POSE_RANGE);
}

static uint32_t hash_shapes(uint32_t hash)
{
    const wg_section *clips = &file.section[WG_SECTION_CLIPS];
    for (uint8_t clip = 0; clip < clips->count; clip++) {
        uint32_t last_us = wg_rd32(clips->at + (uint32_t)clip * WG_CLIP_BYTES + WG_CLIP_US);
        for (uint8_t i = 0; i < POSE_TIMES; i++) {
            wg_clip_sample(&file, clip, last_us / (POSE_TIMES - 1u) * i, values, 0);
            set_fields();
            for (uint8_t shape = 0; shape < file.section[WG_SECTION_SHAPES].count; shape++) {
                hash = hash_shape(hash, shape);
                hash = BONES ? hash_skin(hash, shape) : hash;
            }
        }
    }
    return hash;
}

/* Pixels as they are, and as grey ones. */
static uint32_t hash_band(uint32_t hash, wg_rect rect)
{
    uint32_t *pixels = (uint32_t *)xyz;
    uint16_t count = (uint16_t)((rect.x1 - rect.x0) * (rect.y1 - rect.y0));
    wg_picture_band(&picture, rect, pixels);
    for (uint16_t i = 0; i < count; i++) {
        hash = hash_u32(hash, pixels[i]);
    }
    uint32_t bytes = wg_pixels_grey4(&picture, rect, pixels, (uint8_t *)pixels);
    for (uint32_t i = 0; i < bytes; i++) {
        hash = hash_u32(hash, ((const uint8_t *)pixels)[i]);
    }
    return hash;
}

/* In bands of 5 lines and then in columns, as many as there is memory for. */
static uint32_t hash_picture(uint32_t hash)
{
    if (CLIP_SKINS) {
        wg_picture_set_skinned(&picture, values);
    } else {
        wg_picture_set(&picture, values);
    }
    for (uint16_t y = 0; y < PICTURE_HEIGHT; y = (uint16_t)(y + 5u)) {
        uint16_t end = (uint16_t)(y + 5u < PICTURE_HEIGHT ? y + 5u : PICTURE_HEIGHT);
        const wg_rect rect = {0, y, PICTURE_WIDTH, end};
        hash = hash_band(hash, rect);
    }
    for (uint16_t x = 0; x < PICTURE_WIDTH; x = (uint16_t)(x + 8u)) {
        const wg_rect rect = {x, 0, (uint16_t)(x + 8u), PICTURE_HEIGHT};
        hash = hash_band(hash, rect);
    }
    return hash;
}

/* Every view in every shading at a few times of every clip. */
static uint32_t hash_pictures(uint32_t hash)
{
    const wg_picture_memory memory = {vertices, shades, NORMALS ? made : 0, weights};
    const wg_size size = {PICTURE_WIDTH, PICTURE_HEIGHT};
    const wg_section *clips = &file.section[WG_SECTION_CLIPS];
    if (!PICTURES || file.section[WG_SECTION_VIEWS].count == 0) {
        return hash;
    }
    wg_picture_init(&picture, &file, size, &memory);
    if (HAS_SKINS) {
        skins.bones = bones;
        wg_picture_paint(&picture, BONES ? &skins : NULL);
    }
    for (uint8_t i = 0; i < 3u * file.section[WG_SECTION_VIEWS].count; i++) { /* <= 48 */
        uint8_t clip = (uint8_t)(i % clips->count);
        uint32_t last_us = wg_rd32(clips->at + (uint32_t)clip * WG_CLIP_BYTES + WG_CLIP_US);
        wg_clip_sample(&file, clip, last_us / 4u * (i % 4u), values, 0);
        set_fields();
        wg_picture_look(&picture, (uint8_t)(i / 3u));
        picture.shading = (uint8_t)(i % 3u);
        hash = hash_picture(hash);
    }
    return hash;
}

static void log_hash(uint32_t hash)
{
    char text[] = "hash 00000000";
    for (uint8_t digit = 0; digit < 8; digit++) {
        text[12 - digit] = "0123456789abcdef"[hash & 15u];
        hash >>= 4;
    }
    hal_log(text);
}

int main(void)
{
    hal_init();
    if (wg_open(&file, CLIP_DATA, CLIP_BYTES) < 0 || wg_open_shapes(&file) < 0 ||
        (HAS_SKINS && wg_open_skins(&file) < 0)) {
        hal_log("clip refused");
        hal_stop(1);
    }
    log_hash(hash_pictures(hash_shapes(hash_player(hash_clips(UINT32_C(2166136261))))));
    hal_stop(0);
    return 0;
}
