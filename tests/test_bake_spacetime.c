/* Spacetime control: what its motions must do by theory.
 * Source: Schulz 2013, 2.6, 2.8. Vectors from elsewhere: test_bake_spacetime_oracle.c.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spacetime_problem.h"

/* ---- interpolation and smoothness ------------------------------------------------------------ */

/* What is continuous changes over 1e-7 by that times its slope, estimated over 1e-3 on each side. */
static void check_smooth(const motion *m, double t, double size)
{
    double a[3][D_MAX], b[3][D_MAX], far[3][D_MAX], e = 1e-7;
    motion_eval(m, t - e, a[0], a[1], a[2]);
    motion_eval(m, t + e, b[0], b[1], b[2]);
    for (int order = 0; order < 3; order++)
        for (int i = 0; i < m->d; i++) {
            double slope = 0;
            for (int side = -1; side < 2; side += 2) {
                motion_eval(m, t + side * (1e-3 + e), far[0], far[1], far[2]);
                const double *near = side < 0 ? a[order] : b[order];
                slope = fmax(slope, fabs(far[order][i] - near[i]) / 1e-3);
            }
            CHECK_NEAR(a[order][i], b[order][i], 10 * e * slope + 1e-9 * size);
        }
}

static void poses_are_hit_and_joined_twice_differentiably(void)
{
    static problem x;
    static const bake_end ends[3] = {BAKE_END_FREE, BAKE_END_VELOCITY, BAKE_END_PERIODIC};
    for (int trial = 0; trial < 36; trial++) {
        double q[D_MAX], v[D_MAX], a[D_MAX];
        random_problem(&x, (way)(trial % 3), 2 + trial % 4, 2 + trial % 5, ends[trial / 3 % 3]);
        x.settings.regularise[trial % 2] = trial % 4 == 3 ? 0.5 : 0.0;
        motion m = solved_motion(&x);
        if (!m.term)
            continue;
        for (int k = 0; k < x.count; k++) {
            motion_eval(&m, x.keys[k].time, q, v, a);
            for (int i = 0; i < x.d; i++)
                CHECK_NEAR(q[i], x.q[k][i], 1e-12);
            double next = x.keys[k + (k < x.count - 1)].time, t = x.keys[k].time;
            if (m.periodic || (k > 0 && k < x.count - 1))
                check_smooth(&m, t, 1.0 + largest(a, x.d));
            for (int part = 1; part < 4 && k < x.count - 1; part++)
                check_smooth(&m, t + 0.25 * part * (next - t), 1.0 + largest(a, x.d));
            for (int i = 0; i < x.d && x.settings.end[0] == BAKE_END_VELOCITY; i++)
                if (k == 0 || k == x.count - 1)
                    CHECK_NEAR(v[i], x.end_v[k > 0][i], 1e-10);
        }
        motion_free(&m);
    }
}

/* Coupled motions have the freedom to be C2 there, and for soft ones; the others are C1. */
static void velocities_at_keys_are_met(void)
{
    static problem x;
    for (int kind = 0; kind < 3; kind++)
        for (int soft = 0; soft < 1 + (kind == COUPLE); soft++) {
            double q[D_MAX], v[D_MAX], a[D_MAX];
            random_problem(&x, (way)kind, 4, 4, kind ? BAKE_END_VELOCITY : BAKE_END_FREE);
            x.keys[1].v = x.v[1];
            x.keys[1].weight[1] = soft ? 1e9 : BAKE_HARD;
            motion m = solved_motion(&x);
            /* 2 weight (v - target) = jump of 2 f, |f| <= 1e4 here */
            for (int side = -1; side < 2; side++) {
                motion_eval(&m, x.keys[1].time + side * 1e-9, q, v, a);
                for (int i = 0; i < x.d; i++) {
                    CHECK_NEAR(q[i], x.q[1][i], 1e-8);
                    CHECK_NEAR(v[i], x.v[1][i], soft ? 1e-4 : 2e-9 * largest(a, x.d) + 1e-10);
                }
            }
            if (kind == COUPLE)
                check_smooth(&m, x.keys[1].time, 1 + largest(a, x.d));
            motion_free(&m);
        }
}

