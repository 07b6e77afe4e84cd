/* The host: a log on stdout, a servo bus that is a file, a pseudo-terminal or a real serial port.
 *   WIGGLY_BUS  /dev/ttyUSB0, a pty or a file, with :BAUD for a port that has one (default 57600);
 *               unset: the bytes go nowhere
 *   WIGGLY_LOG  a file instead of stdout
 *   WIGGLY_FAST set: time jumps instead of passing, to make a file quickly; each look at the clock
 *               takes 1 us and computing takes none, so that every run is the same
 *   WIGGLY_WIRE a file that gets what is written on I2C and SPI, a line a transfer in hexadecimal
 *               digits: "i2c 3d 80ae", "spi 0 15003f" (with the level of the data/command line)
 * I2C has no bus here: it answers -1 unless WIGGLY_WIRE is set.
 * Source: POSIX.1-2008 termios; CRTSCTS and baud rates above 38400 are common extensions.
 * SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE /* cfmakeraw, B57600 and above */
#include "hal.h"
#include "board.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static int bus = -1;
static FILE *log_file, *wire;
static int fast;
static uint64_t start_us;
static uint64_t fast_us; /* the time when WIGGLY_FAST is set */

static const struct {
    long baud;
    speed_t speed;
} SPEEDS[] = {
    {9600, B9600},     {19200, B19200},     {38400, B38400},
    {57600, B57600},   {115200, B115200},   {230400, B230400},
    {500000, B500000}, {1000000, B1000000}, {2000000, B2000000},
};

static void die(const char *what, const char *name)
{
    fprintf(stderr, "%s %s: %s\n", what, name, strerror(errno));
    exit(2);
}

static void bus_speed(long baud, const char *name)
{
    struct termios line;
    if (tcgetattr(bus, &line) < 0) {
        die("cannot set up", name);
    }
    cfmakeraw(&line); /* no echo, no newline translation: the bus carries every byte value */
    line.c_cflag |= CLOCAL | CREAD;
    line.c_cflag &= ~(tcflag_t)(CRTSCTS | CSTOPB);
    for (size_t i = 0; i < sizeof SPEEDS / sizeof SPEEDS[0]; i++) {
        if (SPEEDS[i].baud == baud) {
            cfsetspeed(&line, SPEEDS[i].speed);
            if (tcsetattr(bus, TCSANOW, &line) < 0) {
                die("cannot set up", name);
            }
            return;
        }
    }
    fprintf(stderr, "%s: no baud rate %ld\n", name, baud);
    exit(2);
}

static void bus_open(const char *path_and_baud)
{
    char *path = strdup(path_and_baud);
    long baud = BOARD_BUS_BAUD;
    char *colon = path ? strrchr(path, ':') : NULL;
    if (!path) {
        die("cannot open", path_and_baud);
    }
    if (colon && strspn(colon + 1, "0123456789") == strlen(colon + 1)) {
        baud = strtol(colon + 1, NULL, 10);
        *colon = 0;
    }
    bus = open(path, O_RDWR | O_CREAT | O_NOCTTY, 0644);
    if (bus < 0) {
        die("cannot open", path);
    }
    if (isatty(bus)) {
        bus_speed(baud, path);
    } else if (ftruncate(bus, 0) < 0 && errno != EINVAL) { /* a pipe or device has no length */
        die("cannot empty", path);
    }
    free(path);
}

static uint64_t clock_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

void hal_init(void)
{
    const char *path = getenv("WIGGLY_BUS");
    const char *log_path = getenv("WIGGLY_LOG");
    if (path && *path) {
        bus_open(path);
    }
    log_file = log_path && *log_path ? fopen(log_path, "w") : stdout;
    if (!log_file) {
        die("cannot open", log_path);
    }
    const char *wire_path = getenv("WIGGLY_WIRE");
    if (wire_path && !(wire = fopen(wire_path, "w"))) {
        die("cannot open", wire_path);
    }
    fast = getenv("WIGGLY_FAST") != NULL;
    start_us = clock_us();
}

uint32_t hal_time_us(void)
{
    return (uint32_t)(fast ? fast_us++ : clock_us() - start_us);
}

void hal_wait_until(uint32_t time_us)
{
    int32_t left_us = (int32_t)(time_us - hal_time_us());
    if (left_us <= 0) {
        return;
    }
    if (fast) {
        fast_us += (uint32_t)left_us;
        return;
    }
    struct timespec left = {left_us / 1000000, (long)(left_us % 1000000) * 1000};
    while (nanosleep(&left, &left) < 0 && errno == EINTR) { /* again after a signal, for the rest */
    }
}

void hal_bus_write(const uint8_t *bytes, uint16_t count)
{
    while (bus >= 0 && count > 0) {
        ssize_t written = write(bus, bytes, count);
        if (written < 0 && errno != EINTR) {
            die("cannot write to", "the bus");
        }
        if (written > 0) {
            bytes += written;
            count = (uint16_t)(count - written);
        }
    }
}

uint16_t hal_bus_read(uint8_t *bytes, uint16_t size)
{
    struct pollfd wait = {bus, POLLIN, 0};
    if (bus < 0 || !isatty(bus) || poll(&wait, 1, 0) != 1) {
        return 0; /* a file has only what was written to it */
    }
    ssize_t count = read(bus, bytes, size);
    return count > 0 ? (uint16_t)count : 0;
}

static void wire_write(const char *name, unsigned number, const uint8_t *bytes, uint16_t count)
{
    if (wire) {
        fprintf(wire, "%s %x ", name, number);
        while (count--) {
            fprintf(wire, "%02x", *bytes++);
        }
        fprintf(wire, "\n");
    }
}

int hal_i2c_write(uint8_t address, const uint8_t *bytes, uint16_t count)
{
    wire_write("i2c", address, bytes, count);
    return wire ? 0 : -1;
}

void hal_spi_write(uint8_t dc, const uint8_t *bytes, uint16_t count)
{
    wire_write("spi", dc, bytes, count);
}

void hal_log(const char *text)
{
    fprintf(log_file, "%s\n", text);
    fflush(log_file);
}

void hal_stop(int code)
{
    if (bus >= 0 && isatty(bus)) {
        tcdrain(bus); /* a real port still holds bytes */
    }
    exit(code);
}
