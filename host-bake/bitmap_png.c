/* PNG files as pixels; the colour of a picture.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bitmap.h"

#include <png.h>
#include <stdlib.h>
#include <string.h>

int pixels_read_png(const char *path, pixels *out, bake_error *error)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    *out = (pixels){.unit = 1};
    if (!png_image_begin_read_from_file(&png, path))
        return bake_fail(error, "cannot be read as a PNG picture: %s", png.message);
    if (png.width > PIXELS_MAX || png.height > PIXELS_MAX) {
        png_image_free(&png);
        return bake_fail(error, "has %u x %u pixels; a picture has at most %d a side: reduce it",
                         (unsigned)png.width, (unsigned)png.height, PIXELS_MAX);
    }
    png.format = PNG_FORMAT_RGBA;
    out->width = (int)png.width;
    out->height = (int)png.height;
    out->rgba = bake_alloc(PNG_IMAGE_SIZE(png), 1);
    if (png_image_finish_read(&png, NULL, out->rgba, 0, NULL))
        return 0;
    pixels_free(out);
    return bake_fail(error, "cannot be read as a PNG picture: %s; export it again", png.message);
}

void pixels_free(pixels *p)
{
    free(p->rgba);
    *p = (pixels){0};
}

/* In steps of 8, so that smooth shading counts as one colour; then the mean of what is in the
 * fullest cell. */
void pixels_main_colour(const pixels *p, unsigned char colour[3])
{
    enum { CELLS = 1 << 15 };
    typedef struct {
        long count, sum[3];
    } cell;
    cell *cells = bake_alloc(CELLS, sizeof *cells), *most = cells;
    for (size_t i = 0; i < (size_t)p->width * (size_t)p->height; i++) {
        const uint8_t *c = p->rgba + 4 * i;
        cell *at = cells + ((c[0] >> 3) << 10 | (c[1] >> 3) << 5 | c[2] >> 3);
        if (c[3] < 128)
            continue;
        at->count++;
        for (int k = 0; k < 3; k++)
            at->sum[k] += c[k];
        if (at->count > most->count)
            most = at;
    }
    for (int k = 0; k < 3; k++)
        colour[k] = (unsigned char)(most->count ? most->sum[k] / most->count : 0);
    free(cells);
}
