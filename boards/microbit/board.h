/* BBC micro:bit v1: pins of the edge connector. Source: micro:bit v1 schematic.
 * SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_PIN_TX                 3u          /* ring 0: the servo bus */
#define BOARD_PIN_RX                 2u          /* ring 1 */
#define BOARD_PIN_SCL                0u          /* edge connector pin 19 */
#define BOARD_PIN_SDA                30u         /* edge connector pin 20 */
#define BOARD_PIN_SCK                23u         /* edge connector pin 13 */
#define BOARD_PIN_MOSI               21u         /* edge connector pin 15 */
#define BOARD_PIN_SPI_CS             16u         /* edge connector pin 16 */
#define BOARD_PIN_SPI_DC             18u         /* edge connector pin 8 */
#define BOARD_SPI_SELECTED           0u          /* the level that selects the display */
#define BOARD_SPI_FREQUENCY_REGISTER 0x40000000u /* 4 MHz */
#define BOARD_BUS_BAUD_REGISTER      0x00ebf000u /* 57600 */

#endif
