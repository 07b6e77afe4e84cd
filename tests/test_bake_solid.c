/* Elastic solids: against a 60-digit oracle, closed forms, and what they must do by theory.
 * Source: Schulz 2013, 2.3.3, erratum S5; vectors from tests/reference/solid_oracle.py.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_shapes.h"
#include "check.h"

#include <lapacke.h>
#include <string.h>

/* ---- helpers --------------------------------------------------------------------------------- */

static unsigned random_state = 1;

static double uniform(double lo, double hi)
{
    random_state = random_state * 1664525u + 1013904223u;
    return lo + (hi - lo) * (random_state >> 8) / 16777216.0;
}

static double *copy(const double *values, int count)
{
    double *out = bake_alloc((size_t)count, sizeof *out);
    return memcpy(out, values, (size_t)count * sizeof *out);
}

static double largest(const double *v, int count)
{
    double most = 0;
    for (int i = 0; i < count; i++)
        most = fmax(most, fabs(v[i]));
    return most;
}

/* 0.9 x 0.6 x 0.5 m of something like rubber; every vertex moved by up to `jitter` m. */
static body box(int cells, double jitter)
{
    body b = {0};
    bake_error error;
    box_tets(&b, (double[]){0.9, 0.6, 0.5}, (int[]){cells, cells, cells});
    for (int i = 0; i < 3 * b.vertex_count; i++)
        b.rest[i] += uniform(-jitter, jitter);
    b.material = (body_material){.young = 2e6, .poisson = 0.4, .density = 1100};
    CHECK(body_prepare(&b, &error) == 0);
    return b;
}

/* Moved by up to 0.08 m a coordinate: strains of the order of 1, some tetrahedra turned over. */
static double *crumpled(const body *b)
{
    double *x = copy(b->rest, 3 * b->vertex_count);
    for (int i = 0; i < 3 * b->vertex_count; i++)
        x[i] += uniform(-0.08, 0.08);
    return x;
}

/* x = A rest + t */
static double *mapped(const body *b, const double A[9], const double t[3])
{
    double *x = bake_alloc(3 * (size_t)b->vertex_count, sizeof *x);
    for (int v = 0; v < b->vertex_count; v++)
        for (int i = 0; i < 3; i++)
            x[3 * v + i] = t[i] + A[3 * i] * b->rest[3 * v] + A[3 * i + 1] * b->rest[3 * v + 1] +
                           A[3 * i + 2] * b->rest[3 * v + 2];
    return x;
}

/* 1.1 rad about (1, 2, 3) / sqrt(14), by Rodrigues' formula. */
static void rotation(double R[9])
{
    double a[3], s = sin(1.1), c = cos(1.1);
    for (int i = 0; i < 3; i++)
        a[i] = (i + 1) / sqrt(14);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            R[3 * i + j] = (1 - c) * a[i] * a[j] + (i == j ? c : 0);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        R[3 * j + i] += s * a[k];
        R[3 * i + j] -= s * a[k];
    }
}

/* K u, from the blocks alone. */
static void multiply(const body_blocks *blocks, int n, const double *u, double *out)
{
    memset(out, 0, 3 * (size_t)n * sizeof *out);
    for (size_t m = 0; m < blocks->count; m++) {
        const body_block *k = &blocks->at[m];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                out[3 * k->a + i] += k->k[3 * i + j] * u[3 * k->b + j];
                if (k->a != k->b)
                    out[3 * k->b + j] += k->k[3 * i + j] * u[3 * k->a + i];
            }
    }
}

/* Dense and symmetric; both triangles of the blocks of one vertex are looked at. */
static double *dense(const body_blocks *blocks, int n)
{
    size_t size = 3 * (size_t)n;
    double *K = bake_alloc(size * size, sizeof *K);
    for (size_t m = 0; m < blocks->count; m++) {
        const body_block *k = &blocks->at[m];
        CHECK(k->a >= k->b);
        for (size_t i = 0; i < 3; i++)
            for (size_t j = 0; j < 3; j++) {
                size_t row = 3 * (size_t)k->a + i, column = 3 * (size_t)k->b + j;
                K[row * size + column] += k->k[3 * i + j];
                if (k->a != k->b)
                    K[column * size + row] += k->k[3 * i + j];
            }
    }
    return K;
}

