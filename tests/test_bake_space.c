/* Reduced spaces and their linear models against plain sums, and against the coupled equations.
 * Source: Schulz 2013, 2.2.2, 2.7.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "space.h"
#include "spline_random.h"

#include <lapacke.h>
#include <stdlib.h>
#include <string.h>

#define N 60

static void randomise(double *x, int count, double low, double high)
{
    for (int i = 0; i < count; i++)
        x[i] = uniform(low, high);
}

/* N coordinates, masses over six decades; or a dense M = A^T A + 1. */
static space empty_space(int dense)
{
    space s = {.n = N, .origin = bake_alloc(N, 8), .mass = bake_alloc(N, 8)};
    randomise(s.origin, N, -1, 1);
    for (int i = 0; i < N; i++)
        s.mass[i] = pow(10, uniform(-5, 1));
    if (!dense)
        return s;
    double A[N * N];
    randomise(A, N * N, -1, 1);
    s.M = bake_alloc((size_t)N * N, 8);
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            s.M[i * N + j] = i == j;
            for (int k = 0; k < N; k++)
                s.M[i * N + j] += A[k * N + i] * A[k * N + j];
        }
    }
    return s;
}

/* a^T M b by plain sums. */
static double product(const space *s, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N && s->M; j++)
            sum += a[i] * s->M[i * N + j] * b[j];
        sum += s->M ? 0 : a[i] * s->mass[i] * b[i];
    }
    return sum;
}

/* How much of u, in the mass norm, is not in the space, relative to u. */
static double outside(const space *s, const double *u)
{
    double left[N];
    memcpy(left, u, sizeof left);
    for (int j = 0; j < s->d; j++) {
        double share = product(s, s->V + j * N, u);
        for (int i = 0; i < N; i++)
            left[i] -= share * s->V[j * N + i];
    }
    return sqrt(product(s, left, left) / product(s, u, u));
}

static void made(space *s, const double *vectors, int count, int d)
{
    bake_error error = {""};
    CHECK_EQ(space_make(s, vectors, count, &error), 0);
    if (!s->V)
        printf("%s\n", error.text);
    CHECK_EQ(s->d, d);
    for (int i = 0; i < s->d; i++) {
        for (int j = 0; j <= i; j++) /* the limit of space.h and this sum's own rounding */
            CHECK_NEAR(product(s, s->V + i * N, s->V + j * N), i == j, 1.1e-12);
    }
}

/* ---- spaces ------------------------------------------------------------------------------------ */

/* Rounding: N eps for each of d coefficients, 1e-13; what is dropped is 1e-7 at most, and here 0. */
static void a_space_contains_its_vectors_and_no_more(void)
{
    for (int dense = 0; dense < 2; dense++) {
        space s = empty_space(dense);
        double S[16 * N];
        randomise(S, 16 * N, -1, 1);
        for (int i = 0; i < N; i++) {
            S[3 * N + i] *= 1e9;                    /* any length */
            S[7 * N + i] = S[3 * N + i];            /* twice the same */
            S[9 * N + i] = S[i] + 2 * S[5 * N + i]; /* a combination */
            S[11 * N + i] = -1e-6 * S[2 * N + i];   /* the other way */
            S[12 * N + i] = 0;                      /* nothing */
            S[13 * N + i] = 1e-17 * s.origin[i];    /* rounding of poses */
        }
        made(&s, S, 16, 11);
        for (int j = 0; j < 16; j++) {
            if (j != 12 && j != 13)
                CHECK_NEAR(outside(&s, S + j * N), 0, 1e-12);
        }
        space_free(&s);
    }
}

/* v_k = v_0 + 10^-k w_k: singular values of about 10^-k. Those above 1e-7 are kept, and then all vectors are
 * in the space to rounding, however small their own direction was. Vectors that are nearer still are
 * dropped; that costs every vector 1e-7 sqrt(count) at most. */
static void small_differences_are_kept_down_to_1e_7(void)
{
    for (int dense = 0; dense < 2; dense++) {
        space s = empty_space(dense);
        double S[10 * N], w[N];
        randomise(S, N, -1, 1);
        for (int k = 1; k < 10; k++) {
            double size = k < 6 ? pow(10, -k) : pow(10, -k - 3);
            randomise(w, N, -1, 1);
            for (int i = 0; i < N; i++)
                S[k * N + i] = S[i] + size * w[i];
        }
        made(&s, S, 6, 6);
        for (int k = 0; k < 6; k++)
            CHECK_NEAR(outside(&s, S + k * N), 0, 1e-13);
        free(s.V);
        made(&s, S, 10, 6);
        for (int k = 0; k < 10; k++)
            CHECK_NEAR(outside(&s, S + k * N), 0, 1e-7 * sqrt(10));
        space_free(&s);
    }
}

