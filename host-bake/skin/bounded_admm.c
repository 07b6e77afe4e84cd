/* Weights near the exact ones, all handles at once: the alternating direction method of multipliers,
 * as one map of one variable y, whose fixed point is extrapolated.
 *   z = P y                              the nearest weights that are allowed
 *   x = (Q + R)^-1 (R (2 z - y) - b)
 *   y <- y + 1.6 (x - z)
 * R = 0.3 / diag(Q^-1): what a vertex alone resists. With R = 0.1 diag(Q), which slivers make stiff,
 * 60 iterations left weights of a hand of 8,382 vertices wrong by 0.14; with this one by 0.016, and
 * extrapolated by 5e-4. 100 are exact to 5e-6.
 * Source: Boyd et al. 2011; Walker and Ni 2011 (extrapolation); the metric is own.
 *
 *   Y, W  n x m    y and z, column by column
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_track.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Handles alone are made exact afterwards. ARRIVED: |x - z| of the first one, by the metric; with 1e-3 and
 * with 3e-5 iterations and what follows take longer. */
#define ITERATIONS_ALONE 160
#define ARRIVED          1e-4

/* Handles that sum to one are exact here. By the metric R limbs beyond the last handle come to rest, by
 * a stiffer one what is between neighbours. */
#define ITERATIONS_COUPLED 2000
#define CHECK              20
#define MOVED              1e-5 /* in CHECK iterations; it goes on to about five times that */
#define STIFF              30
#define STIFF_ITERATIONS   30
#define OPTIMAL            8e-7
#define STRIPE             4096 /* vertices whose rows one thread projects */

/* R, its root and the factor of Q + R. */
typedef struct {
    double *metric, *root;
    bounded_factor factor;
} metric;

typedef struct {
    bounded_system *s;
    metric soft, stiff; /* stiff: of handles that sum to one */
    const metric *now;
    track *tracks; /* m */
    int block;     /* columns that are solved for together */
    int failed;
} approach;

static int blocks(approach *a)
{
    int halves = (a->s->m + 23) / 24 * 2; /* of up to 12, for two threads at least */
    a->block = (a->s->m + halves - 1) / halves;
    return (a->s->m + a->block - 1) / a->block;
}

/* right = R (2 z - y) - b */
static void load(const track *t, const double *r, const double *b, int n)
{
    for (int i = 0; i < n; i++) {
        t->x[i] = r[i] * (2 * t->w[i] - t->y[i]) - b[i];
    }
}

/* ---- handles alone ---------------------------------------------------------------------------- */

static void clamp(const double *y, int n, double *w)
{
    for (int i = 0; i < n; i++) {
        w[i] = fmin(fmax(y[i], 0), 1);
    }
}

/* What a block of columns needs besides its tracks. */
typedef struct {
    history past;
    double first; /* |x - z|^2 of the first iteration */
    int arrived;
} column;

static void advance(approach *a, int j, column *c)
{
    track *t = &a->tracks[j];
    bounded_track_measure(t, a->now->root, a->s->n);
    c->first = c->first > 0 ? c->first : t->norm;
    c->arrived = t->norm <= ARRIVED * ARRIVED * c->first;
    history_begin(&c->past, t, 1);
    bounded_track_push(t, a->now->root, a->s->n, &c->past);
    history_mix(&c->past, t, 1);
    bounded_track_add(t, a->s->n, &c->past);
}

/* One iteration of the columns that have not arrived. Returns how many there were. */
static int iterate(approach *a, const int range[2], column *c, double *x, bounded_desk *desk)
{
    const bounded_system *s = a->s;
    size_t n = (size_t)s->n;
    int count = 0;
    for (int j = range[0]; j < range[1]; j++) {
        track *t = &a->tracks[j];
        clamp(t->y, s->n, t->w);
        if (!c[j - range[0]].arrived) {
            t->x = x + n * (size_t)count++;
            load(t, a->now->metric, s->b + n * (size_t)j, s->n);
        }
    }
    if (bounded_factor_solve(desk, &a->now->factor, x, count) < 0) {
        a->failed = 1;
        return 0;
    }
    for (int j = range[0]; j < range[1]; j++) {
        if (!c[j - range[0]].arrived) {
            advance(a, j, &c[j - range[0]]);
        }
    }
    return count;
}

