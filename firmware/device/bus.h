/* What the servo protocols share: a bounded byte writer, and the size of a buffer that always fits.
 *
 *   static uint8_t frame[WG_BUS_BYTES(CLIP_SERVOS)];
 *
 *   wg_servo_step(&file, servos, values, dt_us);
 *   int bytes = wg_maestro_frame(&file, servos, WG_MAESTRO_COMPACT, frame, sizeof frame);
 *   if (bytes > 0) hal_bus_write(frame, (uint16_t)bytes);
 *
 * wg_dynamixel2_frame and wg_pca9685_frame are the same for the other protocols. The caller names
 * the protocol it wants, so that only that one is linked.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_BUS_H
#define WIGGLY_BUS_H

#include "servo.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WG_ERR_SPACE   (-32) /* the buffer is too small: what is in it is of no use */
#define WG_ERR_ADDRESS (-33) /* a device number that the protocol does not have */

/* Worst case of one frame for n servos. Maestro: every servo alone, 7 bytes with device number and
 * CRC. Dynamixel 2.0: 14 + 5n and a stuffing byte for at most every third of 5n + 5 bytes. PCA9685:
 * 65 for all 16 channels of a chip. */
#define WG_BUS_BYTES(servos) (65u + 7u * (unsigned)(servos))

/* Bytes written so far, and how many there would be with room for all: > size is an overflow. */
typedef struct {
    uint8_t *at;
    uint16_t size;
    uint16_t count;
} wg_bytes;

/* Appends one byte; outside the buffer it only counts. */
void wg_bytes_put(wg_bytes *out, uint8_t byte);

/* The byte count, or WG_ERR_SPACE. */
int wg_bytes_result(const wg_bytes *out);

/* How many servos of the clip use `protocol` (WG_PROTOCOL_*). */
uint8_t wg_bus_count(const wg_file *file, uint8_t protocol);

/* The id of servo `index` when it uses `protocol`, else -1. */
int16_t wg_bus_id(const wg_file *file, uint16_t index, uint8_t protocol);

#ifdef __cplusplus
}
#endif
#endif
