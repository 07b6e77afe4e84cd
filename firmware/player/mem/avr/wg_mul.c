/* Wide products from 16-bit ones, a = a1 2^16 + a0.
 * Source: H. S. Warren, Hacker's Delight, 8-2. No intermediate leaves its 32 bits:
 * a1 b0 + (a0 b0 >> 16) <= (2^15 - 1)(2^16 - 1) + 2^16 - 2 < 2^31, and so for the other.
 * SPDX-License-Identifier: MIT */
#include "wg_mul.h"

static uint32_t low_low(uint32_t a, uint32_t b)
{
    return (uint32_t)(uint16_t)a * (uint16_t)b;
}

int32_t wg_mulh(int32_t a, int32_t b)
{
    int16_t a1 = (int16_t)(a >> 16), b1 = (int16_t)(b >> 16);
    uint16_t a0 = (uint16_t)a, b0 = (uint16_t)b;
    int32_t t = (int32_t)a1 * b0 + (int32_t)(uint16_t)(((uint32_t)a0 * b0) >> 16);
    int32_t w = (int32_t)b1 * a0 + (int32_t)(uint16_t)t;
    return (int32_t)a1 * b1 + (int16_t)(t >> 16) + (int16_t)(w >> 16);
}

int32_t wg_mulq(int32_t a, int16_t b)
{
    return (int32_t)(int16_t)(a >> 16) * b + (int16_t)(((int32_t)b * (uint16_t)a) >> 16);
}

uint32_t wg_mulm(uint32_t a, uint32_t b)
{
    uint32_t sum = low_low(a, b) >> 16;
    sum += low_low(a >> 16, b);
    sum += low_low(a, b >> 16);
    return sum + (low_low(a >> 16, b >> 16) << 16);
}

/* a = ua - 2^32 when negative. */
uint32_t wg_mulsm(int32_t a, int32_t b)
{
    uint32_t p = wg_mulm((uint32_t)a, (uint32_t)b);
    return a < 0 ? p - ((uint32_t)b << 16) : p;
}

uint32_t wg_mul29(uint32_t a, uint32_t b)
{
    uint32_t t = low_low(a >> 16, b) + (uint16_t)(low_low(a, b) >> 16);
    uint32_t w = low_low(a, b >> 16) + (uint16_t)t;
    uint32_t high = low_low(a >> 16, b >> 16) + (uint16_t)(t >> 16) + (uint16_t)(w >> 16);
    return high >> 13 ? UINT32_C(1) << 29 : high << 16 | (uint16_t)w;
}

int32_t wg_mul17(uint32_t a, uint32_t b)
{
    return (int32_t)(wg_mulm(a, b) >> 1);
}
