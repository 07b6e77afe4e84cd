/* Luminary (TI) Stellaris LM3S: UART0 is the log, UART1 the bus, SysTick the clock, I2C0, SSI0 as
 * SPI, all polled. The receiver holds 16 bytes.
 * SysTick has 24 bits: a frame that does not look at the clock for 335 ms loses that time.
 * Source: LM3S6965 data sheet; Arm DDI0183 (PL011), DDI0194 (PL022); ARMv7-M B3.3 (SysTick).
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "bare.h"
#include "board.h"

#define SYSTEM             0x400fe000u
#define SYSTEM_STATE       0x050u
#define SYSTEM_PLL_LOCKED  (1u << 6)
#define SYSTEM_CLOCK       0x060u
#define CLOCK_MAIN_OFF     (1u << 0)
#define CLOCK_SOURCE       (3u << 4) /* 0: the crystal */
#define CLOCK_CRYSTAL      (15u << 6)
#define CLOCK_8_MHZ        (14u << 6)
#define CLOCK_BYPASS       (1u << 11)
#define CLOCK_PLL_OFF      (1u << 13)
#define CLOCK_DIVIDE       (1u << 22)
#define CLOCK_DIVISOR      (15u << 23)
#define CLOCK_200_MHZ_BY_4 (3u << 23)
#define CLOCK_TRIES        100000u /* polls: the PLL locks within 0.5 ms */
#define SYSTEM_ON_0        0x100u
#define ON_0_WATCHDOG      (1u << 3)
#define SYSTEM_ON_1        0x104u
#define ON_1_UARTS_SPI_I2C ((3u << 0) | (1u << 4) | (1u << 12))
#define SYSTEM_ON_2        0x108u
#define ON_2_PORTS         0xfu /* A to D */

#define PORT_A        0x40004000u
#define PORT_A_CHIP   0x37u /* PA0, PA1 UART0; PA2, PA4, PA5 SSI0 */
#define PORT_B        0x40005000u
#define PORT_B_I2C    0x0cu
#define PORT_D        0x40007000u
#define PORT_D_UART1  0x0cu
#define PORT_OUTPUT   0x400u
#define PORT_FUNCTION 0x420u
#define PORT_DRAIN    0x50cu
#define PORT_PULL_UP  0x510u
#define PORT_DIGITAL  0x51cu

#define UART0          0x4000c000u
#define UART1          0x4000d000u
#define UART_DATA      0x00u
#define UART_STATE     0x18u
#define UART_RX_EMPTY  (1u << 4)
#define UART_TX_FULL   (1u << 5)
#define UART_BAUD      0x24u
#define UART_BAUD_64TH 0x28u
#define UART_LINE      0x2cu
#define UART_8N1_FIFO  0x70u
#define UART_CONTROL   0x30u
#define UART_ON        0x301u

#define SPI          0x40008000u
#define SPI_FORMAT   0x00u
#define SPI_MODE_0_8 7u /* 8 bits, idle low, sampled at the rising edge */
#define SPI_CONTROL  0x04u
#define SPI_ON       2u
#define SPI_DATA     0x08u
#define SPI_STATE    0x0cu
#define SPI_TX_ROOM  (1u << 1)
#define SPI_RX_SOME  (1u << 2)
#define SPI_BUSY     (1u << 4)
#define SPI_DIVISOR  0x10u
#define SPI_EVEN     (((BOARD_CLOCK_HZ + BOARD_SPI_HZ - 1u) / BOARD_SPI_HZ + 1u) & ~1u)

#define I2C         0x40020000u
#define I2C_ADDRESS 0x00u
#define I2C_CONTROL 0x04u
#define I2C_RUN     1u
#define I2C_START   2u
#define I2C_STOP    4u
#define I2C_BUSY    1u /* of the same register, read */
#define I2C_ERROR   2u
#define I2C_DATA    0x08u
#define I2C_PERIOD  0x0cu
#define I2C_PERIODS ((BOARD_CLOCK_HZ + 20u * BOARD_I2C_HZ - 1u) / (20u * BOARD_I2C_HZ) - 1u)
#define I2C_CONFIG  0x20u
#define I2C_MASTER  0x10u
#define I2C_WAIT_US 1000u /* a byte takes 25 us; a slave may stretch the clock */

