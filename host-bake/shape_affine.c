/* Affine normalisation of frames.
 * Source: Alexa 2002, 7.2; rotations by Kabsch 1976. How flat frames and mirrored ones are treated
 * is ours: the thesis restricts the map to determinants above zero and does not say how.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_affine.h"

#include <lapacke.h>
#include <math.h>
#include <string.h>

double shape_det(const double A[9])
{
    return A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) +
           A[2] * (A[3] * A[7] - A[4] * A[6]);
}

static void multiply(const double a[9], const double b[9], double out[9])
{
    for (int i = 0; i < 9; i++) {
        out[i] = a[i / 3 * 3] * b[i % 3] + a[i / 3 * 3 + 1] * b[3 + i % 3] +
                 a[i / 3 * 3 + 2] * b[6 + i % 3];
    }
}

static double length(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* H = U diag(s) V^T; V^T row-major, so its rows are the right vectors. */
static void svd3(const double H[9], double U[9], double s[3], double Vt[9])
{
    double copy[9];
    memcpy(copy, H, sizeof copy);
    LAPACKE_dgesdd(LAPACK_ROW_MAJOR, 'A', 3, 3, copy, 3, s, U, 3, Vt, 3);
}

double shape_stretch(const double A[9])
{
    double U[9], s[3], Vt[9];
    svd3(A, U, s, Vt);
    return s[0];
}

/* c, and sums over the vertices: H = R (X - c)^T, G = (X - c)(X - c)^T. */
static void moments(const double *frame, const double *reference, int vertices, double c[3],
                    double H[9], double G[9])
{
    c[0] = c[1] = c[2] = 0;
    for (int i = 0; i < 3 * vertices; i++) {
        c[i % 3] += frame[i] / vertices;
    }
    memset(H, 0, 9 * sizeof *H);
    memset(G, 0, 9 * sizeof *G);
    for (int i = 0; i < vertices; i++) {
        for (int k = 0; k < 9; k++) {
            double x = frame[3 * i + k % 3] - c[k % 3];
            H[k] += reference[3 * i + k / 3] * x;
            G[k] += (frame[3 * i + k / 3] - c[k / 3]) * x;
        }
    }
}

/* The smallest rotation that takes the direction v to u [Rodrigues], times `scale`. */
static void turn_line(const double v[3], const double u[3], double scale, double T[9])
{
    double axis[3], cosine = v[0] * u[0] + v[1] * u[1] + v[2] * u[2];
    cross(v, u, axis);
    if (1 + cosine < 1e-9) { /* half a turn, about whatever is normal to v */
        int k = fabs(v[0]) < 0.6 ? 0 : 1;
        double unit[3] = {k == 0, k == 1, 0};
        cross(v, unit, axis);
        double l = length(axis);
        for (int i = 0; i < 9; i++) {
            T[i] = scale * (2 * axis[i / 3] * axis[i % 3] / (l * l) - (i % 4 == 0));
        }
        return;
    }
    const double K[9] = {0, -axis[2], axis[1], axis[2], 0, -axis[0], -axis[1], axis[0], 0};
    double square[9];
    multiply(K, K, square);
    for (int i = 0; i < 9; i++) {
        T[i] = scale * ((i % 4 == 0) + K[i] + square[i] / (1 + cosine));
    }
}

/* T maps the plane of v[0], v[1] only; its normal goes to the normal of their images. 0 when those
 * lie on a line. */
static int complete_plane(const double v[3][3], double T[9])
{
    double image[2][3], normal[3], n[3];
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 3; i++) {
            image[k][i] = T[3 * i] * v[k][0] + T[3 * i + 1] * v[k][1] + T[3 * i + 2] * v[k][2];
        }
    }
    cross(image[0], image[1], n);
    cross(v[0], v[1], normal);
    double area = length(n);
    for (int i = 0; i < 9 && area > 0; i++) {
        T[i] += n[i / 3] / sqrt(area) * normal[i % 3];
    }
    return area > 0;
}

/* Least squares where the frame has `rank` directions, the eigenvectors v of G with the largest
 * eigenvalues. 0 when nothing sensible came out. */
