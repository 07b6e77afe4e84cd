/* Finite elements of order one on triangles and tetrahedra: stiffness, masses, and the energies that
 * weights minimise. All matrices as sparse.h has them (lower triangles); K is positive semidefinite,
 * the negative of the thesis's L.
 * Source: Jacobson 2013, 2.1 (2.16, 2.34, 2.38), 4.3.4 (4.8), 4.8 (4.39); errata J1-J4 of DESIGN 9.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_LAPLACIAN_H
#define BAKE_LAPLACIAN_H

#include "domain.h"
#include "sparse.h"

typedef enum {
    MASS_VORONOI, /* triangles: mixed Voronoi areas [2.1.3, erratum: halves at the obtuse corner];
                         tetrahedra: a quarter of the volume */
    MASS_BARYCENTRIC, /* a third, a quarter */
} mass_kind;

/* Edge lengths of every element, element_count x 6: 01 02 03 12 13 23 (triangles: 01 02 12, then 0),
 * lifted coordinates included. */
void laplacian_lengths(const domain *d, double *length);

/* From edge lengths alone: K (n x n) and the diagonal mass (n). Fails on an element without area or
 * volume, naming where it is. */
int laplacian_make(const domain *d, const double *length, mass_kind kind, sparse *k, double *mass,
                   bake_error *error);

/* Q = K M^-1 K: 1/2 w^T Q w is the Laplacian energy [4.8]. order 1: K itself (harmonic), 2:
 * biharmonic, 3: K M^-1 K M^-1 K. */
int laplacian_energy(const sparse *k, const double *mass, int order, sparse *out,
                     bake_error *error);

/* Adds G^T R G: the shape-preservation brush [4.3.3; erratum: the element's mean of rho times its
 * area, once]. rho: a vertex. */
int laplacian_brush(const domain *d, const double *length, const double *rho, sparse *q,
                    bake_error *error);

#endif
