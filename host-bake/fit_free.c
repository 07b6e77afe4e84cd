/* Few cubic Hermite pieces for a curve that has no knots to keep: places, values and slopes are
 * free. Source: own. Knots are laid so that a free cubic on each piece misses by the same share of
 * the tolerance; all values and slopes follow by least squares, reweighted towards the smallest
 * largest error [Lawson 1961]; the largest share that still ends within the tolerance is found by
 * bisection. That share is bound by the worst place of the curve: elsewhere single knots are then
 * taken out.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PER_TICK    4  /* looks a tick ... */
#define LOOKS_MOST  64 /* ... but of a long piece this many */
#define REWEIGHTS   60
#define HOPELESS    2.5 /* times the limit after a few rounds: reweighting gains less than that */
#define TRIMS       2
#define PROBES      9 /* of the bisection: the share is known to 1 in 2^9 of log(30) */
#define LEAST_SHARE 0.06
#define MOST_SHARE  1.8
#define TIE         1e8
#define PIN         1e4 /* weight of the two ends, so that a loop's seam has no step */

/* The curve at every quarter tick of [first, last]. */
typedef struct {
    int first, last;
    double limit;
    double *truth;
} looks;

static double at(const looks *l, int quarter)
{
    return l->truth[quarter - PER_TICK * l->first];
}

/* Look i at a piece from tick a, h ticks long, in quarter ticks; -1 beyond the last, which is its
 * end. */
static int look_at(int a, int h, int i)
{
    int n = PER_TICK * h < LOOKS_MOST ? PER_TICK * h : LOOKS_MOST;
    return i <= n ? PER_TICK * a + PER_TICK * h * i / n : -1;
}

/* Cholesky of a 4 x 4 system, in place. Returns 0 when it is not positive. */
static int solve4(double A[4][4], double x[4])
{
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j <= i; j++) {
            double s = A[i][j];
            for (int k = 0; k < j; k++) {
                s -= A[i][k] * A[j][k];
            }
            if (i == j && s <= 1e-14) {
                return 0;
            }
            A[i][j] = i == j ? sqrt(s) : s / A[j][j];
        }
        for (int k = 0; k < i; k++) {
            x[i] -= A[i][k] * x[k];
        }
        x[i] /= A[i][i];
    }
    for (int i = 3; i >= 0; i--) {
        for (int k = i + 1; k < 4; k++) {
            x[i] -= A[k][i] * x[k];
        }
        x[i] /= A[i][i];
    }
    return 1;
}

/* Largest error of the cubic that fits [a, b] ticks best by least squares, alone. */
static double lone_error(const looks *l, int a, int b)
{
    double A[4][4] = {{0}}, x[4] = {0}, worst = 0, h = b - a, f[4];
    for (int n = 0, q; (q = look_at(a, b - a, n)) >= 0; n++) {
        fit_hermite((q / (double)PER_TICK - a) / h, 1, f);
        for (int i = 0; i < 4; i++) {
            x[i] += f[i] * at(l, q);
            for (int j = 0; j <= i; j++) {
                A[i][j] += f[i] * f[j];
            }
        }
    }
    if (!solve4(A, x)) {
        return 0; /* fewer than four looks: a cubic passes through them */
    }
    for (int n = 0, q; (q = look_at(a, b - a, n)) >= 0; n++) {
        fit_hermite((q / (double)PER_TICK - a) / h, 1, f);
        worst = fmax(worst, fabs(f[0] * x[0] + f[1] * x[1] + f[2] * x[2] + f[3] * x[3] - at(l, q)));
    }
    return worst;
}

/* The longest piece from `first` whose lone cubic misses by at most `limit`. */
static int reach(const looks *l, int first, double limit)
{
    int good = 1, step = 1;
    while (first + good + step <= l->last && lone_error(l, first, first + good + step) <= limit) {
        good += step;
        step *= 2;
    }
    for (; step > 0; step /= 2) {
        if (first + good + step <= l->last && lone_error(l, first, first + good + step) <= limit) {
            good += step;
        }
    }
    return first + good < l->last ? good : l->last - first;
}

