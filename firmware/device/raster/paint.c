/* Which parts are painted, and with what.
 * Source: own; SPEC 4.23.
 * SPDX-License-Identifier: MIT */
#include "paint.h"

#include <stddef.h>

#include "clip.h"
#include "fix.h"

const uint8_t *wg_paint_of(const wg_file *file, uint8_t paints, uint16_t part)
{
    const uint8_t *paint = file->section[WG_SECTION_PAINTS].at;
    for (; paints > 0; paints--, paint += WG_PAINT_BYTES) {
        if (wg_rd16(paint + WG_PAINT_PART) == part) {
            return paint;
        }
    }
    return NULL;
}

void wg_texture_set(wg_texture *texture, const wg_file *file, const uint8_t *paint, uint16_t shape)
{
    const uint8_t *data = file->section[WG_SECTION_DATA].at;
    const uint8_t *record = wg_record(file, WG_SECTION_SHAPES, shape, WG_SHAPE_BYTES);
    texture->texels = data + wg_rd32(paint + WG_PAINT_TEXELS);
    texture->rest = data + wg_rd32(record + WG_SHAPE_REST);
    texture->step = (int32_t)wg_rd32(paint + WG_PAINT_STEP);
    texture->corner[0] = (int32_t)wg_rd32(paint + WG_PAINT_CORNER) >> 6;
    texture->corner[1] = (int32_t)wg_rd32(paint + WG_PAINT_CORNER + 4) >> 6;
    texture->width = wg_rd16(paint + WG_PAINT_WIDTH);
    texture->height = wg_rd16(paint + WG_PAINT_HEIGHT);
}

void wg_texture_at(const wg_texture *texture, uint16_t vertex, int32_t *texel)
{
    const uint8_t *rest = texture->rest + 6u * (uint32_t)vertex;
    int16_t x = (int16_t)wg_rd16(rest), y = (int16_t)wg_rd16(rest + 2);
    const int32_t at[2] = {fix_add(texture->corner[0], fix_mulq(texture->step, x)),
                           fix_sub(texture->corner[1], fix_mulq(texture->step, y))};
    for (unsigned k = 0; k < 2; k++) {
        texel[k] = fix_clamp(at[k], -WG_TEXEL_LIMIT, WG_TEXEL_LIMIT);
    }
}
