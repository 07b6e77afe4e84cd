/* What moves a mesh as a whole, taken out of its frames.               [Alexa 7.2, l. 2053-2062]
 *   X   3 x m   a frame           Y   3 x m   the same frame, normalised
 *   R   3 x m   the reference     c   3       the frame's centroid
 *   T   3 x 3   least squares: T (X - c) is nearest to R
 *   A   3 x 3   T^-1, played back: X = A Y + c                          [Alexa (7.5)]
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SHAPE_AFFINE_H
#define BAKE_SHAPE_AFFINE_H

/* Row-major; x = A y + c. */
typedef struct {
    double A[9], c[3];
} shape_affine;

/* The longest axis of what T does over its shortest: beyond it, playing T^-1 back would magnify what
 * the bases leave by so much more in one direction than in another that a rotation does better. */
#define SHAPE_CONDITION 8.0

/* Vertices count as flat or as a line when they extend less than this share of their longest axis
 * in the other directions. */
#define SHAPE_FLAT 1e-4

/* A and c of one frame; `reference` has its centroid at 0. Flat frames get the missing directions by
 * a rotation. Returns 0, or -1 when the least squares T mirrors, flattens or is badly conditioned: A
 * is then meaningless. */
int shape_affine_fit(const double *frame, const double *reference, int vertices, shape_affine *out);

/* The best rotation instead [Kabsch]: det A = 1 always. */
void shape_affine_rotate(const double *frame, const double *reference, int vertices,
                         shape_affine *out);

/* y = A^-1 (x - c), x = A y + c, for each vertex; may be in place. */
void shape_affine_undo(const shape_affine *a, const double *x, int vertices, double *y);
void shape_affine_apply(const shape_affine *a, const double *y, int vertices, double *x);

double shape_det(const double A[9]);

/* The longest axis of A: how much it stretches at most. */
double shape_stretch(const double A[9]);

#endif
