/* A growing little-endian byte buffer.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bytes.h"
#include "bake.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void put8(bytes *b, uint32_t value)
{
    if (b->count == b->size) {
        b->size = b->size ? 2 * b->size : 256;
        b->at = bake_grow(b->at, b->size, 1);
    }
    b->at[b->count++] = (uint8_t)value;
}

void put16(bytes *b, uint32_t value)
{
    put8(b, value & 255u);
    put8(b, value >> 8 & 255u);
}

void put32(bytes *b, uint32_t value)
{
    put16(b, value & 65535u);
    put16(b, value >> 16);
}

void put_copy(bytes *b, const void *from, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        put8(b, ((const uint8_t *)from)[i]);
    }
}

void put_text(bytes *b, const char *format, ...)
{
    char text[512];
    va_list list;
    va_start(list, format);
    int n = vsnprintf(text, sizeof text, format, list);
    va_end(list);
    put_copy(b, text, n < 0 ? 0 : (size_t)n < sizeof text ? (size_t)n : sizeof text - 1);
}

void put_align(bytes *b, size_t unit)
{
    while (b->count % unit != 0) {
        put8(b, 0);
    }
}

void bytes_free(bytes *b)
{
    free(b->at);
    memset(b, 0, sizeof *b);
}