/* More vectors than dimensions, as chains have: the space is everything. */
static void more_vectors_than_dimensions_give_all_of_them(void)
{
    space s = empty_space(1);
    double S[2 * N * N];
    randomise(S, 2 * N * N, -1, 1);
    made(&s, S, 2 * N, N);
    space_free(&s);
}

static void projection_undoes_expansion(void)
{
    for (int dense = 0; dense < 2; dense++) {
        space s = empty_space(dense);
        double S[9 * N], q[9], x[N], back[9], u[N], y[N];
        randomise(S, 9 * N, -1, 1);
        made(&s, S, 9, 9);
        randomise(q, 9, -1, 1);
        space_expand(&s, q, x);
        space_project(&s, x, back);
        for (int j = 0; j < 9; j++)
            CHECK_NEAR(back[j], q[j], 1e-11); /* 1e-12 of orthonormality for each of 9 */
        for (int i = 0; i < N; i++)
            x[i] = s.origin[i] + S[4 * N + i]; /* a pose that was put in comes back */
        space_project(&s, x, back);
        space_expand(&s, back, y);
        for (int i = 0; i < N; i++)
            CHECK_NEAR(y[i], x[i], 1e-9); /* 1e-12 in the norm with masses of 1e-5 .. 10 */
        randomise(u, N, -1, 1); /* a velocity: no origin; that of the best approximation */
        space_project_vector(&s, u, back);
        for (int j = 0; j < 9; j++)
            CHECK_NEAR(back[j], product(&s, s.V + j * N, u), 1e-12 * sqrt(product(&s, u, u)));
        space_free(&s);
    }
}

static void what_is_no_space_is_refused(void)
{
    bake_error error;
    double S[2 * N] = {0};
    space s = empty_space(0);
    CHECK_EQ(space_make(&s, S, 2, &error), -1);
    CHECK(strstr(error.text, "nothing moves") != NULL && s.V == NULL);
    S[5] = NAN;
    CHECK_EQ(space_make(&s, S, 2, &error), -1);
    CHECK(strstr(error.text, "not a number") != NULL);
    S[5] = 1;
    s.mass[7] = 0;
    CHECK_EQ(space_make(&s, S, 2, &error), -1);
    CHECK(strstr(error.text, "coordinate 7") != NULL);
    space_free(&s);
}

/* ---- V^T K V ----------------------------------------------------------------------------------- */

static void add_random_block(body_blocks *list, double K[N][N], int a, int b)
{
    body_block *block = &list->at[list->count++];
    *block = (body_block){a, b, {0}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            double k = a == b && j < i ? block->k[3 * j + i] : uniform(-1, 1);
            block->k[3 * i + j] = k;
            K[3 * a + i][3 * b + j] += k;
            if (a != b)
                K[3 * b + j][3 * a + i] += k;
        }
    }
}

/* 33 columns: two full panels and one of a single column. Pairs come repeatedly and in any order. */
static void reduced_hessians_equal_plain_sums(void)
{
    static double K[N][N], S[33 * N];
    body_block blocks[200];
    body_blocks list = {0, 200, blocks};
    space s = empty_space(0);
    double out[33 * 33], dense[33 * 33];
    memset(K, 0, sizeof K);
    randomise(S, 33 * N, -1, 1);
    made(&s, S, 33, 33);
    for (int k = 0; k < 200; k++) {
        int a = (int)uniform(0, 20), b = (int)uniform(0, a + 1);
        add_random_block(&list, K, a, b);
    }
    space_reduce_blocks(&s, &list, out);
    space_reduce_dense(&s, &K[0][0], dense);
    for (int p = 0; p < 33; p++) {
        for (int r = 0; r < 33; r++) {
            double sum = 0, size = 0;
            for (int i = 0; i < N * N; i++) {
                double term = s.V[p * N + i / N] * K[i / N][i % N] * s.V[r * N + i % N];
                sum += term;
                size += fabs(term);
            }
            CHECK_NEAR(out[33 * p + r], sum, 1e-14 * size); /* 60 eps */
            CHECK_NEAR(dense[33 * p + r], sum, 1e-14 * size);
            CHECK(out[33 * p + r] == out[33 * r + p] && dense[33 * p + r] == dense[33 * r + p]);
        }
    }
    space_free(&s);
}

