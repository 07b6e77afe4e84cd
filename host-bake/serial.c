/* A serial line of the host.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "serial.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
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

int serial_file(const char *path, bake_error *error)
{
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    return file < 0 ? bake_fail(error, "%s: %s", path, strerror(errno)) : file;
}

/* Closes a line that cannot be used. */
static int refuse(int line, const char *path, const char *why, bake_error *error)
{
    close(line);
    return bake_fail(error, "%s: %s", path, why);
}

int serial_open(const char *path, long baud, bake_error *error)
{
    speed_t speed = speed_of(baud);
    struct stat what;
    if (speed == B0) {
        return bake_fail(error,
                         "--baud %ld: this machine has 9600, 19200, 38400, 57600, 115200, "
                         "230400, 500000 and 1000000",
                         baud);
    }
    if (stat(path, &what) == 0 && !S_ISCHR(what.st_mode) && !S_ISFIFO(what.st_mode)) {
        return bake_fail(error, "%s: not a serial line; --bus writes the frames to a file", path);
    }
    int line = open(path, O_WRONLY | O_NOCTTY);
    if (line < 0) {
        return bake_fail(error, "%s: %s; ls /dev/tty* shows the lines there are", path,
                         strerror(errno));
    }
    if (isatty(line) && make_raw(line, speed) < 0) {
        return refuse(line, path, "it cannot be set to that baud rate", error);
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
