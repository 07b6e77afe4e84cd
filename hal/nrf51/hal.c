/* Nordic nRF51: one UART (the bus), TIMER0, TWI0, SPI1, all polled. The log goes to the debugger, because
 * there is no second UART; without a debugger it goes nowhere.
 * The receiver holds six bytes: hal_bus_read must keep up with it.
 * Source: Nordic nRF51 Series Reference Manual 3.0.1.
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "bare.h"
#include "board.h"

#define CLOCK         0x40000000u
#define CLOCK_START   0x000u /* the crystal: the RC oscillator is too coarse for a UART */
#define CLOCK_STARTED 0x100u
#define CLOCK_TRIES   100000u /* polls of >= 3 cycles, 18 ms or more: a crystal takes about 1 ms */

#define UART           0x40002000u
#define UART_START_RX  0x000u
#define UART_START_TX  0x008u
#define UART_RX_READY  0x108u
#define UART_TX_READY  0x11cu
#define UART_ENABLE    0x500u
#define UART_ENABLE_ON 4u
#define UART_PIN_TX    0x50cu
#define UART_PIN_RX    0x514u
#define UART_RX        0x518u
#define UART_TX        0x51cu
#define UART_BAUD      0x524u

#define TWI              0x40003000u
#define TWI_START_TX     0x008u
#define TWI_STOP         0x014u
#define TWI_STOPPED      0x104u
#define TWI_SENT         0x11cu
#define TWI_ERROR        0x124u
#define TWI_ERROR_SOURCE 0x4c4u
#define TWI_ENABLE       0x500u
#define TWI_ENABLE_ON    5u
#define TWI_PIN_SCL      0x508u
#define TWI_PIN_SDA      0x50cu
#define TWI_TX           0x51cu
#define TWI_FREQUENCY    0x524u
#define TWI_400_KHZ      0x06680000u
#define TWI_ADDRESS      0x588u
#define TWI_WAIT_US      1000u /* a byte takes 23 us; a slave may stretch the clock */

#define SPI           0x40004000u
#define SPI_READY     0x108u
#define SPI_ENABLE    0x500u
#define SPI_ENABLE_ON 1u
#define SPI_PIN_SCK   0x508u
#define SPI_PIN_MOSI  0x50cu
#define SPI_PIN_MISO  0x510u
#define SPI_NO_PIN    0xffffffffu
#define SPI_RX        0x518u
#define SPI_TX        0x51cu
#define SPI_FREQUENCY 0x524u
#define SPI_TRIES     100u /* polls of >= 3 cycles, 18 us or more: a byte takes 8 us at 1 MHz */

#define GPIO       0x50000000u
#define GPIO_SET   0x508u
#define GPIO_CLEAR 0x50cu
#define GPIO_OUT   0x518u

#define TIMER             0x40008000u
#define TIMER_START       0x000u
#define TIMER_CLEAR       0x00cu
#define TIMER_CAPTURE     0x040u
#define TIMER_BITS        0x508u
#define TIMER_BITS_32     3u
#define TIMER_PRESCALER   0x510u
#define TIMER_16_TO_1_MHZ 4u
#define TIMER_CAPTURED    0x540u

#define WATCHDOG                0x40010000u
#define WATCHDOG_START          0x000u
#define WATCHDOG_RELOAD_VALUE   0x504u
#define WATCHDOG_CONFIG         0x50cu
#define WATCHDOG_PAUSE_IN_SLEEP 0u /* hal_stop sleeps, and nothing else does */
#define WATCHDOG_FEED           0x600u
#define WATCHDOG_KEY            0x6e524635u

/* A crystal that does not start is no reason to stop: servos still move with the other clock. */
static void crystal_start(void)
{
    REG(CLOCK, CLOCK_STARTED) = 0;
    REG(CLOCK, CLOCK_START) = 1;
    for (uint32_t tries = CLOCK_TRIES; tries && !REG(CLOCK, CLOCK_STARTED); tries--) {
    }
}

static void pin_write(uint32_t pin, uint32_t level)
{
    REG(GPIO, level ? GPIO_SET : GPIO_CLEAR) = 1u << pin;
}

/* The SPI drives its pins only if the port has them as outputs, at the level they idle on. */
static void spi_init(void)
{
    pin_write(BOARD_PIN_SPI_CS, !BOARD_SPI_SELECTED);
    pin_write(BOARD_PIN_SCK, 0);
    REG(GPIO, GPIO_OUT) = (1u << BOARD_PIN_SCK) | (1u << BOARD_PIN_MOSI) |
                          (1u << BOARD_PIN_SPI_CS) | (1u << BOARD_PIN_SPI_DC);
    REG(SPI, SPI_PIN_SCK) = BOARD_PIN_SCK;
    REG(SPI, SPI_PIN_MOSI) = BOARD_PIN_MOSI;
    REG(SPI, SPI_PIN_MISO) = SPI_NO_PIN;
    REG(SPI, SPI_FREQUENCY) = BOARD_SPI_FREQUENCY_REGISTER;
    REG(SPI, SPI_ENABLE) = SPI_ENABLE_ON;
}

