/* What the endpoint weights' files share.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_ENDS_PARTS_H
#define BAKE_ENDS_PARTS_H

#include "ends.h"

/* The arguments of ends_make. */
typedef struct {
    const domain *d;
    const handles *h;
    const domain_options *how;
    const double *w;
    double *e;
} ends_problem;

/* Of the point of a bone that is nearest to `at`: 0 at the bone's start, 1 at its end. */
double ends_project(const handle *bone, const double *at);

/* Bounded biharmonic endpoint weights of all bones. */
int ends_bounded(const ends_problem *p, bake_error *error);

#endif