static void outside_it_holds_still_or_repeats(void)
{
    static problem x;
    for (int loop = 0; loop < 2; loop++) {
        double q[D_MAX], v[D_MAX], want[D_MAX], speed[D_MAX];
        random_problem(&x, BLEND, 3, 4, loop ? BAKE_END_PERIODIC : BAKE_END_VELOCITY);
        motion m = solved_motion(&x);
        double from = m.from, to = m.to;
        motion_eval(&m, loop ? from + 0.1 : to, want, speed, NULL);
        motion_eval(&m, loop ? from + 0.1 + 3 * (to - from) : to + 0.1, q, v, NULL);
        for (int i = 0; i < 3; i++) {
            CHECK_NEAR(q[i], want[i], 1e-10);
            CHECK_NEAR(v[i], loop ? speed[i] : 0.0, 1e-9);
        }
        motion_free(&m);
    }
}

/* ---- known answers --------------------------------------------------------------------------- */

/* Free vibration of each mode about its equilibrium, by the formula of a damped oscillator. */
static void vibration(const problem *x, double t, double *q, double *v)
{
    const model *m = &x->models[0];
    const space_settings *s = &x->settings;
    memset(q, 0, (size_t)x->d * sizeof *q);
    memset(v, 0, (size_t)x->d * sizeof *v);
    for (int i = 0; i < x->d; i++) {
        double lambda = s->stiffness * m->lambda[i], delta = 0.5 * (s->alpha + s->beta * lambda);
        double eta = sqrt(lambda - delta * delta), decay = exp(-delta * t);
        double c = decay * cos(eta * t + i), n = decay * sin(eta * t + i);
        double rest = -(s->stiffness * m->inner[i] + m->outer[i]) / lambda;
        for (int r = 0; r < x->d; r++) {
            q[r] += m->Phi[i * x->d + r] * (c + rest);
            v[r] += m->Phi[i * x->d + r] * (-delta * c - eta * n);
        }
    }
}

static void data_of_a_free_vibration_give_it_back(void)
{
    static problem x;
    for (int trial = 0; trial < 6; trial++) {
        double q[D_MAX], v[D_MAX], want[D_MAX], speed[D_MAX];
        random_problem(&x, (way)(trial % 3), 4, 5, trial < 3 ? BAKE_END_VELOCITY : BAKE_END_FREE);
        for (int k = 0; k < x.count; k++) {
            x.list[k] = x.list[0];
            vibration(&x, x.keys[k].time, x.q[k], v);
            if (k == 0 || k == x.count - 1)
                memcpy(x.end_v[k > 0], v, sizeof v);
        }
        motion m = solved_motion(&x);
        /* f is a sum of terms up to lambda = 400: 1e-12 of it, squared, over 3 s */
        CHECK(motion_energy(&m) >= 0.0 && motion_energy(&m) < 1e-18);
        for (double t = m.from; t < m.to; t += 0.01) {
            motion_eval(&m, t, q, v, NULL);
            vibration(&x, t, want, speed);
            for (int i = 0; i < x.d; i++) {
                CHECK_NEAR(q[i], want[i], 1e-11);
                CHECK_NEAR(v[i], speed[i], 1e-9);
            }
        }
        motion_free(&m);
    }
}

static void a_partial_key_of_everything_is_a_whole_one(void)
{
    static problem x;
    for (int trial = 0; trial < 12; trial++) {
        static const bake_end ends[3] = {BAKE_END_FREE, BAKE_END_VELOCITY, BAKE_END_PERIODIC};
        random_problem(&x, ONE, 3, trial % 2 ? 2 : 4, ends[trial % 3]);
        motion whole = solved_motion(&x);
        make_partial(&x, 1, 3 + trial % 2, BAKE_HARD); /* 4 rows of rank 3, which agree */
        if (trial % 3 == 2 && x.count == 2)
            make_partial(&x, 1, 0, BAKE_HARD);
        motion m = solved_motion(&x);
        /* rows of random numbers in -1..1 have a condition of 1e4 at most here */
        CHECK(apart(&m, &whole) < 1e-9);
        motion_free(&whole);
        motion_free(&m);
    }
}

