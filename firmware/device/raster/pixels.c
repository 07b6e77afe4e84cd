/* Pixels to a panel's bytes.
 * Source: ordered dither: B. E. Bayer, ICC 1973.
 * SPDX-License-Identifier: MIT */
#include "pixels.h"

#include "clip.h"

/* The colour of a pixel: 0 background, otherwise that of a part, as bytes of the clip. */
typedef struct {
    uint8_t red, green, blue;
} colour;

/* c s / 255 for s = 0 and 255, at most 1 below it between. */
static uint8_t dimmed(uint8_t c, uint8_t s)
{
    return (uint8_t)((uint16_t)c * (uint16_t)(s + (s >> 7)) >> 8);
}

static colour colour_of(const wg_picture *picture, uint32_t pixel)
{
    uint8_t part = WG_PIXEL_PART(pixel), shade = WG_PIXEL_SHADE(pixel);
    const uint8_t *at = wg_record(picture->file, WG_SECTION_VIEWS, picture->index, WG_VIEW_BYTES) +
                        WG_VIEW_BACKGROUND;
    if (part > 0) {
        at = wg_record(picture->file, WG_SECTION_PARTS, part - 1u, WG_PART_BYTES) + WG_PART_COLOUR;
    } else {
        shade = 255;
    }
    colour c = {dimmed(wg_rd8(at), shade), dimmed(wg_rd8(at + 1), shade),
                dimmed(wg_rd8(at + 2), shade)};
    return c;
}

static uint8_t grey_of(const wg_picture *picture, uint32_t pixel)
{
    colour c = colour_of(picture, pixel);
    /* 77 + 150 + 29 = 256: at most 255. */
    return (uint8_t)((77u * c.red + 150u * c.green + 29u * c.blue) >> 8);
}

/* Bayer's matrix, 0..63: the bits of x ^ y and y interleaved, the lowest ones first. */
static uint8_t bayer(uint16_t x, uint16_t y)
{
    uint8_t a = (uint8_t)(x ^ y), b = (uint8_t)y;
    return (uint8_t)((a & 1u) << 5 | (b & 1u) << 4 | (a & 2u) << 2 | (b & 2u) << 1 |
                     (a & 4u) >> 1 | (b & 4u) >> 2);
}

/* 1 where a dot is lit: for (grey + 2) / 4 of the 64 places, half a place off at the most. */
static uint8_t dot(const wg_picture *picture, uint32_t pixel, uint16_t x, uint16_t y)
{
    return grey_of(picture, pixel) >= 4u * bayer(x, y) + 2u;
}

uint32_t wg_pixels_pages(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out)
{
    uint16_t width = (uint16_t)(rect.x1 - rect.x0);
    uint8_t *to = out;
    for (uint16_t y = rect.y0; y < rect.y1; y = (uint16_t)(y + 8), pixels += 8u * width) {
        for (uint16_t x = 0; x < width; x++) {
            uint8_t byte = 0;
            for (unsigned i = 0; i < 8; i++) {
                byte |= (uint8_t)(dot(picture, pixels[(uint32_t)i * width + x],
                                      (uint16_t)(rect.x0 + x), (uint16_t)(y + i))
                                  << i);
            }
            *to++ = byte;
        }
    }
    return (uint32_t)(to - out);
}

uint32_t wg_pixels_lines(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out)
{
    uint8_t *to = out;
    for (uint16_t y = rect.y0; y < rect.y1; y++) {
        for (uint16_t x = rect.x0; x < rect.x1; x = (uint16_t)(x + 8)) {
            uint8_t byte = 0;
            for (unsigned i = 0; i < 8; i++) {
                byte = (uint8_t)(byte << 1 | dot(picture, *pixels++, (uint16_t)(x + i), y));
            }
            *to++ = byte;
        }
    }
    return (uint32_t)(to - out);
}

/* round(15 grey / 255) = floor((grey + 8) / 17); 241/4096 is 1/17 closely enough up to 263. */
static uint8_t level(const wg_picture *picture, uint32_t pixel)
{
    return (uint8_t)((uint32_t)(grey_of(picture, pixel) + 8u) * 241u >> 12);
}

uint32_t wg_pixels_grey4(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out)
{
    uint32_t bytes = (uint32_t)(rect.x1 - rect.x0) / 2u * (uint32_t)(rect.y1 - rect.y0);
    for (uint32_t i = 0; i < bytes; i++) {
        uint8_t left = level(picture, pixels[2u * i]);
        out[i] = (uint8_t)(left << 4 | level(picture, pixels[2u * i + 1u]));
    }
    return bytes;
}

uint32_t wg_pixels_rgb565(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                          uint8_t *out)
{
    uint32_t count = (uint32_t)(rect.x1 - rect.x0) * (uint32_t)(rect.y1 - rect.y0);
    for (uint32_t i = 0; i < count; i++) {
        colour c = colour_of(picture, pixels[i]);
        out[2u * i] = (uint8_t)((c.red & 0xf8u) | c.green >> 5);
        out[2u * i + 1u] = (uint8_t)((c.green & 0x1cu) << 3 | c.blue >> 3);
    }
    return 2u * count;
}
