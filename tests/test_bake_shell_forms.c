/* Shells against what plane stress and bent plates say in closed form.
 * Source: the energy of host-bake/body/shell.c; the closed forms are derived here.
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

/* nu (tr Q)^2 + (1 - nu) tr Q^2 of a symmetric matrix (xx, yy, xy). */
static double invariant(const double q[3], double nu)
{
    double trace = q[0] + q[1];
    return nu * trace * trace + (1 - nu) * (q[0] * q[0] + q[1] * q[1] + 2 * q[2] * q[2]);
}

static double bending_stiffness(const body_material *m)
{
    return m->young * pow(m->thickness, 3) / (12 * (1 - m->poisson * m->poisson));
}

/* Columns F[0], F[1] of a map of the plane into space: stretched, sheared, turned. */
typedef struct {
    double column[2][3];
} flat_map;

static void green(const flat_map *F, double e[3])
{
    const double *p = F->column[0], *q = F->column[1];
    e[0] = 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - 1);
    e[1] = 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1);
    e[2] = 0.5 * (p[0] * q[0] + p[1] * q[1] + p[2] * q[2]);
}

/* The sheet stays flat, so its energy is that of one strain: E h/(2 (1 - nu^2)) times the invariant
 * of E and the area. Rounding: strains of up to 40 (stretched by 9) in each triangle, 1e-16 of
 * them, times the 1e1 by which a shaken triangle is thinner than its sides: 1e-14 of the energy.
 * Angles are 0 to 1e-15, squared. */
static void sheets_are_plane_stress_on_any_triangles(void)
{
    const flat_map map[4] = {{{{1.3, 0, 0}, {0, 1.3, 0}}},
                             {{{1, 0, 0}, {0.4, 1, 0}}},
                             {{{0.9, 0.2, 0.5}, {-0.3, 1.2, 0.1}}},
                             {{{9, 0, 0}, {0, 6, 0}}}};
    for (int m = 0; m < MATERIALS; m++)
        for (int mesh = 0; mesh < MESHES; mesh++) {
            const body_material *p = &materials[m];
            body b;
            sheet(&b, mesh, (const double[2]){1, 0.8}, (const int[2]){5, 4});
            prepare(&b, p);
            double *x = bake_alloc(3 * (size_t)b.vertex_count, sizeof *x), e[3];
            for (int k = 0; k < 4; k++) {
                for (int i = 0; i < 3 * b.vertex_count; i++)
                    x[i] = map[k].column[0][i % 3] * b.rest[i - i % 3] +
                           map[k].column[1][i % 3] * b.rest[i - i % 3 + 1];
                green(&map[k], e);
                double Y = p->young * p->thickness / (1 - p->poisson * p->poisson);
                double want = 0.8 * 0.5 * Y * invariant(e, p->poisson);
                CHECK_NEAR(body_energy(&b, x), want, 1e-13 * want);
            }
            free(x);
            body_free(&b);
        }
}

/* A strain of 1e-12 gives an energy of 1e-24 with all digits that the coordinates have: they are
 * rounded to 1e-16, 1e-4 of the displacements. Strains from squared lengths would be 1e-16 of 1
 * wrong everywhere, and V(rest) not 0. */
static void tiny_strains_keep_their_digits(void)
{
    body b;
    sheet(&b, IRREGULAR, (const double[2]){1, 0.8}, (const int[2]){5, 4});
    prepare(&b, &materials[STEEL]);
    double *x = bake_alloc(3 * (size_t)b.vertex_count, sizeof *x), e[3] = {1e-12, 0, 0};
    for (int i = 0; i < 3 * b.vertex_count; i++)
        x[i] = b.rest[i] + (i % 3 ? 0 : 1e-12 * b.rest[i]);
    const body_material *p = &materials[STEEL];
    double nu = p->poisson, Y = p->young * p->thickness / (1 - nu * nu);
    double want = 0.8 * 0.5 * Y * invariant(e, nu);
    CHECK_NEAR(body_energy(&b, x), want, 1e-3 * want);
    CHECK(body_energy(&b, b.rest) == 0);
    free(x);
    body_free(&b);
}