static void rows_that_disagree_are_met_in_the_mean(void)
{
    static problem x;
    double q[D_MAX];
    random_problem(&x, ONE, 3, 3, BAKE_END_VELOCITY);
    make_partial(&x, 1, 2, BAKE_HARD);
    for (int i = 0; i < 3; i++)
        x.S[1][3 + i] = x.S[1][i];
    x.p[1][0] = 0.5;
    x.p[1][1] = 1.5;
    motion m = solved_motion(&x);
    motion_eval(&m, x.keys[1].time, q, NULL, NULL);
    CHECK_NEAR(x.S[1][0] * q[0] + x.S[1][1] * q[1] + x.S[1][2] * q[2], 1.0, 1e-12);
    motion_free(&m);
}

/* The soft key's distance from the hard one falls as 1/weight. */
static void weight_turns_soft_into_hard(void)
{
    static problem x;
    for (int rows = 0; rows < 3; rows++) {
        double far[3];
        random_problem(&x, ONE, 3, 4, BAKE_END_VELOCITY);
        if (rows)
            make_partial(&x, 2, rows, BAKE_HARD);
        motion hard = solved_motion(&x);
        for (int i = 0; i < 3; i++) {
            x.keys[2].weight[0] = (double[]){1e7, 1e8, 1e9}[i];
            motion soft = solved_motion(&x);
            far[i] = apart(&hard, &soft);
            motion_free(&soft);
        }
        CHECK(far[2] > 0 && far[2] < 1e-3);
        CHECK_NEAR(far[0] / far[1], 10, 0.1);
        CHECK_NEAR(far[1] / far[2], 10, 0.1);
        motion_free(&hard);
    }
}

static void mode_keys_and_problem_give_the_curve_back(void)
{
    static problem x;
    random_problem(&x, ONE, 4, 5, BAKE_END_VELOCITY);
    make_partial(&x, 2, 2, BAKE_HARD);
    make_partial(&x, 3, 1, 30.0);
    x.keys[1].weight[0] = 1e4;
    motion m = solved_motion(&x);
    const motion_input in = input_of(&x);
    for (int i = 0; i < x.d; i++) {
        bake_spline_problem p;
        bake_key keys[KEYS_MAX];
        double a[4], b[4];
        motion_mode_problem(x.list[0], &x.settings, i, &p);
        motion_mode_keys(&in, i, &m, keys);
        bake_curve curve = solved(&p, keys, x.count, NULL);
        for (double t = m.from; t < m.to; t += 0.05) {
            bake_curve_eval(&curve, t, a);
            bake_curve_eval(&m.term[0].curve[i], t, b);
            CHECK_NEAR(a[0], b[0], 1e-11);
        }
        bake_curve_free(&curve);
    }
    motion_free(&m);
}

/* ---- least energy ---------------------------------------------------------------------------- */

/* A smooth function that is 0 at every key, with its slope where `flat`: a product of (t - t_k). */
static void bump(const problem *x, double t, double out[3])
{
    double p[3] = {1, 0, 0};
    for (int k = 0; k < x->count; k++)
        for (int twice = 0; twice < 2; twice++) {
            double s = 3 * (t - x->keys[k].time);
            p[2] = p[2] * s + 6 * p[1];
            p[1] = p[1] * s + 3 * p[0];
            p[0] = p[0] * s;
        }
    double c = cos(4 * t), n = sin(4 * t);
    out[0] = p[0] * c;
    out[1] = p[1] * c - 4 * p[0] * n;
    out[2] = p[2] * c - 8 * p[1] * n - 16 * p[0] * c;
}

