/* Weights near the exact ones, all handles at once: the alternating direction
 * method of multipliers, as one map of one variable y, whose fixed point is
 * extrapolated. z = P y              nearest allowed weights x = (Q + R)^-1 (R
 * (2 z - y) - b) y <- y + 1.6 (x - z) R = 0.3 / diag(Q^-1): what a vertex alone
 * resists. With R = 0.1 diag(Q), which slivers make stiff, 60 iterations left
 * weights of a hand of 8,382 vertices wrong by 0.14; with this one by 0.016,
 * and extrapolated by 5e-4. Source: Boyd et al. 2011; Walker and Ni 2011
 * (extrapolation); the metric is own.
 *
 *   Y, W  n x m                    y and z, column by column
 *   S, C  n x HISTORY, a column    differences of y + 1.6 (x - z), and of
 * sqrt(R) (x - z) SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define HISTORY            8
#define RELAXATION         1.6
/* Handles alone are made exact afterwards. 40, 60, 80 and 100 iterations and
 * what follows cost about the same from 60 on. */
#define ITERATIONS_ALONE   80
/* Handles together are not: they end when the residual is as asked for, looked at now and then. */
#define ITERATIONS_COUPLED 4000
#define LOOK               25
#define RESIDUAL_COUPLED   5e-7
/* x - z, in units of weight: far below what is asked for. */
#define NEAR               1e-7

/* The past of one column. */
typedef struct {
    double *S, *C;
    double *plain, *residual; /* y + 1.6 (x - z) and sqrt(R) (x - z) of the last iteration */
    double *best;             /* plain of the smallest residual since the last reset */
    double *y, *w, *x;
    double *right;             /* R (2 z - y) - b, then x */
    double norm, dot[HISTORY]; /* |residual|^2; residual^T C */
    double row[HISTORY];       /* the newest column of C times C */
    double far;                /* largest |x - z| */
} track;

/* Columns that are extrapolated as one. */
typedef struct {
    int count, newest; /* differences so far, the slot of the last one */
    int fresh;         /* 1: no last iteration to take a difference from */
    double gram[HISTORY][HISTORY], mix[HISTORY];
    double best;
} history;

typedef struct {
    const bounded_system *s;
    bounded_factor factor; /* of Q + R */
    double *root;          /* sqrt(R) */
    track *track;          /* m */
    int block;             /* columns that are solved for together */
    int failed;
} approach;

/* ---- extrapolation
 * ----------------------------------------------------------------------------
 */

static void track_make(track *t, size_t n)
{
    t->S = bake_alloc(n * HISTORY, sizeof *t->S);
    t->C = bake_alloc(n * HISTORY, sizeof *t->C);
    t->plain = bake_alloc(n, sizeof *t->plain);
    t->residual = bake_alloc(n, sizeof *t->residual);
    t->best = bake_alloc(n, sizeof *t->best);
}

static void track_free(track *t)
{
    free(t->S);
    free(t->C);
    free(t->plain);
    free(t->residual);
    free(t->best);
}

static void track_measure(track *t, const double *root, int n)
{
    t->norm = t->far = 0;
    for (int i = 0; i < n; i++) {
        double f = t->x[i] - t->w[i], scaled = root[i] * f;
        t->norm += scaled * scaled;
        t->far = fmax(t->far, fabs(f));
    }
}

/* Takes the iteration into the history; y becomes the plain step. */
static void track_push(track *t, const double *root, int n, const history *h)
{
    double *S = t->S + (size_t)h->newest * (size_t)n, *C = t->C + (size_t)h->newest * (size_t)n;
    for (int i = 0; i < n; i++) {
        double f = t->x[i] - t->w[i], step = t->y[i] + RELAXATION * f;
        if (!h->fresh) {
            S[i] = step - t->plain[i];
            C[i] = root[i] * f - t->residual[i];
        }
        t->plain[i] = t->y[i] = step;
        t->residual[i] = root[i] * f;
    }
    int count = h->count < HISTORY ? h->count : HISTORY;
    for (int k = 0; k < count; k++) {
        const double *other = t->C + (size_t)k * (size_t)n;
        t->row[k] = cblas_ddot(n, C, 1, other, 1);
        t->dot[k] = cblas_ddot(n, t->residual, 1, other, 1);
    }
}

