/* Frequencies of bodies under refinement, and on different meshes of one shape. What they tend to: Timoshenko's
 * beam [Huang 1961], Saint-Venant's torsion, Love's rod, Kirchhoff's plate.
 *   test_bake_frequencies [--write]   --write: what was measured becomes tests/budget/bodies.csv
 *   VERBOSE=1 prints it
 * SPDX-License-Identifier: MIT */
#include "body_modes.h"

#include <stdlib.h>
#include <string.h>

#define PI     3.14159265358979323846
#define LEVELS 3
#define BUDGET "tests/budget/bodies.csv"

/* ---- figures that are kept ----------------------------------------------------------------------- */

#define FIGURES 64

static struct {
    char name[64];
    double value;
} figure[FIGURES];
static int figures;

/* tag, level: parts of the name. */
static void keep(const char *tag, int level, double value)
{
    if (figures == FIGURES)
        abort();
    snprintf(figure[figures].name, sizeof figure[figures].name, tag, level);
    figure[figures++].value = value;
}

/* What three levels of halved cells tend to when their error begins with power `order` of the cells, and the
 * order that they show. slack: what is left, if the next term has twice that power; doubled, as it need not
 * be alone. */
typedef struct {
    double order, value, slack;
} limit;

static limit limit_of(const double x[LEVELS], int order)
{
    double factor = order == 2 ? 4 : 2, next = factor * factor;
    double first = x[1] + (x[1] - x[0]) / (factor - 1), last = x[2] + (x[2] - x[1]) / (factor - 1);
    return (limit){log2((x[0] - x[1]) / (x[1] - x[2])), last, 2 * fabs(last - first) / (next - 1)};
}

/* Of a second-order limit: when at the coarsest level the fourth power is at most a quarter of the square, the
 * ratio of changes, 4 (1 -+ 5/16)/(1 -+ 5/64), is off by 0.42 powers of two at most. */
#define ORDER_SLACK 0.42

static limit report(const char *name, const double x[LEVELS], int order)
{
    limit l = limit_of(x, order);
    if (getenv("VERBOSE"))
        printf("  %-34s %.5f %.5f %.5f  order %.2f, limit %.5f +- %.5f\n", name, x[0], x[1], x[2],
               l.order, l.value, l.slack);
    for (int i = 0; i < LEVELS; i++) {
        char tag[64];
        snprintf(tag, sizeof tag, "%s; level %%d", name);
        keep(tag, i, x[i]);
    }
    return l;
}

/* ---- beams --------------------------------------------------------------------------------------- */

#define LENGTH  1.0
#define HEIGHT  0.1
#define YOUNG   1e6
#define POISSON 0.3
#define DENSITY 1000.0

/* Huang's equations for b, b^2 = rho A L^4 omega^2/(E I); zero at a frequency. r2, s2: rotary inertia and shear. */
static double huang(int held, double r2, double s2, double b)
{
    double root = sqrt((r2 - s2) * (r2 - s2) + 4 / (b * b));
    double alpha = b * sqrt((root - r2 - s2) / 2), beta = b * sqrt((root + r2 + s2) / 2);
    double square = b * b * (r2 - s2) * (r2 - s2), w = sqrt(1 - b * b * r2 * s2);
    if (held)
        return 2 + (square + 2) * cosh(alpha) * cos(beta) -
               b * (r2 + s2) / w * sinh(alpha) * sin(beta);
    return 2 - 2 * cosh(alpha) * cos(beta) +
           b / w * (r2 * square + 3 * r2 - s2) * sinh(alpha) * sin(beta);
}

/* omega^2 of bending mode `number` (from 0) of a square bar; Cowper's coefficient of shear. */
static double timoshenko(int held, int number)
{
    double kappa = 10 * (1 + POISSON) / (12 + 11 * POISSON), r2 = HEIGHT * HEIGHT / 12;
    double s2 = r2 * 2 * (1 + POISSON) / kappa, step = 0.01, b = 0.5;
    for (int found = -1; found < number; b += step)
        found += huang(held, r2, s2, b) * huang(held, r2, s2, b + step) < 0;
    double low = b - step, high = b;
    for (int i = 0; i < 60; i++) {
        double middle = (low + high) / 2;
        if (huang(held, r2, s2, low) * huang(held, r2, s2, middle) <= 0)
            high = middle;
        else
            low = middle;
    }
    return low * low * YOUNG * HEIGHT * HEIGHT / (12 * DENSITY);
}

