/* Fields of an open clip on the host, by SPEC 4.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_RECORD_H
#define BAKE_RECORD_H

#include <stddef.h>

#include "wiggly.h"

static inline int get8(const uint8_t *at)
{
    return at[0];
}

static inline int get16(const uint8_t *at)
{
    return at[0] | at[1] << 8;
}

static inline uint32_t get32(const uint8_t *at)
{
    return (uint32_t)get16(at) | (uint32_t)get16(at + 2) << 16;
}

/* Record `index` of a section whose records have `stride` bytes. */
static inline const uint8_t *record(const wg_file *file, unsigned kind, int index, unsigned stride)
{
    return file->section[kind].at + (size_t)index * stride;
}

static inline const uint8_t *clip_record(const wg_file *file, int clip)
{
    return record(file, WG_SECTION_CLIPS, clip, WG_CLIP_BYTES);
}

#endif
