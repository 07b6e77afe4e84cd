/* SSD1306 and SSD0303 on I2C: the address of a page and its pixels in one write.
 * SPDX-License-Identifier: MIT */
#include "panel.h"

#include "hal.h"
#include "ssd1306.h"

void panel_start(void)
{
    uint8_t bytes[WG_SSD1306_I2C_BYTES];
    wg_step step;
    int answer = 0;
    for (uint8_t i = 0; (step = PANEL_SETUP(i)).count > 0; i++) {
        answer |= hal_i2c_write(PANEL_ADDRESS, bytes, wg_ssd1306_i2c(&step, bytes));
    }
    if (answer < 0) {
        hal_log("the display does not answer");
    }
}

/* 7 of the PANEL_HEAD bytes: three command bytes, each behind a control byte, and a control byte. */
void panel_draw(const wg_picture *picture, wg_rect rect, uint32_t *pixels)
{
    uint8_t *bytes = (uint8_t *)pixels;
    uint16_t count = (uint16_t)wg_pixels_pages(picture, rect, pixels, bytes);
    wg_step window = wg_ssd1306_window(rect, PANEL_COLUMN);
    bytes -= 2u * window.count + 1u;
    wg_ssd1306_i2c(&window, bytes);
    bytes[2u * window.count] = WG_SSD1306_DATA;
    hal_i2c_write(PANEL_ADDRESS, bytes, (uint16_t)(2u * window.count + 1u + count));
}

void panel_frame(void)
{
}
