/* OLED of 128 x 64 pixels and 16 greys, SSD0323 on SPI. A band is 2 KB of RAM.
 * SPDX-License-Identifier: MIT */
#ifndef PANEL_H
#define PANEL_H

#define PANEL_WIDTH   128
#define PANEL_HEIGHT  64
#define PANEL_ALIGN_X 2
#define PANEL_ALIGN_Y 1
#define PANEL_HEAD    0

#ifndef PANEL_ROWS
#define PANEL_ROWS 4
#endif

#include "../panel_calls.h"

#endif
