/* Equilibria against closed forms: bars that are pulled, bent and pushed.
 * SPDX-License-Identifier: MIT */
#include "body_shapes.h"
#include "check.h"
#include "sparse.h"
#include "statics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define YOUNG   1e6
#define POISSON 0.3

/* ---- bars ------------------------------------------------------------------------------------ */

/* A bar along x, 1 wide, and what a test does to it. */
typedef struct {
    body b;
    double length;
    freedom held;
    double *x, *target;
    int *vertex, dragged;
} bar;

static bar bar_make(double length, int along, int across, double poisson)
{
    bar s = {.length = length, .b.material = {YOUNG, poisson, 1000, 0}};
    bake_error error = {""};
    box_tets(&s.b, (const double[]){length, 1, 1}, (const int[]){along, across, across});
    CHECK_EQ(body_prepare(&s.b, &error), 0);
    size_t n = (size_t)s.b.vertex_count;
    freedom_make(s.b.vertex_count, &s.held);
    s.x = bake_alloc(3 * n, sizeof *s.x);
    s.target = bake_alloc(3 * n, sizeof *s.target);
    s.vertex = bake_alloc(n, sizeof *s.vertex);
    memcpy(s.x, s.b.rest, 3 * n * sizeof *s.x);
    return s;
}

static void bar_free(bar *s)
{
    body_free(&s->b);
    freedom_free(&s->held);
    free(s->x);
    free(s->target);
    free(s->vertex);
}

/* Drags the vertices with x = at to scale * rest + by. */
static void drag(bar *s, double at, const double scale[3], const double by[3])
{
    for (int i = 0; i < s->b.vertex_count; i++) {
        const double *rest = &s->b.rest[3 * i];
        if (rest[0] == at) {
            for (int k = 0; k < 3; k++) {
                s->target[3 * s->dragged + k] = scale[k] * rest[k] + by[k];
            }
            s->vertex[s->dragged++] = i;
        }
    }
}

static int solve(bar *s, const double *force, bake_error *error)
{
    statics_drag d = {s->dragged, s->vertex, s->target};
    return statics_solve(&s->b, &s->held, &d, force, s->x, error);
}

static const double as_it_is[3] = {1, 1, 1}, stays[3] = {0, 0, 0};

/* |free gradient| over |reactions|; dragged vertices are where they should be. reaction: sums over
 * the vertices that rest at x = at. */
static double balance(const bar *s, double at, double reaction[3])
{
    int n = s->b.vertex_count;
    double *r = bake_alloc(3 * (size_t)n, sizeof *r), open = 0, all = 0;
    double *y = bake_alloc(3 * (size_t)n, sizeof *y);
    body_gradient(&s->b, s->x, r);
    memset(reaction, 0, 3 * sizeof *reaction);
    for (int i = 0; i < 3 * n; i++) {
        all += r[i] * r[i];
        reaction[i % 3] += s->b.rest[i - i % 3] == at ? r[i] : 0;
    }
    for (int i = 0; i < s->dragged; i++) {
        for (int k = 0; k < 3; k++) {
            CHECK_NEAR(s->x[3 * s->vertex[i] + k], s->target[3 * i + k], 1e-14 * s->length);
            r[3 * s->vertex[i] + k] = 0;
        }
    }
    freedom_restrict(&s->held, r, y);
    for (int i = 0; i < s->held.count; i++) {
        open += y[i] * y[i];
    }
    free(r);
    free(y);
    return sqrt(open / (all - open));
}

/* ---- pulled ---------------------------------------------------------------------------------- */

/* St. Venant and Kirchhoff in one direction: stretched by a, the sides shrink to t, t^2 = 1 - nu
 * (a^2 - 1), where there is no stress across; V = Y/8 (a^2 - 1)^2 a volume, and its derivative is
 * the force. Affine states are exact for linear elements, so only the convergence of Newton's
 * method is left: 1e-8 of the reactions, in bars no softer than their ends: 1e-7 of the length. */
