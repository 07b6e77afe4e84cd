/* Pixels to a panel's bytes.
 * Source: ordered dither: B. E. Bayer, ICC 1973.
 * SPDX-License-Identifier: MIT */
#include "pixels.h"

#include <stddef.h>

#include "clip.h"
#include "paint.h"

/* The colour of the last pixel: neighbours mostly share part and brightness. */
typedef struct {
    const wg_picture *picture;
    const uint8_t *palette; /* of the part if it is painted, or NULL */
    uint8_t rgb[3], grey;
    uint16_t seen; /* the last pixel's part and brightness */
    uint16_t lit;  /* what its colour is multiplied by, over 256 */
} ink;

static void dip(ink *p, const uint8_t *at)
{
    for (unsigned i = 0; i < 3; i++) {
        p->rgb[i] = wg_rd8(at + i);
    }
    /* 77 + 150 + 29 = 256: at most 255. */
    p->grey = (uint8_t)((77u * p->rgb[0] + 150u * p->rgb[1] + 29u * p->rgb[2]) >> 8);
}

/* The colour of a part, or its palette; 0: the background. */
static void pick(ink *p, uint8_t part)
{
    const wg_file *file = p->picture->file;
    const uint8_t *paint = NULL;
    p->palette = NULL;
    if (part == 0) {
        dip(p, wg_record(file, WG_SECTION_VIEWS, p->picture->index, WG_VIEW_BYTES) +
                   WG_VIEW_BACKGROUND);
        return;
    }
    if (p->picture->shading != WG_SHADING_WIRE) {
        paint = wg_paint_of(file, p->picture->paints, (uint16_t)(part - 1u));
    }
    if (paint) {
        p->palette = file->section[WG_SECTION_DATA].at + wg_rd32(paint + WG_PAINT_PALETTE);
    } else {
        dip(p, wg_record(file, WG_SECTION_PARTS, part - 1u, WG_PART_BYTES) + WG_PART_COLOUR);
    }
}

static void change(ink *p, uint32_t pixel)
{
    uint8_t part = WG_PIXEL_PART(pixel), shade = WG_PIXEL_SHADE(pixel);
    if (part != (uint8_t)p->seen) {
        pick(p, part);
    }
    p->seen = (uint16_t)pixel;
    p->lit = 256;
    if (p->palette) {
        dip(p, p->palette + 3u * shade);
    } else if (part > 0) {
        p->lit = (uint16_t)(shade + (shade >> 7));
    }
}

static void ink_set(ink *p, const wg_picture *picture)
{
    p->picture = picture;
    p->seen = 0;
    p->lit = 256;
    pick(p, 0);
}

/* All of the colour for a brightness of 255, for the background and for colours of a palette. */
static uint16_t brightness(ink *p, uint32_t pixel)
{
    if ((uint16_t)pixel != p->seen) {
        change(p, pixel);
    }
    return p->lit;
}

static uint8_t grey_of(ink *p, uint32_t pixel)
{
    uint16_t lit = brightness(p, pixel);
    return (uint8_t)((uint32_t)p->grey * lit >> 8);
}

/* Bayer's matrix, 0..63: the bits of x ^ y and y interleaved, the lowest ones first. */
static uint8_t bayer(uint16_t x, uint16_t y)
{
    unsigned a = x ^ y, b = y;
    return (uint8_t)((a & 1u) << 5 | (b & 1u) << 4 | (a & 2u) << 2 | (b & 2u) << 1 | (a & 4u) >> 1 |
                     (b & 4u) >> 2);
}

/* 1 where a dot is lit: in (grey + 2) / 4 of the 64 places, half a place off at the most. */
static uint8_t dot(ink *p, uint32_t pixel, uint16_t x, uint16_t y)
{
    return grey_of(p, pixel) >= 4u * bayer(x, y) + 2u;
}

uint32_t wg_pixels_pages(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out)
{
    uint16_t width = (uint16_t)(rect.x1 - rect.x0);
    uint8_t *to = out;
    ink p;
    ink_set(&p, picture);
    for (uint16_t y = rect.y0; y < rect.y1; y = (uint16_t)(y + 8), pixels += 8u * width) {
        for (uint16_t x = 0; x < width; x++) {
            unsigned byte = 0;
            for (unsigned i = 0; i < 8; i++) {
                uint32_t pixel = pixels[(uint32_t)i * width + x];
                byte |= (unsigned)dot(&p, pixel, (uint16_t)(rect.x0 + x), (uint16_t)(y + i)) << i;
            }
            *to++ = (uint8_t)byte;
        }
    }
    return (uint32_t)(to - out);
}

uint32_t wg_pixels_lines(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out)
{
    uint8_t *to = out;
    ink p;
    ink_set(&p, picture);
    for (uint16_t y = rect.y0; y < rect.y1; y++) {
        for (uint16_t x = rect.x0; x < rect.x1; x = (uint16_t)(x + 8)) {
            unsigned byte = 0;
            for (unsigned i = 0; i < 8; i++) {
                byte = byte << 1 | dot(&p, *pixels++, (uint16_t)(x + i), y);
            }
            *to++ = (uint8_t)byte;
        }
    }
    return (uint32_t)(to - out);
}

/* round(15 grey / 255) = floor((grey + 8) / 17); 241/4096 is 1/17 closely enough up to 263. */
static uint8_t level(ink *p, uint32_t pixel)
{
    return (uint8_t)((uint32_t)(grey_of(p, pixel) + 8u) * 241u >> 12);
}

uint32_t wg_pixels_grey4(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out)
{
    uint32_t bytes = (uint32_t)(rect.x1 - rect.x0) / 2u * (uint32_t)(rect.y1 - rect.y0);
    const uint8_t *end = out + bytes;
    ink p;
    ink_set(&p, picture);
    for (; out < end; pixels += 2) {
        uint8_t left = level(&p, pixels[0]);
        *out++ = (uint8_t)(left << 4 | level(&p, pixels[1]));
    }
    return bytes;
}

uint32_t wg_pixels_rgb565(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                          uint8_t *out)
{
    uint32_t bytes = 2u * (uint32_t)(rect.x1 - rect.x0) * (uint32_t)(rect.y1 - rect.y0);
    const uint8_t *end = out + bytes;
    ink p;
    ink_set(&p, picture);
    while (out < end) {
        uint32_t lit = brightness(&p, *pixels++);
        uint8_t green = (uint8_t)(p.rgb[1] * lit >> 8), blue = (uint8_t)(p.rgb[2] * lit >> 8);
        *out++ = (uint8_t)((p.rgb[0] * lit >> 8 & 0xf8u) | green >> 5);
        *out++ = (uint8_t)((green & 0x1cu) << 3 | blue >> 3);
    }
    return bytes;
}

uint32_t wg_pixels_rgb888(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                          uint8_t *out)
{
    uint32_t bytes = 3u * (uint32_t)(rect.x1 - rect.x0) * (uint32_t)(rect.y1 - rect.y0);
    const uint8_t *end = out + bytes;
    ink p;
    ink_set(&p, picture);
    while (out < end) {
        uint32_t lit = brightness(&p, *pixels++);
        for (unsigned i = 0; i < 3; i++) {
            *out++ = (uint8_t)(p.rgb[i] * lit >> 8);
        }
    }
    return bytes;
}
