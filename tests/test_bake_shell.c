/* Shells against the high-precision oracle and against differences of the energy, what
 * rigid motions and winding must not change, and what is refused.
 * Source: host-bake/body/shell.c; vectors from tests/reference/shell_oracle.py.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shell_sheets.h"

#include <lapacke.h>

#define CORNER 6 /* most vertices of a case */

static double largest(const double *v, size_t count)
{
    double out = 0;
    for (size_t i = 0; i < count; i++)
        out = fmax(out, fabs(v[i]));
    return out;
}

/* ---- oracle ---------------------------------------------------------------------------------- */

typedef struct {
    char name[64];
    body b;
    double energy, at[3 * CORNER], mass[CORNER], gradient[3 * CORNER], H[9 * CORNER * CORNER];
} oracle;

static int numbers(FILE *file, const char *kind, double *out, int count)
{
    static char line[1024];
    char *text = fgets(line, sizeof line, file);
    if (!text || strncmp(line, kind, strlen(kind)) != 0)
        return 0;
    text += strlen(kind);
    for (int i = 0; i < count; i++) {
        if (*text++ != ',')
            return 0;
        out[i] = strtod(text, &text);
    }
    return 1;
}

static int read_mesh(FILE *file, oracle *c, int vertices, int triangles)
{
    double v[10], rest[3 * CORNER];
    int corner[CORNER][3];
    for (int t = 0; t < triangles; t++) {
        if (!numbers(file, "triangle", v, 3))
            return 0;
        for (int i = 0; i < 3; i++)
            corner[t][i] = (int)v[i];
    }
    for (int i = 0; i < vertices; i++) {
        if (!numbers(file, "vertex", v, 10))
            return 0;
        memcpy(&rest[3 * i], v, 3 * sizeof *v);
        memcpy(&c->at[3 * i], v + 3, 3 * sizeof *v);
        memcpy(&c->gradient[3 * i], v + 7, 3 * sizeof *v);
        c->mass[i] = v[6];
    }
    make(&c->b, vertices, rest, triangles, (const int(*)[3])corner);
    for (int i = 0; i < 3 * vertices; i++)
        if (!numbers(file, "row", &c->H[3 * vertices * i], 3 * vertices))
            return 0;
    return 1;
}

static int read_case(FILE *file, oracle *c)
{
    char line[256];
    int vertices, triangles;
    body_material m;
    do
        if (!fgets(line, sizeof line, file))
            return 0;
    while (line[0] == '#');
    if (sscanf(line, "case,%63[^,],%d,%d,%lf,%lf,%lf,%lf,%lf", c->name, &vertices, &triangles,
               &m.young, &m.poisson, &m.density, &m.thickness, &c->energy) != 8 ||
        vertices > CORNER || triangles > CORNER || !read_mesh(file, c, vertices, triangles))
        return 0;
    prepare(&c->b, &m);
    return 1;
}

/* Meshes of size 1, so the largest entry of the Hessian is also the unit of forces and energies. A
 * component function is some 50 roundings of 1.1e-16, grown by the thinnest triangle (height 1/4 of
 * a side, which enters the angle's second derivative squared): 50 * 16 * 1.1e-16 = 9e-14. Measured:
 * 7e-16. */
static void check_case(oracle *c)
{
    size_t n = 3 * (size_t)c->b.vertex_count;
    double unit = largest(c->H, n * n), g[3 * CORNER], *H = dense(&c->b, c->at);
    int before = check_ok;
    check_ok = 1;
    CHECK_NEAR(body_energy(&c->b, c->at), c->energy, 1e-13 * unit);
    body_gradient(&c->b, c->at, g);
    for (size_t i = 0; i < n; i++)
        CHECK_NEAR(g[i], c->gradient[i], 1e-13 * unit);
    for (size_t i = 0; i < n * n; i++)
        CHECK_NEAR(H[i], c->H[i], 1e-13 * unit);
    for (int v = 0; v < c->b.vertex_count; v++)
        CHECK_NEAR(c->b.mass[v], c->mass[v], 1e-14 * c->mass[v]);
    if (!check_ok)
        printf("case %s\n", c->name);
    check_ok &= before;
    free(H);
}

