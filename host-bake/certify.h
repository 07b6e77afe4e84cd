/* The certificate: what the finished file plays, measured against what was authored.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_CERTIFY_H
#define BAKE_CERTIFY_H

#include "build.h"
#include "certify_shapes.h"

#include <stdio.h>

/* `clip` of a row that is about the clip file's start-up mix: all layers and filters together. */
#define CERTIFY_MIX (-1)

/* One channel of one clip, or of the mix, in the channel's unit. */
typedef struct {
    int clip, curve, channel;
    double largest, when, rms; /* |played - authored|, the time of the largest [s] */
    double tolerance, range;
    int runs, segments, waves; /* waves: segments played as exact wiggly pieces */
} certificate_channel;

/* One servo in one clip or in the mix, from played frames of 20 ms: microseconds, or steps for
 * Dynamixel. Positions are what the channel asks for, before end stops and limiter; a looping or
 * ping-pong clip is followed over its seam. */
typedef struct {
    int clip, servo;
    double error;                        /* largest of its channel, at the servo */
    double low, high;                    /* positions before the end stops */
    double velocity, acceleration, jerk; /* peaks, per s, s^2, s^3 */
    int clipped;                         /* frames beyond min, max */
    int limited;                         /* frames beyond the velocity or acceleration limit */
} certificate_servo;

typedef struct {
    int channel_count, servo_count, mesh_count;
    certificate_channel *channel;
    certificate_servo *servo;
    certificate_mesh *mesh;
    size_t file_bytes, section_bytes[WG_SECTION_KNOWN + 1];
    double mix_seconds;       /* how long the mix was played; 0: the file has no layers */
    double mix_compared;      /* how long it was compared: until the first trigger fired */
    size_t ram_bytes;         /* of a 32-bit player: file, player, layers, values, servo states */
    size_t picture_ram;       /* of device/raster/picture.h, without pixels; 0: no meshes */
    int over_flash, over_ram; /* more than the scene's target has */
    int search_rounds;   /* halvings while seeking runs and segments, of the clip that needs most */
    int multiplications; /* 32 x 32 -> 64 */
    int divisions;       /* 32 / 16 */
    int failed;          /* rows of channels and meshes over their tolerance, targets exceeded */
} certificate;

/* Replays `file`, opened from b->file or from disk; it must have the scene's clips and channels. */
int certify(const build *b, const wg_file *file, size_t file_bytes, certificate *out,
            bake_error *error);
void certificate_free(certificate *c);
void certificate_print(const build *b, const certificate *c, FILE *to);
void certificate_json(const build *b, const certificate *c, bytes *out);

/* One line for each loop that does not meet at its seam and for each servo that is asked for more
 * than it may do, with what to do about it. */
void certificate_warn(const build *b, const certificate *c, FILE *to);

/* The clip a row is about: its name, or "(mix)". */
const char *certificate_clip(const build *b, int clip);

/* Quarter microseconds print as us, turn/4096 as steps. */
const char *servo_unit(int protocol);
double servo_scale(int protocol);

/* "deg", "us", "mm", or "" for WG_UNIT_NONE and units this version does not know. */
const char *unit_name(int unit);

#endif
