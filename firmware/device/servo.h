/* From channel values to servo positions that the servo can follow: map, clamp, limit velocity and
 * acceleration. The device code's only state that lasts from tick to tick; 12 bytes a servo.
 * Source: own, a trapezoidal profile whose braking speed is solved for the tick; proofs in servo.c.
 *
 * What a servo does at power-up is decided by the first call after wg_servo_init:
 *
 *   nothing               It starts at its target in the first step. Without feedback nobody knows
 *                         where it stands, so it goes there as fast as it can: for bench tests.
 *   wg_servo_start(i, p)  It stands at p (read back, stored, or where the unpowered mechanism
 *                         rests) and approaches its target at 1/8 of its velocity limit.
 *   wg_servo_off(i)       It gets no pulses until wg_servo_start. Starting servos one by one, some
 *                         100 ms apart, keeps the supply from collapsing under all of them.
 *
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_SERVO_H
#define WIGGLY_SERVO_H

#include "wiggly.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WG_SERVO_WAITING     0u /* starts at its target in the next step; no pulses yet */
#define WG_SERVO_OFF         1u /* no pulses until wg_servo_start */
#define WG_SERVO_APPROACHING 2u /* soft start: has not yet met its target */
#define WG_SERVO_FOLLOWING   3u

#define WG_SERVO_TICK_MAX_US  125000ul /* a longer tick counts as this one */
#define WG_SERVO_VELOCITY_CAP 65536ul  /* units/s: "unlimited" beside an acceleration limit */

typedef struct {
    int32_t position_q15; /* what the servo is told, units */
    int32_t velocity_q12; /* of the last step, units/s */
    int32_t target_q15; /* of the last step, units; its low 7 bits, always 0 there, hold the mode */
} wg_servo;

/* Every servo of the clip WAITING. `state` has as many elements as the clip has servos. */
void wg_servo_init(wg_servo *state, const wg_file *file);

/* Servo `index` stands still at `position`, which may lie outside its limits: it never moves
 * further out. The soft start ends when it first meets its target or the target crosses it. */
void wg_servo_start(wg_servo *state, uint8_t index, int16_t position);
void wg_servo_off(wg_servo *state, uint8_t index);

/* Where servo `index` should be, units Q8: offset + floor(value gain / 2^gain_shift), exact
 * (64-bit), clamped to [min, max]. */
int32_t wg_servo_target(const wg_file *file, uint8_t index, const int32_t *values);

/* Moves every servo that is on towards its target.
 *
 *   values   one a channel, as wg_player_sample writes them
 *   dt_us    since the last step: 0 moves nothing, more than WG_SERVO_TICK_MAX_US counts as that;
 *            250 us or more, else the slowest servos (V = 1, A = 16) round to a standstill
 *   limits   V = velocity, A = acceleration, 0 = unlimited (V = 0 beside A > 0: VELOCITY_CAP).
 *            Always, for any sequence of targets:
 *            position in [min, max] (hard, wins over the others), |velocity| <= V + 2^-11 units/s,
 *            |change of velocity| <= A dt + 2^-10 units/s, for ticks of equal length
 *   exact    a motion passes bit-unchanged when every step D of it over dt has |D/dt| <= V,
 *            |D/dt - D'/dt'| <= A dt (D', dt' the step before, 0 after a start) and could still
 *            stop at the end stop ahead: |D/dt| <= A dt or (|D/dt|^2 - (A dt)^2)/2A <= room left.
 *            The last holds by itself where the motion brakes for its end stops with <= 0.8 A
 *   at rest  a constant target is met exactly and never passed, from rest or from any velocity
 *            that can still be braked; with ticks in [s, t] passed by at most A (t^2 - s^2)/2
 *   rounding motion too slow for 1/32768 unit a tick takes its last 1/256 unit at once
 *   checked  by tests/test_device_servo.c
 *   cost     one 47-step division a call; a servo: a few 64-bit products, and a root of 16 steps
 *            while it is not exact */
void wg_servo_step(const wg_file *file, wg_servo *state, const int32_t *values, uint32_t dt_us);

static inline uint8_t wg_servo_mode(const wg_servo *servo)
{
    return (uint8_t)((uint32_t)servo->target_q15 & 127u);
}

static inline bool wg_servo_on(const wg_servo *servo)
{
    return wg_servo_mode(servo) >= WG_SERVO_APPROACHING;
}

/* The position to send: nearest unit, halves up; in [min, max] because those are whole units. */
static inline int16_t wg_servo_position(const wg_servo *servo)
{
    return (int16_t)((servo->position_q15 + 0x4000) >> 15);
}

#ifdef __cplusplus
}
#endif
#endif
