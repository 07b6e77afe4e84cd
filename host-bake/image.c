/* Pictures in memory, and on disk as PNG.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "image.h"
#include "build.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

image image_make(int width, int height)
{
    return (image){width, height, bake_alloc((size_t)width * (size_t)height, 3)};
}

void image_free(image *m)
{
    free(m->rgb);
    memset(m, 0, sizeof *m);
}

static int between(int value, int least, int most)
{
    return value < least ? least : value > most ? most : value;
}

static uint8_t *pixel_at(const image *m, int x, int y)
{
    return m->rgb + 3 * ((size_t)y * (size_t)m->width + (size_t)x);
}

void image_fill(image *m, int x, int y, int width, int height, rgb colour)
{
    int x0 = between(x, 0, m->width), x1 = between(x + width, 0, m->width);
    int y0 = between(y, 0, m->height), y1 = between(y + height, 0, m->height);
    for (int j = y0; j < y1; j++) {
        uint8_t *to = pixel_at(m, x0, j);
        for (int i = x0; i < x1; i++, to += 3) {
            to[0] = colour.red;
            to[1] = colour.green;
            to[2] = colour.blue;
        }
    }
}

void image_copy(image *m, int x, int y, const image *from, int scale)
{
    int x0 = between(x, 0, m->width), x1 = between(x + from->width * scale, 0, m->width);
    int y0 = between(y, 0, m->height), y1 = between(y + from->height * scale, 0, m->height);
    for (int j = y0; j < y1; j++) {
        uint8_t *to = pixel_at(m, x0, j);
        for (int i = x0; i < x1; i++, to += 3) {
            memcpy(to, pixel_at(from, (i - x) / scale, (j - y) / scale), 3);
        }
    }
}

/* ---- text ------------------------------------------------------------------------------------ */

/* Five rows of three pixels, the uppermost row in the upper bits: '-' to '9', then 'A' to 'Z'. */
static const uint16_t DIGITS[] = {
    000700, 000002, 011244, 075557, 026227, 071747, 071717, /* - . / 0 1 2 3 */
    055711, 074717, 074757, 071111, 075757, 075717,         /* 4 5 6 7 8 9 */
};
static const uint16_t LETTERS[] = {
    025755, 065656, 034443, 065556, 074647, 074644, 034553, 055755, 072227, /* A to I */
    011152, 055655, 044447, 057755, 065555, 025552, 065644, 025563, 065655, /* J to R */
    034216, 072222, 055557, 055552, 055775, 055255, 055222, 071247,         /* S to Z */
};

static uint16_t glyph(char c)
{
    if (c >= 'a' && c <= 'z') {
        c = (char)(c - 'a' + 'A');
    }
    return c >= 'A' && c <= 'Z' ? LETTERS[c - 'A'] : c >= '-' && c <= '9' ? DIGITS[c - '-'] : 0;
}

void image_text(image *m, int x, int y, const char *text, rgb colour)
{
    for (; *text; text++, x += IMAGE_TEXT_WIDTH) {
        uint16_t bits = glyph(*text);
        for (int k = 0; k < 15; k++) {
            if (bits >> (14 - k) & 1) {
                image_fill(m, x + 2 * (k % 3), y + 2 * (k / 3), 2, 2, colour);
            }
        }
    }
}

/* ---- PNG ------------------------------------------------------------------------------------- */

int image_write_png(const image *m, const char *path, bake_error *error)
{
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)m->width,
                     .height = (png_uint_32)m->height,
                     .format = PNG_FORMAT_RGB};
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    void *memory = bake_alloc(size, 1);
    int good = png_image_write_to_memory(&png, memory, &size, 0, m->rgb, 0, NULL);
    int err = good ? file_replace(path, memory, size, error)
                   : bake_fail(error, "%s: no PNG of %d x %d pixels: %s", path, m->width, m->height,
                               png.message);
    free(memory);
    return err;
}
