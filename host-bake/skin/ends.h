/* Endpoint weights of stretchable, twistable bones: how far along its bone a vertex moves, 0 at the
 * start, 1 at the end.
 * Source: Jacobson 2013, 6.2-6.4 (6.7)-(6.9); erratum of (6.9): the joints' weights are normalised.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_ENDS_H
#define BAKE_ENDS_H

#include "bounded.h"

typedef enum {
    ENDS_NONE,
    ENDS_BOUNDED,    /* bounded biharmonic [S8]; on a flat shape linear along the bone */
    ENDS_PROJECTION, /* (6.8), clamped */
    ENDS_DISTANCE,   /* (6.9), exponent 2 */
    ENDS_JOINTS      /* (6.7) from bounded biharmonic weights of all joints */
} ends_kind;

/* f(e): a monotone cubic through (x_i, y_i) from (0, 0) to (1, 1) [6.3: filter]. count 0: f(e) = e. */
typedef struct {
    int count;
    const double *x, *y; /* ascending */
} ends_filter;

/* Of every bone of `h`, e: vertex_count x handle_count, column by column; of other handles 0. w: the
 * handles' weights, n x m: where a bone's are below 1e-7 the domain is not solved and e is clamped to
 * what its neighbours have. Fails, naming the bone. */
int ends_make(const domain *d, const handles *h, ends_kind kind, const double *w,
              const domain_options *how, double *e, bake_error *error);

void ends_apply(const ends_filter *f, double *e, int count);

#endif
