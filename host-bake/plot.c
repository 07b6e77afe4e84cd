/* Curves as a PNG: a script for gnuplot with its data inline, through a pipe.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "plot.h"

#include <errno.h>
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
    fprintf(to, " offset 0,-0.6");
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
    fprintf(to, "set terminal pngcairo noenhanced size %d,%d font 'sans,11'\nset output ",
            900 * columns, 90 + 200 * rows);
    quote(to, png);
    fprintf(to,
            "\nset border 3 lc rgb '#707070'\nset tics nomirror out scale 0.5 tc rgb '#404040'\n"
            "set grid lc rgb '#d8d8d8' lt 1 lw 0.5\nset lmargin 9\nset rmargin 3\n"
            "set offsets 0, 0, graph 0.08, graph 0.08\n"
            "set key at screen 0.99, screen 0.99 right top horizontal\n"
            "set multiplot layout %d,%d title ' ' font ',15'\nset label 1 ",
            rows, columns); /* the title's room; the title itself keeps clear of the key */
    quote(to, title);
    fprintf(to, " at screen 0, screen 1 left offset 2,-1 font ',15'\n");
    for (int i = 0; i < count; i++) {
        if (i >= count - columns) {
            fprintf(to, "set xlabel 's'\n");
        }
        write_panel(to, &panels[i], i);
        fprintf(to, "unset key\nunset label 1\n"); /* the first panel's serve all */
    }
    fprintf(to, "unset multiplot\n");
}

int plot_png(const char *path, const char *title, const plot_panel *panels, int count,
             bake_error *error)
{
    size_t size = strlen(path) + 24;
    char *temporary = bake_alloc(size, 1);
    snprintf(temporary, size, "%s.%ld.tmp", path, (long)getpid());
    FILE *probe = fopen(temporary, "wb"); /* gnuplot would draw on the terminal instead */
    if (probe == NULL) {
        bake_fail(error, "%s: cannot be written: %s", path, strerror(errno));
        free(temporary);
        return -1;
    }
    fclose(probe);
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
