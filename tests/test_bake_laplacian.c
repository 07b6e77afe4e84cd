/* Stiffness, masses and energies: closed forms, direct gradients, invariances, convergence.
 * Source: Jacobson 2013, 2.1, 3.4.1 (3.11), (3.12), 3.5, 4.8; errata J1-J4.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "laplacian_operators.h"

#include <float.h>
#include <lapacke.h>

/* Inner vertices moved by up to 0.3 cells: triangles get obtuse, tetrahedra thin. */
static domain rough_sheet(int cells, unsigned seed)
{
    domain d = shape_sheet(1, 1, cells, cells);
    shape_jitter(&d, (const double[]){1, 1}, 0.3 / cells, seed);
    return d;
}

static domain rough_box(int cells, unsigned seed)
{
    static const double size[3] = {1, 1, 1};
    domain d = shape_box(size, (const int[]){cells, cells, cells});
    shape_jitter(&d, size, 0.2 / cells, seed);
    return d;
}

/* ---- K --------------------------------------------------------------------------------------- */

/* Rows of K add up to 0 and linear functions are harmonic inside, up to rounding: a row has at
 * most 30 entries of some |K_ii|, each with a few roundings; those of tetrahedra lose (longest
 * edge / height)^2 to their lengths, at most 100 here. */
static void constants_and_linear_functions_are_harmonic(void)
{
    for (int dimension = 2; dimension <= 3; dimension++) {
        operators o = make(dimension == 2 ? rough_sheet(12, 1) : rough_box(5, 2), MASS_VORONOI);
        double *x = bake_alloc((size_t)o.k.n, sizeof *x), *y = bake_alloc((size_t)o.k.n, sizeof *y);
        for (int f = 0; f <= dimension; f++) {
            for (int v = 0; v < o.k.n; v++)
                x[v] = f == dimension ? 1 : o.d.at[3 * v + f];
            sparse_multiply(&o.k, x, y);
            int inner = 0;
            for (int v = 0; v < o.k.n; v++) {
                int border = shape_on_border(&o.d, v, (const double[]){1, 1, 1});
                double unit = 30 * DBL_EPSILON * o.k.value[o.k.column[v]];
                if (f == dimension)
                    CHECK_NEAR(y[v], 0, unit);
                else if (!border)
                    CHECK_NEAR(y[v], 0, (dimension == 2 ? 10 : 100) * unit);
                inner += !border;
            }
            CHECK(inner > 60);
        }
        free(x);
        free(y);
        release(&o);
    }
}

/* The only energy-free functions are the constants. */
static void stiffness_is_positive_semidefinite(void)
{
    for (int dimension = 2; dimension <= 3; dimension++) {
        operators o = make(dimension == 2 ? rough_sheet(12, 3) : rough_box(4, 4), MASS_VORONOI);
        double *a = dense(&o.k), *lambda = bake_alloc((size_t)o.k.n, sizeof *lambda);
        CHECK(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'L', o.k.n, a, o.k.n, lambda) == 0);
        double unit = o.k.n * DBL_EPSILON * lambda[o.k.n - 1];
        CHECK(lambda[0] >= -unit);
        CHECK(lambda[0] <= unit);
        CHECK(lambda[1] > 1e-3);
        free(a);
        free(lambda);
        release(&o);
    }
}

static double entry(const sparse *s, int a, int b)
{
    int row = a > b ? a : b, column = a > b ? b : a;
    for (int p = s->column[column]; p < s->column[column + 1]; p++)
        if (s->row[p] == row)
            return s->value[p];
    return 0;
}

/* Cells of a box all cut alike, around their main diagonals, where box_tets mirrors every other
 * one. */
static domain unmirrored_box(double size, int cells)
{
    domain d = shape_box((const double[]){size, size, size}, (const int[]){cells, cells, cells});
    int count[3] = {cells, cells, cells};
    static const int path[6][2] = {{0, 1}, {1, 2}, {2, 0}, {1, 0}, {2, 1}, {0, 2}};
    for (int e = 0; e < d.element_count; e++) {
        int cell = e / 6, at[3] = {cell % cells, cell / cells % cells, cell / cells / cells};
        int *corner = d.element[e], odd = e % 6 >= 3;
        corner[0] = box_vertex(count, at[0], at[1], at[2]);
        corner[3] = box_vertex(count, at[0] + 1, at[1] + 1, at[2] + 1);
        for (int s = 0; s < 2; s++) {
            at[path[e % 6][s]]++;
            corner[1 + (odd ? 1 - s : s)] = box_vertex(count, at[0], at[1], at[2]);
        }
    }
    return d;
}

