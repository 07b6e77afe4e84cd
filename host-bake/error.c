/* The error message every stage fills, and allocation that cannot fail.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bake.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int bake_fail(bake_error *error, const char *format, ...)
{
    if (error) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(error->text, sizeof error->text, format, arguments);
        va_end(arguments);
    }
    return -1;
}

static void *checked(void *memory, size_t count, size_t size)
{
    if (memory)
        return memory;
    fprintf(stderr, "out of memory: %zu items of %zu bytes\n", count, size);
    exit(EXIT_FAILURE);
}

void *bake_alloc(size_t count, size_t size)
{
    return checked(calloc(count ? count : 1, size ? size : 1), count, size);
}

void *bake_grow(void *old, size_t count, size_t size)
{
    if (size && count > SIZE_MAX / size)
        return checked(NULL, count, size);
    return checked(realloc(old, count && size ? count * size : 1), count, size);
}

char *bake_copy(const char *text)
{
    size_t bytes = strlen(text) + 1;
    return memcpy(bake_alloc(bytes, 1), text, bytes);
}
