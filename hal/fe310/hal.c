/* SiFive FE310: UART0 is the log, UART1 the bus, SPI1, time from the core's mtime, all polled.
 * The receiver holds eight bytes: hal_bus_read must keep up with it. The FE310-G000 has no I2C.
 * Source: SiFive FE310-G000 Manual v3p2, FE310-G002 Manual v1p5 (UART1).
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "bare.h"
#include "board.h"

#define CLINT      0x02000000u
#define MTIME_LOW  0xbff8u
#define MTIME_HIGH 0xbffcu

#define AON               0x10000000u
#define WATCHDOG_CONFIG   0x000u
#define WATCHDOG_RESET_ON ((1u << 8) | (1u << 12)) /* reset enable, run always */
#define WATCHDOG_FEED     0x018u
#define WATCHDOG_FOOD     0x0d09f00du
#define WATCHDOG_KEY      0x01cu /* before each write to the others */
#define WATCHDOG_UNLOCK   0x0051f15eu
#define WATCHDOG_COMPARE  0x020u
#define WATCHDOG_2_S      0xffffu /* of 32768 Hz */

#define GPIO                 0x10012000u
#define GPIO_OUT_ON          0x08u
#define GPIO_OUT             0x0cu
#define GPIO_FUNCTION_ON     0x38u
#define GPIO_FUNCTION_SELECT 0x3cu
#define GPIO_UART0           (3u << 16)                          /* RX 16, TX 17: function 0 */
#define GPIO_UART1           ((1u << 18) | (1u << 23))           /* TX 18, RX 23: function 0 */
#define GPIO_SPI1            ((1u << 2) | (1u << 3) | (1u << 5)) /* CS0 2, MOSI 3, SCK 5: function 0 */

#define UART0           0x10013000u
#define UART1           0x10023000u
#define UART_TX         0x00u /* negative: full */
#define UART_RX         0x04u /* negative: empty */
#define UART_TX_CONTROL 0x08u
#define UART_RX_CONTROL 0x0cu
#define UART_DIVISOR    0x18u

#define SPI1        0x10024000u
#define SPI_DIVISOR 0x00u
#define SPI_CS_IDLE 0x14u /* the level of CS0 while nothing is selected */
#define SPI_CS_MODE 0x18u
#define SPI_CS_AUTO 0u
#define SPI_CS_HOLD 2u
#define SPI_TX      0x48u
#define SPI_RX      0x4cu /* negative: empty; 8 bits, mode 0 and MSB first are the reset values */
#define SPI_TRIES   1000u /* polls of >= 2 cycles: a byte takes 8 us at 1 MHz, 128 cycles at 16 MHz */

static void uart_init(uint32_t base, uint32_t baud)
{
    REG(base, UART_DIVISOR) = BOARD_CLOCK_HZ / baud - 1u;
    REG(base, UART_TX_CONTROL) = 1;
    REG(base, UART_RX_CONTROL) = 1;
}

static void uart_write(uint32_t base, uint8_t byte)
{
    while ((int32_t)REG(base, UART_TX) < 0) { /* at most one byte time */
    }
    REG(base, UART_TX) = byte;
}

static void watchdog_set(uint32_t offset, uint32_t value)
{
    REG(AON, WATCHDOG_KEY) = WATCHDOG_UNLOCK;
    REG(AON, offset) = value;
}

static uint64_t mtime(void)
{
    uint32_t high, low;
    do { /* again when the low word wrapped in between: at most twice */
        high = REG(CLINT, MTIME_HIGH);
        low = REG(CLINT, MTIME_LOW);
    } while (high != REG(CLINT, MTIME_HIGH));
    return (uint64_t)high << 32 | low;
}

static uint64_t time_start; /* mtime at hal_init */

void hal_init(void)
{
    REG(GPIO, GPIO_FUNCTION_SELECT) &= ~(GPIO_UART0 | GPIO_UART1 | GPIO_SPI1);
    REG(GPIO, GPIO_FUNCTION_ON) |= GPIO_UART0 | GPIO_UART1 | GPIO_SPI1;
    REG(GPIO, GPIO_OUT_ON) |= 1u << BOARD_PIN_SPI_DC;
    REG(SPI1, SPI_DIVISOR) = BOARD_CLOCK_HZ / (2u * BOARD_SPI_HZ) - 1u;
    REG(SPI1, SPI_CS_IDLE) = !BOARD_SPI_SELECTED;
    uart_init(UART0, BOARD_LOG_BAUD);
    uart_init(UART1, BOARD_BUS_BAUD);
    time_start = mtime();
}

/* 10^6 / 64 = 15625 is exact, and so is a 64th of both clocks in use (32768 Hz, 10 MHz); the
 * product stays below 2^64 for three years at 10 MHz. */
uint32_t hal_time_us(void)
{
    return (uint32_t)((mtime() - time_start) * 15625u / (BOARD_MTIME_HZ / 64u));
}

void hal_wait_until(uint32_t time_us)
{
    watchdog_set(WATCHDOG_FEED, WATCHDOG_FOOD);
    watchdog_set(WATCHDOG_COMPARE, WATCHDOG_2_S);
    watchdog_set(WATCHDOG_CONFIG, WATCHDOG_RESET_ON); /* armed by the first frame */
    while ((int32_t)(time_us - hal_time_us()) > 0) {
    }
}

void hal_bus_write(const uint8_t *bytes, uint16_t count)
{
    while (count--) {
        uart_write(UART1, *bytes++);
    }
}

uint16_t hal_bus_read(uint8_t *bytes, uint16_t size)
{
    uint16_t count = 0;
    while (count < size) {
        int32_t word = (int32_t)REG(UART1, UART_RX); /* empty or a byte: reading takes it */
        if (word < 0) {
            break;
        }
        bytes[count++] = (uint8_t)word;
    }
    return count;
}

int hal_i2c_write(uint8_t address, const uint8_t *bytes, uint16_t count)
{
    (void)address;
    (void)bytes;
    (void)count;
    return -1; /* no I2C on this chip: nobody acknowledges */
}

void hal_spi_write(uint8_t dc, const uint8_t *bytes, uint16_t count)
{
    uint32_t others = REG(GPIO, GPIO_OUT) & ~(1u << BOARD_PIN_SPI_DC);
    REG(GPIO, GPIO_OUT) = others | (dc ? 1u << BOARD_PIN_SPI_DC : 0);
    REG(SPI1, SPI_CS_MODE) = SPI_CS_HOLD;
    while (count--) {
        REG(SPI1, SPI_TX) = *bytes++;
        for (uint32_t tries = SPI_TRIES; tries && (int32_t)REG(SPI1, SPI_RX) < 0; tries--) {
        } /* a byte has come in: this one is out */
    }
    REG(SPI1, SPI_CS_MODE) = SPI_CS_AUTO; /* releases it */
}

void hal_log(const char *text)
{
    while (*text) {
        uart_write(UART0, (uint8_t)*text++);
    }
    uart_write(UART0, '\n');
}

void hal_stop(int code)
{
    watchdog_set(WATCHDOG_CONFIG, 0);
    semihost_stop(code);
    for (;;) {
        bare_sleep();
    }
}
