/* Elastic bodies as plain arrays, in SI units: what is meshed, what is held, what it is made of.
 *   x   3 n   positions, vertex by vertex [m]      n vertices
 *   M   3 n   lumped masses: constant, those of the rest shape [kg]
 *   V         potential energy of a deformation [J]; dV its gradient, d2V its Hessian
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BODY_H
#define BAKE_BODY_H

#include "bake.h"

typedef enum { BODY_SOLID, BODY_SHELL } body_kind;

/* young [Pa], poisson -1 .. 0.5 exclusive, density [kg/m^3], thickness [m] (shells). */
typedef struct {
    double young, poisson, density, thickness;
} body_material;

/* A discretised body. Tetrahedra are positively oriented: det(b - a, c - a, d - a) > 0. */
typedef struct {
    body_kind kind;
    int vertex_count, element_count;
    double *rest;      /* vertex_count x 3 [m] */
    int (*element)[4]; /* tetrahedra; shells: triangles, [3] = -1 */
    body_material material;
    double *mass;   /* vertex_count [kg] */
    void *elements; /* what body_prepare keeps of each element; body_free releases it */
} body;

/* From rest, element and material: masses, and what the energy needs of the rest shape. Fails on an
 * element without volume or area, a vertex that no element uses, a material out of range; says
 * which. Lumped masses: a quarter of the incident volume, a third of the incident area [Schulz
 * 2.3.2, 2.3.3] times density (and thickness). */
int body_prepare(body *b, bake_error *error);
void body_free(body *b);

/* ---- energy (elastic.c calls solid.c or shell.c) ---------------------------------------------- */

/* Symmetric 3 x 3 blocks of a Hessian: rows of vertex a, columns of vertex b, a >= b; several
 * blocks of one pair add up. k[3 i + j] = d2V / dx_a,i dx_b,j. */
typedef struct {
    int a, b;
    double k[9];
} body_block;

typedef struct {
    size_t count, room;
    body_block *at;
} body_blocks;

void body_blocks_add(body_blocks *list, int a, int b, const double k[9]); /* any order of a and b */
void body_blocks_free(body_blocks *list);

/* V(x) [J]; HUGE_VAL where it has none (a triangle without area). V(rest) = 0. */
double body_energy(const body *b, const double *x);

/* dV(x), 3 vertex_count, written. */
void body_gradient(const body *b, const double *x, double *gradient);

/* d2V(x), exact: at the rest shape only first derivatives of the component functions contribute
 * [Schulz lemma 1]; elsewhere the second ones too, so it may be indefinite. Appends to an empty
 * list. */
void body_hessian(const body *b, const double *x, body_blocks *out);

#endif
