/* The border of what is opaque in a picture: marching squares over the alphas of pixel centres.
 * A node is a pixel centre, or one of the ring of transparent ones around the picture; the contour
 * crosses edges between nodes, each once, so that its loops cannot cross.
 * Source: own; W. Lorensen, H. Cline, Marching Cubes, 1987, in the plane.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "outline.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double level = 127.5;

/* An antialiased border at c pixels is crossed at (c - 1/2)/c from the pixel's centre: off by
 * 3/2 - sqrt(2) = 0.086 at the most. Crossings nearer to a centre than this are moved here, which
 * makes that 0.125, and no stroke thinner than a quarter of a pixel: it would take many small
 * triangles. */
static const double nearest = 0.125;

typedef struct {
    const pixels *p;
    int *next; /* of each edge: where the contour leaves the cell that it enters there; -1 */
    int loop_count, point_count, point_room, specks;
    int *loop;
    double *at, least; /* least: twice the area */
} tracer;

static int alpha(const pixels *p, int x, int y)
{
    int inside = x >= 0 && y >= 0 && x < p->width && y < p->height;
    return inside ? p->rgba[4 * ((size_t)y * (size_t)p->width + (size_t)x) + 3] : 0;
}

/* The edge from node (x, y) to the right, or down. */
static int edge_of(const pixels *p, int x, int y, int down)
{
    return 2 * ((y + 1) * (p->width + 2) + x + 1) + down;
}

/* Corners clockwise from the upper left one, edge k between k and k + 1. The contour enters a cell
 * where that way leads out of the shape, and leaves it where it leads in. Of two strands in one
 * cell, each cuts off a transparent corner when the middle is opaque, otherwise an opaque one. */
static void link_cell(tracer *t, int x, int y)
{
    const pixels *p = t->p;
    const int a[4] = {alpha(p, x, y), alpha(p, x + 1, y), alpha(p, x + 1, y + 1),
                      alpha(p, x, y + 1)};
    int in[4], sum = a[0] + a[1] + a[2] + a[3];
    for (int k = 0; k < 4; k++)
        in[k] = a[k] > level;
    if (in[0] == in[1] && in[1] == in[2] && in[2] == in[3])
        return;
    const int edge[4] = {edge_of(p, x, y, 0), edge_of(p, x + 1, y, 1), edge_of(p, x, y + 1, 0),
                         edge_of(p, x, y, 1)};
    int first = in[0] == in[2] && in[1] == in[3] && sum < 4 * level ? 3 : 1;
    for (int k = 0; k < 4; k++) {
        int to = k + first;
        if (!in[k] || in[(k + 1) % 4])
            continue;
        while (in[to % 4] || !in[(to + 1) % 4])
            to++;
        t->next[edge[k]] = edge[to % 4];
    }
}

static void add_point(tracer *t, int edge)
{
    int wide = t->p->width + 2, down = edge % 2;
    int x = edge / 2 % wide - 1, y = edge / 2 / wide - 1;
    double a = alpha(t->p, x, y), b = alpha(t->p, x + !down, y + down);
    double way = fmin(fmax((a - level) / (a - b), nearest), 1 - nearest);
    if (t->point_count == t->point_room) {
        t->point_room = 2 * t->point_room + 1024;
        t->at = bake_grow(t->at, (size_t)t->point_room, 2 * sizeof *t->at);
    }
    double *at = t->at + 2 * (size_t)t->point_count++;
    at[0] = x + 0.5 + (down ? 0 : way);
    at[1] = y + 0.5 + (down ? way : 0);
}

double outline_area(const outline *o, int i)
{
    double sum = 0;
    for (int k = o->loop[i], before = o->loop[i + 1] - 1; k < o->loop[i + 1]; before = k++) {
        const double *a = o->at + 2 * (size_t)before, *b = o->at + 2 * (size_t)k;
        sum += a[0] * b[1] - a[1] * b[0];
    }
    return sum;
}

static outline traced(const tracer *t)
{
    return (outline){t->loop_count, t->point_count, t->loop, t->at};
}

static void add_loop(tracer *t, int edge)
{
    t->loop = bake_grow(t->loop, (size_t)t->loop_count + 2, sizeof *t->loop);
    t->loop[t->loop_count] = t->point_count;
    while (t->next[edge] >= 0) {
        int to = t->next[edge];
        add_point(t, edge);
        t->next[edge] = -1;
        edge = to;
    }
    t->loop[t->loop_count + 1] = t->point_count;
    outline o = traced(t);
    if (fabs(outline_area(&o, t->loop_count)) < t->least) {
        t->point_count = t->loop[t->loop_count];
        t->specks++;
    } else {
        t->loop_count++;
    }
}

void outline_free(outline *o)
{
    free((void *)o->loop);
    free((void *)o->at);
    *o = (outline){0};
}

void outline_box(const outline *o, double box[4])
{
    box[0] = box[1] = DBL_MAX;
    box[2] = box[3] = -DBL_MAX;
    for (int i = 0; i < 2 * o->point_count; i++) {
        box[i % 2] = fmin(box[i % 2], o->at[i]);
        box[2 + i % 2] = fmax(box[2 + i % 2], o->at[i]);
    }
}

static int check(const tracer *t, const outline *o, bake_error *error)
{
    if (t->loop_count == 0 && t->specks == 0)
        return bake_fail(error, "shows nothing: none of its pixels has an alpha of 128 or more");
    if (t->loop_count == 0)
        return bake_fail(error, "shows nothing larger than %.3g pixels: draw it larger",
                         t->least / 2);
    if (o->point_count > OUTLINE_POINTS_MAX)
        return bake_fail(error,
                         "has an outline with %d corners, of at most %d: smooth its border, or "
                         "reduce it",
                         o->point_count, OUTLINE_POINTS_MAX);
    return 0;
}

int outline_trace(const pixels *p, double tolerance, outline *out, int *specks, bake_error *error)
{
    int edges = 2 * (p->width + 2) * (p->height + 2);
    tracer t = {.p = p, .least = 2 * ceil(16 * tolerance * tolerance)};
    t.next = bake_alloc((size_t)edges, sizeof *t.next);
    memset(t.next, 0xff, (size_t)edges * sizeof *t.next);
    for (int y = -1; y < p->height; y++)
        for (int x = -1; x < p->width; x++)
            link_cell(&t, x, y);
    for (int i = 0; i < edges; i++)
        if (t.next[i] >= 0)
            add_loop(&t, i);
    free(t.next);
    outline all = traced(&t);
    *out = (outline){0};
    *specks = t.specks;
    if (t.loop_count > 0)
        outline_simplify(&all, tolerance, out);
    outline_free(&all);
    int err = check(&t, out, error);
    if (err)
        outline_free(out);
    return err;
}
