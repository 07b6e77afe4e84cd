/* The solver of vibration modes against spectra with closed forms; of bodies: test_bake_beams.c.
 * SPDX-License-Identifier: MIT */
#include "modes_check.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* ---- matrices -------------------------------------------------------------------------------- */

/* A lattice of count[0] x count[1] x count[2] unit masses with unit springs between neighbours;
 * `wall`: springs to walls at both ends of each axis. Minus `less` times 1. */
static sparse lattice(const int count[3], const int wall[3], double less)
{
    int n = count[0] * count[1] * count[2], step[3] = {1, count[0], count[0] * count[1]};
    sparse s = {.n = n};
    s.column = bake_alloc((size_t)n + 1, sizeof *s.column);
    s.row = bake_alloc(4 * (size_t)n, sizeof *s.row);
    s.value = bake_alloc(4 * (size_t)n, sizeof *s.value);
    for (int j = 0, p = 0; j < n; j++) {
        int diagonal = p;
        s.row[p] = j;
        s.value[p++] = -less;
        for (int k = 0; k < 3; k++) {
            int at = j / step[k] % count[k], ends = (at == 0) + (at == count[k] - 1);
            s.value[diagonal] += 2 - (wall[k] ? 0 : ends);
            if (at < count[k] - 1) {
                s.row[p] = j + step[k];
                s.value[p++] = -1;
            }
        }
        s.column[j + 1] = p;
    }
    return s;
}

/* The lowest of its spectrum, ascending: sums of 2 - 2 cos over the axes. Walls at both ends:
 * angles pi i / (count + 1), i >= 1; none: pi i / count, i >= 0. */
static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double *lattice_spectrum(const int count[3], const int wall[3], double less)
{
    int n = count[0] * count[1] * count[2], step[3] = {1, count[0], count[0] * count[1]};
    double *lambda = bake_alloc((size_t)n, sizeof *lambda);
    for (int j = 0; j < n; j++) {
        lambda[j] = -less;
        for (int k = 0; k < 3; k++) {
            int i = j / step[k] % count[k];
            double half = wall[k] ? PI * (i + 1) / (count[k] + 1) / 2 : PI * i / count[k] / 2;
            lambda[j] += 4 * sin(half) * sin(half);
        }
    }
    qsort(lambda, (size_t)n, sizeof *lambda, ascending);
    return lambda;
}

static double *ones(int n)
{
    double *M = bake_alloc((size_t)n, sizeof *M);
    for (int i = 0; i < n; i++) {
        M[i] = 1;
    }
    return M;
}

/* D K D and D^2 have the spectrum of K and 1: masses from 1 to 1e6. */
static void rescale(sparse *K, double *M)
{
    for (int i = 0; i < K->n; i++) {
        M[i] = pow(10, 6.0 * (i * 37 % 101) / 100);
    }
    for (int j = 0; j < K->n; j++) {
        for (int p = K->column[j]; p < K->column[j + 1]; p++) {
            K->value[p] *= sqrt(M[j] * M[K->row[p]]);
        }
    }
}

/* Against a spectrum; the error of an eigenvalue is at most what rounding makes of the matrix, a
 * few eps of the largest eigenvalue (12 for a lattice), and Lanczos is done when it no longer
 * counts. */
static void check_lattice(const int count[3], const int wall[3], double less, int wanted)
{
    bake_error error = {""};
    sparse K = lattice(count, wall, less);
    double *M = ones(K.n), *want = lattice_spectrum(count, wall, less);
    modes m;
    int negative = 0, rigid = 0;
    for (int pass = 0; pass < 2; pass++) {
        CHECK_EQ(modes_solve(&K, M, wanted, &m, &error), 0);
        check_modes(&m, M);
        for (int i = negative = rigid = 0; i < m.count; i++) {
            CHECK_NEAR(m.lambda[i], want[i], 64 * DBL_EPSILON * 12);
            CHECK(m.residual[i] <= 1e-8);
            negative += want[i] < -1e-12;
            rigid += fabs(want[i]) < 1e-12;
        }
        CHECK_EQ(m.count, wanted);
        CHECK_EQ(m.negative, negative);
        CHECK_EQ(m.rigid, rigid);
        modes_free(&m);
        rescale(&K, M);
    }
    sparse_free(&K);
    free(M);
    free(want);
}

/* ---- closed forms ---------------------------------------------------------------------------- */

static void a_string_has_the_modes_of_a_string(void)
{
    check_lattice((const int[]){1000, 1, 1}, (const int[]){1, 0, 0}, 0, 20);
    check_lattice((const int[]){150, 1, 1}, (const int[]){1, 0, 0}, 0, 149); /* LAPACK */
}

/* Triples, sextuples, and a last one cut through. */
static void a_cube_of_springs_has_all_copies_of_multiple_modes(void)
{
    check_lattice((const int[]){12, 12, 12}, (const int[]){1, 1, 1}, 0, 30);
    check_lattice((const int[]){12, 12, 12}, (const int[]){1, 1, 1}, 0, 100);
}

