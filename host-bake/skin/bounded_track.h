/* Extrapolation of a fixed point iteration y <- y + 1.6 (x - z), a column at a time: columns that belong
 * together share a history.
 *   S, C  n x HISTORY, a column    differences of y + 1.6 (x - z), and of sqrt(R) (x - z)
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BOUNDED_TRACK_H
#define BAKE_BOUNDED_TRACK_H

#include "bounded_parts.h"

/* 5 need a tenth more iterations, 16 as many. */
#define HISTORY 8

typedef struct {
    int count, newest; /* differences so far, the slot of the last one */
    int fresh;         /* 1: no last iteration to take a difference from */
    int back, better;  /* this iteration: go back to the best one; is the best one */
    int mixed;         /* columns of S that are added */
    double gram[HISTORY][HISTORY], mix[HISTORY];
    double best; /* smallest sum of |residual|^2 since the last way back */
} history;

/* The past of one column. */
typedef struct {
    double *y, *w, *x; /* w: z */
    double *S, *C;
    double *plain, *residual; /* y + 1.6 (x - z) and sqrt(R) (x - z) of the last iteration */
    double *best;             /* plain of the smallest residual */
    double norm, far;         /* |residual|^2; largest |x - z| */
    double dot[HISTORY];      /* residual^T C */
    double row[HISTORY];      /* the newest column of C times C */
} track;

void bounded_track_make(track *t, size_t n);
void bounded_track_free(track *t);
void history_make(history *h);

/* From x to the next y, in this order; what is done for tracks may be done by several threads. */
void bounded_track_measure(track *t, const double *root, int n);
void history_begin(history *h, const track *tracks, int columns);
void bounded_track_push(track *t, const double *root, int n, const history *h);
void history_mix(history *h, const track *tracks, int columns);
void bounded_track_add(track *t, int n, const history *h);

#endif
