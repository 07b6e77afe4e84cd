/* The port to copy: a board that has nothing. It builds and runs on the host, without a wait, so
 * that it also shows how fast the rest is. To port wiggly, copy this file to hal/<chip>/, keep the
 * nine signatures of hal.h and fill in what your chip can do; start with hal_log and hal_time_us,
 * then `make run` says "opened" on your log line. What may stay empty is said in each function.
 * SPDX-License-Identifier: MIT */
#include "hal.h"

#include <stdlib.h> /* a chip does not have this: see hal_stop */

static uint32_t now_us; /* replaces the hardware timer */

/* Clocks first, then pins, then the two serial lines and the timer. Runs once, before anything. */
void hal_init(void)
{
    now_us = 0;
}

/* Best: a free-running 32-bit timer at 1 MHz, as in hal/nrf51 and hal/cmsdk. A 16-bit timer needs
 * an overflow count (hal/atmega). A timer that wraps before 2^32 us makes the animation jump. */
uint32_t hal_time_us(void)
{
    return now_us;
}

/* The comparison must be signed, (int32_t)(time_us - hal_time_us()) > 0: plain < fails when the
 * clock wraps. Arm the watchdog here and not in hal_init, with more than two frames of patience. */
void hal_wait_until(uint32_t time_us)
{
    if ((int32_t)(time_us - now_us) > 0) {
        now_us = time_us;
    }
}

/* Must not lose bytes: wait when the transmitter is full. Half-duplex buses switch direction here.
 */
void hal_bus_write(const uint8_t *bytes, uint16_t count)
{
    (void)bytes;
    (void)count;
}

/* May always return 0 if nothing ever answers on the bus. Never waits. */
uint16_t hal_bus_read(uint8_t *bytes, uint16_t size)
{
    (void)bytes;
    (void)size;
    return 0;
}

/* -1 is the right answer of a chip without I2C. Bound every wait: a missing pull-up must not hang.
 */
int hal_i2c_write(uint8_t address, const uint8_t *bytes, uint16_t count)
{
    (void)address;
    (void)bytes;
    (void)count;
    return -1;
}

/* May stay empty on a chip without a display on SPI. Two pins beside the SPI's own: select, whose
 * idle level board.h knows, and data/command, which must not change before the last bit has left.
 */
void hal_spi_write(uint8_t dc, const uint8_t *bytes, uint16_t count)
{
    (void)dc;
    (void)bytes;
    (void)count;
}

/* May stay empty, but then nobody learns why a clip was refused. */
void hal_log(const char *text)
{
    (void)text;
}

/* Never returns. On a chip: leave the outputs as they are, stop the watchdog, sleep in a loop. */
void hal_stop(int code)
{
    exit(code);
}