static void derivatives_match_the_oracle(void)
{
    FILE *file = fopen("tests/vectors/shell_oracle.csv", "r");
    int count = 0;
    CHECK(file != NULL);
    if (!file)
        return;
    for (oracle c; read_case(file, &c); count++) {
        check_case(&c);
        body_free(&c.b);
    }
    CHECK_EQ(count, 14);
    CHECK(feof(file));
    fclose(file);
}

/* ---- derivatives and invariance -------------------------------------------------------------- */

/* A sheet rolled so tightly that 14 hinges turn by 90 to 108 degrees, and shaken by a tenth of an
 * edge. */
static double *crumple(body *b, const body_material *m)
{
    sheet_triangles(b, (const double[2]){1, 0.7}, (const int[2]){4, 3}, 1);
    b->mass = NULL;
    b->elements = NULL;
    prepare(b, m);
    return rolled(b, 0.08, 0.025);
}

/* A central difference with step s errs by s^2/6 of the third derivative of what is differenced,
 * here 1/height^2 = 100 times the first: 1e-10/6 * 100 = 2e-9 of the unit at s = 1e-5; and by its
 * rounding over the step, 1e-13/1e-5 = 1e-8. */
static void derivatives_are_those_of_the_energy(void)
{
    body b;
    double *x = crumple(&b, &materials[RUBBER]), step = 1e-5;
    size_t n = 3 * (size_t)b.vertex_count;
    double *H = dense(&b, x), unit = largest(H, n * n);
    double *g = bake_alloc(3 * n, sizeof *g), *up = g + n, *down = up + n;
    body_gradient(&b, x, g);
    for (size_t i = 0; i < n; i++) {
        double at = x[i];
        x[i] = at + step;
        double energy = body_energy(&b, x);
        body_gradient(&b, x, up);
        x[i] = at - step;
        energy -= body_energy(&b, x);
        body_gradient(&b, x, down);
        x[i] = at;
        CHECK_NEAR(g[i], energy / (2 * step), 2e-8 * unit);
        for (size_t j = 0; j < n; j++)
            CHECK_NEAR(H[i * n + j], (up[j] - down[j]) / (2 * step), 2e-8 * unit);
    }
    free(g);
    free(H);
    free(x);
    body_free(&b);
}

/* About an axis of length 1, then moved. */
static void rigid(double *x, int vertices, double turn)
{
    const double u[3] = {0.6, 0, 0.8}, shift[3] = {1, -2, 0.5};
    for (int v = 0; v < vertices; v++) {
        double *p = &x[3 * v], along = u[0] * p[0] + u[1] * p[1] + u[2] * p[2];
        double across[3] = {u[1] * p[2] - u[2] * p[1], u[2] * p[0] - u[0] * p[2],
                            u[0] * p[1] - u[1] * p[0]};
        for (int i = 0; i < 3; i++)
            p[i] =
                along * u[i] + cos(turn) * (p[i] - along * u[i]) + sin(turn) * across[i] + shift[i];
    }
}

/* Coordinates grow to 10 and are rounded to 1e-15: strains of size 1 in edges of 0.25, and angles,
 * to some 1e-14 in each of four moves, energies to twice that. */
static void energy_ignores_rigid_motions(void)
{
    body b;
    double *x = crumple(&b, &materials[RUBBER]), energy = body_energy(&b, x);
    for (int i = 0; i < 4; i++) {
        rigid(x, b.vertex_count, 0.9 + i);
        CHECK_NEAR(body_energy(&b, x), energy, 1e-12 * energy);
    }
    free(x);
    body_free(&b);
}

/* At rest forces and energy vanish exactly: displacements are 0, and angles are computed as they
 * were for the rest. Eigenvalues are exact to some 1e-15 of the largest; elastic ones are
 * (thickness/size)^2 of it, 4e-7 for steel as measured. The bent sheets have obtuse triangles. */
