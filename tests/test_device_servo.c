/* The servo limiter: motions that comply pass unchanged, the limits hold for every other one,
 * targets are met without overshoot. Random motions from a fixed seed.
 * Tolerances are those stated in servo.h and derived in servo.c.
 * SPDX-License-Identifier: MIT */
#include "device_servo.h"

/* ---- motions that comply pass unchanged ------------------------------------------------------ */

/* The next step of a random motion that complies, or 0 when 1/256 unit is too coarse for one. */
static int compliant_step(const setting *s, double at, double *speed, double dt, double *distance)
{
    double want = *speed + s->acceleration * dt * (between(-1000, 1000) / 1000.0);

    if (fabs(at) > 8000 && want * at > 0) {
        want = *speed - s->acceleration * dt * (at > 0 ? 1 : -1);
    }
    *distance = rint(want * dt * 256) / 256;
    want = *distance / dt;
    if (fabs(want) > s->velocity || fabs(want - *speed) > s->acceleration * dt) {
        return 0;
    }
    *speed = want;
    return 1;
}

static void compliant_motion_passes_bit_unchanged_with_any_ticks(void)
{
    long moved = 0;

    for (int run = 0; run < 300; run++) {
        setting s = random_limits(32767, 2000, 8e4);
        double speed = 0, at = 0, distance;
        int jitter = run % 2;
        rest_at(0);
        for (int i = 0; i < 500; i++) {
            uint32_t dt = jitter ? (uint32_t)between(4000, 16000) : 10000;
            if (fabs(at) > 15000 || !compliant_step(&s, at, &speed, dt * 1e-6, &distance)) {
                break;
            }
            at += distance;
            moved += distance != 0;
            step((int32_t)(at * 256), dt);
            CHECK_EQ(servo.position_q15, (int32_t)(at * 32768));
        }
    }
    CHECK(moved > 10000); /* the generator does not give up at once */
}

/* Two steps that each use the whole limit, to the last 1/256 unit: the rounding of velocities must
 * not refuse any. Ticks of 1/8 s, where 1/256 unit is only 128 bits of a velocity. */
static void steps_at_the_very_acceleration_limit_pass(void)
{
    for (int run = 0; run < 100000; run++) {
        int32_t acceleration = 16 * between(10, 6000), dt = between(110000, 125000);
        int64_t most = (int64_t)acceleration * 256 * dt * dt / 1000000000000;
        int32_t first = between(-(int32_t)most, (int32_t)most);
        int sign = between(0, 1) ? 1 : -1;
        limits(-32768, 32767, 0, acceleration);
        rest_at(0);
        step(first, (uint32_t)dt);
        CHECK_EQ(servo.position_q15, first * 128);
        step(2 * first + sign * (int32_t)most, (uint32_t)dt);
        CHECK_EQ(servo.position_q15, (2 * first + sign * (int32_t)most) * 128);
    }
}

static void compliant_motion_into_an_end_stop_passes_bit_unchanged(void)
{
    setting s = limits(0, 4000, 30000, 160000);
    double slow = 0.78 * s.acceleration; /* 2 % stay for the rounding to 1/256 unit */
    double middle = sqrt(4000 / slow), dt = 0.01;

    rest_at(0);
    for (int i = 1; i * dt <= 2 * middle + 2 * dt; i++) {
        double t = i * dt < 2 * middle ? i * dt : 2 * middle, back = 2 * middle - t;
        double x = t < middle ? slow * t * t / 2 : 4000 - slow * back * back / 2;
        int32_t q8 = (int32_t)rint(x * 256);
        step(q8, 10000);
        CHECK_EQ(servo.position_q15, q8 * 128);
    }
    CHECK_EQ(wg_servo_position(&servo), 4000);
}

static void without_limits_every_motion_passes(void)
{
    limits(-32768, 32767, 0, 0);
    step(0, 0);
    for (int i = 0; i < 1000; i++) {
        int32_t q8 = between(-32768 * 256, 32767 * 256);
        step(q8, (uint32_t)between(1, 200000));
        CHECK_EQ(servo.position_q15, q8 * 128);
    }
}

/* ---- limits hold for every sequence ---------------------------------------------------------- */

