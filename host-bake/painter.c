/* A clip's shapes as pictures on the host.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "painter.h"
#include "command.h"
#include "record.h"
#include "stage.h"

#include <stdlib.h>
#include <string.h>

/* ---- names ----------------------------------------------------------------------------------- */

static const panel PANELS[] = {
    {"plain", PANEL_RGB, {0, 0}},        {"ssd0323", PANEL_GREY4, {128, 64}},
    {"ssd1306", PANEL_PAGES, {128, 64}}, {"ssd0303", PANEL_PAGES, {96, 16}},
    {"st7789", PANEL_565, {240, 240}},   {"ili9341", PANEL_565, {320, 240}},
    {"sharp", PANEL_LINES, {400, 240}},
};
#define PANELS_COUNT ((int)(sizeof PANELS / sizeof *PANELS))

int panel_count(void)
{
    return PANELS_COUNT;
}

const panel *panel_at(int index)
{
    return &PANELS[index];
}

int panel_find(const char *name, bake_error *error)
{
    char list[128] = "";
    for (int i = 0; i < PANELS_COUNT; i++) {
        if (strcmp(name, PANELS[i].name) == 0) {
            return i;
        }
        strcat(strcat(list, i ? ", " : ""), PANELS[i].name);
    }
    return bake_fail(error, "--panel takes one of %s, not '%s'", list, name);
}

static const char *const SHADINGS[] = {"wire", "flat", "smooth"};

int shading_find(const char *name, bake_error *error)
{
    for (int i = WG_SHADING_WIRE; i <= (int)WG_SHADING_SMOOTH; i++) {
        if (strcmp(name, SHADINGS[i]) == 0) {
            return i;
        }
    }
    return bake_fail(error, "--shading takes wire, flat or smooth, not '%s'", name);
}

const char *shading_name(int shading)
{
    return SHADINGS[shading];
}

/* ---- what a clip has ------------------------------------------------------------------------- */

int view_count(const wg_file *file)
{
    return file->section[WG_SECTION_VIEWS].count;
}

int bases_most(const wg_file *file)
{
    int most = 0;
    for (int i = 0; i < file->section[WG_SECTION_SHAPES].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_SHAPES, i, WG_SHAPE_BYTES);
        int bases = get16(r + WG_SHAPE_BASIS_COUNT);
        most = bases > most ? bases : most;
    }
    return most;
}

/* Of the skin that has most. */
static int bones_most(const wg_file *file)
{
    int most = 0;
    for (int i = 0; i < file->section[WG_SECTION_SKINS].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_SKINS, i, WG_SKIN_BYTES);
        int bones = get16(r + WG_SKIN_BONE_COUNT);
        most = bones > most ? bones : most;
    }
    return most;
}

int painter_can(const wg_file *file)
{
    return file->section[WG_SECTION_PARTS].count > 0 && view_count(file) > 0;
}

/* Vertices of every shape that a part has as positions: as picture.h wants them. */
static size_t vertex_count(const wg_file *file)
{
    size_t sum = 0;
    uint32_t counted = 0; /* a bit a shape */
    for (int i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
        int shape = get16(record(file, WG_SECTION_PARTS, i, WG_PART_BYTES) + WG_PART_SHAPE);
        if (!(counted >> shape & 1)) {
            counted |= 1u << shape;
            sum += (size_t)get16(record(file, WG_SECTION_SHAPES, shape, WG_SHAPE_BYTES) +
                                 WG_SHAPE_VERTICES);
        }
    }
    return sum;
}

/* ---- painting -------------------------------------------------------------------------------- */

