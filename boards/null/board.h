/* What your HAL needs to know about the board: clock, addresses, pins, baud rates.
 * SPDX-License-Identifier: MIT */
#ifndef BOARD_H
#define BOARD_H

#endif
