/* The bounded writer and the walk over a clip's servos. Source: own.
 * SPDX-License-Identifier: MIT */
#include "bus.h"

#include "wg_mem.h"

void wg_bytes_put(wg_bytes *out, uint8_t byte)
{
    if (out->count < out->size) {
        out->at[out->count] = byte;
    }
    if (out->count < 0x7fff) {
        out->count++;
    }
}

int wg_bytes_result(const wg_bytes *out)
{
    return out->count > out->size ? WG_ERR_SPACE : (int)out->count;
}

int16_t wg_bus_id(const wg_file *file, uint16_t index, uint8_t protocol)
{
    const uint8_t *record =
        file->section[WG_SECTION_SERVOS].at + (uint16_t)(index * WG_SERVO_BYTES);

    return wg_rd8(record + WG_SERVO_PROTOCOL) == protocol ? (int16_t)wg_rd8(record + WG_SERVO_ID)
                                                          : (int16_t)-1;
}

uint8_t wg_bus_count(const wg_file *file, uint8_t protocol)
{
    uint16_t i;
    uint8_t n = 0;

    for (i = 0; i < file->section[WG_SECTION_SERVOS].count; i++) {
        n = (uint8_t)(n + (wg_bus_id(file, i, protocol) >= 0));
    }
    return n;
}
