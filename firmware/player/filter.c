/* Filters over mixed channel values: offset, gain, clamp, minimum, matrix mix.
 * Source: Alexa 2002, 7.1.2 (SPEC 4.9); every result saturates to the value range.
 * SPDX-License-Identifier: MIT */
#include "clip.h"
#include "fix.h"

/* r' = M r over n <= 8 listed channels; M in Q12. 8 products of 2^29 2^15 stay below 2^47. */
static void mix_matrix(const wg_file *file, const uint8_t *filter, int32_t *values)
{
    const uint8_t *list = file->section[WG_SECTION_DATA].at + wg_rd32(filter + WG_FILTER_A);
    unsigned n = wg_rd8(filter + WG_FILTER_N);
    const uint8_t *m = list + 2u * n;
    int32_t in[WG_MATRIX_MAX];
    for (unsigned i = 0; i < n; i++) {
        in[i] = values[wg_rd16(list + 2u * i)];
    }
    for (unsigned i = 0; i < n; i++) {
        int64_t sum = 0;
        for (unsigned j = 0; j < n; j++) {
            sum += (int64_t)in[j] * (int16_t)wg_rd16(m + 2u * (n * i + j));
        }
        values[wg_rd16(list + 2u * i)] = fix_value(sum >> 12);
    }
}

static int32_t filtered(int32_t v, uint8_t op, int32_t a, int32_t b)
{
    switch (op) {
    case WG_FILTER_OFFSET:
        return fix_value((int64_t)v + a);
    case WG_FILTER_GAIN:
        return fix_value(b + (((int64_t)v - b) * a >> 16));
    case WG_FILTER_CLAMP:
        return fix_clamp(v, a, b);
    default: /* WG_FILTER_MIN */
        return v < a ? a : v;
    }
}

void wg_filter(const wg_file *file, int32_t *values)
{
    const uint8_t *filter = file->section[WG_SECTION_FILTERS].at;
    for (uint16_t i = 0; i < file->section[WG_SECTION_FILTERS].count; i++) {
        uint8_t op = wg_rd8(filter + WG_FILTER_OP);
        if (op == WG_FILTER_MATRIX) {
            mix_matrix(file, filter, values);
        } else {
            int32_t *v = &values[wg_rd16(filter + WG_FILTER_CHANNEL)];
            *v = filtered(*v, op, (int32_t)wg_rd32(filter + WG_FILTER_A),
                          (int32_t)wg_rd32(filter + WG_FILTER_B));
        }
        filter += WG_FILTER_BYTES;
    }
}
