/* PCA9685 register writes against the data sheet, and its traps.
 * SPDX-License-Identifier: MIT */
#include "device_clip.h"
#include "pca9685.h"

static int build_pca9685(const char *name, uint8_t *out, uint16_t size)
{
    static const wg_pca9685 at_200 = WG_PCA9685(25000000, 200), at_50 = WG_PCA9685(25000000, 50);

    if (strcmp(name, "pca9685_prescale_200hz") == 0) {
        return wg_pca9685_setup(&at_200, 2, out, size);
    }
    if (strcmp(name, "pca9685_prescale_50hz") == 0) {
        return wg_pca9685_setup(&at_50, 2, out, size);
    }
    if (strcmp(name, "pca9685_ch0_1500us_50hz") == 0) {
        clip_clear();
        clip_servo(WG_PROTOCOL_PCA9685, 0, 6000);
        return wg_pca9685_frame(&file, servos, &at_50, 0, out);
    }
    return NO_SUCH_VECTOR;
}

static void check_pca9685(const char *name, const uint8_t *want, int count)
{
    uint8_t out[WG_PCA9685_BYTES] = {0};

    compare(name, build_pca9685(name, out, sizeof out), out, want, count);
}

static void pca9685_writes_match_every_published_one(void)
{
    CHECK_EQ(each_vector("pca9685_", check_pca9685), 3);
}

static void pca9685_prescale_rounds_before_it_subtracts_one(void)
{
    CHECK_EQ(WG_PCA9685_PRESCALE(25000000, 200), 30); /* truncation: 29 */
    CHECK_EQ(WG_PCA9685_PRESCALE(25000000, 50), 121);
    CHECK_EQ(WG_PCA9685_PRESCALE(25000000, 60), 101);
    CHECK_EQ(WG_PCA9685_PRESCALE(25000000, 333), 17);
    CHECK_EQ(WG_PCA9685_PRESCALE(25000000, 1526), 3);
    CHECK_EQ(WG_PCA9685_PRESCALE(25000000, 4000), 3);
    CHECK_EQ(WG_PCA9685_PRESCALE(25000000, 24), 253);
    CHECK_EQ(WG_PCA9685_PRESCALE(25000000, 10), 255);
    CHECK_EQ(WG_PCA9685_PRESCALE(26500000, 50), 128);
}

static void pca9685_writes_prescale_only_while_asleep(void)
{
    static const wg_pca9685 pwm = WG_PCA9685(25000000, 50);
    uint8_t out[8], mode1 = 0, prescale_writes = 0;
    int n;

    for (uint8_t step = 0; (n = wg_pca9685_setup(&pwm, step, out, sizeof out)) > 0; step++) {
        mode1 = out[0] == 0x00 ? out[1] : mode1;
        if (out[0] == 0xfe) {
            CHECK(mode1 & 0x10);
            prescale_writes++;
        }
    }
    CHECK_EQ(n, 0);
    CHECK_EQ(prescale_writes, 1);
    CHECK_EQ(mode1, 0x20); /* awake, auto-increment */
    CHECK_EQ(wg_pca9685_setup(&pwm, 1, out, 4), WG_ERR_SPACE);
}

/* OFF in 1..4095 with ON = 0, and within half a tick of the pulse asked for, at every rate. */
static void pca9685_on_never_equals_off_and_pulses_are_right_to_half_a_tick(void)
{
    static const wg_pca9685 pwm[] = {WG_PCA9685(25000000, 50), WG_PCA9685(25000000, 200),
                                     WG_PCA9685(26500000, 333), WG_PCA9685(23000000, 1526)};
    static const double hz[] = {25e6, 25e6, 26.5e6, 23e6};
    uint8_t out[WG_PCA9685_BYTES];

    for (int k = 0; k < 4; k++) {
        double tick_us = 1e6 * (pwm[k].prescale + 1) / hz[k];
        for (int32_t position = -400; position < 20000; position += 3) {
            clip_clear();
            clip_servo(WG_PROTOCOL_PCA9685, 0x25, (int16_t)(position ? position : 1));
            CHECK_EQ(wg_pca9685_frame(&file, servos, &pwm[k], 2, out), 5);
            CHECK_EQ(out[1] | out[2], 0);
            if (position / 4.0 < tick_us * 0.499) {
                CHECK_EQ(out[4], 0x10);
            } else {
                int off = out[3] | out[4] << 8;
                CHECK(off >= 1 && off <= 4095);
                /* The scale's own rounding: 2^-20 of a tick a quarter microsecond. */
                CHECK(off == 4095 ||
                      position / 4.0 - off * tick_us <= tick_us * (0.5 + 20000.0 / (1 << 20)));
                CHECK(off * tick_us - position / 4.0 <= tick_us * (0.5 + 1e-9));
            }
        }
    }
}

static void pca9685_moves_all_servos_of_a_chip_in_one_write(void)
{
    static const wg_pca9685 pwm = WG_PCA9685(25000000, 50);
    static const uint8_t want[] = {0x06 + 8, 0, 0, 0x33, 0x01, 0, 0,    0,   0x10,
                                   0,        0, 0, 0x10, 0,    0, 0x9a, 0x02};
    uint8_t out[WG_PCA9685_BYTES];

    clip_clear();
    clip_servo(WG_PROTOCOL_PCA9685, 5, 13000);
    clip_servo(WG_PROTOCOL_PCA9685, 0x12, 6000);
    clip_servo(WG_PROTOCOL_PCA9685, 2, 6000);
    clip_servo(WG_PROTOCOL_PCA9685, 4, 6000);
    wg_servo_off(servos, 3); /* and channel 3 has no servo */
    clip_servo(WG_PROTOCOL_MAESTRO, 9, 6000);
    CHECK_EQ(wg_pca9685_frame(&file, servos, &pwm, 0, out), sizeof want);
    CHECK(memcmp(out, want, sizeof want) == 0);
    CHECK_EQ(wg_pca9685_frame(&file, servos, &pwm, 1, out), 5);
    CHECK_EQ(wg_pca9685_frame(&file, servos, &pwm, 3, out), 0);
}

int main(void)
{
    TEST(pca9685_writes_match_every_published_one);
    TEST(pca9685_prescale_rounds_before_it_subtracts_one);
    TEST(pca9685_writes_prescale_only_while_asleep);
    TEST(pca9685_on_never_equals_off_and_pulses_are_right_to_half_a_tick);
    TEST(pca9685_moves_all_servos_of_a_chip_in_one_write);
    return check_done();
}
