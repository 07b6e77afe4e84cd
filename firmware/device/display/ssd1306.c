/* SSD1306 and SSD0303 commands. Source: SSD1306 data sheet Rev 1.5, section 9; SSD0303 data sheet.
 * SPDX-License-Identifier: MIT */
#include "ssd1306.h"

#include "wg_mem.h"

#define CONTROL_COMMAND 0x80u /* one command byte, then another control byte */

#define PAGE        0xb0u
#define COLUMN_LOW  0x00u
#define COLUMN_HIGH 0x10u
#define CONTRAST    0x81u
#define MULTIPLEX   0xa8u
#define COM_PINS    0xdau

wg_step wg_ssd1306_setup(const wg_ssd1306 *glass, uint8_t index)
{
    static const uint8_t table[][WG_STEP_ROW] WG_TABLE = {
        {1, 0, 0xae},         /* off */
        {2, 0, 0xd5, 0x80},   /* clock: the reset value */
        {2, 0, MULTIPLEX, 0}, /* rows - 1 */
        {2, 0, 0xd3, 0x00},   /* no offset */
        {1, 0, 0x40},         /* row 0 is the first */
        {2, 0, 0x8d, 0x14},   /* charge pump on */
        {2, 0, 0x20, 0x02},   /* page addressing */
        {1, 0, 0xa1},         /* column 127 is segment 0: with the connector above the glass, */
        {1, 0, 0xc8},         /* and rows from the last to the first */
        {2, 0, COM_PINS, 0},  /* glass */
        {2, 0, CONTRAST, 0},  /* glass */
        {2, 0, 0xd9, 0xf1},   /* precharge, as the charge pump wants it */
        {2, 0, 0xdb, 0x40},   /* deselect level */
        {1, 0, 0x2e},         /* no scrolling */
        {1, 0, 0xa4},         /* show the memory */
        {1, 0, 0xa6},         /* 1 is bright */
        {1, 0, 0xaf},         /* on */
    };
    wg_step step = wg_step_read(table, sizeof table / sizeof table[0], index);

    switch (step.bytes[0]) {
    case MULTIPLEX:
        step.bytes[1] = (uint8_t)(glass->height - 1u);
        break;
    case COM_PINS:
        step.bytes[1] = glass->com_pins;
        break;
    case CONTRAST:
        step.bytes[1] = glass->contrast;
        break;
    default:
        break;
    }
    return step;
}

wg_step wg_ssd0303_setup(uint8_t index)
{
    static const uint8_t table[][WG_STEP_ROW] WG_TABLE = {
        {1, 0, 0xae},            /* off */
        {2, 0, CONTRAST, 0x2b},  /* contrast */
        {1, 0, 0xa1},            /* column 131 is segment 0 */
        {1, 0, 0x40},            /* row 0 is the first */
        {2, 0, 0xd3, 0x00},      /* no offset */
        {2, 0, MULTIPLEX, 0x0f}, /* 16 rows */
        {1, 0, 0xa4},            /* show the memory */
        {1, 0, 0xa6},            /* 1 is bright */
        {1, 0, 0xc8},            /* rows from the last to the first */
        {2, 0, 0xd5, 0x72},      /* clock */
        {2, 0, 0xd8, 0x00},      /* one colour */
        {2, 0, 0xd9, 0x22},      /* precharge */
        {2, 0, COM_PINS, 0x12},  /* rows wired alternately */
        {2, 0, 0xdb, 0x0f},      /* deselect level */
        {2, 0, 0xad, 0x8b},      /* its own supply for the glass */
        {1, 0, 0xaf},            /* on */
    };
    return wg_step_read(table, sizeof table / sizeof table[0], index);
}

wg_step wg_ssd1306_window(wg_rect rect, uint8_t column)
{
    uint8_t x = (uint8_t)(rect.x0 + column);
    wg_step step = {3, 0, {0}};

    step.bytes[0] = (uint8_t)(PAGE | (rect.y0 >> 3));
    step.bytes[1] = (uint8_t)(COLUMN_LOW | (x & 15u));
    step.bytes[2] = (uint8_t)(COLUMN_HIGH | (x >> 4));
    return step;
}

uint8_t wg_ssd1306_i2c(const wg_step *step, uint8_t *out)
{
    for (uint8_t i = 0; i < step->count; i++) {
        out[2 * i] = CONTROL_COMMAND;
        out[2 * i + 1] = step->bytes[i];
    }
    return (uint8_t)(2u * step->count);
}
