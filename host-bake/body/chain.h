/* Planar chains of rigid links with springs in their joints: the rod and Luxo.   [Schulz 2.3.1,
 * 5.1, 5.2]
 *   q = (x, y, theta_1 .. theta_n)  position of the root [m], absolute angle of each link from the
 *     x axis,
 *                                   counter-clockwise [rad]; without a free root: q = (theta_1 ..
 *                                     theta_n)
 * A tree: each link starts at the end of its parent, or at the root. Errata S14, S15.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_CHAIN_H
#define BAKE_CHAIN_H

#include "bake.h"

#define CHAIN_LINKS_MAX 32

/* A mass distribution along its link: a point mass at its end [Schulz 5.1] and a rod whose line
 * density
 * [kg/m] goes linearly from start to end [Schulz 5.2]. */
typedef struct {
    int parent;        /* a link with a smaller index, -1: the root */
    int stiff;         /* 1: welded to its parent, no coordinate of its own (Luxo's shade) */
    double length;     /* [m], > 0 */
    double angle;      /* absolute, in the rest pose [rad] */
    double end_mass;   /* [kg] */
    double density[2]; /* [kg/m] at its start and end */
    double spring;     /* of its joint [N m/rad]: V = spring/2 (theta - theta_parent - rest)^2; of a
                          link at the root: against the ground, 0 = none */
} chain_link;

typedef struct {
    int link_count;
    const chain_link *link;
    int free_root;    /* 1: the root moves; a root mass keeps M regular */
    double root_mass; /* [kg] */
    double gravity;   /* along -y [m/s^2] */
} chain;

/* Coordinates: 2 free_root + links that are not stiff. */
int chain_size(const chain *c);

/* q of the rest pose, root at 0. */
void chain_rest(const chain *c, double *q);

/* start and end of each link, link_count x 2 x 2 [m]. */
void chain_points(const chain *c, const double *q, double *out);

/* M(q), size x size, row-major; kinetic energy = 1/2 q'^T M q'. */
void chain_mass(const chain *c, const double *q, double *M);

/* V(q) with gravity, dV (size), d2V (size x size, plain second derivatives). */
double chain_energy(const chain *c, const double *q);
void chain_gradient(const chain *c, const double *q, double *gradient);
void chain_hessian(const chain *c, const double *q, double *H);

/* Lengths positive, parents smaller, masses such that M is positive definite; names the link. */
int chain_check(const chain *c, bake_error *error);

#endif
