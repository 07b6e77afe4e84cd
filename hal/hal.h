/* What a board must provide: time, a serial bus, I2C, SPI, a log line, a watchdog, a way to stop.
 * hal/<chip>/ implements it; the HAL moves bytes and does not know what they mean.
 * SPDX-License-Identifier: MIT */
#ifndef HAL_H
#define HAL_H

#include <stdint.h>

/* Clocks, pins and the two serial lines (log and bus). Call once, first. */
void hal_init(void);

/* Microseconds since hal_init, wrapping after 71 minutes. */
uint32_t hal_time_us(void);

/* Returns at `time_us` or at once when it has passed (signed difference). Kicks the watchdog. */
void hal_wait_until(uint32_t time_us);

/* Queues or sends `count` bytes on the servo bus; returns when they are accepted. */
void hal_bus_write(const uint8_t *bytes, uint16_t count);

/* Takes up to `size` bytes that have arrived on the servo bus; returns how many, never waits. */
uint16_t hal_bus_read(uint8_t *bytes, uint16_t size);

/* One I2C write transaction to a 7-bit address: 0, or -1 when nobody acknowledged. */
int hal_i2c_write(uint8_t address, const uint8_t *bytes, uint16_t count);

/* One SPI transfer, mode 0, most significant bit first: the device is selected before the first bit
 * and released after the last, and `dc` is the level of its data/command line meanwhile. */
void hal_spi_write(uint8_t dc, const uint8_t *bytes, uint16_t count);

/* A line for people: `text` ends at its NUL; a newline is added. */
void hal_log(const char *text);

/* Ends the program: on an emulated board the emulator exits with `code`, on a real one outputs
 * stay as they are and the processor sleeps. */
void hal_stop(int code);

#endif
