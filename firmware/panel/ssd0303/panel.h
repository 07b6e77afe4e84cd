/* OLED of 96 x 16 pixels, SSD0303 on I2C, as QEMU has it. A band is 3 KB of RAM.
 * SPDX-License-Identifier: MIT */
#ifndef PANEL_H
#define PANEL_H

#define PANEL_WIDTH   96
#define PANEL_HEIGHT  16
#define PANEL_ALIGN_X 1
#define PANEL_ALIGN_Y 8
#define PANEL_ROWS    8
#define PANEL_HEAD    8

#define PANEL_ADDRESS 0x3du
#define PANEL_COLUMN  WG_SSD0303_COLUMN

#define PANEL_SETUP(step) wg_ssd0303_setup(step)

#include "../panel_calls.h"

#endif