/* ---- models ------------------------------------------------------------------------------------ */

#define D 7
typedef struct {
    double K[D * D], z[D], gradient[D], force[D];
} reduced;

/* K of rank `rank`: of indefinite sign, or none below 0. */
static reduced random_reduced(int rank, int indefinite)
{
    reduced r = {.z = {0}};
    double a[D];
    for (int k = 0; k < rank; k++) {
        randomise(a, D, -1, 1);
        for (int i = 0; i < D * D; i++)
            r.K[i] += (indefinite && k % 2 ? -1 : 1) * a[i / D] * a[i % D];
    }
    randomise(r.z, D, -1, 1);
    randomise(r.gradient, D, -1, 1);
    randomise(r.force, D, -1, 1);
    return r;
}

static linear_model model_of(const reduced *r)
{
    linear_model m = {.d = 0};
    bake_error error = {""};
    CHECK_EQ(
        linear_model_make(&(linear_terms){D, r->K, r->z, r->gradient, r->force, 0}, &m, &error), 0);
    return m;
}

/* q'' + (alpha + beta s K) q' + s (K (q - z) + dV(z)) - force, for the states of any c. */
static void coupled(const reduced *r, const linear_model *m, const double p[3], double c[3][D],
                    double *out)
{
    double q[3][D] = {{0}};
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < D * D; i++)
            q[k][i % D] += m->Phi[i] * c[k][i / D];
    }
    for (int i = 0; i < D; i++) {
        out[i] = q[2][i] + p[0] * q[1][i] + p[2] * r->gradient[i] - r->force[i];
        for (int j = 0; j < D; j++)
            out[i] += p[2] * r->K[i * D + j] * (p[1] * q[1][j] + q[0][j] - r->z[j]);
    }
}

/* For any motion at all, the force that the coupled equations ask for is that of the decoupled ones,
 * turned by Phi. Sums of some 3 D products of size 5: 1e-12. */
static void decoupled_equations_are_the_coupled_ones(void)
{
    for (int round = 0; round < 100; round++) {
        reduced r = random_reduced(1 + round % 10, round % 3 == 0);
        linear_model m = model_of(&r);
        double c[3][D], want[D], p[3] = {uniform(0, 2), uniform(0, 2), uniform(0.1, 3)};
        randomise(&c[0][0], 3 * D, -1, 1);
        coupled(&r, &m, p, c, want);
        double got[D] = {0};
        for (int i = 0; i < D * D; i++) {
            int k = i / D;
            double s_lambda = p[2] * m.lambda[k];
            got[i % D] += m.Phi[i] * (c[2][k] + (p[0] + p[1] * s_lambda) * c[1][k] +
                                      s_lambda * c[0][k] + p[2] * m.inner[k] + m.outer[k]);
        }
        for (int i = 0; i < D; i++)
            CHECK_NEAR(got[i], want[i], 1e-12);
        linear_model_free(&m);
    }
}

static void modes_are_orthogonal_ascending_and_signed(void)
{
    reduced r = random_reduced(4, 1);
    linear_model m = model_of(&r);
    int zeros = 0;
    for (int a = 0; a < D; a++) {
        double largest = 0, projected[D];
        for (int i = 0; i < D; i++)
            largest = fabs(m.Phi[a * D + i]) > fabs(largest) ? m.Phi[a * D + i] : largest;
        CHECK(largest > 0);
        CHECK(a == 0 || m.lambda[a] >= m.lambda[a - 1]);
        zeros += m.lambda[a] == 0;
        linear_model_project(&m, m.Phi + a * D, projected);
        for (int b = 0; b < D; b++)
            CHECK_NEAR(projected[b], a == b, 1e-14);
    }
    CHECK_EQ(zeros, D - 4); /* not 1e-17: they are cubic splines, not slow oscillations */
    linear_model_free(&m);
}

