/* Affine maps and rotations of nodes.
 * Source: own; the nearest rotation by Newton's iteration for the polar decomposition (Higham
 * 1986).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_nodes.h"
#include "vector.h"

#include <math.h>

affine affine_identity(void)
{
    return (affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

affine affine_of(const struct aiMatrix4x4 *m)
{
    return (affine){{{(double)m->a1, (double)m->a2, (double)m->a3, (double)m->a4},
                     {(double)m->b1, (double)m->b2, (double)m->b3, (double)m->b4},
                     {(double)m->c1, (double)m->c2, (double)m->c3, (double)m->c4}}};
}

affine affine_product(const affine *a, const affine *b)
{
    affine out;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            out.at[i][j] = j == 3 ? a->at[i][3] : 0;
            for (int k = 0; k < 3; k++) {
                out.at[i][j] += a->at[i][k] * b->at[k][j];
            }
        }
    }
    return out;
}

/* The matrix of cofactors of the left block; returns the determinant. */
static double cofactors(const double a[3][4], double c[3][3])
{
    for (int i = 0; i < 3; i++) {
        vector_cross(a[(i + 1) % 3], a[(i + 2) % 3], c[i]);
    }
    return vector_dot(a[0], c[0]);
}

/* The largest absolute value of the left block. */
static double largest(const affine *a)
{
    double most = 0;
    for (int i = 0; i < 9; i++) {
        most = fmax(most, fabs(a->at[i / 3][i % 3]));
    }
    return most;
}

int affine_inverse(const affine *a, affine *out)
{
    double c[3][3], size = largest(a), determinant = cofactors(a->at, c);
    if (!(fabs(determinant) > 1e-12 * size * size * size) || !isfinite(determinant)) {
        return -1;
    }
    for (int i = 0; i < 3; i++) {
        out->at[i][3] = 0;
        for (int j = 0; j < 3; j++) {
            out->at[i][j] = c[j][i] / determinant;
            out->at[i][3] -= out->at[i][j] * a->at[j][3];
        }
    }
    return 0;
}

static void to_quaternion(const double r[3][4], double q[4])
{
    double trace = r[0][0] + r[1][1] + r[2][2];
    int big = 0; /* of 1 + trace and 1 + 2 r_kk - trace, 4 q^2 each */
    double most = trace;
    for (int k = 0; k < 3; k++) {
        if (2 * r[k][k] - trace > most) {
            most = 2 * r[k][k] - trace;
            big = k + 1;
        }
    }
    double half = sqrt(1 + most) / 2, scale = 1 / (4 * half);
    if (big == 0) {
        q[0] = half;
        for (int k = 0; k < 3; k++) {
            q[k + 1] = scale * (r[(k + 2) % 3][(k + 1) % 3] - r[(k + 1) % 3][(k + 2) % 3]);
        }
        return;
    }
    int i = big - 1, j = (i + 1) % 3, k = (i + 2) % 3;
    q[0] = scale * (r[k][j] - r[j][k]);
    q[i + 1] = half;
    q[j + 1] = scale * (r[j][i] + r[i][j]);
    q[k + 1] = scale * (r[k][i] + r[i][k]);
}

int affine_rotation(const affine *a, double q[4])
{
    double c[3][3], size = largest(a);
    affine r = *a;
    double determinant = cofactors(r.at, c) / (size * size * size);
    if (!(determinant > 1e-12) || !isfinite(determinant)) {
        return -1;
    }
    /* Scaled to determinant 1; then quadratic: 12 steps are enough for a condition of 1000. */
    double scale = 1 / (size * cbrt(determinant));
    for (int step = 0; step < 12; step++) {
        for (int i = 0; i < 9; i++) {
            r.at[i / 3][i % 3] *= step == 0 ? scale : 1;
        }
        determinant = cofactors(r.at, c);
        for (int i = 0; i < 9; i++) {
            r.at[i / 3][i % 3] = (r.at[i / 3][i % 3] + c[i / 3][i % 3] / determinant) / 2;
        }
    }
    to_quaternion(r.at, q);
    return 0;
}

void quaternion_product(const double a[4], const double b[4], double out[4])
{
    const double product[4] = {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                               a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                               a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                               a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
    for (int k = 0; k < 4; k++) {
        out[k] = product[k];
    }
}

/* v + 2 q x (q x v + w v) for |q| = 1 */
void quaternion_turn(const double q[4], const double v[3], double out[3])
{
    double a[3], b[3];
    vector_cross(q + 1, v, a);
    for (int k = 0; k < 3; k++) {
        a[k] += q[0] * v[k];
    }
    vector_cross(q + 1, a, b);
    for (int k = 0; k < 3; k++) {
        out[k] = v[k] + 2 * b[k];
    }
}
