/* The arithmetic that skins add: roots, directions, quaternions; against doubles and 64 bits.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "skin.h"
#include "skin_model.h"

static uint32_t seed = 3;

static uint32_t bits(void)
{
    uint32_t high = seed = seed * 1664525u + 1013904223u;
    seed = seed * 1664525u + 1013904223u;
    return (high & 0xffff0000u) | seed >> 16;
}

/* Numbers of every size, and the neighbours of squares. */
static void root_is_the_floor_of_the_root(void)
{
    for (unsigned i = 0; i < 200000; i++) {
        uint32_t n = bits() >> i % 33u % 32u, of = n & 0xffffu;
        uint32_t a = i % 4u == 0 ? of * of : i % 4u == 1 ? of * of - 1u : n;
        uint64_t root = fix_sqrt(a);
        CHECK(root * root <= a && (root + 1u) * (root + 1u) > a);
    }
    CHECK_EQ(fix_sqrt(0xffffffffu), 65535);
    CHECK_EQ(fix_sqrt(0), 0);
}

static void bit_lengths_are_those_of_the_number(void)
{
    CHECK_EQ(fix_bits(0), 0);
    for (unsigned length = 1; length <= 32; length++) {
        uint32_t least = UINT32_C(1) << (length - 1u);
        CHECK_EQ(fix_bits(least), length);
        CHECK_EQ(fix_bits(least | (least - 1u)), length);
        CHECK_EQ(fix_bits(least | bits() % least), length);
    }
}

/* From the nearest of 256 directions along the tangent: up to (pi / 256)^2 / 2 too long, of which the
 * angle, atan(x) for x, is x^3 / 3 off. Table and result are rounded: 1/2 unit each. */
static void directions_of_16_bits_have_their_angle(void)
{
    for (unsigned i = 0; i < 100000; i++) {
        uint32_t phase = i < 1024 ? i << 22 : bits();
        double want = phase * ldexp(2 * PI, -32), x = PI / 256;
        fix_turn14 t = fix_turn16(phase);
        double c = ldexp(t.cosine, -14), s = ldexp(t.sine, -14);
        CHECK_NEAR(c, cos(want), x * x / 2 + ldexp(1, -14));
        CHECK_NEAR(s, sin(want), x * x / 2 + ldexp(1, -14));
        CHECK_NEAR(remainder(atan2(s, c) - want, 2 * PI), 0,
                   x * x * x / 3 + sqrt(2) * ldexp(1, -14));
    }
    fix_turn14 none = fix_turn16(0);
    CHECK(none.cosine == 16384 && none.sine == 0); /* what kernels rely on when they skip it */
}

static void phases_are_products_to_the_bit(void)
{
    for (unsigned i = 0; i < 50000; i++) {
        int32_t v = (int32_t)bits() >> (2u + i % 24u);
        uint32_t rate = bits() >> 1;
        int64_t product = (int64_t)v * rate;
        CHECK_EQ(fix_phase(v, rate), (uint32_t)(product >> 16));
    }
}

/* Components of up to `size`. */
static void some(int32_t *q, int32_t size)
{
    for (unsigned c = 0; c < 4; c++) {
        q[c] = (int32_t)((int64_t)(bits() % (2u * (uint32_t)size + 1u)) - size);
    }
}

static double length_of(const int32_t *q)
{
    return ldexp(
        sqrt((double)q[0] * q[0] + (double)q[1] * q[1] + (double)q[2] * q[2] + (double)q[3] * q[3]),
        -29);
}

/* Four floors of 8 units of Q29 each. */
static void products_are_those_of_quaternions(void)
{
    for (unsigned i = 0; i < 20000; i++) {
        int32_t a[4], b[4], ab[4];
        some(a, WG_QUAT_ONE);
        some(b, WG_QUAT_ONE / 2);
        memcpy(ab, a, sizeof a);
        wg_quat_mul(ab, b);
        double w[4] = {0}, p[4], q[4];
        for (unsigned c = 0; c < 4; c++) {
            p[c] = ldexp(a[c], -29);
            q[c] = ldexp(b[c], -29);
        }
        w[0] = p[0] * q[0] - model_dot(p + 1, q + 1);
        model_cross(p + 1, q + 1, w + 1);
        for (unsigned c = 1; c < 4; c++) {
            w[c] += p[0] * q[c] + q[0] * p[c];
        }
        for (unsigned c = 0; c < 4; c++) {
            CHECK_NEAR(ldexp(ab[c], -29), w[c], 32 * ldexp(1, -29));
        }
    }
}

