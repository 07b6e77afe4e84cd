/* Machines without an operating system or a C library: registers, start, semihosting.
 * SPDX-License-Identifier: MIT */
#ifndef BARE_H
#define BARE_H

#include <stdint.h>

#define REG(base, offset) (*(volatile uint32_t *)(uintptr_t)((base) + (offset)))

/* From the reset code, with a stack and nothing else: sets up RAM, runs main, stops. */
void bare_start(void);

/* One call to the debugger or emulator. Each architecture implements it, and its fault handler
 * answers -1 when nobody is listening, so that an image that logs this way runs without a debugger.
 */
int32_t semihost(int32_t operation, const void *argument);

/* Sleeps until something happens or not at all: only ever called in a loop. */
void bare_sleep(void);

/* A line on the debugger's console. */
void semihost_log(const char *text);

/* Ends the emulator with `code`, or returns when there is no debugger. */
void semihost_stop(int code);

/* The code of a program that ended in a fault. */
#define BARE_FAULT 99

#endif
