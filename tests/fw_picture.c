/* Cost image: frames of the linked clip for a panel of 128 x 64 grey pixels, for an emulator to count.
 *   run_board.py BOARD IMAGE --roi wg_picture_set   a frame's vertices
 *   run_board.py BOARD IMAGE --roi tall_bands       its pixels, packed, in bands of 8 lines
 *   run_board.py BOARD IMAGE --roi lines            the same, line by line
 * The frames: one in the view's own shading, then flat, smooth, wire. Logs a hash of all bytes, which is
 * the same on every board.
 * SPDX-License-Identifier: MIT */
#include "clip.h"
#include "hal.h"
#include "pixels.h"

#define WIDTH  128u
#define HEIGHT 64u
#define FRAMES 4u
#ifndef PICTURE_ROWS
#define PICTURE_ROWS 8u /* fewer where memory is short: the same bytes */
#endif

void tall_bands(void);
void lines(void);

static wg_file file;
static wg_layer layers[CLIP_LAYERS];
static wg_player player;
static int32_t values[CLIP_CHANNELS];
static int16_t weights[CLIP_BASES + 1];
static wg_vertex vertices[CLIP_VERTICES + 1];
static uint8_t shades[CLIP_VERTICES + 1];
static int16_t normals[3 * CLIP_NORMALS + 1];
static uint32_t band[WIDTH * PICTURE_ROWS];
static wg_picture picture;
static uint32_t hash = UINT32_C(2166136261); /* FNV-1a */

static void hash_bytes(const uint8_t *bytes, uint32_t count)
{
    for (; count > 0; count--) {
        hash = (hash ^ *bytes++) * UINT32_C(16777619);
    }
}

static void log_hash(void)
{
    char text[] = "picture 00000000";
    for (unsigned i = 0; i < 8; i++) {
        text[15 - i] = "0123456789abcdef"[hash >> 4 * i & 15u];
    }
    hal_log(text);
}

static void bands(uint16_t rows)
{
    for (uint16_t y = 0; y < HEIGHT; y = (uint16_t)(y + rows)) {
        const wg_rect rect = {0, y, WIDTH, (uint16_t)(y + rows)};
        wg_picture_band(&picture, rect, band);
        hash_bytes((const uint8_t *)band, wg_pixels_grey4(&picture, rect, band, (uint8_t *)band));
    }
}

void tall_bands(void)
{
    bands(PICTURE_ROWS);
}

void lines(void)
{
    bands(1);
}

int main(void)
{
    static const uint8_t SHADING[FRAMES - 1u] = {WG_SHADING_FLAT, WG_SHADING_SMOOTH,
                                                 WG_SHADING_WIRE};
    const wg_size size = {WIDTH, HEIGHT};
    const wg_picture_memory memory = {vertices, shades, CLIP_NORMALS ? normals : 0, weights};
    hal_init();
    if (wg_open(&file, CLIP_DATA, CLIP_BYTES) < 0 || wg_open_shapes(&file) < 0) {
        hal_log("clip refused");
        hal_stop(1);
    }
    wg_player_init(&player, &file, layers, CLIP_LAYERS);
    wg_picture_init(&picture, &file, size, &memory);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        if (frame > 0) {
            picture.shading = SHADING[frame - 1u];
        }
        wg_player_update(&player, frame * CLIP_TICK_US);
        wg_player_sample(&player, values);
        wg_picture_set(&picture, values);
        tall_bands();
        lines();
    }
    log_hash();
    hal_stop(0);
    return 0;
}
