/* Chains against mass points in high precision, and pendulums against closed forms.
 * Source: Schulz 2013, 2.3.1, 5.1, 5.2; vectors from tests/reference/chain_oracle.py.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "chain.h"
#include "check.h"
#include "space.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DOWN (-1.5707963267948966)
#define D    (CHAIN_LINKS_MAX + 2)

/* ---- oracle ------------------------------------------------------------------------------------ */

typedef struct {
    chain c;
    chain_link link[CHAIN_LINKS_MAX];
    double q[D];
    int links, checked;
} oracle_case;

static int read_numbers(const char *text, double *out)
{
    int count = 0;
    char *rest;
    for (; *text == ','; text = rest)
        out[count++] = strtod(text + 1, &rest);
    return count;
}

/* Each number is a sum of fewer than 100 products, each to 4 eps, of at most the largest: 1e-13. */
static void compare(const char *what, const double *got, const double *want, int count)
{
    double largest = 0;
    for (int i = 0; i < count; i++)
        largest = fmax(largest, fabs(want[i]));
    for (int i = 0; i < count; i++) {
        if (!(fabs(got[i] - want[i]) <= 1e-13 * largest))
            printf("%s, number %d: ", what, i);
        CHECK_NEAR(got[i], want[i], 1e-13 * largest);
    }
}

static void read_head(const char *line, oracle_case *o)
{
    double v[4] = {0};
    CHECK_EQ(read_numbers(strchr(strchr(line, ',') + 1, ','), v), 4);
    o->links = 0;
    o->c = (chain){(int)v[0], o->link, (int)v[1], v[2], v[3]};
}

static void read_link(const char *line, oracle_case *o)
{
    double v[8] = {0};
    CHECK_EQ(read_numbers(strchr(line, ','), v), 8);
    o->link[o->links++] = (chain_link){(int)v[0], (int)v[1], v[2], v[3], v[4], {v[5], v[6]}, v[7]};
}

static void check_line(const char *line, oracle_case *o)
{
    double want[1024], got[D * D];
    int count = read_numbers(strchr(line, ','), want), d = chain_size(&o->c);
    switch (line[0]) {
    case 'q':
        CHECK_EQ(count, d);
        memcpy(o->q, want, (size_t)d * sizeof *want);
        return;
    case 'p':
        chain_points(&o->c, o->q, got);
        break;
    case 'm':
        chain_mass(&o->c, o->q, got);
        break;
    case 'e':
        got[0] = chain_energy(&o->c, o->q);
        break;
    case 'g':
        chain_gradient(&o->c, o->q, got);
        break;
    default:
        chain_hessian(&o->c, o->q, got);
    }
    CHECK_EQ(count, line[0] == 'p'   ? 4 * o->c.link_count
                    : line[0] == 'e' ? 1
                    : line[0] == 'g' ? d
                                     : d * d);
    compare(line[0] == 'm' ? "mass" : line, got, want, count);
    o->checked++;
}

static void chains_equal_their_mass_points(void)
{
    static char line[65536];
    oracle_case o = {.checked = 0};
    FILE *file = fopen("tests/vectors/chain_oracle.csv", "r");
    CHECK(file != NULL);
    while (file && fgets(line, sizeof line, file)) {
        if (line[0] == '#')
            continue;
        if (line[0] == 'c')
            read_head(line, &o);
        else if (line[0] == 'l')
            read_link(line, &o);
        else
            check_line(line, &o);
        bake_error error = {""};
        if (line[0] == 'l' && o.links == o.c.link_count)
            CHECK_EQ(chain_check(&o.c, &error), 0);
    }
    CHECK_EQ(o.checked, 5 * 3 * 5);
    if (file)
        fclose(file);
}

/* ---- small oscillations ------------------------------------------------------------------------ */

/* lambda of  d2V phi = lambda M phi  in the rest pose; returns their count. */
static int frequencies(const chain *c, double *lambda)
{
    bake_error error = {""};
    int d = chain_size(c);
    size_t n = (size_t)d;
    space s = {.n = d, .origin = bake_alloc(n, 8), .M = bake_alloc(n * n, 8)};
    double unit[D * D] = {0}, H[D * D], K[D * D], none[D] = {0};
    linear_model m;
    CHECK_EQ(chain_check(c, &error), 0);
    for (size_t i = 0; i < n; i++)
        unit[i * n + i] = 1;
    chain_rest(c, s.origin);
    chain_mass(c, s.origin, s.M);
    chain_hessian(c, s.origin, H);
    CHECK_EQ(space_make(&s, unit, d, &error), 0);
    CHECK_EQ(s.d, d);
    space_reduce_dense(&s, H, K);
    CHECK_EQ(linear_model_make(&(linear_terms){d, K, none, none, none, 0}, &m, &error), 0);
    memcpy(lambda, m.lambda, n * sizeof *lambda);
    linear_model_free(&m);
    space_free(&s);
    return d;
}

