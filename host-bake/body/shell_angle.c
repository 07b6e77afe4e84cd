/* The dihedral angle of two triangles with a common edge, and its derivatives in closed form.
 *   e  3   the edge, x1 - x0           w_k  3   x_k - x0, k = 2, 3
 *   m_k 3  e x w_k, twice the area     s_k      (w_k . e) / |e|^2: where x_k stands over the edge
 *   g_a 3  gradient of vertex a        c_j  3   the side opposite to x_j: dm_k/dx_j v = c_j x v
 * The gradient is g_2 = -|e| m_2/|m_2|^2, g_3 = |e| m_3/|m_3|^2, and, because rigid motions do not
 * change the angle, g_1 = -s_2 g_2 - s_3 g_3, g_0 = -(1 - s_2) g_2 - (1 - s_3) g_3. The Hessian is
 * the derivative of these products; g_2 does not depend on x_3, so d2 angle/dx_2 dx_3 = 0.
 * Source: the gradient as in Tamstorf and Grinspun 2013; this form of the Hessian is our own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shell_angle.h"
#include "vector.h"

#include <math.h>
#include <string.h>

/* One of the two triangles. */
typedef struct {
    double w[3], m[3], square, s; /* square: |m|^2 */
    double sign;                  /* of g_k */
} side;

static void difference(const double *a, const double *b, double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static void make_side(const double *const x[4], int k, const double e[3], side *out)
{
    difference(x[k], x[0], out->w);
    vector_cross(e, out->w, out->m);
    out->square = vector_dot(out->m, out->m);
    out->s = vector_dot(out->w, e) / vector_dot(e, e);
    out->sign = k == 2 ? -1 : 1;
}

/* Normals m_2 and -m_3; their cross product is -e (m_2 . w_3), which gives the sine without loss
 * when the triangles are nearly flat or nearly folded. */
double shell_angle(const double *const x[4])
{
    double e[3];
    side a, b;
    difference(x[1], x[0], e);
    make_side(x, 2, e, &a);
    make_side(x, 3, e, &b);
    return atan2(-sqrt(vector_dot(e, e)) * vector_dot(a.m, b.w), -vector_dot(a.m, b.m));
}

static void gradient(const double e[3], const side s[2], double g[4][3])
{
    double length = sqrt(vector_dot(e, e));
    for (int i = 0; i < 3; i++) {
        g[2][i] = -length * s[0].m[i] / s[0].square;
        g[3][i] = length * s[1].m[i] / s[1].square;
        g[1][i] = -s[0].s * g[2][i] - s[1].s * g[3][i];
        g[0][i] = -(1 - s[0].s) * g[2][i] - (1 - s[1].s) * g[3][i];
    }
}

void shell_angle_gradient(const double *const x[4], double g[4][3])
{
    double e[3];
    side s[2];
    difference(x[1], x[0], e);
    make_side(x, 2, e, &s[0]);
    make_side(x, 3, e, &s[1]);
    gradient(e, s, g);
}

/* dg_k/dx_j, where c is the side opposite to x_j and d|e| = `along` e/|e| . dx_j: the derivative of
 * m/|m|^2 is (1 - 2 m m^T/|m|^2) [c]x / |m|^2. */
static void far_block(const double e[3], const side *s, const double c[3], double along,
                      double k[9])
{
    double length = sqrt(vector_dot(e, e)), factor = s->sign * length / s->square, mc[3];
    vector_cross(s->m, c, mc);
    const double skew[9] = {0, -c[2], c[1], c[2], 0, -c[0], -c[1], c[0], 0};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            k[3 * i + j] = factor * (skew[3 * i + j] - 2 * s->m[i] * mc[j] / s->square +
                                     along * s->m[i] * e[j] / (length * length));
}

/* Rows of x_k: its own block and those against x_0 and x_1. */
static void far_rows(const double *const x[4], int k, const double e[3], const side *s,
                     double H[4][4][9])
{
    double c0[3], c1[3];
    difference(x[k], x[1], c0);
    difference(x[0], x[k], c1);
    far_block(e, s, c0, -1, H[k][0]);
    far_block(e, s, c1, 1, H[k][1]);
    far_block(e, s, e, 0, H[k][k]);
}

/* What x_k adds to the blocks among x_0 and x_1, by differentiating s_k g_k and (1 - s_k) g_k:
 * ds/dx_1 = (w - 2 s e)/|e|^2, ds/dx_0 = -(e + w - 2 s e)/|e|^2. */
static void near_blocks(const double e[3], const side *s, const double g[3], const double far[2][9],
                        double H[4][4][9])
{
    double square = vector_dot(e, e);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int at = 3 * i + j;
            double ds1 = (s->w[j] - 2 * s->s * e[j]) / square, ds0 = -ds1 - e[j] / square;
            H[1][1][at] -= s->s * far[1][at] + g[i] * ds1;
            H[1][0][at] -= s->s * far[0][at] + g[i] * ds0;
            H[0][0][at] -= (1 - s->s) * far[0][at] - g[i] * ds0;
        }
}

void shell_angle_hessian(const double *const x[4], double g[4][3], double H[4][4][9])
{
    double e[3];
    side s[2];
    difference(x[1], x[0], e);
    for (int k = 2; k < 4; k++) {
        make_side(x, k, e, &s[k - 2]);
        far_rows(x, k, e, &s[k - 2], H);
    }
    gradient(e, s, g);
    memset(H[3][2], 0, sizeof H[3][2]);
    memset(H[0][0], 0, sizeof H[0][0]);
    memset(H[1][0], 0, sizeof H[1][0]);
    memset(H[1][1], 0, sizeof H[1][1]);
    for (int k = 2; k < 4; k++)
        near_blocks(e, &s[k - 2], g[k], (const double(*)[9])H[k], H);
}