void hal_init(void)
{
    crystal_start();
    REG(UART, UART_PIN_TX) = BOARD_PIN_TX;
    REG(UART, UART_PIN_RX) = BOARD_PIN_RX;
    REG(UART, UART_BAUD) = BOARD_BUS_BAUD_REGISTER;
    REG(UART, UART_ENABLE) = UART_ENABLE_ON;
    REG(UART, UART_START_TX) = 1;
    REG(UART, UART_START_RX) = 1;
    REG(TWI, TWI_PIN_SCL) = BOARD_PIN_SCL;
    REG(TWI, TWI_PIN_SDA) = BOARD_PIN_SDA;
    REG(TWI, TWI_FREQUENCY) = TWI_400_KHZ;
    REG(TWI, TWI_ENABLE) = TWI_ENABLE_ON;
    spi_init();
    REG(TIMER, TIMER_BITS) = TIMER_BITS_32;
    REG(TIMER, TIMER_PRESCALER) = TIMER_16_TO_1_MHZ;
    REG(TIMER, TIMER_CLEAR) = 1;
    REG(TIMER, TIMER_START) = 1;
    REG(WATCHDOG, WATCHDOG_CONFIG) = WATCHDOG_PAUSE_IN_SLEEP;
    REG(WATCHDOG, WATCHDOG_RELOAD_VALUE) = 2u * 32768u;
}

uint32_t hal_time_us(void)
{
    REG(TIMER, TIMER_CAPTURE) = 1;
    return REG(TIMER, TIMER_CAPTURED);
}

void hal_wait_until(uint32_t time_us)
{
    REG(WATCHDOG, WATCHDOG_START) = 1; /* by the first frame; later starts change nothing */
    REG(WATCHDOG, WATCHDOG_FEED) = WATCHDOG_KEY;
    while ((int32_t)(time_us - hal_time_us()) > 0) {
    }
}

void hal_bus_write(const uint8_t *bytes, uint16_t count)
{
    while (count--) {
        REG(UART, UART_TX_READY) = 0;
        REG(UART, UART_TX) = *bytes++;
        while (!REG(UART, UART_TX_READY)) { /* one byte time */
        }
    }
}

uint16_t hal_bus_read(uint8_t *bytes, uint16_t size)
{
    uint16_t count = 0;
    while (count < size && REG(UART, UART_RX_READY)) {
        REG(UART, UART_RX_READY) = 0; /* before the read, which lets the next byte up */
        bytes[count++] = (uint8_t)REG(UART, UART_RX);
    }
    return count;
}

/* Waits for an event of the TWI: 0, or -1 on an error or when it does not come. */
static int twi_wait(uint32_t event)
{
    uint32_t from = hal_time_us();
    while (!REG(TWI, event)) {
        if (REG(TWI, TWI_ERROR) || hal_time_us() - from > TWI_WAIT_US) {
            return -1;
        }
    }
    REG(TWI, event) = 0;
    return 0;
}

int hal_i2c_write(uint8_t address, const uint8_t *bytes, uint16_t count)
{
    int answer = 0;
    REG(TWI, TWI_ADDRESS) = address;
    REG(TWI, TWI_ERROR) = 0;
    REG(TWI, TWI_STOPPED) = 0;
    REG(TWI, TWI_START_TX) = 1;
    while (answer == 0 && count--) {
        REG(TWI, TWI_SENT) = 0;
        REG(TWI, TWI_TX) = *bytes++;
        answer = twi_wait(TWI_SENT);
    }
    REG(TWI, TWI_ERROR_SOURCE) = REG(TWI, TWI_ERROR_SOURCE); /* written ones clear */
    REG(TWI, TWI_ERROR) = 0;
    REG(TWI, TWI_STOP) = 1;
    return twi_wait(TWI_STOPPED) < 0 ? -1 : answer;
}

void hal_spi_write(uint8_t dc, const uint8_t *bytes, uint16_t count)
{
    pin_write(BOARD_PIN_SPI_DC, dc);
    pin_write(BOARD_PIN_SPI_CS, BOARD_SPI_SELECTED);
    while (count--) {
        REG(SPI, SPI_READY) = 0;
        REG(SPI, SPI_TX) = *bytes++;
        for (uint32_t tries = SPI_TRIES; tries && !REG(SPI, SPI_READY); tries--) {
        }
        (void)REG(SPI, SPI_RX); /* lets the next READY come */
    }
    pin_write(BOARD_PIN_SPI_CS, !BOARD_SPI_SELECTED);
}

void hal_log(const char *text)
{
    semihost_log(text);
}

void hal_stop(int code)
{
    semihost_stop(code);
    for (;;) {
        bare_sleep();
    }
}
