/* The processor-dependent functions of wg_mul.h, as the host has them, against their definitions in
 * 128 bits. On the boards, tests/fw_mul.c hashes the results for the same operands and
 * tests/test_boards.py compares.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "mul_pairs.h"

__extension__ typedef __int128 wide;

/* floor(a / 2^bits), by division: no shift of a negative number, as the functions themselves do. */
static wide floor_div(wide a, unsigned bits)
{
    wide divisor = (wide)1 << bits, quotient = a / divisor;
    return quotient * divisor > a ? quotient - 1 : quotient;
}

static wide definition(uint8_t function, mul_pair p)
{
    wide a = p.a, b = p.b, sa = (int32_t)p.a;
    switch (function) {
    case MUL_H:
        return floor_div(sa * (int32_t)p.b, 32);
    case MUL_Q:
        return floor_div(sa * (int16_t)p.b, 16);
    case MUL_SM:
        return floor_div(sa * b, 16);
    case MUL_29:
        return floor_div(a * b, 16) < 1 << 29 ? floor_div(a * b, 16) : 1 << 29;
    case MUL_17:
        return floor_div(a * b, 17);
    case MUL_WEIGH:
        return floor_div(sa * b, 15);
    case MUL_INVERSE:
        return UINT32_MAX / a;
    default: /* MUL_SHR */
        return floor_div(sa, p.b);
    }
}

/* Counted, so that no function gets away with results that are all the same. */
static unsigned saturated, negative;

static void check_function(uint8_t function)
{
    uint32_t seed = 1;
    for (uint32_t i = 0; i < MUL_PAIRS; i++) {
        mul_pair p = mul_fit(function, mul_pair_at(i, &seed));
        uint32_t got = mul_result(function, p), want = (uint32_t)definition(function, p);
        if (got != want) {
            printf("%s %08x %08x\n", mul_names[function], (unsigned)p.a, (unsigned)p.b);
        }
        CHECK_EQ(got, want);
        saturated += function == MUL_29 && got == 1u << 29;
        negative += function == MUL_H && (int32_t)got < 0;
    }
}

static void results_are_the_definitions_floors(void)
{
    for (uint8_t function = 0; function < MUL_FUNCTIONS; function++) {
        check_function(function);
    }
}

static void operands_reach_signs_and_saturation(void)
{
    CHECK(negative > MUL_PAIRS / 4 && negative < MUL_PAIRS * 3 / 4);
    CHECK(saturated > MUL_PAIRS / 4 && saturated < MUL_PAIRS * 9 / 10);
}

static void every_divisor_has_its_inverse(void)
{
    for (uint32_t a = 1; a < 65536; a++) {
        uint64_t q = wg_inverse((uint16_t)a);
        CHECK(q * a <= UINT32_MAX && (q + 1) * a > UINT32_MAX);
    }
}

int main(void)
{
    TEST(results_are_the_definitions_floors);
    TEST(operands_reach_signs_and_saturation);
    TEST(every_divisor_has_its_inverse);
    return check_done();
}
