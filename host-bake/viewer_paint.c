/* What the window of wiggly view shows.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "viewer.h"

#include <math.h>

static const rgb AROUND = {32, 32, 36}, GROOVE = {64, 64, 70}, MARK = {230, 150, 40},
                 INK = {200, 200, 200};

/* ---- the timeline ---------------------------------------------------------------------------- */

#define BAR_EDGE 6 /* left and right of it */

int viewer_on_bar(const image *window, int y)
{
    return y >= window->height - VIEWER_BAR;
}

double viewer_bar_fraction(const image *window, int x)
{
    return (x - BAR_EDGE) / fmax(window->width - 1 - 2 * BAR_EDGE, 1);
}

static void paint_bar(const viewer *v, image *window)
{
    int width = window->width - 2 * BAR_EDGE, y = window->height - VIEWER_BAR;
    double length = viewer_length(v), done = length > 0 ? viewer_time(v) / length : 0;
    int mark = BAR_EDGE + (int)lround(done * (width - 1));
    image_fill(window, BAR_EDGE, y + VIEWER_BAR / 2 - 2, width, 4, GROOVE);
    image_fill(window, BAR_EDGE, y + VIEWER_BAR / 2 - 2, mark - BAR_EDGE, 4, MARK);
    image_fill(window, mark - 1, y + 2, 3, VIEWER_BAR - 4, MARK);
}

/* ---- channels as bars ------------------------------------------------------------------------ */

#define ROW (IMAGE_TEXT_HEIGHT + 6)

/* Name, and a bar from the channel's least value over all clips to its most. */
static void paint_channels(const viewer *v, image *window)
{
    int count = v->file->section[WG_SECTION_CHANNELS].count, left = window->width / 3;
    int width = window->width - left - BAR_EDGE;
    for (int c = 0; c < count && (c + 2) * ROW < window->height - VIEWER_BAR; c++) {
        int y = ROW / 2 + c * ROW;
        double least = v->least[c], range = fmax((double)v->most[c] - least, 1);
        double place = fmin(fmax((v->values[c] - least) / range, 0), 1);
        image_text(window, BAR_EDGE, y + 2, clip_name(v->file, NAME_CHANNEL, c), INK);
        image_fill(window, left - 2, y, width + 2, ROW - 3, AROUND); /* long names end here */
        image_fill(window, left, y, width, ROW - 4, GROOVE);
        image_fill(window, left, y, (int)lround(place * width), ROW - 4, MARK);
    }
}

/* ---- the picture ----------------------------------------------------------------------------- */

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

static int between(int value, int least, int most)
{
    return value < least ? least : smaller(value, most);
}

/* The size of the picture in this window, which may be too small for any. */
static wg_size size_in(const viewer *v, const image *window)
{
    const panel *on = panel_at(v->panel);
    int width = between(window->width, PAINTER_SIZE_MIN, PAINTER_SIZE_MAX);
    int height = between(window->height - VIEWER_BAR, PAINTER_SIZE_MIN, PAINTER_SIZE_MAX);
    return on->size.width > 0 ? on->size : (wg_size){(uint16_t)width, (uint16_t)height};
}

static int fit_painter(const viewer *v, painter *p, const image *window, bake_error *error)
{
    wg_size size = size_in(v, window);
    if (p->panel == panel_at(v->panel) && p->image.width == size.width &&
        p->image.height == size.height) {
        return 0;
    }
    painter_close(p);
    return painter_open(p, v->file, panel_at(v->panel), size, error);
}

static void paint_picture(const viewer *v, painter *p, image *window)
{
    int width = window->width, height = window->height - VIEWER_BAR;
    int scale = smaller(width / p->image.width, height / p->image.height);
    scale = scale < 1 ? 1 : scale;
    painter_paint(p, v->values, v->look);
    image_copy(window, (width - scale * p->image.width) / 2, (height - scale * p->image.height) / 2,
               &p->image, scale);
}

int viewer_paint(const viewer *v, painter *p, image *window, bake_error *error)
{
    image_fill(window, 0, 0, window->width, window->height, AROUND);
    if (!painter_can(v->file)) {
        paint_channels(v, window);
    } else if (fit_painter(v, p, window, error) < 0) {
        return -1;
    } else {
        paint_picture(v, p, window);
    }
    image_fill(window, 0, window->height - VIEWER_BAR, window->width, VIEWER_BAR, AROUND);
    paint_bar(v, window);
    return 0;
}