static void a_bar_that_is_pulled_is_as_thin_as_it_should_be(void)
{
    static const double stretches[] = {0.9, 1.001, 1.5};
    for (int c = 0; c < 3; c++) {
        bar s = bar_make(4, 8, 2, POISSON);
        bake_error error = {""};
        double a = stretches[c], strain = a * a - 1, t = sqrt(1 - POISSON * strain), reaction[3];
        freedom_finish(&s.held);
        drag(&s, 0, (const double[]){a, t, t}, stays);
        drag(&s, 4, (const double[]){a, t, t}, stays);
        CHECK_EQ(solve(&s, NULL, &error), 0);
        CHECK(balance(&s, 4, reaction) <= 1.0001e-8);
        for (int i = 0; i < 3 * s.b.vertex_count; i++) {
            CHECK_NEAR(s.x[i], s.b.rest[i] * (i % 3 == 0 ? a : t), 4e-7);
        }
        double force = YOUNG / 2 * strain * a;
        CHECK_NEAR(body_energy(&s.b, s.x), 4 * YOUNG / 8 * strain * strain, 1e-6 * fabs(force));
        CHECK_NEAR(reaction[0], force, 1e-6 * fabs(force));
        bar_free(&s);
    }
}

/* The same state by forces: thirds of triangles on the end face pull with Y/2 (a^2 - 1) a in all;
 * three faces slide in their planes. */
static void forces_on_a_sliding_bar_stretch_it_as_much(void)
{
    bar s = bar_make(3, 6, 2, POISSON);
    bake_error error = {""};
    double a = 1.2, strain = a * a - 1, t = sqrt(1 - POISSON * strain), pull = 0;
    double *force = bake_alloc(3 * (size_t)s.b.vertex_count, sizeof *force);
    for (int i = 0; i < s.b.vertex_count; i++) {
        for (int k = 0; k < 3; k++) {
            if (s.b.rest[3 * i + k] == 0) {
                freedom_slide(&s.held, i, (const double[]){k == 0, k == 1, k == 2});
            }
        }
    }
    freedom_finish(&s.held);
    for (int e = 0; e < s.b.element_count;
         e++) { /* all triangles of the face have an area of 1/8 */
        int on = 0;
        for (int c = 0; c < 4; c++) {
            on += s.b.rest[3 * s.b.element[e][c]] == 3;
        }
        for (int c = 0; on == 3 && c < 4; c++) {
            int v = s.b.element[e][c];
            force[3 * v] += s.b.rest[3 * v] == 3 ? YOUNG / 2 * strain * a / 24 : 0;
        }
    }
    for (int i = 0; i < s.b.vertex_count; i++) {
        pull += force[3 * i];
    }
    CHECK_NEAR(pull, YOUNG / 2 * strain * a, 1e-6);
    CHECK_EQ(solve(&s, force, &error), 0);
    for (int i = 0; i < 3 * s.b.vertex_count; i++) {
        CHECK_NEAR(s.x[i], s.b.rest[i] * (i % 3 == 0 ? a : t), 3e-7);
    }
    free(force);
    bar_free(&s);
}

/* ---- bent ------------------------------------------------------------------------------------ */

/* The force that moves one end of a clamped bar sideways by `by`, both ends upright. */
static double bend(int across, double by)
{
    bar s = bar_make(10, 5 * across, across, 0);
    bake_error error = {""};
    double reaction[3];
    freedom_finish(&s.held);
    drag(&s, 0, as_it_is, stays);
    drag(&s, 10, as_it_is, (const double[]){0, by, 0});
    CHECK_EQ(solve(&s, NULL, &error), 0);
    CHECK(balance(&s, 10, reaction) <= 1.0001e-8);
    bar_free(&s);
    return reaction[1];
}

/* 12 E I / L^3 for slow bending, softened by shear: / (1 + 12 E I / (kappa G A L^2)), kappa = 5/6,
 * G = E/2. Linear elements are too stiff by C h^2: Richardson leaves a fourth order of which the
 * bars of test_bake_modes.c show 0.1 % at these sizes; the clamps stiffen by an end effect of less
 * than h/L of it. Bending is odd: force(2 d) = 2 force(d) (1 + O(d^2 / width^2)), membrane stresses
 * of (d/L)^2. */
static void a_small_drag_bends_a_bar_as_beam_theory_says(void)
{
    double d = 1e-3, coarse = bend(2, d) / d, fine = bend(4, d) / d;
    double expected = YOUNG / 1000 / (1 + 12 / 12 / (5.0 / 6 * 0.5 * 100));
    CHECK_NEAR((4 * fine - coarse) / 3 / expected, 1, 0.02);
    CHECK_NEAR(bend(2, 2 * d) / (2 * d) / coarse, 1, 10 * d * d);
    if (getenv("VERBOSE")) {
        printf("  bending force / theory: %.4f %.4f, limit %.4f\n", coarse / expected,
               fine / expected, (4 * fine - coarse) / 3 / expected);
    }
}

