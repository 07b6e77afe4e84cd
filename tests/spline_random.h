/* Random spline problems for the tests of the solver, repeatable.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef SPLINE_RANDOM_H
#define SPLINE_RANDOM_H

#include "check.h"
#include "spline.h"

#include <math.h>

#define KEYS 16
static const bake_spline_problem clamped = {.end = {BAKE_END_VELOCITY, BAKE_END_VELOCITY}};

static unsigned long long random_state = 1;
static inline double uniform(double low, double high)
{
    random_state = random_state * 6364136223846793005ull + 1442695040888963407ull;
    return low + (high - low) * (double)(random_state >> 11) / 9007199254740992.0;
}

static inline int random_keys(bake_key *keys, int count)
{
    double t = uniform(-2, 2);
    for (int k = 0; k < count; k++, t += uniform(0.2, 1.0))
        keys[k] = (bake_key){t, {uniform(-1, 1), 0, 0}, {BAKE_HARD, 0, 0}};
    return count;
}

static inline bake_mode random_mode(void)
{
    double root = uniform(0.2, 9);
    double sign = uniform(0, 1) < 0.2 ? -1.0 : 1.0;
    return (bake_mode){sign * root * root, uniform(0, 1.5) * root, uniform(-3, 3)};
}

static inline bake_curve solved(const bake_spline_problem *problem, const bake_key *keys, int count,
                                bake_spline_report *report)
{
    bake_curve curve;
    bake_error error = {""};
    CHECK_EQ(bake_spline_solve(problem, keys, count, &curve, report, &error), 0);
    if (!curve.count)
        printf("%s\n", error.text);
    return curve;
}

#endif
