/* Arm MPS2 AN386: addresses and rates. Source: Arm DAI0386, memory map.
 * SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_CLOCK_HZ    25000000u
#define BOARD_LOG_UART    0x40004000u /* UART0 */
#define BOARD_LOG_BAUD    115200u
#define BOARD_BUS_UART    0x40005000u /* UART1 */
#define BOARD_BUS_BAUD    57600u
#define BOARD_WATCHDOG    0x40008000u
#define BOARD_FPGAIO      0x40028000u
#define BOARD_I2C         0x4002a000u /* Arduino shield 1 */
#define BOARD_I2C_HALF_US 2u          /* below 250 kHz */

#endif
