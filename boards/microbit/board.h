/* BBC micro:bit v1: pins of the edge connector. Source: micro:bit v1 schematic.
 * SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_PIN_TX            3u          /* ring 0: the servo bus */
#define BOARD_PIN_RX            2u          /* ring 1 */
#define BOARD_PIN_SCL           0u          /* edge connector pin 19 */
#define BOARD_PIN_SDA           30u         /* edge connector pin 20 */
#define BOARD_BUS_BAUD_REGISTER 0x00ebf000u /* 57600 */

#endif
