/* ROBOTIS Dynamixel protocol 2.0: packets with byte stuffing and CRC-16, the goal positions of all
 * servos in one Sync Write, and a parser for status packets.
 * Source: emanual.robotis.com/docs/en/dxl/protocol2. Positions are 1/4096 turn.
 *
 * Sync Write is not answered, so that frames never collide with replies. A servo moves only with
 * Torque Enable = 1, and a tripped Bus Watchdog (register 98 reads -1) makes its goal registers
 * read-only until 0 is written there.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_DYNAMIXEL2_H
#define WIGGLY_DYNAMIXEL2_H

#include "bus.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WG_DYNAMIXEL2_ID_MAX    252u
#define WG_DYNAMIXEL2_BROADCAST 0xfeu

#define WG_DYNAMIXEL2_PING       0x01u
#define WG_DYNAMIXEL2_READ       0x02u
#define WG_DYNAMIXEL2_WRITE      0x03u
#define WG_DYNAMIXEL2_REBOOT     0x08u
#define WG_DYNAMIXEL2_STATUS     0x55u
#define WG_DYNAMIXEL2_SYNC_WRITE 0x83u

/* Registers of the X series. */
#define WG_DYNAMIXEL2_TORQUE_ENABLE    64u
#define WG_DYNAMIXEL2_BUS_WATCHDOG     98u
#define WG_DYNAMIXEL2_GOAL_POSITION    116u
#define WG_DYNAMIXEL2_PRESENT_POSITION 132u

/* CRC-16 of `count` bytes: polynomial 0x8005, high bit first, start 0. */
uint16_t wg_dynamixel2_crc16(const uint8_t *bytes, uint16_t count);

/* A packet for servo `id`: parameters are as meant, stuffing is added. */
typedef struct {
    uint8_t id;          /* 0..252 or BROADCAST */
    uint8_t instruction; /* WG_DYNAMIXEL2_* or any other */
    const uint8_t *params;
    uint16_t param_count;
} wg_dynamixel2;

/* Builds one packet. Returns its bytes, WG_ERR_ADDRESS (253, 255 are not ids) or WG_ERR_SPACE. */
int wg_dynamixel2_packet(const wg_dynamixel2 *packet, uint8_t *out, uint16_t size);

/* Goal positions of all Dynamixel servos of the clip that are on and have an id <= 252, in one
 * Sync Write.
 *   returns  bytes written (0: no such servo is on), or WG_ERR_SPACE */
int wg_dynamixel2_frame(const wg_file *file, const wg_servo *state, uint8_t *out, uint16_t size);

/* ---- status packets -------------------------------------------------------------------------- */

#define WG_DYNAMIXEL2_PARAMS_MAX   12u
/* Header, length, status and error bytes, CRC, and stuffing for every third byte. */
#define WG_DYNAMIXEL2_READER_BYTES (7u + 2u + WG_DYNAMIXEL2_PARAMS_MAX + 4u + 2u)

/* Bytes not yet understood. {0} is ready. */
typedef struct {
    uint8_t at[WG_DYNAMIXEL2_READER_BYTES];
    uint8_t count;
    uint8_t dropped; /* bytes outside good packets, saturating: 0 on a healthy line */
} wg_dynamixel2_reader;

typedef struct {
    uint8_t id;
    uint8_t error; /* 0; bit 7 = hardware alert */
    uint8_t param_count;
    uint8_t params[WG_DYNAMIXEL2_PARAMS_MAX]; /* stuffing removed */
} wg_dynamixel2_status;

/* Takes one received byte. Returns 1 when a status packet is complete and `status` filled, else 0.
 * Anything else on the line, our own echo included, is dropped; a good packet behind garbage, or
 * inside what looked like the start of another, is found. Cost: at most READER_BYTES rescans. */
int wg_dynamixel2_feed(wg_dynamixel2_reader *reader, uint8_t byte, wg_dynamixel2_status *status);

#ifdef __cplusplus
}
#endif
#endif
