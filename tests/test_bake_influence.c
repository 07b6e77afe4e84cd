/* Weights in bytes: what they sum to, how far they are from what they were, and that no other bytes
 * are nearer.
 * Source: own; SPEC 4.21.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "domain_shapes.h"
#include "influence.h"

#include <math.h>

/* ---- what is stored -------------------------------------------------------------------------- */

/* m weights that sum to 1, of every kind: even, steep, few, equal. */
static void random_weights(unsigned *seed, int m, double *w, size_t step)
{
    double sum = 0, power = shape_random(seed, 0, 12), none = shape_random(seed, 0, 1);
    for (int j = 0; j < m; j++) {
        double x = shape_random(seed, 0, 1);
        w[(size_t)j * step] = x < none && j > 0 ? 0 : pow(shape_random(seed, 0, 1), power) + 1e-12;
        sum += w[(size_t)j * step];
    }
    for (int j = 0; j < m; j++)
        w[(size_t)j * step] /= sum;
}

static double stored(const influence *i, int bone)
{
    for (int k = 0; k < i->count; k++)
        if (i->bone[k] == bone)
            return influence_weight(i, k);
    return 0;
}

/* The sum of all but the `most` largest. */
static double pruned(const double *w, int m, size_t step, int most)
{
    double sum = 0;
    for (int j = 0; j < m; j++) {
        int larger = 0;
        for (int k = 0; k < m; k++)
            larger += w[(size_t)k * step] > w[(size_t)j * step] ||
                      (w[(size_t)k * step] >= w[(size_t)j * step] && k < j);
        sum += larger >= most ? w[(size_t)j * step] : 0;
    }
    return sum;
}

static void check_form(const influence *i, int most)
{
    int sum = 0;
    CHECK(i->count >= 1 && i->count <= most);
    for (int k = 0; k < i->count; k++) {
        int part = i->weight[k] + (k == 0), last = k > 0 ? i->weight[k - 1] + (k == 1) : 256;
        CHECK(part >= 1);
        CHECK(part < last || (part == last && (k == 0 || i->bone[k] > i->bone[k - 1])));
        sum += i->weight[k];
    }
    CHECK_EQ(sum, 255);
}

/* The bound is derived in influence.c. */
static void weights_are_near_to_what_they_were(void)
{
    enum { VERTICES = 2000, BONES = 20 };
    static double w[VERTICES * BONES];
    static influence out[VERTICES];
    unsigned seed = 1;
    double worst = 0;
    bake_error error;
    for (int v = 0; v < VERTICES; v++)
        random_weights(&seed, BONES, w + v, VERTICES);
    for (int most = 1; most <= INFLUENCES_MAX; most++) {
        CHECK(influence_make(w, NULL, (int[]){VERTICES, BONES}, most, out, &error) == 0);
        for (int v = 0; v < VERTICES; v++) {
            double lost = pruned(w + v, BONES, VERTICES, most);
            check_form(&out[v], most);
            for (int j = 0; j < BONES; j++) {
                double off = fabs(stored(&out[v], j) - w[j * VERTICES + v]);
                CHECK(off <= 1.0 / 256 + lost + 1e-12);
                worst = lost < 1e-9 ? fmax(worst, off) : worst;
            }
        }
    }
    printf("weights of which nothing was pruned: largest error %.4f / 256\n", 256 * worst);
}

/* Every division of 256 parts among four: none has a smaller largest error. */
static void no_other_bytes_are_nearer(void)
{
    unsigned seed = 2;
    for (int i = 0; i < 8; i++) {
        double w[4], got = 0, best = 1;
        influence out;
        bake_error error;
        random_weights(&seed, 4, w, 1);
        CHECK(influence_make(w, NULL, (int[]){1, 4}, 4, &out, &error) == 0);
        for (int j = 0; j < 4; j++)
            got = fmax(got, fabs(stored(&out, j) - w[j]));
        for (int a = 0; a <= 256; a++)
            for (int b = 0; a + b <= 256; b++)
                for (int c = 0; a + b + c <= 256; c++) {
                    double off = fmax(fabs(a / 256.0 - w[0]), fabs(b / 256.0 - w[1]));
                    off = fmax(off, fabs(c / 256.0 - w[2]));
                    best = fmin(best, fmax(off, fabs((256 - a - b - c) / 256.0 - w[3])));
                }
        CHECK_NEAR(got, best, 1e-12);
    }
}

