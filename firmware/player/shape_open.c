/* Opening a clip's shapes, parts and views: the one place where they are checked (SPEC 4.13-4.17).
 * Source: own. Apart from open.c, so that a firmware without a display does not carry it.
 * SPDX-License-Identifier: MIT */
#include "open.h"

static uint16_t records(const wg_file *file, uint8_t kind)
{
    return file->section[kind].count;
}

static const uint8_t *shape_record(const wg_file *file, uint16_t shape)
{
    return wg_record(file, WG_SECTION_SHAPES, shape, WG_SHAPE_BYTES);
}

static bool is_affine(const wg_file *file, uint16_t channel)
{
    return channel == WG_ABSENT ||
           wg_is_range(channel, WG_AFFINE_CHANNELS, records(file, WG_SECTION_CHANNELS));
}

static bool is_shape(const wg_file *file, const uint8_t *r)
{
    uint16_t vertices = wg_rd16(r + WG_SHAPE_VERTICES), bases = wg_rd16(r + WG_SHAPE_BASIS_COUNT);
    int8_t frac = (int8_t)wg_rd8(r + WG_SHAPE_FRAC);
    return vertices > 0 && frac >= WG_SHAPE_FRAC_MIN && frac <= WG_SHAPE_FRAC_MAX &&
           bases <= WG_BASES_MAX &&
           wg_is_range(wg_rd16(r + WG_SHAPE_BASIS_FIRST), bases, records(file, WG_SECTION_BASES)) &&
           wg_is_range(wg_rd16(r + WG_SHAPE_BLOCK_FIRST), wg_rd16(r + WG_SHAPE_BLOCK_COUNT),
                       records(file, WG_SECTION_BLOCKS)) &&
           is_affine(file, wg_rd16(r + WG_SHAPE_AFFINE)) &&
           wg_is_data(file, wg_rd32(r + WG_SHAPE_REST), 6u * (uint32_t)vertices, 4) &&
           wg_is_small(wg_rd32(r + WG_SHAPE_ORIGIN)) &&
           wg_is_small(wg_rd32(r + WG_SHAPE_ORIGIN + 4)) &&
           wg_is_small(wg_rd32(r + WG_SHAPE_ORIGIN + 8));
}

static int check_bases(const wg_file *file)
{
    for (uint16_t i = 0; i < records(file, WG_SECTION_BASES); i++) {
        const uint8_t *r = wg_record(file, WG_SECTION_BASES, i, WG_BASIS_BYTES);
        uint8_t shift = wg_rd8(r + WG_BASIS_GAIN_SHIFT);
        if (wg_rd16(r + WG_BASIS_CHANNEL) >= records(file, WG_SECTION_CHANNELS) || shift == 0 ||
            shift > 15) {
            return WG_ERR_BASIS;
        }
    }
    return 0;
}

/* Bytes of a block's components: 8-bit pairs come in groups of two (SPEC 4.15). */
static uint32_t block_bytes(uint16_t count, uint8_t bits, bool pair)
{
    uint32_t components = 3u * (uint32_t)count;
    if (bits == 8) {
        return pair ? (components + 1u) / 2u * 4u : components;
    }
    return components * (pair ? 4u : 2u);
}

static bool is_block(const wg_file *file, const uint8_t *r, const uint8_t *shape)
{
    uint16_t bases = wg_rd16(shape + WG_SHAPE_BASIS_COUNT), b = wg_rd16(r + WG_BLOCK_B);
    uint16_t count = wg_rd16(r + WG_BLOCK_COUNT);
    uint8_t bits = wg_rd8(r + WG_BLOCK_BITS);
    return wg_rd16(r + WG_BLOCK_A) < bases && (b < bases || b == WG_ABSENT) && count > 0 &&
           wg_is_range(wg_rd16(r + WG_BLOCK_FIRST), count, wg_rd16(shape + WG_SHAPE_VERTICES)) &&
           (bits == 8 || bits == 16) &&
           wg_is_data(file, wg_rd32(r + WG_BLOCK_DATA), block_bytes(count, bits, b != WG_ABSENT),
                      4);
}

