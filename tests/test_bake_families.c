/* Wiggly splines: symmetries, the solution families and their borders, the integrals.
 * Source: Schulz 2013, 2.5.1; everything here follows from the equation itself.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_random.h"
#include "spline_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- symmetries ------------------------------------------------------------------------------ */

static void check_same(const bake_curve *a, const bake_curve *b, double time_scale)
{
    double at_a[4], at_b[4], unit = 1.0;
    for (int k = 0; k < a->count; k++)
        for (double x = 0.0625; x < 1; x += 0.125) {
            double t = a->segment[k].t0 + x * (a->segment[k].t1 - a->segment[k].t0);
            bake_curve_eval(a, t, at_a);
            bake_curve_eval(b, time_scale * t, at_b);
            unit = 1.0;
            for (int i = 0; i < 3; i++, unit *= time_scale)
                CHECK_NEAR(at_b[i] * unit, at_a[i], 1e-9 * (1 + fabs(at_a[i])));
        }
}

/* Backwards in time damping changes its sign, in the energy too. */
static void reversed_time_gives_the_reversed_curve(void)
{
    bake_key keys[KEYS], back[KEYS];
    for (int trial = 0; trial < 40; trial++) {
        int count = random_keys(keys, 3 + trial % 5);
        bake_spline_problem p = {.mode = random_mode(), .alpha = trial % 3 ? 0 : 2.0}, q;
        q = p;
        q.mode.delta = -q.mode.delta;
        for (int k = 0; k < count; k++) {
            back[k] = keys[count - 1 - k];
            back[k].time = -back[k].time;
        }
        bake_curve a = solved(&p, keys, count, NULL), b = solved(&q, back, count, NULL);
        check_same(&a, &b, -1.0);
        bake_curve_free(&a);
        bake_curve_free(&b);
    }
}

static void scaled_time_gives_the_scaled_curve(void)
{
    bake_key keys[KEYS], slow[KEYS];
    for (int trial = 0; trial < 40; trial++) {
        int count = random_keys(keys, 3 + trial % 5);
        double c = trial & 1 ? 1000.0 : 0.001;
        bake_spline_problem p = {.mode = random_mode(), .gamma = trial % 3 ? 0 : 2.0}, q = p;
        q.mode = (bake_mode){p.mode.lambda / c / c, p.mode.delta / c, p.mode.g / c / c};
        for (int k = 0; k < count; k++) {
            slow[k] = keys[k];
            slow[k].time = c * keys[k].time;
        }
        bake_curve a = solved(&p, keys, count, NULL), b = solved(&q, slow, count, NULL);
        check_same(&a, &b, c);
        bake_curve_free(&a);
        bake_curve_free(&b);
    }
}

/* Linear in keys, end velocities and force together. */
static void superposed_data_give_the_superposed_curve(void)
{
    bake_key keys[3][KEYS];
    bake_curve curve[3];
    double at[3][4];
    for (int trial = 0; trial < 40; trial++) {
        int count = random_keys(keys[0], 3 + trial % 5);
        bake_spline_problem p[3] = {clamped, clamped, clamped};
        p[0].mode = p[1].mode = p[2].mode = random_mode();
        memcpy(keys[1], keys[0], sizeof keys[0]);
        memcpy(keys[2], keys[0], sizeof keys[0]);
        p[0].alpha = p[1].alpha = p[2].alpha = trial & 1 ? 1.0 : 0.0;
        p[0].end_value[0] = 3.0;
        p[1].mode.g = uniform(-4, 4);
        p[1].end_value[0] = uniform(-4, 4);
        p[2].mode.g = p[0].mode.g + p[1].mode.g;
        p[2].end_value[0] = p[0].end_value[0] + p[1].end_value[0];
        for (int k = 0; k < count; k++) {
            keys[1][k].target[0] = uniform(-1, 1);
            keys[2][k].target[0] = keys[0][k].target[0] + keys[1][k].target[0];
        }
        for (int i = 0; i < 3; i++)
            curve[i] = solved(&p[i], keys[i], count, NULL);
        for (int i = 0; i < 50; i++) {
            double t = uniform(keys[0][0].time, keys[0][count - 1].time);
            for (int j = 0; j < 3; j++)
                bake_curve_eval(&curve[j], t, at[j]);
            for (int j = 0; j < 3; j++)
                CHECK_NEAR(at[2][j], at[0][j] + at[1][j],
                           1e-10 * (1 + fabs(at[0][j]) + fabs(at[1][j])));
        }
        for (int i = 0; i < 3; i++)
            bake_curve_free(&curve[i]);
    }
}

