/* Plain curves (held, linear, B-spline), evaluation, and what the solver says when it must refuse.
 * Source: spline.h; Schulz 2013, figure 2.6 for resonance.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_random.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- plain curves ---------------------------------------------------------------------------- */

static void held_curve_jumps_at_its_keys(void)
{
    bake_key keys[3] = {{0, {1, 0, 0}, {0}}, {1, {2, 0, 0}, {0}}, {3, {-1, 0, 0}, {0}}};
    bake_curve curve;
    bake_error error;
    double out[4];
    CHECK_EQ(bake_curve_held(keys, 3, 4.0, &curve, &error), 0);
    const double at[7][2] = {{-1, 1}, {0, 1}, {0.999, 1}, {1, 2}, {2.999, 2}, {3, -1}, {9, -1}};
    for (int i = 0; i < 7; i++) {
        bake_curve_eval(&curve, at[i][0], out);
        CHECK(out[0] == at[i][1] && out[1] == 0.0 && out[2] == 0.0 && out[3] == 0.0);
    }
    CHECK_EQ(curve.count, 3);
    bake_curve_free(&curve);
    CHECK_EQ(bake_curve_held(keys, 1, 0.0, &curve, &error), -1);
    CHECK_EQ(bake_curve_held(keys, 1, 2.0, &curve, &error), 0);
    bake_curve_free(&curve);
}

static void linear_curve_connects_its_keys(void)
{
    bake_key keys[3] = {{0, {1, 0, 0}, {0}}, {1, {2, 0, 0}, {0}}, {3, {-2, 0, 0}, {0}}};
    bake_curve curve;
    bake_error error;
    double out[4];
    CHECK_EQ(bake_curve_linear(keys, 3, &curve, &error), 0);
    bake_curve_eval(&curve, 0.25, out);
    CHECK_NEAR(out[0], 1.25, 1e-15);
    CHECK_NEAR(out[1], 1.0, 1e-15);
    bake_curve_eval(&curve, 1.0, out);
    CHECK_NEAR(out[0], 2.0, 1e-15);
    CHECK_NEAR(out[1], -2.0, 1e-15); /* the later segment counts */
    bake_curve_eval(&curve, 3.0, out);
    CHECK_NEAR(out[1], -2.0, 1e-15);
    bake_curve_eval(&curve, 3.001, out);
    CHECK(out[0] == -2.0 && out[1] == 0.0);
    bake_curve_free(&curve);
}

static void check_smooth(const bake_curve *curve, int closed)
{
    double left[4], right[4];
    for (int k = closed ? 0 : 1; k < curve->count; k++) {
        const bake_segment *a = &curve->segment[k ? k - 1 : curve->count - 1];
        bake_segment_eval(a, a->t1, left);
        bake_segment_eval(&curve->segment[k], curve->segment[k].t0, right);
        for (int i = 0; i < 3; i++)
            CHECK_NEAR(left[i], right[i], 1e-11 * (1 + fabs(left[i])));
    }
}

static void bspline_is_smooth_and_stays_within_its_control_points(void)
{
    bake_key keys[KEYS];
    bake_error error;
    double out[4];
    for (int trial = 0; trial < 100; trial++) {
        int closed = trial & 1, count = random_keys(keys, 2 + trial % 13);
        bake_curve curve;
        keys[count - 1].target[0] = closed ? keys[0].target[0] : keys[count - 1].target[0];
        CHECK_EQ(bake_curve_bspline(keys, count, closed, &curve, &error), 0);
        check_smooth(&curve, closed);
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (int k = 0; k < count; k++) {
            low = fmin(low, keys[k].target[0]);
            high = fmax(high, keys[k].target[0]);
        }
        for (int i = 0; i <= 200; i++) {
            bake_curve_eval(&curve, keys[0].time + i * (keys[count - 1].time - keys[0].time) / 200,
                            out);
            CHECK(out[0] >= low - 1e-12 && out[0] <= high + 1e-12);
        }
        for (int end = 0; end < 2 && !closed; end++) {
            bake_curve_eval(&curve, keys[end ? count - 1 : 0].time, out);
            CHECK_NEAR(out[0], keys[end ? count - 1 : 0].target[0], 1e-13);
        }
        bake_curve_free(&curve);
    }
}

