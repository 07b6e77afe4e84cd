/* Luminary LM3S6965 evaluation board: rates, and the pins that are the board's and not the chip's.
 * Source: EK-LM3S6965 user's manual, schematic.
 * SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_CLOCK_HZ 50000000u /* from the 8 MHz crystal */
#define BOARD_LOG_BAUD 115200u   /* UART0: PA0, PA1, the board's USB */
#define BOARD_BUS_BAUD 57600u    /* UART1: PD2, PD3 */
#define BOARD_I2C_HZ   400000u   /* PB2, PB3 */
#define BOARD_SPI_HZ   3600000u  /* PA2, PA5; an SSD0323 takes 4 MHz */

#define BOARD_SPI_SELECTED 0u          /* the level that selects the display */
#define BOARD_SPI_CS_PORT  0x40004000u /* PA3 */
#define BOARD_SPI_CS_PIN   3u
#define BOARD_SPI_DC_PORT  0x40006000u /* PC7 */
#define BOARD_SPI_DC_PIN   7u
#define BOARD_SD_CARD_CS   0x40007000u /* PD0, high: the card on the same SPI is left alone */
#define BOARD_SD_CARD_PIN  0u

#endif
