# SiFive E: FE310, RV32IMAC, as emulated (the HiFive1 differs in flash address and mtime rate).
# SPDX-License-Identifier: MIT
CROSS    := riscv64-unknown-elf-
# the older ISA spec has the CSR instructions in its base, and its name finds the 32-bit libgcc
CPU      := -march=rv32imac -mabi=ilp32 -misa-spec=2.2 -ffreestanding -fcallgraph-info=su -isystem hal/bare/libc
HAL      := fe310 rv32 bare
LD       := -nostdlib -T boards/sifive_e/link.ld -lgcc
# 2^6 ns an instruction is 16 MIPS, the chip's 16 MHz
EMULATOR := qemu-system-riscv32 -M sifive_e -bios none -icount shift=6,align=off,sleep=off -serial file:@LOG@ -serial file:@BUS@ -semihosting-config enable=on,target=native -kernel @IMAGE@
