/* Bounded biharmonic weights against IPOPT, on flat shapes, solids and with handles of every kind.
 * SPDX-License-Identifier: MIT */
#include "ipopt_oracle.h"
#include "weights_problem.h"

/* Both solvers are exact to their residuals; what a residual of 1e-6 diag(Q) may move a weight in a domain
 * of a few hundred vertices is below this (bounded.h promises 1e-4 on any). */
#define AGREE 1e-5

static void compare(weights_problem *p)
{
    double *x = bake_alloc((size_t)p->n, sizeof *x), worst = 0;
    weights_solve(p, BOUNDED_SEPARATE);
    for (int j = 0; j < p->m; j++) {
        int status = ipopt_weights(&p->q, &p->fixed, j, x);
        CHECK(status == 0 || status == 1);
        double off = weights_largest_difference(x, weights_of(p, j), p->n);
        worst = fmax(worst, off);
    }
    printf("%d vertices, %d handles: off by %.1e\n", p->n, p->m, worst);
    CHECK_NEAR(worst, 0, AGREE);
    free(x);
    weights_free(p);
}

static void points_in_a_square(void)
{
    handle h[5];
    for (int i = 0; i < 5; i++) {
        h[i] = weights_point((3 + 3 * i) / 18.0, (2 + 4 * (i * 3 % 5)) / 18.0, 0);
    }
    const handles all = {.count = 5, .handle = h};
    weights_problem p = weights_make(shape_sheet(1, 1, 18, 18), &all, 2);
    compare(&p);
}

static void bones_and_a_point_in_a_square(void)
{
    const handle h[3] = {weights_bone(2 / 18.0, 0.5, 0.5, 0.5),
                         weights_bone(0.5, 0.5, 15 / 18.0, 11 / 18.0),
                         weights_point(4 / 18.0, 16 / 18.0, 0)};
    const handles all = {.count = 3, .handle = h};
    weights_problem p = weights_make(shape_sheet(1, 1, 18, 18), &all, 2);
    compare(&p);
}

static void points_in_a_box(void)
{
    const handle h[3] = {weights_point(0, 0, 0), weights_point(3, 1, 1), weights_point(1.5, 0, 1)};
    const handles all = {.count = 3, .handle = h};
    weights_problem p =
        weights_make(shape_box((const double[]){3, 1, 1}, (const int[]){9, 3, 3}), &all, 2);
    compare(&p);
}

int main(void)
{
    TEST(points_in_a_square);
    TEST(bones_and_a_point_in_a_square);
    TEST(points_in_a_box);
    return check_done();
}