/* On grids of step h: -1 and -h to the neighbours along the axes, nothing along diagonals. */
static void grids_give_the_five_and_seven_point_stencils(void)
{
    operators flat = make(shape_sheet(2, 2, 8, 8), MASS_VORONOI);
    operators solid = make(unmirrored_box(1.5, 6), MASS_VORONOI);
    operators *both[2] = {&flat, &solid};
    for (int i = 0; i < 2; i++) {
        operators *o = both[i];
        double h = 0.25, side[2] = {2, 1.5}, unit = i == 0 ? 1 : h;
        int checked = 0;
        for (int v = 0; v < o->k.n; v++) {
            if (shape_on_border(&o->d, v, (const double[]){side[i], side[i], side[i]}))
                continue;
            checked++;
            CHECK_NEAR(entry(&o->k, v, v), (i == 0 ? 4 : 6) * unit, 1e-13);
            for (int u = 0; u < o->k.n; u++) {
                double far = fabs(o->d.at[3 * v] - o->d.at[3 * u]) +
                             fabs(o->d.at[3 * v + 1] - o->d.at[3 * u + 1]) +
                             fabs(o->d.at[3 * v + 2] - o->d.at[3 * u + 2]);
                if (u != v)
                    CHECK_NEAR(entry(&o->k, v, u), far < 1.5 * h ? -unit : 0, 1e-13);
            }
        }
        CHECK_EQ(checked, i == 0 ? 49 : 125);
        release(o);
    }
}

static double determinant(double m[3][3])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* Gradients of a tetrahedron's hat functions as rows, from coordinates; returns its volume. */
static double gradients(const double at[12], double g[4][3])
{
    double m[3][3];
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++)
            m[a][i] = at[3 * (a + 1) + i] - at[i];
    double det = determinant(m);
    memset(g, 0, 12 * sizeof(double));
    for (int a = 0; a < 3; a++)
        for (int i = 0; i < 3; i++) {
            int b = (a + 1) % 3, c = (a + 2) % 3, j = (i + 1) % 3, k = (i + 2) % 3;
            g[a + 1][i] = (m[b][j] * m[c][k] - m[b][k] * m[c][j]) / det;
            g[0][i] -= g[a + 1][i];
        }
    return det / 6;
}

/* Random tetrahedra, with an edge of 1e-3, and slivers down to a height of 1e-4. Lengths are
 * rounded to eps, which moves the square of a height by about 4 eps longest^2: relative to the
 * height that is 2 eps (longest / height)^2, and K has terms (V / height^2) that all change by
 * twice that. */
static void tetrahedra_agree_with_direct_gradients(void)
{
    unsigned seed = 5;
    double worst = 0;
    for (int i = 0; i < 4000; i++) {
        double at[12], g[4][3], longest = 0, steepest = 0;
        for (int k = 0; k < 12; k++)
            at[k] = shape_random(&seed, -1, 1);
        for (int k = 0; k < 3 && i % 3 == 1; k++) /* one short edge */
            at[3 + k] = at[k] + 1e-3 * at[3 + k];
        if (i % 3 == 2) /* the last corner near to the plane of the others */
            for (int k = 0; k < 3; k++)
                at[9 + k] = at[k] + 0.3 * (at[3 + k] - at[k]) + 0.4 * (at[6 + k] - at[k]) +
                            1e-4 * at[9 + k];
        domain d = {.dimension = 3,
                    .vertex_count = 4,
                    .element_count = 1,
                    .at = at,
                    .element = (int[][4]){{0, 1, 2, 3}}};
        double length[6], mass[4], volume = fabs(gradients(at, g));
        sparse k = {0};
        bake_error error;
        laplacian_lengths(&d, length);
        for (int e = 0; e < 6; e++)
            longest = fmax(longest, length[e]);
        for (int a = 0; a < 4; a++)
            steepest = fmax(steepest, g[a][0] * g[a][0] + g[a][1] * g[a][1] + g[a][2] * g[a][2]);
        double flatness = longest * longest * steepest, size = volume * steepest;
        if (flatness > 1e10)
            continue;
        CHECK(laplacian_make(&d, length, MASS_VORONOI, &k, mass, &error) == 0);
        for (int a = 0; a < 4; a++)
            for (int b = 0; b <= a; b++) {
                double want = volume * (g[a][0] * g[b][0] + g[a][1] * g[b][1] + g[a][2] * g[b][2]);
                double off = fabs(entry(&k, a, b) - want) / (size * flatness * DBL_EPSILON);
                worst = fmax(worst, off);
            }
        CHECK_NEAR(mass[0] / (volume / 4), 1, 4 * flatness * DBL_EPSILON);
        sparse_free(&k);
    }
    printf("tetrahedra: K within %.2g eps (longest / height)^2\n", worst);
    CHECK(worst <= 4);
}