#define SYSTICK         0xe000e010u
#define SYSTICK_CONTROL 0x0u
#define SYSTICK_ON      5u /* the processor's clock, no interrupt */
#define SYSTICK_RELOAD  0x4u
#define SYSTICK_VALUE   0x8u
#define SYSTICK_MAX     0xffffffu
#define SYSTICK_US      (BOARD_CLOCK_HZ / 1000000u)

#define WATCHDOG          0x40000000u
#define WATCHDOG_LOAD     0x000u
#define WATCHDOG_CONTROL  0x008u
#define WATCHDOG_RESET_ON 3u /* interrupt on the first timeout, reset on the second */
#define WATCHDOG_CLEAR    0x00cu
#define WATCHDOG_LOCK     0xc00u
#define WATCHDOG_KEY      0x1acce551u

static uint32_t ticks_seen, ticks_left, time_us; /* SysTick last read, less than 1 us of it */

/* The order is the data sheet's: off the PLL, set it up, wait for it, back onto it. */
static void clock_start(void)
{
    uint32_t clock = (REG(SYSTEM, SYSTEM_CLOCK) | CLOCK_BYPASS) & ~(CLOCK_DIVIDE | CLOCK_MAIN_OFF);
    REG(SYSTEM, SYSTEM_CLOCK) = clock;
    clock &= ~(CLOCK_SOURCE | CLOCK_CRYSTAL | CLOCK_PLL_OFF | CLOCK_DIVISOR);
    clock |= CLOCK_8_MHZ;
    REG(SYSTEM, SYSTEM_CLOCK) = clock;
    clock |= CLOCK_DIVIDE | CLOCK_200_MHZ_BY_4;
    REG(SYSTEM, SYSTEM_CLOCK) = clock;
    for (uint32_t tries = CLOCK_TRIES; tries && !(REG(SYSTEM, SYSTEM_STATE) & SYSTEM_PLL_LOCKED);
         tries--) {
    }
    REG(SYSTEM, SYSTEM_CLOCK) = clock & ~CLOCK_BYPASS;
}

/* A port's data register has an address for every set of pins. */
static void pin_write(uint32_t port, uint32_t pin, uint32_t level)
{
    REG(port, 4u << pin) = level << pin;
}

static void pin_output(uint32_t port, uint32_t pin, uint32_t level)
{
    REG(port, PORT_OUTPUT) |= 1u << pin;
    REG(port, PORT_DIGITAL) |= 1u << pin;
    pin_write(port, pin, level);
}

static void pins_of_chip(uint32_t port, uint32_t pins)
{
    REG(port, PORT_FUNCTION) |= pins;
    REG(port, PORT_DIGITAL) |= pins;
}

static void uart_init(uint32_t base, uint32_t baud)
{
    uint32_t divisor = (BOARD_CLOCK_HZ * 4u + baud / 2u) / baud; /* of clock / 16, in 64ths */
    REG(base, UART_CONTROL) = 0;
    REG(base, UART_BAUD) = divisor >> 6;
    REG(base, UART_BAUD_64TH) = divisor & 63u;
    REG(base, UART_LINE) = UART_8N1_FIFO;
    REG(base, UART_CONTROL) = UART_ON;
}

static void uart_write(uint32_t base, uint8_t byte)
{
    while (REG(base, UART_STATE) & UART_TX_FULL) { /* at most one byte time */
    }
    REG(base, UART_DATA) = byte;
}

static void spi_init(void)
{
    pin_output(BOARD_SPI_CS_PORT, BOARD_SPI_CS_PIN, !BOARD_SPI_SELECTED);
    pin_output(BOARD_SPI_DC_PORT, BOARD_SPI_DC_PIN, 0);
    pin_output(BOARD_SD_CARD_CS, BOARD_SD_CARD_PIN, 1); /* which selects QEMU's display */
    REG(SPI, SPI_CONTROL) = 0;
    REG(SPI, SPI_DIVISOR) = SPI_EVEN;
    REG(SPI, SPI_FORMAT) = SPI_MODE_0_8;
    REG(SPI, SPI_CONTROL) = SPI_ON;
}

