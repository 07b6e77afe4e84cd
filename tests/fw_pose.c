/* Cost image: every shape of the linked clip is posed in ranges, for an emulator to count.
 *   run_board.py BOARD IMAGE --roi wg_pose_vertices    one range of POSE_RANGE vertices
 *   run_board.py BOARD IMAGE --roi wg_pose_set         weights and matrix of one shape
 * Channel values are those of the clip's layers, or their rest values where no clip moves them.
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "wiggly.h"
#include "clip.h"

#define POSE_RANGE 64u
#define POSE_TICKS 4u

static wg_file file;
static wg_layer layers[CLIP_LAYERS];
static wg_player player;
static int32_t values[CLIP_CHANNELS];
static int16_t weights[WG_BASES_MAX];
static int32_t xyz[3u * POSE_RANGE];
static volatile int32_t sink; /* keeps the vertices */

static void pose_shape(uint8_t shape)
{
    wg_pose pose;
    wg_pose_init(&pose, &file, shape, weights);
    wg_pose_set(&pose, values, WG_BASES_MAX, 0);
    for (uint32_t first = 0; first < pose.vertices; first += POSE_RANGE) {
        uint32_t left = pose.vertices - first;
        wg_pose_vertices(&pose, (uint16_t)first, (uint16_t)(left < POSE_RANGE ? left : POSE_RANGE),
                         xyz);
        sink = xyz[0];
    }
}

int main(void)
{
    hal_init();
    if (wg_open(&file, CLIP_DATA, CLIP_BYTES) < 0 || wg_open_shapes(&file) < 0) {
        hal_log("clip refused");
        hal_stop(1);
    }
    wg_player_init(&player, &file, layers, CLIP_LAYERS);
    for (uint32_t tick = 0; tick < POSE_TICKS; tick++) {
        wg_player_update(&player, tick * CLIP_TICK_US);
        wg_player_sample(&player, values);
        for (uint8_t shape = 0; shape < file.section[WG_SECTION_SHAPES].count; shape++) {
            pose_shape(shape);
        }
    }
    hal_stop(0);
    return 0;
}
