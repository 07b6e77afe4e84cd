/* Between the files of the certificate.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_CERTIFY_PARTS_H
#define BAKE_CERTIFY_PARTS_H

#include "certify.h"

#define CERTIFY_FRAME_US 20000u

/* Frames that follow the seam of a motion that repeats: a jerk is seen in four. */
#define CERTIFY_SEAM_FRAMES 4u

/* The last four positions of a servo, newest last; `known` of them are there. */
typedef struct {
    double position[4];
    int known;
} servo_watch;

/* How long the motion goes before it repeats or rests [us]: ping-pong lasts twice its clip. */
uint64_t certify_period(const wg_file *file, int clip);
int certify_repeats(const wg_file *file, int clip);

/* A row is begun, sees every frame and is ended, which converts it, with the
 * error its owner has set, from positions to its unit. */
void servo_begin(certificate_servo *row);
void servo_frame(const build *b, const wg_file *file, const int32_t *values, servo_watch *watch,
                 certificate_servo *row);
void servo_end(const build *b, certificate_servo *row);

/* Fills the row of row->servo in row->clip, played alone. */
void certify_servo(const build *b, const wg_file *file, certificate_servo *row);

/* The name of a section of the format, WG_SECTION_*. */
const char *section_name(unsigned kind);

/* RAM of device/raster/picture.h, without pixels. */
size_t certify_picture_ram(const build *b);

/* The parts of the certificate that are about meshes. */
void certificate_print_meshes(const build *b, const certificate *c, FILE *to);
void certificate_print_target(const build *b, const certificate *c, FILE *to);
void certificate_print_mesh_failures(const build *b, const certificate *c, FILE *to);
void certificate_json_meshes(const build *b, const certificate *c, bytes *out);
void certificate_print_bodies(const build *b, FILE *to);
/* Of rigs: how many fields miss their channels' tolerances. */
int certify_skins(const build *b);
void certificate_print_skins(const build *b, FILE *to);
void certificate_print_skin_failures(const build *b, FILE *to);
void certificate_json_skins(const build *b, bytes *out);
void certificate_json_bodies(const build *b, bytes *out);

/* "key": "name", and a comma; names may hold anything. */
void json_name(bytes *out, const char *key, const char *name);

/* Appends the rows of the start-up mix. */
void certify_mix(const build *b, const wg_file *file, certificate *c);

#endif
