/* Self-test image of a HAL: every function of hal.h once, with answers that a person or a script
 * can check on the two lines. A new port runs this first.
 *   bus    all 256 byte values in order, then each received byte plus one, for 100 ms
 *   I2C    01 02 03 04 to the memory at 0x40, if there is one
 *   SPI    01 02 03 04 twice, as command and as data; nothing answers, so it only has to come back
 *   stops  with 42
 * SPDX-License-Identifier: MIT */
#include "hal.h"

#define WAIT_US      50000u
#define LATE_US      200u /* a desktop may be later; an emulated board is not */
#define LISTEN_US    2000000u
#define LISTEN_BYTES 4u

static void time_test(void)
{
    uint32_t until = hal_time_us() + WAIT_US;
    hal_wait_until(until);
    hal_log(hal_time_us() - until <= LATE_US ? "wait ok" : "wait: early or late");
    uint32_t from = hal_time_us();
    hal_wait_until(from - 1u);
    hal_log(hal_time_us() - from <= LATE_US ? "past ok" : "past: waited for a time gone by");
}

static void bus_test(void)
{
    uint8_t bytes[16];
    for (uint16_t row = 0; row < 16; row++) {
        for (uint8_t i = 0; i < 16; i++) {
            bytes[i] = (uint8_t)(row * 16u + i);
        }
        hal_bus_write(bytes, sizeof bytes);
    }
}

static void echo_test(void)
{
    uint32_t from = hal_time_us();
    for (uint8_t count = 0; count < LISTEN_BYTES && hal_time_us() - from < LISTEN_US;) {
        uint8_t byte;
        hal_wait_until(hal_time_us()); /* for the watchdog */
        if (hal_bus_read(&byte, 1) == 1) {
            byte++;
            hal_bus_write(&byte, 1);
            count++;
        }
    }
}

int main(void)
{
    static const uint8_t data[] = {1, 2, 3, 4};
    hal_init();
    hal_log("hal");
    time_test();
    bus_test();
    echo_test();
    hal_log(hal_i2c_write(0x40, data, sizeof data) == 0 ? "i2c 40 ok" : "i2c 40 silent");
    hal_log(hal_i2c_write(0x41, data, sizeof data) == 0 ? "i2c 41 ok" : "i2c 41 silent");
    hal_spi_write(0, data, sizeof data);
    hal_spi_write(1, data, sizeof data);
    hal_log("spi sent");
    hal_stop(42);
    return 0;
}
