/* What any bytes must survive: they are made into a clip that gets past the header, opened, and if
 * that succeeds everything a player and the device code can do with it is done. Sanitizers watch
 * the memory, `must` the promises of wiggly.h, servo.h and picture.h. The same bytes give the same run.
 * SPDX-License-Identifier: MIT */
#ifndef EXERCISE_H
#define EXERCISE_H

#include "exercise_base.h"
#include "exercise_picture.h"
#include "exercise_skin.h"
#include "dynamixel2.h"
#include "maestro.h"
#include "pca9685.h"
#include "servo.h"
#include "wiggly.h"

#define EXERCISE_MAX    65536u /* larger inputs are ignored */
#define EXERCISE_STEPS  48u    /* actions on the player */
#define EXERCISE_RANGES 6u     /* of vertices, of each shape at each set of values */
#define EXERCISE_EVENTS 300u   /* taken after one update at the most */

static int in_range(int32_t value)
{
    return value >= -(1 << 29) && value <= 1 << 29;
}

/* ---- tracks ---------------------------------------------------------------------------------- */

/* Where a track ends, from its last run: positions lie in 0 .. this << 16. */
static uint32_t track_end(const wg_file *file, uint32_t track)
{
    const uint8_t *t = file->section[WG_SECTION_TRACKS].at + track * WG_TRACK_BYTES;
    uint32_t last =
        build_get(t + WG_TRACK_RUN_FIRST, 2) + build_get(t + WG_TRACK_RUN_COUNT, 2) - 1u;
    must(last < file->section[WG_SECTION_RUNS].count);
    const uint8_t *run = file->section[WG_SECTION_RUNS].at + last * WG_RUN_BYTES;
    uint32_t ends = build_get(run + WG_RUN_TIMES, 4) + 2u * build_get(run + WG_RUN_SEGMENTS, 2);
    must(ends <= file->section[WG_SECTION_DATA].bytes);
    return build_get(file->section[WG_SECTION_DATA].at + ends - 2u, 2);
}

static void exercise_tracks(const wg_file *file, uint32_t *state)
{
    static const uint16_t RATES[] = {1, 1000, 65535};
    uint32_t count = file->section[WG_SECTION_TRACKS].count;
    for (uint32_t i = 0; i < count; i += 1u + count / 64u) {
        uint32_t end = track_end(file, i) << 16;
        for (unsigned n = 0; n < 16; n++) {
            uint32_t tick = exercise_number(state) << 16;
            uint32_t position = n == 0 ? end : (tick | exercise_next(state) % 0xffffu) % (end + 1u);
            int32_t value = wg_track_value(file, (uint16_t)i, position);
            must(in_range(value));
            must(value == wg_track_value(file, (uint16_t)i, position));
            wg_track_velocity(file, (uint16_t)i, position, RATES[n % 3u]);
        }
    }
}

static void exercise_clips(const wg_file *file, uint32_t *state)
{
    int32_t values[WG_CHANNELS_MAX], velocities[WG_CHANNELS_MAX];
    uint32_t count = file->section[WG_SECTION_CLIPS].count;
    for (uint32_t i = 0; i < count; i += 1u + count / 8u) {
        for (unsigned n = 0; n < 6; n++) {
            uint32_t time = exercise_number(state);
            wg_clip_sample(file, (uint8_t)i, time, values, n & 1u ? velocities : NULL);
            for (unsigned c = 0; c < file->section[WG_SECTION_CHANNELS].count; c++) {
                must(in_range(values[c]));
            }
        }
    }
}

/* ---- device ---------------------------------------------------------------------------------- */

static void exercise_frames(const wg_file *file, const wg_servo *servos, uint32_t *state)
{
    static const wg_pca9685 pwm = WG_PCA9685(25000000, 50);
    uint16_t size = (uint16_t)WG_BUS_BYTES(file->section[WG_SECTION_SERVOS].count);
    uint16_t small = (uint16_t)(exercise_next(state) % (size + 1u));
    uint8_t *out = malloc(size), *less = malloc(small ? small : 1u);
    uint8_t pca[WG_PCA9685_BYTES];
    must(wg_maestro_frame(file, servos, WG_MAESTRO_COMPACT, out, size) >= 0);
    must(wg_maestro_frame(file, servos, 12u, out, size) >= 0);
    must(wg_dynamixel2_frame(file, servos, out, size) >= 0);
    wg_maestro_frame(file, servos, WG_MAESTRO_COMPACT, less, small);
    wg_dynamixel2_frame(file, servos, less, small);
    for (unsigned chip = 0; chip < 17; chip++) {
        int bytes = wg_pca9685_frame(file, servos, &pwm, (uint8_t)chip, pca);
        must(bytes >= 0 && bytes <= (int)sizeof pca);
    }
    free(less);
    free(out);
}

