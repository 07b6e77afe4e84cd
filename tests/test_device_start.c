/* Servo targets from channel values, power-up, ticks of no length and of great length.
 * SPDX-License-Identifier: MIT */
#include "device_servo.h"

/* ---- map ------------------------------------------------------------------------------------- */

static void target_is_offset_plus_floor_of_value_times_gain(void)
{
    for (int i = 0; i < 20000; i++) {
        setting s = {0, 0, 0, -32768, 32767, 0, 0};
        int32_t value = between(-(1 << 29), 1 << 29);
        int64_t product, unit, want;
        s.offset = between(-(1 << 23), 1 << 23);
        s.gain = between(-32768, 32767);
        s.shift = between(0, 40);
        product = (int64_t)value * s.gain;
        unit = (int64_t)1 << s.shift;
        want = s.offset + product / unit - (product % unit < 0);
        clip_with(&s);
        want = want < -32768 * 256 ? -32768 * 256 : want > 32767 * 256 ? 32767 * 256 : want;
        CHECK_EQ(wg_servo_target(&file, 0, &value), want);
    }
}

static void target_is_clamped_to_min_and_max(void)
{
    int32_t far = 1 << 29, near = -(1 << 29);

    limits(3968, 8000, 0, 0);
    CHECK_EQ(wg_servo_target(&file, 0, &far), 8000 * 256);
    CHECK_EQ(wg_servo_target(&file, 0, &near), 3968 * 256);
}

static void position_rounds_to_the_nearest_unit(void)
{
    limits(-32768, 32767, 0, 0);
    for (int i = 0; i < 2000; i++) {
        int32_t q8 = between(-32768 * 256, 32767 * 256);
        step(q8, 10000);
        CHECK_EQ(wg_servo_position(&servo), floor(q8 / 256.0 + 0.5));
    }
}

/* ---- starting and time ----------------------------------------------------------------------- */

static void first_step_starts_at_the_first_target(void)
{
    limits(-4000, 4000, 10, 16);
    CHECK(!wg_servo_on(&servo));
    step(1234 * 256, 0);
    CHECK(wg_servo_on(&servo));
    CHECK_EQ(wg_servo_position(&servo), 1234);
}

static void start_approaches_at_an_eighth_of_the_velocity_limit(void)
{
    double fast = 0;

    for (int unlimited = 0; unlimited < 2; unlimited++) {
        double limit = unlimited ? WG_SERVO_VELOCITY_CAP : 8000;
        limits(-4000, 4000, unlimited ? 0 : 8000, 0);
        wg_servo_start(&servo, 0, -3000);
        for (int i = 0; i < 1000 && wg_servo_mode(&servo) == WG_SERVO_APPROACHING; i++) {
            double before = position();
            step(3000 * 256, 10000);
            CHECK(fabs(position() - before) <= limit / 8 * 0.01 + 0.01);
        }
        CHECK_EQ(wg_servo_position(&servo), 3000);
        CHECK_EQ(wg_servo_mode(&servo), WG_SERVO_FOLLOWING);
        fast = position();
        step(0, 10000);
        CHECK(fast - position() > limit / 8 * 0.01 + 0.01);
    }
}

static void soft_start_ends_when_the_target_crosses_the_servo(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        limits(-4000, 4000, 800, 16000);
        wg_servo_start(&servo, 0, 0);
        step(sign * 3000 * 256, 10000);
        CHECK_EQ(wg_servo_mode(&servo), WG_SERVO_APPROACHING);
        step(-sign * 3000 * 256, 10000);
        CHECK_EQ(wg_servo_mode(&servo), WG_SERVO_FOLLOWING);
    }
}

static void a_start_outside_the_limits_comes_in_and_never_goes_further_out(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        limits(-1000, 1000, 2000, 4000);
        wg_servo_start(&servo, 0, (int16_t)(sign * 1800));
        for (int i = 0; i < 3000; i++) {
            double before = position() * sign;
            step(sign * 900 * 256, 10000);
            CHECK(position() * sign <= before && before - position() * sign <= 20.01);
        }
        CHECK_EQ(servo.position_q15, sign * 900 * 32768);
    }
}

static void a_servo_that_is_off_stays_off_until_started(void)
{
    limits(-1000, 1000, 0, 0);
    wg_servo_off(&servo, 0);
    step(500 * 256, 10000);
    CHECK(!wg_servo_on(&servo));
    wg_servo_start(&servo, 0, 100);
    CHECK(wg_servo_on(&servo));
    CHECK_EQ(wg_servo_position(&servo), 100);
}

static void zero_time_moves_nothing_and_a_long_tick_counts_as_the_longest(void)
{
    wg_servo a;

    limits(-4000, 4000, 800, 16000);
    rest_at(0);
    a = servo;
    step(4000 * 256, 0);
    CHECK(memcmp(&a, &servo, sizeof a) == 0);
    step(4000 * 256, WG_SERVO_TICK_MAX_US);
    a = servo;
    rest_at(0);
    step(4000 * 256, 4000000000u);
    CHECK(memcmp(&a, &servo, sizeof a) == 0);
}

static void state_is_twelve_bytes(void)
{
    CHECK_EQ(sizeof(wg_servo), 12);
}

int main(void)
{
    TEST(target_is_offset_plus_floor_of_value_times_gain);
    TEST(target_is_clamped_to_min_and_max);
    TEST(position_rounds_to_the_nearest_unit);
    TEST(first_step_starts_at_the_first_target);
    TEST(start_approaches_at_an_eighth_of_the_velocity_limit);
    TEST(soft_start_ends_when_the_target_crosses_the_servo);
    TEST(a_start_outside_the_limits_comes_in_and_never_goes_further_out);
    TEST(a_servo_that_is_off_stays_off_until_started);
    TEST(zero_time_moves_nothing_and_a_long_tick_counts_as_the_longest);
    TEST(state_is_twelve_bytes);
    return check_done();
}
