/* Wiggly splines against the high-precision oracle, and the properties they must have by theory.
 * Source: Schulz 2013, 2.4-2.5; vectors from tests/reference/spline_oracle.py.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_random.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* E_reg by Simpson's rule over 2000 panels a segment: independent of the solver's integrals. */
static double energy_of(const bake_spline_problem *p, const bake_curve *a, const bake_curve *b,
                        double step, double (*bump)(const bake_curve *, double, int))
{
    double total = 0.0, state[4], other[4], d[3];
    for (int k = 0; k < a->count; k++)
        for (int i = 0; i <= 4000; i++) {
            const bake_segment *s = &a->segment[k];
            double h = (s->t1 - s->t0) / 4000, t = s->t0 + i * h;
            bake_segment_eval(s, t, state);
            bake_segment_eval(&b->segment[k], t, other);
            for (int j = 0; j < 3; j++)
                d[j] = state[j] + step * (bump ? bump(a, t, j) : other[j] - state[j]);
            double f = d[2] + 2 * p->mode.delta * d[1] + p->mode.lambda * d[0] + p->mode.g;
            double e =
                f * f + p->alpha * d[0] * d[0] + p->beta * d[1] * d[1] + p->gamma * d[2] * d[2];
            total += e * h / 3 * (i == 0 || i == 4000 ? 1 : i & 1 ? 4 : 2);
        }
    return total;
}

/* ---- oracle ---------------------------------------------------------------------------------- */

typedef struct {
    char name[64];
    bake_spline_problem problem;
    bake_key keys[KEYS];
    int count, read;
    double size[3], energy, longest;
} oracle_case;

static void read_numbers(const char *text, double *out, int count)
{
    char *rest;
    for (int i = 0; i < count; i++, text = rest + (*rest == ','))
        out[i] = strtod(text, &rest);
}

static void read_case(const char *line, oracle_case *c)
{
    double v[15];
    int name = 0;
    *c = (oracle_case){0};
    sscanf(line, "case,%63[^,],%n", c->name, &name);
    read_numbers(line + name, v, 15);
    c->problem = (bake_spline_problem){
        {v[0], v[1], v[2]}, {(bake_end)v[3], (bake_end)v[4]}, {v[5], v[6]}, v[7], v[8], v[9]};
    c->count = (int)v[10];
    memcpy(c->size, v + 11, sizeof c->size);
    c->energy = v[14];
}

static void read_key(const char *line, oracle_case *c)
{
    double v[7];
    read_numbers(line, v, 7);
    bake_key key = {v[0], {v[1], v[2], v[3]}, {v[4], v[5], v[6]}};
    if (c->read)
        c->longest = fmax(c->longest, key.time - c->keys[c->read - 1].time);
    c->keys[c->read++] = key;
}

/* 1e-9 of the amplitude in value, h velocity and h^2 acceleration. Thin layers of overdamped modes
 * move faster than amplitude/h: there it is 1e-9 of the largest velocity or acceleration. Worst
 * measured: 3.5e-11 at 1e-3 from resonance, 1.3e-11 with soft weights, 1e-12 elsewhere. */
static void check_sample(const oracle_case *c, const bake_curve *curve, const char *line)
{
    double v[4], got[4], unit = 1.0;
    read_numbers(line, v, 4);
    bake_curve_eval(curve, v[0], got);
    for (int i = 0; i < 3; i++, unit /= c->longest) {
        double tolerance = 1e-9 * fmax(c->size[i], c->size[0] * unit);
        CHECK_NEAR(got[i], v[i + 1], tolerance);
        if (!(fabs(got[i] - v[i + 1]) <= tolerance))
            printf("case %s, derivative %d at %g\n", c->name, i, v[0]);
    }
}

/* The perturbation w -> w + eps of data and roundoff moves E by sqrt(E) at most; f^2 of amplitude:
 * |lambda| size + |2 delta| size' + size'' bounds f. */
static void check_energy(const oracle_case *c, const bake_spline_report *report, double span)
{
    const bake_mode *mode = &c->problem.mode;
    double force = fabs(mode->lambda) * c->size[0] + 2 * mode->delta * c->size[1] + c->size[2];
    if (c->energy >= 0.0)
        CHECK_NEAR(sqrt(report->energy), sqrt(c->energy), 1e-9 * force * sqrt(span));
}

