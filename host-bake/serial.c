/* A serial line of the host.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "serial.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

static speed_t speed_of(long baud)
{
    static const struct {
        long baud;
        speed_t speed;
    } table[] = {
        {9600, B9600}, {19200, B19200}, {38400, B38400}, {57600, B57600}, {115200, B115200}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        if (table[i].baud == baud) {
            return table[i].speed;
        }
    }
#ifdef B1000000
    return baud == 230400 ? B230400 : baud == 500000 ? B500000 : baud == 1000000 ? B1000000 : B0;
#else
    return B0;
#endif
}

/* 8 bits, no parity, one stop bit, nothing translated. */
static int make_raw(int line, speed_t speed)
{
    struct termios t;
    if (tcgetattr(line, &t) < 0) {
        return -1;
    }
    t.c_iflag = 0;
    t.c_oflag = 0;
    t.c_lflag = 0;
    t.c_cflag = CS8 | CREAD | CLOCAL;
    cfsetispeed(&t, speed);
    cfsetospeed(&t, speed);
    return tcsetattr(line, TCSANOW, &t);
}

int serial_open(const char *path, long baud, int *paced, bake_error *error)
{
    speed_t speed = speed_of(baud);
    if (speed == B0) {
        return bake_fail(error,
                         "--baud %ld: this machine has 9600, 19200, 38400, 57600, 115200, "
                         "230400, 500000 and 1000000",
                         baud);
    }
    int line = open(path, O_WRONLY | O_CREAT | O_NOCTTY, 0644);
    if (line < 0) {
        return bake_fail(error, "%s: %s", path, strerror(errno));
    }
    *paced = isatty(line);
    if (*paced && make_raw(line, speed) < 0) {
        bake_fail(error, "%s: cannot be set to %ld baud: %s", path, baud, strerror(errno));
        close(line);
        return -1;
    }
    if (!*paced && ftruncate(line, 0) < 0 && errno != EINVAL) { /* pipes have no length */
        bake_fail(error, "%s: %s", path, strerror(errno));
        close(line);
        return -1;
    }
    return line;
}

int serial_write(int line, const void *data, size_t count, bake_error *error)
{
    const char *at = data;
    while (count > 0) { /* each round writes at least a byte or fails */
        ssize_t n = write(line, at, count);
        if (n < 0 && errno != EINTR) {
            return bake_fail(error, "the serial line failed: %s", strerror(errno));
        }
        at += n > 0 ? n : 0;
        count -= n > 0 ? (size_t)n : 0;
    }
    return 0;
}

void serial_close(int line)
{
    if (isatty(line)) {
        tcdrain(line);
    }
    close(line);
}
