/* What all parts of exercise.h need: promises, and numbers that look random.
 * SPDX-License-Identifier: MIT */
#ifndef EXERCISE_BASE_H
#define EXERCISE_BASE_H

#include "../clip_build.h"

static void must(int cond)
{
    if (!cond) {
        abort();
    }
}

static uint32_t exercise_next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Small, huge and in between. */
static uint32_t exercise_number(uint32_t *state)
{
    uint32_t n = exercise_next(state) << 8 ^ exercise_next(state);
    return n >> (exercise_next(state) & 31u);
}

#endif
