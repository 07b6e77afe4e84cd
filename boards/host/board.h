/* The machine you sit at. SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_BUS_BAUD 57600

#endif
