/* Vibration modes of elastic bodies against LAPACK on the full matrices, and against blocks and beams
 * of elasticity theory.
 *   VERBOSE=1 prints what was measured
 * SPDX-License-Identifier: MIT */
#include "body_shapes.h"
#include "modes_check.h"

#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

/* The same eigenvalues from full matrices. Both are exact to noise and 1e-10. */
static void compare_dense(const sparse *K, const double *M, const modes *found)
{
    size_t n = (size_t)K->n;
    bake_error error = {""};
    modes all;
    double *full = bake_alloc(n * n, sizeof *full), *mass = bake_alloc(n * n, sizeof *mass);
    for (size_t j = 0; j < n; j++) {
        mass[j * n + j] = M[j];
        for (int p = K->column[j]; p < K->column[j + 1]; p++) {
            size_t i = (size_t)K->row[p];
            full[i * n + j] = full[j * n + i] = K->value[p];
        }
    }
    CHECK_EQ(modes_dense(full, mass, K->n, &all, &error), 0);
    for (int i = found->rigid; i < found->count; i++) {
        CHECK_NEAR(all.lambda[i], found->lambda[i], found->noise + 1e-10 * fabs(all.lambda[i]));
    }
    modes_free(&all);
    free(full);
    free(mass);
}

/* Modes of a prepared body, in x; left: held where x = 0. */
static void modes_of(body *b, int left, int count, modes *out, double **mass)
{
    bake_error error = {""};
    body_blocks blocks = {0};
    freedom f;
    sparse K;
    CHECK_EQ(body_prepare(b, &error), 0);
    freedom_make(b->vertex_count, &f);
    for (int i = 0; i < b->vertex_count && left; i++) {
        if (b->rest[3 * i] == 0) {
            freedom_fix(&f, i);
        }
    }
    freedom_finish(&f);
    body_hessian(b, b->rest, &blocks);
    CHECK_EQ(sparse_from_blocks(&blocks, &f, &K, &error), 0);
    *mass = bake_alloc((size_t)f.count, sizeof **mass);
    for (int i = 0; i < b->vertex_count; i++) {
        for (int j = f.first[i]; j < f.first[i + 1]; j++) {
            (*mass)[j] = b->mass[i];
        }
    }
    CHECK_EQ(modes_solve(&K, *mass, count, out, &error), 0);
    check_modes(out, *mass);
    if (f.count < 900) {
        compare_dense(&K, *mass, out);
    }
    sparse_free(&K);
    body_blocks_free(&blocks);
    freedom_free(&f);
}

/* A free cube of edge a moves exactly as u = cos(pi x/a) sin(pi y/a), v = -sin(pi x/a) cos(pi y/a):
 * no stress on any face [Lame]. omega = sqrt(2) pi/a sqrt(mu/rho), for each pair of axes. Which of
 * the body's modes are that motion is seen from their share in it. Returns the mean omega by these
 * shares. */
static double lame_mode(int cells, int pair, double *share)
{
    body b = {.material = {.young = 2.6e6, .poisson = 0.3, .density = 1000}};
    int x = pair, y = (pair + 1) % 3;
    double *M, sum = 0, norm = 0;
    modes m;
    box_tets(&b, (const double[]){1, 1, 1}, (const int[]){cells, cells, cells});
    modes_of(&b, 0, 30, &m, &M);
    CHECK_EQ(m.rigid, 6);
    CHECK_EQ(m.negative, 0);
    *share = 0;
    for (int j = 0; j < 30; j++) {
        double inner = 0;
        for (int i = 0; i < b.vertex_count; i++) {
            const double *at = &b.rest[3 * i], *phi = &m.phi[j * m.n + 3 * i];
            double u = cos(PI * at[x]) * sin(PI * at[y]), v = -sin(PI * at[x]) * cos(PI * at[y]);
            inner += M[3 * i] * (u * phi[x] + v * phi[y]);
            norm += j == 0 ? M[3 * i] * (u * u + v * v) : 0;
        }
        *share += inner * inner;
        sum += inner * inner * m.lambda[j];
    }
    double omega = sqrt(sum / *share);
    *share /= norm;
    modes_free(&m);
    body_free(&b);
    free(M);
    return omega;
}

/* Lumped masses and linear elements are wrong by (k h)^2 / 24 at most along a lattice's axes, k =
 * sqrt(2) pi: 1.3 % of 8 cells, a quarter of it for 16. The motion itself is found to (k h)^2 / 24
 * too, so that less than its square is missing. */
