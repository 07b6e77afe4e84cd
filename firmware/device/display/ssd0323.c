/* SSD0323 commands. Source: SSD0323 data sheet, command table; OSRAM AN018.
 * SPDX-License-Identifier: MIT */
#include "ssd0323.h"

#include "wg_mem.h"

wg_step wg_ssd0323_setup(uint8_t index)
{
    static const uint8_t table[][WG_STEP_ROW] WG_TABLE = {
        {1, 0, 0xae},       /* off */
        {2, 0, 0x81, 0x32}, /* contrast */
        {1, 0, 0x85},       /* half of the current range */
        {2, 0, 0xa0, 0x52}, /* odd and even rows on two sides, from the last; left pixel above */
        {2, 0, 0xa1, 0x00}, /* row 0 is the first */
        {2, 0, 0xa2, 0x4c}, /* which of the 80 rows the glass begins with */
        {1, 0, 0xa4},       /* show the memory */
        {2, 0, 0xa8, 0x3f}, /* 64 rows */
        {2, 0, 0xb1, 0x22}, /* phases */
        {2, 0, 0xb2, 0x46}, /* row period */
        {2, 0, 0xb3, 0xf1}, /* clock */
        {2, 0, 0xbf, 0x0d}, /* low level of segments */
        {2, 0, 0xbe, 0x02}, /* deselect level */
        {2, 0, 0xbc, 0x10}, /* precharge */
        {9, 0, 0xb8, 0x01, 0x11, 0x22, 0x32, 0x43, 0x54, 0x65, 0x76}, /* greys */
        {2, 0, 0xad, 0x03},                                           /* its own supply */
        {1, 0, 0xaf},                                                 /* on */
    };
    return wg_step_read(table, sizeof table / sizeof table[0], index);
}

wg_step wg_ssd0323_window(wg_rect rect)
{
    wg_step step = {6, 0, {0x15, 0, 0, 0x75, 0, 0}};

    step.bytes[1] = (uint8_t)(rect.x0 >> 1); /* columns of two pixels */
    step.bytes[2] = (uint8_t)((rect.x1 >> 1) - 1u);
    step.bytes[4] = (uint8_t)rect.y0;
    step.bytes[5] = (uint8_t)(rect.y1 - 1u);
    return step;
}
