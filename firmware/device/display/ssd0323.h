/* Solomon Systech SSD0323: OLED of 128 x 64 pixels and 16 greys, on SPI.
 * Source: SSD0323 data sheet, command table; OSRAM application note AN018 for the values of its
 * Pictiva glass, which an LM3S6965 evaluation board carries.
 * Steps go with the data/command line low, pixels with it high. The clock may be 4 MHz.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_SSD0323_H
#define WIGGLY_SSD0323_H

#include "display.h"

#ifdef __cplusplus
extern "C" {
#endif

wg_step wg_ssd0323_setup(uint8_t index);

/* Where the next pixels belong; they fill it row by row. rect.x0 and x1 are even. */
wg_step wg_ssd0323_window(wg_rect rect);

#ifdef __cplusplus
}
#endif
#endif
