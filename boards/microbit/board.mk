# BBC micro:bit v1: nRF51822, Cortex-M0, 256 KB flash, 16 KB RAM.
# SPDX-License-Identifier: MIT
CROSS    := arm-none-eabi-
CPU      := -mcpu=cortex-m0 -mthumb -mfloat-abi=soft -ffreestanding -fcallgraph-info=su
HAL      := nrf51 arm_m bare
LD       := -nostdlib -T boards/microbit/link.ld -lgcc
# 2^6 ns an instruction is 16 MIPS, the chip's 16 MHz; the log is the semihosting console
EMULATOR := qemu-system-arm -M microbit -icount shift=6,align=off,sleep=off -serial file:@BUS@ -chardev file,id=log,path=@LOG@ -semihosting-config enable=on,target=native,chardev=log -kernel @IMAGE@
