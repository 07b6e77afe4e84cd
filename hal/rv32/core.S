/* What every RV32 chip shares: reset, traps, semihosting.
 * Source: RISC-V Privileged Architecture 3.1; RISC-V Semihosting 0.3 (the three instructions).
 * SPDX-License-Identifier: MIT */
    .section .text.reset, "ax"
    .globl reset
reset:
    la sp, stack_top
    la t0, trap
    csrw mtvec, t0
    call bare_start
1:  j 1b

/* A semihosting ebreak (mcause 3) without a debugger: step over it, and the call answers -1.
 * Any other trap is a bug: tell the emulator; a chip stands still until its watchdog bites.
 * t0 is free: only a call to semihost gets through here and returns. */
    .text
    .balign 4
trap:
    csrr t0, mcause
    addi t0, t0, -3
    bnez t0, 2f
    csrr t0, mepc
    addi t0, t0, 4
    csrw mepc, t0
    li a0, -1
    mret
2:  la sp, stack_top
    li a0, 99
    call semihost_stop
3:  j 3b

/* int32_t semihost(int32_t operation, const void *argument). The sequence must not be compressed,
 * nor cross a page. */
    .globl semihost
    .balign 16
    .option push
    .option norvc
semihost:
    slli zero, zero, 0x1f
    ebreak
    srai zero, zero, 7
    ret
    .option pop

    .globl bare_sleep
bare_sleep:
    wfi
    ret
