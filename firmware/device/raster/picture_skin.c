/* Frames of shapes with skins.
 * Source: own.
 * SPDX-License-Identifier: MIT */
#include "picture_skin.h"

#include <stddef.h>

#include "clip.h"
#include "steps.h"

/* Whether a part of the shape shows a field. */
static bool has_field(const wg_picture *picture, uint16_t shape)
{
    const wg_file *file = picture->file;
    for (uint8_t i = 0; i < picture->paints; i++) {
        const uint8_t *paint = wg_record(file, WG_SECTION_PAINTS, i, WG_PAINT_BYTES);
        const uint8_t *part =
            wg_record(file, WG_SECTION_PARTS, wg_rd16(paint + WG_PAINT_PART), WG_PART_BYTES);
        if (wg_rd8(paint + WG_PAINT_KIND) == WG_PAINT_FIELD &&
            wg_rd16(part + WG_PART_SHAPE) == shape) {
            return true;
        }
    }
    return false;
}

/* A mesh that begins: its bones, if it has some. The camera comes after them. */
static void start_skin(wg_picture *picture)
{
    wg_picture_work *w = &picture->work;
    wg_picture_skins *s = picture->skins;
    uint8_t shape = (uint8_t)w->mesh.shape;
    w->skinned = s && wg_skin_init(&s->skin, picture->file, shape, s->bones);
    if (w->skinned) {
        wg_pose_set(&w->pose, w->values, picture->bases, NULL);
        wg_skin_set(&s->skin, w->values, &picture->view.camera);
        if (picture->memory.shades && has_field(picture, shape)) {
            picture->fields |= (uint16_t)(1u << shape);
        }
    }
}

static void step_skin(wg_picture *picture)
{
    const wg_picture_work *w = &picture->work;
    const wg_skin *skin = &picture->skins->skin;
    int32_t xyz[3 * WG_STEP_RANGE];
    uint16_t first = (uint16_t)w->vertex, count = wg_step_count(w);
    if ((unsigned)picture->fields >> w->mesh.shape & 1u) {
        wg_skin_brightness(skin, w->values, first, count,
                           picture->memory.shades + w->mesh.first + first);
    }
    wg_skin_vertices(skin, &w->pose, first, count, xyz);
    wg_step_positions(picture, xyz, count);
}

bool wg_picture_step_skinned(wg_picture *picture)
{
    wg_picture_work *w = &picture->work;
    if (w->stage == WG_STEP_POSITIONS) {
        if (w->vertex == 0) {
            start_skin(picture);
        }
        if (w->skinned) {
            step_skin(picture);
            return w->stage != WG_STEP_DONE;
        }
    }
    return wg_picture_step(picture);
}

void wg_picture_set_skinned(wg_picture *picture, const int32_t *values)
{
    wg_picture_begin(picture, values);
    while (wg_picture_step_skinned(picture)) { /* once every 32 vertices or triangles */
    }
}