static void oracle_agrees_to_1e_9_of_the_amplitude(void)
{
    char line[1024];
    oracle_case c = {.count = -1};
    bake_curve curve = {0};
    bake_spline_report report;
    int cases = 0, samples = 0;
    FILE *file = fopen("tests/vectors/spline_oracle.csv", "r");
    CHECK(file != NULL);
    while (file && fgets(line, sizeof line, file)) {
        if (line[0] == 'c')
            read_case(line, &c);
        if (line[0] == 'k')
            read_key(line + 4, &c);
        if (line[0] == 'k' && c.read == c.count) {
            bake_curve_free(&curve);
            curve = solved(&c.problem, c.keys, c.count, &report);
            check_energy(&c, &report, c.keys[c.count - 1].time - c.keys[0].time);
            cases++;
        }
        if (line[0] == 'a' && curve.count && ++samples)
            check_sample(&c, &curve, line + 3);
    }
    CHECK(cases > 380 && samples > 2500);
    bake_curve_free(&curve);
    if (file)
        fclose(file);
}

/* ---- interpolation and smoothness ------------------------------------------------------------ */

static void check_join(const bake_segment *a, const bake_segment *b, double size)
{
    double left[4], right[4], h = fmin(a->t1 - a->t0, b->t1 - b->t0), unit = 1.0;
    bake_segment_eval(a, a->t1, left);
    bake_segment_eval(b, b->t0, right);
    for (int i = 0; i < 3; i++, unit /= h)
        CHECK_NEAR(left[i], right[i], 1e-11 * (size * unit + fabs(left[i])));
}

static void keys_are_hit_and_joined_twice_differentiably(void)
{
    bake_key keys[KEYS];
    for (int trial = 0; trial < 200; trial++) {
        bake_spline_problem p = clamped;
        int count = random_keys(keys, 2 + trial % 14);
        p.mode = random_mode();
        p.end_value[0] = uniform(-2, 2);
        p.alpha = trial % 3 ? 0.0 : 0.5;
        bake_curve curve = solved(&p, keys, count, NULL);
        double out[4];
        for (int k = 0; k < count; k++) {
            bake_curve_eval(&curve, keys[k].time, out);
            CHECK_NEAR(out[0], keys[k].target[0], 1e-12);
            if (k > 0 && k < count - 1)
                check_join(&curve.segment[k - 1], &curve.segment[k], 1.0);
        }
        bake_curve_eval(&curve, keys[0].time, out);
        CHECK_NEAR(out[1], p.end_value[0], 1e-11);
        bake_curve_free(&curve);
    }
}

static void periodic_curve_closes_twice_differentiably(void)
{
    bake_key keys[KEYS];
    for (int trial = 0; trial < 60; trial++) {
        bake_spline_problem p = {.end = {BAKE_END_PERIODIC, BAKE_END_PERIODIC}};
        int count = random_keys(keys, 2 + trial % 8);
        p.mode = random_mode();
        p.beta = trial & 1 ? 0.3 : 0.0;
        keys[count - 1].target[0] = keys[0].target[0];
        bake_curve curve = solved(&p, keys, count, NULL);
        check_join(&curve.segment[count - 2], &curve.segment[0], 1.0);
        bake_curve_free(&curve);
    }
}

/* ---- known answers --------------------------------------------------------------------------- */

/* Textbook cubic spline: tridiagonal system for the second derivatives M at the keys. */
static void textbook_cubic(const bake_key *keys, int n, const double *v, double M[KEYS])
{
    double a[KEYS] = {0}, b[KEYS] = {0}, c[KEYS] = {0}, d[KEYS] = {0};
    for (int k = 0; k < n; k++) {
        double h0 = k ? keys[k].time - keys[k - 1].time : 0;
        double h1 = k < n - 1 ? keys[k + 1].time - keys[k].time : 0;
        double s0 = k ? (keys[k].target[0] - keys[k - 1].target[0]) / h0 : v ? v[0] : 0;
        double s1 = k < n - 1 ? (keys[k + 1].target[0] - keys[k].target[0]) / h1 : v ? v[1] : 0;
        int natural = !v && (k == 0 || k == n - 1);
        a[k] = natural ? 0 : h0 / 6;
        b[k] = natural ? 1 : (h0 + h1) / 3;
        c[k] = natural ? 0 : h1 / 6;
        d[k] = natural ? 0 : s1 - s0;
    }
    for (int k = 1; k < n; k++) {
        b[k] -= a[k] / b[k - 1] * c[k - 1];
        d[k] -= a[k] / b[k - 1] * d[k - 1];
    }
    for (int k = n - 1; k >= 0; k--)
        M[k] = (d[k] - (k < n - 1 ? c[k] * M[k + 1] : 0)) / b[k];
}

