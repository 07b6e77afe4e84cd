/* Pololu Maestro commands. Source: Maestro User's Guide 5.c to 5.f.
 * SPDX-License-Identifier: MIT */
#include "maestro.h"

#define MICRO_CHANNELS 6 /* of the Micro Maestro, the one that lacks Set Multiple Targets */

uint16_t wg_maestro_options(const wg_file *file)
{
    for (uint16_t i = 0; i < file->section[WG_SECTION_SERVOS].count; i++) {
        if (wg_bus_id(file, i, WG_PROTOCOL_MAESTRO) >= MICRO_CHANNELS) {
            return WG_MAESTRO_COMPACT;
        }
    }
    return WG_MAESTRO_COMPACT | WG_MAESTRO_SINGLE;
}

uint8_t wg_maestro_crc7(const uint8_t *bytes, uint16_t count)
{
    uint8_t crc = 0, bit;
    uint16_t i;

    for (i = 0; i < count; i++) {
        crc ^= bytes[i];
        for (bit = 0; bit < 8; bit++) {
            crc = (uint8_t)(crc & 1 ? (crc ^ 0x91) >> 1 : crc >> 1);
        }
    }
    return crc;
}

/* Command byte in the chosen protocol. Returns where the command starts, for its CRC. */
static uint16_t begin(wg_bytes *out, uint16_t options, uint8_t command)
{
    uint16_t start = out->count;

    if (!(options & WG_MAESTRO_COMPACT)) {
        wg_bytes_put(out, 0xaa);
        wg_bytes_put(out, (uint8_t)(options & 0x7f));
        command &= 0x7f;
    }
    wg_bytes_put(out, command);
    return start;
}

static void end(wg_bytes *out, uint16_t options, uint16_t start)
{
    if (!(options & WG_MAESTRO_CRC)) {
        return;
    }
    /* After an overflow there is nothing to sum: the byte only counts. */
    wg_bytes_put(out, out->count > out->size
                          ? 0
                          : wg_maestro_crc7(out->at + start, (uint16_t)(out->count - start)));
}

static void put_value(wg_bytes *out, int16_t value)
{
    uint16_t v = value < 0 ? 0 : value > 16383 ? 16383 : (uint16_t)value;

    wg_bytes_put(out, (uint8_t)(v & 0x7f));
    wg_bytes_put(out, (uint8_t)(v >> 7));
}

void wg_maestro_command(wg_bytes *out, uint16_t options, uint8_t command)
{
    end(out, options, begin(out, options, command));
}

void wg_maestro_set(wg_bytes *out, uint16_t options, uint8_t command, uint8_t channel,
                    int16_t value)
{
    uint16_t start = begin(out, options, command);

    wg_bytes_put(out, channel & 0x7f);
    put_value(out, value);
    end(out, options, start);
}

void wg_maestro_minissc(wg_bytes *out, uint8_t channel, uint8_t position)
{
    wg_bytes_put(out, 0xff);
    wg_bytes_put(out, channel > 254 ? 254 : channel);
    wg_bytes_put(out, position > 254 ? 254 : position);
}

static int16_t value_of(const wg_servo *servo)
{
    return wg_servo_on(servo) ? wg_servo_position(servo) : (int16_t)0;
}

/* How many servos from `first` on have consecutive ids. */
static uint16_t run_length(const wg_file *file, uint16_t first, int16_t id)
{
    uint16_t n = 1;

    while (first + n < file->section[WG_SECTION_SERVOS].count &&
           wg_bus_id(file, (uint16_t)(first + n), WG_PROTOCOL_MAESTRO) ==
               (int16_t)(id + (int16_t)n)) {
        n++;
    }
    return n;
}

int wg_maestro_frame(const wg_file *file, const wg_servo *state, uint16_t options, uint8_t *out,
                     uint16_t size)
{
    wg_bytes bytes = {out, size, 0};
    uint16_t i, n;

    for (i = 0; i < file->section[WG_SECTION_SERVOS].count; i = (uint16_t)(i + n)) {
        int16_t id = wg_bus_id(file, i, WG_PROTOCOL_MAESTRO);
        uint16_t k, start;
        n = 1;
        if (id < 0) {
            continue;
        }
        if (!(options & WG_MAESTRO_SINGLE)) {
            n = run_length(file, i, id);
        }
        if (n == 1) {
            wg_maestro_set(&bytes, options, WG_MAESTRO_TARGET, (uint8_t)id, value_of(&state[i]));
            continue;
        }
        start = begin(&bytes, options, WG_MAESTRO_MULTIPLE);
        wg_bytes_put(&bytes, (uint8_t)n);
        wg_bytes_put(&bytes, (uint8_t)id);
        for (k = 0; k < n; k++) {
            put_value(&bytes, value_of(&state[i + k]));
        }
        end(&bytes, options, start);
    }
    return wg_bytes_result(&bytes);
}