/* What is 0 is a matter of the caller's noise, too; then inner is all of the force there. */
static void noise_becomes_zero(void)
{
    const double K[4] = {1e-9, 0, 0, 4}, z[2] = {3, 5}, gradient[2] = {0.5, 0.25},
                 force[2] = {2, 1};
    linear_model m;
    bake_error error;
    CHECK_EQ(linear_model_make(&(linear_terms){2, K, z, gradient, force, 1e-8}, &m, &error), 0);
    CHECK(m.lambda[0] == 0 && m.lambda[1] == 4);
    CHECK(m.inner[0] == 0.5 && m.inner[1] == 0.25 - 4 * 5);
    CHECK(m.outer[0] == -2 && m.outer[1] == -1);
    linear_model_free(&m);
    CHECK_EQ(linear_model_make(&(linear_terms){2, K, z, gradient, force, 1e-10}, &m, &error), 0);
    CHECK(m.lambda[0] == 1e-9);
    linear_model_free(&m);
    const double bad[4] = {1, NAN, NAN, 1};
    CHECK_EQ(linear_model_make(&(linear_terms){2, bad, z, gradient, force, 0}, &m, &error), -1);
    CHECK(strstr(error.text, "not a number") != NULL);
}

/* Of a quadratic potential it makes no difference where it is linearised; and a space whose origin is
 * moved by a sees coordinates c - Phi^T a. inner is a sum of 2 D products of size up to 7: 1e-12. */
static void models_do_not_depend_on_the_point_or_the_origin(void)
{
    for (int round = 0; round < 20; round++) {
        reduced r = random_reduced(3 + round % 6, 1), there = r, moved = r;
        double a[D], shift[D];
        randomise(a, D, -1, 1);
        for (int i = 0; i < D; i++) {
            there.z[i] += a[i];
            moved.z[i] -= a[i];
            for (int j = 0; j < D; j++)
                there.gradient[i] += r.K[i * D + j] * a[j];
        }
        linear_model m = model_of(&r), n = model_of(&there), o = model_of(&moved);
        linear_model_project(&m, a, shift);
        for (int i = 0; i < D; i++) {
            CHECK(m.lambda[i] == n.lambda[i] && m.lambda[i] == o.lambda[i]);
            CHECK_NEAR(n.inner[i], m.inner[i], 1e-12);
            CHECK_NEAR(o.inner[i], m.inner[i] + m.lambda[i] * shift[i], 1e-12);
        }
        linear_model_free(&m);
        linear_model_free(&n);
        linear_model_free(&o);
    }
}

/* Where nothing accelerates: K (q - z) = force - dV(z), by LAPACK's LU; and -g / lambda (erratum S1), with
 * lambda < 0 among them. Both are accurate to eps times K's condition, which is below 1e4 here. */
static void equilibrium_is_minus_g_over_lambda(void)
{
    reduced r = random_reduced(D, 1);
    for (int i = 0; i < D; i++)
        r.K[i * (D + 1)] += i % 2 ? 3 : -3;
    linear_model m = model_of(&r);
    double K[D * D], want[D], c[D];
    lapack_int pivot[D];
    memcpy(K, r.K, sizeof K);
    for (int i = 0; i < D; i++)
        want[i] = r.force[i] - r.gradient[i];
    CHECK_EQ(LAPACKE_dgesv(LAPACK_COL_MAJOR, D, 1, K, D, pivot, want, D), 0);
    for (int i = 0; i < D; i++)
        want[i] += r.z[i];
    linear_model_project(&m, want, c);
    CHECK(m.lambda[0] < 0);
    for (int i = 0; i < D; i++)
        CHECK_NEAR(c[i], -(m.inner[i] + m.outer[i]) / m.lambda[i], 1e-11);
    linear_model_free(&m);
}

static void a_plain_model_is_the_space_itself(void)
{
    linear_model m;
    double q[D], c[D];
    linear_model_plain(D, &m);
    randomise(q, D, -1, 1);
    linear_model_project(&m, q, c);
    CHECK_EQ(m.d, D);
    for (int i = 0; i < D; i++)
        CHECK(c[i] == q[i] && m.lambda[i] == 0 && m.inner[i] == 0 && m.outer[i] == 0);
    linear_model_free(&m);
}

int main(void)
{
    TEST(a_space_contains_its_vectors_and_no_more);
    TEST(small_differences_are_kept_down_to_1e_7);
    TEST(more_vectors_than_dimensions_give_all_of_them);
    TEST(projection_undoes_expansion);
    TEST(what_is_no_space_is_refused);
    TEST(reduced_hessians_equal_plain_sums);
    TEST(decoupled_equations_are_the_coupled_ones);
    TEST(modes_are_orthogonal_ascending_and_signed);
    TEST(noise_becomes_zero);
    TEST(models_do_not_depend_on_the_point_or_the_origin);
    TEST(equilibrium_is_minus_g_over_lambda);
    TEST(a_plain_model_is_the_space_itself);
    return check_done();
}
