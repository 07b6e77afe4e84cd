/* Drawings as pixels: librsvg draws all that SVG can describe, so that overlapping paths, their
 * fill rules, strokes and transforms need no geometry of our own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bitmap.h"

#include <librsvg/rsvg.h>

#include <math.h>
#include <string.h>

/* Pixels of the longer side: finer than outlines are by default (mesh_flat.c). */
static const double side = 1024;

static int fail(bake_error *error, GError *why)
{
    bake_fail(error, "cannot be read as an SVG drawing: %s", why ? why->message : "nothing in it");
    g_clear_error(&why);
    return -1;
}

/* Width and height in CSS pixels, or those of the viewBox, or of what is drawn. */
static int size_of(RsvgHandle *drawing, double size[2], bake_error *error)
{
    RsvgLength width, height;
    RsvgRectangle box, ink = {0, 0, 0, 0};
    const RsvgRectangle screen = {0, 0, side, side};
    gboolean has[3];
    GError *why = NULL;
    if (!rsvg_handle_get_intrinsic_size_in_pixels(drawing, &size[0], &size[1])) {
        rsvg_handle_get_intrinsic_dimensions(drawing, &has[0], &width, &has[1], &height, &has[2],
                                             &box);
        if (!has[2] &&
            !rsvg_handle_get_geometry_for_layer(drawing, NULL, &screen, &ink, NULL, &why))
            return fail(error, why);
        size[0] = has[2] ? box.width : ink.x + ink.width;
        size[1] = has[2] ? box.height : ink.y + ink.height;
    }
    double longer = fmax(size[0], size[1]);
    if (isfinite(longer) && fmin(size[0], size[1]) > longer / side)
        return 0;
    return bake_fail(error,
                     "is a drawing of %g x %g pixels: give it a width, a height and a viewBox",
                     size[0], size[1]);
}

/* Cairo's premultiplied words of red, green, blue and alpha. */
static void take(const unsigned char *from, int stride, const pixels *to)
{
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < to->width; x++) {
            uint8_t *c = to->rgba + 4 * ((size_t)y * (size_t)to->width + (size_t)x);
            uint32_t word;
            memcpy(&word, from + (size_t)y * (size_t)stride + 4 * (size_t)x, sizeof word);
            uint32_t alpha = word >> 24;
            for (int k = 0; k < 3 && alpha > 0; k++)
                c[k] = (uint8_t)(((word >> (16 - 8 * k) & 255u) * 255u + alpha / 2) / alpha);
            c[3] = (uint8_t)alpha;
        }
}

static int draw(RsvgHandle *drawing, pixels *out, bake_error *error)
{
    GError *why = NULL;
    cairo_surface_t *to = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, out->width, out->height);
    cairo_t *pen = cairo_create(to);
    const RsvgRectangle all = {0, 0, out->unit * out->width, out->unit * out->height};
    cairo_scale(pen, 1 / out->unit, 1 / out->unit);
    int err = rsvg_handle_render_document(drawing, pen, &all, &why) ? 0 : fail(error, why);
    cairo_destroy(pen);
    cairo_surface_flush(to);
    if (err == 0 && cairo_surface_status(to) != CAIRO_STATUS_SUCCESS)
        err = bake_fail(error, "is a drawing that cannot be drawn: %s",
                        cairo_status_to_string(cairo_surface_status(to)));
    if (err == 0) {
        out->rgba = bake_alloc((size_t)out->width * (size_t)out->height, 4);
        take(cairo_image_surface_get_data(to), cairo_image_surface_get_stride(to), out);
    }
    cairo_surface_destroy(to);
    return err;
}

int pixels_read_svg(const char *path, pixels *out, bake_error *error)
{
    GError *why = NULL;
    RsvgHandle *drawing = rsvg_handle_new_from_file(path, &why);
    double size[2];
    *out = (pixels){0};
    if (drawing == NULL)
        return fail(error, why);
    rsvg_handle_set_dpi(drawing, 96);
    int err = size_of(drawing, size, error);
    if (err == 0) {
        out->unit = fmax(size[0], size[1]) / side;
        out->width = (int)ceil(size[0] / out->unit - 1e-9);
        out->height = (int)ceil(size[1] / out->unit - 1e-9);
        err = draw(drawing, out, error);
    }
    g_object_unref(drawing);
    return err;
}
