/* Sharp Memory LCD of 400 x 240 pixels, LS027B7DH01 on SPI. A band is 6.25 KB of RAM.
 * SPDX-License-Identifier: MIT */
#ifndef PANEL_H
#define PANEL_H

#define PANEL_WIDTH   400
#define PANEL_HEIGHT  240
#define PANEL_ALIGN_X PANEL_WIDTH
#define PANEL_ALIGN_Y 1
#define PANEL_HEAD    0

#ifndef PANEL_ROWS
#define PANEL_ROWS 4
#endif

#include "../panel_calls.h"

#endif
