/* Brightness of vertices: the mean of the bones' value channels.
 * Source: own (SPEC 6.11). Apart from skin.c: most skins have none.
 * SPDX-License-Identifier: MIT */
#include "skin.h"

/* 1 = 2^16; 0 for a bone without a channel. */
static int32_t brightness(const wg_skin *skin, const int32_t *values, uint8_t bone)
{
    uint16_t channel = wg_rd16(wg_skin_bone(skin, bone) + WG_BONE_VALUE);
    return channel == WG_ABSENT
               ? 0
               : fix_scale(values[channel], 16 - wg_channel_frac(skin->file, channel));
}

void wg_skin_brightness(const wg_skin *skin, const int32_t *values, uint16_t first, uint16_t count,
                        uint8_t *out)
{
    const uint32_t range[2] = {first, (uint32_t)first + count};
    uint16_t spans = wg_rd16(skin->record + WG_SKIN_SPAN_COUNT);
    uint8_t each = (uint8_t)(2u + wg_rd8(skin->record + WG_SKIN_ENDS));
    for (uint16_t i = 0; i < spans; i++) {
        wg_skin_cut cut = wg_skin_span(skin, i, range);
        for (uint8_t *at = out + (unsigned)cut.at; cut.count > 0; cut.count--, at++) {
            int32_t sum = 0;
            uint16_t more = 1; /* the first weight counts one more */
            for (uint8_t n = cut.influences; n > 0; n--, more = 0) {
                uint16_t w = (uint16_t)((wg_rd8(cut.data + 1) + more) << 7);
                sum = fix_add(sum, fix_weigh(brightness(skin, values, wg_rd8(cut.data)), w));
                cut.data += each;
            }
            *at = (uint8_t)fix_clamp(sum >> 8, 0, 255);
        }
    }
}