/* Half a bar's length sideways and a quarter back: far from linear; the energy is below that of a
 * straight shear (which is admissible), and the pose is the same in one drag and in two. */
static void a_large_drag_ends_in_equilibrium(void)
{
    bar once = bar_make(10, 20, 2, POISSON), twice = bar_make(10, 20, 2, POISSON);
    bake_error error = {""};
    double reaction[3], apart = 0;
    for (int i = 0; i < 2; i++) {
        bar *s = i ? &twice : &once;
        freedom_finish(&s->held);
        drag(s, 0, as_it_is, stays);
        drag(s, 10, as_it_is, (const double[]){-2.5, 5, 0});
    }
    CHECK_EQ(solve(&once, NULL, &error), 0);
    CHECK(balance(&once, 10, reaction) <= 1.0001e-8);
    for (int i = 0; i < twice.dragged; i++) {
        twice.target[3 * i + 0] += twice.b.rest[3 * twice.vertex[i]] == 10 ? 1.5 : 0;
    }
    CHECK_EQ(solve(&twice, NULL, &error), 0);
    for (int i = 0; i < twice.dragged; i++) {
        twice.target[3 * i + 0] -= twice.b.rest[3 * twice.vertex[i]] == 10 ? 1.5 : 0;
    }
    CHECK_EQ(solve(&twice, NULL, &error), 0);
    for (int i = 0; i < 3 * once.b.vertex_count; i++) {
        apart = fmax(apart, fabs(once.x[i] - twice.x[i]));
        twice.x[i] = once.b.rest[i]; /* sheared, for the energy */
    }
    CHECK_NEAR(apart, 0, 1e-5);
    for (int i = 0; i < once.b.vertex_count; i++) {
        twice.x[3 * i] -= 0.25 * once.b.rest[3 * i];
        twice.x[3 * i + 1] += 0.5 * once.b.rest[3 * i];
    }
    CHECK(body_energy(&once.b, once.x) < body_energy(&once.b, twice.x));
    bar_free(&once);
    bar_free(&twice);
}

/* ---- pushed ---------------------------------------------------------------------------------- */

/* How far a bar leaves its axis when its ends are pushed together by `share` of its length; its
 * equilibrium has to be a minimum: there is a factor without a shift. */
static double push(double share)
{
    bar s = bar_make(10, 20, 4, 0);
    bake_error error = {""};
    body_blocks blocks = {0};
    double reaction[3], most = 0;
    freedom_finish(&s.held);
    drag(&s, 0, as_it_is, stays);
    drag(&s, 10, as_it_is, (const double[]){-10 * share, 0, 0});
    CHECK_EQ(solve(&s, NULL, &error), 0);
    CHECK(balance(&s, 10, reaction) <= 1.0001e-8);
    for (int i = 0; i < 3 * s.b.vertex_count; i++) {
        most = fmax(most, i % 3 == 0 ? 0 : fabs(s.x[i] - s.b.rest[i]));
    }
    freedom free_ones;
    sparse K;
    freedom_make(s.b.vertex_count, &free_ones);
    for (int i = 0; i < s.dragged; i++) {
        freedom_fix(&free_ones, s.vertex[i]);
    }
    freedom_finish(&free_ones);
    body_hessian(&s.b, s.x, &blocks);
    CHECK_EQ(sparse_from_blocks(&blocks, &free_ones, &K, &error), 0);
    sparse_factor *f = sparse_analyse(&K, &error);
    CHECK(f != NULL && sparse_refactor(f, &K, 0, NULL, &error) == 0);
    sparse_factor_free(f);
    sparse_free(&K);
    body_blocks_free(&blocks);
    freedom_free(&free_ones);
    bar_free(&s);
    return most;
}

/* Euler: a clamped bar buckles at a strain of 4 pi^2 I / (A L^2) = 3.3 %, this mesh bends 1.44
 * times as hard (test_bake_modes.c): 4.7 %. Pushed by s beyond it, its half wave rises to about
 * (2 L/pi) sqrt(s - 4.7 %) = 1.5 for 10 %. */
static void a_bar_that_is_pushed_too_far_buckles(void)
{
    CHECK(push(0.03) < 1e-6);
    double rise = push(0.10);
    CHECK(rise > 1 && rise < 2.2);
}

