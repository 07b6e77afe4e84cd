# The same MPS2 board with an OLED of 96 x 16 pixels on its I2C. SPDX-License-Identifier: MIT
include boards/mps2-an386/board.mk
PANEL    ?= ssd0303
EMULATOR := qemu-system-arm -M mps2-an386 -icount shift=5,align=off,sleep=off -device ssd0303,address=0x3d -serial file:@LOG@ -serial file:@BUS@ -semihosting-config enable=on,target=native -kernel @IMAGE@
