/* The certificate: what the finished file plays, measured against what was authored.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_CERTIFY_H
#define BAKE_CERTIFY_H

#include "build.h"

#include <stdio.h>

/* One channel of one clip, in the channel's unit. */
typedef struct {
    int clip, curve, channel;
    double largest, when, rms; /* |played - authored|, the time of the largest [s] */
    double tolerance, range;
    int runs, segments, waves; /* waves: segments played as exact wiggly pieces */
} certificate_channel;

/* One servo in one clip, from played frames of 20 ms: microseconds, or steps for Dynamixel. */
typedef struct {
    int clip, servo;
    double error;                        /* largest of its channel, at the servo */
    double low, high;                    /* positions before the end stops */
    double velocity, acceleration, jerk; /* peaks, per s, s^2, s^3 */
    int clipped;                         /* frames beyond min, max */
    int limited;                         /* frames beyond the velocity or acceleration limit */
} certificate_servo;

typedef struct {
    int channel_count, servo_count;
    certificate_channel *channel;
    certificate_servo *servo;
    size_t file_bytes, section_bytes[WG_SECTION_KNOWN + 1];
    size_t ram_bytes;    /* of a 32-bit player: file, player, layers, values, servo states */
    int search_rounds;   /* of the clip that needs most, all layers on it: see README */
    int multiplications; /* 32 x 32 -> 64 */
    int divisions;       /* 32 / 16 */
    int failed;          /* channels over their tolerance */
} certificate;

/* Replays `file`, opened from b->file or from disk; it must have the scene's clips and channels. */
int certify(const build *b, const wg_file *file, size_t file_bytes, certificate *out,
            bake_error *error);
void certificate_free(certificate *c);
void certificate_print(const build *b, const certificate *c, FILE *to);
void certificate_json(const build *b, const certificate *c, bytes *out);

/* Quarter microseconds print as us, turn/4096 as steps. */
const char *servo_unit(int protocol);
double servo_scale(int protocol);

#endif
