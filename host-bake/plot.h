/* Curves as a PNG, drawn by gnuplot.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_PLOT_H
#define BAKE_PLOT_H

#include "bake.h"

/* A line of a panel: `count` points (x ascending). */
typedef struct {
    const char *title, *style; /* gnuplot: "lines lw 2", "points pt 7" */
    int count;
    const double *x, *y;
} plot_line;

typedef struct {
    const char *title, *unit;
    int line_count;
    plot_line line[4];
} plot_panel;

/* Panels under each other, in two columns from seven on. Written whole or not at all. */
int plot_png(const char *path, const char *title, const plot_panel *panels, int count,
             bake_error *error);

#endif
