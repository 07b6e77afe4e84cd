/* Bases for a tolerance on the largest error, against cases that can be solved by hand.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "shape_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define VERTICES 100
#define ROWS     (3 * VERTICES)
#define FRAMES   24

static shape_reduction reduction(int bits)
{
    shape_reduction r = {.rows = ROWS, .columns = FRAMES, .bits = bits, .every = 1, .most = 16};
    r.residual = bake_alloc(ROWS * FRAMES, sizeof *r.residual);
    r.basis = bake_alloc(16, sizeof *r.basis);
    return r;
}

static const shape_span ALL = {0, FRAMES};

/* ---- directions ------------------------------------------------------------------------------- */

/* All vertices move by 0.5, and one of them by 1 at other times: the first motion has 25 times the
 * energy and is the first principal component. But only the second one is beyond 0.6. */
static void one_vertex(shape_reduction *r)
{
    for (int f = 0; f < FRAMES; f++) {
        for (int i = 0; i < VERTICES; i++) {
            r->residual[f * ROWS + 3 * i] = f % 2 ? 0.5 : -0.5;
        }
        r->residual[f * ROWS + 3 * 7 + 1] = f / 2 % 2 ? 1 : -1;
    }
}

static void what_is_beyond_the_tolerance_comes_before_what_has_energy(void)
{
    shape_reduction r = reduction(0);
    shape_directions d;
    shape_pca p;
    bake_error error = {""};
    one_vertex(&r);
    CHECK_EQ(shape_pca_make(r.residual, ROWS, FRAMES, 1, &p, &error), 0);
    CHECK_NEAR(fabs(p.B[3 * 7 + 1]), 0, 1e-9); /* the first component leaves the vertex alone */
    CHECK_EQ(shape_weigh(&r, ALL, 0.6, &d, &error), 0);
    CHECK_EQ(d.enough, 1);
    for (int i = 0; i < ROWS; i++) { /* of the one direction, nearly all is that vertex's */
        CHECK(i == 3 * 7 + 1 || fabs(d.B[i]) <= 0.2 * fabs(d.B[3 * 7 + 1]));
    }
    free(d.B);
    shape_pca_free(&p);
    shape_reduction_free(&r);
}

/* Two directions hold everything; in one, the limit below 0.5 cannot be met. */
static void directions_out_of_reach_are_the_plain_ones(void)
{
    shape_reduction r = reduction(0);
    shape_directions d;
    bake_error error = {""};
    one_vertex(&r);
    r.most = 1;
    CHECK_EQ(shape_weigh(&r, ALL, 0.4, &d, &error), 0);
    CHECK_EQ(d.count, 1);
    CHECK_EQ(d.enough, 2);
    for (int i = 0; i < VERTICES; i++) { /* orthonormal: 1 / sqrt(100) each */
        CHECK_NEAR(fabs(d.B[3 * i]), 0.1, 1e-9);
    }
    free(d.B);
    shape_reduction_free(&r);
}

/* ---- weights ---------------------------------------------------------------------------------- */

/* One basis, all vertices by 1 along x; of five, one is to move by 1 and four are to stay. Least
 * squares moves all by 1/5 and misses by 4/5; the least largest error is half the range [Chebyshev].
 * The second frame is seen through a turn that shows it twice as large. */
static void single_frames_get_the_least_largest_error(void)
{
    static const double limit = 0.56;
    double Q[15] = {0}, E[30] = {0}, X[2] = {0};
    const shape_affine turn[2] = {{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0}},
                                  {{2, 0, 0, 0, 2, 0, 0, 0, 2}, {0}}};
    shape_reduction r = {.rows = 15, .columns = 2, .turn = turn, .every = 1};
    for (int i = 0; i < 5; i++) {
        Q[3 * i] = 1;
    }
    E[3 * 3] = 1;
    E[15 + 3 * 2] = -0.5;
    const shape_design design = {&r, {0, 2}, limit, 1, Q};
    double worst = shape_refit(&design, E, X);
    CHECK(worst <= limit && worst >= 0.5);
    CHECK(X[0] >= 1 - limit && X[0] <= limit);
    CHECK(X[1] <= -(1 - limit) / 2 && X[1] >= -limit / 2);
    for (int i = 0; i < 5; i++) { /* E is what is left */
        CHECK_NEAR(E[3 * i], (i == 3) - X[0], 1e-12);
        CHECK_NEAR(E[15 + 3 * i], -0.5 * (i == 2) - X[1], 1e-12);
    }
}

/* ---- widths ----------------------------------------------------------------------------------- */

/* A direction of uneven entries, scaled by -1 .. 1: 8 bits leave up to 1/254, 16 bits 1/65024. */
static double reduced(int bits, double limit, int *bases, int *wide)
{
    shape_reduction r = reduction(bits);
    bake_error error = {""};
    double worst = 0, truth[ROWS * FRAMES];
    for (int i = 0; i < ROWS * FRAMES; i++) {
        truth[i] = r.residual[i] = sin(1 + i % ROWS) * cos(0.5 * (i / ROWS));
    }
    CHECK_EQ(shape_reduce(&r, ALL, -1, limit, &error), 0);
    *wide = 0;
    for (int j = 0; j < r.count; j++) {
        int narrow = 1;
        for (int i = 0; i < ROWS; i++) {
            narrow &= r.basis[j].entry[i] % 256 == 0;
        }
        *wide += !narrow;
    }
    for (int f = 0; f < FRAMES; f++) {
        for (int i = 0; i < ROWS; i += 3) {
            double square = 0;
            for (int k = i; k < i + 3; k++) {
                double e = truth[f * ROWS + k];
                for (int j = 0; j < r.count; j++) {
                    e -= r.basis[j].weight[f] * r.basis[j].entry[k] / (bits == 16 ? 32767 : 32512);
                }
                square += e * e;
            }
            worst = fmax(worst, sqrt(square));
        }
    }
    *bases = r.count;
    CHECK_NEAR(worst, shape_reduction_worst(&r, ALL), 1e-12);
    shape_reduction_free(&r);
    return worst;
}

/* Three components, each off by half a step, are sqrt 3 / 254 = 0.0068. */
static void a_basis_is_as_wide_as_its_rounding_asks_for(void)
{
    int bases, wide;
    CHECK(reduced(0, 0.01, &bases, &wide) <= 0.01);
    CHECK_EQ(bases, 1);
    CHECK_EQ(wide, 0);
    CHECK(reduced(0, 0.001, &bases, &wide) <= 0.001);
    CHECK_EQ(bases, 1);
    CHECK_EQ(wide, 1);
    CHECK(reduced(16, 0.001, &bases, &wide) <= 0.001);
    CHECK_EQ(bases, 1);
    CHECK(reduced(8, 0.001, &bases, &wide) <= 0.001); /* a second one gives back what it lost */
    CHECK_EQ(bases, 2);
    CHECK_EQ(wide, 0);
}

int main(void)
{
    TEST(what_is_beyond_the_tolerance_comes_before_what_has_energy);
    TEST(directions_out_of_reach_are_the_plain_ones);
    TEST(single_frames_get_the_least_largest_error);
    TEST(a_basis_is_as_wide_as_its_rounding_asks_for);
    return check_done();
}
