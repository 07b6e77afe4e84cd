/* Wide products, a reciprocal and a shift for an AVR with MUL: 8 bits times 8 in two cycles.
 * Source: products by columns, P. G. Comba, IBM Systems Journal 29 (1990), 526-538; the rest is
 * ours.
 *
 * avr-gcc's convention: the first argument and the result are in r22..r25, the second one in
 * r18..r21, low byte first (16 bits: r24, r25 and r20, r21); r0, r18..r27, r30 and r31 are free; r1
 * is 0 at the exit.
 *
 * Column n is the sum of all a_i b_j with i + j = n, plus the carry: column n - 1 divided by 256.
 * Three registers hold it. Its low byte is byte n of the product; the upper two are the next carry,
 * and a third one joins them. The registers change their roles, not their contents:
 *
 *   column   products                 sum is at most   so the carry is at most
 *     0      a0b0                              65025    254
 *     1      a1b0 a0b1                        130304    509
 *     2      a2b0 a1b1 a0b2                   195584    764
 *     3      a3b0 a2b1 a1b2 a0b3              260864   1019
 *     4      a3b1 a2b2 a1b3                   196094    765
 *     5      a3b2 a2b3                        130815    510
 *     6      a3b3                              65535    (its two bytes are bytes 6 and 7)
 *
 * In columns 1 and 2 the carry and the first product fit 16 bits, 509 + 65025 = 65534, so that
 * product needs no third addition.
 *
 * Signs: only the top bytes have one. MULSU takes it from its first operand and leaves that of the
 * product in C; subtracting C from the third byte extends the product to 24 bits. Such a column is
 * at least -256 - 2 128 255 = -65536 and gives a carry of -256 or more, which is extended by its
 * sign, not by zeros. MULSU knows r16..r23 only, hence the copies of a2 and a3.
 *
 * tests/test_boards.py compares every function with mem/near/wg_mul.h on the emulator.
 * SPDX-License-Identifier: MIT */

#define A0   r22
#define A1   r23
#define A2   r24
#define A3   r25
#define B0   r18
#define B1   r19
#define B2   r20
#define B3   r21
#define ZERO r31
/* The sums of the first columns rotate through these. */
#define X    r26
#define Y    r27
#define Z    r30

/* (u2 u1 u0) += r1 r0, unsigned. */
.macro  sum     u0, u1, u2
        add     \u0, r0
        adc     \u1, r1
        adc     \u2, ZERO
.endm

/* The same for a signed product whose sign is in C. */
.macro  sums    u0, u1, u2
        sbc     \u2, ZERO
        sum     \u0, \u1, \u2
.endm

/* u becomes the sign of v, the upper byte of a carry. */
.macro  extend  u, v
        mov     \u, \v
        lsl     \u
        sbc     \u, \u
.endm

.macro  function name
        .section .text.\name, "ax", @progbits
        .global \name
        .type   \name, @function
\name:
.endm

.macro  endfunction name
        .size   \name, . - \name
.endm

/* Columns 0 to 2, without signs: column 2 ends up in (X Z Y), so Y is byte 2 of the product. */
.macro  columns_0_to_2
        clr     ZERO
        mul     A0, B0
        mov     X, r1
        clr     Y               ; column 1 in (Z Y X)
        mul     A1, B0
        add     X, r0
        adc     Y, r1
        clr     Z
        mul     A0, B1
        sum     X, Y, Z
        mul     A2, B0          ; column 2 in (X Z Y)
        add     Y, r0
        adc     Z, r1
        clr     X
        mul     A1, B1
        sum     Y, Z, X
        mul     A0, B2
        sum     Y, Z, X
.endm

/* int32_t wg_mulh(int32_t a, int32_t b): bytes 4 to 7. */
        function wg_mulh
        columns_0_to_2
        clr     Y               ; column 3 in (Y X Z)
        mulsu   B3, A0
        sums    Z, X, Y
        mov     A0, A3          ; a0 has been used: now a3
        mul     A2, B1
        sum     Z, X, Y
        mul     A1, B2
        sum     Z, X, Y
        mulsu   A0, B0
        sums    Z, X, Y
        mov     B0, A2          ; b0 has been used: now a2, and r24, r25 are free
        extend  r24, Y          ; column 4 in (r24 Y X)
        mulsu   B3, A1
        sums    X, Y, r24
        mul     B0, B2
        sum     X, Y, r24
        mulsu   A0, B1
        sums    X, Y, r24
        extend  r25, r24        ; column 5 in (r25 r24 Y)
        mulsu   B3, B0
        sums    Y, r24, r25
        mulsu   A0, B2
        sums    Y, r24, r25
        muls    A0, B3          ; column 6 in (r25 r24)
        add     r24, r0
        adc     r25, r1
        movw    r22, X          ; X and Y
        clr     r1
        ret
        endfunction wg_mulh

