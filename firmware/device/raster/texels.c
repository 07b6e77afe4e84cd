/* Triangles with a picture on them, pixel by pixel.
 * Source: own.
 * SPDX-License-Identifier: MIT */
#include "draw.h"
#include "fix.h"

/* The texel that a place lies in, among those that the corners do. */
static uint32_t texel_of(const wg_fill *f, unsigned which, uint32_t place)
{
    return (uint32_t)fix_clamp((int32_t)place >> 20, f->low[which], f->high[which]);
}

/* One row. */
static void fill_row(const wg_fill *f, const wg_texture *texture, uint32_t *pixel,
                     uint_fast16_t count)
{
    uint32_t at[WG_SLOPES];
    bool inside = false;
    for (unsigned i = 0; i < WG_SLOPES; i++) {
        at[i] = f->slope[i].at;
    }
    for (; count > 0; count--, pixel++) {
        if ((int32_t)(at[0] | at[1] | at[2]) >= 0) {
            uint32_t row = texel_of(f, 2, at[5]) * texture->width;
            uint8_t texel = wg_rd8(texture->texels + row + texel_of(f, 1, at[4]));
            uint32_t word = wg_near(f, at[3]) << 16 | (uint32_t)texel << 8 | f->part;
            if (texel > 0 && word > *pixel) {
                *pixel = word;
            }
            inside = true;
        } else if (inside) {
            return;
        }
        for (unsigned i = 0; i < WG_SLOPES; i++) {
            at[i] += f->slope[i].column;
        }
    }
}

void wg_fill_texels(const wg_canvas *canvas, wg_fill *fill)
{
    uint_fast16_t width = (uint_fast16_t)(canvas->rect.x1 - canvas->rect.x0);
    uint_fast16_t count = (uint_fast16_t)(fill->box.x1 - fill->box.x0);
    uint32_t *pixel = wg_canvas_pixel(canvas, fill->box.x0, fill->box.y0);
    for (uint_fast16_t y = fill->box.y0; y < fill->box.y1; y++, pixel += width) {
        fill_row(fill, canvas->texture, pixel, count);
        for (unsigned i = 0; i < WG_SLOPES; i++) {
            fill->slope[i].at += fill->slope[i].row;
        }
    }
}
