/* What frequencies do not depend on, and how many rigid motions a body has that is held in parts.
 * SPDX-License-Identifier: MIT */
#include "bench_meshes.h"
#include "body_modes.h"

#include <stdlib.h>
#include <string.h>

/* ---- scales -------------------------------------------------------------------------------------- */

static void scaled(body_kind kind, const body_material *material, double scale, double lambda[20])
{
    body b = {0};
    modes m;
    if (kind == BODY_SOLID)
        box_tets(&b, (const double[]){0.3, 0.2, 0.1}, (const int[]){6, 4, 2});
    else
        sheet_triangles(&b, (const double[]){0.3, 0.2}, (const int[]){12, 8}, 1);
    b.material = *material;
    b.material.thickness *= scale;
    for (int i = 0; i < 3 * b.vertex_count; i++)
        b.rest[i] *= scale;
    modes_of(&b, all_free, 20, &m);
    memcpy(lambda, m.lambda, 20 * sizeof *lambda);
    modes_free(&m);
    body_free(&b);
}

/* Powers of two change no rounding, nor do roots of powers of four: masses are taken the root of. */
static void frequencies_scale_to_the_last_bit(void)
{
    static const struct {
        double young, density, scale, lambda;
    } factor[4] = {{4, 1, 1, 4}, {1, 4, 1, 0.25}, {1, 1, 4, 0.0625}, {16, 4, 4, 0.25}};
    for (body_kind kind = BODY_SOLID; kind <= BODY_SHELL; kind++) {
        body_material m = {1e6, 0.3, 1000, kind == BODY_SOLID ? 0 : 5e-3};
        double plain[20], lambda[20];
        scaled(kind, &m, 1, plain);
        for (int i = 0; i < 4; i++) {
            body_material other = m;
            other.young *= factor[i].young;
            other.density *= factor[i].density;
            scaled(kind, &other, factor[i].scale, lambda);
            for (int k = 0; k < 20; k++)
                CHECK(lambda[k] == factor[i].lambda * plain[k]);
        }
    }
}

/* ---- what is left to move ------------------------------------------------------------------------ */

static void fix_corner(const body *b, freedom *f)
{
    freedom_make(b->vertex_count, f);
    freedom_fix(f, 0);
}

static void fix_edge(const body *b, freedom *f)
{
    freedom_make(b->vertex_count, f);
    for (int i = 0; i < b->vertex_count; i++)
        if (b->rest[3 * i] == 0 && b->rest[3 * i + 1] == 0)
            freedom_fix(f, i);
}

static void slide_on_floor(const body *b, freedom *f)
{
    freedom_make(b->vertex_count, f);
    for (int i = 0; i < b->vertex_count; i++)
        if (b->rest[3 * i + 2] == 0)
            freedom_slide(f, i, (const double[]){0, 0, 1});
}

static void slide_in_corner(const body *b, freedom *f)
{
    slide_on_floor(b, f);
    for (int i = 0; i < b->vertex_count; i++)
        if (b->rest[3 * i] == 0)
            freedom_slide(f, i, (const double[]){1, 0, 0});
}

static void check_rigid(body *b, void (*hold)(const body *, freedom *), int rigid)
{
    modes m;
    modes_of(b, hold, rigid + 4, &m);
    CHECK_EQ(m.rigid, rigid);
    CHECK_EQ(m.negative, 0);
    for (int i = 0; i < m.count; i++)
        CHECK(m.residual[i] <= 1e-8);
    modes_free(&m);
    body_free(b);
}

static body block(void)
{
    body b = {.material = {1e6, 0.3, 1000, 0}};
    box_tets(&b, (const double[]){0.3, 0.2, 0.1}, (const int[]){9, 6, 4});
    return b;
}

/* A second one beside the first. */
static body two_blocks(void)
{
    body b = block(), other = block();
    int n = b.vertex_count, e = b.element_count;
    b.rest = bake_grow(b.rest, 6 * (size_t)n, sizeof *b.rest);
    b.element = bake_grow(b.element, 2 * (size_t)e, sizeof *b.element);
    for (int i = 0; i < 3 * n; i++)
        b.rest[3 * n + i] = other.rest[i] + (i % 3 == 1);
    for (int i = 0; i < 4 * e; i++)
        b.element[e + i / 4][i % 4] = n + other.element[i / 4][i % 4];
    b.vertex_count *= 2;
    b.element_count *= 2;
    body_free(&other);
    return b;
}

static void what_holds_a_body_takes_its_rigid_motions(void)
{
    body b = block();
    check_rigid(&b, all_free, 6);
    b = block();
    check_rigid(&b, fix_corner, 3);
    b = block();
    check_rigid(&b, fix_edge, 1);
    b = block();
    check_rigid(&b, slide_on_floor, 3);
    b = block();
    check_rigid(&b, slide_in_corner, 1);
    b = block();
    check_rigid(&b, hold_left, 0);
    b = two_blocks();
    check_rigid(&b, all_free, 12);
}

/* A closed box of sheet, and the same sheet as a bowl is not flat: membranes and bending act together. */
static void a_closed_shell_has_six_rigid_motions(void)
{
    body b = {.material = {1e6, 0.3, 1000, 2e-3}};
    box_surface(&b, (const double[]){0.3, 0.2, 0.1}, (const int[]){12, 8, 4});
    check_rigid(&b, all_free, 6);
    b = (body){.material = {1e6, 0.3, 1000, 2e-3}};
    mesh_bug(&b);
    check_rigid(&b, all_free, 6);
}

int main(void)
{
    TEST(frequencies_scale_to_the_last_bit);
    TEST(what_holds_a_body_takes_its_rigid_motions);
    TEST(a_closed_shell_has_six_rigid_motions);
    return check_done();
}
