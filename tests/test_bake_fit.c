/* The player against exact curves: every family of a wiggly spline, plain keys, hard cases.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"
#include "spline_random.h"

#include <stdlib.h>
#include <string.h>

#define RATE       1000
#define FAMILIES   6
#define RATIOS_MAX 20000

/* What came of the curve segments of one family. */
typedef struct {
    int segments, waves, bytes;
    double ratio[RATIOS_MAX]; /* largest error over tolerance, a segment */
} tally;

static tally tallies[FAMILIES];
static int curves, unsolved, refused, over;

typedef struct {
    double range, largest; /* largest minus smallest, largest magnitude */
} extent;

static extent extent_of(const bake_curve *curve)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < curve->count; i++)
        for (int k = 0; k <= 64; k++) {
            double out[4];
            const bake_segment *s = &curve->segment[i];
            bake_segment_eval(s, s->t0 + (s->t1 - s->t0) * k / 64, out);
            low = fmin(low, out[0]);
            high = fmax(high, out[0]);
        }
    return (extent){high - low, fmax(fabs(low), fabs(high))};
}

/* The baker's choices: 20 bits for the range, less for what is far from 0; tolerance 2^-13. */
static fit_problem problem_for(const bake_curve *curve, const bake_mode *mode, scene_curve_kind kind, int ticks)
{
    extent e = extent_of(curve);
    double range = e.range > 0 ? e.range : fmax(1e-6, e.largest);
    int frac = (int)floor(20 - log2(range));
    while (frac > -30 && ldexp(e.largest, frac) > ldexp(1, 27))
        frac--;
    return (fit_problem){.curve = curve,
                         .mode = mode,
                         .kind = kind,
                         .rate = RATE,
                         .ticks = ticks,
                         .frac = frac > 30 ? 30 : frac,
                         .tolerance = range / 8192};
}

/* Largest |played - exact| over ticks [first, last], at each quarter tick of the player's grid. */
static double played_error(const fit_problem *p, const replay *r, int first, int last)
{
    double worst = 0;
    for (int i = 4 * first; i < 4 * last; i++) {
        uint32_t position = (uint32_t)i << 14;
        double value, slope;
        fit_truth(p, i / 4.0, &value, &slope);
        worst = fmax(worst, fabs(ldexp(replay_value(r, position), -p->frac) - value));
    }
    return worst;
}

/* Bytes of `track` that lie in [first, last): segments, and runs that begin there. */
static int bytes_between(const bake_track *track, int first, int last, int *waves)
{
    int total = 0;
    *waves = 0;
    for (int i = 0; i < track->count; i++) {
        const track_run *run = &track->run[i];
        int wave = run->kind > (int)WG_KIND_CUBIC;
        if (run->start >= first && run->start < last)
            total += 20 + (wave ? 4 * run->param_count : 4);
        for (int k = 0, start = run->start; k < run->segments; start = run->end[k++])
            if (start >= first && start < last) {
                total += wave ? 10 : 6;
                *waves |= wave;
            }
    }
    return total;
}

static void count_segments(const fit_problem *p, const bake_track *track)
{
    replay r;
    replay_open(&r, track);
    for (int i = 0; i < p->curve->count; i++) {
        const bake_segment *s = &p->curve->segment[i];
        tally *t = &tallies[s->family];
        int first = (int)lround(s->t0 * p->rate), last = (int)lround(s->t1 * p->rate), wave;
        double ratio = played_error(p, &r, first, last) / p->tolerance;
        t->bytes += bytes_between(track, first, last, &wave);
        t->waves += wave;
        if (t->segments < RATIOS_MAX)
            t->ratio[t->segments++] = ratio;
        over += ratio > 1;
    }
    replay_close(&r);
}

