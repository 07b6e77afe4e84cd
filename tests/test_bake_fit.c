/* The player against exact curves: every family of a wiggly spline, plain keys, hard cases.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"
#include "fit_measure.h"
#include "spline_random.h"

#include <stdlib.h>
#include <string.h>

#define FAMILIES   6
#define RATIOS_MAX 20000

/* What came of the curve segments of one family. */
typedef struct {
    int segments, waves, bytes;
    double ratio[RATIOS_MAX]; /* largest error over tolerance, a segment */
} tally;

static tally tallies[FAMILIES];
static int curves, unsolved, refused, over, rounds = 1;

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

/* sqrt(|lambda|) h from 0.1 to 100 (h = 0.5 s on average), damping ratio 0 to 20, both signs of
 * lambda, with and without a constant force. */
static void waves_stay_within_tolerance_for_every_mode(void)
{
    static const double roots[] = {0.1, 1, 2, 5, 20, 100};
    static const double dampings[] = {0, 0.1,   0.7,   0.95, 0.98, 0.995, 0.9999,
                                      1, 1.001, 1.005, 1.02, 1.3,  5,     20};
    bake_key keys[KEYS];
    for (size_t i = 0; i < sizeof roots / sizeof *roots; i++)
        for (size_t j = 0; j < sizeof dampings / sizeof *dampings; j++)
            for (int k = 0; k < 3 * rounds; k++) {
                double root = roots[i] / 0.5;
                bake_spline_problem problem = clamped;
                problem.mode.lambda = (k % 3 == 2 ? -1 : 1) * root * root;
                problem.mode.delta = dampings[j] * root;
                problem.mode.g = k % 3 == 1 ? uniform(-3, 3) * root * root : 0;
                sweep_one(&problem, keys, irregular_keys(keys));
            }
    CHECK_EQ(refused, 0);
    CHECK_EQ(over, 0);
    CHECK(curves > 200 && curves > 20 * unsolved);
}

static void waves_stay_within_tolerance_without_stiffness(void)
{
    static const double deltas[] = {0, 0.1, 1, 3, 10, 100};
    bake_key keys[KEYS];
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 8 * rounds; k++) {
            bake_spline_problem problem = clamped;
            problem.mode.delta = deltas[i];
            problem.mode.g = k & 1 ? uniform(-3, 3) : 0;
            sweep_one(&problem, keys, irregular_keys(keys));
        }
    CHECK_EQ(refused, 0);
    CHECK_EQ(over, 0);
}

/* A wave costs 10 bytes a segment and about 40 for its run; a cubic in its place needs 5 pieces a
 * half period at 2^-13. What a designer asks for must stay near the former. */
static void animators_modes_become_waves(void)
{
    int segments = 0, waves = 0, size = 0;
    bake_key keys[KEYS];
    for (int k = 0; k < 20; k++) {
        double root = 2 * 3.14159265358979 * uniform(2, 4);
        bake_spline_problem problem = clamped;
        problem.mode = (bake_mode){root * root, uniform(0.05, 0.3) * root, 0};
        int count = irregular_keys(keys);
        bake_curve curve = solved(&problem, keys, count, NULL);
        int ticks = (int)lround(keys[count - 1].time * RATE);
        fit_problem p = problem_for(&curve, &problem.mode, CURVE_WIGGLY, ticks);
        bake_track track;
        bake_error error = {""};
        CHECK_EQ(fit_track(&p, &track, &error), 0);
        for (int i = 0; i < track.count; i++) {
            int wave = track.run[i].kind > (int)WG_KIND_CUBIC;
            waves += wave ? track.run[i].segments : 0;
            size += 20 + (wave ? 16 : 4) + track.run[i].segments * (wave ? 10 : 6);
        }
        segments += curve.count;
        track_free(&track);
        bake_curve_free(&curve);
    }
    printf("animator's modes: %d segments, %d waves, %.1f bytes a segment\n", segments, waves,
           (double)size / segments);
    CHECK_EQ(waves, segments);
    CHECK(size <= 10 * segments + 36 * 20); /* one run a curve */
}

/* ---- plain keys -------------------------------------------------------------------------- */

