/* One clip as a pure function of time: position in ticks, all channels at once.
 * Source: own (SPEC 6.2).
 * SPDX-License-Identifier: MIT */
#include "clip.h"
#include "fix.h"

uint64_t wg_clip_duration(const wg_file *file, uint8_t clip)
{
    const uint8_t *c = wg_clip_record(file, clip);
    return ((uint64_t)wg_rd32(c + WG_CLIP_US) << 16) | wg_rd16(c + WG_CLIP_US_FRAC);
}

/* mul is ticks a us, normalised to 32 significant bits: off by 2^-32 of the time, 15 ns in a
 * minute. */
uint32_t wg_clip_position(const wg_file *file, uint8_t clip, uint32_t time_us)
{
    const uint8_t *c = wg_clip_record(file, clip);
    uint64_t ticks_q16 =
        ((uint64_t)time_us * wg_rd32(c + WG_CLIP_MUL)) >> wg_rd8(c + WG_CLIP_MUL_SHIFT);
    uint32_t end_q16 = (uint32_t)wg_rd16(c + WG_CLIP_TICKS) << 16;
    return ticks_q16 > end_q16 ? end_q16 : (uint32_t)ticks_q16;
}

void wg_rest(const wg_file *file, int32_t *values)
{
    const uint8_t *channel = file->section[WG_SECTION_CHANNELS].at;
    for (uint16_t i = 0; i < file->section[WG_SECTION_CHANNELS].count; i++) {
        values[i] = (int32_t)wg_rd32(channel + WG_CHANNEL_REST);
        channel += WG_CHANNEL_BYTES;
    }
}

void wg_clip_sample(const wg_file *file, uint8_t clip, uint32_t time_us, int32_t *values,
                    int32_t *velocities)
{
    const uint8_t *c = wg_clip_record(file, clip);
    uint32_t position = wg_clip_position(file, clip, time_us);
    uint16_t track = wg_rd16(c + WG_CLIP_TRACK_FIRST);
    uint16_t rate = wg_rd16(c + WG_CLIP_RATE);
    wg_rest(file, values);
    for (uint16_t i = 0; velocities && i < file->section[WG_SECTION_CHANNELS].count; i++) {
        velocities[i] = 0;
    }
    for (uint16_t n = wg_rd16(c + WG_CLIP_TRACK_COUNT); n > 0; n--, track++) {
        uint16_t channel =
            wg_rd16(wg_record(file, WG_SECTION_TRACKS, track, WG_TRACK_BYTES) + WG_TRACK_CHANNEL);
        values[channel] = wg_track_value(file, track, position);
        if (velocities) {
            velocities[channel] = wg_track_velocity(file, track, position, rate);
        }
    }
}
