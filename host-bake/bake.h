/* What the stages of the baker share: one error type and the exact curves they pass along.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_H
#define BAKE_H

#include <stddef.h>

/* A message for the person at the keyboard: file and line where there is one, what was expected,
 * what to do. Every stage returns 0, or -1 with `text` filled. */
typedef struct {
    char text[1024];
} bake_error;

/* Formats the message and returns -1, so that a stage can `return bake_fail(...)`. */
int bake_fail(bake_error *error, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* calloc that ends the program with a message: the baker runs on a PC and has no plan B. */
void *bake_alloc(size_t count, size_t size);
void *bake_grow(void *old, size_t count, size_t size);
char *bake_copy(const char *text);

#endif
