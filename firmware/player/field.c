/* Fields: channels that are means of others.
 * Source: Jacobson 2013, (5.2); the integer form is ours (SPEC 6.12).
 * SPDX-License-Identifier: MIT */
#include "clip.h"
#include "fix.h"

void wg_fields_set(const wg_file *file, int32_t *values)
{
    const uint8_t *field = file->section[WG_SECTION_FIELDS].at;
    for (uint16_t left = file->section[WG_SECTION_FIELDS].count; left > 0; left--) {
        uint16_t channel = wg_rd16(field + WG_FIELD_CHANNEL);
        uint8_t count = wg_rd8(field + WG_FIELD_COUNT);
        int frac = wg_channel_frac(file, channel);
        const uint8_t *from = file->section[WG_SECTION_DATA].at + wg_rd32(field + WG_FIELD_DATA);
        const uint8_t *weight = from + 2u * count;
        int32_t sum = 0;
        for (uint8_t i = 0; i < count; i++) {
            uint16_t j = wg_rd16(from + 2u * i);
            uint16_t w = (uint16_t)((wg_rd8(weight + i) + (i == 0)) << 7);
            sum = fix_add(sum, fix_weigh(fix_scale(values[j], frac - wg_channel_frac(file, j)), w));
        }
        values[channel] = fix_clamp(sum, -FIX_VALUE_MAX, FIX_VALUE_MAX);
        field += WG_FIELD_BYTES;
    }
}