/* A dozen roundings in K and M, amplified by the condition of M: 30 for four links, below 1e4 here. */
#define NEAR(got, want) CHECK_NEAR(got, want, 1e-11 * fabs(want))

static void pendulums_have_their_textbook_frequencies(void)
{
    const double g = 9.81, l = 0.7;
    double lambda[D], gravity[D];
    chain_link link[2] = {{-1, 0, l, DOWN, 2, {0, 0}, 0}, {0, 0, l, DOWN, 2, {0, 0}, 0}};
    chain c = {1, link, 0, 0, g};
    frequencies(&c, lambda);
    NEAR(lambda[0], g / l);
    link[0].spring = 3;
    frequencies(&c, lambda);
    NEAR(lambda[0], g / l + 3 / (2 * l * l));
    link[0] = (chain_link){-1, 0, l, DOWN, 0, {5, 5}, 0}; /* uniform rod: 1/2 g over l/3 */
    frequencies(&c, lambda);
    NEAR(lambda[0], 1.5 * g / l);
    link[0] = (chain_link){-1, 0, l, DOWN, 0, {0, 5}, 0}; /* 1/3 over 1/4 */
    frequencies(&c, lambda);
    NEAR(lambda[0], 4 * g / (3 * l));
    link[0].density[0] = 5, link[0].density[1] = 0; /* 1/6 over 1/12 */
    frequencies(&c, lambda);
    NEAR(lambda[0], 2 * g / l);
    link[0] = (chain_link){-1, 0, l, DOWN, 2, {0, 0}, 0};
    c.link_count = 2;
    frequencies(&c, lambda);
    NEAR(lambda[0], (2 - sqrt(2)) * g / l);
    NEAR(lambda[1], (2 + sqrt(2)) * g / l);
    chain_gradient(&c, (double[]){DOWN, DOWN}, gravity); /* an equilibrium but for pi's rounding */
    CHECK_NEAR(gravity[0], 0, 1e-14);
}

/* Beads on a string: the roots of the Laguerre polynomial L_4 (Abramowitz and Stegun, table 25.9). */
static void a_hanging_chain_has_the_roots_of_laguerre(void)
{
    const double root[4] = {0.322547689619392, 1.745761101158347, 4.536620296921128,
                            9.395070912301133};
    chain_link link[4];
    double lambda[D];
    for (int i = 0; i < 4; i++)
        link[i] = (chain_link){i - 1, 0, 0.25, DOWN, 3, {0, 0}, 0};
    frequencies(&(chain){4, link, 0, 0, 9.81}, lambda);
    for (int i = 0; i < 4; i++)
        NEAR(lambda[i], root[i] * 9.81 / 0.25);
}

/* Two free uniform rods with a spring between them fold with both centres at rest: each turns by half the
 * fold about its centre, m l^2 / 12 twice. */
static void free_rods_fold_about_their_centres(void)
{
    const double l = 0.3, density = 2, mass = l * density;
    chain_link link[2] = {{-1, 0, l, 0.4, 0, {density, density}, 0},
                          {0, 0, l, 0.4, 0, {density, density}, 7}};
    double lambda[D];
    CHECK_EQ(frequencies(&(chain){2, link, 1, 0, 0}, lambda), 4);
    CHECK(lambda[0] == 0 && lambda[1] == 0 && lambda[2] == 0);
    NEAR(lambda[3], 24 * 7 / (mass * l * l));
}

/* Figure 2.2: four links, unit masses and lengths, omega = 1/2. Clamped at one end and straight, the
 * largest and the smallest lambda differ by a factor of 590 whatever omega, length and mass are; what is
 * printed without gravity (0.01 .. 1.25) leaves 125. So the printed bounds are not those of a straight
 * rod; ours are those of scipy's eigh for K = tridiag(-1, 2, -1) / 2, M_ij = 4 - max(i, j). */
