/* The commands of `wiggly`, one file each.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_COMMAND_H
#define BAKE_COMMAND_H

#include "bake.h"
#include "wiggly.h"

#include <stdio.h>

/* Exit codes. */
#define EXIT_DONE      0
#define EXIT_FAILED    1 /* an input is wrong, a solve failed, a file cannot be written */
#define EXIT_USAGE     2
#define EXIT_TOLERANCE 3 /* baked, but a channel misses its tolerance */

/* One accepted option: "--png" with or without a value. */
typedef struct {
    const char *name;
    int takes_value;
    const char *value; /* given: the value, or "" without one; else NULL */
} option;

/* What is neither an option nor its value: at most `most` words, which go to `word`. */
typedef struct {
    const char **word;
    int most;
} option_words;

/* Sorts argv into options and words. The number of words, or -1 and a message. */
int options_parse(int argc, char **argv, option *options, option_words words, bake_error *error);
const char *option_value(const option *options, const char *name);
/* A positive number, or `otherwise` without the option; -1 and a message if it is neither. */
double option_number(const option *options, const char *name, double otherwise, bake_error *error);

int command_bake(int argc, char **argv, bake_error *error);
int command_check(int argc, char **argv, bake_error *error);
int command_info(int argc, char **argv, bake_error *error);
int command_play(int argc, char **argv, bake_error *error);
int command_view(int argc, char **argv, bake_error *error);

/* A clip from disk, opened by the player. The words own the bytes. */
typedef struct {
    uint32_t *words;
    size_t size;
    wg_file file;
} clip_disk;

int clip_read(const char *path, clip_disk *out, bake_error *error);
void clip_release(clip_disk *c);

/* What went wrong when wg_open refused a file. */
const char *clip_complaint(int code);

/* Name `index` of its kind in the NAMES section, or "" where there is none. */
typedef enum { NAME_CHANNEL, NAME_CLIP, NAME_SERVO, NAME_LAYER, NAME_EVENT } name_kind;
const char *clip_name(const wg_file *file, name_kind kind, int index);

/* Index of the clip with this name, the first one for NULL, or -1. */
int clip_find(const wg_file *file, const char *name);

double channel_unit(const wg_file *file, int channel, int32_t raw); /* raw to the channel's unit */

/* A table to write: "-" is stdout. NULL, or -1, and a message when the disk refuses. */
FILE *csv_open(const char *path, bake_error *error);
int csv_close(FILE *to, const char *path, bake_error *error);

#endif
