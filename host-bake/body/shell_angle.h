/* The dihedral angle of two triangles with a common edge, and its derivatives.
 * Vertices: x[0], x[1] the edge, x[2] and x[3] opposite to it. The angle is 0 when the triangles
 * lie flat side by side, in (-pi, pi]; exchanging x[0] and x[1], or x[2] and x[3], turns its sign.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SHELL_ANGLE_H
#define BAKE_SHELL_ANGLE_H

double shell_angle(const double *const x[4]);

/* Gradient: g[a] of vertex a. Triangles must have an area. */
void shell_angle_gradient(const double *const x[4], double g[4][3]);

/* Gradient and Hessian: H[a][b][3 i + j] = d2 angle / dx_a,i dx_b,j for a >= b, no others. */
void shell_angle_hessian(const double *const x[4], double g[4][3], double H[4][4][9]);

#endif
