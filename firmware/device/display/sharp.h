/* Sharp Memory LCD: one bit a pixel, reflecting, on SPI; its memory is the glass and is written in
 * whole lines. LS013B7DH03 (128 x 128), LS013B7DH05 (144 x 168), LS027B7DH01 (400 x 240) and others
 * of up to 255 lines.
 * Source: Sharp application note "Memory LCD Programming"; LS027B7DH01 specification, 6-5. Bits go
 * out in the order of the figures there, the upper one of a byte first, and so does a line's number,
 * which the panel takes the lowest bit first.
 *
 * Its chip select is active high, and it has no data/command line. The clock may be 1.1 MHz
 * (LS013B7DH03) or 2 MHz. VCOM, bit M1 of every command, has to change once in WG_SHARP_VCOM_MS,
 * drawn or not: else the liquid crystal sees a direct voltage, fades and is harmed.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_SHARP_H
#define WIGGLY_SHARP_H

#include "display.h"

#ifdef __cplusplus
extern "C" {
#endif

/* 2 Hz: the panels take 0.5 to 10 Hz and more. */
#define WG_SHARP_VCOM_MS 250u

/* All white, and VCOM. Once, first. */
wg_step wg_sharp_clear(uint8_t vcom);

/* VCOM alone, for when there is nothing to draw. */
wg_step wg_sharp_vcom(uint8_t vcom);

/* The bytes of lines rect.y0 to y1 - 1 in one transfer.
 *   rect     x0 = 0, x1 the panel's width, which is a multiple of 8
 *   bytes    in: what wg_pixels_lines made of it; out: the transfer, WG_SHARP_BYTES longer
 *   returns  how many bytes */
uint16_t wg_sharp_lines(wg_rect rect, uint8_t vcom, uint8_t *bytes);

#define WG_SHARP_BYTES(lines) (2u + 2u * (lines))

#ifdef __cplusplus
}
#endif
#endif
