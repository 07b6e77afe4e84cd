/* Arduino Mega 2560. SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_CLOCK_HZ 16000000
#define BOARD_LOG_BAUD 115200
#define BOARD_BUS_BAUD 57600

#endif
