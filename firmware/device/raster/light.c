/* Brightness of a surface from its normal.
 * Source: Lambert's law; integer arithmetic own.
 * SPDX-License-Identifier: MIT */
#include "view.h"

#include "fix.h"

static uint8_t shade_of(const wg_view *view, const int32_t *normal)
{
    int32_t n[3] = {0, 0, 1 << 14};
    uint32_t most = wg_magnitude(normal[0]) | wg_magnitude(normal[1]) | wg_magnitude(normal[2]);
    int16_t down = (int16_t)(wg_bits(most) - 15);
    uint32_t square = 0;
    int32_t dot = 0;
    for (unsigned i = 0; i < 3; i++) {
        if (most > 0) {
            n[i] = wg_scaled(normal[i], down); /* the longest: 2^14 .. 2^15 */
        }
        square += (uint32_t)(n[i] * n[i]); /* 3 2^30 at the most */
        dot += n[i] * view->light[i];
    }
    if (dot <= 0) {
        return view->ambient;
    }
    wg_ratio per_length = wg_ratio_inverse(wg_root(square));
    per_length.bits = (int16_t)(per_length.bits - 7);
    int32_t full = 127 * 128, lit = wg_ratio_mul(dot, per_length); /* of 127 128 */
    lit = (255 - (int32_t)view->ambient) * (lit > full ? full : lit); /* < 2^22 */
    /* / (127 128) = 16513 / 2^28 within 2^-20 of it */
    return (uint8_t)(view->ambient + fix_round(fix_mulh(fix_shl(lit, 8), 16513), 4));
}

void wg_view_light(const wg_view *view, const int32_t *normals, uint16_t count, uint8_t *shades)
{
    for (uint16_t i = 0; i < count; i++) {
        shades[i] = shade_of(view, normals + 3u * (uint32_t)i);
    }
}