/* A block of columns from beginning to end. */
static void run_block(void *context, int item, bounded_desk *desk)
{
    approach *a = context;
    size_t n = (size_t)a->s->n;
    int first = item * a->block, last = first + a->block;
    const int range[2] = {first, last < a->s->m ? last : a->s->m};
    double *x = bake_alloc(n * (size_t)a->block, sizeof *x);
    column *c = bake_alloc((size_t)a->block, sizeof *c);
    for (int j = range[0]; j < range[1]; j++) {
        history_make(&c[j - first].past);
        bounded_track_make(&a->tracks[j], n);
    }
    for (int i = 0, left = 1; i < ITERATIONS_ALONE && left; i++) {
        left = iterate(a, range, c, x, desk);
    }
    for (int j = range[0]; j < range[1]; j++) {
        clamp(a->tracks[j].y, a->s->n, a->tracks[j].w);
        bounded_track_free(&a->tracks[j]);
    }
    free(x);
    free(c);
}

static int run_alone(approach *a)
{
    const bounded_work work = {run_block, a};
    bounded_each(a->s, blocks(a), &work);
    return a->failed ? -1 : 0;
}

/* ---- handles that sum to one ------------------------------------------------------------------ */

/* The nearest row that is not negative and sums to 1: what is above a level that rises as handles drop
 * out [Michelot 1986]. */
static void project_row(const double *y, size_t n, size_t m, double *w)
{
    double level = -HUGE_VAL;
    for (size_t k = 0, before = m + 1; k <= m; k++) {
        double sum = 0;
        size_t count = 0;
        for (size_t j = 0; j < m; j++) {
            if (y[n * j] > level) {
                sum += y[n * j];
                count++;
            }
        }
        if (count == before) {
            break;
        }
        before = count;
        level = (sum - 1) / (double)count;
    }
    for (size_t j = 0; j < m; j++) {
        w[n * j] = fmax(y[n * j] - level, 0);
    }
}

typedef struct {
    approach *a;
    history past;
} couple;

static void run_stripe(void *context, int item, bounded_desk *desk)
{
    const approach *a = ((couple *)context)->a;
    int last = (item + 1) * STRIPE < a->s->n ? (item + 1) * STRIPE : a->s->n;
    (void)desk;
    for (int i = item * STRIPE; i < last; i++) {
        project_row(a->tracks[0].y + i, (size_t)a->s->n, (size_t)a->s->m, a->tracks[0].w + i);
    }
}

static void run_solve(void *context, int item, bounded_desk *desk)
{
    approach *a = ((couple *)context)->a;
    const bounded_system *s = a->s;
    int first = item * a->block, last = first + a->block < s->m ? first + a->block : s->m;
    for (int j = first; j < last; j++) {
        load(&a->tracks[j], a->now->metric, s->b + (size_t)s->n * (size_t)j, s->n);
    }
    if (bounded_factor_solve(desk, &a->now->factor, a->tracks[first].x, last - first) < 0) {
        a->failed = 1;
    }
    for (int j = first; j < last; j++) {
        bounded_track_measure(&a->tracks[j], a->now->root, s->n);
    }
}

static void run_push(void *context, int item, bounded_desk *desk)
{
    couple *c = context;
    (void)desk;
    bounded_track_push(&c->a->tracks[item], c->a->now->root, c->a->s->n, &c->past);
}

static void run_add(void *context, int item, bounded_desk *desk)
{
    couple *c = context;
    (void)desk;
    bounded_track_add(&c->a->tracks[item], c->a->s->n, &c->past);
}

/* The farthest that a weight has moved since the last time. */
static double moved(const approach *a, double *before)
{
    size_t size = (size_t)a->s->n * (size_t)a->s->m;
    const double *w = a->tracks[0].w;
    double most = 0;
    for (size_t i = 0; i < size; i++) {
        most = fmax(most, fabs(w[i] - before[i]));
    }
    memcpy(before, w, size * sizeof *w);
    return most;
}

static int optimal(const approach *a)
{
    bounded_report *r = bake_alloc((size_t)a->s->m, sizeof *r);
    double worst = 0;
    bounded_judge(a->s, BOUNDED_COUPLED, a->tracks[0].w, r);
    for (int j = 0; j < a->s->m; j++) {
        worst = fmax(worst, fmax(r[j].stationarity, r[j].dual));
    }
    free(r);
    return worst <= OPTIMAL;
}

/* The other metric; multipliers R (y - z) stay as they are. */
static void change(approach *a)
{
    int stiff = a->now == &a->soft;
    double part = stiff ? 1.0 / STIFF : STIFF;
    for (int j = 0; j < a->s->m; j++) {
        track *t = &a->tracks[j];
        for (int i = 0; i < a->s->n; i++) {
            t->y[i] = t->w[i] + part * (t->y[i] - t->w[i]);
        }
    }
    a->now = stiff ? &a->stiff : &a->soft;
}