/* One triangle with a hinge at side 0 and borders at sides 1, 2: T = t_1 t_2^T + t_2 t_1^T, t along
 * the sides, does not see what turns there, so T . L = turn/height n_0^T T n_0, and the least
 * invariant of such an L is that squared over its dual at T: (tr T^2 - nu/(1 + nu) (tr T)^2)/(1 -
 * nu). */
static double ear(const double side[3][2], double turn, double nu)
{
    double l = hypot(side[0][0], side[0][1]), area, T[3], seen;
    const double *s = side[1], *t = side[2], n[2] = {side[0][1] / l, -side[0][0] / l};
    area = 0.5 * fabs(s[0] * t[1] - s[1] * t[0]);
    T[0] = 2 * s[0] * t[0];
    T[1] = 2 * s[1] * t[1];
    T[2] = s[0] * t[1] + s[1] * t[0];
    seen = n[0] * n[0] * T[0] + n[1] * n[1] * T[1] + 2 * n[0] * n[1] * T[2];
    seen *= turn * l / (2 * area);
    double trace = T[0] + T[1], square = T[0] * T[0] + T[1] * T[1] + 2 * T[2] * T[2];
    return area * seen * seen * (1 - nu) / (square - nu / (1 + nu) * trace * trace);
}

/* Turned about its edge, which strains nothing. 34 angles, beyond 90 degrees on both sides. */
static void hinge_turns_by_its_closed_form(void)
{
    const double rest[12] = {0, 0, 0, 2, 0, 0, 0.5, 1.5, 0, 1.25, -0.75, 0};
    const double up[3][2] = {{2, 0}, {-1.5, 1.5}, {-0.5, -1.5}};
    const double down[3][2] = {{2, 0}, {-0.75, -0.75}, {-1.25, 0.75}};
    const int corner[2][3] = {{0, 1, 2}, {1, 0, 3}};
    for (int m = 0; m < MATERIALS; m++) {
        body b;
        make(&b, 4, rest, 2, corner);
        prepare(&b, &materials[m]);
        double D = bending_stiffness(&materials[m]), nu = materials[m].poisson;
        for (int i = -17; i <= 17; i++) {
            double turn = i * PI / 18, x[12];
            memcpy(x, rest, sizeof x);
            x[7] = 1.5 * cos(turn);
            x[8] = 1.5 * sin(turn);
            double want = 0.5 * D * (ear(up, turn, nu) + ear(down, turn, nu));
            /* membrane: strains rounded to 2e-16, squared, times E h < 1e12 D; angles to 1e-15 */
            CHECK_NEAR(body_energy(&b, x), want, 1e-13 * D);
        }
        body_free(&b);
    }
}

/* Borders that are nearly parallel leave almost nothing to minimise over, but not less than
 * nothing: what is eliminated with the second one is w^2 or its rounding against the first, and so
 * is what it takes from the hinge. Some 100 roundings: 1e-14. */
static void slivers_at_the_border_have_the_closed_form(void)
{
    const int corner[2][3] = {{0, 1, 2}, {1, 0, 3}};
    for (int i = 0; i < 100; i++) {
        double w = pow(10, -2 - 0.09 * i), nu = materials[STEEL].poisson;
        const double rest[12] = {0, 0, 0, w, 0, 0, 0.3 * w, 1, 0, 0.1 * w, -0.7, 0};
        const double up[3][2] = {{w, 0}, {-0.7 * w, 1}, {-0.3 * w, -1}};
        const double down[3][2] = {{w, 0}, {-0.9 * w, -0.7}, {-0.1 * w, 0.7}};
        body b;
        make(&b, 4, rest, 2, corner);
        prepare(&b, &materials[STEEL]);
        double x[12], D = bending_stiffness(&materials[STEEL]);
        memcpy(x, rest, sizeof x);
        x[7] = cos(0.5);
        x[8] = sin(0.5);
        double least = 0.5 * D * (ear(up, 0.5, nu) + ear(down, 0.5, nu));
        CHECK_NEAR(body_energy(&b, x), least, 1e-12 * least);
        body_free(&b);
    }
}