/* ---- the oracle ------------------------------------------------------------------------------ */

/* "key,value,value..." into out; how many. */
static int read_values(char *line, const char *key, double *out, int room)
{
    int count = 0;
    char *word = strtok(line, ",");
    if (!word || strcmp(word, key) != 0)
        return 0;
    while (count < room && (word = strtok(NULL, ",")))
        out[count++] = atof(word);
    return count;
}

static int read_line(FILE *file, const char *key, double *out, int count)
{
    static char line[16384];
    int got = fgets(line, sizeof line, file) ? read_values(line, key, out, count) : 0;
    CHECK_EQ(got, count);
    return got == count;
}

#define VERTICES 8
#define SIZE     (3 * VERTICES)

/* A dozen roundings an entry, times what the edge matrices' condition and lambda/mu make of them
 * (100 and 4 for the flat one, 2.5 and 99 where the volume hardly changes): 12 * 1.1e-16 * 400 of
 * the largest. */
#define ORACLE 6e-13

static void check_against(const body *b, const double *x, FILE *file)
{
    int n = b->vertex_count, entries = 3 * n * (3 * n + 1) / 2;
    double want[SIZE * (SIZE + 1) / 2], got[SIZE];
    body_blocks blocks = {0};
    if (read_line(file, "mass", want, n))
        for (int i = 0; i < n; i++)
            CHECK_NEAR(b->mass[i], want[i], 1e-14 * want[i]);
    if (read_line(file, "energy", want, 1))
        CHECK_NEAR(body_energy(b, x), want[0], ORACLE * want[0]);
    body_gradient(b, x, got);
    if (read_line(file, "gradient", want, 3 * n))
        for (int i = 0; i < 3 * n; i++)
            CHECK_NEAR(got[i], want[i], ORACLE * largest(want, 3 * n) + 1e-30);
    body_hessian(b, x, &blocks);
    double *K = dense(&blocks, n);
    if (read_line(file, "hessian", want, entries))
        for (int i = 0, k = 0; i < 3 * n; i++)
            for (int j = 0; j <= i; j++, k++) {
                CHECK_NEAR(K[i * 3 * n + j], want[k], ORACLE * largest(want, entries));
                CHECK_NEAR(K[j * 3 * n + i], want[k], ORACLE * largest(want, entries));
            }
    free(K);
    body_blocks_free(&blocks);
}

static void check_case(FILE *file, int vertices, int tets)
{
    double material[3], corner[4 * 5], rest[SIZE], x[SIZE];
    bake_error error;
    body b = {.vertex_count = vertices, .element_count = tets};
    if (!read_line(file, "material", material, 3) || !read_line(file, "tets", corner, 4 * tets) ||
        !read_line(file, "rest", rest, 3 * vertices) || !read_line(file, "x", x, 3 * vertices))
        return;
    b.material = (body_material){material[0], material[1], material[2], 0};
    b.rest = copy(rest, 3 * vertices);
    b.element = bake_alloc((size_t)tets, sizeof *b.element);
    for (int i = 0; i < 4 * tets; i++)
        b.element[i / 4][i % 4] = (int)corner[i];
    CHECK(body_prepare(&b, &error) == 0);
    check_against(&b, x, file);
    body_free(&b);
}

static void oracle_agrees(void)
{
    char line[1024];
    int cases = 0, vertices, tets;
    FILE *file = fopen("tests/vectors/solid_oracle.csv", "r");
    CHECK(file != NULL);
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "case,%*[^,],%d,%d", &vertices, &tets) == 2 && vertices <= VERTICES &&
            tets <= 5) {
            check_case(file, vertices, tets);
            cases++;
        }
    CHECK_EQ(cases, 5);
    if (file)
        fclose(file);
}

