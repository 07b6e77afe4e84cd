/* Reads of clip bytes and constant tables where flash is in the address space: plain loads.
 * The clip is little-endian and its records keep every field on its own alignment (SPEC 2).
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_MEM_H
#define WIGGLY_MEM_H

#include <stdint.h>

#define WG_TABLE /* where a constant table lives: nothing to say here */

static inline uint8_t wg_rd8(const void *p)
{
    return *(const uint8_t *)p;
}

static inline uint16_t wg_rd16(const void *p)
{
    return *(const uint16_t *)p;
}

static inline uint32_t wg_rd32(const void *p)
{
    return *(const uint32_t *)p;
}

#endif
