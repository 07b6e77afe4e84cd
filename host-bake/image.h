/* Pictures in memory, 8 bits a colour, and on disk as PNG.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_IMAGE_H
#define BAKE_IMAGE_H

#include "bake.h"

#include <stdint.h>

typedef struct {
    int width, height;
    uint8_t *rgb; /* 3 bytes a pixel, row by row from the top; owned */
} image;

typedef struct {
    uint8_t red, green, blue;
} rgb;

/* Black. Both sizes at least 1. */
image image_make(int width, int height);
void image_free(image *m);

/* What lies outside the image is left out. */
void image_fill(image *m, int x, int y, int width, int height, rgb colour);
/* `from` with every pixel as a square of scale x scale, its corner at (x, y). */
void image_copy(image *m, int x, int y, const image *from, int scale);

/* Letters of 3 x 5 pixels each 2 x 2, capitals whatever the text says; what has no letter here is a
 * gap. A character is 8 wide with its gap, a line IMAGE_TEXT_HEIGHT high. */
#define IMAGE_TEXT_WIDTH  8
#define IMAGE_TEXT_HEIGHT 10
void image_text(image *m, int x, int y, const char *text, rgb colour);

/* Whole or not at all, as file_replace. */
int image_write_png(const image *m, const char *path, bake_error *error);

#endif