static void the_rod_of_figure_2_2(void)
{
    const double weightless[4] = {0.01031779, 0.39740501, 2.5033267, 6.08895051};
    const double hanging[4] = {3.1761785, 17.65804053, 47.42106733, 97.70471365};
    chain_link link[4];
    double lambda[D];
    for (int i = 0; i < 4; i++)
        link[i] = (chain_link){i - 1, 0, 1, DOWN, 1, {0, 0}, 0.5};
    frequencies(&(chain){4, link, 0, 0, 0}, lambda);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(lambda[i], weightless[i], 1e-8);
    CHECK(lambda[3] / lambda[0] > 1.25 / 0.01);
    frequencies(&(chain){4, link, 0, 0, 9.81}, lambda);
    for (int i = 0; i < 4; i++)
        CHECK_NEAR(lambda[i], hanging[i], 1e-8);
}

/* The lamp from its far end: three arms, then the edge {v2, v1} and two of the shade, welded to it. */
static void make_luxo(chain_link link[6])
{
    const double angle[6] = {0.4, 2.0, 0.8, -0.2, 0.1, -0.5};
    for (int i = 0; i < 6; i++)
        link[i] = (chain_link){i < 4 ? i - 1 : 3, i >= 4, i < 3 ? 1.5 : 0.5, angle[i], 0, {1, 1},
                               i ? 0.5 : 0};
}

/* The text says the kernel is the translations, four lambda > 0. With its own energy, which knows angles
 * between edges only, turning the lamp as a whole costs nothing either: three. */
static void luxo_has_three_rigid_motions_and_two_with_its_foot_held_level(void)
{
    chain_link link[6];
    double lambda[D];
    make_luxo(link);
    CHECK_EQ(frequencies(&(chain){6, link, 1, 0, 0}, lambda), 6);
    CHECK(lambda[0] == 0 && lambda[1] == 0 && lambda[2] == 0 && lambda[3] > 1e-3);
    link[0].spring = 0.5;
    frequencies(&(chain){6, link, 1, 0, 0}, lambda);
    CHECK(lambda[0] == 0 && lambda[1] == 0 && lambda[2] > 1e-3);
}

/* ---- checks ------------------------------------------------------------------------------------ */

static void refused(const chain *c, const char *part)
{
    bake_error error = {""};
    CHECK_EQ(chain_check(c, &error), -1);
    CHECK(strstr(error.text, part) != NULL);
    if (!strstr(error.text, part))
        printf("said: %s\n", error.text);
}

static void chains_that_cannot_be_are_refused(void)
{
    chain_link good[3] = {
        {-1, 0, 1, 0, 1, {0, 0}, 0}, {0, 0, 1, 0, 1, {0, 0}, 0}, {1, 0, 1, 0, 0, {1, 0}, 0}};
    chain_link link[3];
    chain c = {3, link, 0, 0, 9.81};
#define WITH(change, part) (memcpy(link, good, sizeof good), (void)(change), refused(&c, part))
    WITH(link[1].parent = 1, "link 2");
    WITH(link[2].length = 0, "link 3");
    WITH(link[2].length = NAN, "link 3");
    WITH(link[0].angle = INFINITY, "link 1");
    WITH(link[1].spring = -1, "link 2");
    WITH(link[2].density[0] = 0, "link 3 can turn");
    WITH((link[0].stiff = link[1].stiff = link[2].stiff = 1), "stiff");
    WITH(c.link_count = 33, "32 links");
    c = (chain){1, link, 1, 0, 0};
    WITH(0, "link 1 can turn"); /* its mass sits at the end, and the root can follow */
    c.root_mass = 1;
    bake_error error = {""};
    CHECK_EQ(chain_check(&c, &error), 0);
    c.root_mass = 0;
    WITH(link[0].end_mass = 0, "no mass");
}

int main(void)
{
    TEST(chains_equal_their_mass_points);
    TEST(pendulums_have_their_textbook_frequencies);
    TEST(a_hanging_chain_has_the_roots_of_laguerre);
    TEST(free_rods_fold_about_their_centres);
    TEST(the_rod_of_figure_2_2);
    TEST(luxo_has_three_rigid_motions_and_two_with_its_foot_held_level);
    TEST(chains_that_cannot_be_are_refused);
    return check_done();
}
