/* wiggly play --png for clips with parts: one picture, a series or a sheet.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "play_picture.h"
#include "record.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH_MAX_US 4294e6
#define SERIES_MAX    10000

/* A performance on its way to the next picture. */
typedef struct {
    stage *g;
    painter paint;
    painter_look look;
    long frame; /* the next one */
} show;

/* Paints the moment `time_us`, not before the last one asked for. The player goes there frame by
 * frame, so that events and triggers act when they do on a device. */
static const image *show_at(show *s, double time_us)
{
    int32_t values[WG_CHANNELS_MAX];
    uint32_t us = (uint32_t)floor(time_us + 0.5);
    for (; (uint64_t)s->frame * s->g->frame_us <= us; s->frame++) {
        stage_step(s->g, s->frame);
    }
    stage_peek(s->g, us, values);
    painter_paint(&s->paint, values, s->look);
    return &s->paint.image;
}

/* ---- how long, how many ---------------------------------------------------------------------- */

/* Microseconds of the whole performance. */
static double length_us(const stage *g, const option *options, bake_error *error)
{
    int layer = layer_longest(&g->player);
    double once = layer < 0 ? 1e6 : get32(clip_record(g->file, g->layers[layer].clip) + WG_CLIP_US);
    return 1e6 * option_number(options, "--seconds", once * 1e-6, error);
}

/* The end of a clip that loops is its beginning again, and is left out. */
static int shows_end(const stage *g, const option *options)
{
    int layer = layer_longest(&g->player);
    return option_value(options, "--seconds") != NULL || layer < 0 ||
           g->layers[layer].end != WG_END_LOOP;
}

/* What a mistyped number would do is long, and a clip's clock has 32 bits of microseconds. */
static int check_length(const stage *g, const option *options, bake_error *error)
{
    double us = length_us(g, options, error), fps = option_number(options, "--fps", 10, error);
    if (fps < 0) {
        return -1;
    }
    if (us > LENGTH_MAX_US) {
        return bake_fail(error, "--png shows up to %g s, not %g", LENGTH_MAX_US * 1e-6, us * 1e-6);
    }
    return us * 1e-6 * fps > SERIES_MAX
               ? bake_fail(error, "%g s at %g pictures a second are more than %d pictures",
                           us * 1e-6, fps, SERIES_MAX)
               : 0;
}

/* ---- a series -------------------------------------------------------------------------------- */

/* The %d of a name: where, and how many digits with zeros in front. NULL if there is none. */
static const char *place_of_number(const char *path, int *digits, const char **rest)
{
    const char *at = strchr(path, '%');
    char *end;
    *digits = 0;
    *rest = at;
    if (at == NULL) {
        return NULL;
    }
    long count = strtol(at + 1, &end, 10);
    if (at[1] >= '0' && at[1] <= '9') {
        *digits = (int)count;
    }
    *rest = *end == 'd' && count >= 0 && count < 10 && strchr(end, '%') == NULL ? end + 1 : NULL;
    return at;
}

int series_check(const char *path, bake_error *error)
{
    const char *rest;
    int digits;
    if (place_of_number(path, &digits, &rest) == NULL) {
        return 0;
    }
    return rest ? 1
                : bake_fail(error,
                            "--png %s: a series has one %%d or %%03d in its name, nothing else "
                            "with %%",
                            path);
}

static int write_series(show *s, const char *path, const option *options, bake_error *error)
{
    const char *rest, *at;
    int digits, err = 0;
    double fps = option_number(options, "--fps", 10, error);
    double end = length_us(s->g, options, error) + (shows_end(s->g, options) ? 0.5 : -0.5);
    size_t size = strlen(path) + 32;
    char *name = bake_alloc(size, 1);
    at = place_of_number(path, &digits, &rest);
    for (int i = 0; err == 0 && i * 1e6 / fps <= end; i++) {
        snprintf(name, size, "%.*s%0*d%s", (int)(at - path), path, digits, i, rest);
        err = image_write_png(show_at(s, i * 1e6 / fps), name, error);
    }
    free(name);
    return err;
}

/* ---- a sheet --------------------------------------------------------------------------------- */

static int write_sheet(show *s, const char *path, const option *options, bake_error *error)
{
    const rgb paper = {24, 24, 24}, ink = {200, 200, 200};
    int count = SHEET_COLUMNS * SHEET_ROWS;
    int w = s->paint.image.width + SHEET_GAP, h = s->paint.image.height + SHEET_LABEL + SHEET_GAP;
    double step = length_us(s->g, options, error) / (count - shows_end(s->g, options));
    image sheet = image_make(SHEET_COLUMNS * w + SHEET_GAP, SHEET_ROWS * h + SHEET_GAP);
    image_fill(&sheet, 0, 0, sheet.width, sheet.height, paper);
    for (int i = 0; i < count; i++) {
        char label[32];
        int x = SHEET_GAP + i % SHEET_COLUMNS * w, y = SHEET_GAP + i / SHEET_COLUMNS * h;
        image_copy(&sheet, x, y, show_at(s, i * step), 1);
        snprintf(label, sizeof label, "%.2f s", i * step * 1e-6);
        image_text(&sheet, x, y + h - SHEET_GAP - IMAGE_TEXT_HEIGHT, label, ink);
    }
    int err = image_write_png(&sheet, path, error);
    image_free(&sheet);
    return err;
}

int play_pictures(stage *g, const option *options, const char *path, bake_error *error)
{
    painter_wish wish;
    show s = {.g = g};
    if (painter_options(options, (wg_size){240, 240}, &wish, error) < 0 ||
        check_length(g, options, error) < 0 ||
        painter_open_wish(&s.paint, g->file, &wish, error) < 0) {
        return -1;
    }
    s.look = wish.look;
    int series = series_check(path, error), err = -1;
    if (wish.at >= 0) {
        err = image_write_png(show_at(&s, wish.at * 1e6), path, error);
    } else if (series > 0) {
        err = write_series(&s, path, options, error);
    } else if (series == 0) {
        err = write_sheet(&s, path, options, error);
    }
    painter_close(&s.paint);
    return err;
}