/* The mix of past steps whose residual is least. Returns how many. */
static int history_mix(history *h, const track *tracks, int columns)
{
    double gram[HISTORY * HISTORY];
    int count = h->count < HISTORY ? h->count : HISTORY;
    memset(h->mix, 0, sizeof h->mix);
    for (int k = 0; k < count; k++) {
        double sum = 0;
        for (int j = 0; j < columns; j++) {
            sum += tracks[j].row[k];
            h->mix[k] += tracks[j].dot[k];
        }
        h->gram[k][h->newest] = h->gram[h->newest][k] = sum;
    }
    for (int k = 0; k < count; k++) {
        for (int l = 0; l < count;
             l++) { /* 1e-10: nearly dependent columns are no reason to fail */
            gram[k * count + l] = h->gram[k][l] * (k == l ? 1 + 1e-10 : 1);
        }
    }
    if (count && LAPACKE_dposv(LAPACK_COL_MAJOR, 'L', count, 1, gram, count, h->mix, count) != 0) {
        h->count = count = 0;
    }
    return count;
}

/* From x to the next y. A residual that has doubled: back to the best step, and
 * a new history. */
static void advance(track *tracks, int columns, const approach *a, history *h)
{
    int n = a->s->n;
    double norm = 0;
    for (int j = 0; j < columns; j++) {
        track_measure(&tracks[j], a->root, n);
        norm += tracks[j].norm;
    }
    if (norm > 4 * h->best && h->count > 0) {
        for (int j = 0; j < columns; j++) {
            memcpy(tracks[j].y, tracks[j].best, (size_t)n * sizeof(double));
        }
        *h = (history){.fresh = 1, .best = HUGE_VAL};
        return;
    }
    if (!h->fresh) {
        h->newest = h->count++ % HISTORY;
    }
    for (int j = 0; j < columns; j++) {
        track_push(&tracks[j], a->root, n, h);
        if (norm < h->best) {
            memcpy(tracks[j].best, tracks[j].plain, (size_t)n * sizeof(double));
        }
    }
    h->best = fmin(h->best, norm);
    h->fresh = 0;
    int count = history_mix(h, tracks, columns);
    for (int j = 0; j < columns; j++) {
        for (int k = 0; k < count; k++) {
            cblas_daxpy(n, -h->mix[k], tracks[j].S + (size_t)k * (size_t)n, 1, tracks[j].y, 1);
        }
    }
}

/* ---- handles alone
 * ----------------------------------------------------------------------------
 */

static void clamp(const double *y, int n, double *w)
{
    for (int i = 0; i < n; i++) {
        w[i] = fmin(fmax(y[i], 0), 1);
    }
}

/* right = R (2 z - y) - b */
static void load(const track *t, const double *metric, const double *b, int n)
{
    for (int i = 0; i < n; i++) {
        t->right[i] = metric[i] * (2 * t->w[i] - t->y[i]) - b[i];
    }
}

/* A block of columns from beginning to end; those that have arrived drop out.
 */
static void run_block(void *context, int item, bounded_desk *desk)
{
    approach *a = context;
    const bounded_system *s = a->s;
    size_t n = (size_t)s->n;
    int first = item * a->block, last = first + a->block < s->m ? first + a->block : s->m;
    double *x = bake_alloc(n * (size_t)a->block, sizeof *x);
    history *h = bake_alloc((size_t)a->block, sizeof *h);
    for (int j = first; j < last; j++) {
        h[j - first] = (history){.fresh = 1, .best = HUGE_VAL};
        track_make(&a->track[j], n);
    }
    for (int i = 0, left = last - first; i < ITERATIONS_ALONE && left && !a->failed; i++) {
        int count = 0;
        for (int j = first; j < last; j++) {
            track *t = &a->track[j];
            clamp(t->y, s->n, t->w);
            if (t->far > NEAR) {
                t->x = t->right = x + n * (size_t)count++;
                load(t, s->metric, s->b + n * (size_t)j, s->n);
            }
        }
        if (bounded_factor_solve(desk, &a->factor, x, count) < 0) {
            a->failed = 1;
        }
        for (int j = first; j < last; j++) {
            if (a->track[j].far > NEAR) {
                advance(&a->track[j], 1, a, &h[j - first]);
            }
        }
        left = count;
    }
    for (int j = first; j < last; j++) {
        clamp(a->track[j].y, s->n, a->track[j].w);
        track_free(&a->track[j]);
    }
    free(x);
    free(h);
}

static int run_alone(approach *a)
{
    int halves = (a->s->m + 23) / 24 * 2; /* blocks of up to 12, for two threads at least */
    a->block = (a->s->m + halves - 1) / halves;
    const bounded_work work = {run_block, a};
    for (int j = 0; j < a->s->m; j++) {
        a->track[j].far = HUGE_VAL;
    }
    bounded_each(a->s->threads, (a->s->m + a->block - 1) / a->block, &work);
    return a->failed ? -1 : 0;
}

/* ---- handles that sum to one
 * ------------------------------------------------------------------ */

