/* Sharp Memory LCD on SPI: board.h says that its select is active high, and a clock it can take.
 * SPDX-License-Identifier: MIT */
#include "panel.h"

#include "hal.h"
#include "sharp.h"

#define VCOM_US (WG_SHARP_VCOM_MS * UINT32_C(1000))

static uint8_t vcom;
static uint32_t vcom_us; /* when it last changed */

static void send(wg_step step)
{
    hal_spi_write(0, step.bytes, step.count);
}

void panel_start(void)
{
    vcom_us = hal_time_us();
    send(wg_sharp_clear(vcom));
}

void panel_draw(const wg_picture *picture, wg_rect rect, uint32_t *pixels)
{
    uint8_t *bytes = (uint8_t *)pixels;
    wg_pixels_lines(picture, rect, pixels, bytes);
    hal_spi_write(0, bytes, wg_sharp_lines(rect, vcom, bytes));
}

void panel_frame(void)
{
    if (hal_time_us() - vcom_us >= VCOM_US) {
        vcom_us += VCOM_US;
        vcom = !vcom;
        send(wg_sharp_vcom(vcom));
    }
}
