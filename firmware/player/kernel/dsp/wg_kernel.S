/* Blocks of two bases on cores with the DSP extension: one SMLAD a component adds both products.
 * Four components a group, because eight of them are all the registers there are; groups of four
 * are repeated three times, so that four vertices are one round. The same bits as kernel/plain:
 * SMLAD wraps like fix_add, and the Q flag it then sets is not read.
 * Source: own; the layout of SPEC 4.15 was made for it.
 *   r0 acc, r1 data, r2 weights, r3 components
 * SPDX-License-Identifier: MIT */
        .syntax unified
        .thumb
        .text

        .macro  group16
        ldm     r0, {r4-r7}
        ldm     r1!, {r8-r11}
        smlad   r4, r8, r2, r4
        smlad   r5, r9, r2, r5
        smlad   r6, r10, r2, r6
        smlad   r7, r11, r2, r7
        stm     r0!, {r4-r7}
        .endm

/* void wg_kernel_pair16(int32_t *acc, const uint8_t *data, uint32_t weights, unsigned components) */
        .section .text.wg_kernel_pair16, "ax", %progbits
        .global wg_kernel_pair16
        .type   wg_kernel_pair16, %function
        .balign 4
wg_kernel_pair16:
        push    {r4-r11}
        subs    r3, #12
        blo     2f
1:      group16
        group16
        group16
        subs    r3, #12
        bhs     1b
2:      adds    r3, #12
        beq     4f
3:      ldr     r4, [r0]                /* at most 11 components are left */
        ldr     r5, [r1], #4
        smlad   r4, r5, r2, r4
        str     r4, [r0], #4
        subs    r3, #1
        bne     3b
4:      pop     {r4-r11}
        bx      lr
        .size   wg_kernel_pair16, . - wg_kernel_pair16

/* A word holds a.c, a.c', b.c, b.c'; its upper bytes of both halves, and those of the word moved up
 * by one byte, are the operands of c' and c, times 256. r12 is the mask. */
        .macro  group8
        ldm     r0, {r4-r7}
        ldm     r1!, {r8, r9}
        and     r10, r12, r8, lsl #8
        and     r8, r12, r8
        and     r11, r12, r9, lsl #8
        and     r9, r12, r9
        smlad   r4, r10, r2, r4
        smlad   r5, r8, r2, r5
        smlad   r6, r11, r2, r6
        smlad   r7, r9, r2, r7
        stm     r0!, {r4-r7}
        .endm

/* void wg_kernel_pair8(int32_t *acc, const uint8_t *data, uint32_t weights, unsigned components) */
        .section .text.wg_kernel_pair8, "ax", %progbits
        .global wg_kernel_pair8
        .type   wg_kernel_pair8, %function
        .balign 4
wg_kernel_pair8:
        push    {r4-r11}
        mov     r12, #0xff00ff00
        subs    r3, #12
        blo     2f
1:      group8
        group8
        group8
        subs    r3, #12
        bhs     1b
2:      adds    r3, #12
        beq     4f
3:      ldr     r8, [r1], #4            /* at most 11 components are left: one or two of a word */
        ldr     r4, [r0]
        and     r10, r12, r8, lsl #8
        smlad   r4, r10, r2, r4
        str     r4, [r0], #4
        subs    r3, #1
        beq     4f
        ldr     r4, [r0]
        and     r8, r12, r8
        smlad   r4, r8, r2, r4
        str     r4, [r0], #4
        subs    r3, #1
        bne     3b
4:      pop     {r4-r11}
        bx      lr
        .size   wg_kernel_pair8, . - wg_kernel_pair8
