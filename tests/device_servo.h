/* What the tests of the servo limiter share: a clip of one servo, random numbers from a fixed seed.
 * SPDX-License-Identifier: MIT */
#ifndef DEVICE_SERVO_H
#define DEVICE_SERVO_H

#include "check.h"
#include "servo.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define UNIT_Q15 32768.0
#define ULP      (1.0 / 4096) /* of a velocity */

static uint32_t seed = 2463534242u;

static inline uint32_t xorshift(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed;
}

static inline int32_t between(int32_t low, int32_t high)
{
    return low + (int32_t)(xorshift() % ((uint32_t)(high - low) + 1));
}

/* ---- a clip with one servo on channel 0, whose value is the target in Q8 --------------------- */

typedef struct {
    int32_t offset, gain, shift, low, high;
    double velocity, acceleration; /* units/s, units/s^2; rounded down to what a clip can hold */
} setting;

static uint32_t record[WG_SERVO_BYTES / 4];
static wg_file file;
static wg_servo servo;

static inline void store(uint8_t *at, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) {
        at[i] = (uint8_t)(value >> (8 * i));
    }
}

static inline void clip_with(const setting *s)
{
    uint8_t *r = (uint8_t *)record;

    memset(record, 0, sizeof record);
    store(r + WG_SERVO_OFFSET, (uint32_t)s->offset, 4);
    store(r + WG_SERVO_GAIN, (uint32_t)s->gain, 2);
    store(r + WG_SERVO_GAIN_SHIFT, (uint32_t)s->shift, 1);
    store(r + WG_SERVO_MIN, (uint32_t)s->low, 2);
    store(r + WG_SERVO_MAX, (uint32_t)s->high, 2);
    store(r + WG_SERVO_VELOCITY, (uint32_t)s->velocity, 2);
    store(r + WG_SERVO_ACCELERATION, (uint32_t)(s->acceleration / 16), 2);
    file.section[WG_SECTION_SERVOS].at = r;
    file.section[WG_SECTION_SERVOS].count = 1;
    wg_servo_init(&servo, &file);
}

static inline setting limits(int32_t low, int32_t high, double velocity, double acceleration)
{
    setting s = {0, 1, 0, low, high, velocity, 16 * floor(acceleration / 16)};

    clip_with(&s);
    return s;
}

static inline void step(int32_t target_q8, uint32_t dt_us)
{
    wg_servo_step(&file, &servo, &target_q8, dt_us);
}

/* On, at rest at `units`, past the soft start. */
static inline void rest_at(int16_t units)
{
    wg_servo_start(&servo, 0, units);
    step(units * 256, 10000);
    CHECK_EQ(wg_servo_mode(&servo), WG_SERVO_FOLLOWING);
}

static inline double velocity(void)
{
    return servo.velocity_q12 * ULP;
}

static inline double position(void)
{
    return servo.position_q15 / UNIT_Q15;
}

static inline double random_scale(double low, double high)
{
    return low * pow(high / low, between(0, 1000) / 1000.0);
}
/* Arguments are evaluated in any order; these draws in one, so every compiler tests the same. */
static inline setting random_limits(int32_t end, double slowest, double weakest)
{
    double fast = floor(random_scale(slowest, 65535));

    return limits(-end, end, fast, random_scale(weakest, 1e6));
}

#endif
