/* Vertices of LINEAR skins on cores with the DSP extension: x and y of a vertex in one word are an
 * operand of SMLAD, and SMMLA weighs a row: its high word of row w 2^22 is floor(row w / 2^10), so the
 * bits are those of kernel/plain.
 * Source: own (SPEC 6.10); the words of a bone (skin.h) lie as they do for LDM.
 *   r0 bones, r1 xyz, r2 data, r3 x and y, r4 z and in its upper half influences that are left,
 *   r5-r7 sums
 * SPDX-License-Identifier: MIT */
        .syntax unified
        .thumb

        .equ    SKIN_BONES, 0           /* wg_kernel_skin */
        .equ    SKIN_DATA, 8
        .equ    SKIN_INFLUENCES, 12
        .equ    SKIN_MOVE, 16

        /* on the stack: what LDM and LDRD fetch for each vertex */
        .equ    LEFT, 0                 /* influences - 1 in the upper half, then the sums' start */
        .equ    MOVE, 16                /* g, then vertices that are left */
        .equ    COUNT, 28
        .equ    BONES, 32
        .equ    FRAMES, 36
        .equ    SINES, 40
        .equ    XYZ, 44
        .equ    FRAME, 48

        .macro  function name
        .section .text.\name, "ax", %progbits
        .global \name
        .type   \name, %function
        .balign 4
\name:
        .endm

