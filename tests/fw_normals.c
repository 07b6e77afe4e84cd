/* Cost image: every vertex of the linked clip posed, projected and shaded, for an emulator to
 * count.
 *   run_board.py BOARD IMAGE --roi cost_every_1    one frame, shades renewed each frame
 *   run_board.py BOARD IMAGE --roi cost_every_2    each second frame, and cost_every_4: each fourth
 *   run_board.py BOARD IMAGE --roi cost_draw       the pixels of one frame, 128 x 64
 * Which normals there are is the clip's affair: a shape of them, or none, so that they are made
 * from the posed triangles [Alexa 7.3.3].
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "picture.h"
#include "clip.h"

#define TICK_US UINT32_C(100000)
#define FRAMES  4u /* of each kind: whole rounds of 1, 2 and 4 */
#define WIDTH   128u
#define HEIGHT  64u

static wg_file file;
static wg_layer layers[CLIP_LAYERS];
static wg_player player;
static int32_t values[CLIP_CHANNELS];
static wg_picture picture;
static wg_vertex vertices[CLIP_VERTICES + 1];
static uint8_t shades[CLIP_VERTICES + 1];
static int16_t normals[3u * (CLIP_VERTICES + 1)];
static int16_t weights[CLIP_BASES + 1];
static uint32_t pixels[WIDTH * HEIGHT];
static volatile uint32_t
    sink; /* keeps what nobody needs, and each function apart from the others */

void cost_every_1(void);
void cost_every_2(void);
void cost_every_4(void);
void cost_draw(void);

void __attribute__((noinline)) cost_every_1(void)
{
    wg_picture_set(&picture, values);
    sink = 1;
}

void __attribute__((noinline)) cost_every_2(void)
{
    wg_picture_set(&picture, values);
    sink = 2;
}

void __attribute__((noinline)) cost_every_4(void)
{
    wg_picture_set(&picture, values);
    sink = 4;
}

void __attribute__((noinline)) cost_draw(void)
{
    const wg_rect all = {0, 0, WIDTH, HEIGHT};
    wg_picture_band(&picture, all, pixels);
    sink = pixels[0];
}

static void frame(uint32_t i)
{
    switch (picture.normals_every) {
    case 1:
        cost_every_1();
        break;
    case 2:
        cost_every_2();
        break;
    default:
        cost_every_4();
        break;
    }
    if (i == FRAMES - 1u) {
        cost_draw();
    }
}

static void play(uint8_t every)
{
    const wg_picture_memory memory = {vertices, shades, normals, weights};
    const wg_size size = {WIDTH, HEIGHT};
    wg_picture_init(&picture, &file, size, &memory);
    picture.normals_every = every;
    wg_player_init(&player, &file, layers, CLIP_LAYERS);
    for (uint32_t i = 0; i < FRAMES; i++) {
        wg_player_update(&player, i * TICK_US);
        wg_player_sample(&player, values);
        frame(i);
    }
}

int main(void)
{
    hal_init();
    if (wg_open(&file, CLIP_DATA, CLIP_BYTES) < 0 || wg_open_shapes(&file) < 0) {
        hal_log("clip refused");
        hal_stop(1);
    }
    for (uint8_t every = 1; every <= 4; every = (uint8_t)(every * 2)) {
        play(every);
    }
    hal_stop(0);
    return 0;
}
