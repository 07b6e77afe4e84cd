/* Servo map and limiter. Positions are Q15, velocities Q12 units/s, accelerations units/s^2.
 *
 * A step over dt picks a velocity u; v is the last one, a = A dt, e the distance to the target.
 *
 * 1. Exact: u = e/dt is taken when |u| <= V, |u - v| <= a, and it can still stop: either |u| <= a,
 *    or the servo was within a dt of the last target, so that u is the target's own velocity to
 *    within a, and braking by a once and then continuously ends before the end stop ahead:
 *    (u - a) dt + (u - a)^2/2A = (u^2 - a^2)/2A <= room.
 *
 * 2. Chase otherwise: the largest u in [v - a, v + a] and [-V, V] that can stop at the target,
 *    u dt + u^2/2A <= e, so u <= sqrt(a^2 + 2Ae) - a. Braking with steps of any length needs no
 *    more than u^2/2A, so a later, shorter tick does no harm.
 *
 * Invariant v^2/2A <= e: u = v - a has u dt + u^2/2A = v^2/2A - a dt/2 <= e, so braking always
 * keeps it, and the rounding (travel and root down, a up) only adds to the slack a dt/2. Near the
 * target, e <= a dt, it gives e/dt >= v^2/2a >= v - a, so rule 1 applies and the servo lands;
 * landing leaves |v| <= a, so that the next step is 0: no overshoot.
 *
 * The 0.8 A of servo.h: braking with B = bA from u = kB dt takes k(k - 1)/2 B dt^2 or more; that
 * covers (u^2 - a^2)/2A for every k when 2 sqrt((1 - b)/b) >= 1, so when b <= 0.8.
 *
 * Source: own.
 * SPDX-License-Identifier: MIT */
#include "servo.h"

#include "fix.h"
#include "wg_mem.h"
#include "wg_mul.h"

/* 125000 / us as rate / 2^shift, rate in [2^30, 2^31): a distance Q15 times it is Q12 units/s. */
typedef struct {
    uint32_t us;
    uint32_t rate;
    uint8_t shift;
} tick;

typedef struct {
    int32_t low, high;     /* Q15 */
    int32_t velocity;      /* Q12, > 0 */
    int32_t step;          /* a, Q12, rounded up: at least 1; 0 = unlimited */
    uint32_t acceleration; /* A, < 2^20 */
} limits;

static uint32_t magnitude(int32_t a)
{
    return a < 0 ? 0u - (uint32_t)a : (uint32_t)a;
}

static int32_t with_sign(int32_t sign, uint32_t a)
{
    return sign < 0 ? -(int32_t)a : (int32_t)a;
}

static tick tick_make(uint32_t us)
{
    tick t = {us, 0, 0};
    uint32_t bits = 125000ul << 15, rest = 0;
    uint8_t n = 0;

    /* The first 1 comes after at most 17 bits (us <= 125000), 30 more follow. */
    for (; n < 47 && t.rate < 1ul << 30; n++) {
        rest = rest << 1 | bits >> 31;
        bits <<= 1;
        t.rate <<= 1;
        if (rest >= us) {
            rest -= us;
            t.rate |= 1;
        }
    }
    t.shift = (uint8_t)(n - 17); /* 14 at 1 us .. 30 */
    return t;
}

/* distance / tick towards 0, less than 5/4 of the last bit short up to 2^28, then VELOCITY_HUGE. */
#define VELOCITY_HUGE (1ul << 29)
static int32_t velocity_of(const tick *t, int32_t distance)
{
    uint32_t d = magnitude(distance), v = VELOCITY_HUGE;

    if (d >> t->shift == 0) {              /* else v >= 2^shift 2^30 / 2^shift */
        uint32_t a = d << (32 - t->shift); /* wg_mulh takes it for a - 2^32 from 2^31 on */
        v = (uint32_t)wg_mulh((int32_t)a, (int32_t)t->rate) + (a >> 31 ? t->rate : 0);
        v = v > VELOCITY_HUGE ? VELOCITY_HUGE : v;
    }
    return with_sign(distance, v);
}

/* velocity x tick, towards 0: 68719 = floor(2^33 / 125000). 2^28 2^17 2^17 < 2^63. */
static int32_t travel_of(const tick *t, int32_t velocity)
{
    return with_sign(velocity, (uint32_t)(((uint64_t)magnitude(velocity) * t->us * 68719u) >> 33));
}

