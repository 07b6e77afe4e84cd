/* ST7789 and ILI9341 on SPI. SPDX-License-Identifier: MIT */
#include "panel.h"

#include "hal.h"
#include "mipi_dcs.h"

static const wg_dcs glass = PANEL_GLASS;

static void send(const wg_step *step)
{
    hal_spi_write(0, step->bytes, 1);
    if (step->count > 1) {
        hal_spi_write(1, step->bytes + 1, (uint16_t)(step->count - 1u));
    }
}

void panel_start(void)
{
    wg_step step;
    for (uint8_t i = 0; (step = wg_dcs_setup(&glass, i)).count > 0; i++) {
        send(&step);
        hal_wait_until(hal_time_us() + (uint32_t)step.wait_ms * 1000u);
    }
}

void panel_draw(const wg_picture *picture, wg_rect rect, uint32_t *pixels)
{
    uint8_t *bytes = (uint8_t *)pixels;
    uint16_t count = (uint16_t)wg_pixels_rgb565(picture, rect, pixels, bytes);
    wg_step step;
    for (uint8_t i = 0; (step = wg_dcs_window(&glass, rect, i)).count > 0; i++) {
        send(&step);
    }
    hal_spi_write(1, bytes, count);
}

void panel_frame(void)
{
}
