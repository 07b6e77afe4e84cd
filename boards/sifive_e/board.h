/* SiFive E as emulated. Source: SiFive FE310-G000 Manual v3p2; mtime rate measured.
 * SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_CLOCK_HZ 16000000u
#define BOARD_MTIME_HZ 10000000u /* the chip itself has 32768 */
#define BOARD_LOG_BAUD 115200u
#define BOARD_BUS_BAUD 57600u

#define BOARD_SPI_HZ       4000000u
#define BOARD_SPI_SELECTED 0u /* the level that selects the display */
#define BOARD_PIN_SPI_DC   1u /* GPIO 1: pin 9 of a HiFive1, beside SPI1 on 10, 11 and 13 */

#endif
