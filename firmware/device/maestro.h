/* Pololu Maestro servo controllers: targets as quarter microseconds of pulse.
 * Source: Pololu Maestro Servo Controller User's Guide, sections 5.c to 5.f.
 *
 * A channel that is off jumps to its next target at full speed, whatever speed and acceleration the
 * Maestro was told [5.e]: a soft start has to come from wg_servo_start, with the servo on from the
 * first frame.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_MAESTRO_H
#define WIGGLY_MAESTRO_H

#include "bus.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How to speak: a device number 0..127 (12 from the factory) or COMPACT, plus flags. */
#define WG_MAESTRO_COMPACT 0x0080u /* no device number: the only Maestro on the line */
#define WG_MAESTRO_CRC     0x0100u /* CRC-7 behind every command, when the Maestro wants it */
#define WG_MAESTRO_SINGLE  0x0200u /* never Set Multiple Targets: the Micro Maestro 6 lacks it */

#define WG_MAESTRO_TARGET       0x84u /* 1/4 us, 0 = pulses off */
#define WG_MAESTRO_SPEED        0x87u /* 1/4 us per 10 ms, 0 = unlimited */
#define WG_MAESTRO_ACCELERATION 0x89u /* 1/4 us per 10 ms per 80 ms, 0 = unlimited */
#define WG_MAESTRO_MULTIPLE     0x9fu
#define WG_MAESTRO_GET_POSITION 0x90u
#define WG_MAESTRO_GET_ERRORS   0xa1u
#define WG_MAESTRO_GO_HOME      0xa2u

/* COMPACT, with SINGLE when every Maestro id is below 6: a Micro Maestro may be there. */
uint16_t wg_maestro_options(const wg_file *file);

/* CRC-7 of `count` bytes: polynomial 0x91, low bit first, start 0. */
uint8_t wg_maestro_crc7(const uint8_t *bytes, uint16_t count);

/* Appends a command without arguments: GET_ERRORS, GO_HOME. */
void wg_maestro_command(wg_bytes *out, uint16_t options, uint8_t command);

/* Appends TARGET, SPEED or ACCELERATION of one channel; value 0..16383, clamped. */
void wg_maestro_set(wg_bytes *out, uint16_t options, uint8_t command, uint8_t channel,
                    int16_t value);

/* Appends a Mini SSC position (0..254, 127 = neutral): 3 bytes, no CRC. */
void wg_maestro_minissc(wg_bytes *out, uint8_t channel, uint8_t position);

/* All Maestro servos of the clip: servos that follow each other in the clip with ids n, n+1, ... go
 * into one Set Multiple Targets, so their pulses change together; the others by themselves. A servo
 * that is not on gets target 0, no pulses.
 *   returns  bytes written (0: no such servo in the clip), or WG_ERR_SPACE */
int wg_maestro_frame(const wg_file *file, const wg_servo *state, uint16_t options, uint8_t *out,
                     uint16_t size);

#ifdef __cplusplus
}
#endif
#endif