/* Sides 1, 1 and t = 1e-9: area t / 2, half cotangents 1 / 4A and t^2 / 8A, all up to 1 + t^2. */
static void needles_keep_their_digits(void)
{
    double t = 1e-9, length[6] = {1, 1, t}, mass[3];
    double at[9] = {0, 0, 0, 1, t / 2, 0, 1, -t / 2, 0};
    domain d = {.dimension = 2,
                .vertex_count = 3,
                .element_count = 1,
                .at = at,
                .element = (int[][4]){{0, 1, 2, -1}}};
    sparse k = {0};
    bake_error error;
    CHECK(laplacian_make(&d, length, MASS_VORONOI, &k, mass, &error) == 0);
    double area = t / 2;
    CHECK_NEAR(entry(&k, 1, 2) / (-(1 / (4 * area))), 1, 8 * DBL_EPSILON);
    CHECK_NEAR(entry(&k, 0, 1) / (-(t * t / (8 * area))), 1, 8 * DBL_EPSILON);
    CHECK_NEAR((mass[0] + mass[1] + mass[2]) / area, 1, 8 * DBL_EPSILON);
    sparse_free(&k);
}

/* ---- masses ---------------------------------------------------------------------------------- */

static void masses_are_positive_and_sum_to_the_whole(void)
{
    for (mass_kind kind = MASS_VORONOI; kind <= MASS_BARYCENTRIC; kind++)
        for (int dimension = 2; dimension <= 3; dimension++) {
            operators o = make(dimension == 2 ? rough_sheet(20, 6) : rough_box(6, 7), kind);
            double sum = 0;
            for (int v = 0; v < o.k.n; v++) {
                CHECK(o.mass[v] > 0);
                sum += o.mass[v];
            }
            CHECK_NEAR(sum, 1, o.k.n * 20 * DBL_EPSILON);
            release(&o);
        }
}

/* The quadrilateral of corner, middle of a side, circumcentre, middle of the other side. */
static double voronoi_part(const double *p, const double *q, const double *r)
{
    double a[2] = {q[0] - p[0], q[1] - p[1]}, b[2] = {r[0] - p[0], r[1] - p[1]};
    double cross = a[0] * b[1] - a[1] * b[0];
    double aa = a[0] * a[0] + a[1] * a[1], bb = b[0] * b[0] + b[1] * b[1];
    double c[2] = {(b[1] * aa - a[1] * bb) / (2 * cross), (a[0] * bb - b[0] * aa) / (2 * cross)};
    return fabs(a[0] / 2 * c[1] - a[1] / 2 * c[0]) / 2 +
           fabs(c[0] * b[1] / 2 - c[1] * b[0] / 2) / 2;
}

static void voronoi_masses_are_the_areas_nearer_to_a_corner(void)
{
    static const double acute[9] = {0, 0, 0, 1, 0, 0, 0.3, 0.9, 0};
    static const double obtuse[9] = {0, 0, 0, 1, 0, 0, 0.4, 0.2, 0};
    int element[1][4] = {{0, 1, 2, -1}};
    bake_error error;
    double length[6], mass[3];
    sparse k;
    domain d = {.dimension = 2,
                .vertex_count = 3,
                .element_count = 1,
                .at = (double *)acute,
                .element = element};
    laplacian_lengths(&d, length);
    CHECK(laplacian_make(&d, length, MASS_VORONOI, &k, mass, &error) == 0);
    for (int v = 0; v < 3; v++)
        CHECK_NEAR(
            mass[v],
            voronoi_part(acute + 3 * v, acute + 3 * ((v + 1) % 3), acute + 3 * ((v + 2) % 3)),
            1e-15);
    sparse_free(&k);
    for (int turn = 0; turn < 3; turn++) { /* whichever corner is the obtuse one */
        for (int a = 0; a < 3; a++)
            element[0][a] = (a + turn) % 3;
        d.at = (double *)obtuse;
        laplacian_lengths(&d, length);
        CHECK(laplacian_make(&d, length, MASS_VORONOI, &k, mass, &error) == 0);
        CHECK_NEAR(mass[0], 0.1 / 4, 1e-16);
        CHECK_NEAR(mass[1], 0.1 / 4, 1e-16);
        CHECK_NEAR(mass[2], 0.1 / 2, 1e-16);
        sparse_free(&k);
    }
}

