/* Pictures and drawings as pixels.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BITMAP_H
#define BAKE_BITMAP_H

#include "bake.h"

#include <stdint.h>

#define PIXELS_MAX 4096 /* a side */

/* The upper row first; colours are not multiplied by alpha. */
typedef struct {
    int width, height;
    uint8_t *rgba; /* 4 bytes a pixel; owned */
    double unit;   /* units of the file a pixel: 1; drawings are drawn larger */
} pixels;

/* Readers for damaged files too (in a process of its own: isolate.h). error: the end of a sentence
 * that begins with the file's name. */
int pixels_read_png(const char *path, pixels *out, bake_error *error);
int pixels_read_svg(const char *path, pixels *out, bake_error *error);
void pixels_free(pixels *p);

/* The colour that covers most. */
void pixels_main_colour(const pixels *p, unsigned char colour[3]);

#endif