/* Shifted to 29 bits, a component loses 2^-28 of the largest; the root of 15 bits 2^-14 of itself. */
static void units_have_length_1_and_their_direction(void)
{
    for (unsigned i = 0; i < 50000; i++) {
        int32_t q[4], was[4];
        some(q, (int32_t)(0x7fffffffu >> i % 31u));
        for (unsigned c = 0; c < 4; c++) {
            q[c] = i % 5u == c ? -q[c] - 1 : q[c];
        }
        memcpy(was, q, sizeof q);
        double before = length_of(q);
        if (before > 0) {
            CHECK(wg_quat_unit(q));
            CHECK_NEAR(length_of(q), 1, ldexp(1, -13));
            for (unsigned c = 0; c < 4; c++) {
                CHECK_NEAR(ldexp(q[c], -29) / length_of(q), ldexp(was[c], -29) / before,
                           2 * ldexp(1, -27));
            }
        }
    }
}

/* What must not end in a division by 0, or in a shift too far. */
static void extreme_quaternions_are_units_or_none(void)
{
    static const int32_t LEAST = -0x7fffffff - 1;
    static const int32_t EXTREME[] = {-0x3fffffff, 0x3fffffff,  -0x7fffffff - 1, 0x7fffffff, -1,
                                      1,           -0x1fffffff, -0x20000000,     0x20000000, 0};
    for (unsigned i = 0; i < 10; i++) {
        int32_t q[4] = {EXTREME[i], EXTREME[i], EXTREME[i], EXTREME[i]}, R[9];
        wg_quat_rotation(q, R);
        CHECK_EQ(wg_quat_unit(q), EXTREME[i] != 0);
        CHECK(i == 9 || fabs(length_of(q) - 1) < ldexp(1, -13));
    }
    const int32_t one[4] = {LEAST, 0, 0, 0};
    int32_t R[9];
    wg_quat_rotation(one, R); /* n = 2^30: that of -4 */
    CHECK(R[0] == 1 << 30 && R[4] == 1 << 30 && R[8] == 1 << 30 && R[1] == 0);
}

/* n loses 4 of 2^26 |q|^2 or more; products lose 1 of the same, a sum of two 2, times 2: 2^-21 for
 * |q| >= 1/2. The reciprocal is 2^-29 off after one step, its own floors add 2^-27. */
static void matrices_are_those_of_quaternions_of_any_length(void)
{
    for (unsigned i = 0; i < 50000; i++) {
        int32_t q[4], R[9];
        some(q, i % 2u ? WG_QUAT_ONE : WG_QUAT_ONE / 2 * 3);
        double want[9], size = length_of(q);
        double p[4] = {q[0], q[1], q[2], q[3]};
        if (size < 0.5) {
            continue;
        }
        model_of_quaternion(p, want);
        wg_quat_rotation(q, R);
        for (unsigned k = 0; k < 9; k++) {
            CHECK_NEAR(ldexp(R[k], -30), want[k], ldexp(1, -21));
        }
    }
}

static void short_quaternions_turn_nothing(void)
{
    const int32_t q[4] = {0, 1 << 23, 1 << 23, 1 << 23}; /* n = 3 2^14 < 2^16 */
    int32_t R[9];
    wg_quat_rotation(q, R);
    for (unsigned k = 0; k < 9; k++) {
        CHECK_EQ(R[k], k % 4u == 0 ? 1 << 30 : 0);
    }
}

int main(void)
{
    TEST(root_is_the_floor_of_the_root);
    TEST(bit_lengths_are_those_of_the_number);
    TEST(directions_of_16_bits_have_their_angle);
    TEST(phases_are_products_to_the_bit);
    TEST(products_are_those_of_quaternions);
    TEST(units_have_length_1_and_their_direction);
    TEST(extreme_quaternions_are_units_or_none);
    TEST(matrices_are_those_of_quaternions_of_any_length);
    TEST(short_quaternions_turn_nothing);
    return check_done();
}