/* Until weights hardly move by the soft metric, then some iterations by the stiff one, and again unless
 * that is optimal. project, solve, push, add: what an iteration consists of. */
static void alternate(approach *a, couple *c, const bounded_work work[4], double *before)
{
    bounded_system *s = a->s;
    int stripes = (s->n + STRIPE - 1) / STRIPE, parts = blocks(a);
    for (int i = 0, since = 0; i < ITERATIONS_COUPLED && !a->failed; i++, since++) {
        int soft = a->now == &a->soft, last = 0;
        bounded_each(s, stripes, &work[0]);
        if (soft && since && since % CHECK == 0) {
            last = moved(a, before) <= MOVED;
        } else if (!soft && since == STIFF_ITERATIONS) {
            last = 1;
            if (optimal(a)) {
                break;
            }
        }
        if (last) {
            change(a);
            history_make(&c->past);
            since = 0;
        }
        bounded_each(s, parts, &work[1]);
        history_begin(&c->past, a->tracks, s->m);
        bounded_each(s, s->m, &work[2]);
        history_mix(&c->past, a->tracks, s->m);
        bounded_each(s, s->m, &work[3]);
    }
}

static int run_coupled(approach *a)
{
    bounded_system *s = a->s;
    size_t n = (size_t)s->n, m = (size_t)s->m;
    double *x = bake_alloc(n * m, sizeof *x), *before = bake_alloc(n * m, sizeof *before);
    couple c = {.a = a};
    const bounded_work work[4] = {{run_stripe, &c}, {run_solve, &c}, {run_push, &c}, {run_add, &c}};
    history_make(&c.past);
    for (size_t j = 0; j < m; j++) {
        bounded_track_make(&a->tracks[j], n);
        a->tracks[j].x = x + n * j;
    }
    alternate(a, &c, work, before);
    for (size_t j = 0; j < m; j++) {
        bounded_track_free(&a->tracks[j]);
    }
    free(x);
    free(before);
    return a->failed ? -1 : 0;
}

/* ---- from nothing ----------------------------------------------------------------------------- */

/* y = -Q^-1 b: without bounds */
static int start(bounded_system *s, double *y)
{
    size_t size = (size_t)s->n * (size_t)s->m;
    bounded_factor f;
    int result = bounded_factor_make(s->desk, s, NULL, NULL, &f);
    if (result == 0) {
        for (size_t i = 0; i < size; i++) {
            y[i] = -s->b[i];
        }
        result = bounded_factor_solve(s->desk, &f, y, s->m);
    }
    if (result == 0) {
        result = bounded_metric(s->desk, s, &f);
    }
    bounded_factor_free(s->desk, &f);
    return result;
}

static int metric_make(bounded_system *s, double scale, metric *out)
{
    size_t n = (size_t)s->n;
    out->metric = bake_alloc(n, sizeof *out->metric);
    out->root = bake_alloc(n, sizeof *out->root);
    for (size_t i = 0; i < n; i++) {
        out->metric[i] = scale * s->metric[i];
        out->root[i] = sqrt(out->metric[i]);
    }
    return bounded_factor_make(s->desk, s, NULL, out->metric, &out->factor);
}

static void metric_free(bounded_system *s, metric *m)
{
    bounded_factor_free(s->desk, &m->factor);
    free(m->metric);
    free(m->root);
}

int bounded_approach(bounded_system *s, int coupled, double *w, bake_error *error)
{
    size_t n = (size_t)s->n, m = (size_t)s->m;
    double *y = bake_alloc(n * m, sizeof *y);
    approach a = {.s = s, .now = &a.soft};
    int result = start(s, y);
    if (result == 0) {
        result = metric_make(s, 1, &a.soft);
    }
    if (result == 0 && coupled) {
        result = metric_make(s, STIFF, &a.stiff);
    }
    if (result == 0) {
        a.tracks = bake_alloc(m, sizeof *a.tracks);
        for (size_t j = 0; j < m; j++) {
            clamp(y + n * j, s->n, y + n * j);
            a.tracks[j].y = y + n * j;
            a.tracks[j].w = w + n * j;
        }
        result = coupled ? run_coupled(&a) : run_alone(&a);
    }
    metric_free(s, &a.soft);
    metric_free(s, &a.stiff);
    free(a.tracks);
    free(y);
    return result == 0 ? 0 : bounded_no_factor(s, result, error);
}