static int solve(const double H[9], const double v[3][3], const double *lambda, int rank,
                 double T[9])
{
    double inverse[9] = {0};
    for (int k = 0; k < rank; k++) {
        for (int i = 0; i < 9; i++) {
            inverse[i] += v[k][i / 3] * v[k][i % 3] / lambda[k];
        }
    }
    multiply(H, inverse, T);
    if (rank == 2) {
        return complete_plane(v, T);
    }
    if (rank == 1) {
        double u[3];
        for (int i = 0; i < 3; i++) {
            u[i] = T[3 * i] * v[0][0] + T[3 * i + 1] * v[0][1] + T[3 * i + 2] * v[0][2];
        }
        double scale = length(u);
        for (int i = 0; i < 3; i++) {
            u[i] /= scale;
        }
        turn_line(v[0], u, scale, T);
        return scale > 0;
    }
    return 1;
}

/* A = T^-1 if T is fit to be played back. */
static int invert(const double T[9], double A[9])
{
    double U[9], s[3], Vt[9];
    svd3(T, U, s, Vt);
    if (!(shape_det(T) > 0 && s[0] <= SHAPE_CONDITION * s[2])) {
        return -1;
    }
    for (int i = 0; i < 9; i++) {
        A[i] = 0;
        for (int k = 0; k < 3; k++) {
            A[i] += Vt[3 * k + i / 3] * U[3 * (i % 3) + k] / s[k];
        }
    }
    return 0;
}

int shape_affine_fit(const double *frame, const double *reference, int vertices, shape_affine *out)
{
    double H[9], G[9], T[9], lambda[3], up[3], v[3][3];
    moments(frame, reference, vertices, out->c, H, G);
    LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'V', 'U', 3, G, 3, up); /* ascending, vectors in columns */
    int rank = 0;
    for (int k = 0; k < 3; k++) {
        lambda[k] = up[2 - k];
        for (int i = 0; i < 3; i++) {
            v[k][i] = G[3 * i + 2 - k];
        }
        rank += lambda[k] > SHAPE_FLAT * SHAPE_FLAT * lambda[0];
    }
    if (rank == 0) { /* all vertices in one place */
        const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        memcpy(out->A, identity, sizeof identity);
        return 0;
    }
    return solve(H, (const double(*)[3])v, lambda, rank, T) ? invert(T, out->A) : -1;
}

/* H = R X^T = U s V^T; T = U diag(1, 1, +-1) V^T, A = T^T. */
void shape_affine_rotate(const double *frame, const double *reference, int vertices,
                         shape_affine *out)
{
    double H[9], G[9], U[9], s[3], Vt[9];
    moments(frame, reference, vertices, out->c, H, G);
    svd3(H, U, s, Vt);
    double sign = shape_det(U) * shape_det(Vt) < 0 ? -1 : 1;
    for (int i = 0; i < 9; i++) {
        out->A[i] = Vt[i / 3] * U[3 * (i % 3)] + Vt[3 + i / 3] * U[3 * (i % 3) + 1] +
                    sign * Vt[6 + i / 3] * U[3 * (i % 3) + 2];
    }
}

void shape_affine_apply(const shape_affine *a, const double *y, int vertices, double *x)
{
    for (int i = 0; i < vertices; i++, y += 3, x += 3) {
        const double p[3] = {y[0], y[1], y[2]};
        for (int k = 0; k < 3; k++) {
            const double *row = &a->A[3 * k];
            x[k] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + a->c[k];
        }
    }
}

void shape_affine_undo(const shape_affine *a, const double *x, int vertices, double *y)
{
    const double *A = a->A, det = shape_det(A);
    double B[9];
    for (int i = 0; i < 9; i++) { /* the adjugate: cofactors transposed */
        int r = (i % 3 + 1) % 3, s = (i % 3 + 2) % 3, p = (i / 3 + 1) % 3, q = (i / 3 + 2) % 3;
        B[i] = (A[3 * r + p] * A[3 * s + q] - A[3 * r + q] * A[3 * s + p]) / det;
    }
    for (int i = 0; i < vertices; i++, x += 3, y += 3) {
        const double p[3] = {x[0] - a->c[0], x[1] - a->c[1], x[2] - a->c[2]};
        for (int k = 0; k < 3; k++) {
            y[k] = B[3 * k] * p[0] + B[3 * k + 1] * p[1] + B[3 * k + 2] * p[2];
        }
    }
}
