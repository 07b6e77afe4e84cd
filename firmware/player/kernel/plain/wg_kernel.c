/* Blocks of two bases in plain C.
 * Source: own (SPEC 6.8).
 * SPDX-License-Identifier: MIT */
#include "../../kernel.h"
#include "../../fix.h"

/* acc + a w_a + b w_b. */
static inline int32_t sum16(int32_t acc, const uint8_t *a, int16_t wa, int16_t wb)
{
    acc = fix_add(acc, (int32_t)(int16_t)wg_rd16(a) * wa);
    return fix_add(acc, (int32_t)(int16_t)wg_rd16(a + 2) * wb);
}

/* A vertex a round: with 16 bases a vertex takes a Cortex-M3 250 instructions in all, and 298 with a
 * component a round (tests/fw_pose.c). */
void wg_kernel_pair16(int32_t *acc, const uint8_t *data, uint32_t weights, unsigned components)
{
    int16_t wa = (int16_t)weights, wb = (int16_t)(weights >> 16);
    for (; components > 0; components -= 3) {
        acc[0] = sum16(acc[0], data, wa, wb);
        acc[1] = sum16(acc[1], data + 4, wa, wb);
        acc[2] = sum16(acc[2], data + 8, wa, wb);
        acc += 3;
        data += 12;
    }
}

/* 256 times the sum of the 8-bit products. */
static inline int32_t sum8(const uint8_t *a, int16_t wa, int16_t wb)
{
    return fix_shl((int32_t)(int8_t)wg_rd8(a) * wa + (int32_t)(int8_t)wg_rd8(a + 2) * wb, 8);
}

void wg_kernel_pair8(int32_t *acc, const uint8_t *data, uint32_t weights, unsigned components)
{
    int16_t wa = (int16_t)weights, wb = (int16_t)(weights >> 16);
    for (; components > 1; components -= 2) {
        acc[0] = fix_add(acc[0], sum8(data, wa, wb));
        acc[1] = fix_add(acc[1], sum8(data + 1, wa, wb));
        acc += 2;
        data += 4;
    }
    if (components > 0) {
        acc[0] = fix_add(acc[0], sum8(data, wa, wb));
    }
}
