/* What a command line says about pictures.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "painter_options.h"

#include <stdlib.h>
#include <string.h>

/* A number that may be 0, up to `most`; -1 and a message otherwise. */
static double number_from_0(const option *options, const char *name, double most, bake_error *error)
{
    const char *text = option_value(options, name);
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end != 0 || !(value >= 0) || value > most) {
        return bake_fail(error, "%s needs a number from 0 to %g, not '%s'", name, most, text);
    }
    return value;
}

static int whole_from_0(const option *options, const char *name, int most, int *out,
                        bake_error *error)
{
    if (option_value(options, name) == NULL) {
        return 0;
    }
    double value = number_from_0(options, name, most, error);
    *out = (int)value;
    return value < 0      ? -1
           : value > *out ? bake_fail(error, "%s needs a whole number, not %g", name, value)
                          : 0;
}

static int size_option(const option *options, wg_size *out, bake_error *error)
{
    const char *text = option_value(options, "--size");
    if (text == NULL) {
        return 0;
    }
    char *x, *end;
    long width = strtol(text, &x, 10), height = *x == 'x' ? strtol(x + 1, &end, 10) : 0;
    if (*x != 'x' || *end != 0 || width < PAINTER_SIZE_MIN || width > PAINTER_SIZE_MAX ||
        height < PAINTER_SIZE_MIN || height > PAINTER_SIZE_MAX) {
        return bake_fail(error, "--size needs WIDTHxHEIGHT, each %d to %d, not '%s'",
                         PAINTER_SIZE_MIN, PAINTER_SIZE_MAX, text);
    }
    *out = (wg_size){(uint16_t)width, (uint16_t)height};
    return 0;
}

int painter_options(const option *options, wg_size usual, painter_wish *out, bake_error *error)
{
    const char *panel_name = option_value(options, "--panel");
    const char *shading = option_value(options, "--shading");
    *out = (painter_wish){PAINTER_LOOK, 0, usual, -1};
    if (panel_name && (out->panel = panel_find(panel_name, error)) < 0) {
        return -1;
    }
    if (shading && (out->look.shading = shading_find(shading, error)) < 0) {
        return -1;
    }
    if (panel_at(out->panel)->size.width > 0 && option_value(options, "--size")) {
        return bake_fail(error, "--panel %s has its own size: leave --size out", panel_name);
    }
    if (option_value(options, "--at") &&
        (out->at = number_from_0(options, "--at", 4294, error)) < 0) {
        return -1;
    }
    if (whole_from_0(options, "--view", (int)WG_VIEWS_MAX - 1, &out->look.view, error) < 0 ||
        whole_from_0(options, "--bases", (int)WG_BASES_MAX, &out->look.bases, error) < 0) {
        return -1;
    }
    return size_option(options, &out->size, error);
}

int painter_open_wish(painter *p, const wg_file *file, const painter_wish *wish, bake_error *error)
{
    int views = view_count(file);
    if (wish->look.view >= views) {
        return bake_fail(error, "--view %d: the clip has %d view%s, counted from 0",
                         wish->look.view, views, views == 1 ? "" : "s");
    }
    return painter_open(p, file, panel_at(wish->panel), wish->size, error);
}
