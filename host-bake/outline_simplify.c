/* Outlines with fewer corners, whose loops still do not touch: a loop that would is simplified
 * less.
 * Source: D. Douglas, T. Peucker, Algorithms for the Reduction of the Number of Points, 1973; the
 * repair is own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "outline.h"

#include <math.h>
#include <stdlib.h>

/* A loop's tolerance is halved so often; then that of all is 0, which only straightens straight
 * lines. */
enum { ROUNDS = 8 };

/* Cross products of a loop's pixels below this are 0: ways of 1e-9 pixels. */
static const double flat = 1e-9;

static const double *point(const outline *o, int i)
{
    return o->at + 2 * (size_t)i;
}

static double cross(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* ---- one loop -------------------------------------------------------------------------------- */

static double distance(const double *p, const double *a, const double *b)
{
    double way[2] = {b[0] - a[0], b[1] - a[1]}, from[2] = {p[0] - a[0], p[1] - a[1]};
    double length = way[0] * way[0] + way[1] * way[1];
    double t = length > 0 ? (way[0] * from[0] + way[1] * from[1]) / length : 0;
    t = fmin(fmax(t, 0), 1);
    return hypot(from[0] - t * way[0], from[1] - t * way[1]);
}

/* Of points first .. last - 1, the one farthest from where it would be on the way from a to b. */
static int farthest(const outline *o, const int range[2], const double *ends[2], double *far)
{
    int found = range[0];
    *far = -1;
    for (int i = range[0]; i < range[1]; i++) {
        double d = distance(point(o, i), ends[0], ends[1]);
        if (d > *far) {
            *far = d;
            found = i;
        }
    }
    return found;
}

/* Marks the corners that are left between point range[0] and range[1], which may be that behind the
 * loop's last: its first. stack: as many as the loop has points. */
static void mark(const outline *o, int loop, const int range[2], double tolerance, char *keep)
{
    int first = o->loop[loop], end = o->loop[loop + 1], used = 1;
    int(*stack)[2] = bake_alloc((size_t)(end - first) + 1, sizeof *stack);
    stack[0][0] = range[0];
    stack[0][1] = range[1];
    while (used > 0) {
        int a = stack[--used][0], b = stack[used][1];
        const int inner[2] = {a + 1, b};
        const double *ends[2] = {point(o, a), point(o, b < end ? b : first)};
        double far;
        int middle = farthest(o, inner, ends, &far);
        if (far <= tolerance)
            continue;
        keep[middle] = 1;
        stack[used][0] = a;
        stack[used++][1] = middle;
        stack[used][0] = middle;
        stack[used++][1] = b;
    }
    free(stack);
}

/* Beginning at the loop's first point, its uppermost, and the farthest from it. */
static void mark_loop(const outline *o, int loop, double tolerance, char *keep)
{
    int first = o->loop[loop], end = o->loop[loop + 1];
    const int all[2] = {first, end};
    const double *start[2] = {point(o, first), point(o, first)};
    double far;
    int other = farthest(o, all, start, &far);
    const int there[2] = {first, other}, back[2] = {other, end};
    keep[first] = keep[other] = 1;
    mark(o, loop, there, tolerance, keep);
    mark(o, loop, back, tolerance, keep);
}

static void simplify(const outline *from, const double *tolerance, outline *out)
{
    char *keep = bake_alloc((size_t)from->point_count, 1);
    int *loop = bake_alloc((size_t)from->loop_count + 1, sizeof *loop), count = 0;
    double *at = bake_alloc((size_t)from->point_count, 2 * sizeof *at);
    for (int i = 0; i < from->loop_count; i++) {
        mark_loop(from, i, tolerance[i], keep);
        for (int k = from->loop[i]; k < from->loop[i + 1]; k++) {
            at[2 * count] = point(from, k)[0];
            at[2 * count + 1] = point(from, k)[1];
            count += keep[k];
        }
        loop[i + 1] = count;
    }
    free(keep);
    *out = (outline){from->loop_count, count, loop, at};
}

/* ---- what went wrong ------------------------------------------------------------------------- */

typedef struct {
    int loop, from, to; /* points */
    double low[2], high[2];
} segment;

static int by_left(const void *a, const void *b)
{
    double x = ((const segment *)a)->low[0], y = ((const segment *)b)->low[0];
    return (x > y) - (x < y);
}

static segment *list_segments(const outline *o)
{
    segment *all = bake_alloc((size_t)o->point_count, sizeof *all), *s = all;
    for (int i = 0; i < o->loop_count; i++)
        for (int k = o->loop[i]; k < o->loop[i + 1]; k++, s++) {
            *s = (segment){.loop = i, .from = k, .to = k + 1 < o->loop[i + 1] ? k + 1 : o->loop[i]};
            const double *a = point(o, s->from), *b = point(o, s->to);
            for (int j = 0; j < 2; j++) {
                s->low[j] = fmin(a[j], b[j]);
                s->high[j] = fmax(a[j], b[j]);
            }
        }
    qsort(all, (size_t)o->point_count, sizeof *all, by_left);
    return all;
}

/* -1, 0, 1 */
static int side(const double *a, const double *b, const double *c)
{
    double x = cross(a, b, c);
    return (x > flat) - (x < -flat);
}

/* Segments that follow each other have a point in common, and may fold back there. */
static int touch(const outline *o, const segment *s, const segment *t)
{
    if (s->low[1] > t->high[1] || t->low[1] > s->high[1])
        return 0;
    const double *a = point(o, s->from), *b = point(o, s->to);
    const double *c = point(o, t->from), *d = point(o, t->to);
    if (s->to == t->from)
        return side(a, b, d) == 0 &&
               (b[0] - a[0]) * (d[0] - b[0]) + (b[1] - a[1]) * (d[1] - b[1]) < 0;
    if (t->to == s->from)
        return touch(o, t, s);
    return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
}

static int inside(const outline *o, int loop, const double *p)
{
    int in = 0;
    for (int k = o->loop[loop], j = o->loop[loop + 1] - 1; k < o->loop[loop + 1]; j = k++) {
        const double *a = point(o, j), *b = point(o, k);
        if ((a[1] > p[1]) != (b[1] > p[1]))
            in ^= (cross(a, b, p) > 0) == (b[1] > a[1]);
    }
    return in;
}

/* A loop that has changed sides with another runs the wrong way for where it is: the marching
 * squares have the shape on one side of all. */
static int turned(const outline *o, int loop)
{
    int depth = 0;
    for (int i = 0; i < o->loop_count; i++)
        depth += i != loop && inside(o, i, point(o, o->loop[loop]));
    return (outline_area(o, loop) > 0) != (depth % 2 == 0);
}

/* Marks the loops that touch, fold or have lost their inside, and all where one has changed sides;
 * how many. */
static int find_bad(const outline *o, char *bad)
{
    segment *s = list_segments(o);
    int count = 0, change = 0;
    for (int i = 0; i < o->point_count; i++)
        for (int j = i + 1; j < o->point_count && s[j].low[0] <= s[i].high[0]; j++)
            if ((!bad[s[i].loop] || !bad[s[j].loop]) && touch(o, &s[i], &s[j]))
                bad[s[i].loop] = bad[s[j].loop] = 1;
    for (int i = 0; i < o->loop_count; i++) {
        bad[i] |= o->loop[i + 1] - o->loop[i] < 3;
        count += bad[i];
    }
    for (int i = 0; i < o->loop_count && count == 0 && !change; i++)
        change = turned(o, i);
    for (int i = 0; i < o->loop_count && change; i++)
        bad[i] = 1;
    free(s);
    return count + change;
}

void outline_simplify(const outline *from, double tolerance, outline *out)
{
    double *each = bake_alloc((size_t)from->loop_count, sizeof *each);
    char *bad = bake_alloc((size_t)from->loop_count, 1);
    for (int i = 0; i < from->loop_count; i++)
        each[i] = tolerance;
    for (int round = 1;; round++) {
        simplify(from, each, out);
        if (round > ROUNDS || out->point_count > OUTLINE_POINTS_MAX || find_bad(out, bad) == 0)
            break;
        for (int i = 0; i < from->loop_count; i++) {
            each[i] *= round == ROUNDS ? 0 : bad[i] ? 0.5 : 1;
            bad[i] = 0;
        }
        outline_free(out);
    }
    free(each);
    free(bad);
}