/* All records first, then the blocks: those of a shape lie inside its range. */
static int check_shapes(const wg_file *file)
{
    for (uint16_t i = 0; i < records(file, WG_SECTION_SHAPES); i++) {
        if (!is_shape(file, shape_record(file, i))) {
            return WG_ERR_SHAPE;
        }
    }
    return 0;
}

static int check_blocks(const wg_file *file)
{
    for (uint16_t i = 0; i < records(file, WG_SECTION_SHAPES); i++) {
        const uint8_t *shape = shape_record(file, i);
        uint32_t first = wg_rd16(shape + WG_SHAPE_BLOCK_FIRST);
        for (uint16_t j = 0; j < wg_rd16(shape + WG_SHAPE_BLOCK_COUNT); j++) {
            if (!is_block(file, wg_record(file, WG_SECTION_BLOCKS, first + j, WG_BLOCK_BYTES),
                          shape)) {
                return WG_ERR_BLOCK;
            }
        }
    }
    return 0;
}

/* Every corner is a vertex of the part's shape. */
static bool is_corners(const wg_file *file, const uint8_t *part, uint16_t vertices)
{
    const uint8_t *corner = file->section[WG_SECTION_DATA].at + wg_rd32(part + WG_PART_DATA);
    for (uint32_t left = 3u * (uint32_t)wg_rd16(part + WG_PART_TRIANGLES); left > 0; left--) {
        if (wg_rd16(corner) >= vertices) {
            return false;
        }
        corner += 2;
    }
    return true;
}

static bool is_part(const wg_file *file, const uint8_t *r)
{
    uint16_t shape = wg_rd16(r + WG_PART_SHAPE), normals = wg_rd16(r + WG_PART_NORMALS);
    uint16_t triangles = wg_rd16(r + WG_PART_TRIANGLES), shapes = records(file, WG_SECTION_SHAPES);
    if (shape >= shapes || (normals >= shapes && normals != WG_ABSENT)) {
        return false;
    }
    uint16_t vertices = wg_rd16(shape_record(file, shape) + WG_SHAPE_VERTICES);
    return (normals == WG_ABSENT ||
            wg_rd16(shape_record(file, normals) + WG_SHAPE_VERTICES) == vertices) &&
           triangles > 0 && wg_rd8(r + WG_PART_SIDES) <= 1 &&
           wg_is_data(file, wg_rd32(r + WG_PART_DATA), WG_TRIANGLE_BYTES * (uint32_t)triangles,
                      2) &&
           is_corners(file, r, vertices);
}

static int check_parts(const wg_file *file)
{
    for (uint16_t i = 0; i < records(file, WG_SECTION_PARTS); i++) {
        if (!is_part(file, wg_record(file, WG_SECTION_PARTS, i, WG_PART_BYTES))) {
            return WG_ERR_PART;
        }
    }
    return 0;
}

static int check_views(const wg_file *file)
{
    for (uint16_t i = 0; i < records(file, WG_SECTION_VIEWS); i++) {
        const uint8_t *r = wg_record(file, WG_SECTION_VIEWS, i, WG_VIEW_BYTES);
        bool good = wg_rd8(r + WG_VIEW_PROJECTION) <= WG_ORTHOGRAPHIC &&
                    wg_rd8(r + WG_VIEW_SHADING) <= WG_SHADING_SMOOTH;
        for (unsigned c = 0; c < WG_VIEW_CHANNELS; c++) {
            good =
                good && wg_rd16(r + WG_VIEW_CHANNEL + 2u * c) < records(file, WG_SECTION_CHANNELS);
        }
        if (!good) {
            return WG_ERR_VIEW;
        }
    }
    return 0;
}

int wg_open_shapes(const wg_file *file)
{
    int err = check_shapes(file);
    if (err == 0) {
        err = check_bases(file);
    }
    if (err == 0) {
        err = check_blocks(file);
    }
    if (err == 0) {
        err = check_parts(file);
    }
    return err == 0 ? check_views(file) : err;
}
