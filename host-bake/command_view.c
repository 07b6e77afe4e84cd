/* wiggly view: a clip in a window.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "viewer_window.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A panel's dots are small: the window shows them larger. */
#define PANEL_WIDTH_LEAST 400

static wg_size window_size(const painter_wish *wish)
{
    wg_size size = panel_at(wish->panel)->size;
    if (size.width == 0) {
        return wish->size;
    }
    int scale = (PANEL_WIDTH_LEAST + size.width - 1) / size.width;
    return (wg_size){(uint16_t)(scale * size.width), (uint16_t)(scale * size.height)};
}

static int check_options(const option *options, painter_wish *wish, bake_error *error)
{
    if (painter_options(options, (wg_size){400, 400}, wish, error) < 0 ||
        option_number(options, "--frames", 1, error) < 0) {
        return -1;
    }
    return 0;
}

/* The clip as the options want it, up to the moment that the window opens. */
static int prepare(viewer *v, const wg_file *file, const option *options, const painter_wish *wish,
                   bake_error *error)
{
    painter trial;
    if (viewer_init(v, file, option_value(options, "--clip"), error) < 0) {
        return -1;
    }
    if (painter_can(file)) { /* complaints come before the window does */
        if (painter_open_wish(&trial, file, wish, error) < 0) {
            return -1;
        }
        painter_close(&trial);
    }
    v->look = wish->look;
    v->panel = wish->panel;
    if (!painter_can(file)) {
        v->look = PAINTER_LOOK;
    }
    if (wish->at >= 0) {
        viewer_seek(v, (uint32_t)(wish->at * 1e6 + 0.5));
    }
    return 0;
}

int command_view(int argc, char **argv, bake_error *error)
{
    option options[] = {{"--clip", 1, NULL},
                        {"--frames", 1, NULL},
                        {"--shot", 1, NULL},
                        PAINTER_OPTIONS,
                        {NULL, 0, NULL}};
    const char *words[1];
    painter_wish wish;
    int count = options_parse(argc, argv, options, (option_words){words, 1}, error);
    if (count == 0) {
        count = bake_fail(error, "usage: wiggly view CLIP.wgl");
    }
    if (count < 0 || check_options(options, &wish, error) < 0) {
        return EXIT_USAGE;
    }
    clip_disk disk;
    if (clip_read(words[0], &disk, error) < 0) {
        return EXIT_FAILED;
    }
    viewer *v = bake_alloc(1, sizeof *v);
    int err = prepare(v, &disk.file, options, &wish, error);
    if (err == 0) {
        const char *given = option_value(options, "--frames");
        double frames = given ? option_number(options, "--frames", 1, error) : 0;
        const window_wish window = {window_size(&wish), (long)ceil(frames),
                                    option_value(options, "--shot")};
        v->name = strrchr(words[0], '/') ? strrchr(words[0], '/') + 1 : words[0];
        err = window_run(v, &window, error);
    }
    free(v);
    clip_release(&disk);
    return err < 0 ? EXIT_FAILED : EXIT_DONE;
}