/* ---- derivatives ----------------------------------------------------------------------------- */

/* The energy is a polynomial of degree 4 along every line, so this formula has no error but
 * rounding: (1 + 8 + 8 + 1) / 12 = 1.5 times that of a value, over the step. */
static double difference(const double f[4], double step)
{
    return (f[0] - 8 * f[1] + 8 * f[2] - f[3]) / (12 * step);
}

static const double stencil[4] = {-2, -1, 1, 2};

static void derivatives_are_those_of_the_energy(void)
{
    for (int trial = 0; trial < 5; trial++) {
        body b = box(4, 0.02);
        int n = 3 * b.vertex_count;
        double *x = crumpled(&b), *along = crumpled(&b), *at = copy(x, n), step = 0.1;
        double *gradient[4], *g = copy(x, n), *Ku = copy(x, n), V[4], slope = 0, terms = 0;
        body_blocks K = {0};
        for (int i = 0; i < n; i++)
            along[i] -= b.rest[i];
        body_gradient(&b, x, g);
        body_hessian(&b, x, &K);
        multiply(&K, b.vertex_count, along, Ku);
        for (int k = 0; k < 4; k++) {
            for (int i = 0; i < n; i++)
                at[i] = x[i] + stencil[k] * step * along[i];
            V[k] = body_energy(&b, at);
            body_gradient(&b, at, gradient[k] = bake_alloc((size_t)n, sizeof(double)));
        }
        for (int i = 0; i < n; i++) {
            double f[4] = {gradient[0][i], gradient[1][i], gradient[2][i], gradient[3][i]};
            /* 24 tetrahedra about a vertex, a dozen roundings of strains of order 1 each: 1e-13 */
            CHECK_NEAR(difference(f, step), Ku[i],
                       1e-13 / step * largest(f, 4) + 1e-13 / step * largest(Ku, n));
            slope += g[i] * along[i];
            terms += fabs(g[i] * along[i]);
        }
        /* 384 tetrahedra are summed: 384 * 1.1e-16 at most */
        CHECK_NEAR(difference(V, step), slope, 1e-13 * (V[0] / step + terms));
        for (int k = 0; k < 4; k++)
            free(gradient[k]);
        free(x), free(along), free(at), free(g), free(Ku);
        body_blocks_free(&K);
        body_free(&b);
    }
}

/* ---- closed forms ---------------------------------------------------------------------------- */

/* Uniaxial stress: E = diag(e, -nu e, -nu e) has W = young e^2 / 2 exactly, which erratum S5 (2 mu
 * instead of mu, E without 1/2) would not give. */
static void stretch_has_the_energy_of_youngs_modulus(void)
{
    body b = box(3, 0);
    double nu = b.material.poisson, volume = 0.9 * 0.6 * 0.5, zero[3] = {0};
    for (double e = -0.3; e < 1; e += 0.2) {
        double across = sqrt(1 - 2 * nu * e);
        double *x =
            mapped(&b, (double[9]){sqrt(1 + 2 * e), 0, 0, 0, across, 0, 0, 0, across}, zero);
        double want = 0.5 * b.material.young * e * e * volume;
        /* strains of 1e-1 from displacements of 1e0 with 1e-16: 1e-14; squared, twice */
        CHECK_NEAR(body_energy(&b, x), want, 1e-12 * want);
        free(x);
    }
    body_free(&b);
}