static void sweep_one(const bake_spline_problem *problem, const bake_key *keys, int count)
{
    bake_curve curve;
    bake_error error = {""};
    if (bake_spline_solve(problem, keys, count, &curve, NULL, &error) < 0 || error.text[0]) {
        unsolved++; /* resonant keys: the solver says so, test_bake_spline looks at that */
        bake_curve_free(&curve);
        return;
    }
    int ticks = (int)lround(curve.segment[curve.count - 1].t1 * RATE);
    fit_problem p = problem_for(&curve, &problem->mode, CURVE_WIGGLY, ticks);
    bake_track track;
    curves++;
    if (fit_track(&p, &track, &error) < 0) {
        if (refused++ < 5)
            printf("refused: lambda %g delta %g: %s\n", problem->mode.lambda, problem->mode.delta,
                   error.text);
    } else {
        count_segments(&p, &track);
        track_free(&track);
    }
    bake_curve_free(&curve);
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_tallies(void)
{
    static const char *const name[FAMILIES] = {"POLY", "OSC", "CRIT", "EXP", "HYP", "SERIES"};
    printf("%d curves, %d not solved, %d refused\n", curves, unsolved, refused);
    printf("family  segments  waves  bytes/segment  error/tolerance: median  95%%   largest\n");
    for (int i = 0; i < FAMILIES; i++) {
        tally *t = &tallies[i];
        if (t->segments == 0)
            continue;
        qsort(t->ratio, (size_t)t->segments, sizeof *t->ratio, compare);
        printf("%-7s %8d %6d %10.1f %28.3f %6.3f %6.3f\n", name[i], t->segments, t->waves,
               (double)t->bytes / t->segments, t->ratio[t->segments / 2],
               t->ratio[t->segments * 95 / 100], t->ratio[t->segments - 1]);
    }
}

/* Keys of a curve: 2 to 8 of them, 0.1 to 0.9 s apart. */
static int irregular_keys(bake_key *keys)
{
    int count = (int)uniform(2, 8.999);
    double t = 0;
    for (int k = 0; k < count; k++) {
        keys[k] = (bake_key){.time = t, .target = {uniform(-1, 1)}, .weight = {BAKE_HARD}};
        t = floor((t + uniform(0.1, 0.9)) * RATE + 0.5) / RATE;
    }
    return count;
}

static const double ROOTS[] = {0.1, 0.2, 0.5, 1, 2, 3.5, 5, 8, 13, 20, 33, 50, 100};
static const double DAMPINGS[] = {0,     0.01,  0.1,    0.3, 0.7,    0.9,   0.95,  0.98,  0.99,
                                  0.995, 0.999, 0.9999, 1,   1.0001, 1.001, 1.002, 1.005, 1.01,
                                  1.02,  1.05,  1.1,    1.3, 2,      5,     20};

/* sqrt(|lambda|) h from 0.1 to 100 (h = 0.5 s on average), damping ratio 0 to 20, both signs of
 * lambda, with and without a constant force. */
static void waves_stay_within_tolerance_for_every_mode(void)
{
    bake_key keys[KEYS];
    int rounds = 2;
    for (size_t i = 0; i < sizeof ROOTS / sizeof *ROOTS; i++)
        for (size_t j = 0; j < sizeof DAMPINGS / sizeof *DAMPINGS; j++)
            for (int k = 0; k < 3 * rounds; k++) {
                double root = ROOTS[i] / 0.5;
                bake_spline_problem problem = clamped;
                problem.mode.lambda = (k % 3 == 2 ? -1 : 1) * root * root;
                problem.mode.delta = DAMPINGS[j] * root;
                problem.mode.g = k % 3 == 1 ? uniform(-3, 3) * root * root : 0;
                sweep_one(&problem, keys, irregular_keys(keys));
            }
}

static void waves_stay_within_tolerance_without_stiffness(void)
{
    static const double deltas[] = {0, 0.1, 1, 3, 10, 100};
    bake_key keys[KEYS];
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 20; k++) {
            bake_spline_problem problem = clamped;
            problem.mode.delta = deltas[i];
            problem.mode.g = k & 1 ? uniform(-3, 3) : 0;
            sweep_one(&problem, keys, irregular_keys(keys));
        }
}

int main(void)
{
    TEST(waves_stay_within_tolerance_for_every_mode);
    TEST(waves_stay_within_tolerance_without_stiffness);
    print_tallies();
    printf("over %d\n", over);
    return check_done();
}
