/* Curves as a PNG: a script for gnuplot with its data inline, through a pipe.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "plot.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Text between double quotes for gnuplot. */
static void quote(FILE *to, const char *text)
{
    fputc('"', to);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\') {
            fputc('\\', to);
        }
        fputc((unsigned char)*text < 32 ? ' ' : *text, to);
    }
    fputc('"', to);
}

static void write_panel(FILE *to, const plot_panel *p, int index)
{
    for (int i = 0; i < p->line_count; i++) {
        fprintf(to, "$d%d_%d << EOD\n", index, i);
        for (int k = 0; k < p->line[i].count; k++) {
            fprintf(to, "%.6g %.9g\n", p->line[i].x[k], p->line[i].y[k]);
        }
        fprintf(to, "EOD\n");
    }
    fprintf(to, "set title ");
    quote(to, p->title);
    fprintf(to, "\nset ylabel ");
    quote(to, p->unit);
    fprintf(to, "\nplot ");
    for (int i = 0; i < p->line_count; i++) {
        fprintf(to, "%s$d%d_%d with %s title ", i ? ", " : "", index, i, p->line[i].style);
        quote(to, p->line[i].title);
    }
    fputc('\n', to);
}

static void write_script(FILE *to, const char *png, const char *title, const plot_panel *panels,
                         int count)
{
    int columns = count > 6 ? 2 : 1, rows = (count + columns - 1) / columns;
    fprintf(to, "set terminal pngcairo noenhanced size %d,%d font 'sans,9'\nset output ",
            900 * columns, 60 + 190 * rows);
    quote(to, png);
    fprintf(to, "\nset key outside right top\nset grid\nset xlabel ''\nset lmargin 9\n"
                "set multiplot layout %d,%d title ", rows, columns);
    quote(to, title);
    fputc('\n', to);
    for (int i = 0; i < count; i++) {
        if (i >= count - columns) {
            fprintf(to, "set xlabel 's'\n");
        }
        write_panel(to, &panels[i], i);
    }
    fprintf(to, "unset multiplot\n");
}

int plot_png(const char *path, const char *title, const plot_panel *panels, int count,
             bake_error *error)
{
    size_t size = strlen(path) + 24;
    char *temporary = bake_alloc(size, 1);
    snprintf(temporary, size, "%s.%ld.tmp", path, (long)getpid());
    FILE *pipe = popen("gnuplot 2>/dev/null", "w");
    int status = -1;
    if (pipe) {
        write_script(pipe, temporary, title, panels, count);
        status = pclose(pipe);
    }
    int good = status == 0 && rename(temporary, path) == 0;
    if (!good) {
        remove(temporary);
        if (status != -1 && WIFEXITED(status) && WEXITSTATUS(status) == 127) {
            bake_fail(error, "%s: gnuplot is not installed: apt-get install gnuplot-nox", path);
        } else {
            bake_fail(error, "%s: gnuplot could not draw it", path);
        }
    }
    free(temporary);
    return good ? 0 : -1;
}
