/* Steps out of tables in flash. Source: own.
 * SPDX-License-Identifier: MIT */
#include "display.h"

#include "wg_mem.h"

wg_step wg_step_read(const uint8_t (*table)[WG_STEP_ROW], uint8_t count, uint8_t index)
{
    wg_step step = {0, 0, {0}};
    if (index < count) {
        const uint8_t *row = table[index];
        step.count = wg_rd8(row);
        step.wait_ms = wg_rd8(row + 1);
        for (uint8_t i = 0; i < WG_STEP_BYTES; i++) {
            step.bytes[i] = wg_rd8(row + 2 + i);
        }
    }
    return step;
}
