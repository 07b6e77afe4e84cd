/* Arm MPS2 AN386 with a display: the same board. SPDX-License-Identifier: MIT */
#include "../mps2-an386/board.h"