/* On even knots the value at a knot is (c0 + 4 c1 + c2)/6 and the velocity (c2 - c0)/(2 h). */
static void even_bspline_has_the_textbook_values(void)
{
    bake_key keys[8];
    double c[8] = {0.5, -1, 2, 0.25, 3, -2, 1, 0.5}, h = 0.4, out[4];
    bake_curve curve;
    bake_error error;
    for (int k = 0; k < 8; k++)
        keys[k] = (bake_key){h * k, {c[k], 0, 0}, {0}};
    for (int closed = 0; closed < 2; closed++) {
        CHECK_EQ(bake_curve_bspline(keys, 8, closed, &curve, &error), 0);
        for (int k = closed ? 0 : 2; k < (closed ? 7 : 6); k++) {
            double before = c[(k + 6) % 7], after = c[(k + 1) % 7];
            bake_curve_eval(&curve, h * k, out);
            CHECK_NEAR(out[0], (before + 4 * c[k] + after) / 6, 1e-13);
            CHECK_NEAR(out[1], (after - before) / (2 * h), 1e-12);
        }
        bake_curve_free(&curve);
    }
    keys[7].target[0] = 9.0;
    CHECK_EQ(bake_curve_bspline(keys, 8, 1, &curve, &error), -1);
    CHECK(curve.segment == NULL);
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void refuses(const bake_spline_problem *p, const bake_key *keys, int count, const char *text)
{
    bake_curve curve;
    bake_error error = {""};
    CHECK_EQ(bake_spline_solve(p, keys, count, &curve, NULL, &error), -1);
    CHECK(curve.segment == NULL);
    CHECK(strstr(error.text, text) != NULL);
    if (!strstr(error.text, text))
        printf("expected '%s' in '%s'\n", text, error.text);
    bake_curve_free(&curve);
}

static void bad_input_is_named(void)
{
    bake_key keys[3] = {
        {0, {1, 0, 0}, {-1, 0, 0}}, {1, {2, 0, 0}, {-1, 0, 0}}, {2, {0, 0, 0}, {-1, 0, 0}}};
    bake_spline_problem p = clamped;
    refuses(&p, keys, 1, "at least two keys");
    keys[1].time = 0;
    refuses(&p, keys, 3, "not later");
    keys[1].time = (double)NAN;
    refuses(&p, keys, 3, "not a number");
    keys[1].time = 1;
    keys[2].target[0] = HUGE_VAL;
    refuses(&p, keys, 3, "2 s has a value that is not a number");
    keys[2].target[0] = 0;
    keys[2].weight[0] = -0.5;
    refuses(&p, keys, 3, "weight -0.5");
    keys[2].weight[0] = -1;
    p.end[0] = BAKE_END_PERIODIC;
    refuses(&p, keys, 3, "both ends or none");
    p.end[1] = BAKE_END_PERIODIC;
    refuses(&p, keys, 3, "prescribed twice");
    p = clamped;
    p.alpha = -1;
    refuses(&p, keys, 3, "regulariser");
    p.alpha = 0;
    p.mode.lambda = (double)NAN;
    refuses(&p, keys, 3, "not a number");
}

static void undetermined_and_contradictory_data_are_refused(void)
{
    bake_key keys[2] = {{0, {1, 0, 0}, {-1, 0, 0}}, {1, {2, 0, 0}, {0, 0, 0}}};
    bake_spline_problem p = {.mode = {1.0, 0.0, 0.0}};
    refuses(&p, keys, 2, "do not determine");
    p.alpha = 1e-3; /* the remedy the message names */
    bake_curve curve = solved(&p, keys, 2, NULL);
    bake_curve_free(&curve);
    bake_key three[3] = {
        {0, {1, 0, 0}, {-1, -1, -1}}, {1, {2, 3, 0}, {-1, -1, -1}}, {2, {2, 3, 1}, {-1, -1, -1}}};
    refuses(&p, three, 3, "do not determine");
    p.end[0] = BAKE_END_VELOCITY;
    p.end_value[0] = 7.0;
    refuses(&p, three, 3, "prescribed twice");
}

/* eta h = pi (1 + 1e-4): the keys at 2 s and 3 s must be named, and the remedies work. */
static void resonance_is_explained(void)
{
    bake_key keys[2] = {{2, {1, 0, 0}, {-1, 0, 0}}, {3, {0.5, 0, 0}, {-1, 0, 0}}};
    double eta = 3.14159265358979 * (1 + 1e-4);
    bake_spline_problem p = {.mode = {eta * eta, 0, 0}};
    bake_spline_report report;
    bake_curve curve;
    bake_error error = {""};
    CHECK_EQ(bake_spline_solve(&p, keys, 2, &curve, &report, &error), 0);
    CHECK(report.overshoot > 1000);
    CHECK_EQ(report.resonant_segment, 0);
    CHECK(strstr(error.text, "between the keys at 2 s and 3 s") &&
          strstr(error.text, "regularise"));
    bake_curve_free(&curve);
    CHECK_EQ(bake_spline_solve(&p, keys, 2, &curve, NULL, &error), 0);
    CHECK(strstr(error.text, "between the keys at 2 s and 3 s") != NULL); /* without a report too */
    bake_curve_free(&curve);
    p.mode.lambda = 3.14159265358979 * 3.14159265358979;
    refuses(&p, keys, 2, "between the keys at 2 s and 3 s");
    p.alpha = 1.0;
    CHECK_EQ(bake_spline_solve(&p, keys, 2, &curve, &report, &error), 0);
    CHECK(report.overshoot < 2 && error.text[0] == '\0');
    bake_curve_free(&curve);
    p.alpha = 0.0;
    p.end[0] = p.end[1] = BAKE_END_VELOCITY;
    CHECK_EQ(bake_spline_solve(&p, keys, 2, &curve, &report, &error), 0);
    CHECK(report.overshoot < 2 && error.text[0] == '\0');
    bake_curve_free(&curve);
}

/* Natural ends of two keys: the acceleration is rounding and nothing else. */
static void two_natural_keys_are_a_line(void)
{
    static const double VALUE[][2] = {{0, 1}, {-1.98e-6, 2.92e-5}, {1e6, 1e6}, {3, -4}, {0, 0}};
    static const double END[] = {1.56, 1, 1e-3, 4000};
    for (int i = 0; i < 5; i++) {
        for (int j = 0; j < 4; j++) {
            bake_key keys[2] = {{.target = {VALUE[i][0]}, .weight = {BAKE_HARD}},
                                {END[j], {VALUE[i][1]}, {BAKE_HARD}}};
            const bake_spline_problem line = {
                .end = {BAKE_END_ACCELERATION, BAKE_END_ACCELERATION}};
            bake_curve curve;
            bake_error error = {""};
            double out[4];
            CHECK_EQ(bake_spline_solve(&line, keys, 2, &curve, NULL, &error), 0);
            bake_curve_eval(&curve, 0.25 * END[j], out);
            double want = 0.75 * VALUE[i][0] + 0.25 * VALUE[i][1];
            CHECK_NEAR(out[0], want, 1e-14 * (fabs(VALUE[i][0]) + fabs(VALUE[i][1]))); /* 50 eps */
            bake_curve_free(&curve);
        }
    }
}

int main(void)
{
    TEST(two_natural_keys_are_a_line);
    TEST(held_curve_jumps_at_its_keys);
    TEST(linear_curve_connects_its_keys);
    TEST(bspline_is_smooth_and_stays_within_its_control_points);
    TEST(even_bspline_has_the_textbook_values);
    TEST(bad_input_is_named);
    TEST(undetermined_and_contradictory_data_are_refused);
    TEST(resonance_is_explained);
    return check_done();
}
