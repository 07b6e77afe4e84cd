/* Operands for the processor-dependent functions of wg_mul.h, the same wherever they are compiled:
 * all pairs of edge values, then random ones in which bytes 00 and ff are common, because carries
 * and signs hide there.
 * SPDX-License-Identifier: MIT */
#ifndef MUL_PAIRS_H
#define MUL_PAIRS_H

#include "wg_mul.h"

enum { MUL_H, MUL_Q, MUL_SM, MUL_29, MUL_17, MUL_WEIGH, MUL_INVERSE, MUL_SHR, MUL_FUNCTIONS };

static const char *const mul_names[MUL_FUNCTIONS] = {"mulh ", "mulq ", "mulsm", "mul29",
                                                     "mul17", "weigh", "inver", "shr  "};

static const uint32_t mul_edges[] = {
    0,          1,          2,          0x7f,       0x80,       0xff,       0x100,      0x7fff,
    0x8000,     0xffff,     0x10000,    0x7fffff,   0x800000,   0xffffff,   0x1000000,  0x7fffffff,
    0x80000000, 0x80000001, 0xffffff00, 0xffff0000, 0x00ff00ff, 0xff00ff00, 0x80808080, 0xffffffff};

#define MUL_EDGES (sizeof mul_edges / sizeof mul_edges[0])
#define MUL_PAIRS (MUL_EDGES * MUL_EDGES + 4000u)

typedef struct {
    uint32_t a, b;
} mul_pair;

/* xorshift32: Marsaglia, Journal of Statistical Software 8 (2003), 14. */
static uint32_t mul_random(uint32_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    return *seed;
}

/* Each byte as it is, 0 or 255, with probabilities 1/2, 1/4 and 1/4. */
static uint32_t mul_random_bytes(uint32_t *seed)
{
    uint32_t value = mul_random(seed), choice = mul_random(seed);
    for (uint32_t byte = 0xff; byte; byte <<= 8) {
        value = choice & 1u ? value : choice & 2u ? value | byte : value & ~byte;
        choice >>= 2;
    }
    return value;
}

/* Pair number `index`, to be asked for in ascending order with one seed that starts at 1. */
static mul_pair mul_pair_at(uint32_t index, uint32_t *seed)
{
    mul_pair p;
    if (index < MUL_EDGES * MUL_EDGES) {
        p.a = mul_edges[index / MUL_EDGES];
        p.b = mul_edges[index % MUL_EDGES];
    } else {
        p.a = mul_random_bytes(seed);
        p.b = mul_random_bytes(seed);
    }
    return p;
}

/* The pair made to fulfil a function's conditions. For MUL_17, a < 2^(32-s) and b < 2^(16+s). */
static mul_pair mul_fit(uint8_t function, mul_pair p)
{
    uint32_t s = (p.a ^ p.b) & 15u;
    switch (function) {
    case MUL_SM:
        p.b &= 0x7fffffffu;
        break;
    case MUL_17:
        p.a >>= s;
        p.b >>= 16u - s;
        break;
    case MUL_WEIGH: /* |a| <= 2^30, b <= 2^15 */
        p.a = (uint32_t)((int32_t)p.a >> 1);
        p.b = p.b >> 31 ? 32768u : p.b & 0x7fffu;
        break;
    case MUL_INVERSE: /* 1 .. 65535 */
        p.a = p.a & 0xffffu ? p.a & 0xffffu : 1u;
        break;
    case MUL_SHR:
        p.b &= 31u;
        break;
    default: /* any pair, or any a and the lower half of b */
        break;
    }
    return p;
}

static uint32_t mul_result(uint8_t function, mul_pair p)
{
    switch (function) {
    case MUL_H:
        return (uint32_t)wg_mulh((int32_t)p.a, (int32_t)p.b);
    case MUL_Q:
        return (uint32_t)wg_mulq((int32_t)p.a, (int16_t)p.b);
    case MUL_SM:
        return wg_mulsm((int32_t)p.a, (int32_t)p.b);
    case MUL_29:
        return wg_mul29(p.a, p.b);
    case MUL_17:
        return (uint32_t)wg_mul17(p.a, p.b);
    case MUL_WEIGH:
        return (uint32_t)wg_weigh((int32_t)p.a, (uint16_t)p.b);
    case MUL_INVERSE:
        return wg_inverse((uint16_t)p.a);
    default: /* MUL_SHR */
        return (uint32_t)wg_shr((int32_t)p.a, (uint8_t)p.b);
    }
}

#endif
