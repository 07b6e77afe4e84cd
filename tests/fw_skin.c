/* Cost image: the first shape's skin of the linked clip, posed in ranges, for an emulator to count.
 *   run_board.py BOARD IMAGE --roi wg_skin_vertices    one range of POSE_RANGE vertices
 *   run_board.py BOARD IMAGE --roi wg_skin_set         all bones
 * Channel values are those of the first clip, or their rest values where it does not move them.
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "wiggly.h"
#include "clip.h"

#define POSE_RANGE 64u
#define BONES      16u
#define TICKS      2u

static wg_file file;
static int32_t values[CLIP_CHANNELS];
static int16_t weights[WG_BASES_MAX];
static wg_bone bones[BONES];
static int32_t xyz[3u * POSE_RANGE];
static volatile int32_t sink; /* keeps the vertices */

static void pose_skin(void)
{
    wg_pose pose;
    wg_skin skin;
    wg_pose_init(&pose, &file, 0, weights);
    wg_pose_set(&pose, values, WG_BASES_MAX, 0);
    if (!wg_skin_init(&skin, &file, 0, bones)) {
        return;
    }
    wg_skin_set(&skin, values, 0);
    for (uint32_t first = 0; first + POSE_RANGE <= pose.vertices; first += POSE_RANGE) {
        wg_skin_vertices(&skin, &pose, (uint16_t)first, POSE_RANGE, xyz);
        sink = xyz[0];
    }
}

int main(void)
{
    hal_init();
    if (wg_open(&file, CLIP_DATA, CLIP_BYTES) < 0 || wg_open_shapes(&file) < 0 ||
        wg_open_skins(&file) < 0 || file.section[WG_SECTION_BONES].count > BONES) {
        hal_log("clip refused");
        hal_stop(1);
    }
    for (uint32_t tick = 0; tick < TICKS; tick++) {
        wg_clip_sample(&file, 0, tick * CLIP_TICK_US, values, 0);
        wg_fields_set(&file, values);
        pose_skin();
    }
    hal_stop(0);
    return 0;
}