/* Knots of equal difficulty; gives up beyond `most` pieces. */
static int lay(const looks *l, double share, int most, fit_knots *k)
{
    memset(k, 0, sizeof *k);
    fit_knots_add(k, l->first, 0, 0);
    for (int tick = l->first; tick < l->last;) {
        if (k->count > most) {
            return -1;
        }
        tick += reach(l, tick, share * l->limit);
        fit_knots_add(k, tick, 0, 0);
    }
    return k->count - 1 <= most ? 0 : -1;
}

/* Adds one look at piece j with unknowns (v, h m) of its two knots to the banded normal equations
 * (LAPACK upper band storage, 3 superdiagonals, column-major, row 3 = diagonal). */
static void add_look(double *band, double *rhs, int j, const double f[4], double value)
{
    for (int r = 0; r < 4; r++) {
        rhs[2 * j + r] += f[r] * value;
        for (int c = r; c < 4; c++) {
            band[(2 * j + c) * 4 + 3 - (c - r)] += f[r] * f[c];
        }
    }
}

/* Look n of piece j with the four weights of its knots there; -1 beyond the last one. */
static int look(const fit_knots *k, int j, int n, double f[4])
{
    int h = k->tick[j + 1] - k->tick[j], q = look_at(k->tick[j], h, n);
    fit_hermite((q / (double)PER_TICK - k->tick[j]) / h, h, f);
    return q;
}

/* Ties both end knots to what they are. */
static void tie_ends(const fit_knots *k, double *band, double *x)
{
    int last = k->count - 1, h = k->tick[last] - k->tick[0];
    for (int end = 0; end < 2; end++) {
        int j = end ? last : 0;
        double v = TIE, m = TIE * h * h;
        band[4 * (2 * j) + 3] += v;
        band[4 * (2 * j + 1) + 3] += m;
        x[2 * j] += v * k->value[j];
        x[2 * j + 1] += m * k->slope[j];
    }
}

/* Weighted least squares for all values and slopes; a window's ends stay (`tied`). */
static int solve_all(const looks *l, fit_knots *k, int tied, const double *weight, double *work)
{
    int n = 2 * k->count, i = 0;
    double f[4], *band = work, *x = work + 4 * n;
    memset(band, 0, (size_t)n * 4 * sizeof *band);
    memset(x, 0, (size_t)n * sizeof *x);
    for (int j = 0; j + 1 < k->count; j++) {
        for (int q, m = 0; (q = look(k, j, m, f)) >= 0; m++, i++) {
            double root = sqrt(weight[i]);
            for (int c = 0; c < 4; c++) {
                f[c] *= root;
            }
            add_look(band, x, j, f, root * at(l, q));
        }
    }
    if (tied) {
        tie_ends(k, band, x);
    }
    for (int j = 0; j < n; j++) { /* a piece of one tick leaves slopes open */
        band[4 * j + 3] *= 1 + 1e-13;
    }
    if (LAPACKE_dpbsv(LAPACK_COL_MAJOR, 'U', n, 3, 1, band, 4, x, n) != 0) {
        return -1;
    }
    for (int j = tied; j < k->count - tied; j++) {
        k->value[j] = x[2 * j];
        k->slope[j] = x[2 * j + 1];
    }
    return 0;
}

/* Largest error; weights grow with each look's own. */
static double reweight(const looks *l, const fit_knots *k, double *weight, double *miss)
{
    double worst = 0, sum = 0, f[4];
    int i = 0;
    for (int j = 0; j + 1 < k->count; j++) {
        for (int q, m = 0; (q = look(k, j, m, f)) >= 0; m++, i++) {
            miss[i] = fabs(f[0] * k->value[j] + f[1] * k->slope[j] + f[2] * k->value[j + 1] +
                           f[3] * k->slope[j + 1] - at(l, q));
            worst = fmax(worst, miss[i]);
        }
    }
    for (int n = 0; n < i; n++) {
        weight[n] *= miss[n] / worst + 1e-3;
        sum += weight[n];
    }
    for (int n = 0; n < i; n++) {
        weight[n] = fmax(weight[n] * i / sum, 1e-6);
    }
    weight[0] = fmax(weight[0], PIN);
    weight[i - 1] = fmax(weight[i - 1], PIN);
    return worst;
}