/* ---- isometries ------------------------------------------------------------------------------ */

static void check_same(const operators *a, const operators *b)
{
    CHECK_EQ(a->k.column[a->k.n], b->k.column[b->k.n]);
    for (int p = 0; p < a->k.column[a->k.n]; p++)
        CHECK_NEAR(a->k.value[p], b->k.value[p], 1e-12);
    for (int v = 0; v < a->k.n; v++)
        CHECK_NEAR(a->mass[v] / b->mass[v], 1, 1e-12);
}

/* A strip folded along lines of edges, and one turned into six dimensions: entries are of size 1,
 * rounding of coordinates 1e-16 of a strip of 12 cells. */
static void only_lengths_matter(void)
{
    operators flat = make(shape_sheet(2, 1, 12, 6), MASS_VORONOI);
    domain folded = shape_sheet(2, 1, 12, 6), lifted = shape_sheet(2, 1, 12, 6);
    lifted.lift = bake_alloc(3 * (size_t)lifted.vertex_count, sizeof *lifted.lift);
    for (int v = 0; v < folded.vertex_count; v++) {
        double *at = folded.at + 3 * v, x = at[0];
        at[0] = x <= 1 ? x : 1 + (x - 1) * cos(1.1);
        at[2] = x <= 1 ? 0 : (x - 1) * sin(1.1);
        double y = at[1];
        for (int i = 0; i < 3; i++) { /* orthonormal columns of six rows each */
            lifted.at[3 * v + i] = (x + y) / sqrt(6);
            lifted.lift[3 * v + i] = (x - y) / sqrt(6);
        }
    }
    operators f = make(folded, MASS_VORONOI), l = make(lifted, MASS_VORONOI);
    check_same(&flat, &f);
    check_same(&flat, &l);
    release(&flat);
    release(&f);
    release(&l);
}

/* ---- energies -------------------------------------------------------------------------------- */

/* out = a diag(1 / mass) b */
static double *product(const double *a, const double *mass, const double *b, int n)
{
    double *out = bake_alloc((size_t)n * (size_t)n, sizeof *out);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            for (int j = 0; j < n; j++)
                out[i * n + j] += a[i * n + k] / mass[k] * b[k * n + j];
    return out;
}

static void energies_are_products_of_stiffness_and_inverse_mass(void)
{
    operators o = make(rough_sheet(9, 8), MASS_VORONOI);
    int n = o.k.n;
    double *one = dense(&o.k), *two = product(one, o.mass, one, n);
    double *three = product(two, o.mass, one, n), *want[3] = {one, two, three};
    for (int order = 1; order <= 3; order++) {
        sparse q;
        bake_error error;
        CHECK(laplacian_energy(&o.k, o.mass, order, &q, &error) == 0);
        double *got = dense(&q), most = 0;
        for (int i = 0; i < n * n; i++)
            most = fmax(most, fabs(want[order - 1][i]));
        for (int i = 0; i < n * n; i++)
            CHECK_NEAR(got[i], want[order - 1][i], 1e-14 * most);
        for (int j = 0; j < n; j++) {
            CHECK_EQ(q.row[q.column[j]], j);
            for (int p = q.column[j] + 1; p < q.column[j + 1]; p++)
                CHECK(q.row[p] > q.row[p - 1]);
        }
        free(got);
        sparse_free(&q);
    }
    free(one);
    free(two);
    free(three);
    release(&o);
}