static int make_plain(scene_curve_kind kind, const bake_key *keys, int count, bake_curve *curve)
{
    bake_error error = {""};
    return kind == CURVE_HELD ? bake_curve_held(keys, count, keys[count - 1].time, curve, &error)
           : kind == CURVE_LINEAR  ? bake_curve_linear(keys, count, curve, &error)
           : kind == CURVE_BSPLINE ? bake_curve_bspline(keys, count, 0, curve, &error)
                                   : bake_spline_solve(&clamped, keys, count, curve, NULL, &error);
}

/* Fits, plays every quarter tick of the whole clip; returns the bytes of runs and data, -1 if
 * refused. */
static int fit_and_play(const fit_problem *p, double *worst)
{
    bake_track track;
    bake_error error = {""};
    replay r;
    if (fit_track(p, &track, &error) < 0) {
        printf("refused: %s\n", error.text);
        return -1;
    }
    CHECK_EQ(track.run[0].start, 0);
    CHECK_EQ(track.run[track.count - 1].end[track.run[track.count - 1].segments - 1], p->ticks);
    replay_open(&r, &track);
    *worst = played_error(p, &r, 0, p->ticks);
    int size = (int)(r.runs.count + r.data.count) - 2; /* replay_open puts two in front */
    replay_close(&r);
    track_free(&track);
    return size;
}

/* 20-byte run, and a segment: held, linear 4, cubic and B-spline 6 bytes; a knot more at the end.
 * Keys that begin late and end early cost two segments more, not two runs. */
static void plain_keys_are_exact_and_cost_one_segment_each(void)
{
    static const scene_curve_kind kinds[] = {CURVE_HELD, CURVE_LINEAR, CURVE_CUBIC, CURVE_BSPLINE};
    static const int segment[] = {4, 4, 6, 6}, knot[] = {2, 2, 4, 4};
    for (int i = 0; i < 4; i++)
        for (int late = 0; late < 2; late++)
            for (int n = 0; n < 10; n++) {
                bake_key keys[KEYS];
                bake_curve curve;
                double worst = HUGE_VAL;
                int count = irregular_keys(keys);
                for (int k = 0; late && k < count; k++)
                    keys[k].time = floor((keys[k].time + 0.25) * RATE + 0.5) / RATE;
                CHECK_EQ(make_plain(kinds[i], keys, count, &curve), 0);
                int ticks = (int)lround((keys[count - 1].time + 0.5 * late) * RATE);
                fit_problem p = problem_for(&curve, NULL, kinds[i], ticks);
                int size = fit_and_play(&p, &worst);
                CHECK(worst <= p.tolerance / 4);
                /* a B-spline does not come to rest at its ends: there the constants are runs */
                int ends = late ? i == 3 ? 26 + 26 : 2 * segment[i] : 0;
                CHECK(size > 0 && size <= 20 + knot[i] + segment[i] * curve.count + ends);
                bake_curve_free(&curve);
            }
}

/* Keys a tick apart, and a clip as long as a clip can be. */
static void shortest_segments_and_longest_clips_fit(void)
{
    static const scene_curve_kind kinds[] = {CURVE_HELD, CURVE_LINEAR, CURVE_CUBIC, CURVE_WIGGLY};
    static const bake_mode mode = {200, 2, 0};
    for (int i = 0; i < 4; i++) {
        bake_key keys[7];
        bake_curve curve;
        bake_error error = {""};
        double worst = HUGE_VAL;
        const int tick[] = {0, 1, 2, 4, 700, 701, 65000};
        for (int k = 0; k < 7; k++)
            keys[k] =
                (bake_key){.time = tick[k] / 1000.0, .target = {k % 3}, .weight = {BAKE_HARD}};
        bake_spline_problem problem = clamped;
        problem.mode = mode;
        CHECK_EQ(i == 3 ? bake_spline_solve(&problem, keys, 7, &curve, NULL, &error)
                        : make_plain(kinds[i], keys, 7, &curve),
                 0);
        fit_problem p = problem_for(&curve, &mode, kinds[i], 65535);
        CHECK(fit_and_play(&p, &worst) > 0);
        CHECK(worst <= p.tolerance);
        bake_curve_free(&curve);
    }
}

/* ---- captures ---------------------------------------------------------------------------- */

