/* Brightness of a surface from its normal.
 * Source: Lambert's law; integer arithmetic own.
 * SPDX-License-Identifier: MIT */
#include "view.h"

#include "fix.h"

#define FULL (127 * 128)

static uint8_t shade_of(const wg_view *view, const int32_t *normal)
{
    wg_ratio f = {WG_FAR, 23}; /* 128 */
    int bits = wg_bits_3(normal);
    uint32_t square = 0;
    int32_t dot = 0;
    for (unsigned i = 0; i < 3; i++) { /* the longest: 2^14 .. 2^15 */
        int32_t n = bits > 0 ? wg_scaled(normal[i], bits - 15) : i < 2 ? 0 : FULL;
        square += (uint32_t)(n * n); /* 3 2^30 at the most */
        dot += n * view->light[i];
    }
    if (dot <= 0) {
        return view->ambient;
    }
    wg_ratio_divide(&f, wg_root(square));
    int32_t lit = wg_ratio_mul(dot, &f);
    lit = (255 - (int32_t)view->ambient) * (lit > FULL ? FULL : lit); /* < 2^22 */
    /* / FULL = 16513 / 2^28 within 2^-20 of it */
    return (uint8_t)(view->ambient + fix_round(fix_mulh(fix_shl(lit, 8), 16513), 4));
}

void wg_view_light(const wg_view *view, const int32_t *normals, uint16_t count, uint8_t *shades)
{
    for (; count > 0; count--, normals += 3) {
        *shades++ = shade_of(view, normals);
    }
}
