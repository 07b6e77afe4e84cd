/* MIPI display commands. Source: ST7789V data sheet V1.0; ILI9341 data sheet V1.11.
 * SPDX-License-Identifier: MIT */
#include "mipi_dcs.h"

#include "wg_mem.h"

#define RESET      0x01u
#define SLEEP_OUT  0x11u
#define NORMAL     0x13u
#define INVERT_OFF 0x20u
#define INVERT_ON  0x21u
#define ON         0x29u
#define COLUMNS    0x2au
#define ROWS       0x2bu
#define WRITE      0x2cu
#define ORDER      0x36u
#define FORMAT     0x3au

wg_step wg_dcs_setup(const wg_dcs *glass, uint8_t index)
{
    static const uint8_t table[][WG_STEP_ROW] WG_TABLE = {
        {1, 120, RESET},      /* 5 ms, but 120 ms until SLEEP_OUT of a chip that was awake */
        {1, 120, SLEEP_OUT},  /* 5 ms, but its supplies take 120 ms */
        {2, 0, FORMAT, 0x55}, /* 16 bits */
        {2, 0, ORDER, 0},     /* glass */
        {1, 0, INVERT_OFF},   /* glass */
        {1, 0, NORMAL},       /* all of the glass */
        {1, 0, ON},
    };
    wg_step step = wg_step_read(table, sizeof table / sizeof table[0], index);

    if (step.bytes[0] == ORDER) {
        step.bytes[1] = glass->order;
    }
    if (step.bytes[0] == INVERT_OFF && glass->invert) {
        step.bytes[0] = INVERT_ON;
    }
    return step;
}

/* Two words, high byte first. */
static wg_step range(uint8_t command, uint16_t first, uint16_t last)
{
    wg_step step = {5, 0, {0}};

    step.bytes[0] = command;
    step.bytes[1] = (uint8_t)(first >> 8);
    step.bytes[2] = (uint8_t)first;
    step.bytes[3] = (uint8_t)(last >> 8);
    step.bytes[4] = (uint8_t)last;
    return step;
}

wg_step wg_dcs_window(const wg_dcs *glass, wg_rect rect, uint8_t index)
{
    wg_step write = {1, 0, {WRITE}}, none = {0, 0, {0}};

    switch (index) {
    case 0:
        return range(COLUMNS, (uint16_t)(rect.x0 + glass->x), (uint16_t)(rect.x1 + glass->x - 1u));
    case 1:
        return range(ROWS, (uint16_t)(rect.y0 + glass->y), (uint16_t)(rect.y1 + glass->y - 1u));
    case 2:
        return write;
    default:
        return none;
    }
}
