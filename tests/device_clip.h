/* What the tests of the servo protocols share: a clip of servos that stand still, and the packets
 * of tests/vectors/servo_frames.csv.
 * SPDX-License-Identifier: MIT */
#ifndef DEVICE_CLIP_H
#define DEVICE_CLIP_H

#include "bus.h"
#include "check.h"

#include <stdlib.h>
#include <string.h>

#define VECTORS        "tests/vectors/servo_frames.csv"
#define NO_SUCH_VECTOR (-1000)

/* ---- a clip with servos at fixed positions --------------------------------------------------- */

#define SERVOS 64
static uint32_t records[SERVOS * WG_SERVO_BYTES / 4];
static wg_file file;
static wg_servo servos[SERVOS];

static inline void clip_clear(void)
{
    memset(records, 0, sizeof records);
    file.section[WG_SECTION_SERVOS].at = (const uint8_t *)records;
    file.section[WG_SECTION_SERVOS].count = 0;
}

/* Adds a servo that stands at `position`; 0 = off. */
static inline void clip_servo(uint8_t protocol, uint8_t id, int16_t position)
{
    uint16_t i = file.section[WG_SECTION_SERVOS].count++;
    uint8_t *r = (uint8_t *)records + i * WG_SERVO_BYTES;

    r[WG_SERVO_PROTOCOL] = protocol;
    r[WG_SERVO_ID] = id;
    if (position) {
        wg_servo_start(servos, (uint8_t)i, position);
    } else {
        wg_servo_off(servos, (uint8_t)i);
    }
}

/* "AA 0C 04" into bytes; stops at the first thing that is none. */
static int parse_hex(const char *text, uint8_t *out, int size)
{
    int n = 0;
    char *end;

    for (; n < size; text = end) {
        unsigned long byte = strtoul(text, &end, 16);
        if (end == text) {
            break;
        }
        out[n++] = (uint8_t)byte;
    }
    return n;
}

/* Calls `one` for every vector whose name starts with `prefix`; returns how many there were. */
static inline int each_vector(const char *prefix,
                              void (*one)(const char *name, const uint8_t *want, int count))
{
    FILE *in = fopen(VECTORS, "r");
    char line[512];
    int rows = 0;

    CHECK(in != NULL);
    while (in && fgets(line, sizeof line, in)) {
        uint8_t want[64];
        char *hex = strchr(line, ',');
        if (line[0] == '#' || !hex || strncmp(line, prefix, strlen(prefix)) != 0) {
            continue;
        }
        *hex = 0;
        hex = strchr(hex + 1, ',');
        CHECK(hex != NULL);
        if (hex) {
            one(line, want, parse_hex(hex + 1, want, sizeof want));
            rows++;
        }
    }
    if (in) {
        fclose(in);
    }
    return rows;
}

static inline void compare(const char *name, int got, const uint8_t *out, const uint8_t *want,
                           int count)
{
    CHECK_EQ(got, count);
    CHECK(memcmp(out, want, (size_t)count) == 0);
    if (!check_ok) {
        printf("in %s\n", name);
    }
}

/* Every length too short for the frame must be refused, and nothing written behind it: the buffer
 * has exactly that length on the heap, for the address sanitizer, and a canary without it. */
static inline void check_shorter(int (*build)(const char *, uint8_t *, uint16_t), const char *name,
                                 int count)
{
    for (int size = 0; size < count; size++) {
        uint8_t *out = malloc((size_t)size + 1);
        uint8_t canary = (uint8_t)(0xa5 ^ size);
        out[size] = canary;
        CHECK_EQ(build(name, out, (uint16_t)size), WG_ERR_SPACE);
        CHECK_EQ(out[size], canary);
        free(out);
    }
}

#endif