/* Ten seconds of slow swings with flicks and sensor noise, 100 samples a second. */
static bake_curve captured_curve(void)
{
    enum { N = 1001 };
    static bake_key keys[N];
    bake_error error = {""};
    bake_curve curve;
    for (int i = 0; i < N; i++) {
        double t = i / 100.0,
               flick = exp(-20 * (t - 4) * (t - 4)) + exp(-60 * (t - 7.3) * (t - 7.3));
        keys[i] = (bake_key){.time = t, .weight = {BAKE_HARD}};
        keys[i].target[0] =
            20 * sin(1.7 * t) + 7 * sin(5.1 * t + 1) + 30 * flick + uniform(-0.2, 0.2);
    }
    const bake_spline_problem cubic = {.end = {BAKE_END_ACCELERATION, BAKE_END_ACCELERATION}};
    CHECK_EQ(bake_spline_solve(&cubic, keys, N, &curve, NULL, &error), 0);
    return curve;
}

static void captures_need_fewer_pieces_than_interpolation(void)
{
    static const double tolerances[] = {0.05, 0.25, 0.5, 2};
    bake_curve curve = captured_curve();
    for (int i = 0; i < 4; i++) {
        fit_problem p = problem_for(&curve, NULL, CURVE_CAPTURED, 10000);
        fit_knots plain, least;
        bake_error error = {""};
        double worst = HUGE_VAL;
        p.tolerance = tolerances[i];
        CHECK_EQ(fit_knots_find(&p, 0, 10000, &plain, &error), 0);
        CHECK_EQ(fit_knots_least(&p, 0, 10000, plain.count - 2, &least), 0);
        int size = fit_and_play(&p, &worst);
        printf("capture, tolerance %4.2f of 60: %d pieces interpolate, %d are enough; %d bytes\n",
               p.tolerance, plain.count - 1, least.count - 1, size);
        CHECK((least.count - 1) * 10 <= (plain.count - 1) * 8);
        CHECK(worst <= p.tolerance);
        /* loops have no step at their seam: the ends are where the capture has them */
        double value, slope;
        fit_truth(&p, 0, &value, &slope);
        CHECK_NEAR(least.value[0], value, p.tolerance / 10);
        fit_knots_free(&plain);
        fit_knots_free(&least);
    }
    bake_curve_free(&curve);
}

/* ---- numbers far from 1
 * --------------------------------------------------------------------------- */

static bake_curve scaled_curve(double range, double offset, const bake_mode *mode)
{
    bake_key keys[5];
    bake_error error = {""};
    bake_curve curve;
    bake_spline_problem problem = clamped;
    problem.mode = *mode;
    problem.mode.g = -mode->lambda * offset; /* swings about the offset */
    for (int k = 0; k < 5; k++)
        keys[k] = (bake_key){
            .time = 0.4 * k, .target = {offset + range * uniform(0, 1)}, .weight = {BAKE_HARD}};
    CHECK_EQ(bake_spline_solve(&problem, keys, 5, &curve, NULL, &error), 0);
    return curve;
}

static void every_magnitude_fits(void)
{
    static const double ranges[] = {1e-6, 1, 1e9};
    static const double offsets[] = {0, 1, -1000};
    static const bake_mode modes[] = {{0, 0, 0}, {200, 2, 0}, {100, 30, 0}};
    for (int i = 0; i < 27; i++) {
        double range = ranges[i % 3], worst = HUGE_VAL;
        bake_mode mode = modes[i / 9];
        bake_curve curve = scaled_curve(range, range * offsets[i / 3 % 3], &mode);
        mode.g = -mode.lambda * range * offsets[i / 3 % 3];
        fit_problem p = problem_for(&curve, &mode, CURVE_WIGGLY, 2000);
        p.tolerance = fmax(p.tolerance, ldexp(2, -p.frac));
        CHECK(fit_and_play(&p, &worst) > 0);
        CHECK(worst <= p.tolerance);
        bake_curve_free(&curve);
    }
}

/* A hundred thousand times farther away than it moves: 27 bits leave 10 for the motion. 2^-7 is
 * met, 2^-13 is refused in words. */
static void what_the_format_cannot_hold_is_refused(void)
{
    static const bake_mode still = {0, 0, 0};
    bake_curve curve = scaled_curve(1, 1e5, &still);
    fit_problem p = problem_for(&curve, &still, CURVE_WIGGLY, 2000);
    bake_track track;
    bake_error error = {""};
    double worst = HUGE_VAL;
    CHECK_EQ(fit_track(&p, &track, &error), -1);
    CHECK(strstr(error.text, "tolerance") != NULL);
    p.tolerance = 1 / 128.0;
    CHECK(fit_and_play(&p, &worst) > 0);
    CHECK(worst <= p.tolerance);
    bake_curve_free(&curve);
}