static void rest_is_a_minimum_free_to_move_rigidly(void)
{
    for (int m = 0; m < MATERIALS; m++) {
        body b;
        sheet_triangles(&b, (const double[2]){1, 0.7}, (const int[2]){5, 3}, m % 2);
        b.mass = NULL;
        b.elements = NULL;
        double *bent = rolled(&b, 0.4, 0);
        memcpy(b.rest, bent, 3 * (size_t)b.vertex_count * sizeof *bent);
        b.rest[3 * 8] += 0.12; /* an inner vertex nearly on the line of two others */
        prepare(&b, &materials[m]);
        size_t n = 3 * (size_t)b.vertex_count;
        double *H = dense(&b, b.rest), *lambda = bake_alloc(n, sizeof *lambda);
        body_gradient(&b, b.rest, lambda);
        CHECK(body_energy(&b, b.rest) == 0 && largest(lambda, n) == 0);
        CHECK_EQ(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'U', (int)n, H, (int)n, lambda), 0);
        CHECK(fabs(lambda[0]) < 1e-13 * lambda[n - 1] && lambda[5] < 1e-13 * lambda[n - 1]);
        CHECK(lambda[6] > 1e-9 * lambda[n - 1]);
        free(lambda);
        free(H);
        free(bent);
        body_free(&b);
    }
}

static void winding_of_triangles_does_not_matter(void)
{
    body b;
    double *x = crumple(&b, &materials[CORK]), energy = body_energy(&b, x);
    for (int t = 0; t < b.element_count; t += 3) {
        int swap = b.element[t][0];
        b.element[t][0] = b.element[t][1];
        b.element[t][1] = swap;
    }
    prepare(&b, &materials[CORK]);
    CHECK_NEAR(body_energy(&b, x), energy, 1e-13 * energy);
    free(x);
    body_free(&b);
}

/* ---- what is refused ------------------------------------------------------------------------- */

static int refuses(int vertices, const double *rest, int triangles, const int (*corner)[3],
                   const char *words)
{
    body b;
    bake_error error = {""};
    make(&b, vertices, rest, triangles, corner);
    b.material = materials[RUBBER];
    int failed = body_prepare(&b, &error) != 0 && strstr(error.text, words) != NULL;
    if (!failed)
        printf("\"%s\" does not say \"%s\"\n", error.text, words);
    body_free(&b);
    return failed;
}

static void broken_meshes_are_refused_by_name(void)
{
    const double rest[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0.5, 0.5, 0, 1};
    CHECK(refuses(5, rest, 3, (const int[3][3]){{0, 1, 2}, {3, 1, 0}, {0, 1, 4}},
                  "edge of vertices 0 and 1 has more than two triangles (0, 1, 2)"));
    CHECK(refuses(3, rest, 2, (const int[2][3]){{0, 1, 2}, {2, 1, 0}},
                  "triangles 0 and 1 have the same vertices"));
    const double line[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.5, 0.5, 0};
    CHECK(refuses(4, line, 2, (const int[2][3]){{0, 1, 2}, {2, 1, 3}},
                  "triangle 1 at (0, 1, 0) m has no area"));
}

static void energy_is_infinite_without_area(void)
{
    const double rest[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, flat[9] = {0, 0, 0, 1, 0, 0, 0.5, 0, 0};
    body b;
    make(&b, 3, rest, 1, (const int[1][3]){{0, 1, 2}});
    prepare(&b, &materials[RUBBER]);
    CHECK(body_energy(&b, flat) == HUGE_VAL);
    body_free(&b);
}

int main(void)
{
    TEST(derivatives_match_the_oracle);
    TEST(derivatives_are_those_of_the_energy);
    TEST(energy_ignores_rigid_motions);
    TEST(rest_is_a_minimum_free_to_move_rigidly);
    TEST(winding_of_triangles_does_not_matter);
    TEST(broken_meshes_are_refused_by_name);
    TEST(energy_is_infinite_without_area);
    return check_done();
}
