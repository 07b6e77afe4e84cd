/* One gap of a coupled motion: the half before its switch and the half after it.
 * Source: Schulz 2013, 2.8.2; the elimination is our own.
 *
 *   w, v   d      value and velocity at the switch, in coordinates of the model before it
 *   k      d      multipliers of C2 at the switch, likewise
 *   x      3 d    (w, v, k)
 *   y      4 d    of the two keys, each in coordinates of its own model: velocity, multipliers of
 * C2 R      d x d  Phi_0^T Phi_1: c_0 = R c_1 M      7 d x 7 d  stationarity of the gap's energy
 * and conditions, order (x, y) Z      3 d x (4 d + 1)  x = Z (-y, 1) Matrices are column-major.
 * Modal coordinates keep stiff and soft modes apart as far as the two models agree: in coordinates
 * q their energies, which go with lambda^(3/2), would drown each other. SPDX-License-Identifier:
 * AGPL-3.0-or-later */
#ifndef BAKE_SPACETIME_GAP_H
#define BAKE_SPACETIME_GAP_H

#include "spacetime_parts.h"

/* One mode on half a gap. Q: energy in (w0, v0, w1, v1, 1), row-major, but for the constant. */
typedef struct {
    bake_segment segment;
    bake_part part;
    double Q[25];
} gap_piece;

/* The caller sets d to joins; [0] before the switch, [1] after it. */
typedef struct {
    int d;
    const linear_model *model[2];
    const bake_mode *mode[2];
    const double *pose[2]; /* of its key, in the model's coordinates */
    const double *regularise;
    double time[2]; /* of its keys */
    int joins[2];   /* whether C2 is a condition at that key */
    gap_piece *piece[2];
    double *R, *Z;
} gap;

/* Pieces, R. before: the gap before it, whose last pieces may be like its first; or NULL. */
void gap_prepare(gap *g, const gap *before);

/* What is left of the gap's equations when the switch follows its keys: rest y = its last column;
 * rest is 4 d x (4 d + 1). Returns -1 if that is not determined; condition: reciprocal, of what was
 * solved. */
int gap_eliminate(gap *g, double *rest, double *condition);

/* Coefficients of the pieces from the keys' velocities and multipliers. */
void gap_finish(gap *g, const double *y);
void gap_free(gap *g);

#endif