/* omega^2 of the first twist of a square bar: J/I_p = 6 (1/3 - 64/pi^5 sum tanh(n pi/2)/n^5). */
static double twist(int held)
{
    double J = 1.0 / 3, k = (held ? 0.5 : 1) * PI / LENGTH;
    for (int n = 1; n < 40; n += 2)
        J -= 64 / pow(PI, 5) * tanh(n * PI / 2) / pow(n, 5);
    return k * k * 6 * J * YOUNG / (2 * (1 + POISSON) * DENSITY);
}

/* omega^2 of the first stretch [Love]: sections that get thinner move sideways, r^2 = h^2/6. */
static double stretch(int held)
{
    double k = (held ? 0.5 : 1) * PI / LENGTH;
    return k * k * YOUNG / DENSITY / (1 + POISSON * POISSON * k * k * HEIGHT * HEIGHT / 6);
}

/* How much of a mode stretches, or twists, like the first wave: a projection, in units of no matter. */
static double share(const body *b, const double *phi, int held, int twists)
{
    double sum = 0, norm = 0;
    for (int i = 0; i < b->vertex_count; i++) {
        const double *x = &b->rest[3 * i], *u = &phi[3 * i];
        double wave = held ? sin(PI / 2 * x[0] / LENGTH) : cos(PI * x[0] / LENGTH);
        double y = x[1] - HEIGHT / 2, z = x[2] - HEIGHT / 2;
        double v[3] = {twists ? 0 : wave, twists ? -z * wave : 0, twists ? y * wave : 0};
        for (int k = 0; k < 3; k++) {
            sum += b->mass[i] * u[k] * v[k];
            norm += b->mass[i] * v[k] * v[k];
        }
    }
    return sum * sum / norm;
}

enum { BEND_1, BEND_2, TWIST, STRETCH, KINDS };

/* I_p of the lumped masses over the section's: 1.5 of 2 cells. Known, so that it is taken out. */
static double inertia(const body *b)
{
    double sum = 0;
    for (int i = 0; i < b->vertex_count; i++) {
        double y = b->rest[3 * i + 1] - HEIGHT / 2, z = b->rest[3 * i + 2] - HEIGHT / 2;
        sum += b->mass[i] * (y * y + z * z);
    }
    return sum / (DENSITY * LENGTH * pow(HEIGHT, 4) / 6);
}

/* lambda over theory, of each kind. The mesh has all symmetries of the bar: bending comes in pairs, and does
 * not mix with the others. */
static void bar(int held, int cells, double out[KINDS])
{
    enum { COUNT = 14 };
    body b = {.material = {.young = YOUNG, .poisson = POISSON, .density = DENSITY}};
    int first = held ? 0 : 6, kind[2] = {0, 0}, bends = 0;
    modes m;
    box_tets(&b, (const double[]){LENGTH, HEIGHT, HEIGHT}, (const int[]){10 * cells, cells, cells});
    modes_of(&b, held ? hold_left : all_free, first + COUNT, &m);
    CHECK_EQ(m.rigid, first);
    CHECK_EQ(m.negative, 0);
    double most[2] = {0, 0}, bend[COUNT];
    for (int j = first; j < m.count; j++)
        for (int k = 0; k < 2; k++) {
            double s = share(&b, m.phi + (size_t)j * (size_t)m.n, held, k == 0);
            if (s > most[k]) {
                most[k] = s;
                kind[k] = j;
            }
        }
    for (int j = first; j < m.count; j++)
        if (j != kind[0] && j != kind[1])
            bend[bends++] = m.lambda[j];
    CHECK(most[0] > 0.9 && most[1] > 0.9); /* of 1 */
    CHECK_NEAR(bend[1] / bend[0], 1, 1e-9);
    CHECK_NEAR(bend[3] / bend[2], 1, 1e-9);
    out[BEND_1] = bend[0] / timoshenko(held, 0);
    out[BEND_2] = bend[2] / timoshenko(held, 1);
    out[TWIST] = m.lambda[kind[0]] * inertia(&b) / twist(held);
    out[STRETCH] = m.lambda[kind[1]] / stretch(held);
    modes_free(&m);
    body_free(&b);
}

