/* Discrete shells against what plane stress and the calibration of the bending energy say in closed
 * form.
 * Source: Schulz 2013, 2.3.2; the calibration is that of host-bake/body/shell.c.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shell_sheets.h"

#define PI 3.14159265358979323846

/* A regular hexagon of equilateral triangles, `side` of them along each of its sides, which are 1.
 * Its 9 side^2 - 3 side inner edges go in each of the three directions equally often. */
static void hexagon(body *b, int side, double turned)
{
    int width = 2 * side + 1, count = 0, triangles = 0, *index;
    double *rest = bake_alloc(3 * (size_t)(width * width), sizeof *rest);
    int(*corner)[3] = bake_alloc((size_t)(2 * width * width), sizeof *corner);
    index = bake_alloc((size_t)((width + 1) * (width + 1)), sizeof *index);
#define AT(i, j) index[(i) + (j) * (width + 1)]
    for (int j = 0; j < width; j++)
        for (int i = 0; i < width; i++)
            if (abs(i + j - 2 * side) <= side) {
                double u = i - side + 0.5 * (j - side), v = 0.5 * sqrt(3) * (j - side);
                rest[3 * count] = (u * cos(turned) - v * sin(turned)) / side;
                rest[3 * count + 1] = (u * sin(turned) + v * cos(turned)) / side;
                AT(i, j) = ++count;
            }
    for (int j = 0; j < width; j++)
        for (int i = 0; i < width; i++) {
            int p = AT(i, j), q = AT(i + 1, j), r = AT(i, j + 1), s = AT(i + 1, j + 1);
            if (p && q && r)
                memcpy(corner[triangles++], (int[3]){p - 1, q - 1, r - 1}, sizeof *corner);
            if (q && r && s)
                memcpy(corner[triangles++], (int[3]){q - 1, s - 1, r - 1}, sizeof *corner);
        }
#undef AT
    make(b, count, rest, triangles, (const int(*)[3])corner);
    free(rest);
    free(corner);
    free(index);
}

/* 1/2 u^T H u */
static double quadratic(const double *H, const double *u, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            sum += 0.5 * u[i] * H[i * n + j] * u[j];
    return sum;
}

/* d = displacement gradient (x, y rows). Every triangle has its own share of its edges' weights, so
 * there is no effect of the border. 1e-12: 300 terms of rounding 1e-16, weights of both signs. */
static void equilateral_triangles_are_plane_stress(void)
{
    for (int m = 0; m < MATERIALS; m++) {
        const body_material *p = &materials[m];
        body b;
        hexagon(&b, 3, 0.3);
        prepare(&b, p);
        size_t n = 3 * (size_t)b.vertex_count;
        double *H = dense(&b, b.rest), *u = bake_alloc(n, sizeof *u);
        unsigned state = 5;
        double d[4] = {dice(&state), dice(&state), dice(&state), dice(&state)};
        for (int v = 0; v < b.vertex_count; v++) {
            const double *r = &b.rest[3 * v];
            u[3 * v] = d[0] * r[0] + d[1] * r[1];
            u[3 * v + 1] = d[2] * r[0] + d[3] * r[1];
        }
        double shear = 0.5 * (d[1] + d[2]), trace = d[0] + d[3], nu = p->poisson;
        double square = d[0] * d[0] + d[3] * d[3] + 2 * shear * shear;
        double area = 1.5 * sqrt(3), Y = p->young * p->thickness / (1 - nu * nu);
        double want = 0.5 * Y * area * (nu * trace * trace + (1 - nu) * square);
        CHECK_NEAR(quadratic(H, u, n), want, 1e-12 * Y * area * square);
        free(H);
        free(u);
        body_free(&b);
    }
}

/* By s all around, not small, for any triangles that keep the material's stiffness of area. */
static void uniform_stretch_has_a_closed_form(void)
{
    for (int m = 0; m < 3; m++)
        for (int equilateral = 0; equilateral < 2; equilateral++) {
            const body_material *p = &materials[m];
            body b;
            sheet_triangles(&b, (const double[2]){1, 0.8}, (const int[2]){5, 4}, 0);
            b.mass = NULL;
            b.elements = NULL;
            if (equilateral) {
                body_free(&b);
                hexagon(&b, 2, 0);
            }
            prepare(&b, p);
            double *x = bake_alloc(3 * (size_t)b.vertex_count, sizeof *x), s = 1.3;
            for (int i = 0; i < 3 * b.vertex_count; i++)
                x[i] = s * b.rest[i];
            double nu = p->poisson, area = equilateral ? 1.5 * sqrt(3) : 0.8;
            double k = 4 * p->young * p->thickness / (1 + nu), wide = s * s - 1;
            double kA = p->young * p->thickness * (3 * nu - 1) / (2 * (1 - nu * nu));
            double want = 0.5 * area * (k * (s - 1) * (s - 1) + kA * wide * wide);
            CHECK_NEAR(body_energy(&b, x), want, 1e-12 * k * area);
            free(x);
            body_free(&b);
        }
}

