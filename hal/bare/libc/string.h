/* The part of string.h that mem.c implements, for compilers that come without a C library: such a
 * board puts this directory on its include path.
 * SPDX-License-Identifier: MIT */
#ifndef BARE_STRING_H
#define BARE_STRING_H

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t count);
void *memmove(void *to, const void *from, size_t count);
void *memset(void *to, int value, size_t count);
int memcmp(const void *a, const void *b, size_t count);

#endif