/* A motion that jumps, ramps, stands, runs into the end stops. */
static int32_t wild(int32_t last, int i)
{
    switch (i / 40 % 4) {
    case 0:
        return i % 7 ? last : between(-4200, 4200) * 256;
    case 1:
        return last + between(0, 40000);
    case 2:
        return last - between(0, 40000);
    default:
        return last;
    }
}

/* Two velocities taken from positions: towards 0 and 21 ppm low when chasing, 5/4 ULP when exact,
 * and the last 1/256 unit at once. */
static void check_step_limits(const setting *s, double before, double speed, double moved,
                              double dt)
{
    double last = (position() - before) / dt;
    double rounding = 130 / UNIT_Q15 / dt + 2.2e-5 * (fabs(last) + fabs(moved)) + 4 * ULP;

    CHECK(position() >= -4000 && position() <= 4000);
    if (s->velocity > 0) {
        CHECK(fabs(velocity()) <= s->velocity + 2 * ULP);
        CHECK(fabs(last) <= s->velocity + rounding);
    }
    if (s->acceleration > 0) {
        CHECK(fabs(velocity() - speed) <= s->acceleration * dt + 4 * ULP);
        CHECK(fabs(last - moved) <= s->acceleration * dt + rounding);
    }
}

static void limits_hold_for_every_sequence_of_targets(void)
{
    for (int run = 0; run < 400; run++) {
        setting s = random_limits(4000, 20, 200);
        uint32_t dt = (uint32_t)random_scale(500, 125000);
        int32_t target = 0;
        double moved = 0;
        if (run % 8 == 1) {
            s = limits(-4000, 4000, s.velocity, 0);
        } else if (run % 8 == 2) {
            s = limits(-4000, 4000, 0, s.acceleration);
        }
        rest_at(0);
        for (int i = 0; i < 600; i++) {
            double before = position(), speed = velocity();
            target = wild(target, i);
            target = target < -1100000 ? -1100000 : target > 1100000 ? 1100000 : target;
            step(target, dt);
            check_step_limits(&s, before, speed, moved, dt * 1e-6);
            moved = (position() - before) / (dt * 1e-6);
        }
    }
}

/* ---- constant targets ------------------------------------------------------------------------ */

/* Shortest time from rest to rest over `distance`. */
static double fastest(const setting *s, double distance)
{
    double ramp = s->velocity * s->velocity / s->acceleration;

    return distance > ramp ? distance / s->velocity + s->velocity / s->acceleration
                           : 2 * sqrt(distance / s->acceleration);
}

static void constant_target_is_met_exactly_and_never_passed(void)
{
    double slowest = 0;

    for (int run = 0; run < 2000; run++) {
        setting s = random_limits(32767, 20, 200);
        uint32_t dt = (uint32_t)random_scale(500, 125000);
        int32_t from = between(-30000, 30000), to = between(-30000, 30000);
        double want = fastest(&s, abs(to - from)), ticks = 3 * want / (dt * 1e-6) + 40, i;
        rest_at((int16_t)from);
        for (i = 0; i < ticks && servo.position_q15 != to * 32768; i++) {
            step(to * 256, dt);
            CHECK(to >= from ? position() <= to : position() >= to);
        }
        CHECK(servo.position_q15 == to * 32768);
        slowest = fmax(slowest, (i * dt * 1e-6 - 4 * dt * 1e-6) / want);
        step(to * 256, dt);
        step(to * 256, dt);
        CHECK_EQ(servo.position_q15, to * 32768);
        CHECK_EQ(servo.velocity_q12, 0);
    }
    /* Landing halves the last a dt a few times; the rest is the fastest profile there is. */
    CHECK(slowest < 1.05);
    printf("constant target: at most %.3f of the fastest time + 4 ticks\n", slowest);
}

static void the_slowest_servo_arrives_with_the_shortest_tick(void)
{
    for (int from = -3; from <= 3; from++) {
        double before;
        limits(-10, 10, 1, 16);
        wg_servo_start(&servo, 0, (int16_t)from);
        for (int i = 0; i < 300000 && servo.position_q15 != 0; i++) {
            before = fabs(position());
            step(0, 250);
            CHECK(fabs(position()) <= before && before - fabs(position()) <= 1.0 / 256);
        }
        CHECK_EQ(servo.position_q15, 0);
    }
}