static void without_stiffness_it_is_the_cubic_spline(void)
{
    bake_key keys[KEYS];
    double M[KEYS], out[4];
    for (int trial = 0; trial < 40; trial++) {
        int natural = trial & 1, count = random_keys(keys, 3 + trial % 9);
        bake_spline_problem p = {.end_value = {natural ? 0 : 1.5, natural ? 0 : -0.5}};
        p.end[0] = p.end[1] = natural ? BAKE_END_FREE : BAKE_END_VELOCITY;
        bake_curve curve = solved(&p, keys, count, NULL);
        textbook_cubic(keys, count, natural ? NULL : p.end_value, M);
        for (int k = 0; k < count - 1; k++) {
            double h = keys[k + 1].time - keys[k].time, t = uniform(0, h), r = h - t;
            double want = (M[k] * r * r * r + M[k + 1] * t * t * t) / (6 * h) +
                          (keys[k].target[0] / h - M[k] * h / 6) * r +
                          (keys[k + 1].target[0] / h - M[k + 1] * h / 6) * t;
            bake_curve_eval(&curve, keys[k].time + t, out);
            CHECK_NEAR(out[0], want, 1e-12);
            CHECK_NEAR(out[2], (M[k] * r + M[k + 1] * t) / h, 1e-10);
        }
        bake_curve_free(&curve);
    }
}

/* w = -g/lambda + e^(-delta t) cos(eta t) costs nothing, so it must come back, with E = 0. */
static void data_of_a_free_oscillation_gives_it_back(void)
{
    double delta = 0.7, eta = 5.0, lambda = delta * delta + eta * eta, g = 3.0;
    for (int end = 0; end < 2; end++) {
        bake_key keys[6];
        for (int k = 0; k < 6; k++) {
            double t = 0.37 * k;
            keys[k] =
                (bake_key){t, {exp(-delta * t) * cos(eta * t) - g / lambda, 0, 0}, {-1, 0, 0}};
        }
        bake_spline_problem p = {.mode = {lambda, delta, g}};
        double T = keys[5].time, out[4];
        p.end[0] = p.end[1] = end ? BAKE_END_FREE : BAKE_END_VELOCITY;
        p.end_value[0] = end ? 0.0 : -delta;
        p.end_value[1] = end ? 0.0 : -exp(-delta * T) * (delta * cos(eta * T) + eta * sin(eta * T));
        bake_spline_report report;
        bake_curve curve = solved(&p, keys, 6, &report);
        CHECK(report.energy < 1e-20);
        for (double t = 0; t < T; t += 0.01) {
            bake_curve_eval(&curve, t, out);
            CHECK_NEAR(out[0], exp(-delta * t) * cos(eta * t) - g / lambda, 1e-12);
        }
        bake_curve_free(&curve);
    }
}

/* Erratum S2: for lambda = 0 the force keeps its linear term; two free keys give the parabola of
 * free fall, w'' = -g, with delta = 0, and fall with drag, w'' + 2 delta w' = -g, otherwise. */
static void without_stiffness_the_force_still_acts(void)
{
    bake_key keys[2] = {{0.0, {1, 0, 0}, {-1, 0, 0}}, {0.5, {2, 0, 0}, {-1, 0, 0}}};
    for (int i = 0; i < 5; i++) {
        bake_spline_problem p = {.mode = {0.0, 0.0, 9.81}};
        double out[4];
        p.mode.delta = (double[]){0.0, 1e-6, 0.3, 3.0, 40.0}[i];
        p.alpha = 0.0;
        bake_spline_report report;
        bake_curve curve = solved(&p, keys, 2, &report);
        CHECK(report.energy < 1e-18);
        for (double t = 0.05; t < 0.5; t += 0.1) {
            bake_curve_eval(&curve, t, out);
            CHECK_NEAR(out[2] + 2 * p.mode.delta * out[1], -9.81, 1e-9);
        }
        bake_curve_free(&curve);
    }
}

/* ---- minimality ------------------------------------------------------------------------------ */

