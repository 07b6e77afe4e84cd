/* From a band of pixels to the bytes of a panel.
 *   pixels   what wg_picture_band wrote for `rect`
 *   out      the bytes; may be the same memory as `pixels`
 *   returns  how many bytes
 * A pixel of brightness s has (c (s + (s >> 7))) >> 8 of its part's red, green and blue c, or colour s
 * of its part's palette if it is painted (in a wireframe none is), or the view's background; the grey
 * of a colour is (77 red + 150 green + 29 blue) >> 8 and dimmed likewise.
 * Monochrome dithers with the 8 x 8 ordered matrix [Bayer], by the pixel's place in the picture: the
 * same dots in every rectangle.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_PIXELS_H
#define WIGGLY_PIXELS_H

#include "picture.h"

#ifdef __cplusplus
extern "C" {
#endif

/* 1 bit, a byte = 8 pixels below each other, the upper one in bit 0, column by column, page by page
 * (SSD1306, SSD0303); rect.y0 and y1 on multiples of 8. */
uint32_t wg_pixels_pages(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out);
/* 1 bit, a byte = 8 pixels beside each other, the left one in bit 7 (Sharp Memory LCD); rect.x0 and
 * x1 on multiples of 8. */
uint32_t wg_pixels_lines(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out);
/* 4 bits, a byte = 2 pixels, the left one in the upper half (SSD0323); rect.x0 and x1 even. */
uint32_t wg_pixels_grey4(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                         uint8_t *out);
/* 16 bits, high byte first (ST7789, ILI9341). */
uint32_t wg_pixels_rgb565(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                          uint8_t *out);
/* 24 bits: red, green, blue. */
uint32_t wg_pixels_rgb888(const wg_picture *picture, wg_rect rect, const uint32_t *pixels,
                          uint8_t *out);

#ifdef __cplusplus
}
#endif
#endif
