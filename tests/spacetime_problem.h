/* Random spacetime problems for tests, by value, repeatable.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef SPACETIME_PROBLEM_H
#define SPACETIME_PROBLEM_H

#include "spacetime.h"
#include "spline_random.h"

#include <stdlib.h>
#include <string.h>

#define D_MAX    20
#define KEYS_MAX 12

/* ---- problems -------------------------------------------------------------------------------- */

typedef struct {
    double lambda[D_MAX], inner[D_MAX], outer[D_MAX], Phi[D_MAX * D_MAX];
    linear_model as;
} model;

typedef enum { ONE, BLEND, COUPLE } way;

/* Everything a motion is asked for, by value. */
typedef struct {
    way way;
    int d, count, model_count;
    model models[KEYS_MAX];
    const linear_model *list[KEYS_MAX];
    space_settings settings;
    space_key keys[KEYS_MAX];
    double q[KEYS_MAX][D_MAX], v[KEYS_MAX][D_MAX], end_v[2][D_MAX];
    double S[KEYS_MAX][D_MAX * D_MAX], p[KEYS_MAX][D_MAX];
} problem;

static inline void link_model(problem *x, int j)
{
    model *m = &x->models[j];
    m->as = (linear_model){x->d, m->lambda, m->inner, m->outer, m->Phi};
    x->list[j] = &m->as;
}

static inline motion_input input_of(const problem *x)
{
    return (motion_input){&x->settings, x->keys, x->count};
}

static inline int solve(problem *x, motion *m, bake_error *error)
{
    const motion_input in = input_of(x);
    if (x->way == ONE)
        return motion_one_point(x->list[0], &in, m, error);
    return (x->way == BLEND ? motion_blend : motion_couple)(x->list, &in, m, error);
}

static inline motion solved_motion(problem *x)
{
    motion m;
    bake_error error = {""};
    CHECK_EQ(solve(x, &m, &error), 0);
    if (!m.term)
        printf("%s\n", error.text);
    return m;
}

/* Random rotation near 1 for `mix` small. */
static inline void random_model(problem *x, int j, double top, double mix)
{
    model *m = &x->models[j];
    int d = x->d;
    for (int i = 0; i < d; i++) {
        double root = top * (i + 1) / d * uniform(0.8, 1.2), *column = m->Phi + i * d;
        m->lambda[i] = root * root;
        m->inner[i] = uniform(-2, 2);
        m->outer[i] = uniform(-2, 2);
        for (int r = 0; r < d; r++)
            column[r] = (r == i) + mix * uniform(-1, 1);
        for (int k = 0; k < 2 * i; k++) { /* twice: rounding of the first pass */
            const double *other = m->Phi + (k % i) * d;
            double dot = 0;
            for (int r = 0; r < d; r++)
                dot += column[r] * other[r];
            for (int r = 0; r < d; r++)
                column[r] -= dot * other[r];
        }
        double norm = 0;
        for (int r = 0; r < d; r++)
            norm += column[r] * column[r];
        for (int r = 0; r < d; r++)
            column[r] /= sqrt(norm);
    }
    link_model(x, j);
}

static inline void random_problem(problem *x, way kind, int d, int count, bake_end end)
{
    memset(x, 0, sizeof *x);
    x->way = kind;
    x->d = d;
    x->count = count;
    x->settings = (space_settings){.alpha = 0.3, .beta = 0.005, .stiffness = 1.2};
    double t = uniform(-1, 1);
    for (int k = 0; k < count; k++, t += uniform(0.3, 0.7)) {
        random_model(x, k, 15, 0.2);
        for (int i = 0; i < d; i++) {
            x->q[k][i] = uniform(-1, 1);
            x->v[k][i] = uniform(-1, 1);
        }
        x->keys[k] = (space_key){.time = t, .q = x->q[k], .weight = {BAKE_HARD, 0}};
    }
    for (int side = 0; side < 2; side++) {
        x->settings.end[side] = end;
        for (int i = 0; i < d; i++)
            x->end_v[side][i] = uniform(-1, 1);
        x->settings.end_v[side] = x->end_v[side];
    }
    if (end == BAKE_END_PERIODIC) {
        memcpy(x->q[count - 1], x->q[0], sizeof x->q[0]);
        x->list[count - 1] = x->list[0];
    }
}

/* Makes a key ask for `rows` random combinations of its pose. */
static inline void make_partial(problem *x, int k, int rows, double weight)
{
    x->keys[k].rows = rows;
    x->keys[k].weight[0] = weight;
    x->keys[k].S = x->S[k];
    x->keys[k].p = x->p[k];
    for (int r = 0; r < rows; r++) {
        x->p[k][r] = 0;
        for (int i = 0; i < x->d; i++) {
            x->S[k][r * x->d + i] = uniform(-1, 1);
            x->p[k][r] += x->S[k][r * x->d + i] * x->q[k][i];
        }
    }
}

static inline double largest(const double *x, int count)
{
    double size = 0;
    for (int i = 0; i < count; i++)
        size = fmax(size, fabs(x[i]));
    return size;
}

/* The largest distance of two motions over time. */
static inline double apart(const motion *a, const motion *b)
{
    double worst = 0, p[D_MAX], q[D_MAX];
    for (double t = a->from; t <= a->to; t += 0.007) {
        motion_eval(a, t, p, NULL, NULL);
        motion_eval(b, t, q, NULL, NULL);
        for (int i = 0; i < a->d; i++)
            worst = fmax(worst, fabs(p[i] - q[i]));
    }
    return worst;
}

#endif