static void what_is_not_held_has_a_mode_at_zero(void)
{
    check_lattice((const int[]){20, 11, 9}, (const int[]){0, 0, 0}, 0, 25);
    check_lattice((const int[]){700, 1, 1}, (const int[]){0, 0, 0}, 0, 12);
}

static void modes_of_indefinite_systems_begin_with_the_lowest(void)
{
    check_lattice((const int[]){20, 11, 9}, (const int[]){0, 0, 0}, 0.7, 40);
    check_lattice((const int[]){12, 12, 12}, (const int[]){1, 1, 1}, 11.0, 20);
}

/* Finite elements of a bar held at both ends, with the full mass matrix: lambda = 6/h^2 (1 - c)/(2
 * + c), c = cos(pi i / elements). The largest is 12/h^2 and M's condition 3: errors of some eps of
 * it. */
static void dense_masses_are_taken_into_account(void)
{
    enum { N = 24 };
    double K[N * N] = {0}, M[N * N] = {0}, h = 1.0 / (N + 1);
    bake_error error = {""};
    modes m;
    for (int i = 0; i < N; i++) {
        K[N * i + i] = 2 / h;
        M[N * i + i] = 4 * h / 6;
        for (int j = i - 1; j <= i + 1; j += 2) {
            if (j >= 0 && j < N) {
                K[N * i + j] = -1 / h;
                M[N * i + j] = h / 6;
            }
        }
    }
    CHECK_EQ(modes_dense(K, M, N, &m, &error), 0);
    CHECK_EQ(m.count, N);
    for (int i = 0; i < N; i++) {
        double c = cos(PI * (i + 1) / (N + 1));
        CHECK_NEAR(m.lambda[i], 6 / (h * h) * (1 - c) / (2 + c), 64 * DBL_EPSILON * 12 / (h * h));
        CHECK(m.residual[i] <= 1e-10);
        for (int j = 0; j <= i; j++) { /* Phi^T M Phi */
            double sum = i == j ? -1 : 0;
            for (int p = 0; p < N * N; p++) {
                sum += m.phi[N * i + p / N] * M[p] * m.phi[N * j + p % N];
            }
            CHECK_NEAR(sum, 0, 1e-12);
        }
    }
    modes_free(&m);
    M[0] = -1;
    CHECK_EQ(modes_dense(K, M, N, &m, &error), -1);
    CHECK(strstr(error.text, "mass matrix is not positive definite"));
}

/* ---- rounding -------------------------------------------------------------------------------- */

/* A string of springs of strength 1 that hangs on one of strength s: its softest mode is s / n as
 * long as s is small, 1e-12 of the largest. That is above rounding (64 eps) and no rigid mode,
 * though nothing can find more than 4 digits of it. The mode's residual is above 1e-8 for the same
 * reason. */
static void a_soft_mode_is_not_taken_for_a_rigid_one(void)
{
    int n = 500;
    double soft = 2e-9;
    bake_error error = {""};
    sparse K = lattice((const int[]){n, 1, 1}, (const int[]){0, 0, 0}, 0);
    double *M = ones(n);
    modes m;
    K.value[0] += soft;
    CHECK_EQ(modes_solve(&K, M, 10, &m, &error), 0);
    CHECK_EQ(m.rigid, 0);
    CHECK_NEAR(m.lambda[0] / (soft / n), 1, 4e-4);
    CHECK(m.noise < m.lambda[0]);
    modes_free(&m);
    K.value[0] -= soft;
    CHECK_EQ(modes_solve(&K, M, 10, &m, &error), 0);
    CHECK_EQ(m.rigid, 1);
    CHECK(m.lambda[0] == 0);
    CHECK(m.noise > 0 && m.noise < 1e-3 * m.lambda[1]);
    modes_free(&m);
    sparse_free(&K);
    free(M);
}

static void the_same_matrix_has_the_same_modes(void)
{
    bake_error error = {""};
    sparse K = lattice((const int[]){20, 11, 9}, (const int[]){0, 0, 0}, 0.3);
    double *M = ones(K.n);
    modes a, b;
    CHECK_EQ(modes_solve(&K, M, 30, &a, &error), 0);
    CHECK_EQ(modes_solve(&K, M, 30, &b, &error), 0);
    CHECK(memcmp(a.phi, b.phi, 30 * (size_t)K.n * sizeof *a.phi) == 0);
    CHECK(memcmp(a.lambda, b.lambda, 30 * sizeof *a.lambda) == 0);
    modes_free(&a);
    modes_free(&b);
    sparse_free(&K);
    free(M);
}

static void impossible_requests_are_refused_with_a_reason(void)
{
    bake_error error = {""};
    sparse K = lattice((const int[]){300, 1, 1}, (const int[]){1, 0, 0}, 0);
    double *M = ones(300);
    modes m;
    CHECK_EQ(modes_solve(&K, M, 300, &m, &error), -1);
    CHECK(strstr(error.text, "300 modes of a body with 300 coordinates: at most 299"));
    CHECK_EQ(modes_solve(&K, M, 0, &m, &error), -1);
    M[7] = 0;
    CHECK_EQ(modes_solve(&K, M, 10, &m, &error), -1);
    CHECK(strstr(error.text, "coordinate 7 has a mass of 0 kg"));
    M[7] = 1;
    K.value[5] = NAN;
    CHECK_EQ(modes_solve(&K, M, 10, &m, &error), -1);
    CHECK(m.phi == NULL);
    sparse_free(&K);
    free(M);
}