/* int32_t wg_mulq(int32_t a, int16_t b): bytes 2 to 5, b in r20 and r21. */
        function wg_mulq
        clr     ZERO
        movw    r18, r24        ; a2 and a3 where MULSU takes them, and r24, r25 are free
        mul     A0, r20
        mov     Z, r1
        clr     X               ; column 1 in (Y X Z)
        mul     A1, r20
        add     Z, r0
        adc     X, r1
        clr     Y
        mulsu   r21, A0
        sums    Z, X, Y
        extend  r24, Y          ; column 2 in (r24 Y X)
        mul     r18, r20
        sum     X, Y, r24
        mulsu   r21, A1
        sums    X, Y, r24
        extend  r25, r24        ; column 3 in (r25 r24 Y)
        mulsu   r19, r20
        sums    Y, r24, r25
        mulsu   r21, r18
        sums    Y, r24, r25
        muls    r19, r21        ; column 4 in (r25 r24)
        add     r24, r0
        adc     r25, r1
        movw    r22, X
        clr     r1
        ret
        endfunction wg_mulq

/* Column 3 without signs, in (A0 X Z): a0 is used first and lends its register. */
.macro  column_3
        mul     A0, B3
        clr     A0              ; leaves C alone, and r0 and r1
        add     Z, r0
        adc     X, r1
        adc     A0, ZERO
        mul     A1, B2
        sum     Z, X, A0
        mul     A2, B1
        sum     Z, X, A0
        mul     A3, B0
        sum     Z, X, A0
.endm

/* Bytes 2 to 5 of a b without signs, in Y, Z, X and A0: what would go to byte 6 is left out. */
.macro  middle_bytes
        columns_0_to_2
        column_3
        mul     A1, B3          ; column 4 in (A0 X)
        add     X, r0
        adc     A0, r1
        mul     A2, B2
        add     X, r0
        adc     A0, r1
        mul     A3, B1
        add     X, r0
        adc     A0, r1
        mul     A2, B3          ; column 5 in A0
        add     A0, r0
        mul     A3, B2
        add     A0, r0
        clr     r1
.endm

/* uint32_t wg_mulsm(int32_t a, int32_t b): a negative a is 2^32 too large without its sign, so the
 * product is 2^32 b too large and byte 4 on is b too large. */
        function wg_mulsm
        middle_bytes
        sbrs    A3, 7
        rjmp    1f
        sub     X, B0
        sbc     A0, B1
1:      mov     r25, A0
        mov     r24, X
        mov     r23, Z
        mov     r22, Y
        ret
        endfunction wg_mulsm

/* int32_t wg_mul17(uint32_t a, uint32_t b): one more bit is shifted out; a b < 2^48. */
        function wg_mul17
        middle_bytes
        lsr     A0
        ror     X
        ror     Z
        ror     Y
        mov     r25, A0
        mov     r24, X
        mov     r23, Z
        mov     r22, Y
        ret
        endfunction wg_mul17

/* uint32_t wg_mul29(uint32_t a, uint32_t b): bytes 2 to 5, or 2^29 when the product has more. */
        function wg_mul29
        columns_0_to_2
        column_3
        clr     B0              ; b0 has been used; column 4 in (B0 A0 X)
        mul     A1, B3
        sum     X, A0, B0
        mul     A2, B2
        sum     X, A0, B0
        mul     A3, B1
        sum     X, A0, B0
        clr     A1              ; a1 has been used; column 5 in (A1 B0 A0)
        mul     A2, B3
        sum     A0, B0, A1
        mul     A3, B2
        sum     A0, B0, A1
        mul     A3, B3          ; column 6 in (A1 B0)
        add     B0, r0
        adc     A1, r1
        clr     r1
        or      B0, A1
        brne    1f
        cpi     A0, 0x20        ; bit 29 and up
        brsh    1f
        mov     r25, A0
        mov     r24, X
        mov     r23, Z
        mov     r22, Y
        ret
1:      ldi     r25, 0x20
        clr     r24
        clr     r23
        clr     r22
        ret
        endfunction wg_mul29

/* uint32_t wg_inverse(unsigned a): long division of 32 one bits by a, in r24 and r25. A remainder
 * before the subtraction is below 2 a <= 131070: 17 bits, the last of them in C. After a step, C is
 * the inverse of the quotient's bit. */
        function wg_inverse
        movw    r20, r24        ; the divisor
        clr     r18             ; the remainder
        clr     r19
        ldi     r26, 4
1:      mov     r25, r24        ; a byte of the quotient is complete
        mov     r24, r23
        mov     r23, r22
        .rept   8
        sec
        rol     r18
        rol     r19
        brcs    2f
        cp      r18, r20
        cpc     r19, r21
        brcs    3f
2:      sub     r18, r20
        sbc     r19, r21
        clc
3:      rol     r22
        .endr
        dec     r26
        breq    4f
        rjmp    1b              ; too far for a branch
4:      com     r22
        com     r23
        com     r24
        com     r25
        ret
        endfunction wg_inverse

/* int32_t wg_shr(int32_t a, unsigned bits): bytes first; bits in r20. */
        function wg_shr
        subi    r20, 8
        brcs    2f
1:      mov     r22, r23
        mov     r23, r24
        mov     r24, r25
        lsl     r25
        sbc     r25, r25
        subi    r20, 8
        brcc    1b
2:      subi    r20, -8
        breq    4f
3:      asr     r25
        ror     r24
        ror     r23
        ror     r22
        dec     r20
        brne    3b
4:      ret
        endfunction wg_shr