/* sqrt(x), never above it and at most 2^-15 below: 16 bits are enough for a braking speed. */
static uint32_t root(uint64_t x)
{
    uint32_t rest = (uint32_t)x, high = (uint32_t)(x >> 32), r = 0, bit;
    uint8_t shift = 0;

    /* By words: AVR shifts 64 bits one at a time. At most 3 whole bytes, then 4 pairs of bits. */
    for (; high >> 8; shift = (uint8_t)(shift + 4)) {
        rest = rest >> 8 | high << 24;
        high >>= 8;
    }
    for (; high; shift++) {
        rest = rest >> 2 | high << 30;
        high >>= 2;
    }
    for (bit = 1ul << 30; bit; bit >>= 2) { /* 16 times */
        if (rest >= r + bit) {
            rest -= r + bit;
            r = (r >> 1) + bit;
        } else {
            r >>= 1;
        }
    }
    return r << shift;
}

/* a^2 + 2A room in Q24: < 2^59 + 2^21 2^31 2^9 < 2^62. */
static uint64_t braking(const limits *l, uint32_t room)
{
    return (uint64_t)(uint32_t)l->step * (uint32_t)l->step +
           ((uint64_t)room * (2 * l->acceleration) << 9);
}

/* Rule 1. Rounding down makes two velocities differ by less than 1 more, which the rounding up of a
 * covers; the reciprocals of unequal ticks add up to 1/4 (2^-30 of 2^28): hence the + 1. */
static bool exact(const wg_servo *s, int32_t target, int32_t wanted, const limits *l, const tick *t)
{
    int32_t behind = (s->target_q15 & ~127) - s->position_q15;
    uint32_t room = (uint32_t)(wanted < 0 ? target - l->low : l->high - target);
    uint32_t slack = (uint32_t)l->step + 1, speed = magnitude(wanted);

    if (speed > (uint32_t)l->velocity) {
        return false;
    }
    if (l->step == 0) {
        return true;
    }
    if (magnitude(wanted - s->velocity_q12) > slack) {
        return false;
    }
    return speed <= slack || /* can stand still in the next step */
           (magnitude(velocity_of(t, behind)) <= slack &&
            (uint64_t)(speed - 1) * (speed - 1) <= braking(l, room));
}

/* Rule 2, mirrored so that the target lies ahead. */
static int32_t chase(int32_t velocity, int32_t distance, const limits *l)
{
    int32_t v = distance < 0 ? -velocity : velocity;
    int32_t u = l->velocity;

    if (l->step) {
        u = (int32_t)root(braking(l, magnitude(distance))) - l->step;
        u = fix_clamp(u < 0 ? 0 : u, v - l->step, v + l->step);
        u = fix_clamp(u, -l->velocity, l->velocity);
    }
    return distance < 0 ? -u : u;
}

/* Moves by one velocity. Only ticks that shorten in front of an end stop, or a start outside, ever
 * reach the clamp: outside means no further out, else it would be a jump. */
static void move(wg_servo *s, int32_t distance, const limits *l, const tick *t)
{
    int32_t from = s->position_q15, d = travel_of(t, s->velocity_q12);
    int32_t to = from + (d == 0 && magnitude(distance) < 128 ? distance : d);
    int32_t low = from < l->low ? from : l->low, high = from > l->high ? from : l->high;

    s->position_q15 = fix_clamp(to, low, high);
    if (to != s->position_q15) {
        s->velocity_q12 = 0;
    }
}

static void follow(wg_servo *s, int32_t target, const limits *l, const tick *t)
{
    int32_t distance = target - s->position_q15;
    int32_t behind = (s->target_q15 & ~127) - s->position_q15;
    int32_t wanted = velocity_of(t, distance);
    uint32_t mode = wg_servo_mode(s);

    if (exact(s, target, wanted, l, t)) {
        s->velocity_q12 = wanted;
        s->position_q15 = target;
    } else {
        s->velocity_q12 = chase(s->velocity_q12, distance, l);
        move(s, distance, l, t);
    }
    if (s->position_q15 == target || (behind < 0 && distance > 0) || (behind > 0 && distance < 0)) {
        mode = WG_SERVO_FOLLOWING;
    }
    s->target_q15 = (int32_t)((uint32_t)target | mode);
}