/* A system of 3 x 3 blocks by hand: vertex 0 slides along (0.6, 0.8, 0), vertex 1 is free. */
static void blocks_add_up_in_the_directions_that_are_left(void)
{
    double k[9] = {4, 1, 0, 1, 5, 2, 0, 2, 6}, half[9], minus[9], x[4] = {1, 2, 3, 4}, y[4];
    body_blocks blocks = {0};
    bake_error error = {""};
    freedom f;
    sparse s;
    freedom_make(2, &f);
    freedom_slide(&f, 0, (const double[]){0.8, -0.6, 0});
    freedom_slide(&f, 0, (const double[]){0, 0, 1});
    freedom_finish(&f);
    for (int i = 0; i < 9; i++) {
        half[i] = k[i] / 2;
        minus[i] = -k[i];
    }
    body_blocks_add(&blocks, 0, 0, half); /* a spring with matrix k between the two */
    body_blocks_add(&blocks, 0, 1, minus);
    body_blocks_add(&blocks, 1, 1, k);
    body_blocks_add(&blocks, 0, 0, half);
    CHECK_EQ(sparse_from_blocks(&blocks, &f, &s, &error), 0);
    CHECK_EQ(s.n, 4);
    CHECK_EQ(s.column[4], 10);
    sparse_multiply(&s, x, y); /* u0 = +-(0.6, 0.8, 0), u1 = (2, 3, 4); forces +-k (u0 - u1) */
    double sign = f.axis[0][0] > 0 ? 1 : -1, d[3] = {0.6 * sign - 2, 0.8 * sign - 3, -4}, force[3];
    for (int i = 0; i < 3; i++) {
        force[i] = k[3 * i] * d[0] + k[3 * i + 1] * d[1] + k[3 * i + 2] * d[2];
        CHECK_NEAR(y[1 + i], -force[i], 1e-13);
    }
    CHECK_NEAR(y[0], sign * (0.6 * force[0] + 0.8 * force[1]), 1e-13);
    sparse_free(&s);
    blocks.at[0].k[4] = NAN;
    CHECK_EQ(sparse_from_blocks(&blocks, &f, &s, &error), -1);
    body_blocks_free(&blocks);
    freedom_free(&f);
}

static double right(int i)
{
    return i % 997 * 7919 % 1000;
}

static void a_factor_solves_and_knows_when_it_is_none(void)
{
    enum { COLUMNS = 37 };
    bake_error error = {""};
    sparse K = lattice((const int[]){20, 20, 20}, (const int[]){1, 1, 1}, 0);
    double *one = ones(K.n), *y = bake_alloc((size_t)K.n, sizeof *y);
    double *X = bake_alloc((size_t)K.n * COLUMNS, sizeof *X), worst = 0;
    sparse_factor *f = sparse_analyse(&K, &error);
    CHECK(f != NULL && sparse_refactor(f, &K, 0.5, one, &error) == 0);
    for (int i = 0; i < K.n * COLUMNS; i++) {
        X[i] = right(i);
    }
    sparse_solve(f, X, COLUMNS);
    for (int j = 0; j < COLUMNS; j++) { /* |x| <= 1000 / 0.5, |K| = 12: some eps of 24000 */
        sparse_multiply(&K, X + j * K.n, y);
        for (int i = 0; i < K.n; i++) {
            double left = y[i] + 0.5 * X[j * K.n + i] - right(j * K.n + i);
            worst = fmax(worst, fabs(left));
        }
    }
    CHECK_NEAR(worst, 0, 8 * DBL_EPSILON * 24000);
    /* the lowest eigenvalue is 3 (2 - 2 cos(pi/21)) = 0.067: below it there is no factor */
    CHECK_EQ(sparse_refactor(f, &K, -0.06, one, &error), 0);
    CHECK_EQ(sparse_refactor(f, &K, -0.07, one, &error), 1);
    CHECK(error.text[0] == 0);
    sparse_factor_free(f);
    sparse_free(&K);
    free(one);
    free(X);
    free(y);
}

int main(void)
{
    TEST(a_string_has_the_modes_of_a_string);
    TEST(a_cube_of_springs_has_all_copies_of_multiple_modes);
    TEST(what_is_not_held_has_a_mode_at_zero);
    TEST(modes_of_indefinite_systems_begin_with_the_lowest);
    TEST(dense_masses_are_taken_into_account);
    TEST(a_soft_mode_is_not_taken_for_a_rigid_one);
    TEST(the_same_matrix_has_the_same_modes);
    TEST(impossible_requests_are_refused_with_a_reason);
    TEST(blocks_add_up_in_the_directions_that_are_left);
    TEST(a_factor_solves_and_knows_when_it_is_none);
    return check_done();
}
