/* Displays with MIPI's command set, 16 bits a pixel, on SPI: Sitronix ST7789, Ilitek ILI9341.
 * Source: ST7789V data sheet V1.0, section 9.1; ILI9341 data sheet V1.11, section 8.2. Voltages and
 * gamma curves stay as the glass's maker has stored them in the chip.
 * A step's first byte goes with the data/command line low, its others and pixels with it high; the
 * chip may be released between any two bytes. Clock: 15 MHz (ST7789), 10 MHz (ILI9341).
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_MIPI_DCS_H
#define WIGGLY_MIPI_DCS_H

#include "display.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A glass in front of the chip's 240 x 320 pixels. */
typedef struct {
    uint8_t order;  /* 36h: bit 7 rows, 6 columns reversed, 5 exchanged, 3 blue first */
    uint8_t invert; /* 1: a glass that is bright at 0 */
    uint16_t x, y;  /* the chip's pixel in its upper left corner */
} wg_dcs;

#define WG_ST7789_240X240                                                                          \
    {                                                                                              \
        0x00, 1, 0, 0                                                                              \
    }
#define WG_ST7789_240X320                                                                          \
    {                                                                                              \
        0x00, 1, 0, 0                                                                              \
    }
#define WG_ST7789_135X240                                                                          \
    {                                                                                              \
        0x00, 1, 52, 40                                                                            \
    }
#define WG_ILI9341_240X320                                                                         \
    {                                                                                              \
        0x48, 0, 0, 0                                                                              \
    }
#define WG_ILI9341_320X240                                                                         \
    {                                                                                              \
        0x28, 0, 0, 0                                                                              \
    }

wg_step wg_dcs_setup(const wg_dcs *glass, uint8_t index);

/* Where the next pixels belong, in three steps; they fill it row by row. */
wg_step wg_dcs_window(const wg_dcs *glass, wg_rect rect, uint8_t index);

#ifdef __cplusplus
}
#endif
#endif
