/* Solomon Systech SSD1306 and SSD0303: OLEDs of one bit a pixel, on I2C or SPI.
 * Source: SSD1306 data sheet Rev 1.5, sections 8.1.5 (I2C), 9, 10.1.3 (page addressing) and its
 * application note (charge pump); SSD0303 data sheet, with what the maker of the 96 x 16 glass sets.
 *
 * Both are addressed page by page, a page being 8 rows: the one way that both have, and on I2C the
 * address of a page and its pixels are a single write.
 *   SPI   every step with the data/command line low, pixels with it high
 *   I2C   wg_ssd1306_i2c(step), for pixels followed by WG_SSD1306_DATA and the pixels; 7-bit
 *         address 0x3c or 0x3d
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_SSD1306_H
#define WIGGLY_SSD1306_H

#include "display.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WG_SSD1306_ADDRESS 0x3cu /* 0x3d with the pin SA0 (D/C) high */
#define WG_SSD1306_DATA    0x40u /* the control byte before pixels */

typedef struct {
    uint8_t height;
    uint8_t com_pins; /* DAh: how the glass's rows are wired */
    uint8_t contrast;
} wg_ssd1306;

#define WG_SSD1306_128X64                                                                          \
    {                                                                                              \
        64, 0x12, 0xcf                                                                             \
    }
#define WG_SSD1306_128X32                                                                          \
    {                                                                                              \
        32, 0x02, 0x8f                                                                             \
    }

/* The memory's column that is the glass's left one. */
#define WG_SSD1306_COLUMN 0u
#define WG_SSD0303_COLUMN 36u /* of 96 x 16 glass */

wg_step wg_ssd1306_setup(const wg_ssd1306 *glass, uint8_t index);
wg_step wg_ssd0303_setup(uint8_t index);

/* Where the (x1 - x0) bytes of one page belong: `rect` is 8 rows high, y0 a multiple of 8, and
 * x1 + column <= 128 (132 of an SSD0303). */
wg_step wg_ssd1306_window(wg_rect rect, uint8_t column);

#define WG_SSD1306_I2C_BYTES (2u * WG_STEP_BYTES)

/* A step as I2C bytes: a control byte before every command byte, which is right for any number.
 *   returns  2 step.count <= WG_SSD1306_I2C_BYTES */
uint8_t wg_ssd1306_i2c(const wg_step *step, uint8_t *out);

#ifdef __cplusplus
}
#endif
#endif
