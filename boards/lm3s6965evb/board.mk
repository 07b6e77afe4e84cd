# Luminary LM3S6965 evaluation board: Cortex-M3, 256 KB flash, 64 KB RAM, a grey OLED of 128 x 64 on its SPI.
# SPDX-License-Identifier: MIT
CROSS    := arm-none-eabi-
CPU      := -mcpu=cortex-m3 -mthumb -mfloat-abi=soft -ffreestanding -fcallgraph-info=su
HAL      := stellaris arm_m bare
PANEL    ?= ssd0323
LD       := -nostdlib -T boards/lm3s6965evb/link.ld -lgcc
# 2^5 ns an instruction is 31 MIPS, what the chip does at 50 MHz with 1.6 cycles an instruction
EMULATOR := qemu-system-arm -M lm3s6965evb -icount shift=5,align=off,sleep=off -serial file:@LOG@ -serial file:@BUS@ -semihosting-config enable=on,target=native -kernel @IMAGE@
