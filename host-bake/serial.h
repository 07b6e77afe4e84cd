/* A serial line of the host, raw and at a baud rate.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SERIAL_H
#define BAKE_SERIAL_H

#include "bake.h"

/* Opens a serial device, a pty, a pipe or a file for writing; *paced = 1 for a terminal line, whose
 * other end expects frames in real time. Returns a descriptor, or -1 with a message. */
int serial_open(const char *path, long baud, int *paced, bake_error *error);
int serial_write(int line, const void *data, size_t count, bake_error *error);

/* Waits until everything has left. */
void serial_close(int line);

#endif