/* Turned about its edge, which changes neither lengths nor areas: 1/2 w theta^2, w = 3 alpha l^2/A.
 * 34 angles, beyond 90 degrees on both sides. */
static void hinge_turns_by_its_closed_form(void)
{
    const double rest[12] = {0, 0, 0, 2, 0, 0, 0.5, 1.5, 0, 1.25, -0.75, 0};
    const int corner[2][3] = {{0, 1, 2}, {1, 0, 3}};
    body b;
    make(&b, 4, rest, 2, corner);
    prepare(&b, &materials[STEEL]);
    for (int i = -17; i <= 17; i++) {
        double turn = i * PI / 18, x[12];
        memcpy(x, rest, sizeof x);
        x[7] = 1.5 * cos(turn);
        x[8] = 1.5 * sin(turn);
        double alpha = materials[STEEL].young * pow(materials[STEEL].thickness, 3) / 32;
        double w = 3 * alpha * 4 / (0.5 * 2 * 1.5 + 0.5 * 2 * 0.75);
        /* membrane: lengths rounded to 2e-16 of 2, squared, times 8 E h */
        CHECK_NEAR(body_energy(&b, x), 0.5 * w * turn * turn, 1e-13 * w);
    }
    body_free(&b);
}

/* z = (a + b) p^2/2 + (a - b) q^2/2 along two perpendicular directions: theta = height (across -
 * along/3) is exact. Each of the 9 n^2 - 3 n inner edges stands for a third of its triangles,
 * 6 n^2 - 2 n of the 6 n^2 triangles: what is missing is the border's, which has no bending. */
static void paraboloids_are_plates_of_poisson_minus_a_third(void)
{
    const double halves[4][2] = {{1, 0}, {0, 1}, {0.5, 0.5}, {2.0 / 3, 1.0 / 3}};
    for (int side = 1; side <= 4; side++)
        for (int c = 0; c < 4; c++) {
            body b;
            hexagon(&b, side, 0);
            prepare(&b, &materials[STEEL]);
            size_t n = 3 * (size_t)b.vertex_count;
            double *H = dense(&b, b.rest), *u = bake_alloc(n, sizeof *u);
            double A = halves[c][0], B = halves[c][1];
            for (int v = 0; v < b.vertex_count; v++) {
                const double *r = &b.rest[3 * v];
                double p = r[0] * cos(0.4) + r[1] * sin(0.4), q = r[1] * cos(0.4) - r[0] * sin(0.4);
                u[3 * v + 2] = 0.5 * ((A + B) * p * p + (A - B) * q * q);
            }
            double Eh3 = materials[STEEL].young * pow(materials[STEEL].thickness, 3),
                   area = 1.5 * sqrt(3);
            double inner = 1 - 1.0 / (3 * side), want = 0.5 * Eh3 / 32 * (4 * A * A + 8 * B * B);
            CHECK_NEAR(quadratic(H, u, n), want * area * inner, 1e-11 * Eh3);
            if (c == 3) /* curvatures 1 and 1/3: the beam */
                CHECK_NEAR(want, 0.5 * Eh3 / 12, 1e-14 * Eh3);
            free(H);
            free(u);
            body_free(&b);
        }
}

/* A cylinder, curved one way, held straight the other: D = 3 E h^3/32, 9/8 of the beam's. Without
 * the border's share (above) the error is of second order in the length l of the edges, as an arc's
 * chord is: below l^2/12, and falling to a quarter (0.1: the fourth order), rolled whichever way.
 * So thick that the chords' membrane energy, l^4/h^2 of the bending's, does not count. */
static void rolled_sheet_converges_with_order_two(void)
{
    for (double turned = 0; turned < 1; turned += 0.3) {
        double error[3];
        for (int i = 0; i < 3; i++) {
            body b;
            int side = 4 << i;
            hexagon(&b, side, turned);
            prepare(&b, &(body_material){1e6, 0.3, 1000, 100});
            double *x = rolled(&b, 1, 0), inner = 1 - 1.0 / (3 * side);
            double want = 0.5 * 3 * 1e6 * 1e6 / 32 * 1.5 * sqrt(3);
            error[i] = body_energy(&b, x) / (inner * want) - 1;
            free(x);
            body_free(&b);
        }
        CHECK(fabs(error[2]) < 1.0 / (12 * 16 * 16));
        CHECK_NEAR(error[0] / error[1], 4, 0.1);
        CHECK_NEAR(error[1] / error[2], 4, 0.1);
    }
}

int main(void)
{
    TEST(equilateral_triangles_are_plane_stress);
    TEST(uniform_stretch_has_a_closed_form);
    TEST(hinge_turns_by_its_closed_form);
    TEST(paraboloids_are_plates_of_poisson_minus_a_third);
    TEST(rolled_sheet_converges_with_order_two);
    return check_done();
}