/* r0 skin, r1 xyz, r2 count; `half` rounds the sums. */
        .macro  enter half
        push    {r4-r11, lr}
        sub     sp, #FRAME
        ldr     r3, [r0, #SKIN_INFLUENCES]
        subs    r3, #1
        lsls    r3, r3, #16
        movs    r4, #\half
        mov     r5, r4
        mov     r6, r4
        stm     sp, {r3-r6}
        str     r2, [sp, #COUNT]
        add     r3, r0, #SKIN_MOVE
        ldm     r3, {r4-r6}
        add     r3, sp, #MOVE
        stm     r3, {r4-r6}
        ldr     r2, [r0, #SKIN_DATA]
        .endm

/* r1 xyz: its position in r3 and r4. */
        .macro  position
        ldm     r1, {r8-r10}
        lsl     lr, r9, #1
        pkhtb   r3, lr, r8, asr #15
        ldm     sp, {r4-r7}
        pkhtb   r4, r4, r10, asr #15
        .endm

/* The sums, `bits` finer than a vertex, go to r1. */
        .macro  finish bits
        ldrd    r8, r9, [sp, #MOVE]
        ldrd    r10, r11, [sp, #MOVE + 8]
        add     r5, r8, r5, asr #\bits
        add     r6, r9, r6, asr #\bits
        add     r7, r10, r7, asr #\bits
        stm     r1!, {r5-r7}
        subs    r11, #1
        str     r11, [sp, #COUNT]
        .endm

        .macro  leave
        add     sp, #FRAME
        pop     {r4-r11, pc}
        .endm

/* One influence; the first weight counts `more`. r9 bone, r10-r12 t and then the rows. */
        .macro  linear more
        ldrb    r9, [r2], #2
        add     r9, r0, r9, lsl #6
        ldm     r9!, {r10-r12}
        ldm     r9!, {r8, lr}
        smlad   r10, r8, r3, r10
        smlad   r11, lr, r3, r11
        ldm     r9, {r8, r9, lr}
        smlad   r12, r8, r3, r12
        smlabb  r10, r9, r4, r10
        smlatb  r11, r9, r4, r11
        smlabb  r12, lr, r4, r12
        ldrb    r8, [r2, #-1]
        .if     \more
        adds    r8, #1
        .endif
        lsl     r8, r8, #22
        smmla   r5, r10, r8, r5
        smmla   r6, r11, r8, r6
        smmla   r7, r12, r8, r7
        .endm

/* void wg_kernel_linear(const wg_kernel_skin *skin, int32_t *xyz, unsigned count) */
        function wg_kernel_linear
        enter   8
        ldr     r0, [r0, #SKIN_BONES]
1:      position
        linear  1
        subs    r4, #0x10000
        blo     3f
2:      linear  0
        subs    r4, #0x10000
        bhs     2b
3:      finish  4
        bne     1b
        leave
        .size   wg_kernel_linear, . - wg_kernel_linear

/* One influence with an end. r8 bone, r9 frame, r10-r12 h and then l; r0 and r1 are free. */
        .macro  ends more
        ldrb    r8, [r2], #3
        ldrd    r10, r11, [sp, #BONES]  /* and FRAMES */
        add     r9, r8, r8, lsl #1
        add     r8, r10, r8, lsl #6
        add     r9, r11, r9, lsl #4
        ldm     r8!, {r10-r12}
        ldm     r9!, {r1, lr}
        smlad   r10, r1, r3, r10
        smlad   r11, lr, r3, r11
        ldm     r9, {r1, r9, lr}
        smlad   r12, r1, r3, r12
        smlabb  r10, r9, r4, r10
        smlatb  r11, r9, r4, r11
        smlabb  r12, lr, r4, r12
        lsl     r12, r12, #1
        pkhtb   r11, r12, r11, asr #15  /* l1 and l2 */
        ldm     r8!, {r1, r9, lr}       /* S, A, B */
        ldrb    r12, [r2, #-1]
        asr     r10, r10, #15
        add     r12, r12, r12, lsr #7   /* e */
        smlawb  r10, r1, r12, r10       /* l0, stretched */
        mla     r1, lr, r12, r9         /* the phase */
        cbnz    r1, 4f
        pkhbt   r10, r10, r11, lsl #16
        asr     r11, r11, #16
        b       5f
4:      add     r12, r1, #0x800000
        ldr     r9, =105414357
        lsl     r1, r1, #8
        smmul   r9, r1, r9              /* D */
        lsr     r12, r12, #24
        ldr     r1, [sp, #SINES]
        add     r12, r1, r12, lsl #1
        ldrsh   r1, [r12, #128]
        ldrsh   r12, [r12]
        smmlar  lr, r1, r9, r12         /* s */
        smmlsr  r1, r12, r9, r1         /* c */
        pkhbt   r1, r1, lr, lsl #16
        mov     lr, #0x2000
        smlsd   r9, r1, r11, lr
        smladx  r11, r1, r11, lr
        pkhbt   r10, r10, r9, lsl #2    /* l0 and l1 / 2^14 */
        asr     r11, r11, #14
5:      ldm     r8!, {r1, r9, r12}
        ldm     r8!, {r0, lr}
        smlad   r1, r0, r10, r1
        smlad   r9, lr, r10, r9
        ldm     r8, {r0, r8, lr}
        smlad   r12, r0, r10, r12
        smlabb  r1, r8, r11, r1
        smlatb  r9, r8, r11, r9
        smlabb  r12, lr, r11, r12
        ldrb    r8, [r2, #-2]
        .if     \more
        adds    r8, #1
        .endif
        lsl     r8, r8, #22
        smmla   r5, r1, r8, r5
        smmla   r6, r9, r8, r6
        smmla   r7, r12, r8, r7
        .endm

/* void wg_kernel_ends(const wg_kernel_skin *skin, int32_t *xyz, unsigned count) */
        function wg_kernel_ends
        enter   4
        ldrd    r3, r4, [r0, #SKIN_BONES] /* and SKIN_FRAMES */
        ldr     r5, =fix_sine_table
        strd    r3, r4, [sp, #BONES]
        str     r5, [sp, #SINES]
1:      position
        str     r1, [sp, #XYZ]
        ends    1
        subs    r4, #0x10000
        blo     3f
2:      ends    0
        subs    r4, #0x10000
        bhs     2b
3:      ldr     r1, [sp, #XYZ]
        finish  3
        bne     1b
        leave
        .ltorg
        .size   wg_kernel_ends, . - wg_kernel_ends
