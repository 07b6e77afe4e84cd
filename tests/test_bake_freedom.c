/* Directions that vertices may move in: orthonormal, perpendicular to every normal, no fewer.
 * Source: Schulz 2013, 2.2.1, 2.7.3.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "check.h"
#include "freedom.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static unsigned random_state = 1;

static double uniform(double lo, double hi)
{
    random_state = random_state * 1664525u + 1013904223u;
    return lo + (hi - lo) * (random_state >> 8) / 16777216.0;
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int left(const freedom *f, int vertex)
{
    return f->first[vertex + 1] - f->first[vertex];
}

/* Z^T Z = 1 through expand and restrict alone, unit vector by unit vector. Axes are products and
 * quotients of a dozen roundings: 1e-15. */
static void check_orthonormal(const freedom *f)
{
    size_t n = (size_t)f->vertex_count, count = (size_t)f->count;
    double *y = bake_alloc(count, sizeof *y), *back = bake_alloc(count, sizeof *back);
    double *u = bake_alloc(3 * n, sizeof *u);
    CHECK_EQ(f->first[0], 0);
    CHECK_EQ(f->first[n], f->count);
    for (size_t i = 0; i < count; i++) {
        memset(y, 0, count * sizeof *y);
        y[i] = 1;
        for (size_t j = 0; j < 3 * n; j++)
            u[j] = NAN; /* every element is written */
        freedom_expand(f, y, u);
        freedom_restrict(f, u, back);
        for (size_t j = 0; j < count; j++)
            CHECK_NEAR(back[j], i == j, 2e-15);
    }
    free(y), free(back), free(u);
}

/* u minus Z Z^T u, at one vertex: what it may not do. */
static void refused(const freedom *f, int vertex, const double motion[3], double out[3])
{
    size_t n = 3 * (size_t)f->vertex_count;
    double *u = bake_alloc(n, sizeof *u), *y = bake_alloc((size_t)f->count, sizeof *y);
    memcpy(&u[3 * vertex], motion, 3 * sizeof *u);
    freedom_restrict(f, u, y);
    freedom_expand(f, y, u);
    for (int i = 0; i < 3; i++)
        out[i] = motion[i] - u[3 * vertex + i];
    free(u), free(y);
}

static void all_vertices_are_free_at_first(void)
{
    freedom f;
    double u[12], y[12], again[12];
    freedom_make(4, &f);
    freedom_finish(&f);
    CHECK_EQ(f.count, 12);
    for (int i = 0; i < 12; i++)
        u[i] = uniform(-1, 1);
    freedom_restrict(&f, u, y);
    freedom_expand(&f, y, again);
    for (int i = 0; i < 12; i++) {
        CHECK(again[i] == u[i]);
        CHECK(y[i] == u[i]);
    }
    freedom_free(&f);
    CHECK(f.first == NULL && f.axis == NULL);
}

/* Vertex i of 4 has i normals, in general position. */
static void each_normal_takes_one_direction(void)
{
    for (int trial = 0; trial < 1000; trial++) {
        freedom f;
        double normal[4][3], out[3];
        freedom_make(4, &f);
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 3; j++)
                normal[i][j] = uniform(-1, 1) * pow(10, trial % 13 - 6);
        for (int vertex = 0; vertex < 4; vertex++)
            for (int i = 0; i < vertex; i++)
                freedom_slide(&f, vertex, normal[i]);
        freedom_finish(&f);
        check_orthonormal(&f);
        CHECK_EQ(f.count, 3 + 2 + 1 + 0);
        for (int vertex = 0; vertex < 4; vertex++) {
            CHECK_EQ(left(&f, vertex), 3 - vertex);
            for (int k = f.first[vertex]; k < f.first[vertex + 1]; k++)
                for (int i = 0; i < vertex; i++)
                    /* perpendicular; two normals at an angle of 1e-3 lose three digits of it */
                    CHECK_NEAR(dot(f.axis[k], normal[i]), 0,
                               1e-12 * sqrt(dot(normal[i], normal[i])));
        }
        refused(&f, 1, normal[0], out);
        for (int i = 0; i < 3; i++) /* all of the normal, */
            CHECK_NEAR(out[i], normal[0][i],
                       1e-14 * fabs(normal[0][i]) + 1e-14 * pow(10, trial % 13 - 6));
        refused(&f, 1, normal[1], out);
        double share = dot(normal[1], normal[0]) / dot(normal[0], normal[0]);
        for (int i = 0; i < 3; i++) /* and nothing but the normal */
            CHECK_NEAR(out[i], share * normal[0][i], 1e-14 * pow(10, trial % 13 - 6) * 3);
        freedom_free(&f);
    }
}

