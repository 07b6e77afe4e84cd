/* Exact weights of one handle from near ones: a primal-dual active set. Free vertices below 0 are held
 * at 0, those that push the wrong way are let go, all at once; when that has not helped ten times, one
 * at a time, which ends always. Every solution is that of a factor of the free set.
 * Source: Judice, Pires 1994; the levels are own.
 *
 * Far from its handle a weight alternates around 0, ever smaller, and whole regions below 1e-6 change
 * sign from one vertex to the next. Of large problems such a region is left at 0, as long as what that
 * does to the weights is foreseen to be small: letting vertex i go moves it by about
 * -g_i / (0.05 Q_ii), and the others by -Q_FF^-1 Q_Fi of that.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROUNDS    500
#define PATIENCE  10
#define STIFFNESS 0.05 /* of a vertex whose neighbours move along, as a part of Q_ii */
#define LEVELS    5

/* Up to this many free vertices everything is exact: it costs less than a second. */
#define SMALL 4000

typedef struct {
    double zero;          /* weights that begin at 0 */
    double below;         /* how far outside the bounds a weight may be until it is clamped */
    double effect;        /* of what is not let go, on any weight */
    double level[LEVELS]; /* -g_i / Q_ii that is not let go: the first one whose effect is small */
} tolerances;

static const tolerances exact = {0, 1e-11, 0, {1e-12, 1e-12, 1e-12, 1e-12, 1e-12}};
static const tolerances large = {1e-6, 1e-7, 3e-5, {8e-7, 1e-7, 1e-8, 1e-9, 1e-10}};

typedef struct {
    const bounded_system *s;
    const double *b;
    const tolerances *t;
    bounded_border border;
    char *state;
    double *w, *g, *x;
} polish;

/* How much a bound pushes the wrong way. */
static double wrong(const polish *p, int i)
{
    return p->state[i] == BOUNDED_LOW    ? -p->g[i] / p->s->d[i]
           : p->state[i] == BOUNDED_HIGH ? p->g[i] / p->s->d[i]
                                         : 0;
}

static double outside(const polish *p, int i)
{
    return p->state[i] == BOUNDED_FREE_VERTEX ? fmax(-p->w[i], p->w[i] - 1) : 0;
}

/* w of the present set: solved for, and once more for what is left over. */
static int solve(bounded_desk *desk, polish *p)
{
    const bounded_system *s = p->s;
    int result = bounded_border_set(desk, &p->border, p->state);
    for (int i = 0; i < s->n; i++) {
        p->w[i] = p->state[i] == BOUNDED_HIGH;
    }
    for (int k = 0; k < 2 && result == 0; k++) {
        bounded_gradient(s, p->b, p->w, p->x);
        for (int i = 0; i < s->n; i++) {
            p->x[i] = -p->x[i];
        }
        result = bounded_border_solve(desk, &p->border, p->state, p->x);
        for (int i = 0; i < s->n; i++) {
            p->w[i] += p->x[i];
        }
    }
    bounded_gradient(s, p->b, p->w, p->g);
    return result;
}

/* What letting go all vertices below a level would do to the free ones. -1: no memory. */
static double effect(bounded_desk *desk, const polish *p, double level)
{
    const bounded_system *s = p->s;
    const bounded_border *f = &p->border;
    double *t = bake_alloc((size_t)f->factor.n, sizeof *t), most = 0;
    int any = 0;
    for (int i = 0; i < s->n; i++) {
        double v = wrong(p, i);
        if (v > 0 && v <= level) {
            double move = v / STIFFNESS * (p->state[i] == BOUNDED_LOW ? 1 : -1);
            for (int k = s->column[i]; k < s->column[i + 1]; k++) {
                int at = f->place[s->row[k]];
                if (at >= 0 && p->state[s->row[k]] == BOUNDED_FREE_VERTEX) {
                    t[at] -= s->value[k] * move;
                    any = 1;
                }
            }
        }
    }
    if (any && bounded_factor_solve(desk, &f->factor, t, 1) < 0) {
        most = -1;
    }
    for (int k = 0; k < f->factor.n && any && most >= 0; k++) {
        if (p->state[f->list[k]] == BOUNDED_FREE_VERTEX) {
            most = fmax(most, fabs(t[k]));
        }
    }
    free(t);
    return most;
}

/* The level of this round, or -1. */
static double choose(bounded_desk *desk, const polish *p)
{
    int k = p->t->effect > 0 ? 0 : LEVELS - 1;
    for (; k < LEVELS - 1; k++) {
        double e = effect(desk, p, p->t->level[k]);
        if (e <= p->t->effect) {
            return e < 0 ? -1 : p->t->level[k];
        }
    }
    return p->t->level[k];
}

/* Moves vertices between the sets: all that are wrong, or the last of them. Returns how many are. */
static int move(polish *p, double level, int one, int apply)
{
    int count = 0;
    for (int i = p->s->n - 1; i >= 0; i--) {
        int out = outside(p, i) > p->t->below;
        if (!out && wrong(p, i) <= level) {
            continue;
        }
        if (apply && (!one || count == 0)) {
            p->state[i] = !out ? BOUNDED_FREE_VERTEX : p->w[i] < 0 ? BOUNDED_LOW : BOUNDED_HIGH;
        }
        count++;
    }
    return count;
}

/* 0, 1 = no end, -1 */
static int rounds(bounded_desk *desk, polish *p)
{
    const bounded_system *s = p->s;
    int fewest = s->n + 1, patience = PATIENCE;
    for (int i = 0; i < ROUNDS; i++) {
        int result = solve(desk, p);
        double level = result == 0 ? choose(desk, p) : -1;
        if (level < 0) {
            return result ? result : -1;
        }
        int count = move(p, level, 0, 0);
        if (count == 0) {
            return 0;
        }
        if (count < fewest) {
            fewest = count;
            patience = PATIENCE;
        } else if (--patience < -PATIENCE && p->t == &exact) {
            p->t = &large; /* signs of rounding errors do not settle */
            fewest = s->n + 1;
            patience = PATIENCE;
        }
        move(p, level, patience < 0, 1);
    }
    return 1;
}

int bounded_polish(bounded_desk *desk, const bounded_system *s, const double *b, double *w,
                   int *factors)
{
    size_t n = (size_t)s->n;
    polish p = {.s = s, .b = b, .w = w, .t = s->n <= SMALL ? &exact : &large};
    p.border.s = s;
    p.state = bake_alloc(n, 1);
    p.g = bake_alloc(n, sizeof *p.g);
    p.x = bake_alloc(n, sizeof *p.x);
    for (int i = 0; i < s->n; i++) {
        p.state[i] = w[i] <= p.t->zero ? BOUNDED_LOW
                     : w[i] >= 1       ? BOUNDED_HIGH
                                       : BOUNDED_FREE_VERTEX;
    }
    int result = rounds(desk, &p);
    for (int i = 0; i < s->n; i++) {
        w[i] = fmin(fmax(w[i], 0), 1);
    }
    *factors = p.border.made;
    bounded_border_free(desk, &p.border);
    free(p.state);
    free(p.g);
    free(p.x);
    return result;
}