static void a_free_cube_has_six_zeros_and_lames_modes(void)
{
    double exact = sqrt(2) * PI * sqrt(1e6 / 1000), share, error[2];
    for (int i = 0; i < 2; i++) {
        double kh = sqrt(2) * PI / (8 << i), bound = kh * kh / 24;
        error[i] = lame_mode(8 << i, i, &share) / exact - 1;
        CHECK(fabs(error[i]) <= bound);
        CHECK(share >= 1 - bound && share <= 1 + 1e-9);
    }
    CHECK_NEAR(log2(error[0] / error[1]), 2, 0.25);
}

/* lambda of the first two bending modes of a bar 20 long and 1 wide over those of Euler and
 * Bernoulli, for `cells` across. Both are pairs, as the mesh has all of the bar's symmetries. */
static void bar_modes(int held, int cells, const double root[2], double out[2])
{
    body b = {.material = {.young = 1e6, .poisson = 0, .density = 1000}};
    int first = held ? 0 : 6;
    double *M;
    modes m;
    box_tets(&b, (const double[]){20, 1, 1}, (const int[]){10 * cells, cells, cells});
    modes_of(&b, held, first + 4, &m, &M);
    CHECK_EQ(m.rigid, first);
    CHECK_EQ(m.negative, 0);
    for (int k = 0; k < 2; k++) {
        double exact = pow(root[k] / 20, 4) * 1e6 / 12 / 1000, *pair = &m.lambda[first + 2 * k];
        CHECK_NEAR(pair[0] / pair[1], 1, 1e-9);
        out[k] = pair[0] / exact;
        CHECK(out[k] > 1);
    }
    modes_free(&m);
    body_free(&b);
    free(M);
}

/* Linear tetrahedra cannot bend: what they store in shear instead goes with the square of their
 * size and adds to the stiffness. So lambda = limit + C/cells^2, from above: ratios of 4 between
 * differences, and a limit by Richardson. It is below Euler and Bernoulli by what shear and rotary
 * inertia take, for short waves (k r)^2 (1 + E/(kappa G)), k = root/L, r^2 = 1/12, kappa = 5/6, E/G
 * = 2 [Timoshenko]; by how much depends on the ends, half of it is allowed, and 0.5 % for
 * Richardson (4 % of the last difference). */
static void check_bar(int held, const double root[2])
{
    double lambda[3][2];
    for (int i = 0; i < 3; i++) {
        bar_modes(held, 2 << i, root, lambda[i]);
    }
    for (int k = 0; k < 2; k++) {
        double first = lambda[0][k] - lambda[1][k], second = lambda[1][k] - lambda[2][k];
        double shear = pow(root[k] / 20, 2) / 12 * (1 + 2.4), far = lambda[2][k] - second / 3;
        CHECK_NEAR(log2(first / second), 2, 0.15);
        CHECK_NEAR(far, 1 - shear, shear / 2 + 0.005);
        if (getenv("VERBOSE")) {
            printf("  %s bar, bending %d: lambda %.4f %.4f %.4f, order %.3f, limit %.5f, expected "
                   "%.5f\n",
                   held ? "held" : "free", k + 1, lambda[0][k], lambda[1][k], lambda[2][k],
                   log2(first / second), far, 1 - shear);
        }
    }
}

static void a_held_bar_bends_as_beam_theory_says(void)
{
    check_bar(1, (const double[]){1.87510406871196, 4.69409113297417});
}

static void a_free_bar_bends_as_beam_theory_says(void)
{
    check_bar(0, (const double[]){4.73004074486270, 7.85320462409584});
}

/* Thin, so that bending is six orders softer than stretching. */
static void a_free_sheet_has_six_zeros(void)
{
    for (int equilateral = 0; equilateral < 2; equilateral++) {
        body b = {.material = {2e9, 0.3, 1000, 0.5e-3}};
        double *M;
        modes m;
        sheet_triangles(&b, (const double[]){0.3, 0.2}, (const int[]){24, 18}, equilateral);
        modes_of(&b, 0, 16, &m, &M);
        CHECK_EQ(m.rigid, 6);
        CHECK_EQ(m.negative, 0);
        CHECK(m.lambda[6] > 1e3 * m.noise);
        for (int i = 0; i < 16; i++) {
            CHECK(m.residual[i] <= 1e-8);
        }
        modes_free(&m);
        body_free(&b);
        free(M);
    }
}

int main(void)
{
    TEST(a_free_cube_has_six_zeros_and_lames_modes);
    TEST(a_held_bar_bends_as_beam_theory_says);
    TEST(a_free_bar_bends_as_beam_theory_says);
    TEST(a_free_sheet_has_six_zeros);
    return check_done();
}
