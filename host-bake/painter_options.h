/* What a command line says about pictures: the same for `wiggly play --png` and `wiggly view`.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_PAINTER_OPTIONS_H
#define BAKE_PAINTER_OPTIONS_H

#include "command.h"
#include "painter.h"

/* Lines of an option table. */
#define PAINTER_OPTIONS                                                                            \
    {"--size", 1, NULL}, {"--panel", 1, NULL}, {"--view", 1, NULL}, {"--bases", 1, NULL},          \
        {"--shading", 1, NULL},                                                                    \
    {                                                                                              \
        "--at", 1, NULL                                                                            \
    }

#define PAINTER_SIZE_MIN 8

typedef struct {
    painter_look look;
    int panel;
    wg_size size;
    double at; /* seconds; -1: not given */
} painter_wish;

/* -1 and a message when one of them is wrong whatever the clip is. */
int painter_options(const option *options, wg_size usual, painter_wish *out, bake_error *error);

/* painter_open, after a look at the views that the clip has. */
int painter_open_wish(painter *p, const wg_file *file, const painter_wish *wish, bake_error *error);

#endif