/* F = 1 + s e_x e_y^T: E has s/2 beside the diagonal and s^2/2 once on it. */
static void shear_has_its_closed_form(void)
{
    body b = box(3, 0.02);
    double nu = b.material.poisson, mu = b.material.young / (2 * (1 + nu));
    double lambda = 2 * mu * nu / (1 - 2 * nu), mass = 0, t[3] = {0.3, -0.2, 7};
    for (int v = 0; v < b.vertex_count; v++)
        mass += b.mass[v];
    for (double s = -2; s <= 2; s += 0.5) {
        double *x = mapped(&b, (double[9]){1, s, 0, 0, 1, 0, 0, 0, 1}, t), q = s * s / 2;
        double want = (lambda / 2 * q * q + mu * (q + q * q)) * mass / b.material.density;
        /* at 7 m coordinates have 9e-16 m, edges 0.1 m: 1e-14 of strains, squared where s = 0 */
        CHECK_NEAR(body_energy(&b, x), want, 1e-12 * want + 1e-28 * 1e7);
        free(x);
    }
    body_free(&b);
}

/* Coordinates are multiples of 1/8, so that 2^-30 of them is exact: then the energy of a strain of
 * 1e-9 has all its digits. From F^T F - 1 it would have seven: (1e-16 / 1e-9). */
static void small_strains_keep_their_digits(void)
{
    body b = {.material = {.young = 2e6, .poisson = 0.25, .density = 1}};
    bake_error error;
    box_tets(&b, (double[]){1, 1, 0.5}, (int[]){2, 2, 1});
    CHECK(body_prepare(&b, &error) == 0);
    double e = ldexp(1, -30), strain = e + e * e / 2, lambda = 0.8e6, mu = 0.8e6;
    double *x = mapped(&b, (double[9]){1 + e, 0, 0, 0, 1, 0, 0, 0, 1}, (double[3]){0});
    double want = 0.5 * (lambda / 2 + mu) * strain * strain;
    CHECK_NEAR(body_energy(&b, x), want, 1e-14 * want);
    CHECK(body_energy(&b, b.rest) == 0);
    free(x);
    body_free(&b);
}

/* ---- rigid motions --------------------------------------------------------------------------- */

static void turning_costs_nothing(void)
{
    double R[9], t[3] = {0.4, -0.1, 0.2}, zero[3] = {0};
    body b = box(4, 0.02);
    rotation(R);
    double *x = crumpled(&b), *rest = b.rest, V = body_energy(&b, x);
    double *turned = mapped(&b, R, t);
    /* strains of 1e-14 (1e-16 m of 0.1 m, a dozen roundings), squared, of a stiffness of 1e7 Pa */
    CHECK_NEAR(body_energy(&b, turned), 0, 1e-28 * 1e7);
    free(turned);
    b.rest = x;
    turned = mapped(&b, R, zero);
    b.rest = rest;
    CHECK(V > 1e3);
    CHECK_NEAR(body_energy(&b, turned), V, 1e-13 * V);
    free(x), free(turned);
    body_free(&b);
}

/* The six directions of rigid motion about the rest pose: a unit translation, or e_i x r. */
static void rigid(const body *b, int which, double *u)
{
    int i = which % 3, j = (i + 1) % 3, k = (i + 2) % 3;
    memset(u, 0, 3 * (size_t)b->vertex_count * sizeof *u);
    for (int v = 0; v < b->vertex_count; v++) {
        if (which < 3) {
            u[3 * v + i] = 1;
        } else {
            u[3 * v + j] = -b->rest[3 * v + k];
            u[3 * v + k] = b->rest[3 * v + j];
        }
    }
}

static void kernel_at_rest_is_the_six_rigid_motions(void)
{
    body b = box(3, 0.02);
    int n = b.vertex_count;
    double *u = bake_alloc(3 * (size_t)n, sizeof *u), *Ku = bake_alloc(3 * (size_t)n, sizeof *Ku);
    double *lambda = bake_alloc(3 * (size_t)n, sizeof *lambda), norm;
    body_blocks K = {0};
    body_hessian(&b, b.rest, &K);
    double *A = dense(&K, n);
    CHECK(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'L', 3 * n, A, 3 * n, lambda) == 0);
    norm = lambda[3 * n - 1];
    for (int i = 0; i < 6; i++) {
        rigid(&b, i, u);
        multiply(&K, n, u, Ku);
        CHECK(largest(Ku, 3 * n) <= 1e-12 * norm * largest(u, 3 * n));
        CHECK_NEAR(lambda[i], 0, 1e-12 * norm);
    }
    /* no seventh: bending has 3e-3 of the stiffest in so short a box, and rounding 1e-15 */
    CHECK(lambda[6] > 1e-4 * norm);
    free(u), free(Ku), free(lambda), free(A);
    body_blocks_free(&K);
    body_free(&b);
}

