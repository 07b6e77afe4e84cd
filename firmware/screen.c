/* From channel values to the display: picture.h draws bands of what may have changed, the panel
 * packs and sends each. It is done in slices, between the ticks. All memory is static; its size
 * follows from the clip and the panel.
 * SPDX-License-Identifier: MIT */
#include "screen.h"

#include "fix.h"
#include "panel.h"
#include "picture_skin.h"

#include "clip.h"

#include <stddef.h>
#include <string.h>

#ifndef CLIP_NORMALS
#define CLIP_NORMALS 0 /* CLIP_VERTICES if some are to be recomputed for every picture */
#endif
#ifndef CLIP_SKINS
#define CLIP_SKINS  0
#define CLIP_BONES  0 /* of the skin that has most */
#define CLIP_PAINTS 0
#endif

WG_STATIC_ASSERT(PANEL_WIDTH <= WG_SIDE_MAX && PANEL_HEIGHT <= WG_SIDE_MAX);
/* A band is sent in one go, 2 bytes a pixel at the most, and hal.h counts bytes in 16 bits. */
WG_STATIC_ASSERT(UINT32_C(2) * PANEL_WIDTH * PANEL_ROWS <= 65535u);

static wg_picture picture;
static wg_vertex vertices[CLIP_VERTICES + 1]; /* an array of none is not C */
static uint8_t shades[CLIP_VERTICES + 1];
static int16_t normals[3 * CLIP_NORMALS + 1];
static int16_t weights[CLIP_BASES + 1];
static wg_bone bones[CLIP_BONES + 1];
static wg_picture_skins skins;
static uint32_t band[PANEL_HEAD / 4 + PANEL_WIDTH * PANEL_ROWS];
static int32_t seen[CLIP_CHANNELS]; /* by the picture that is being made */
static wg_rect dirty, rect;         /* what is to be sent, and the band of it that is next */
static enum { IDLE, POSING, DRAWING } stage;
static bool shown; /* the clip has a view */

int screen_start(const wg_file *file)
{
    const wg_picture_memory memory = {vertices, shades, CLIP_NORMALS ? normals : NULL, weights};
    const wg_size size = {PANEL_WIDTH, PANEL_HEIGHT};
    int error = wg_open_shapes(file);
    if (error == 0 && (CLIP_SKINS || CLIP_PAINTS)) {
        error = wg_open_skins(file);
    }
    shown = error == 0 && file->section[WG_SECTION_VIEWS].count > 0;
    if (shown) {
        wg_picture_init(&picture, file, size, &memory);
        if (CLIP_SKINS || CLIP_PAINTS) { /* what a clip has not is not linked */
            skins.bones = bones;
            wg_picture_paint(&picture, CLIP_SKINS ? &skins : NULL);
        }
        panel_start();
    }
    return error;
}

static void begin(const int32_t *values)
{
    memcpy(seen, values, sizeof seen);
    wg_picture_begin(&picture, seen);
    stage = POSING;
}

void screen_frame(const int32_t *values)
{
    if (!shown) {
        return;
    }
    panel_frame();
    if (stage == IDLE) {
        begin(values);
    }
}

/* The band that begins where the last one ended; none is left: the picture is done. */
static void next_band(void)
{
    uint16_t rows = (uint16_t)(dirty.y1 - rect.y1);
    rect.y0 = rect.y1;
    rect.y1 = (uint16_t)(rect.y0 + (rows < PANEL_ROWS ? rows : PANEL_ROWS));
    stage = rect.x0 < rect.x1 && rows > 0 ? DRAWING : IDLE;
}

static bool step(void)
{
    return CLIP_SKINS ? wg_picture_step_skinned(&picture) : wg_picture_step(&picture);
}

bool screen_work(void)
{
    const wg_size align = {PANEL_ALIGN_X, PANEL_ALIGN_Y};
    if (stage == POSING && !step()) {
        dirty = wg_picture_dirty(&picture, align);
        rect = dirty;
        rect.y1 = dirty.y0;
        next_band();
    } else if (stage == DRAWING) {
        wg_picture_band(&picture, rect, band + PANEL_HEAD / 4);
        panel_draw(&picture, rect, band + PANEL_HEAD / 4);
        next_band();
    }
    return stage != IDLE;
}

void screen_finish(const int32_t *values)
{
    if (shown) {
        while (screen_work()) { /* once every slice of a picture */
        }
        begin(values);
        while (screen_work()) {
        }
    }
}