/* ---- little held ----------------------------------------------------------------------------- */

/* One corner pulls the rest along, which may turn as it likes, but not stretch. */
static void a_free_body_follows_one_vertex_without_a_strain(void)
{
    bar s = bar_make(2, 4, 2, POISSON);
    bake_error error = {""};
    freedom_finish(&s.held);
    s.vertex[0] = 0;
    s.dragged = 1;
    s.target[0] = 1.0;
    s.target[1] = -0.5;
    CHECK_EQ(solve(&s, NULL, &error), 0);
    for (int e = 0; e < s.b.element_count; e++) {
        for (int c = 1; c < 4; c++) {
            double now = 0, then = 0;
            for (int k = 0; k < 3; k++) {
                int a = 3 * s.b.element[e][0] + k, b = 3 * s.b.element[e][c] + k;
                now += pow(s.x[a] - s.x[b], 2);
                then += pow(s.b.rest[a] - s.b.rest[b], 2);
            }
            CHECK_NEAR(sqrt(now), sqrt(then), 1e-6);
        }
    }
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(s.x[k], s.target[k], 1e-14);
    }
    bar_free(&s);
}

static void nothing_moves_when_nothing_is_dragged(void)
{
    bar s = bar_make(2, 4, 2, POISSON);
    bake_error error = {""};
    freedom_finish(&s.held);
    CHECK_EQ(solve(&s, NULL, &error), 0);
    CHECK(memcmp(s.x, s.b.rest, 3 * (size_t)s.b.vertex_count * sizeof *s.x) == 0);
    bar_free(&s);
}

/* ---- impossible ------------------------------------------------------------------------------ */

static void a_drag_through_the_body_fails_and_says_how_far_it_got(void)
{
    bar s = bar_make(10, 20, 2, POISSON);
    bake_error error = {""};
    int percent = -1;
    freedom_finish(&s.held);
    drag(&s, 0, as_it_is, stays);
    drag(&s, 10, as_it_is, (const double[]){-15, 0, 0});
    CHECK_EQ(solve(&s, NULL, &error), -1);
    CHECK(sscanf(error.text, "the drag got %d%% of the way", &percent) == 1);
    CHECK(percent >= 0 && percent < 67); /* at 67 % the ends meet */
    CHECK(memcmp(s.x, s.b.rest, 3 * (size_t)s.b.vertex_count * sizeof *s.x) == 0);
    bar_free(&s);
}

/* A force on a body that nothing holds. */
static void a_body_that_falls_has_no_equilibrium(void)
{
    bar s = bar_make(2, 4, 2, POISSON);
    bake_error error = {""};
    double *force = bake_alloc(3 * (size_t)s.b.vertex_count, sizeof *force);
    freedom_finish(&s.held);
    for (int i = 0; i < s.b.vertex_count; i++) {
        force[3 * i + 1] = -9.81 * s.b.mass[i];
    }
    CHECK_EQ(solve(&s, force, &error), -1);
    CHECK(strstr(error.text, "is something not held that forces push"));
    free(force);
    bar_free(&s);
}

static void targets_that_are_no_numbers_are_refused(void)
{
    bar s = bar_make(2, 4, 2, POISSON);
    bake_error error = {""};
    freedom_finish(&s.held);
    drag(&s, 2, as_it_is, (const double[]){0, NAN, 0});
    CHECK_EQ(solve(&s, NULL, &error), -1);
    CHECK(strstr(error.text, "is dragged to"));
    s.target[1] = 0;
    s.vertex[0] = s.b.vertex_count;
    CHECK_EQ(solve(&s, NULL, &error), -1);
    bar_free(&s);
}

int main(void)
{
    TEST(a_bar_that_is_pulled_is_as_thin_as_it_should_be);
    TEST(forces_on_a_sliding_bar_stretch_it_as_much);
    TEST(a_small_drag_bends_a_bar_as_beam_theory_says);
    TEST(a_large_drag_ends_in_equilibrium);
    TEST(a_bar_that_is_pushed_too_far_buckles);
    TEST(a_free_body_follows_one_vertex_without_a_strain);
    TEST(nothing_moves_when_nothing_is_dragged);
    TEST(a_drag_through_the_body_fails_and_says_how_far_it_got);
    TEST(a_body_that_falls_has_no_equilibrium);
    TEST(targets_that_are_no_numbers_are_refused);
    return check_done();
}
