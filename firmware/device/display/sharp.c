/* Sharp Memory LCD commands. Source: Sharp application note "Memory LCD Programming".
 * SPDX-License-Identifier: MIT */
#include "sharp.h"

#include <string.h>

#define M0_WRITE 0x80u
#define M1_VCOM  0x40u
#define M2_CLEAR 0x20u

static wg_step command(uint8_t mode, uint8_t vcom)
{
    wg_step step = {2, 0, {0}}; /* the second byte: time to take it over */

    step.bytes[0] = (uint8_t)(mode | (vcom ? M1_VCOM : 0u));
    return step;
}

wg_step wg_sharp_clear(uint8_t vcom)
{
    return command(M2_CLEAR, vcom);
}

wg_step wg_sharp_vcom(uint8_t vcom)
{
    return command(0, vcom);
}

/* The bits of a byte in the opposite order. */
static uint8_t reversed(uint8_t byte)
{
    uint8_t out = 0;
    for (uint8_t i = 0; i < 8; i++) {
        out = (uint8_t)((unsigned)out << 1 | ((unsigned)byte >> i & 1u));
    }
    return out;
}

uint16_t wg_sharp_lines(wg_rect rect, uint8_t vcom, uint8_t *bytes)
{
    uint16_t lines = (uint16_t)(rect.y1 - rect.y0), width = (uint16_t)(rect.x1 >> 3);
    uint16_t stride = (uint16_t)(width + 2u); /* number, pixels, trailer */

    /* Every line moves to the right, the last one farthest: from the last to the first. */
    for (uint16_t i = lines; i > 0; i--) {
        uint8_t *line = bytes + 1u + (uint16_t)((i - 1u) * stride);
        memmove(line + 1, bytes + (uint16_t)((i - 1u) * width), width);
        line[0] = reversed((uint8_t)(rect.y0 + i)); /* lines count from 1 */
        line[width + 1u] = 0;
    }
    bytes[0] = command(M0_WRITE, vcom).bytes[0];
    bytes[1u + (uint16_t)(lines * stride)] = 0;
    return (uint16_t)(2u + lines * stride);
}