static void check_stored(const double *w, int m, int most, const influence *want)
{
    influence got;
    bake_error error;
    CHECK(influence_make(w, NULL, (int[]){1, m}, most, &got, &error) == 0);
    CHECK(memcmp(&got, want, sizeof got) == 0);
}

static void ties_go_to_the_first_bone(void)
{
    check_stored((const double[]){1}, 1, 4, &(influence){1, {0}, {255}, {0}});
    check_stored((const double[]){0, 0.5, 0.5}, 3, 4, &(influence){2, {1, 2}, {127, 128}, {0}});
    check_stored((const double[]){1 / 3.0, 1 / 3.0, 1 / 3.0}, 3, 4,
                 &(influence){3, {0, 1, 2}, {85, 85, 85}, {0}});
    check_stored((const double[]){0.25, 0.25, 0.25, 0.25}, 4, 2,
                 &(influence){2, {0, 1}, {127, 128}, {0}});
    check_stored((const double[]){0.001, 0.999}, 2, 2, &(influence){1, {1}, {255}, {0}});
    check_stored((const double[]){0.002, 0.998}, 2, 2, &(influence){2, {1, 0}, {254, 1}, {0}});
    check_stored((const double[]){-1e-9, 1 + 1e-9}, 2, 2, &(influence){1, {1}, {255}, {0}});
}

/* ---- endpoint weights ------------------------------------------------------------------------ */

static void endpoint_weights_take_the_nearest_byte(void)
{
    for (int i = -100; i <= 1100; i++) {
        double w = 1, e = i / 1000.0, want = e < 0 ? 0 : e > 1 ? 1 : e, best = 1;
        influence out;
        bake_error error;
        CHECK(influence_make(&w, &e, (int[]){1, 1}, 1, &out, &error) == 0);
        for (int b = 0; b < 256; b++)
            best = fmin(best, fabs((b + (b >> 7)) / 256.0 - want));
        CHECK_NEAR(fabs(influence_end(&out, 0) - want), best, 1e-15);
    }
}

static void endpoint_weights_follow_their_bones(void)
{
    static const double w[3] = {0.1, 0.6, 0.3}, e[3] = {0.25, 1, 0.75};
    influence out;
    bake_error error;
    CHECK(influence_make(w, e, (int[]){1, 3}, 2, &out, &error) == 0);
    CHECK_EQ(out.count, 2);
    CHECK_EQ(out.bone[0], 1);
    CHECK_EQ(out.bone[1], 2);
    CHECK_NEAR(influence_end(&out, 0), 1, 0);
    CHECK_NEAR(influence_end(&out, 1), 0.75, 0);
}

/* ---- what is refused ------------------------------------------------------------------------- */

static void check_refused(const double *w, const double *e, const int size[2], int most,
                          const char *expect)
{
    static influence out[4];
    bake_error error = {""};
    CHECK(influence_make(w, e, size, most, out, &error) < 0);
    CHECK(strstr(error.text, expect) != NULL);
}

static void a_vertex_without_weights_is_named(void)
{
    static double many[300] = {1};
    check_refused((const double[]){1, 0, 0, 1e-3}, NULL, (int[]){2, 2}, 4, "vertex 1: its largest");
    check_refused((const double[]){1, -1}, NULL, (int[]){2, 1}, 4, "vertex 1: its largest");
    check_refused((const double[]){1, (double)NAN}, NULL, (int[]){2, 1}, 4, "a weight of vertex 1");
    check_refused((const double[]){1}, (const double[]){(double)NAN}, (int[]){1, 1}, 4, "vertex 0");
    check_refused((const double[]){1}, NULL, (int[]){1, 1}, 9, "9 influences a vertex");
    check_refused(many, NULL, (int[]){1, 300}, 4, "300 bones");
}

int main(void)
{
    TEST(weights_are_near_to_what_they_were);
    TEST(no_other_bytes_are_nearer);
    TEST(ties_go_to_the_first_bone);
    TEST(endpoint_weights_take_the_nearest_byte);
    TEST(endpoint_weights_follow_their_bones);
    TEST(a_vertex_without_weights_is_named);
    return check_done();
}
