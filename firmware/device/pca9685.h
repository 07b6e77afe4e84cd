/* NXP PCA9685: 16 PWM outputs on I2C, used as servo pulses.
 * Source: PCA9685 data sheet, sections 7.3.1 to 7.3.5. Ids are channel + 16 x chip; chip k answers
 * at WG_PCA9685_ADDRESS + k. A position is 1/4 us, a tick of the chip 4.88 us at 50 Hz.
 *
 *   static const wg_pca9685 pwm = WG_PCA9685(25000000, 50);
 *   uint8_t out[WG_PCA9685_BYTES];
 *   for (step = 0; (n = wg_pca9685_setup(&pwm, step, out, sizeof out)) > 0; step++)
 *       hal_i2c_write(address, out, n);                 // then wait 500 us for the oscillator
 *   n = wg_pca9685_frame(&file, servos, &pwm, 0, out);  // every tick
 *   if (n > 0) hal_i2c_write(address, out, n);
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_PCA9685_H
#define WIGGLY_PCA9685_H

#include "bus.h"

#ifdef __cplusplus
extern "C" {
#endif

#define WG_PCA9685_ADDRESS  0x40u
#define WG_PCA9685_CHANNELS 16u
#define WG_PCA9685_BYTES    (1u + 4u * WG_PCA9685_CHANNELS) /* the longest write */

/* round(oscillator / 4096 / hertz) - 1, in 3..255: 24 to 1526 Hz. Truncation would give 29 instead
 * of the data sheet's 30 at 200 Hz. Constant for constant arguments, as is everything here. */
#define WG_PCA9685_DIVIDER(oscillator_hz, hertz)                                                   \
    (((uint32_t)(oscillator_hz) + 2048ul * (hertz)) / (4096ul * (hertz)))
#define WG_PCA9685_PRESCALE(oscillator_hz, hertz)                                                  \
    (WG_PCA9685_DIVIDER(oscillator_hz, hertz) < 4u ? 3u                                            \
     : WG_PCA9685_DIVIDER(oscillator_hz, hertz) > 256u                                             \
         ? 255u                                                                                    \
         : WG_PCA9685_DIVIDER(oscillator_hz, hertz) - 1u)

/* Ticks a quarter microsecond in UQ20, from the divider in use, not from the hertz asked for. */
#define WG_PCA9685_SCALE(oscillator_hz, prescale)                                                  \
    ((uint32_t)(((uint64_t)(oscillator_hz) << 18) / (1000000ul * ((prescale) + 1u))))

/* `oscillator_hz` is nominally 25 MHz; chips lie up to 5 % off, so measure a pulse and trim. */
#define WG_PCA9685(oscillator_hz, hertz)                                                           \
    {                                                                                              \
        WG_PCA9685_SCALE(oscillator_hz, WG_PCA9685_PRESCALE(oscillator_hz, hertz)),                \
            (uint8_t)WG_PCA9685_PRESCALE(oscillator_hz, hertz)                                     \
    }

typedef struct {
    uint32_t scale_q20;
    uint8_t prescale;
} wg_pca9685;

/* The I2C writes that bring a chip up, one a step: sleep (PRE_SCALE is ignored otherwise), all
 * outputs full off, PRE_SCALE, push-pull outputs, wake with auto-increment.
 *   returns  bytes for this step, 0 after the last, or WG_ERR_SPACE */
int wg_pca9685_setup(const wg_pca9685 *pwm, uint8_t step, uint8_t *out, uint16_t size);

/* All servos of chip `chip` in one write, so that they change together, at its STOP. The write
 * spans the lowest to the highest channel in use; channels between them without a servo are held
 * full off, as is a servo that is not on or at a position below half a tick.
 *   out      WG_PCA9685_BYTES
 *   returns  bytes written, or 0: no servo on this chip
 *   rounding OFF = round(position scale / 2^20), halves up, in 1..4095, and ON = 0: never equal */
int wg_pca9685_frame(const wg_file *file, const wg_servo *state, const wg_pca9685 *pwm,
                     uint8_t chip, uint8_t *out);

#ifdef __cplusplus
}
#endif
#endif