/* |q'' + D q' + K q + G|^2 of motion a + step (direction), by Simpson's rule between the keys, with
 * model 0; direction: b - a, or without b the bump times (1, 2, 3, ..). */
static double energy_of(const problem *x, const motion *a, const motion *b, double step)
{
    const model *m = &x->models[0];
    const space_settings *s = &x->settings;
    double total = 0, q[3][D_MAX], other[3][D_MAX], shape[3];
    for (int k = 0; k < x->count - 1; k++)
        for (int n = 0; n <= 800; n++) {
            double h = (x->keys[k + 1].time - x->keys[k].time) / 800, t = x->keys[k].time + n * h;
            motion_eval(a, t, q[0], q[1], q[2]);
            if (b)
                motion_eval(b, t, other[0], other[1], other[2]);
            else
                bump(x, t, shape);
            for (int o = 0; o < 3; o++)
                for (int i = 0; i < x->d; i++)
                    q[o][i] += step * (b ? other[o][i] - q[o][i] : shape[o] * (i + 1));
            for (int i = 0; i < x->d; i++) {
                double lambda = s->stiffness * m->lambda[i], c[3] = {0};
                for (int r = 0; r < x->d; r++)
                    for (int o = 0; o < 3; o++)
                        c[o] += m->Phi[i * x->d + r] * q[o][r];
                double f = c[2] + (s->alpha + s->beta * lambda) * c[1] + lambda * c[0] +
                           s->stiffness * m->inner[i] + m->outer[i];
                total += f * f * h / 3 * (n == 0 || n == 800 ? 1 : n & 1 ? 4 : 2);
            }
        }
    for (int k = 0; k < x->count; k++) { /* soft partial keys */
        const space_key *key = &x->keys[k];
        if (key->rows == 0 || key->weight[0] <= 0)
            continue;
        motion_eval(a, key->time, q[0], NULL, NULL);
        if (b)
            motion_eval(b, key->time, other[0], NULL, NULL);
        for (int r = 0; r < key->rows; r++) {
            double left = -key->p[r];
            for (int i = 0; i < x->d; i++)
                left +=
                    key->S[r * x->d + i] * (q[0][i] + (b ? step * (other[0][i] - q[0][i]) : 0.0));
            total += key->weight[0] * left * left;
        }
    }
    return total;
}

/* The energy is quadratic along a line: its slope at 0 must vanish against its curvature. */
static void check_minimum(const problem *x, const motion *a, const motion *b)
{
    double at = energy_of(x, a, b, 0), up = energy_of(x, a, b, 0.5),
           down = energy_of(x, a, b, -0.5);
    CHECK(up > at && down > at);
    /* 1e-6: Simpson's rule over 800 intervals is 1e-9 of each energy */
    CHECK(fabs(up - down) <= 1e-6 * (up + down));
}

static void no_other_motion_needs_less_force(void)
{
    static problem x, other;
    for (int trial = 0; trial < 8; trial++) {
        random_problem(&x, ONE, 4, 4, trial % 2 ? BAKE_END_FREE : BAKE_END_VELOCITY);
        if (trial >= 4) {
            make_partial(&x, 1, 2, BAKE_HARD);
            make_partial(&x, 2, 1, trial & 2 ? 200.0 : BAKE_HARD);
        }
        motion a = solved_motion(&x);
        CHECK_NEAR(motion_energy(&a),
                   trial & 2 && trial >= 4 ? motion_energy(&a) : energy_of(&x, &a, NULL, 0),
                   1e-8 * motion_energy(&a));
        check_minimum(&x, &a, NULL);
        /* others with the same partial poses: q moves along what the rows do not see */
        other = x;
        for (int k = 1; k < 3 && trial >= 4; k++) {
            const double *S = other.S[k];
            double n[4] = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}, q[4];
            motion_eval(&a, x.keys[k].time, q, NULL, NULL);
            for (int r = 0; r < 40000 * x.keys[k].rows; r++) { /* alternating projections */
                const double *row = S + r % x.keys[k].rows * 4;
                double dot = 0, norm = 0;
                for (int i = 0; i < 4; i++) {
                    dot += row[i] * n[i];
                    norm += row[i] * row[i];
                }
                for (int i = 0; i < 4; i++)
                    n[i] -= dot / norm * row[i];
            }
            for (int i = 0; i < 4; i++)
                other.q[k][i] = q[i] + n[i];
            other.keys[k] =
                (space_key){.time = x.keys[k].time, .q = other.q[k], .weight = {BAKE_HARD, 0}};
        }
        for (int k = 0; k < x.count; k++)
            other.keys[k].q = other.q[k];
        motion b = solved_motion(&other);
        if (trial >= 4)
            check_minimum(&x, &a, &b);
        motion_free(&a);
        motion_free(&b);
    }
}

