/* Flat shells as plates and as sheets: frequencies on four kinds of triangles against exact ones.
 * Source: supported squares pi^2 (m^2 + n^2); the others from a Ritz method with Legendre
 * polynomials, all digits here the same with 9 or 10 and with 12 or 14 of them each way (the
 * strip's to 5e-4; free plates as Leissa 1973, to his 1 %). Ranges are what was measured, and what
 * host-bake/body/shell.c says.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shell_sheets.h"

#include <lapacke.h>

#define PI    3.14159265358979323846
#define FIRST 6 /* frequencies */

static const body_material plate = {1, 0.3, 1, 1};

/* Smallest and largest share of exact frequencies. */
typedef struct {
    double low, high;
} range;

static size_t number(const char *held, size_t n, size_t *at)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++)
        at[i] = held[i] ? 0 : ++count;
    return count;
}

/* d2V(rest) over masses, of the coordinates that are not held: they have numbers from 1 on. */
static double *stiffness(const body *b, const size_t *at, size_t n)
{
    double *K = bake_alloc(n * n, sizeof *K);
    body_blocks list = {0};
    body_hessian(b, b->rest, &list);
    for (size_t i = 0; i < 9 * list.count; i++) {
        const body_block *block = &list.at[i / 9];
        size_t p = at[3 * block->a + (int)(i % 9 / 3)], q = at[3 * block->b + (int)(i % 3)];
        double value = block->k[i % 9] / sqrt(b->mass[block->a] * b->mass[block->b]);
        if (!p || !q)
            continue;
        K[(p - 1) * n + q - 1] += value;
        if (block->a != block->b)
            K[(q - 1) * n + p - 1] += value;
    }
    body_blocks_free(&list);
    return K;
}

/* Behind `rigid` modes; modulus: D, or E h/(1 - nu^2). */
static void compare(const body *b, const char *held, int rigid, double modulus,
                    const double exact[FIRST], range *r)
{
    size_t n = 3 * (size_t)b->vertex_count, *at = bake_alloc(n, sizeof *at);
    size_t count = number(held, n, at);
    double *K = stiffness(b, at, count), *lambda = bake_alloc(count, sizeof *lambda);
    CHECK_EQ(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'U', (int)count, K, (int)count, lambda), 0);
    for (int i = 0; i < FIRST; i++) {
        double share = sqrt(lambda[rigid + i] / modulus) / exact[i];
        r->low = fmin(r->low, share);
        r->high = fmax(r->high, share);
    }
    free(lambda);
    free(K);
    free(at);
}

/* Holds z, or x and y. */
static char *hold(const body *b, int along)
{
    char *held = bake_alloc(3 * (size_t)b->vertex_count, 1);
    for (int i = 0; i < 3 * b->vertex_count; i++)
        held[i] = along ? i % 3 == 2 : i % 3 != 2;
    return held;
}

static double plate_modulus(void)
{
    return plate.young * pow(plate.thickness, 3) / (12 * (1 - plate.poisson * plate.poisson));
}

static int is_shifted(int mesh)
{
    return mesh == EQUILATERAL || mesh == IRREGULAR;
}

static void square(body *b, int mesh)
{
    sheet(b, mesh, (const double[2]){1, 1}, (const int[2]){16, is_shifted(mesh) ? 18 : 16});
    prepare(b, &plate);
}

static range bent_squares(int mesh)
{
    const double alone[FIRST] = {13.468, 19.596, 24.270, 34.801, 34.801, 61.093}, p = PI * PI;
    const double supported[FIRST] = {2 * p, 5 * p, 5 * p, 8 * p, 10 * p, 10 * p};
    range r = {HUGE_VAL, 0};
    body b;
    square(&b, mesh);
    char *held = hold(&b, 0);
    compare(&b, held, 3, plate_modulus(), alone, &r);
    for (int v = 0; v < b.vertex_count; v++) {
        const double *x = &b.rest[3 * v];
        held[3 * v + 2] = x[0] == 0 || x[0] == 1 || x[1] == 0 || x[1] == 1;
    }
    compare(&b, held, 0, plate_modulus(), supported, &r);
    free(held);
    body_free(&b);
    return r;
}

/* 8 x 1, clamped: held up to there are the vertices of the line, and of one more cell behind it. */
static range bent_strip(int mesh)
{
    const double exact[FIRST] = {0.05287, 0.33116, 0.83086, 0.92825, 1.82279, 2.51298};
    range r = {HUGE_VAL, 0};
    body b;
    sheet(&b, mesh, (const double[2]){8.125, 1}, (const int[2]){65, is_shifted(mesh) ? 9 : 8});
    prepare(&b, &plate);
    char *held = hold(&b, 0);
    for (int v = 0; v < b.vertex_count; v++)
        held[3 * v + 2] = b.rest[3 * v] < 0.125 * 1.25;
    compare(&b, held, 0, plate_modulus(), exact, &r);
    free(held);
    body_free(&b);
    return r;
}

static range stretched_square(int mesh)
{
    const double exact[FIRST] = {2.3206, 2.4716, 2.4716, 2.6284, 2.9874, 3.4522};
    range r = {HUGE_VAL, 0};
    body b;
    square(&b, mesh);
    char *held = hold(&b, 1);
    compare(&b, held, 3, 1 / (1 - plate.poisson * plate.poisson), exact, &r);
    free(held);
    body_free(&b);
    return r;
}

/* 0.005: the rounding of two digits. */
static int is_within(range r, double low, double high)
{
    int within = r.low > low - 0.005 && r.high < high + 0.005;
    if (!within)
        printf("%.3f .. %.3f, not %.2f .. %.2f\n", r.low, r.high, low, high);
    return within;
}

static void plates_bend_as_documented(void)
{
    CHECK(is_within(bent_squares(EQUILATERAL), 0.97, 1.00));
    CHECK(is_within(bent_strip(EQUILATERAL), 0.98, 0.98));
    CHECK(is_within(bent_squares(ONE_DIAGONAL), 0.96, 0.99));
    CHECK(is_within(bent_strip(ONE_DIAGONAL), 0.98, 0.99));
    CHECK(is_within(bent_squares(IRREGULAR), 1.00, 1.04));
    CHECK(is_within(bent_strip(IRREGULAR), 1.00, 1.01));
    CHECK(is_within(bent_squares(ALTERNATING), 0.97, 1.43));
    CHECK(is_within(bent_strip(ALTERNATING), 0.99, 1.42));
}

static void sheets_stretch_as_documented(void)
{
    CHECK(is_within(stretched_square(EQUILATERAL), 1.00, 1.00));
    CHECK(is_within(stretched_square(ONE_DIAGONAL), 1.00, 1.01));
    CHECK(is_within(stretched_square(IRREGULAR), 1.00, 1.00));
    CHECK(is_within(stretched_square(ALTERNATING), 1.00, 1.01));
}

int main(void)
{
    TEST(plates_bend_as_documented);
    TEST(sheets_stretch_as_documented);
    return check_done();
}