/* ---- families -------------------------------------------------------------------------------- */

/* w'''' + 2 (lambda - 2 delta^2) w'' + lambda^2 w + lambda g = 0, the fourth derivative as a
 * difference quotient of the third. A step of 1e-4/R leaves 1e-8/6 of R^4 (R the largest root,
 * at least 1/H), rounding of w''' 1e-15/1e-4 times the terms it is summed from. */
static void check_equation(const bake_segment *s, const bake_mode *mode)
{
    double H = 0.5 * (s->t1 - s->t0), e[3][4], delta = mode->delta, lambda = mode->lambda;
    double p = 2 * (lambda - 2 * delta * delta), q = lambda * lambda;
    double r = fmax(1 / H, fabs(delta) + sqrt(fabs(delta * delta - lambda))), step = 1e-4 / r;
    for (double x = -0.9; x < 1; x += 0.2) {
        double t = 0.5 * (s->t0 + s->t1) + x * H;
        for (int i = 0; i < 3; i++)
            bake_segment_eval(s, t + (i - 1) * step, e[i]);
        double fourth = (e[2][3] - e[0][3]) / (2 * step), force = lambda * mode->g;
        double size = fabs(s->rest) + fabs(s->drive);
        for (int j = 0; j < 4; j++)
            size += fabs(s->w[j]);
        CHECK_NEAR(fourth + p * e[1][2] + q * e[1][0] + force, 0.0, 1e-7 * size * pow(r, 4));
    }
}

static bake_mode mode_near_every_border(int trial)
{
    double root = exp(uniform(log(0.05), log(20)));
    double near = trial % 10 ? copysign(exp(uniform(-18, 2)), uniform(-1, 1)) : 0.0;
    double stiffness = trial % 7 == 0 ? 0.0 : trial % 3 == 0 ? -root * root : root * root;
    double ratio = stiffness < 0.0 ? exp(uniform(-12, 1)) : fmax(0.0, 1.0 + near);
    return (bake_mode){stiffness, ratio * root, uniform(-1, 1)};
}

static void every_family_solves_the_equation(void)
{
    int seen[6] = {0};
    for (int trial = 0; trial < 3000; trial++) {
        bake_mode mode = mode_near_every_border(trial);
        bake_segment s;
        if (trial == 0)
            mode = (bake_mode){0, 0, 1.0};
        bake_segment_prepare(&s, &mode, 0.3, 0.3 + uniform(0.5, 2));
        for (int j = 0; j < 4; j++)
            s.w[j] = uniform(-1, 1);
        seen[s.family]++;
        check_equation(&s, &mode);
    }
    for (int family = 0; family < 6; family++)
        CHECK(seen[family] > 0);
}

static double largest_value(const bake_segment *s)
{
    double largest = 0.0, out[4];
    for (int i = 0; i <= 64; i++) {
        bake_segment_eval(s, s->t0 + (s->t1 - s->t0) * i / 64.0, out);
        largest = fmax(largest, fabs(out[0]));
    }
    return largest;
}

/* The promise of spline.h, for curves from random end data (keys one second apart, H = 1/2). */
static void coefficients_stay_near_the_amplitude(void)
{
    double worst_plain = 0.0, worst_close = 0.0;
    for (int trial = 0; trial < 20000; trial++) {
        bake_key keys[2] = {{0, {uniform(-1, 1), 0, 0}, {BAKE_HARD, 0, 0}},
                            {1, {uniform(-1, 1), 0, 0}, {BAKE_HARD, 0, 0}}};
        bake_spline_problem p = clamped;
        double stretch = exp(uniform(0, 2)), coefficient = 0.0;
        p.mode = mode_near_every_border(trial);
        p.mode.lambda *= stretch * stretch;
        p.mode.delta *= stretch;
        p.mode.g = 0.0;
        for (int i = 0; i < 2; i++)
            p.end_value[i] = uniform(-1, 1) * (trial & 1 ? 1 : sqrt(fabs(p.mode.lambda)));
        bake_curve curve = solved(&p, keys, 2, NULL);
        const bake_segment *s = &curve.segment[0];
        for (int j = 0; j < 4; j++)
            coefficient = fmax(coefficient, fabs(s->w[j]));
        double ratio = coefficient / largest_value(s);
        double gap = s->family == BAKE_EXP ? 0.5 * (s->a - s->b) : s->b;
        int close = s->family != BAKE_SERIES && s->family != BAKE_POLY && gap < s->a;
        CHECK(ratio <= 40 + (close ? 4 * s->a * 0.5 : 0.0));
        *(close ? &worst_close : &worst_plain) =
            fmax(close ? worst_close : worst_plain, close ? ratio / (40 + 2 * s->a) : ratio);
        bake_curve_free(&curve);
    }
    /* not vacuous: random data come within a factor of ten of the bounds */
    CHECK(worst_plain > 4 && worst_close > 0.1);
}