/* The nearest row that is not negative and sums to 1: what is above a water
 * level, which rises as handles drop out [Michelot 1986]. */
static void project_row(const double *y, size_t n, int m, double *w)
{
    double level = 0;
    int count = m, before = m + 1;
    for (int j = 0; j < m; j++) {
        w[n * (size_t)j] = y[n * (size_t)j];
        level += w[n * (size_t)j];
    }
    level = (level - 1) / m;
    while (count < before) { /* at most m times */
        double sum = 0;
        before = count;
        count = 0;
        for (int j = 0; j < m; j++) {
            if (y[n * (size_t)j] > level) {
                sum += y[n * (size_t)j];
                count++;
            }
        }
        level = (sum - 1) / count;
    }
    for (int j = 0; j < m; j++) {
        w[n * (size_t)j] = fmax(y[n * (size_t)j] - level, 0);
    }
}

static void solve_block(void *context, int item, bounded_desk *desk)
{
    approach *a = context;
    const bounded_system *s = a->s;
    size_t n = (size_t)s->n;
    int first = item * a->block, last = first + a->block < s->m ? first + a->block : s->m;
    for (int j = first; j < last; j++) {
        load(&a->track[j], s->metric, s->b + n * (size_t)j, s->n);
    }
    if (bounded_factor_solve(desk, &a->factor, a->track[first].right, last - first) < 0) {
        a->failed = 1;
    }
}

static int run_coupled(approach *a)
{
    const bounded_system *s = a->s;
    size_t n = (size_t)s->n;
    double *x = bake_alloc(n * (size_t)s->m, sizeof *x);
    history h = {.fresh = 1, .best = HUGE_VAL};
    const bounded_work work = {solve_block, a};
    int halves = (a->s->m + 23) / 24 * 2;
    a->block = (a->s->m + halves - 1) / halves;
    for (int j = 0; j < s->m; j++) {
        track_make(&a->track[j], n);
        a->track[j].x = a->track[j].right = x + n * (size_t)j;
    }
    for (int i = 0; i < ITERATIONS_COUPLED && !a->failed; i++) {
        for (size_t v = 0; v < n; v++) {
            project_row(a->track[0].y + v, n, s->m, a->track[0].w + v);
        }
        if (i % LOOK == 0 && bounded_coupled_residual(s, a->track[0].w) < RESIDUAL_COUPLED) {
            break;
        }
        bounded_each(s->threads, (s->m + a->block - 1) / a->block, &work);
        advance(a->track, s->m, a, &h);
    }
    for (size_t v = 0; v < n; v++) {
        project_row(a->track[0].y + v, n, s->m, a->track[0].w + v);
    }
    for (int j = 0; j < s->m; j++) {
        track_free(&a->track[j]);
    }
    free(x);
    return a->failed ? -1 : 0;
}

/* ---- from nothing
 * -----------------------------------------------------------------------------
 */

/* y = -Q^-1 b: without bounds */
static int start(bounded_desk *desk, bounded_system *s, double *y)
{
    size_t size = (size_t)s->n * (size_t)s->m;
    bounded_factor f;
    int result = bounded_factor_make(desk, s, NULL, NULL, &f);
    if (result == 0) {
        for (size_t i = 0; i < size; i++) {
            y[i] = -s->b[i];
        }
        result = bounded_factor_solve(desk, &f, y, s->m);
    }
    if (result == 0) {
        result = bounded_metric(desk, s, &f);
    }
    bounded_factor_free(desk, &f);
    return result;
}

int bounded_approach(bounded_system *s, int coupled, double *w, bake_error *error)
{
    size_t n = (size_t)s->n;
    double *y = bake_alloc(n * (size_t)s->m, sizeof *y);
    approach a = {.s = s};
    bounded_desk desk;
    bounded_desk_make(&desk);
    int result = start(&desk, s, y);
    if (result == 0) {
        result = bounded_factor_make(&desk, s, NULL, s->metric, &a.factor);
    }
    if (result == 0) {
        a.root = bake_alloc(n, sizeof *a.root);
        a.track = bake_alloc((size_t)s->m, sizeof *a.track);
        for (size_t i = 0; i < n; i++) {
            a.root[i] = sqrt(s->metric[i]);
        }
        for (size_t j = 0; j < (size_t)s->m; j++) {
            clamp(y + n * j, s->n, y + n * j);
            a.track[j].y = y + n * j;
            a.track[j].w = w + n * j;
        }
        result = coupled ? run_coupled(&a) : run_alone(&a);
    }
    bounded_factor_free(&desk, &a.factor);
    bounded_desk_free(&desk);
    free(a.root);
    free(a.track);
    free(y);
    return result == 0 ? 0 : bounded_no_factor(s, result, error);
}
