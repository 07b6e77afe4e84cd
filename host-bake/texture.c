/* Pixels to the texels and the palette of a clip.
 * Source: own; the palette is libimagequant's.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "texture.h"

#include <libimagequant.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A texel has a colour of its own when so much of it is opaque: less is mostly the border's, which
 * the neighbours show better. */
static const double own_colour = 0.25;

/* Texels that repeat their neighbours' colour: triangles reach half a pixel over the border, a
 * sampled texel may be a rounding farther off, and the holes that the outline leaves out are
 * smaller. */
enum { BLEED = 4 };

/* Texels under way: alpha is 255 or 0. */
typedef struct {
    int width, height;
    uint8_t *rgba;
} grid;

/* How much of pixel i lies in a .. b. */
static double overlap(int i, double a, double b)
{
    return fmin(i + 1.0, b) - fmax(i, a);
}

/* The mean of a rectangle of pixels (lower, then upper corner); what is outside is transparent. */
static void mean(const pixels *p, const double r[4], uint8_t *out)
{
    double sum[4] = {0}, area = (r[2] - r[0]) * (r[3] - r[1]);
    int x1 = (int)fmin(ceil(r[2]), p->width), y1 = (int)fmin(ceil(r[3]), p->height);
    for (int y = (int)fmax(floor(r[1]), 0); y < y1; y++)
        for (int x = (int)fmax(floor(r[0]), 0); x < x1; x++) {
            const uint8_t *c = p->rgba + 4 * ((size_t)y * (size_t)p->width + (size_t)x);
            double a = c[3] * overlap(x, r[0], r[2]) * overlap(y, r[1], r[3]);
            for (int k = 0; k < 3; k++)
                sum[k] += a * c[k];
            sum[3] += a;
        }
    if (sum[3] < 255 * own_colour * area)
        return;
    for (int k = 0; k < 3; k++)
        out[k] = (uint8_t)lround(sum[k] / sum[3]);
    out[3] = 255;
}

/* Texels a scene unit, for a longer side of so many pixels: pictures that are not reduced keep their
 * pixels. */
static double choose_step(const picture_place *where, double longer)
{
    return fmin(1, (where->texels - 2) / longer) / where->unit;
}

static grid sample(const pixels *p, const picture_place *where, mesh_picture *out)
{
    const double *box = where->box;
    double x = floor(box[0]), y = floor(box[1]);
    double wide = ceil(box[2]) - x, high = ceil(box[3]) - y;
    out->step = choose_step(where, fmax(wide, high));
    double texels = out->step * where->unit, pixel = 1 / texels; /* a pixel; a texel */
    x -= pixel;
    y -= pixel;
    out->corner[0] = ((box[0] + box[2]) / 2 - x) * texels;
    out->corner[1] = ((box[1] + box[3]) / 2 - y) * texels;
    grid g = {2 + (int)ceil(wide * texels - 1e-9), 2 + (int)ceil(high * texels - 1e-9), NULL};
    g.rgba = bake_alloc((size_t)g.width * (size_t)g.height, 4);
    for (int j = 0; j < g.height; j++)
        for (int i = 0; i < g.width; i++) {
            const double r[4] = {x + i * pixel, y + j * pixel, x + (i + 1) * pixel,
                                 y + (j + 1) * pixel};
            mean(p, r, g.rgba + 4 * ((size_t)j * (size_t)g.width + (size_t)i));
        }
    return g;
}

/* What surrounds a texel, the nearest first. */
static const uint8_t *neighbour(const grid *g, const uint8_t *from, int x, int y)
{
    static const int way[8][2] = {{-1, 0},  {1, 0},  {0, -1}, {0, 1},
                                  {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    for (int k = 0; k < 8; k++) {
        int i = x + way[k][0], j = y + way[k][1];
        const uint8_t *c = from + 4 * ((ptrdiff_t)j * g->width + i);
        if (i >= 0 && j >= 0 && i < g->width && j < g->height && c[3])
            return c;
    }
    return NULL;
}

static void bleed(grid *g)
{
    size_t size = 4 * (size_t)g->width * (size_t)g->height;
    uint8_t *before = bake_alloc(size, 1);
    for (int n = 0; n < BLEED; n++) {
        memcpy(before, g->rgba, size);
        for (int y = 0; y < g->height; y++)
            for (int x = 0; x < g->width; x++) {
                uint8_t *c = g->rgba + 4 * ((size_t)y * (size_t)g->width + (size_t)x);
                const uint8_t *near = c[3] ? NULL : neighbour(g, before, x, y);
                if (near)
                    memcpy(c, near, 4);
            }
    }
    free(before);
}

/* The texels that have a colour, one behind the other, and where they are. */
static int list(const grid *g, uint8_t *colour, int *where)
{
    int count = 0;
    for (int i = 0; i < g->width * g->height; i++)
        if (g->rgba[4 * (size_t)i + 3]) {
            memcpy(colour + 4 * (size_t)count, g->rgba + 4 * (size_t)i, 4);
            where[count++] = i;
        }
    return count;
}

/* index: which of the palette's entries each colour becomes, from 0. Not dithered: a picture that
 * moves would flicker, and drawn ones have few colours. */
static int quantise(const uint8_t *colour, int count, unsigned char *palette, uint8_t *index)
{
    liq_attr *how = liq_attr_create();
    liq_image *from = how ? liq_image_create_rgba(how, colour, count, 1, 0) : NULL;
    liq_result *result = NULL;
    int good = from && liq_set_max_colors(how, 255) == LIQ_OK &&
               liq_image_quantize(from, how, &result) == LIQ_OK &&
               liq_set_dithering_level(result, 0) == LIQ_OK &&
               liq_write_remapped_image(result, from, index, (size_t)count) == LIQ_OK;
    const liq_palette *found = good ? liq_get_palette(result) : NULL;
    for (unsigned i = 0; found && i < found->count && i < 255; i++) {
        palette[3 * i] = found->entries[i].r;
        palette[3 * i + 1] = found->entries[i].g;
        palette[3 * i + 2] = found->entries[i].b;
    }
    if (result)
        liq_result_destroy(result);
    if (from)
        liq_image_destroy(from);
    if (how)
        liq_attr_destroy(how);
    return good ? 0 : -1;
}

static int index_texels(const grid *g, mesh_picture *out)
{
    size_t size = (size_t)g->width * (size_t)g->height;
    uint8_t *colour = bake_alloc(size, 4), *index = bake_alloc(size, 1);
    int *where = bake_alloc(size, sizeof *where), count = list(g, colour, where);
    int err = count > 0 ? quantise(colour, count, out->palette + 3, index) : -1;
    out->width = g->width;
    out->height = g->height;
    out->texel = bake_alloc(size, 1);
    for (int i = 0; i < count; i++)
        out->texel[where[i]] = (unsigned char)(index[i] + 1);
    free(where);
    free(index);
    free(colour);
    return err;
}

int picture_make(const pixels *p, const picture_place *where, mesh_picture *out, bake_error *error)
{
    *out = (mesh_picture){0};
    grid g = sample(p, where, out);
    bleed(&g);
    int err = index_texels(&g, out);
    free(g.rgba);
    return err ? bake_fail(error, "has colours that no palette could be found for") : 0;
}
