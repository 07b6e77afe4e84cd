/* Poses by dragging: some vertices are put somewhere, elasticity finds the rest.
 * Source: own; minimises V(x) over the free coordinates by Newton's method with a line search.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_STATICS_H
#define BAKE_STATICS_H

#include "freedom.h"

/* Where vertices are put. */
typedef struct {
    int count;
    const int *vertex;
    const double *target; /* count x 3 [m] */
} statics_drag;

/* x: 3 n, in: where to start (rest, usually), out: the equilibrium. `held`: what the body's
 * constraints leave; dragged vertices are fixed at their targets whatever it says. force: 3 n
 * constant forces [N] or NULL. The targets are approached in as many steps as it takes; fails when
 * Newton's method does not bring the free gradient below 1e-8 of the reaction forces (or to what
 * rounding leaves), and says how far it got (0..100 %). An unstable equilibrium is no answer: a bar
 * that is pushed along its axis buckles. */
int statics_solve(const body *b, const freedom *held, const statics_drag *drag, const double *force,
                  double *x, bake_error *error);

#endif