static void levels(int held, double x[KINDS][LEVELS])
{
    for (int i = 0; i < LEVELS; i++) {
        double found[KINDS];
        bar(held, 2 << i, found);
        for (int k = 0; k < KINDS; k++)
            x[k][i] = found[k];
    }
}

static const char *const names[2][KINDS] = {
    {"free bar, bending 1", "free bar, bending 2", "free bar, twist", "free bar, stretch"},
    {"held bar, bending 1", "held bar, bending 2", "held bar, twist", "held bar, stretch"}};

/* Linear tetrahedra are too stiff for bending and twisting, by C/cells^2: from above. Timoshenko's beam is exact
 * to fourth order in k h; what its coefficient of shear misses is of sixth, (k h)^4/12 = 0.4 % of lambda for
 * k = 7.85, 5e-4 for 4.73. Ends are free to warp; (pi h/L)^2 E C_w/(G J) = 2.5e-4 for a square. Love's rod:
 * (k h)^4 nu^2/36 and less, 1e-4. */
static void a_free_bar_bends_twists_and_stretches_as_theory_says(void)
{
    const double theory[KINDS] = {5e-4, 4e-3, 2.5e-4, 1e-4};
    double x[KINDS][LEVELS];
    levels(0, x);
    for (int k = 0; k < KINDS; k++) {
        limit l = report(names[0][k], x[k], 2);
        CHECK(k == STRETCH || (x[k][0] > x[k][1] && x[k][1] > x[k][2]));
        CHECK_NEAR(l.order, 2, ORDER_SLACK);
        CHECK_NEAR(l.value, 1, l.slack + theory[k]);
    }
}

/* The clamp forbids sections to get thinner and to warp. That makes about half a height stiffer: for bending
 * and stretching from E to at most E (1 - nu)/((1 + nu) (1 - 2 nu)) = 1.35 E, on average over that depth by half
 * of it. That half height holds 3 h/(2 L) of the energy of bending in the first mode (curvature goes to 0 at
 * the other end), 4 h/(2 L) in the second, 2 h/(2 L) of stretching: 2.6, 3.5 and 1.8 %. For twisting it is like a
 * bar shorter by h/4, 2 h/(4 L) of lambda: 5 %. */
static void a_held_bar_is_a_little_stiffer_than_theory_says(void)
{
    const double theory[KINDS] = {0.026, 0.035, 0.05, 0.018};
    double x[KINDS][LEVELS];
    levels(1, x);
    for (int k = 0; k < KINDS; k++) {
        limit l = report(names[1][k], x[k], 2);
        CHECK(x[k][0] > x[k][1] && x[k][1] > x[k][2]);
        CHECK(k == STRETCH || fabs(l.order - 2) <= ORDER_SLACK); /* that one's error is small */
        CHECK(l.value > 1 && l.value < 1 + l.slack + theory[k]);
    }
}

/* ---- cubes --------------------------------------------------------------------------------------- */

static void add_tet(body *b, int a, int c, int d, int e)
{
    const int corner[4] = {a, c, d, e};
    memcpy(b->element[b->element_count++], corner, sizeof corner);
}

/* The vertices of box_tets, five tetrahedra a cell: one in the middle of four at corners. */
static void box_of_fives(body *b, const double size[3], const int cells[3])
{
    box_tets(b, size, cells);
    b->element_count = 0;
    for (int at = 0; at < cells[0] * cells[1] * cells[2]; at++) {
        int i = at % cells[0], j = at / cells[0] % cells[1], k = at / cells[0] / cells[1], v[8];
        int odd = (i + j + k) % 2;
        for (int c = 0; c < 8; c++) /* odd cells are mirrored along x */
            v[c] = box_vertex(cells, i + (c % 2 != odd), j + c / 2 % 2, k + c / 4);
        add_tet(b, v[1], v[2], v[odd ? 7 : 4], v[odd ? 4 : 7]);
        add_tet(b, v[0], v[1], v[odd ? 4 : 2], v[odd ? 2 : 4]);
        add_tet(b, v[3], v[1], v[odd ? 2 : 7], v[odd ? 7 : 2]);
        add_tet(b, v[5], v[1], v[odd ? 7 : 4], v[odd ? 4 : 7]);
        add_tet(b, v[6], v[2], v[odd ? 4 : 7], v[odd ? 7 : 4]);
    }
}

