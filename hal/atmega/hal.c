/* ATmega with two USARTs (1280, 2560, 1284P, 328PB): USART0 is the log, USART1 the bus, Timer1 the
 * clock, TWI the I2C, SPI; all polled except for the timer's overflow.
 * The receiver holds two bytes: hal_bus_read must keep up with it.
 * Source: Microchip ATmega640/1280/1281/2560/2561 data sheet 2549Q.
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "board.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#define UART_DIVISOR(baud) ((BOARD_CLOCK_HZ / 8u + (baud) / 2u) / (baud)-1u)
#define TIMER_MHZ          2u /* clk / 8 */
#define TIMER_WRAP_US      (65536u / TIMER_MHZ)
#define TWI_TRIES                                                                                  \
    1000u /* polls of >= 8 cycles each, 0.5 ms or more: a byte at 400 kHz takes 23 us */

#if BOARD_CLOCK_HZ != 16000000
#error "Timer1's clk/8 is 2 MHz at 16 MHz only: choose another divisor in hal_init"
#endif

static volatile uint32_t overflow_us; /* time when Timer1 was last 0 */

ISR(TIMER1_OVF_vect)
{
    overflow_us += TIMER_WRAP_US;
}

void hal_init(void)
{
    wdt_disable();
    UCSR0A = 1 << U2X0;
    UBRR0 = UART_DIVISOR(BOARD_LOG_BAUD);
    UCSR0B = 1 << TXEN0;
    UCSR1A = 1 << U2X1;
    UBRR1 = UART_DIVISOR(BOARD_BUS_BAUD);
    UCSR1B = (1 << TXEN1) | (1 << RXEN1); /* 8N1 is the reset value of UCSR1C */
    TWBR = (BOARD_CLOCK_HZ / 400000u - 16u) / 2u;
    BOARD_SPI_PORT = BOARD_SPI_SELECTED ? 0 : 1 << BOARD_SPI_CS;
    BOARD_SPI_OUT = (1 << BOARD_SPI_CS) | (1 << BOARD_SPI_SCK) | (1 << BOARD_SPI_MOSI);
    BOARD_SPI_DC_OUT |= 1 << BOARD_SPI_DC;
    SPCR = (1 << SPE) | (1 << MSTR); /* mode 0, clk / 4 */
    TCCR1B = 1 << CS11;
    TIMSK1 = 1 << TOIE1;
    sei();
}

/* An overflow that happens with interrupts off is still pending in TOV1; a count below half then
 * belongs after it. */
uint32_t hal_time_us(void)
{
    uint8_t flags = SREG;
    cli();
    uint16_t count = TCNT1;
    uint32_t time_us = overflow_us;
    if ((TIFR1 & (1 << TOV1)) && count < 0x8000u) {
        time_us += TIMER_WRAP_US;
    }
    SREG = flags;
    return time_us + count / TIMER_MHZ;
}

void hal_wait_until(uint32_t time_us)
{
    wdt_enable(WDTO_2S); /* armed by the first frame: a program without one is not watched */
    wdt_reset();
    while ((int32_t)(time_us - hal_time_us()) > 0) {
    }
}

void hal_bus_write(const uint8_t *bytes, uint16_t count)
{
    while (count--) {
        while (!(UCSR1A & (1 << UDRE1))) { /* at most one byte time */
        }
        UDR1 = *bytes++;
    }
}

uint16_t hal_bus_read(uint8_t *bytes, uint16_t size)
{
    uint16_t count = 0;
    while (count < size && (UCSR1A & (1 << RXC1))) {
        bytes[count++] = UDR1;
    }
    return count;
}

/* Starts one step of the TWI and waits for it: its status code, or 0 when it does not end. */
static uint8_t twi_step(uint8_t control)
{
    TWCR = (uint8_t)((1 << TWINT) | (1 << TWEN) | control);
    for (uint16_t tries = TWI_TRIES; tries; tries--) {
        if (TWCR & (1 << TWINT)) {
            return TWSR & 0xf8;
        }
    }
    return 0;
}

static uint8_t twi_byte(uint8_t byte)
{
    TWDR = byte;
    return twi_step(0);
}

#define TWI_STARTED       0x08
#define TWI_ADDRESS_ACKED 0x18
#define TWI_DATA_ACKED    0x28

int hal_i2c_write(uint8_t address, const uint8_t *bytes, uint16_t count)
{
    int answer = -1;
    if (twi_step(1 << TWSTA) == TWI_STARTED &&
        twi_byte((uint8_t)(address << 1)) == TWI_ADDRESS_ACKED) {
        answer = 0;
        while (answer == 0 && count--) {
            answer = twi_byte(*bytes++) == TWI_DATA_ACKED ? 0 : -1;
        }
    }
    TWCR = (1 << TWINT) | (1 << TWEN) | (1 << TWSTO);
    for (uint16_t tries = TWI_TRIES; tries && (TWCR & (1 << TWSTO)); tries--) {
    }
    return answer;
}

static void spi_select(uint8_t selected)
{
    if (selected == BOARD_SPI_SELECTED) {
        BOARD_SPI_PORT &= (uint8_t) ~(1 << BOARD_SPI_CS);
    } else {
        BOARD_SPI_PORT |= 1 << BOARD_SPI_CS;
    }
}

void hal_spi_write(uint8_t dc, const uint8_t *bytes, uint16_t count)
{
    if (dc) {
        BOARD_SPI_DC_PORT |= 1 << BOARD_SPI_DC;
    } else {
        BOARD_SPI_DC_PORT &= (uint8_t) ~(1 << BOARD_SPI_DC);
    }
    spi_select(1);
    while (count--) {
        SPDR = *bytes++;
        while (!(SPSR & (1 << SPIF))) { /* 32 cycles */
        }
    }
    spi_select(0);
}

static void log_byte(char byte)
{
    while (!(UCSR0A & (1 << UDRE0))) { /* at most one byte time */
    }
    UDR0 = (uint8_t)byte;
}

void hal_log(const char *text)
{
    while (*text) {
        log_byte(*text++);
    }
    log_byte('\n');
}

/* Ten byte times at 9600 baud let both lines run dry; an emulator ends at a sleep with interrupts
 * off and takes the code from GPIOR0. */
void hal_stop(int code)
{
    uint32_t dry_us = hal_time_us() + 10000u;
    while ((int32_t)(dry_us - hal_time_us()) > 0) {
    }
    cli();
    wdt_disable();
    GPIOR0 = (uint8_t)code;
    for (;;) {
        sleep_mode();
    }
}
