/* IPS glass of 240 x 240 pixels, ST7789 on SPI. A band is 7.5 KB of RAM.
 * SPDX-License-Identifier: MIT */
#ifndef PANEL_H
#define PANEL_H

#define PANEL_WIDTH   240
#define PANEL_HEIGHT  240
#define PANEL_ALIGN_X 1
#define PANEL_ALIGN_Y 1
#define PANEL_HEAD    0
#define PANEL_GLASS   WG_ST7789_240X240

#ifndef PANEL_ROWS
#define PANEL_ROWS 8
#endif

#include "../panel_calls.h"

#endif