/* A free cube's first elastic modes: a pair and two triples, alike but for rounding on these meshes. */
enum { SOFT = 8 };

static void cube(int fives, int cells, double lambda[SOFT])
{
    const double size[3] = {1, 1, 1};
    body b = {.material = {1, 0.3, 1, 0}};
    modes m;
    (fives ? box_of_fives : box_tets)(&b, size, (const int[]){cells, cells, cells});
    modes_of(&b, all_free, 6 + SOFT, &m);
    CHECK_EQ(m.rigid, 6);
    memcpy(lambda, m.lambda + 6, SOFT * sizeof *lambda);
    modes_free(&m);
    body_free(&b);
}

/* Different triangulations are differently wrong and agree in the limit. */
static void meshes_of_a_cube_agree_the_better_the_finer(void)
{
    double x[2][SOFT][LEVELS], lambda[SOFT];
    for (int i = 0; i < LEVELS; i++)
        for (int fives = 0; fives < 2; fives++) {
            cube(fives, 4 << i, lambda);
            for (int k = 0; k < SOFT; k++)
                x[fives][k][i] = lambda[k];
        }
    for (int k = 0; k < SOFT; k++) {
        limit six = limit_of(x[0][k], 2), five = limit_of(x[1][k], 2);
        double apart[LEVELS];
        for (int i = 0; i < LEVELS; i++)
            apart[i] = fabs(x[0][k][i] - x[1][k][i]);
        if (getenv("VERBOSE"))
            printf("  cube, mode %2d: %.5f +- %.5f, %.5f +- %.5f; apart %.4f %.4f %.4f\n", k,
                   six.value, six.slack, five.value, five.slack, apart[0], apart[1], apart[2]);
        CHECK_NEAR(six.value, five.value, six.slack + five.slack);
        CHECK(apart[1] < apart[0] / 2 && apart[2] < apart[1] / 2); /* a quarter, in the end */
        for (int s = 0; k != 0 && k != 2 && k != 5 && s < 2; s++)
            CHECK_NEAR(x[s][k][2] / x[s][k - 1][2], 1, 1e-9);
        keep("cube in sixes, 16 cells, mode %d", k, x[0][k][2]);
        keep("cube in fives, 16 cells, mode %d", k, x[1][k][2]);
    }
}

/* ---- plates -------------------------------------------------------------------------------------- */

#define ROW 0.86602540378443865 /* height of an equilateral triangle */

static void support_border(const body *b, freedom *f)
{
    const double *end = &b->rest[3 * (b->vertex_count - 1)];
    freedom_make(b->vertex_count, f);
    for (int i = 0; i < b->vertex_count; i++) {
        const double *x = &b->rest[3 * i];
        if (x[0] == 0 || x[0] == end[0] || x[1] == 0 || x[1] == end[1])
            freedom_slide(f, i, (const double[]){0, 0, 1});
    }
}

/* A limit of errors b/n + a/n^2, n halved cells: of three levels. */
static double two_orders(const double x[3])
{
    return (x[0] - 6 * x[1] + 8 * x[2]) / 3;
}

/* A supported plate of equilateral triangles, 8 x 10 of them and finer: pi^4 (m^2/a^2 + n^2/b^2)^2 D/(rho h). In
 * its plane it is free. Beside the error of the inside, of second order, there is that of the half triangles
 * along two sides, which do not know the curvature along the border: a part of 1/n, of first order. What comes
 * next is of third: a seventh of what one level more changes, doubled. */
