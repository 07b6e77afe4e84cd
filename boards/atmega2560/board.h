/* Arduino Mega 2560. SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_CLOCK_HZ 16000000
#define BOARD_LOG_BAUD 115200
#define BOARD_BUS_BAUD 57600

#define BOARD_SPI_SELECTED 0 /* the level that selects the display */
#define BOARD_SPI_PORT     PORTB
#define BOARD_SPI_OUT      DDRB
#define BOARD_SPI_CS       PB0 /* pin 53 */
#define BOARD_SPI_SCK      PB1 /* pin 52 */
#define BOARD_SPI_MOSI     PB2 /* pin 51 */
#define BOARD_SPI_DC_PORT  PORTL
#define BOARD_SPI_DC_OUT   DDRL
#define BOARD_SPI_DC       PL0 /* pin 49 */

#endif
