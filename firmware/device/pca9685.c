/* PCA9685 register writes. Source: PCA9685 data sheet 7.3.1 to 7.3.5.
 * SPDX-License-Identifier: MIT */
#include "pca9685.h"

#include <string.h>

#include "wg_mem.h"

#define MODE1     0x00u
#define MODE2     0x01u
#define LED0      0x06u /* ON_L ON_H OFF_L OFF_H a channel */
#define ALL_LED   0xfau
#define PRE_SCALE 0xfeu

#define MODE1_SLEEP          0x10u
#define MODE1_AUTO_INCREMENT 0x20u
#define MODE2_PUSH_PULL      0x04u
#define FULL_OFF             0x10u /* in OFF_H; wins over everything else */

int wg_pca9685_setup(const wg_pca9685 *pwm, uint8_t step, uint8_t *out, uint16_t size)
{
    /* 5 bytes a step: their number, then the bytes. */
    static const uint8_t writes[5][6] WG_TABLE = {
        {2, MODE1, MODE1_SLEEP | MODE1_AUTO_INCREMENT},
        {5, ALL_LED, 0, 0, 0, FULL_OFF},
        {2, PRE_SCALE, 0},
        {2, MODE2, MODE2_PUSH_PULL},
        {2, MODE1, MODE1_AUTO_INCREMENT},
    };
    wg_bytes bytes = {out, size, 0};
    uint8_t i;

    if (step >= 5) {
        return 0;
    }
    for (i = 1; i <= wg_rd8(&writes[step][0]); i++) {
        wg_bytes_put(&bytes, step == 2 && i == 2 ? pwm->prescale : wg_rd8(&writes[step][i]));
    }
    return wg_bytes_result(&bytes);
}

/* OFF count of a pulse, 0 = full off. 15 bits x 32 bits fit in 64. */
static uint16_t off_count(const wg_servo *servo, uint32_t scale_q20)
{
    int16_t position = wg_servo_position(servo);
    uint64_t ticks;

    if (!wg_servo_on(servo) || position <= 0) {
        return 0;
    }
    ticks = (((uint64_t)scale_q20 * (uint16_t)position >> 19) + 1) >> 1;
    return ticks > 4095 ? 4095 : (uint16_t)ticks;
}

int wg_pca9685_frame(const wg_file *file, const wg_servo *state, const wg_pca9685 *pwm,
                     uint8_t chip, uint8_t *out)
{
    uint8_t low = WG_PCA9685_CHANNELS, high = 0, k;
    uint16_t i;

    memset(out, 0, WG_PCA9685_BYTES);
    for (k = 0; k < WG_PCA9685_CHANNELS; k++) {
        out[4 * k + 4] = FULL_OFF;
    }
    for (i = 0; i < file->section[WG_SECTION_SERVOS].count; i++) {
        int16_t id = wg_bus_id(file, i, WG_PROTOCOL_PCA9685);
        uint16_t ticks = off_count(&state[i], pwm->scale_q20);
        if (id < 0 || id >> 4 != chip) {
            continue;
        }
        k = (uint8_t)(id & 15);
        low = k < low ? k : low;
        high = k > high ? k : high;
        out[4 * k + 3] = (uint8_t)ticks;
        out[4 * k + 4] = (uint8_t)(ticks ? ticks >> 8 : FULL_OFF);
    }
    if (low == WG_PCA9685_CHANNELS) {
        return 0;
    }
    memmove(out + 1, out + 1 + 4 * low, 4u * (uint8_t)(high - low + 1));
    out[0] = (uint8_t)(LED0 + 4u * low);
    return 1 + 4 * (high - low + 1);
}
