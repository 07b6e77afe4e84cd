/* Inside the player: what the checks of an opened clip have in common.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_OPEN_H
#define WIGGLY_OPEN_H

#include "clip.h"

static inline bool wg_is_small(uint32_t value) /* |value| <= WG_VALUE_LIMIT as int32 */
{
    return value + (uint32_t)WG_VALUE_LIMIT <= 2u * (uint32_t)WG_VALUE_LIMIT;
}

/* first .. first + count - 1 exist among `total`. */
static inline bool wg_is_range(uint16_t first, uint16_t count, uint16_t total)
{
    return first <= total && count <= total - first;
}

/* `bytes` bytes at `offset` of DATA, on a multiple of `unit`. 64 bits: no sum can wrap. */
static inline bool wg_is_data(const wg_file *file, uint32_t offset, uint64_t bytes, uint32_t unit)
{
    return offset % unit == 0 && offset + bytes <= file->section[WG_SECTION_DATA].bytes;
}

#endif