/* Values and slopes for the knots; 0 when the largest error is within the limit. */
static int settle(const looks *l, fit_knots *k, int tied)
{
    size_t n = 2 * (size_t)k->count, room = 0;
    for (int j = 0; j + 1 < k->count; j++) {
        room += (size_t)(PER_TICK * (k->tick[j + 1] - k->tick[j])) + 2;
    }
    double *work = bake_alloc(5 * n, sizeof *work);
    double *weight = bake_alloc(room, sizeof *weight), *miss = bake_alloc(room, sizeof *miss);
    int err = -1;
    for (size_t i = 0; i < room; i++) {
        weight[i] = 1;
    }
    for (int round = 0; round < REWEIGHTS && err < 0; round++) {
        if (solve_all(l, k, tied, weight, work) < 0) {
            break;
        }
        double worst = reweight(l, k, weight, miss);
        err = worst <= l->limit ? 0 : -1;
        if (round >= 3 && worst > HOPELESS * l->limit) {
            break;
        }
    }
    free(work);
    free(weight);
    free(miss);
    return err;
}

/* The window of knots about j without j: its neighbours move a third of the way into the gap. */
#define WINDOW 4

static void cut(const fit_knots *k, int j, int a, int b, fit_knots *out)
{
    memset(out, 0, sizeof *out);
    for (int i = a; i <= b; i++) {
        int move = i == j - 1 && i > a ? 1 : i == j + 1 && i < b ? -1 : 0;
        int tick = k->tick[i] + (move ? (k->tick[j] - k->tick[i]) / 3 : 0);
        if (i != j) {
            fit_knots_add(out, tick, k->value[i], k->slope[i]);
        }
    }
}

/* Takes knot j out if the window about it still holds without. */
static int drop(const looks *l, fit_knots *k, int j)
{
    int a = j > WINDOW ? j - WINDOW : 0, b = j + WINDOW < k->count ? j + WINDOW : k->count - 1;
    fit_knots part;
    cut(k, j, a, b, &part);
    int err = settle(l, &part, 1);
    if (err == 0) {
        for (int i = 0; i < part.count; i++) {
            k->tick[a + i] = part.tick[i];
            k->value[a + i] = part.value[i];
            k->slope[a + i] = part.slope[i];
        }
        for (int i = b + 1; i < k->count; i++) {
            k->tick[i - 1] = k->tick[i];
            k->value[i - 1] = k->value[i];
            k->slope[i - 1] = k->slope[i];
        }
        k->count--;
    }
    fit_knots_free(&part);
    return err;
}

/* Each success leaves a knot less; a failure moves on. */
static void trim(const looks *l, fit_knots *k)
{
    for (int j = 1; j + 1 < k->count;) {
        j += drop(l, k, j) < 0;
    }
}

static void keep(fit_knots *best, fit_knots *found)
{
    fit_knots_free(best);
    *best = *found;
    memset(found, 0, sizeof *found);
}

int fit_knots_least(const fit_problem *p, int first, int last, int most, fit_knots *k)
{
    looks l = {first, last, p->tolerance, NULL};
    double low = log(LEAST_SHARE), high = log(MOST_SHARE);
    l.truth = bake_alloc((size_t)(PER_TICK * (last - first)) + 1, sizeof *l.truth);
    for (int q = PER_TICK * first; q <= PER_TICK * last; q++) {
        double slope;
        fit_truth(p, q / (double)PER_TICK, &l.truth[q - PER_TICK * first], &slope);
    }
    memset(k, 0, sizeof *k);
    for (int probe = 0; probe < PROBES; probe++) {
        fit_knots found;
        double share = probe == 0 ? low : (low + high) / 2;
        int laid = lay(&l, exp(share), most, &found);
        if (laid == 0 && settle(&l, &found, 0) == 0) {
            most = found.count - 2;
            keep(k, &found);
            low = share;
        } else if (laid < 0) {
            low = share; /* too many pieces: only larger shares can help */
        } else {
            high = share;
        }
        fit_knots_free(&found);
    }
    for (int pass = 0; pass < TRIMS && k->count > 2; pass++) {
        trim(&l, k);
    }
    free(l.truth);
    return k->count > 0 ? 0 : -1;
}