static void the_cubic_needs_more_force(void)
{
    static problem x;
    bake_error error;
    for (int trial = 0; trial < 9; trial++) {
        double cubic = 0;
        static const bake_end ends[3] = {BAKE_END_FREE, BAKE_END_VELOCITY, BAKE_END_PERIODIC};
        random_problem(&x, (way)(trial % 3), 4, 4, ends[trial / 3]);
        motion m = solved_motion(&x), plain;
        const motion_input in = input_of(&x);
        CHECK_EQ(motion_cubic_energy(&m, &in, &cubic, &error), 0);
        CHECK(cubic > motion_energy(&m));
        if (x.way == ONE) { /* the cubic as a motion without stiffness, measured by model 0 */
            problem *zero = malloc(sizeof *zero);
            *zero = x;
            zero->settings.alpha = zero->settings.beta = 0;
            memset(zero->models[0].lambda, 0, sizeof zero->models[0].lambda);
            memset(zero->models[0].inner, 0, sizeof zero->models[0].inner);
            memset(zero->models[0].outer, 0, sizeof zero->models[0].outer);
            link_model(zero, 0);
            plain = solved_motion(zero);
            /* Simpson's rule over 800 intervals: 1e-10 of a polynomial's energy */
            CHECK_NEAR(cubic, energy_of(&x, &plain, NULL, 0), 1e-8 * cubic);
            motion_free(&plain);
            free(zero);
        }
        motion_free(&m);
    }
}

/* Among the motions that coupling chooses from: those with other velocities at a key. */
static void coupling_has_the_least_energy_of_its_kind(void)
{
    static problem x;
    for (int trial = 0; trial < 4; trial++) {
        random_problem(&x, COUPLE, 3, 4, BAKE_END_VELOCITY);
        motion best = solved_motion(&x);
        double v[D_MAX], energy[3];
        motion_eval(&best, x.keys[1].time, NULL, v, NULL);
        x.keys[1].v = x.v[1];
        x.keys[1].weight[1] = BAKE_HARD;
        for (int i = 0; i < 3; i++) {
            for (int r = 0; r < x.d; r++)
                x.v[1][r] = v[r] + (i - 1) * (r + 1) * 0.5;
            motion m = solved_motion(&x);
            energy[i] = motion_energy(&m);
            motion_free(&m);
        }
        CHECK(energy[0] > energy[1] && energy[2] > energy[1]);
        CHECK_NEAR(energy[1], motion_energy(&best), 1e-9 * motion_energy(&best));
        CHECK(fabs(energy[0] - energy[2]) <= 1e-7 * (energy[0] + energy[2]));
        motion_free(&best);
    }
}

/* ---- limits ---------------------------------------------------------------------------------- */

static void check_refused(problem *x, const char *word)
{
    motion m;
    bake_error error = {""};
    CHECK_EQ(solve(x, &m, &error), -1);
    CHECK(m.term == NULL && strstr(error.text, word) != NULL);
    if (!strstr(error.text, word))
        printf("'%s' is not in: %s\n", word, error.text);
}

