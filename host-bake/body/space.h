/* Reduced spaces and the linear dynamic models in them.                      [Schulz 2.7, 2.2.2]
 *   x = origin + V q                V  n x d, V^T M V = 1 (n = 3 vertices, or a chain's size)
 *   q = Phi c                       Phi  d x d, orthogonal: decoupled coordinates of one model
 *   c_i'' + 2 delta_i c_i' + s lambda_i c_i + s inner_i + outer_i = 0
 *   2 delta_i = alpha + beta s lambda_i
 * Each model is linearised about a point z of the space; c is counted from the space's origin for
 * all of them: inner = Phi^T V^T dV(z) - lambda Phi^T q_z, outer = -Phi^T V^T (constant forces).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SPACE_H
#define BAKE_SPACE_H

#include "modes.h"

typedef struct {
    int n, d;
    double *origin; /* n */
    double *M;      /* n x n dense (chains) or NULL, with */
    double *mass;   /* n: diagonal */
    double *V;      /* n x d, column-major */
} space;

/* Algorithm 2 [Schulz 2.7.2]: an orthonormal basis, in the mass product, of `count` vectors (n x
 * count, column-major), each scaled to mass norm 1 first; directions whose singular value is below
 * 1e-7 of the largest are dropped. By SVD of sqrt(M) S through its Gram matrix and one
 * re-orthonormalisation; |V^T M V - 1| <= 1e-12 is checked. s->n, origin, mass or M are set by the
 * caller before. Vectors that are rounding (16 eps of the origin's mass norm) are left out; fails
 * when nothing is left. */
int space_make(space *s, const double *vectors, int count, bake_error *error);
void space_free(space *s);

/* q = V^T M (x - origin), or of a velocity / difference: q = V^T M u. */
void space_project(const space *s, const double *x, double *q);
void space_project_vector(const space *s, const double *u, double *q);
/* Of `count` vectors u (n x count) in one product: q is d x count. */
void space_project_vectors(const space *s, const double *u, int count, double *q);
/* x = origin + V q */
void space_expand(const space *s, const double *q, double *x);

typedef struct {
    int d;
    double *lambda;        /* d [1/s^2], ascending; noise about 0 is 0 */
    double *inner, *outer; /* d */
    double *Phi;           /* d x d, column-major: q = Phi c */
} linear_model;

/* What a model is made of, reduced: K d x d, V^T d2V(z) V, row-major, symmetric; q_z the point z;
 * gradient V^T dV(z); force V^T of the constant forces; noise as in modes.h. */
typedef struct {
    int d;
    const double *K, *q_z, *gradient, *force;
    double noise;
} linear_terms;

/* The sign of each column of Phi is fixed as in modes.h. */
int linear_model_make(const linear_terms *at, linear_model *out, bake_error *error);

/* lambda, inner, outer = 0: plain cubic splines in the space. */
void linear_model_plain(int d, linear_model *out);
void linear_model_free(linear_model *m);

/* c = Phi^T q */
void linear_model_project(const linear_model *m, const double *q, double *c);

/* V^T K V for K given as the blocks of a body's Hessian (n = 3 vertices): d x d, row-major. */
void space_reduce_blocks(const space *s, const body_blocks *K, double *out);

/* The same of a dense symmetric K (n x n): chains. */
void space_reduce_dense(const space *s, const double *K, double *out);

#endif
