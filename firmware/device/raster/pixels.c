/* Pixels to a panel's bytes.
 * Source: ordered dither: B. E. Bayer, ICC 1973.
 * SPDX-License-Identifier: MIT */
#include "pixels.h"

#include "clip.h"

/* The colour of the part that the last pixel had: neighbours mostly share it. */
typedef struct {
    const wg_picture *picture;
    uint8_t rgb[3], grey;
    uint8_t part; /* + 1, or 0 for the background */
} paint;

static void pick(paint *p, uint8_t part)
{
    const wg_file *file = p->picture->file;
    const uint8_t *at =
        part > 0 ? wg_record(file, WG_SECTION_PARTS, part - 1u, WG_PART_BYTES) + WG_PART_COLOUR
                 : wg_record(file, WG_SECTION_VIEWS, p->picture->index, WG_VIEW_BYTES) +
                       WG_VIEW_BACKGROUND;
    p->part = part;
    for (unsigned i = 0; i < 3; i++) {
        p->rgb[i] = wg_rd8(at + i);
    }
    /* 77 + 150 + 29 = 256: at most 255. */
    p->grey = (uint8_t)((77u * p->rgb[0] + 150u * p->rgb[1] + 29u * p->rgb[2]) >> 8);
}

static void paint_set(paint *p, const wg_picture *picture)
{
    p->picture = picture;
    pick(p, 0);
}

/* What a pixel's colour is multiplied by, over 256: all of it for 255, and for the background. */
static uint16_t brightness(paint *p, uint32_t pixel)
{
    uint8_t part = WG_PIXEL_PART(pixel), shade = WG_PIXEL_SHADE(pixel);
    if (part != p->part) {
        pick(p, part);
    }
    return part > 0 ? (uint16_t)(shade + (shade >> 7)) : 256;
}

static uint8_t grey_of(paint *p, uint32_t pixel)
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
static uint8_t dot(paint *p, uint32_t pixel, uint16_t x, uint16_t y)
{
    return grey_of(p, pixel) >= 4u * bayer(x, y) + 2u;
}

uint32_t wg_pixels_pages(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out)
{
    uint16_t width = (uint16_t)(rect.x1 - rect.x0);
    uint8_t *to = out;
    paint p;
    paint_set(&p, picture);
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
    paint p;
    paint_set(&p, picture);
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
static uint8_t level(paint *p, uint32_t pixel)
{
    return (uint8_t)((uint32_t)(grey_of(p, pixel) + 8u) * 241u >> 12);
}

uint32_t wg_pixels_grey4(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out)
{
    uint32_t bytes = (uint32_t)(rect.x1 - rect.x0) / 2u * (uint32_t)(rect.y1 - rect.y0);
    const uint8_t *end = out + bytes;
    paint p;
    paint_set(&p, picture);
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
    paint p;
    paint_set(&p, picture);
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
    paint p;
    paint_set(&p, picture);
    while (out < end) {
        uint32_t lit = brightness(&p, *pixels++);
        for (unsigned i = 0; i < 3; i++) {
            *out++ = (uint8_t)(p.rgb[i] * lit >> 8);
        }
    }
    return bytes;
}