void hal_init(void)
{
    clock_start();
    REG(SYSTEM, SYSTEM_ON_0) |= ON_0_WATCHDOG;
    REG(SYSTEM, SYSTEM_ON_1) |= ON_1_UARTS_SPI_I2C;
    REG(SYSTEM, SYSTEM_ON_2) |= ON_2_PORTS;
    (void)REG(SYSTEM, SYSTEM_ON_2); /* a port answers some clocks after it is switched on */
    pins_of_chip(PORT_A, PORT_A_CHIP);
    pins_of_chip(PORT_B, PORT_B_I2C);
    REG(PORT_B, PORT_DRAIN) |= PORT_B_I2C;
    REG(PORT_B, PORT_PULL_UP) |= PORT_B_I2C;
    pins_of_chip(PORT_D, PORT_D_UART1);
    uart_init(UART0, BOARD_LOG_BAUD);
    uart_init(UART1, BOARD_BUS_BAUD);
    spi_init();
    REG(I2C, I2C_CONFIG) = I2C_MASTER;
    REG(I2C, I2C_PERIOD) = I2C_PERIODS;
    REG(SYSTICK, SYSTICK_RELOAD) = SYSTICK_MAX;
    REG(SYSTICK, SYSTICK_VALUE) = 0;
    REG(SYSTICK, SYSTICK_CONTROL) = SYSTICK_ON;
    ticks_seen = REG(SYSTICK, SYSTICK_VALUE);
}

uint32_t hal_time_us(void)
{
    uint32_t count = REG(SYSTICK, SYSTICK_VALUE); /* downwards */
    ticks_left += (ticks_seen - count) & SYSTICK_MAX;
    ticks_seen = count;
    time_us += ticks_left / SYSTICK_US;
    ticks_left %= SYSTICK_US;
    return time_us;
}

/* Once armed, by the first frame, the watchdog's control cannot be changed: hal_stop takes its
 * clock. */
void hal_wait_until(uint32_t until_us)
{
    REG(WATCHDOG, WATCHDOG_LOCK) = WATCHDOG_KEY;
    REG(WATCHDOG, WATCHDOG_LOAD) = BOARD_CLOCK_HZ; /* 1 s to the first of two timeouts */
    REG(WATCHDOG, WATCHDOG_CONTROL) = WATCHDOG_RESET_ON;
    REG(WATCHDOG, WATCHDOG_CLEAR) = 1;
    while ((int32_t)(until_us - hal_time_us()) > 0) {
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
    while (count < size && !(REG(UART1, UART_STATE) & UART_RX_EMPTY)) {
        bytes[count++] = (uint8_t)REG(UART1, UART_DATA);
    }
    return count;
}

/* Starts one step of the I2C and waits for it: 0, or -1 on an error or when it does not end. */
static int i2c_step(uint32_t control)
{
    uint32_t from = hal_time_us();
    REG(I2C, I2C_CONTROL) = control;
    while (REG(I2C, I2C_CONTROL) & I2C_BUSY) {
        if (hal_time_us() - from > I2C_WAIT_US) {
            return -1;
        }
    }
    return REG(I2C, I2C_CONTROL) & I2C_ERROR ? -1 : 0;
}

int hal_i2c_write(uint8_t address, const uint8_t *bytes, uint16_t count)
{
    uint32_t start = I2C_START;
    REG(I2C, I2C_ADDRESS) = (uint32_t)address << 1;
    while (count--) {
        REG(I2C, I2C_DATA) = *bytes++;
        if (i2c_step(I2C_RUN | start | (count ? 0 : I2C_STOP)) < 0) {
            i2c_step(I2C_STOP);
            return -1;
        }
        start = 0;
    }
    return 0;
}

void hal_spi_write(uint8_t dc, const uint8_t *bytes, uint16_t count)
{
    pin_write(BOARD_SPI_DC_PORT, BOARD_SPI_DC_PIN, dc != 0);
    pin_write(BOARD_SPI_CS_PORT, BOARD_SPI_CS_PIN, BOARD_SPI_SELECTED);
    while (count--) {
        while (!(REG(SPI, SPI_STATE) & SPI_TX_ROOM)) { /* at most one byte time */
        }
        REG(SPI, SPI_DATA) = *bytes++;
        while (REG(SPI, SPI_STATE) & SPI_RX_SOME) { /* at most the eight that it holds */
            (void)REG(SPI, SPI_DATA);
        }
    }
    while (REG(SPI, SPI_STATE) & SPI_BUSY) { /* at most eight byte times */
    }
    pin_write(BOARD_SPI_CS_PORT, BOARD_SPI_CS_PIN, !BOARD_SPI_SELECTED);
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
    REG(SYSTEM, SYSTEM_ON_0) &= ~ON_0_WATCHDOG;
    semihost_stop(code);
    for (;;) {
        bare_sleep();
    }
}