int painter_open(painter *p, const wg_file *file, const panel *on, wg_size size, bake_error *error)
{
    memset(p, 0, sizeof *p);
    if (stage_open(file, error) < 0) {
        return -1;
    }
    if (on->size.width > 0) {
        size = on->size;
    }
    size_t count = vertex_count(file), area = (size_t)size.width * size.height;
    p->panel = on;
    p->look = PAINTER_LOOK;
    p->memory.vertices = bake_alloc(count, sizeof *p->memory.vertices);
    p->memory.shades = bake_alloc(count, 1);
    p->memory.normals = bake_alloc(3 * count, sizeof *p->memory.normals); /* as CLIP_NORMALS */
    p->memory.weights = bake_alloc((size_t)bases_most(file) + 1, sizeof *p->memory.weights);
    p->skins = bake_alloc(1, sizeof *p->skins);
    p->skins->bones = bake_alloc((size_t)bones_most(file) + 1, sizeof *p->skins->bones);
    p->pixels = bake_alloc(area, sizeof *p->pixels);
    p->packed = bake_alloc(area, 2);
    p->image = image_make(size.width, size.height);
    wg_picture_init(&p->picture, file, size, &p->memory);
    wg_picture_paint(&p->picture, p->skins);
    return 0;
}

void painter_close(painter *p)
{
    if (p->skins != NULL) {
        free(p->skins->bones);
    }
    free(p->skins);
    free(p->memory.vertices);
    free(p->memory.shades);
    free(p->memory.normals);
    free(p->memory.weights);
    free(p->pixels);
    free(p->packed);
    image_free(&p->image);
    memset(p, 0, sizeof *p);
}

static void grey(uint8_t *to, int value)
{
    to[0] = to[1] = to[2] = (uint8_t)value;
}

/* What the panel makes of its bytes, pixel (x, y) of w x h. */
static void show_pixel(panel_pixels kind, const uint8_t *packed, const int at[3], uint8_t *to)
{
    int x = at[0], y = at[1], w = at[2];
    int place = y * w + x, value;
    switch (kind) {
    case PANEL_GREY4:
        value = packed[place / 2] >> (x % 2 ? 0 : 4) & 15;
        grey(to, 17 * value);
        break;
    case PANEL_PAGES:
        grey(to, packed[y / 8 * w + x] >> (y % 8) & 1 ? 255 : 0);
        break;
    case PANEL_LINES:
        grey(to, packed[place / 8] >> (7 - x % 8) & 1 ? 255 : 0);
        break;
    default:
        value = packed[2 * place] << 8 | packed[2 * place + 1];
        to[0] = (uint8_t)((value >> 11) << 3 | value >> 13);
        to[1] = (uint8_t)((value >> 5 & 63) << 2 | (value >> 9 & 3));
        to[2] = (uint8_t)((value & 31) << 3 | (value >> 2 & 7));
    }
}

static void paint_panel(painter *p, wg_rect all)
{
    static uint32_t (*const PACK[])(const wg_picture *, wg_rect, const uint32_t *, uint8_t *) = {
        [PANEL_GREY4] = wg_pixels_grey4,
        [PANEL_PAGES] = wg_pixels_pages,
        [PANEL_LINES] = wg_pixels_lines,
        [PANEL_565] = wg_pixels_rgb565,
    };
    PACK[p->panel->pixels](&p->picture, all, p->pixels, p->packed);
    for (int y = 0; y < all.y1; y++) {
        for (int x = 0; x < all.x1; x++) {
            const int at[3] = {x, y, all.x1};
            show_pixel(p->panel->pixels, p->packed, at, p->image.rgb + 3 * (y * all.x1 + x));
        }
    }
}

void painter_paint(painter *p, const int32_t *values, painter_look look)
{
    const wg_rect all = {0, 0, p->picture.size.width, p->picture.size.height};
    if (look.view != p->look.view || look.shading != p->look.shading) {
        wg_picture_look(&p->picture, (uint8_t)look.view);
    }
    if (look.shading >= 0) {
        p->picture.shading = (uint8_t)look.shading;
    }
    p->picture.bases = (uint16_t)look.bases;
    p->look = look;
    wg_picture_set_skinned(&p->picture, values);
    wg_picture_band(&p->picture, all, p->pixels);
    if (p->panel->pixels == PANEL_RGB) {
        wg_pixels_rgb888(&p->picture, all, p->pixels, p->image.rgb);
    } else {
        paint_panel(p, all);
    }
}
