/* What any clip with shapes must survive as pictures: every view, shading and choice of memory, tiny
 * and narrow pictures, rectangles of any place and size, and every way to pack their pixels. Memory is
 * of exactly the size that picture.h asks for.
 * SPDX-License-Identifier: MIT */
#ifndef EXERCISE_PICTURE_H
#define EXERCISE_PICTURE_H

#include "exercise_base.h"
#include "picture_skin.h"
#include "pixels.h"

#define EXERCISE_CORNERS  60000u /* clips with more of them would take seconds: not drawn */
#define EXERCISE_FRAMES   6u
#define EXERCISE_PICTURES 4u

/* On multiples of 8, which all packers take. */
static const wg_size EXERCISE_SIZES[] = {{24, 16}, {8, 400}, {400, 8}, {56, 40}, {8, 8}, {800, 8}};
#define EXERCISE_SIZE_COUNT ((uint32_t)(sizeof EXERCISE_SIZES / sizeof *EXERCISE_SIZES))

typedef struct {
    wg_picture picture;
    wg_picture_memory memory;
    wg_picture_skins skins;
    int16_t weights[WG_BASES_MAX];
    uint32_t *pixels, *before; /* this frame's and the last one's */
    uint32_t area;
} exercise_screen;

static const uint8_t *exercise_part(const wg_file *file, uint32_t part)
{
    return file->section[WG_SECTION_PARTS].at + part * WG_PART_BYTES;
}

/* Vertices of every shape that a part has as positions, or 0: nothing to draw, or too much. */
static uint32_t exercise_vertex_count(const wg_file *file)
{
    uint32_t vertices = 0, corners = 0, counted = 0;
    for (uint32_t i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
        const uint8_t *part = exercise_part(file, i);
        uint32_t shape = build_get(part + WG_PART_SHAPE, 2);
        const uint8_t *r = file->section[WG_SECTION_SHAPES].at + shape * WG_SHAPE_BYTES;
        corners += 3u * build_get(part + WG_PART_TRIANGLES, 2);
        if (!(counted >> shape & 1u)) {
            counted |= 1u << shape;
            vertices += build_get(r + WG_SHAPE_VERTICES, 2);
            corners += build_get(r + WG_SHAPE_BLOCK_COUNT, 2);
        }
    }
    return file->section[WG_SECTION_VIEWS].count > 0 && vertices + corners < EXERCISE_CORNERS
               ? vertices
               : 0;
}

/* Of the skin that has most: CLIP_BONES. */
static uint32_t exercise_bone_count(const wg_file *file)
{
    const uint8_t *r = file->section[WG_SECTION_SKINS].at;
    uint32_t most = 0;
    for (uint32_t i = 0; i < file->section[WG_SECTION_SKINS].count; i++, r += WG_SKIN_BYTES) {
        uint32_t count = build_get(r + WG_SKIN_BONE_COUNT, 2);
        most = count > most ? count : most;
    }
    return most;
}

/* ---- bands and packers ----------------------------------------------------------------------- */

static uint32_t exercise_area(wg_rect r)
{
    return (uint32_t)(r.x1 - r.x0) * (uint32_t)(r.y1 - r.y0);
}

/* A pixel of the whole picture as it appears in a rectangle's band. */
static uint32_t exercise_place(const exercise_screen *s, wg_rect r, uint32_t i)
{
    uint32_t width = (uint32_t)(r.x1 - r.x0);
    return (r.y0 + i / width) * s->picture.size.width + r.x0 + i % width;
}

static void exercise_rectangle(const exercise_screen *s, uint32_t *state)
{
    wg_rect r;
    r.x0 = (uint16_t)(exercise_next(state) % s->picture.size.width);
    r.y0 = (uint16_t)(exercise_next(state) % s->picture.size.height);
    r.x1 = (uint16_t)(r.x0 + 1u + exercise_next(state) % (s->picture.size.width - r.x0));
    r.y1 = (uint16_t)(r.y0 + 1u + exercise_next(state) % (s->picture.size.height - r.y0));
    uint32_t area = exercise_area(r), *band = malloc(area * sizeof *band);
    wg_picture_band(&s->picture, r, band);
    for (uint32_t i = 0; i < area; i++) {
        must(band[i] == s->pixels[exercise_place(s, r, i)]);
    }
    free(band);
}

/* Into memory of its own, and in place: the same bytes, as many as there are bits for. */
static void exercise_packer(const exercise_screen *s, wg_rect r, unsigned kind)
{
    static const uint8_t BITS[] = {1, 1, 4, 16, 24};
    static uint32_t (*const PACK[])(const wg_picture *, wg_rect, const uint32_t *, uint8_t *) = {
        wg_pixels_pages, wg_pixels_lines, wg_pixels_grey4, wg_pixels_rgb565, wg_pixels_rgb888};
    uint32_t bytes = s->area * BITS[kind] / 8u;
    uint8_t *apart = malloc(bytes);
    uint32_t *band = malloc(s->area * sizeof *band);
    memcpy(band, s->pixels, s->area * sizeof *band);
    must(PACK[kind](&s->picture, r, band, apart) == bytes);
    must(PACK[kind](&s->picture, r, band, (uint8_t *)band) == bytes);
    must(memcmp(apart, band, bytes) == 0);
    free(band);
    free(apart);
}