/* w^T B w is the sum over triangles of mean rho area |grad w|^2; area once [erratum J4]. */
static void the_brush_weighs_gradients(void)
{
    for (int order = 1; order <= 2; order++) {
        operators o = make(rough_sheet(10, 9), MASS_VORONOI);
        int n = o.k.n;
        unsigned seed = 10;
        double want = 0, *rho = bake_alloc((size_t)n, sizeof *rho);
        double *w = bake_alloc((size_t)n, sizeof *w), *y = bake_alloc((size_t)n, sizeof *y);
        double *z = bake_alloc((size_t)n, sizeof *z), got = 0;
        sparse q, plain;
        bake_error error;
        for (int v = 0; v < n; v++) {
            rho[v] = o.d.at[3 * v] > 0.5 ? shape_random(&seed, 0, 3) : 0;
            w[v] = shape_random(&seed, 0, 1);
        }
        CHECK(laplacian_energy(&o.k, o.mass, order, &q, &error) == 0);
        CHECK(laplacian_energy(&o.k, o.mass, order, &plain, &error) == 0);
        CHECK(laplacian_brush(&o.d, o.length, rho, &q, &error) == 0);
        CHECK_EQ(q.column[n], plain.column[n]);
        sparse_multiply(&q, w, y);
        sparse_multiply(&plain, w, z);
        for (int v = 0; v < n; v++)
            got += w[v] * (y[v] - z[v]);
        for (int e = 0; e < o.d.element_count; e++) {
            const int *c = o.d.element[e];
            double mean = (rho[c[0]] + rho[c[1]] + rho[c[2]]) / 3, dx = 0, dy = 0;
            double *p[3] = {o.d.at + 3 * c[0], o.d.at + 3 * c[1], o.d.at + 3 * c[2]};
            double twice = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) -
                           (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
            for (int a = 0; a < 3; a++) {
                dx += w[c[a]] * (p[(a + 1) % 3][1] - p[(a + 2) % 3][1]) / twice;
                dy += w[c[a]] * (p[(a + 2) % 3][0] - p[(a + 1) % 3][0]) / twice;
            }
            want += mean * twice / 2 * (dx * dx + dy * dy);
        }
        CHECK_NEAR(got, want, 1e-9 * want); /* the energy itself is up to 1e4 times larger */
        free(rho);
        free(w);
        free(y);
        free(z);
        sparse_free(&q);
        sparse_free(&plain);
        release(&o);
    }
}

/* ---- what is refused ------------------------------------------------------------------------- */

static void check_refused(domain *d, const char *expect)
{
    double length[12] = {0}, mass[5];
    sparse k;
    bake_error error = {""};
    laplacian_lengths(d, length);
    CHECK(laplacian_make(d, length, MASS_VORONOI, &k, mass, &error) < 0);
    CHECK(strstr(error.text, expect) != NULL);
}

static void what_has_no_area_is_refused_with_its_place(void)
{
    double line[9] = {0, 0, 0, 0.1, 0.1, 0, 0.7, 0.7, 0};
    double plane[12] = {0, 0, 0.3, 1, 0, 0.3, 0, 1, 0.3, 0.3, 0.3, 0.3};
    double alone[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 6, 7};
    domain flat = {.dimension = 2,
                   .vertex_count = 3,
                   .element_count = 1,
                   .at = line,
                   .element = (int[][4]){{0, 1, 2, -1}}};
    domain solid = {.dimension = 3,
                    .vertex_count = 4,
                    .element_count = 1,
                    .at = plane,
                    .element = (int[][4]){{0, 1, 2, 3}}};
    domain bare = {.dimension = 2,
                   .vertex_count = 4,
                   .element_count = 1,
                   .at = alone,
                   .element = (int[][4]){{0, 1, 2, -1}}};
    check_refused(&flat, "triangle 0 near (0.266667, 0.266667, 0) has no area");
    check_refused(&solid, "tetrahedron 0 near (0.325, 0.325, 0.3) has no volume");
    check_refused(&bare, "vertex 3 at (5, 6, 7) is in no element");
}

static void senseless_arguments_are_refused(void)
{
    operators o = make(shape_sheet(1, 1, 2, 2), MASS_VORONOI);
    bake_error error;
    sparse q;
    double rho[9] = {0, 0, 0, -1};
    CHECK(laplacian_energy(&o.k, o.mass, 0, &q, &error) < 0);
    CHECK(laplacian_energy(&o.k, o.mass, 4, &q, &error) < 0);
    CHECK(laplacian_brush(&o.d, o.length, rho, &o.k, &error) < 0);
    CHECK(strstr(error.text, "the brush at vertex 3 is -1") != NULL);
    release(&o);
}

int main(void)
{
    TEST(constants_and_linear_functions_are_harmonic);
    TEST(stiffness_is_positive_semidefinite);
    TEST(grids_give_the_five_and_seven_point_stencils);
    TEST(tetrahedra_agree_with_direct_gradients);
    TEST(needles_keep_their_digits);
    TEST(masses_are_positive_and_sum_to_the_whole);
    TEST(voronoi_masses_are_the_areas_nearer_to_a_corner);
    TEST(only_lengths_matter);
    TEST(energies_are_products_of_stiffness_and_inverse_mass);
    TEST(the_brush_weighs_gradients);
    TEST(what_has_no_area_is_refused_with_its_place);
    TEST(senseless_arguments_are_refused);
    return check_done();
}
