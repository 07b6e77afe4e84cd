/* Reads one captured curve: picks the reader, cuts, shifts and scales.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "capture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Sources store float times: two instants closer than this are one. */
static const double same_time = 1e-6;

void capture_add(capture_reader *r, double time, double value)
{
    capture *c = r->out;
    if (c->count == r->room) {
        r->room = r->room ? 2 * r->room : 256;
        c->time = bake_grow(c->time, (size_t)r->room, sizeof(double));
        c->value = bake_grow(c->value, (size_t)r->room, sizeof(double));
    }
    c->time[c->count] = time;
    c->value[c->count++] = value;
}

static double value_at(const capture *c, double time)
{
    int i = 1;
    while (i < c->count - 1 && c->time[i] < time)
        i++;
    double part = (time - c->time[i - 1]) / (c->time[i] - c->time[i - 1]);
    return c->value[i - 1] + part * (c->value[i] - c->value[i - 1]);
}

static int find_span(const capture_reader *r, double *start, double *end)
{
    const capture *c = r->out;
    const scene_curve *curve = r->curve;
    double first = c->time[0], last = c->time[c->count - 1];
    *start = curve->from > 0 ? curve->from : first;
    *end = curve->to > 0 ? curve->to : last;
    if (*start < first - same_time || *end > last + same_time || *end - *start < same_time)
        return bake_fail(
            r->error,
            "%s:%d: the curve asks for %g .. %g s of the source '%s', which lasts from "
            "%g to %g s; change 'from' or 'to'",
            r->scene_path, curve->line, *start, *end, r->source->name, first, last);
    return 0;
}

/* Keeps start .. end, with interpolated samples at both, and shifts it to 0. */
static int cut(capture_reader *r)
{
    double start, end;
    if (find_span(r, &start, &end))
        return -1;
    capture *c = r->out;
    capture kept = {0};
    capture_reader into = {.out = &kept};
    capture_add(&into, 0, value_at(c, start));
    for (int i = 0; i < c->count; i++)
        if (c->time[i] > start + same_time && c->time[i] < end - same_time)
            capture_add(&into, c->time[i] - start, c->value[i]);
    capture_add(&into, end - start, value_at(c, end));
    capture_free(c);
    *c = kept;
    return 0;
}

static void scale(const capture_reader *r)
{
    const scene_curve *curve = r->curve;
    capture *c = r->out;
    int turns = curve->node != NULL && curve->component == CAPTURE_ROTATION;
    double full = turns ? 360 * ceil(c->value[0] / 360 - 0.5) : 0;
    for (int i = 0; i < c->count; i++)
        c->value[i] = curve->scale * (c->value[i] - full) + curve->offset;
}

int capture_load(const scene *s, const scene_curve *curve, capture *out, bake_error *error)
{
    *out = (capture){0};
    capture_reader r = {.scene_path = s->path,
                        .source = &s->sources[curve->source],
                        .curve = curve,
                        .out = out,
                        .error = error};
    int err = curve->column != NULL ? capture_read_csv(&r) : capture_read_node(&r);
    if (err == 0)
        err = cut(&r);
    if (err == 0)
        scale(&r);
    else
        capture_free(out);
    return err;
}

void capture_free(capture *c)
{
    free(c->time);
    free(c->value);
    free(c->kink);
    *c = (capture){0};
}