static void a_supported_plate_tends_to_kirchhoffs(void)
{
    enum { FINER = 4, MODES = 4 };
    const body_material steel = {2e11, 0.3, 7850, 1e-3};
    const double side = 10 * ROW / 8, stiffness = steel.young * 1e-6 / (12 * (1 - 0.09));
    const int waves[MODES][2] = {{1, 1}, {1, 2}, {2, 1}, {2, 2}};
    double x[MODES][FINER];
    for (int i = 0; i < FINER; i++) {
        body b = {.material = steel};
        modes m;
        sheet_triangles(&b, (const double[]){1, side}, (const int[]){8 << i, 10 << i}, 1);
        modes_of(&b, support_border, 3 + MODES, &m);
        CHECK_EQ(m.rigid, 3);
        for (int k = 0; k < MODES; k++) {
            double p = waves[k][0], q = waves[k][1] / side, wave = PI * PI * (p * p + q * q);
            x[k][i] = m.lambda[3 + k] * steel.density / (stiffness * wave * wave);
            keep("supported plate, mode %d", k, x[k][i]);
        }
        modes_free(&m);
        body_free(&b);
    }
    for (int k = 0; k < MODES; k++) {
        double before = two_orders(x[k]), last = two_orders(x[k] + 1);
        if (getenv("VERBOSE"))
            printf("  supported plate, mode %d: %.5f %.5f %.5f %.5f  limit %.5f %.5f\n", k, x[k][0],
                   x[k][1], x[k][2], x[k][3], before, last);
        CHECK_NEAR(last, 1, fabs(last - before) * 2 / 7 + 1e-5);
    }
}

static void hold_first_cell(const body *b, freedom *f)
{
    double width = b->rest[3];
    freedom_make(b->vertex_count, f);
    for (int i = 0; i < b->vertex_count; i++)
        if (b->rest[3 * i] < 1.25 * width)
            freedom_fix(f, i);
}

/* nu = 0: what bends along does not bend across, and Euler and Bernoulli are exact for thin strips. The clamp is
 * somewhere in the width of a cell, as rows are shifted by turns: an error of first order. */
static void a_strip_bends_like_a_beam(void)
{
    for (int held = 0; held < 2; held++) {
        const double root = held ? 1.87510406871196 : 4.73004074486270;
        double x[LEVELS];
        for (int i = 0; i < LEVELS; i++) {
            body b = {.material = {1e6, 0, 1000, 5e-3}};
            int cells[2] = {40 << i, 4 << i}, first = held ? 0 : 6;
            double cell = 1.0 / cells[0], length = held ? 1 + cell : 1;
            modes m;
            cells[0] += held;
            sheet_triangles(&b, (const double[]){length, 0.1 * ROW}, cells, 1);
            modes_of(&b, held ? hold_first_cell : all_free, first + 4, &m);
            CHECK_EQ(m.rigid, first);
            x[i] = m.lambda[first] * 12 * 1000 / (1e6 * 25e-6 * pow(root, 4));
            modes_free(&m);
            body_free(&b);
        }
        limit l = report(held ? "held strip" : "free strip", x, held ? 1 : 2);
        CHECK_NEAR(l.order, held ? 1 : 2, 0.1);
        CHECK_NEAR(l.value, 1, l.slack + 1e-5);
    }
}

/* ---- budget -------------------------------------------------------------------------------------- */

static int write_figures(void)
{
    FILE *file = fopen(BUDGET, "w");
    if (!file)
        return 1;
    fprintf(file, "name,value\n");
    for (int i = 0; i < figures; i++)
        fprintf(file, "\"%s\",%.6g\n", figure[i].name, figure[i].value);
    return fclose(file) != 0;
}

/* They repeat to about 1e-9; six digits are kept. */
static void figures_are_those_committed(void)
{
    FILE *file = fopen(BUDGET, "r");
    char line[200], name[64];
    double value;
    int row = 0;
    CHECK(file != NULL);
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "\"%63[^\"]\",%lf", name, &value) == 2) {
            CHECK(row < figures && strcmp(name, figure[row].name) == 0);
            CHECK_NEAR(value / figure[row].value, 1, 1e-5);
            row++;
        }
    CHECK_EQ(row, figures);
    if (file)
        fclose(file);
}

int main(int argc, char **argv)
{
    TEST(a_free_bar_bends_twists_and_stretches_as_theory_says);
    TEST(a_held_bar_is_a_little_stiffer_than_theory_says);
    TEST(meshes_of_a_cube_agree_the_better_the_finer);
    TEST(a_supported_plate_tends_to_kirchhoffs);
    TEST(a_strip_bends_like_a_beam);
    if (argc > 1 && strcmp(argv[1], "--write") == 0)
        return write_figures();
    TEST(figures_are_those_committed);
    return check_done();
}
