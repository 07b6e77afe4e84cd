/* SSD0323 on SPI. SPDX-License-Identifier: MIT */
#include "panel.h"

#include "hal.h"
#include "ssd0323.h"

void panel_start(void)
{
    wg_step step;
    for (uint8_t i = 0; (step = wg_ssd0323_setup(i)).count > 0; i++) {
        hal_spi_write(0, step.bytes, step.count);
    }
}

void panel_draw(const wg_picture *picture, wg_rect rect, uint32_t *pixels)
{
    uint8_t *bytes = (uint8_t *)pixels;
    uint16_t count = (uint16_t)wg_pixels_grey4(picture, rect, pixels, bytes);
    wg_step window = wg_ssd0323_window(rect);
    hal_spi_write(0, window.bytes, window.count);
    hal_spi_write(1, bytes, count);
}

void panel_frame(void)
{
}