/* Positions stay between a servo's limits unless wg_servo_start put it outside. */
static void exercise_servos(const wg_file *file, const int32_t *values, wg_servo *servos,
                            uint32_t *state)
{
    uint32_t count = file->section[WG_SECTION_SERVOS].count;
    if (count == 0) {
        return;
    }
    uint8_t one = (uint8_t)(exercise_next(state) % count);
    uint32_t action = exercise_next(state) % 8u;
    if (action == 0) {
        wg_servo_off(servos, one);
    } else if (action == 1) {
        const uint8_t *r = file->section[WG_SECTION_SERVOS].at + one * WG_SERVO_BYTES;
        wg_servo_start(servos, one, (int16_t)build_get(r + WG_SERVO_MIN, 2));
    }
    wg_servo_step(file, servos, values, exercise_number(state));
    for (uint32_t i = 0; i < count; i++) {
        const uint8_t *r = file->section[WG_SECTION_SERVOS].at + i * WG_SERVO_BYTES;
        int16_t position = wg_servo_position(&servos[i]);
        must(!wg_servo_on(&servos[i]) || (position >= (int16_t)build_get(r + WG_SERVO_MIN, 2) &&
                                          position <= (int16_t)build_get(r + WG_SERVO_MAX, 2)));
    }
    exercise_frames(file, servos, state);
}

/* ---- player ---------------------------------------------------------------------------------- */

static uint8_t some_clip(const wg_file *file, uint32_t *state)
{
    uint32_t count = file->section[WG_SECTION_CLIPS].count;
    uint32_t clip = exercise_next(state) % (count + 1u);
    return (uint8_t)(clip == count ? WG_NONE : clip);
}

static void act(wg_player *p, uint8_t layer, uint32_t *state)
{
    uint32_t n = exercise_number(state);
    switch (exercise_next(state) % 12u) {
    case 0:
        wg_player_play(p, layer, some_clip(p->file, state));
        break;
    case 1:
        wg_player_pause(p, layer, n & 1u);
        break;
    case 2:
        wg_player_seek(p, layer, n);
        break;
    case 3:
    case 4:
        wg_player_speed(p, layer, (int32_t)(n & 1u ? n : 0u - n));
        break;
    case 5:
        wg_player_end(p, layer, (uint8_t)(n % 3u));
        break;
    case 6:
        wg_player_fade(p, layer, (uint16_t)(n % 32769u), exercise_number(state));
        break;
    case 7:
        if (layer + 1u < p->layer_count) {
            wg_player_crossfade(p, layer, some_clip(p->file, state), n);
        }
        break;
    default:
        wg_player_speed(p, layer, n & 1u ? WG_SPEED_ONE : -WG_SPEED_ONE);
    }
}

static void check_layer(const wg_player *p, uint8_t layer)
{
    const wg_layer *l = &p->layers[layer];
    must(l->faded_us <= l->fade_us);
    if (l->clip != WG_NONE) {
        const uint8_t *c =
            p->file->section[WG_SECTION_CLIPS].at + (uint32_t)l->clip * WG_CLIP_BYTES;
        must(wg_player_time(p, layer) <= build_get(c + WG_CLIP_US, 4));
    }
    wg_player_ended(p, layer);
}

static void exercise_player(const wg_file *file, uint32_t *state)
{
    wg_layer layers[WG_LAYERS_MAX];
    wg_servo servos[WG_SERVOS_MAX];
    wg_player player;
    wg_event event;
    int32_t values[WG_CHANNELS_MAX];
    memset(layers, 0xa5, sizeof layers); /* init must not need cleared memory */
    wg_player_init(&player, file, layers, (uint8_t)(1u + exercise_next(state) % WG_LAYERS_MAX));
    wg_servo_init(servos, file);
    must(!wg_player_event(&player, &event));
    for (unsigned step = 0; step < EXERCISE_STEPS; step++) {
        uint8_t layer = (uint8_t)(exercise_next(state) % player.layer_count);
        act(&player, layer, state);
        wg_player_update(&player, player.now_us + exercise_number(state));
        for (unsigned n = 0; n < EXERCISE_EVENTS && wg_player_event(&player, &event); n++) {
            must(event.layer < player.layer_count && event.backwards < 2);
        }
        wg_player_sample(&player, values);
        for (unsigned c = 0; c < file->section[WG_SECTION_CHANNELS].count; c++) {
            must(in_range(values[c]));
        }
        check_layer(&player, layer);
        exercise_servos(file, values, servos, state);
    }
}