/* The same mode a hair on either side of every threshold gives the same curve. */
static void families_meet_at_their_borders(void)
{
    static const double border[][2] = {{4, 0},     {4, 1},      {4, 2},     {2.56, 1.6}, {100, 10},
                                       {1e4, 100}, {-4, 0},     {-25, 0},   {0, 1},      {0, 1e-9},
                                       {24.19, 5}, {-100, 0.9}, {-25, 0.9}, {9.8696, 0}};
    bake_key keys[3] = {{0, {1, 0, 0}, {BAKE_HARD, 0, 0}},
                        {1, {-0.5, 0, 0}, {BAKE_HARD, 0, 0}},
                        {2, {2, 0, 0}, {BAKE_HARD, 0, 0}}};
    for (size_t i = 0; i < sizeof border / sizeof *border; i++)
        for (int direction = 0; direction < 4; direction++) {
            bake_spline_problem p = clamped, q;
            double unit = 1e-13 * (1 + fabs(border[i][0]));
            p.mode = (bake_mode){border[i][0], border[i][1], 2.0};
            q = p;
            q.mode.lambda += direction & 1 ? unit : -unit;
            q.mode.delta += direction & 2 ? unit : -unit;
            bake_curve a = solved(&p, keys, 3, NULL), b = solved(&q, keys, 3, NULL);
            check_same(&a, &b, 1.0);
            bake_curve_free(&a);
            bake_curve_free(&b);
        }
}

typedef struct {
    const bake_segment *s;
    const bake_mode *mode;
    double energy;
} integral;

static double force(const bake_mode *mode, const double e[4], int derivative)
{
    return e[2 + derivative] + 2 * mode->delta * e[1 + derivative] + mode->lambda * e[derivative];
}

static void add_energy(void *context, double s, double weight)
{
    integral *i = context;
    double e[4];
    bake_segment_eval(i->s, 0.5 * (i->s->t0 + i->s->t1) + s, e);
    i->energy += weight * force(i->mode, e, 0) * force(i->mode, e, 0);
}

/* Integrating f f by parts leaves the boundary terms f w' - f' w + 2 delta f w, because f solves
 * the adjoint equation [Schulz, proof of lemma 2]: an answer without quadrature. */
static void quadrature_equals_the_boundary_terms(void)
{
    for (int trial = 0; trial < 500; trial++) {
        double root = exp(uniform(log(0.1), log(200))), boundary = 0, size = 0, e[4];
        bake_mode mode = {trial % 4 ? root * root : -root * root, root * uniform(0, 3), 0};
        bake_segment s;
        bake_segment_prepare(&s, &mode, 1.0, 2.0);
        for (int j = 0; j < 4; j++)
            s.w[j] = uniform(-1, 1);
        integral sum = {&s, &mode, 0};
        bake_segment_quadrature(&s, add_energy, &sum);
        for (int end = 0; end < 2; end++) {
            bake_segment_eval(&s, 1.0 + end, e);
            double f = force(&mode, e, 0), df = force(&mode, e, 1);
            double terms[3] = {f * e[1], -df * e[0], 2 * mode.delta * f * e[0]};
            for (int i = 0; i < 3; i++) {
                boundary += end ? terms[i] : -terms[i];
                size += fabs(terms[i]);
            }
        }
        CHECK_NEAR(sum.energy, boundary, 1e-12 * size);
    }
}

int main(void)
{
    TEST(reversed_time_gives_the_reversed_curve);
    TEST(scaled_time_gives_the_scaled_curve);
    TEST(superposed_data_give_the_superposed_curve);
    TEST(every_family_solves_the_equation);
    TEST(coefficients_stay_near_the_amplitude);
    TEST(families_meet_at_their_borders);
    TEST(quadrature_equals_the_boundary_terms);
    return check_done();
}