/* ---- what body_prepare makes and refuses ----------------------------------------------------- */

static void masses_sum_to_density_times_volume(void)
{
    for (int cells = 1; cells <= 5; cells++) {
        body b = box(cells, 0);
        double mass = 0, want = 1100 * 0.9 * 0.6 * 0.5;
        for (int v = 0; v < b.vertex_count; v++) {
            CHECK(b.mass[v] > 0);
            mass += b.mass[v];
        }
        CHECK_NEAR(mass, want, 1e-13 * want);
        /* the first corner has all six tetrahedra of its cell: a quarter of it */
        CHECK_NEAR(b.mass[0], want / (4 * cells * cells * cells), 1e-13 * want);
        body_free(&b);
    }
}

/* ---- blocks ---------------------------------------------------------------------------------- */

static void blocks_are_turned_into_the_lower_triangle(void)
{
    body_blocks list = {0};
    double k[9], K[81];
    for (int i = 0; i < 9; i++)
        k[i] = i;
    for (int i = 0; i < 1000; i++) {
        body_blocks_add(&list, 0, 2, k);
        body_blocks_add(&list, 2, 0, k);
        body_blocks_add(&list, 1, 1, k);
    }
    CHECK_EQ(list.count, 3000);
    double *got = dense(&list, 3);
    memset(K, 0, sizeof K);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            K[9 * i + 6 + j] = K[9 * (6 + j) + i] = 1000 * (k[3 * i + j] + k[3 * j + i]);
            K[9 * (3 + i) + 3 + j] = 1000 * k[3 * i + j];
        }
    for (int i = 0; i < 81; i++)
        CHECK(got[i] == K[i]);
    free(got);
    body_blocks_free(&list);
    CHECK(list.at == NULL && list.count == 0);
}

static int compare_blocks(const body_block *a, const body_block *b)
{
    return a->b != b->b ? a->b - b->b : a->a - b->a;
}

static void a_hessian_has_one_block_a_vertex_and_an_edge(void)
{
    body b = {.material = {.young = 2e6, .poisson = 0.4, .density = 1100}};
    bake_error error;
    body_blocks K = {0};
    box_tets(&b, (double[]){1, 1, 2}, (int[]){5, 5, 8});
    CHECK(body_prepare(&b, &error) == 0);
    body_hessian(&b, b.rest, &K);
    /* one block a vertex and an edge, ordered; Euler: n - edges + faces - tets = 1 for a ball, and
     * 4 tets = 2 faces - those outside, 2 * 2 (5 * 5 + 2 * 5 * 8) */
    int outside = 4 * (5 * 5 + 2 * 5 * 8), faces = (4 * b.element_count + outside) / 2;
    CHECK_EQ(K.count, 2 * b.vertex_count + faces - b.element_count - 1);
    for (size_t i = 1; i < K.count; i++)
        CHECK(compare_blocks(&K.at[i - 1], &K.at[i]) < 0);
    body_blocks_free(&K);
    body_free(&b);
}

int main(void)
{
    TEST(oracle_agrees);
    TEST(derivatives_are_those_of_the_energy);
    TEST(stretch_has_the_energy_of_youngs_modulus);
    TEST(shear_has_its_closed_form);
    TEST(small_strains_keep_their_digits);
    TEST(turning_costs_nothing);
    TEST(kernel_at_rest_is_the_six_rigid_motions);
    TEST(masses_sum_to_density_times_volume);
    TEST(blocks_are_turned_into_the_lower_triangle);
    TEST(a_hessian_has_one_block_a_vertex_and_an_edge);
    return check_done();
}