static void constant_curves_fit(void)
{
    static const double values[] = {0, 1e-9, 3, -1e9};
    for (int i = 0; i < 4; i++) {
        bake_key keys[3];
        bake_error error = {""};
        bake_curve curve;
        double worst = HUGE_VAL;
        for (int k = 0; k < 3; k++)
            keys[k] = (bake_key){.time = k, .target = {values[i]}, .weight = {BAKE_HARD}};
        CHECK_EQ(bake_spline_solve(&clamped, keys, 3, &curve, NULL, &error), 0);
        fit_problem p = problem_for(&curve, NULL, CURVE_CUBIC, 2000);
        CHECK(fit_and_play(&p, &worst) > 0);
        CHECK(worst <= p.tolerance);
        bake_curve_free(&curve);
    }
}

/* ---- velocity ---------------------------------------------------------------------------- */

/* Error of the player's velocity, over the largest that a value error of one tolerance allows: by
 * Markov's inequality a cubic that stays within T on h seconds has slopes below 18 T/h; a wave adds
 * its rate. */
static double velocity_ratio(const fit_problem *p, const bake_track *track, double fast)
{
    replay r;
    double worst = 0;
    replay_open(&r, track);
    for (int i = 0; i < track->count; i++) {
        const track_run *run = &track->run[i];
        for (int k = 0, start = run->start; k < run->segments; start = run->end[k++]) {
            int h = run->end[k] - start;
            double bound = p->tolerance * (18.0 * RATE / h + fast);
            for (int n = 0; n < 9; n++) {
                uint32_t position = (uint32_t)(65536.0 * (start + (double)h * n / 9));
                double value, slope;
                fit_truth(p, position / 65536.0, &value, &slope);
                int32_t v = wg_track_velocity(&r.file, 0, position, (uint16_t)p->rate);
                worst = fmax(worst, fabs(ldexp(v, -p->frac) - slope * p->rate) / bound);
            }
        }
    }
    replay_close(&r);
    return worst;
}

static void velocities_follow_values(void)
{
    static const bake_mode modes[] = {{200, 2, 0}, {350, 0, 0}, {100, 30, 0},
                                      {0, 4, 0},   {-40, 1, 0}, {0, 0, 0}};
    double worst = 0;
    for (int i = 0; i < 60; i++) {
        bake_key keys[KEYS];
        bake_track track;
        bake_error error = {""};
        bake_spline_problem problem = clamped;
        problem.mode = modes[i % 6];
        int count = irregular_keys(keys);
        bake_curve curve = solved(&problem, keys, count, NULL);
        double rate = problem.mode.delta + sqrt(fabs(problem.mode.lambda));
        fit_problem p = problem_for(&curve, &problem.mode, CURVE_WIGGLY,
                                    (int)lround(keys[count - 1].time * RATE));
        CHECK_EQ(fit_track(&p, &track, &error), 0);
        worst = fmax(worst, velocity_ratio(&p, &track, 2 * rate));
        track_free(&track);
        bake_curve_free(&curve);
    }
    printf("velocity: %.2f of what the tolerance allows\n", worst);
    CHECK(worst <= 2); /* what is left of the curve is no polynomial: twice */
}

/* --full sweeps four times as many curves. */
int main(int argc, char **argv)
{
    rounds = argc > 1 && strcmp(argv[1], "--full") == 0 ? 4 : 1;
    TEST(waves_stay_within_tolerance_for_every_mode);
    TEST(waves_stay_within_tolerance_without_stiffness);
    print_tallies();
    TEST(animators_modes_become_waves);
    TEST(plain_keys_are_exact_and_cost_one_segment_each);
    TEST(shortest_segments_and_longest_clips_fit);
    TEST(captures_need_fewer_pieces_than_interpolation);
    TEST(every_magnitude_fits);
    TEST(what_the_format_cannot_hold_is_refused);
    TEST(constant_curves_fit);
    TEST(velocities_follow_values);
    return check_done();
}
