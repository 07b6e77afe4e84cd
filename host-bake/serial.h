/* A serial line of the host, raw and at a baud rate.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SERIAL_H
#define BAKE_SERIAL_H

#include "bake.h"

/* Opens a serial device, a pty or a pipe that is there, raw and at a baud rate. A file is refused: it
 * would be a mistyped device. Returns a descriptor, or -1 with a message. */
int serial_open(const char *path, long baud, bake_error *error);

/* A new or emptied file instead of a line. */
int serial_file(const char *path, bake_error *error);
int serial_write(int line, const void *data, size_t count, bake_error *error);

/* Waits until everything has left. */
void serial_close(int line);

#endif