static const uint8_t *record_of(const wg_file *file, uint8_t index)
{
    return file->section[WG_SECTION_SERVOS].at + (uint16_t)(index * WG_SERVO_BYTES);
}

/* Limits of one servo for this tick; 281474977 = ceil(2^48 / 10^6), and A is stored as A/16. */
static limits limits_of(const uint8_t *record, const tick *t, uint32_t mode)
{
    uint32_t velocity = wg_rd16(record + WG_SERVO_VELOCITY);
    uint32_t acceleration = wg_rd16(record + WG_SERVO_ACCELERATION);
    limits l;

    l.low = fix_shl((int16_t)wg_rd16(record + WG_SERVO_MIN), 15);
    l.high = fix_shl((int16_t)wg_rd16(record + WG_SERVO_MAX), 15);
    l.velocity = (int32_t)(velocity << 12);
    l.acceleration = acceleration << 4;
    l.step = 0;
    if (acceleration) {
        l.step = (int32_t)(((uint64_t)acceleration * t->us * 281474977u) >> 32) + 1;
    }
    if (velocity == 0) { /* no velocity_of is above VELOCITY_HUGE */
        l.velocity = acceleration || mode == WG_SERVO_APPROACHING
                         ? (int32_t)(WG_SERVO_VELOCITY_CAP << 12)
                         : (int32_t)VELOCITY_HUGE;
    }
    if (mode == WG_SERVO_APPROACHING) {
        l.velocity >>= 3;
    }
    return l;
}

int32_t wg_servo_target(const wg_file *file, uint8_t index, const int32_t *values)
{
    const uint8_t *record = record_of(file, index);
    int32_t value = values[wg_rd16(record + WG_SERVO_CHANNEL)];
    int64_t product = (int64_t)value * (int16_t)wg_rd16(record + WG_SERVO_GAIN);
    int32_t low = fix_shl((int16_t)wg_rd16(record + WG_SERVO_MIN), 8);
    int32_t high = fix_shl((int16_t)wg_rd16(record + WG_SERVO_MAX), 8);

    product >>= wg_rd8(record + WG_SERVO_GAIN_SHIFT);
    product += (int32_t)wg_rd32(record + WG_SERVO_OFFSET);
    return product < low ? low : product > high ? high : (int32_t)product;
}

void wg_servo_init(wg_servo *state, const wg_file *file)
{
    uint16_t count = file->section[WG_SECTION_SERVOS].count, i;

    for (i = 0; i < count; i++) {
        state[i].position_q15 = state[i].velocity_q12 = 0;
        state[i].target_q15 = (int32_t)WG_SERVO_WAITING;
    }
}

void wg_servo_start(wg_servo *state, uint8_t index, int16_t position)
{
    wg_servo *s = &state[index];

    s->position_q15 = fix_shl(position, 15);
    s->velocity_q12 = 0;
    s->target_q15 = (int32_t)((uint32_t)s->position_q15 | WG_SERVO_APPROACHING);
}

void wg_servo_off(wg_servo *state, uint8_t index)
{
    state[index].velocity_q12 = 0;
    state[index].target_q15 = (int32_t)WG_SERVO_OFF;
}

void wg_servo_step(const wg_file *file, wg_servo *state, const int32_t *values, uint32_t dt_us)
{
    uint16_t count = file->section[WG_SECTION_SERVOS].count, i;
    tick t = tick_make(dt_us == 0                     ? 1
                       : dt_us > WG_SERVO_TICK_MAX_US ? WG_SERVO_TICK_MAX_US
                                                      : dt_us);

    for (i = 0; i < count; i++) { /* <= WG_SERVOS_MAX */
        wg_servo *s = &state[i];
        int32_t target = fix_shl(wg_servo_target(file, (uint8_t)i, values), 7);
        uint32_t mode = wg_servo_mode(s);

        if (mode == WG_SERVO_WAITING) {
            s->position_q15 = target;
            s->target_q15 = (int32_t)((uint32_t)target | WG_SERVO_FOLLOWING);
        } else if (mode != WG_SERVO_OFF && dt_us) {
            limits l = limits_of(record_of(file, (uint8_t)i), &t, mode);
            follow(s, target, &l, &t);
        }
    }
}
