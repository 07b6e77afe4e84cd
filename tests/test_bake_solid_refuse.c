/* Solids that cannot be: meshes and materials that body_prepare refuses, with the reason.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "body_shapes.h"
#include "check.h"
#include <lapacke.h>
#include <string.h>

static body one_cell(void)
{
    body b = {.material = {.young = 1, .poisson = 0.3, .density = 1}};
    box_tets(&b, (double[]){1, 1, 1}, (int[]){1, 1, 1});
    return b;
}

static void check_refused(body *b, const char *why)
{
    bake_error error = {{0}};
    CHECK(body_prepare(b, &error) == -1);
    CHECK(strstr(error.text, why) != NULL);
    CHECK(b->mass == NULL && b->elements == NULL);
    if (!strstr(error.text, why))
        printf("%s\n", error.text);
    body_free(b);
}

static void bad_meshes_are_refused(void)
{
    body b = one_cell();
    b.element[4][2] = b.vertex_count;
    check_refused(&b, "tetrahedron 4 has vertex 8");
    b = one_cell();
    b.element[4][2] = b.element[4][1];
    check_refused(&b, "twice");
    b = one_cell();
    b.element_count = 2;
    check_refused(&b, "belongs to no tetrahedron");
    b = one_cell();
    b.rest[7] = NAN;
    check_refused(&b, "no number");
    b = one_cell();
    int swap = b.element[3][0];
    b.element[3][0] = b.element[3][1];
    b.element[3][1] = swap;
    check_refused(&b, "tetrahedron 3 at");
    b = one_cell();
    for (int i = 0; i < 3; i++) /* a corner onto the opposite one's face */
        b.rest[3 * b.element[0][0] + i] = b.rest[3 * b.element[0][1] + i] + 1e-13;
    check_refused(&b, "has no volume");
    b = one_cell();
    b.element_count = 0;
    check_refused(&b, "0 elements");
}

static void bad_materials_are_refused(void)
{
    static const struct {
        body_material material;
        const char *why;
    } bad[] = {
        {{0, 0.3, 1, 0}, "Young's modulus"},   {{-1, 0.3, 1, 0}, "Young's modulus"},
        {{NAN, 0.3, 1, 0}, "Young's modulus"}, {{HUGE_VAL, 0.3, 1, 0}, "Young's modulus"},
        {{1, 0.5, 1, 0}, "Poisson's ratio"},   {{1, -1, 1, 0}, "Poisson's ratio"},
        {{1, NAN, 1, 0}, "Poisson's ratio"},   {{1, 0.3, 0, 0}, "density"},
        {{1, 0.3, -1000, 0}, "density"},       {{1, 0.3, NAN, 0}, "density"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        body b = one_cell();
        b.material = bad[i].material;
        check_refused(&b, bad[i].why);
    }
    body b = one_cell();
    bake_error error;
    b.material.poisson = 0.499;
    CHECK(body_prepare(&b, &error) == 0);
    body_free(&b);
}

int main(void)
{
    TEST(bad_meshes_are_refused);
    TEST(bad_materials_are_refused);
    return check_done();
}
