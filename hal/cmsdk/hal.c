/* Arm MPS2 boards: CMSDK UARTs and watchdog, FPGAIO counter, SBCon I2C, all polled.
 * The bus receiver holds one byte: hal_bus_read must keep up with it.
 * Source: Arm DDI0479 (CMSDK), DAI0386 (AN386 memory map).
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "bare.h"
#include "board.h"

#define UART_DATA          0x00u
#define UART_STATE         0x04u
#define UART_STATE_TX_FULL 1u
#define UART_STATE_RX_FULL 2u
#define UART_CTRL          0x08u
#define UART_CTRL_TX_RX    3u
#define UART_BAUDDIV       0x10u

#define FPGAIO_COUNTER  0x18u
#define FPGAIO_PRESCALE 0x1cu

#define WATCHDOG_LOAD     0x00u
#define WATCHDOG_CONTROL  0x08u
#define WATCHDOG_RESET_ON 3u /* interrupt on the first timeout, reset on the second */
#define WATCHDOG_CLEAR    0x0cu
#define WATCHDOG_LOCK     0xc00u
#define WATCHDOG_KEY      0x1acce551u

#define I2C_SET   0x00u /* reads back the lines */
#define I2C_CLEAR 0x04u
#define SCL       1u
#define SDA       2u

static void uart_init(uint32_t base, uint32_t baud)
{
    REG(base, UART_BAUDDIV) = BOARD_CLOCK_HZ / baud;
    REG(base, UART_CTRL) = UART_CTRL_TX_RX;
}

static void uart_write(uint32_t base, uint8_t byte)
{
    while (REG(base, UART_STATE) & UART_STATE_TX_FULL) { /* at most one byte time */
    }
    REG(base, UART_DATA) = byte;
}

static void watchdog(uint32_t control)
{
    REG(BOARD_WATCHDOG, WATCHDOG_LOCK) = WATCHDOG_KEY;
    REG(BOARD_WATCHDOG, WATCHDOG_LOAD) = BOARD_CLOCK_HZ; /* 1 s to the first of two timeouts */
    REG(BOARD_WATCHDOG, WATCHDOG_CONTROL) = control;
}

void hal_init(void)
{
    uart_init(BOARD_LOG_UART, BOARD_LOG_BAUD);
    uart_init(BOARD_BUS_UART, BOARD_BUS_BAUD);
    REG(BOARD_I2C, I2C_SET) = SCL | SDA;
    REG(BOARD_FPGAIO, FPGAIO_PRESCALE) = BOARD_CLOCK_HZ / 1000000u - 1u;
    REG(BOARD_FPGAIO, FPGAIO_COUNTER) = 0;
}

uint32_t hal_time_us(void)
{
    return REG(BOARD_FPGAIO, FPGAIO_COUNTER);
}

void hal_wait_until(uint32_t time_us)
{
    watchdog(
        WATCHDOG_RESET_ON); /* armed by the first frame: a program without one is not watched */
    REG(BOARD_WATCHDOG, WATCHDOG_CLEAR) = 1;
    while ((int32_t)(time_us - hal_time_us()) > 0) {
    }
}

void hal_bus_write(const uint8_t *bytes, uint16_t count)
{
    while (count--) {
        uart_write(BOARD_BUS_UART, *bytes++);
    }
}

uint16_t hal_bus_read(uint8_t *bytes, uint16_t size)
{
    uint16_t count = 0;
    while (count < size && (REG(BOARD_BUS_UART, UART_STATE) & UART_STATE_RX_FULL)) {
        bytes[count++] = (uint8_t)REG(BOARD_BUS_UART, UART_DATA);
    }
    return count;
}

/* Half a period of the I2C clock; the register accesses themselves come on top. */
static void i2c_line(uint32_t set_or_clear, uint32_t lines)
{
    REG(BOARD_I2C, set_or_clear) = lines;
    uint32_t from = REG(BOARD_FPGAIO, FPGAIO_COUNTER);
    while (REG(BOARD_FPGAIO, FPGAIO_COUNTER) - from < BOARD_I2C_HALF_US) {
    }
}

/* Eight bits and the acknowledge clock: 0, or -1 when nobody pulled SDA down. */
static int i2c_byte(uint8_t byte)
{
    for (uint8_t bit = 0x80; bit; bit >>= 1) {
        i2c_line(byte & bit ? I2C_SET : I2C_CLEAR, SDA);
        i2c_line(I2C_SET, SCL);
        i2c_line(I2C_CLEAR, SCL);
    }
    i2c_line(I2C_SET, SDA);
    i2c_line(I2C_SET, SCL);
    int answer = REG(BOARD_I2C, I2C_SET) & SDA ? -1 : 0;
    i2c_line(I2C_CLEAR, SCL);
    return answer;
}

int hal_i2c_write(uint8_t address, const uint8_t *bytes, uint16_t count)
{
    i2c_line(I2C_CLEAR, SDA); /* start */
    i2c_line(I2C_CLEAR, SCL);
    int answer = i2c_byte((uint8_t)(address << 1));
    while (answer == 0 && count--) {
        answer = i2c_byte(*bytes++);
    }
    i2c_line(I2C_CLEAR, SDA); /* stop */
    i2c_line(I2C_SET, SCL);
    i2c_line(I2C_SET, SDA);
    return answer;
}

/* The board's SPI ports have no data/command line: displays on I2C only. */
void hal_spi_write(uint8_t dc, const uint8_t *bytes, uint16_t count)
{
    (void)dc;
    (void)bytes;
    (void)count;
}

void hal_log(const char *text)
{
    while (*text) {
        uart_write(BOARD_LOG_UART, (uint8_t)*text++);
    }
    uart_write(BOARD_LOG_UART, '\n');
}

void hal_stop(int code)
{
    watchdog(0);
    semihost_stop(code);
    for (;;) {
        bare_sleep();
    }
}
