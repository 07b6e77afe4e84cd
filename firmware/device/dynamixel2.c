/* Dynamixel 2.0 packets. Source: emanual.robotis.com/docs/en/dxl/protocol2.
 * SPDX-License-Identifier: MIT */
#include "dynamixel2.h"

#include <string.h>

#define LENGTH_AT 5u
#define BODY_AT   7u /* the instruction: length counts, and stuffing looks at, bytes from here on */

uint16_t wg_dynamixel2_crc16(const uint8_t *bytes, uint16_t count)
{
    uint16_t crc = 0, i;
    uint8_t bit;

    for (i = 0; i < count; i++) {
        crc = (uint16_t)(crc ^ (uint16_t)bytes[i] << 8);
        for (bit = 0; bit < 8; bit++) {
            crc = (uint16_t)(crc & 0x8000 ? (uint16_t)(crc << 1) ^ 0x8005u : (uint16_t)(crc << 1));
        }
    }
    return crc;
}

static bool is_header(const uint8_t *b)
{
    return b[0] == 0xff && b[1] == 0xff && b[2] == 0xfd;
}

static void begin(wg_bytes *out, uint8_t id, uint8_t instruction)
{
    wg_bytes_put(out, 0xff);
    wg_bytes_put(out, 0xff);
    wg_bytes_put(out, 0xfd);
    wg_bytes_put(out, 0);
    wg_bytes_put(out, id);
    wg_bytes_put(out, 0);
    wg_bytes_put(out, 0);
    wg_bytes_put(out, instruction);
}

/* One byte of the body, and the FD that keeps FF FF FD from looking like a header. The length is
 * still 0 here, so nothing in front of the body takes part. */
static void put(wg_bytes *out, uint8_t byte)
{
    wg_bytes_put(out, byte);
    if (out->count <= out->size && is_header(out->at + out->count - 3)) {
        wg_bytes_put(out, 0xfd);
    }
}

/* Length and CRC count the stuffed bytes: both come last. */
static int end(wg_bytes *out)
{
    uint16_t length = (uint16_t)(out->count - BODY_AT + 2), crc;

    if (out->count > out->size) {
        return WG_ERR_SPACE;
    }
    out->at[LENGTH_AT] = (uint8_t)length;
    out->at[LENGTH_AT + 1] = (uint8_t)(length >> 8);
    crc = wg_dynamixel2_crc16(out->at, out->count);
    wg_bytes_put(out, (uint8_t)crc);
    wg_bytes_put(out, (uint8_t)(crc >> 8));
    return wg_bytes_result(out);
}

int wg_dynamixel2_packet(const wg_dynamixel2 *packet, uint8_t *out, uint16_t size)
{
    wg_bytes bytes = {out, size, 0};
    uint16_t i;

    if (packet->id > WG_DYNAMIXEL2_ID_MAX && packet->id != WG_DYNAMIXEL2_BROADCAST) {
        return WG_ERR_ADDRESS;
    }
    begin(&bytes, packet->id, packet->instruction);
    for (i = 0; i < packet->param_count; i++) {
        put(&bytes, packet->params[i]);
    }
    return end(&bytes);
}

int wg_dynamixel2_frame(const wg_file *file, const wg_servo *state, uint8_t *out, uint16_t size)
{
    wg_bytes bytes = {out, size, 0};
    uint16_t i;
    uint8_t servos = 0, k;

    begin(&bytes, WG_DYNAMIXEL2_BROADCAST, WG_DYNAMIXEL2_SYNC_WRITE);
    put(&bytes, WG_DYNAMIXEL2_GOAL_POSITION);
    put(&bytes, 0);
    put(&bytes, 4);
    put(&bytes, 0);
    for (i = 0; i < file->section[WG_SECTION_SERVOS].count; i++) {
        int16_t id = wg_bus_id(file, i, WG_PROTOCOL_DYNAMIXEL2);
        uint32_t position = (uint32_t)(int32_t)wg_servo_position(&state[i]);
        if (id < 0 || (unsigned)id > WG_DYNAMIXEL2_ID_MAX || !wg_servo_on(&state[i])) {
            continue;
        }
        put(&bytes, (uint8_t)id);
        for (k = 0; k < 4; k++) {
            put(&bytes, (uint8_t)(position >> (8 * k)));
        }
        servos++;
    }
    return servos ? end(&bytes) : 0;
}

/* What the bytes at the start are: 0 = the start of a packet, -1 = no packet, else its length. */
static int examine(const wg_dynamixel2_reader *r)
{
    static const uint8_t head[4] = {0xff, 0xff, 0xfd, 0x00};
    uint16_t length, crc;

    if (memcmp(r->at, head, r->count < 4 ? r->count : 4) != 0) {
        return -1;
    }
    if (r->count < BODY_AT) {
        return 0;
    }
    length = (uint16_t)((uint16_t)r->at[LENGTH_AT + 1] << 8);
    length = (uint16_t)(length + r->at[LENGTH_AT] + BODY_AT);
    if (length < BODY_AT + 4 || length > WG_DYNAMIXEL2_READER_BYTES) {
        return -1;
    }
    if (r->count < length) {
        return 0;
    }
    crc = wg_dynamixel2_crc16(r->at, (uint16_t)(length - 2));
    return r->at[length - 2] == (uint8_t)crc && r->at[length - 1] == (uint8_t)(crc >> 8) &&
                   r->at[BODY_AT] == WG_DYNAMIXEL2_STATUS
               ? (int)length
               : -1;
}

static void drop(wg_dynamixel2_reader *r, uint8_t bytes)
{
    r->count = (uint8_t)(r->count - bytes);
    memmove(r->at, r->at + bytes, r->count);
}

/* Fills `status` from a checked packet. Returns 1, or 0 with more parameters than fit. */
static int unpack(const uint8_t *at, uint8_t length, wg_dynamixel2_status *status)
{
    uint8_t i, n = 0;

    status->id = at[4];
    status->error = at[BODY_AT + 1];
    for (i = BODY_AT + 2; i < length - 2; i++) {
        if (i >= BODY_AT + 3 && at[i] == 0xfd && is_header(at + i - 3)) {
            continue;
        }
        if (n == WG_DYNAMIXEL2_PARAMS_MAX) {
            return 0;
        }
        status->params[n++] = at[i];
    }
    status->param_count = n;
    return 1;
}

int wg_dynamixel2_feed(wg_dynamixel2_reader *reader, uint8_t byte, wg_dynamixel2_status *status)
{
    reader->at[reader->count++] = byte;
    while (reader->count) { /* each pass drops a byte or returns: the buffer is never full here */
        int length = examine(reader);
        int good;
        if (length == 0) {
            return 0;
        }
        if (length > 0) {
            good = unpack(reader->at, (uint8_t)length, status);
            drop(reader, (uint8_t)length);
            if (good) {
                return 1;
            }
            continue;
        }
        drop(reader, 1);
        if (reader->dropped < 255) {
            reader->dropped++;
        }
    }
    return 0;
}