/* A smooth function that vanishes at every key: product of (t - t_k) times cos(3 t + j). */
static double bump(const bake_curve *curve, double t, int derivative)
{
    double p[3] = {1, 0, 0}, out[3];
    for (int k = 0; k <= curve->count; k++) {
        double x = t - (k ? curve->segment[k - 1].t1 : curve->segment[0].t0);
        p[2] = p[2] * x + 2 * p[1];
        p[1] = p[1] * x + p[0];
        p[0] = p[0] * x;
    }
    double c = cos(3 * t + 1), s = sin(3 * t + 1);
    out[0] = p[0] * c;
    out[1] = p[1] * c - 3 * p[0] * s;
    out[2] = p[2] * c - 6 * p[1] * s - 9 * p[0] * c;
    return out[derivative];
}

static void check_minimum(const bake_spline_problem *p, const bake_curve *a, const bake_curve *b,
                          double (*direction)(const bake_curve *, double, int))
{
    double at = energy_of(p, a, b, 0.0, direction), step = 0.01;
    double up = energy_of(p, a, b, step, direction), down = energy_of(p, a, b, -step, direction);
    CHECK(up > at && down > at);
    /* a minimum, not just a lower neighbour: the slope vanishes against the curvature */
    CHECK(fabs(up - down) <= 1e-6 * (up + down - 2 * at) / step);
}

static void perturbations_never_lower_the_energy(void)
{
    bake_key keys[KEYS];
    for (int trial = 0; trial < 12; trial++) {
        int count = random_keys(keys, 3 + trial % 3);
        bake_spline_problem p = {.mode = random_mode()}, other;
        bake_curve a = solved(&p, keys, count, NULL);
        check_minimum(&p, &a, &a, bump);
        bake_curve_free(&a);
        /* with a regulariser the minimum is over the span: another spline through the same keys */
        p.alpha = trial & 1 ? 30.0 : 0.0;
        p.beta = trial & 1 ? 0.0 : 20.0;
        p.gamma = 0.4;
        other = clamped;
        other.mode = p.mode;
        a = solved(&p, keys, count, NULL);
        bake_curve b = solved(&other, keys, count, NULL);
        check_minimum(&p, &a, &b, NULL);
        bake_curve_free(&a);
        bake_curve_free(&b);
    }
}

static void free_ends_satisfy_the_natural_condition(void)
{
    bake_key keys[KEYS];
    double out[4];
    for (int trial = 0; trial < 60; trial++) {
        int count = random_keys(keys, 2 + trial % 6), direct = trial & 1;
        bake_spline_problem p = {.mode = random_mode()};
        if (!direct)
            keys[1] = (bake_key){keys[1].time, {keys[1].target[0], 0, 0}, {100.0, 0, 0}};
        if (!direct && count < 4)
            continue;
        bake_curve curve = solved(&p, keys, count, NULL);
        for (int end = 0; end < 2; end++) {
            bake_curve_eval(&curve, keys[end ? count - 1 : 0].time, out);
            double parts[4] = {out[2], 2 * p.mode.delta * out[1], p.mode.lambda * out[0], p.mode.g};
            double sum = 0, size = 100;
            for (int i = 0; i < 4; i++) {
                sum += parts[i];
                size += fabs(parts[i]);
            }
            CHECK_NEAR(sum, 0.0, 1e-9 * size);
        }
        bake_curve_free(&curve);
    }
}

static void a_growing_weight_tends_to_a_hard_key(void)
{
    bake_key keys[4];
    random_keys(keys, 4);
    bake_spline_problem p = {.mode = {30.0, 0.8, 1.0}};
    double before = HUGE_VAL, out[4];
    for (double weight = 1.0; weight <= 1e12; weight *= 100) {
        keys[2].weight[0] = weight;
        bake_curve curve = solved(&p, keys, 4, NULL);
        bake_curve_eval(&curve, keys[2].time, out);
        double gap = fabs(out[0] - keys[2].target[0]);
        CHECK(gap < before);
        before = gap;
        bake_curve_free(&curve);
    }
    /* gap = jump of f' / weight, and f' is of the order lambda^1.5 = 160 */
    CHECK(before > 0.0 && before < 1e-8);
}

int main(void)
{
    TEST(oracle_agrees_to_1e_9_of_the_amplitude);
    TEST(keys_are_hit_and_joined_twice_differentiably);
    TEST(periodic_curve_closes_twice_differentiably);
    TEST(without_stiffness_it_is_the_cubic_spline);
    TEST(data_of_a_free_oscillation_gives_it_back);
    TEST(without_stiffness_the_force_still_acts);
    TEST(perturbations_never_lower_the_energy);
    TEST(free_ends_satisfy_the_natural_condition);
    TEST(a_growing_weight_tends_to_a_hard_key);
    return check_done();
}
