# Arm MPS2 with the AN386 image: Cortex-M4. Compiled without its FPU, which the player has no use for.
# SPDX-License-Identifier: MIT
CROSS    := arm-none-eabi-
CPU      := -mcpu=cortex-m4 -mthumb -mfloat-abi=soft -ffreestanding -fcallgraph-info=su
KERNEL   := dsp
HAL      := cmsdk arm_m bare
LD       := -nostdlib -T boards/mps2-an386/link.ld -lgcc
# 2^5 ns an instruction is 31 MIPS, near the board's 25 MHz
EMULATOR := qemu-system-arm -M mps2-an386 -icount shift=5,align=off,sleep=off -serial file:@LOG@ -serial file:@BUS@ -semihosting-config enable=on,target=native -kernel @IMAGE@
