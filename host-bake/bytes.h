/* A growing little-endian byte buffer.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BYTES_H
#define BAKE_BYTES_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    uint8_t *at;
    size_t count, size;
} bytes;

void put8(bytes *b, uint32_t value);
void put16(bytes *b, uint32_t value);
void put32(bytes *b, uint32_t value);
void put_copy(bytes *b, const void *from, size_t count);

/* printf, at most 511 characters a call. */
void put_text(bytes *b, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* Zero bytes until count is a multiple of `unit`. */
void put_align(bytes *b, size_t unit);
void bytes_free(bytes *b);

#endif