static void two_planes_leave_their_line(void)
{
    freedom f;
    const double y[3] = {0, 1, 0}, slope[3] = {1, 1, 0};
    freedom_make(3, &f);
    freedom_slide(&f, 1, y);
    freedom_slide(&f, 1, slope);
    freedom_finish(&f);
    CHECK_EQ(left(&f, 0), 3);
    CHECK_EQ(left(&f, 1), 1);
    CHECK_EQ(left(&f, 2), 3);
    CHECK_NEAR(fabs(f.axis[3][2]), 1, 1e-15);
    freedom_free(&f);
}

/* Every way of saying the same twice: a multiple, the opposite, a sum, one with six digits. */
static void dependent_normals_take_nothing_more(void)
{
    static const double a[3] = {1, 2, -2}, b[3] = {0.5, -1, 0.3};
    static const double same[4][3] = {
        {3, 6, -6}, {-1, -2, 2}, {0.333333, 0.666667, -0.666667}, {1e200, 2e200, -2e200}};
    static const double sum[3] = {2 * 1 - 3 * 0.5, 2 * 2 + 3, 2 * -2 - 3 * 0.3};
    freedom f;
    freedom_make(2, &f);
    freedom_slide(&f, 0, a);
    freedom_slide(&f, 1, a);
    for (int i = 0; i < 4; i++) {
        freedom_slide(&f, 0, same[i]);
        CHECK_EQ(f.count, 4);
    }
    freedom_slide(&f, 1, b);
    freedom_slide(&f, 1, sum);
    freedom_slide(&f, 1, same[2]);
    freedom_finish(&f);
    CHECK_EQ(left(&f, 0), 2);
    CHECK_EQ(left(&f, 1), 1);
    check_orthonormal(&f);
    freedom_free(&f);
}

/* A hundredth of a degree apart: two planes, which somebody meant. */
static void normals_close_together_are_two(void)
{
    static const double a[3] = {0, 1, 0}, b[3] = {1.7e-4, 1, 0};
    freedom f;
    freedom_make(1, &f);
    freedom_slide(&f, 0, a);
    freedom_slide(&f, 0, b);
    freedom_finish(&f);
    CHECK_EQ(f.count, 1);
    CHECK_NEAR(fabs(f.axis[0][2]), 1, 1e-12);
    freedom_free(&f);
}

static void normals_without_direction_take_nothing(void)
{
    static const double bad[4][3] = {{0, 0, 0}, {NAN, 0, 0}, {HUGE_VAL, 1, 0}, {0, 1, NAN}};
    freedom f;
    freedom_make(1, &f);
    for (int i = 0; i < 4; i++)
        freedom_slide(&f, 0, bad[i]);
    freedom_finish(&f);
    CHECK_EQ(f.count, 3);
    freedom_free(&f);
}

static void what_is_fixed_stays_fixed(void)
{
    static const double n[3] = {0, 0, 1};
    freedom f;
    double y[6], u[12];
    freedom_make(4, &f);
    freedom_slide(&f, 1, n);
    freedom_fix(&f, 0);
    freedom_fix(&f, 1);
    freedom_fix(&f, 1);
    freedom_slide(&f, 1, n);
    freedom_fix(&f, 3);
    freedom_finish(&f);
    CHECK_EQ(f.count, 3);
    for (int i = 0; i < 3; i++)
        y[i] = 1 + i;
    freedom_expand(&f, y, u);
    for (int i = 0; i < 12; i++)
        CHECK(u[i] == (i / 3 == 2 ? 1 + i % 3 : 0));
    freedom_free(&f);
}

int main(void)
{
    TEST(all_vertices_are_free_at_first);
    TEST(each_normal_takes_one_direction);
    TEST(two_planes_leave_their_line);
    TEST(dependent_normals_take_nothing_more);
    TEST(normals_close_together_are_two);
    TEST(normals_without_direction_take_nothing);
    TEST(what_is_fixed_stays_fixed);
    return check_done();
}
