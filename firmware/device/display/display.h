/* What the drivers of displays share: a step, the bytes that set a display up or that say where the
 * next pixels belong. A driver makes bytes and sends nothing; firmware/panel/<name>/ sends them.
 *
 *   for (i = 0; (step = wg_ssd0323_setup(i)).count > 0; i++)
 *       send step.bytes as a command, wait step.wait_ms;
 *   for (each band of picture.h) {
 *       step = wg_ssd0323_window(band);                 // send as a command
 *       count = wg_pixels_grey4(picture, band, pixels, bytes);      // send as data
 *   }
 *
 * | driver       | displays                  | pixels.h        | a window is on multiples of    |
 * |--------------|---------------------------|-----------------|--------------------------------|
 * | ssd1306.h    | SSD1306, SSD0303          | wg_pixels_pages | 1 column, 8 rows; one page each|
 * | ssd0323.h    | SSD0323                   | wg_pixels_grey4 | 2 columns                      |
 * | mipi_dcs.h   | ST7789, ILI9341           | wg_pixels_rgb565| nothing                        |
 * | sharp.h      | Sharp Memory LCD          | wg_pixels_lines | whole lines                    |
 *
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_DISPLAY_H
#define WIGGLY_DISPLAY_H

#include "raster.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WG_STEP_BYTES 9u

typedef struct {
    uint8_t count;   /* 0: there is no such step */
    uint8_t wait_ms; /* before anything else is sent */
    uint8_t bytes[WG_STEP_BYTES];
} wg_step;

#define WG_STEP_ROW (2u + WG_STEP_BYTES) /* a step in a constant table: its fields in order */

/* Step `index` of `count` rows in a WG_TABLE; behind them an empty one. */
wg_step wg_step_read(const uint8_t (*table)[WG_STEP_ROW], uint8_t count, uint8_t index);

#ifdef __cplusplus
}
#endif
#endif
