/* Fuzzing without libFuzzer: every file named on the command line as it is, then `rounds` mutations
 * of them, the same ones at every run.
 *   replay rounds file...
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "exercise.h"

#define FILES_MAX 256

typedef struct {
    uint8_t *at;
    uint32_t size;
} input;

static input inputs[FILES_MAX];
static unsigned input_count;
static uint32_t seed = 20;

static uint32_t rnd(uint32_t below)
{
    return (uint32_t)((uint64_t)exercise_next(&seed) * below >> 24);
}

static void load(const char *path)
{
    FILE *f = fopen(path, "rb");
    uint8_t *at = malloc(EXERCISE_MAX);
    if (!f || !at || input_count == FILES_MAX) {
        fprintf(stderr, "cannot read %s\n", path);
        exit(2);
    }
    inputs[input_count].at = at;
    inputs[input_count++].size = (uint32_t)fread(at, 1, EXERCISE_MAX, f);
    fclose(f);
}

/* A value that tends to matter: a limit, a neighbour of what is there, or something from elsewhere
 * in the file. */
static uint32_t tempting(const uint8_t *bytes, uint32_t size, uint32_t old)
{
    static const uint32_t FIXED[] = {
        0,      1,      2,          255,        254,      256,        0x7fff,     0x8000,
        0xffff, 0xfffe, 0x10000000, 0xf0000000, 1u << 31, 0x7fffffff, 0xffffffff, 0xfffffffc};
    switch (rnd(4)) {
    case 0:
        return FIXED[rnd(16)];
    case 1:
        return old + (rnd(2) ? 1u + rnd(4) : 0u - (1u + rnd(4)));
    case 2:
        return build_get(bytes + rnd(size - 4u), 4);
    default:
        return exercise_number(&seed);
    }
}

/* One field, aligned as fields are, or a block moved, or the end cut off. */
static uint32_t mutate(uint8_t *bytes, uint32_t size)
{
    uint32_t width = 1u << rnd(3), at = rnd(size - 4u) & ~(width - 1u);
    switch (rnd(12)) {
    case 0: {
        uint32_t length = 1u + rnd(24), from = rnd(size), to = rnd(size);
        uint32_t room = size - (from > to ? from : to);
        memmove(bytes + to, bytes + from, length < room ? length : room);
        return size;
    }
    case 1:
        return size > 200 ? size - rnd(size / 8u) : size;
    default:
        build_put(bytes + at, width, tempting(bytes, size, build_get(bytes + at, width)));
        return size;
    }
}

int main(int argc, char **argv)
{
    static uint8_t bytes[EXERCISE_MAX];
    unsigned opened = 0, rounds = argc > 1 ? (unsigned)strtoul(argv[1], NULL, 10) : 0;
    for (int i = 2; i < argc; i++) {
        load(argv[i]);
        exercise(inputs[input_count - 1u].at, inputs[input_count - 1u].size);
    }
    for (unsigned n = 0; n < rounds && input_count > 0; n++) {
        const input *in = &inputs[rnd(input_count)];
        uint32_t size = in->size;
        if (size < 64) {
            continue;
        }
        memcpy(bytes, in->at, size);
        for (unsigned changes = 1u + rnd(3); changes > 0; changes--) {
            size = mutate(bytes, size);
        }
        opened += exercise(bytes, size) == 0;
    }
    printf("%u files, %u mutations, %u of them opened\n", input_count, rounds, opened);
    for (unsigned i = 0; i < input_count; i++) {
        free(inputs[i].at);
    }
    /* Mutations that never open would test nothing behind wg_open. */
    return input_count == 0 || (rounds >= 1000 && opened < rounds / 20u);
}
