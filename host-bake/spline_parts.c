/* A segment as a function of the values and velocities at its two knots, and integrals over it.
 * Source: Schulz 2013, 2.5.1; the split into even and odd halves is our own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_parts.h"

#include <math.h>

int bake_family_index(bake_family family, int parity, int which)
{
    /* products: C c even, C s odd, S c odd, S s even; sums and powers alternate */
    static const int of_product[2][2] = {{0, 3}, {1, 2}}, of_sum[2][2] = {{0, 2}, {1, 3}};
    int product = family == BAKE_OSC || family == BAKE_CRIT || family == BAKE_HYP;
    return product ? of_product[parity][which] : of_sum[parity][which];
}

/* The 2 x 2 system of one parity: its inverse, and H^2 acceleration from (value, H velocity). */
static void invert(bake_part *part, bake_family family, int parity, double acceleration[2])
{
    int i = bake_family_index(family, parity, 0), j = bake_family_index(family, parity, 1);
    const double(*e)[4] = (const double(*)[4])part->end;
    double determinant = e[0][i] * e[1][j] - e[0][j] * e[1][i];
    double(*inverse)[2] = part->inverse[parity];
    inverse[0][0] = e[1][j] / determinant;
    inverse[0][1] = -e[0][j] / determinant;
    inverse[1][0] = -e[1][i] / determinant;
    inverse[1][1] = e[0][i] / determinant;
    for (int k = 0; k < 2; k++)
        acceleration[k] = e[2][i] * inverse[0][k] + e[2][j] * inverse[1][k];
}

static void fill_end(bake_part *part, const bake_segment *segment)
{
    double all[4][5], H = part->H, scale = 1.0;
    bake_segment_functions(segment, H, all);
    for (int i = 0; i < 4; i++, scale *= H) {
        part->part[i] = all[i][4] * scale;
        for (int j = 0; j < 4; j++)
            part->end[i][j] = all[i][j] * scale;
    }
}

void bake_part_prepare(bake_part *part, const bake_segment *segment)
{
    double even[2], odd[2], H = 0.5 * (segment->t1 - segment->t0), H2 = H * H;
    part->H = H;
    fill_end(part, segment);
    invert(part, segment->family, 0, even);
    invert(part, segment->family, 1, odd);
    part->right[0] = 0.5 * (even[0] - odd[0]) / H2;
    part->right[1] = 0.5 * (odd[1] - even[1]) / H;
    part->right[2] = 0.5 * (even[0] + odd[0]) / H2;
    part->right[3] = 0.5 * (odd[1] + even[1]) / H;
    part->left[0] = part->right[2];
    part->left[1] = -part->right[3];
    part->left[2] = part->right[0];
    part->left[3] = -part->right[1];
    part->shift = (part->part[2] - even[0] * part->part[0] - even[1] * part->part[1]) / H2;
}

void bake_part_coefficients(const bake_part *part, const double w[2], const double v[2],
                            bake_segment *segment)
{
    double value[2] = {0.5 * (w[0] + w[1]) - part->part[0], 0.5 * (w[1] - w[0])};
    double slope[2] = {0.5 * part->H * (v[1] - v[0]) - part->part[1],
                       0.5 * part->H * (v[0] + v[1])};
    for (int parity = 0; parity < 2; parity++)
        for (int i = 0; i < 2; i++) {
            const double *row = part->inverse[parity][i];
            segment->w[bake_family_index(segment->family, parity, i)] =
                row[0] * value[parity] + row[1] * slope[parity];
        }
}

static const double gauss_node[8] = {
    0.0950125098376374402, 0.281603550779258913, 0.458016777657227386, 0.617876244402643748,
    0.755404408355003034,  0.865631202387831744, 0.944575023073232576, 0.989400934991649933};
static const double gauss_weight[8] = {
    0.189450610455068496, 0.182603415044923589,  0.169156519395002538,  0.149595988816576732,
    0.124628971255533872, 0.0951585116824927848, 0.0622535239386478929, 0.0271524594117540949};

/* One panel at distances [near, far] from the ends, and its mirror image. */
static void panel(double H, double near, double far, bake_visit *visit, void *context)
{
    double middle = H - 0.5 * (near + far), half = 0.5 * (far - near);
    for (int i = 0; i < 8; i++)
        for (int side = -1; side <= 1; side += 2) {
            double s = middle + side * half * gauss_node[i], weight = half * gauss_weight[i];
            visit(context, s, weight);
            visit(context, -s, weight);
        }
}

void bake_segment_quadrature(const bake_segment *segment, bake_visit *visit, void *context)
{
    double H = 0.5 * (segment->t1 - segment->t0), a = segment->a, b = segment->b;
    double first = H, longest = H;
    if (segment->family != BAKE_POLY && segment->family != BAKE_SERIES)
        first = fmin(H, 2.0 / (a + b));
    if (segment->family == BAKE_OSC)
        longest = fmin(H, 3.14 / b);
    /* first grows by doubling, then by half periods: at most 60 + b H / 3.14 panels */
    for (double near = 0.0, far = fmin(first, longest); near < H;) {
        panel(H, near, far, visit, context);
        near = far;
        far = fmin(2.0 * far, far + longest);
        if (far > H * (1.0 - 1e-9))
            far = H;
    }
}
