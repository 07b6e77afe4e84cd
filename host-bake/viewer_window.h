/* The window of wiggly view: SDL, and nothing else in the project.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_VIEWER_WINDOW_H
#define BAKE_VIEWER_WINDOW_H

#include "viewer.h"

typedef struct {
    wg_size size;     /* of the picture at the start; the timeline comes below it */
    long frames;      /* ends after so many; 0: when told to */
    const char *shot; /* where the last frame goes as PNG, or NULL */
} window_wish;

/* Shows `v` until it is quit. */
int window_run(viewer *v, const window_wish *wish, bake_error *error);

#endif
