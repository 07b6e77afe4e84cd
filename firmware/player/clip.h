/* Inside the player: records of an open clip and its time base.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_CLIP_H
#define WIGGLY_CLIP_H

#include "wiggly.h"
#include "wg_mem.h"

/* A record of a section; `stride` is the WG_*_BYTES of its kind. */
static inline const uint8_t *wg_record(const wg_file *file, uint8_t kind, uint32_t index,
                                       uint32_t stride)
{
    return file->section[kind].at + index * stride;
}

static inline const uint8_t *wg_clip_record(const wg_file *file, uint8_t clip)
{
    return wg_record(file, WG_SECTION_CLIPS, clip, WG_CLIP_BYTES);
}

static inline int wg_channel_frac(const wg_file *file, uint16_t channel)
{
    return (int8_t)wg_rd8(wg_record(file, WG_SECTION_CHANNELS, channel, WG_CHANNEL_BYTES) +
                          WG_CHANNEL_FRAC);
}

/* Duration in us Q16 (48 bits). */
uint64_t wg_clip_duration(const wg_file *file, uint8_t clip);

/* Rest values of all channels. */
void wg_rest(const wg_file *file, int32_t *values);

/* The clip's filters over mixed values, in order (Alexa 7.1.2). */
void wg_filter(const wg_file *file, int32_t *values);

#endif
