/* OLED of 128 x 64 pixels, SSD1306 on I2C. A band is 4 KB of RAM.
 * SPDX-License-Identifier: MIT */
#ifndef PANEL_H
#define PANEL_H

#define PANEL_WIDTH   128
#define PANEL_HEIGHT  64
#define PANEL_ALIGN_X 1
#define PANEL_ALIGN_Y 8
#define PANEL_ROWS    8
#define PANEL_HEAD    8

#define PANEL_ADDRESS 0x3cu
#define PANEL_COLUMN  WG_SSD1306_COLUMN

#define PANEL_SETUP(step) wg_ssd1306_setup(&(const wg_ssd1306)WG_SSD1306_128X64, step)

#include "../panel_calls.h"

#endif
