/* One clip's curves, authored beside played: as a picture and as a table.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "check_curves.h"
#include "certify.h"
#include "command.h"
#include "fit.h"
#include "plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FRAME_US 20000
#define POINTS   1500 /* of a picture's line */

static double authored_at(const author_clip *a, int curve, double tick)
{
    const fit_problem p = {.curve = &a->curve[curve], .rate = a->rate};
    double value, slope;
    fit_truth(&p, tick, &value, &slope);
    return value;
}

/* ---- the picture ----------------------------------------------------------------------------- */

typedef struct {
    double authored[POINTS], played[POINTS];
    double *key_t, *key_v; /* keys */
    int keys;
} panel_data;

static void fill_keys(const scene_curve *c, panel_data *d)
{
    d->key_t = bake_alloc((size_t)c->key_count + 1, sizeof *d->key_t);
    d->key_v = bake_alloc((size_t)c->key_count + 1, sizeof *d->key_v);
    for (int k = 0; k < c->key_count; k++) {
        if (c->keys[k].weight[0] != 0) {
            d->key_t[d->keys] = c->keys[k].time;
            d->key_v[d->keys++] = c->keys[k].target[0];
        }
    }
}

static void fill_panels(const build *b, const wg_file *file, int clip, double *t, panel_data *data)
{
    const author_clip *a = &b->clip[clip];
    const scene_clip *s = &b->scene->clips[clip];
    int32_t *values = bake_alloc((size_t)b->scene->channel_count, sizeof *values);
    for (int i = 0; i < POINTS; i++) {
        double tick = (double)a->ticks * i / POINTS;
        t[i] = tick / a->rate;
        wg_clip_sample(file, (uint8_t)clip, (uint32_t)lround(1e6 * t[i]), values, NULL);
        for (int j = 0; j < s->curve_count; j++) {
            int channel = s->curves[j].channel;
            data[j].authored[i] = authored_at(a, j, tick);
            data[j].played[i] = channel_unit(file, channel, values[channel]);
        }
    }
    for (int j = 0; j < s->curve_count; j++) {
        fill_keys(&s->curves[j], &data[j]);
    }
    free(values);
}

int curves_png(const build *b, const wg_file *file, int clip, const char *path, bake_error *error)
{
    const scene_clip *s = &b->scene->clips[clip];
    panel_data *data = bake_alloc((size_t)s->curve_count, sizeof *data);
    plot_panel *panels = bake_alloc((size_t)s->curve_count, sizeof *panels);
    double *t = bake_alloc(POINTS, sizeof *t);
    fill_panels(b, file, clip, t, data);
    for (int j = 0; j < s->curve_count; j++) {
        const scene_channel *channel = &b->scene->channels[s->curves[j].channel];
        panel_data *d = &data[j];
        panels[j] = (plot_panel){
            channel->name,
            unit_name(channel->unit),
            d->keys ? 3 : 2,
            {{"authored", "lines lw 6 lc rgb '#f2b766'", POINTS, t, d->authored},
             {"played", "lines lw 1.5 lc rgb '#1d4f91'", POINTS, t, d->played},
             {"keys", "points pt 7 ps 0.8 lc rgb '#b3261e'", d->keys, d->key_t, d->key_v}}};
    }
    char title[256];
    snprintf(title, sizeof title, "%s: authored and played", s->name);
    int err = plot_png(path, title, panels, s->curve_count, error);
    for (int j = 0; j < s->curve_count; j++) {
        free(data[j].key_t);
        free(data[j].key_v);
    }
    free(t);
    free(panels);
    free(data);
    return err;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void write_rows(const build *b, const wg_file *file, int clip, FILE *to)
{
    const author_clip *a = &b->clip[clip];
    const scene_clip *s = &b->scene->clips[clip];
    int32_t *values = bake_alloc((size_t)b->scene->channel_count, sizeof *values);
    long last = (long)floor(1e6 * a->ticks / a->rate / FRAME_US + 1e-9);
    fprintf(to, "time");
    for (int j = 0; j < s->curve_count; j++) {
        const char *name = b->scene->channels[s->curves[j].channel].name;
        fprintf(to, ",%s authored,%s played", name, name);
    }
    for (long i = 0; i <= last; i++) {
        /* One rounding, so that a whole tick is exact and a step lies on its own side of it. */
        double tick = (double)i * FRAME_US * a->rate / 1e6;
        fprintf(to, "\n%.6f", (double)i * FRAME_US / 1e6);
        wg_clip_sample(file, (uint8_t)clip, (uint32_t)i * FRAME_US, values, NULL);
        for (int j = 0; j < s->curve_count; j++) {
            int channel = s->curves[j].channel;
            fprintf(to, ",%.9g,%.9g", authored_at(a, j, tick),
                    channel_unit(file, channel, values[channel]));
        }
    }
    fputc('\n', to);
    free(values);
}

int curves_csv(const build *b, const wg_file *file, int clip, const char *path, bake_error *error)
{
    FILE *to = csv_open(path, error);
    if (to == NULL) {
        return -1;
    }
    write_rows(b, file, clip, to);
    return csv_close(to, path, error);
}