/* ---- frames ---------------------------------------------------------------------------------- */

static void exercise_pixels(const exercise_screen *s)
{
    for (uint32_t i = 0; i < s->area; i++) {
        uint32_t p = s->pixels[i];
        must(WG_PIXEL_PART(p) <= s->picture.file->section[WG_SECTION_PARTS].count);
        must(p == 0 || WG_PIXEL_NEAR(p) > 0);
    }
}

/* Outside what may have changed, both frames are background. */
static void exercise_dirty(const exercise_screen *s, uint32_t *state)
{
    const wg_size align = {(uint16_t)(exercise_next(state) % 12u),
                           (uint16_t)(exercise_next(state) % 12u)};
    wg_rect r = wg_picture_dirty(&s->picture, align);
    wg_size size = s->picture.size;
    must(r.x0 <= r.x1 && r.y0 <= r.y1 && r.x1 <= size.width && r.y1 <= size.height);
    must(align.width < 2 ||
         (r.x0 % align.width == 0 && (r.x1 % align.width == 0 || r.x1 == size.width)));
    for (uint32_t i = 0; i < s->area; i++) {
        uint32_t x = i % size.width, y = i / size.width;
        int in = x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1;
        must(in || ((s->pixels[i] | s->before[i]) & 255u) == 0);
    }
}

static void exercise_frame(exercise_screen *s, const int32_t *values, uint32_t *state)
{
    const wg_rect all = {0, 0, s->picture.size.width, s->picture.size.height};
    uint32_t *swap = s->before;
    s->before = s->pixels;
    s->pixels = swap;
    wg_picture_set_skinned(&s->picture, values);
    wg_picture_band(&s->picture, all, s->pixels);
    exercise_pixels(s);
    exercise_dirty(s, state);
    for (unsigned n = 0; n < 3; n++) {
        exercise_rectangle(s, state);
    }
    exercise_packer(s, all, exercise_next(state) % 5u);
}

/* Values of all sizes and both signs, 2^29 at the most, as wg_player_sample gives them; then some of
 * them change, so that frames resemble each other; then what the first clip shows. */
static void exercise_values(const wg_file *file, unsigned frame, int32_t *values, uint32_t *state)
{
    if (frame + 2u >= EXERCISE_FRAMES) {
        wg_clip_sample(file, 0, exercise_number(state), values, NULL);
        return;
    }
    for (unsigned c = 0; c < file->section[WG_SECTION_CHANNELS].count; c++) {
        int32_t v = (int32_t)(exercise_number(state) % ((1u << 29) + 1u));
        if (frame == 0) {
            values[c] = exercise_next(state) & 1u ? 1 << 29 : -(1 << 29);
        } else if (frame < 3 || exercise_next(state) % 4u == 0) {
            values[c] = exercise_next(state) & 1u ? v : -v;
        }
    }
}

static void exercise_screen_open(exercise_screen *s, const wg_file *file, uint32_t vertices,
                                 uint32_t *state)
{
    wg_size size = EXERCISE_SIZES[exercise_next(state) % EXERCISE_SIZE_COUNT];
    s->area = (uint32_t)size.width * size.height;
    s->pixels = calloc(s->area, sizeof *s->pixels);
    s->before = calloc(s->area, sizeof *s->before);
    s->memory.vertices = malloc(vertices * sizeof *s->memory.vertices);
    s->memory.shades = exercise_next(state) % 4u ? malloc(vertices) : NULL;
    s->memory.normals =
        exercise_next(state) % 2u ? malloc(3u * vertices * sizeof *s->memory.normals) : NULL;
    s->memory.weights = s->weights;
    s->skins.bones = malloc(exercise_bone_count(file) * sizeof *s->skins.bones);
    memset(&s->picture, 0xa5, sizeof s->picture); /* init must not need cleared memory */
    wg_picture_init(&s->picture, file, size, &s->memory);
    if (wg_open_skins(file) == 0) { /* otherwise they are not looked at */
        wg_picture_paint(&s->picture, exercise_next(state) % 4u ? &s->skins : NULL);
    }
    wg_picture_look(&s->picture,
                    (uint8_t)(exercise_next(state) % file->section[WG_SECTION_VIEWS].count));
    s->picture.shading = (uint8_t)(exercise_next(state) % 3u);
    s->picture.normals_every = (uint8_t)(exercise_next(state) % 3u);
    s->picture.bases = (uint16_t)(exercise_next(state) % 70u);
}

static void exercise_screen_close(exercise_screen *s)
{
    free(s->skins.bones);
    free(s->memory.normals);
    free(s->memory.shades);
    free(s->memory.vertices);
    free(s->before);
    free(s->pixels);
}

static void exercise_pictures(const wg_file *file, uint32_t *state)
{
    uint32_t vertices = exercise_vertex_count(file);
    exercise_screen screen;
    for (unsigned n = 0; n < EXERCISE_PICTURES && vertices > 0; n++) {
        int32_t values[WG_CHANNELS_MAX];
        exercise_screen_open(&screen, file, vertices, state);
        for (unsigned frame = 0; frame < EXERCISE_FRAMES; frame++) {
            exercise_values(file, frame, values, state);
            exercise_frame(&screen, values, state);
        }
        exercise_screen_close(&screen);
    }
}

#endif
