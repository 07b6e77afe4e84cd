/* From dense weights to what a clip stores: few influences a vertex, in bytes that sum to 255.
 * Source: own. SPEC 4.21: the first weight counts one more, so that a vertex has 256 parts.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_INFLUENCE_H
#define BAKE_INFLUENCE_H

#include "bake.h"

#define INFLUENCES_MAX 8

typedef struct {
    int count; /* 1 .. INFLUENCES_MAX; descending weights, then ascending bones */
    unsigned char bone[INFLUENCES_MAX];
    unsigned char weight[INFLUENCES_MAX]; /* sum to 255 */
    unsigned char end[INFLUENCES_MAX];    /* endpoint weight: e^ = end + (end >> 7) is e 256 */
} influence;

/* The `most` largest weights of each vertex, rounded so that the largest error of a weight is least
 * (largest remainders). w, e: n x m, column by column; e NULL: no endpoint weights. out: n. A vertex
 * whose weights are all below 1/512 is an error that names it. */
int influence_make(const double *w, const double *e, const int size[2], int most, influence *out,
                   bake_error *error);

/* A stored weight and endpoint weight as the player understands them: 0 .. 1. */
double influence_weight(const influence *i, int k);
double influence_end(const influence *i, int k);

#endif