static void uneven_ticks_pass_a_constant_target_by_no_more_than_stated(void)
{
    double worst = 0;

    for (int run = 0; run < 2000; run++) {
        setting s = random_limits(32767, 10000, 4e4);
        int32_t shortest = between(1000, 20000), longest = shortest + between(0, 10000);
        double bound =
            s.acceleration * ((double)longest * longest - (double)shortest * shortest) * 1e-12 / 2;
        int32_t to = between(-10000, 10000);
        int sign = to > 0 ? 1 : -1;
        rest_at(0);
        for (int i = 0; i < 3000; i++) {
            step(to * 256, (uint32_t)between(shortest, longest));
            worst = fmax(worst, (position() - to) * sign - bound);
        }
        CHECK(servo.position_q15 == to * 32768);
    }
    CHECK(worst <= 3 / UNIT_Q15); /* floor of travel, once a step of the way back */
}

static void a_moving_servo_that_can_still_brake_does_not_overshoot(void)
{
    for (int run = 0; run < 2000; run++) {
        setting s = limits(-32768, 32767, 60000, random_scale(1e4, 1e6));
        uint32_t dt = (uint32_t)between(1000, 20000);
        int pushes = between(1, 40);
        double room;
        int32_t to;
        rest_at(-20000);
        for (int i = 0; i < pushes; i++) {
            step(30000 * 256, dt);
        }
        room = velocity() * velocity() / (2 * s.acceleration);
        to = (int32_t)ceil(position() + room) + between(0, 20);
        for (int i = 0; i < 4000 && to <= 32767; i++) {
            step(to * 256, dt);
            CHECK(position() <= to);
        }
        CHECK(to > 32767 || servo.position_q15 == to * 32768);
    }
}

static void a_target_that_stops_dead_at_an_end_stop_is_braked_for(void)
{
    setting s = limits(0, 4000, 30000, 160000);
    double speed = 0;

    rest_at(0);
    for (int i = 0; i < 200; i++) {
        double x = 160000.0 / 2 * i * i * 1e-4; /* full acceleration into the clamp */
        step((int32_t)fmin(x * 256, 1e8), 10000);
        CHECK(fabs(velocity() - speed) <= s.acceleration * 0.01 + 4 * ULP);
        CHECK(position() <= 4000);
        speed = velocity();
    }
    CHECK_EQ(wg_servo_position(&servo), 4000);
}

/* Ticks that shorten leave a rest of velocity at the end stop: it ends there and then. */
static void a_servo_held_by_an_end_stop_has_no_velocity(void)
{
    int held = 0;

    for (int run = 0; run < 200; run++) {
        int32_t dt = between(8000, 12000);
        double last = 0;
        limits(0, between(900, 1100), 30000, 160000);
        rest_at(0);
        for (int i = 0; i < 400; i++) {
            step(2000 * 256, (uint32_t)dt);
            if (position() == last && last > 0) {
                CHECK_EQ(servo.velocity_q12, 0);
                held++;
            }
            last = position();
            if (position() > 899) {
                dt = 500;
            }
        }
    }
    CHECK(held > 200 * 100); /* it gets there in every run */
}

int main(void)
{
    TEST(compliant_motion_passes_bit_unchanged_with_any_ticks);
    TEST(steps_at_the_very_acceleration_limit_pass);
    TEST(compliant_motion_into_an_end_stop_passes_bit_unchanged);
    TEST(without_limits_every_motion_passes);
    TEST(limits_hold_for_every_sequence_of_targets);
    TEST(constant_target_is_met_exactly_and_never_passed);
    TEST(the_slowest_servo_arrives_with_the_shortest_tick);
    TEST(uneven_ticks_pass_a_constant_target_by_no_more_than_stated);
    TEST(a_moving_servo_that_can_still_brake_does_not_overshoot);
    TEST(a_target_that_stops_dead_at_an_end_stop_is_braked_for);
    TEST(a_servo_held_by_an_end_stop_has_no_velocity);
    return check_done();
}