/* ---- shapes ---------------------------------------------------------------------------------- */

/* Ranges of odd sizes; the last vertex of each once more by itself. */
static void exercise_vertices(const wg_pose *pose, uint32_t *state)
{
    for (unsigned n = 0; n < EXERCISE_RANGES; n++) {
        uint32_t first = exercise_next(state) % pose->vertices;
        uint32_t left = pose->vertices - first, count = 1u + 2u * (exercise_next(state) % 40u);
        int32_t *xyz, one[3];
        count = n == 0 || count > left ? left : count;
        xyz = malloc(3u * count * sizeof *xyz);
        wg_pose_vertices(pose, (uint16_t)first, (uint16_t)count, xyz);
        wg_pose_vertices(pose, (uint16_t)(first + count - 1u), 1, one);
        must(memcmp(one, xyz + 3u * (count - 1u), sizeof one) == 0);
        free(xyz);
    }
}

static void exercise_shapes(const wg_file *file, uint32_t *state)
{
    /* a turn about z by the 3-4-5 triangle's angle, and a way of any size */
    wg_rigid camera = {{644245094, -858993459, 0, 858993459, 644245094, 0, 0, 0, 1 << 30},
                       {0, 0, (1 << 30) - 1},
                       0};
    int32_t values[WG_CHANNELS_MAX];
    int16_t weights[2][WG_BASES_MAX];
    wg_pose pose, normals;
    for (unsigned n = 0; n < 3; n++) {
        for (unsigned c = 0; c < WG_CHANNELS_MAX; c++) {
            int32_t v = (int32_t)(exercise_number(state) % (1u << 29));
            values[c] = n == 0 ? (c & 1u ? 1 << 29 : -(1 << 29)) : c & 2u ? v : -v;
        }
        camera.centre[0] = values[0];
        camera.centre_frac = (int8_t)exercise_next(state);
        for (uint32_t s = 0; s < file->section[WG_SECTION_SHAPES].count; s++) {
            wg_pose_init(&pose, file, (uint8_t)s, weights[0]);
            wg_pose_set(&pose, values, WG_BASES_MAX, n == 1 ? &camera : NULL);
            exercise_vertices(&pose, state);
            wg_pose_init(&normals, file, (uint8_t)s, weights[1]);
            wg_pose_set_normals(&normals, values, (uint16_t)(exercise_next(state) % 70u), &pose);
            exercise_vertices(&normals, state);
        }
    }
}

/* The bytes as they might come down a noisy bus. */
static void exercise_bus(const uint8_t *data, size_t size)
{
    wg_dynamixel2_reader reader = {{0}, 0, 0};
    wg_dynamixel2_status status;
    for (size_t i = 0; i < size && i < 2000; i++) {
        if (wg_dynamixel2_feed(&reader, data[i], &status)) {
            must(status.param_count <= WG_DYNAMIXEL2_PARAMS_MAX);
        }
        must(reader.count <= WG_DYNAMIXEL2_READER_BYTES);
    }
}

/* ---- all of it ------------------------------------------------------------------------------- */

/* Returns what wg_open said about the repaired bytes. */
static int exercise(const uint8_t *data, size_t size)
{
    if (size < WG_HEADER_BYTES || size > EXERCISE_MAX) {
        return WG_ERR_SHORT;
    }
    wg_file file;
    exercise_bus(data, size);
    uint8_t *clip = build_copy(data, (uint32_t)size);
    build_put(clip, 4, WG_FORMAT_MAGIC);
    clip[WG_HEADER_MAJOR] = WG_FORMAT_MAJOR;
    build_put(clip + WG_HEADER_LENGTH, 4, (uint32_t)size);
    build_seal(clip, (uint32_t)size);
    int err = wg_open(&file, clip, (uint32_t)size);
    must(err <= 0 && err >= WG_ERR_NAME);
    if (err == 0) {
        uint32_t state = build_get(clip + WG_HEADER_CRC, 4);
        exercise_tracks(&file, &state);
        exercise_clips(&file, &state);
        exercise_player(&file, &state);
        int shapes = wg_open_shapes(&file);
        must(shapes <= 0 && (shapes == 0 || (shapes <= WG_ERR_SHAPE && shapes >= WG_ERR_VIEW)));
        if (shapes == 0) {
            exercise_shapes(&file, &state);
            int skins = wg_open_skins(&file);
            must(skins <= 0 && (skins == 0 || (skins <= WG_ERR_BONE && skins >= WG_ERR_PAINT)));
            if (skins == 0) {
                exercise_skins(&file, &state);
            }
            exercise_pictures(&file, &state);
        }
    }
    free(clip);
    return err;
}

#endif