static void what_cannot_be_solved_is_refused_with_its_reason(void)
{
    static problem x;
    random_problem(&x, ONE, 3, 2, BAKE_END_FREE);
    make_partial(&x, 1, 1, BAKE_HARD);
    check_refused(&x, "undetermined");
    random_problem(&x, ONE, 3, 3, BAKE_END_FREE);
    make_partial(&x, 1, 1, BAKE_HARD);
    memset(x.S[1], 0, sizeof x.S[1]);
    check_refused(&x, "cannot move");
    random_problem(&x, BLEND, 3, 3, BAKE_END_FREE);
    x.keys[1].weight[0] = 3;
    check_refused(&x, "whole pose");
    random_problem(&x, COUPLE, 3, 3, BAKE_END_PERIODIC);
    x.q[2][1] += 0.1;
    check_refused(&x, "repeat the first");
    random_problem(&x, COUPLE, 3, 3, BAKE_END_VELOCITY);
    x.keys[2].time = x.keys[1].time;
    check_refused(&x, "not later");
}

/* A key half a period after another: with both ends' velocities free, any amplitude fits. */
static void resonance_names_its_mode(void)
{
    static problem x;
    motion m;
    bake_error error = {""};
    random_problem(&x, ONE, 3, 3, BAKE_END_FREE);
    x.settings = (space_settings){.stiffness = 1};
    x.models[0].lambda[1] = 10 * 10;
    for (int k = 0; k < 3; k++)
        x.keys[k].time = k * 3.14159265358979 / 10 * (1 + 1e-13);
    CHECK_EQ(solve(&x, &m, &error), -1);
    CHECK(strstr(error.text, "mode 2 (1.592 Hz)") && strstr(error.text, "resonance"));
    x.keys[1].time *= 1.001;
    x.keys[2].time *= 1.001;
    CHECK_EQ(solve(&x, &m, &error), 0);
    CHECK(strstr(error.text, "mode 2 (1.592 Hz)") && strstr(error.text, "overshoots"));
    motion_free(&m);
}

/* One key to the next is 600 half periods of the stiffest mode. */
static void stiff_modes_leave_the_soft_ones_their_digits(void)
{
    static problem x;
    for (int trial = 0; trial < 3; trial++) {
        random_problem(&x, COUPLE, 6, 4, BAKE_END_VELOCITY);
        x.settings.alpha = 0.1;
        x.settings.beta = 1e-6;
        for (int k = 0; k < x.count; k++) {
            x.list[k] = x.list[0];
            for (int i = 0; i < x.d; i++)
                x.models[0].lambda[i] = pow(10, 1 + 1.2 * i);
        }
        x.way = BLEND;
        motion one = solved_motion(&x);
        x.way = COUPLE;
        motion m = solved_motion(&x);
        /* One model: coupling adds knots and C2 there, so it may only lower the energy of each
         * mode's spline where that is not smooth already: it must be the same motion. */
        CHECK(apart(&one, &m) < 1e-8);
        CHECK_NEAR(motion_energy(&m), motion_energy(&one), 1e-8 * motion_energy(&one));
        motion_free(&one);
        motion_free(&m);
    }
}

int main(void)
{
    TEST(poses_are_hit_and_joined_twice_differentiably);
    TEST(velocities_at_keys_are_met);
    TEST(outside_it_holds_still_or_repeats);
    TEST(data_of_a_free_vibration_give_it_back);
    TEST(a_partial_key_of_everything_is_a_whole_one);
    TEST(rows_that_disagree_are_met_in_the_mean);
    TEST(weight_turns_soft_into_hard);
    TEST(mode_keys_and_problem_give_the_curve_back);
    TEST(no_other_motion_needs_less_force);
    TEST(the_cubic_needs_more_force);
    TEST(coupling_has_the_least_energy_of_its_kind);
    TEST(what_cannot_be_solved_is_refused_with_its_reason);
    TEST(resonance_names_its_mode);
    TEST(stiff_modes_leave_the_soft_ones_their_digits);
    return check_done();
}