/* What a hexagon of area 3/2 sqrt(3) and curvatures a + b, a - b should have, over D: of 6 side^2
 * triangles 6 side have one side on the border, equally often in each of three directions. There
 * the curvature across, u, is free: the least of the invariant is (1 - nu^2) v^2 + 2 (1 - nu) w^2,
 * v along the border and w mixed, whose means are a^2 + b^2/2 and b^2/2. */
static double hexagon_energy(int side, double a, double b, double nu)
{
    double inner = 2 * (1 + nu) * a * a + 2 * (1 - nu) * b * b;
    double border = (1 - nu * nu) * (a * a + 0.5 * b * b) + (1 - nu) * b * b;
    return 0.5 * 1.5 * sqrt(3) * (inner + (border - inner) / side);
}

/* z = (a + b) p^2/2 + (a - b) q^2/2 along two perpendicular directions: L is exact, whatever
 * Poisson's ratio. 1e-11: 300 terms of rounding 1e-16, and turns over heights of 0.2 from
 * coordinates of 1. */
static void paraboloids_are_plates_of_the_material(void)
{
    const double halves[4][2] = {{1, 0}, {0, 1}, {0.5, 0.5}, {0.3, -0.8}};
    for (int side = 1; side <= 4; side++)
        for (int c = 0; c < 4 * MATERIALS; c++) {
            const body_material *m = &materials[c / 4];
            body b;
            hexagon(&b, side, 0);
            prepare(&b, m);
            size_t n = 3 * (size_t)b.vertex_count;
            double *H = dense(&b, b.rest), *u = bake_alloc(n, sizeof *u);
            double A = halves[c % 4][0], B = halves[c % 4][1], D = bending_stiffness(m);
            for (int v = 0; v < b.vertex_count; v++) {
                const double *r = &b.rest[3 * v];
                double p = r[0] * cos(0.4) + r[1] * sin(0.4), q = r[1] * cos(0.4) - r[0] * sin(0.4);
                u[3 * v + 2] = 0.5 * ((A + B) * p * p + (A - B) * q * q);
            }
            CHECK_NEAR(quadratic(H, u, n), D * hexagon_energy(side, A, B, m->poisson), 1e-11 * D);
            free(H);
            free(u);
            body_free(&b);
        }
}

/* A cylinder, curved one way, straight the other. Without the border's share (above) the error is
 * of second order in the length l of the edges, as an arc's chord is: below l^2/12 on hinges and
 * their heights each, so l^2/4 in the square of their ratio; falling to a quarter (0.1: the fourth
 * order), rolled whichever way. So thick that the chords' membrane energy, l^4/h^2 of the
 * bending's, does not count. */
static void rolled_sheet_converges_with_order_two(void)
{
    const body_material m = {1e6, 0.3, 1000, 100};
    for (double turned = 0; turned < 1; turned += 0.3) {
        double error[3];
        for (int i = 0; i < 3; i++) {
            body b;
            int side = 4 << i;
            hexagon(&b, side, turned);
            prepare(&b, &m);
            double *x = rolled(&b, 1, 0);
            double want = bending_stiffness(&m) * hexagon_energy(side, 0.5, 0.5, m.poisson);
            error[i] = body_energy(&b, x) / want - 1;
            free(x);
            body_free(&b);
        }
        CHECK(fabs(error[2]) < 1.0 / (4 * 16 * 16));
        CHECK_NEAR(error[0] / error[1], 4, 0.1);
        CHECK_NEAR(error[1] / error[2], 4, 0.1);
    }
}

int main(void)
{
    TEST(sheets_are_plane_stress_on_any_triangles);
    TEST(tiny_strains_keep_their_digits);
    TEST(hinge_turns_by_its_closed_form);
    TEST(slivers_at_the_border_have_the_closed_form);
    TEST(paraboloids_are_plates_of_the_material);
    TEST(rolled_sheet_converges_with_order_two);
    return check_done();
}
