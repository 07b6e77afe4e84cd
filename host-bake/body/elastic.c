/* Elastic bodies: what all kinds have in common, checked here once; then solid.c or shell.c.
 * Source: Schulz 2013, 2.3. The masses are those of the rest shape: the thesis writes M(x), with
 * the areas and volumes of the deformed shape, but a body has the same mass however it is deformed.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "elastic_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* With young > 0 and poisson in (-1, 0.5): mu = young / (2 + 2 poisson) > 0 and
 * 3 lambda + 2 mu = young / (1 - 2 poisson) > 0, which makes the energy convex about rest. */
static int check_material(const body *b, bake_error *error)
{
    const body_material *m = &b->material;
    if (!(m->young > 0) || !isfinite(m->young))
        return bake_fail(error, "Young's modulus is %g Pa: it has to be positive", m->young);
    if (!(m->poisson > -1 && m->poisson < 0.5))
        return bake_fail(error,
                         "Poisson's ratio is %g: it has to lie between -1 and 0.5, both excluded",
                         m->poisson);
    if (!(m->density > 0) || !isfinite(m->density))
        return bake_fail(error, "the density is %g kg/m^3: it has to be positive", m->density);
    if (b->kind == BODY_SHELL && (!(m->thickness > 0) || !isfinite(m->thickness)))
        return bake_fail(error, "the thickness is %g m: it has to be positive", m->thickness);
    return 0;
}

static const char *element_name(const body *b)
{
    return b->kind == BODY_SOLID ? "tetrahedron" : "triangle";
}

static int check_element(const body *b, int e, char *used, bake_error *error)
{
    int corners = b->kind == BODY_SOLID ? 4 : 3;
    for (int i = 0; i < corners; i++) {
        int v = b->element[e][i];
        if (v < 0 || v >= b->vertex_count)
            return bake_fail(error, "%s %d has vertex %d, the body has %d vertices",
                             element_name(b), e, v, b->vertex_count);
        used[v] = 1;
        for (int j = 0; j < i; j++)
            if (b->element[e][j] == v)
                return bake_fail(error, "%s %d has vertex %d twice", element_name(b), e, v);
    }
    return 0;
}

static int check_vertices(const body *b, const char *used, bake_error *error)
{
    for (int v = 0; v < b->vertex_count; v++) {
        const double *x = &b->rest[3 * v];
        if (!isfinite(x[0]) || !isfinite(x[1]) || !isfinite(x[2]))
            return bake_fail(error, "vertex %d has a coordinate that is no number", v);
        if (!used[v])
            return bake_fail(error, "vertex %d at (%g, %g, %g) m belongs to no %s: remove it", v,
                             x[0], x[1], x[2], element_name(b));
    }
    return 0;
}

static int check_mesh(const body *b, bake_error *error)
{
    if (b->vertex_count < 1 || b->element_count < 1)
        return bake_fail(error, "a body of %d vertices and %d elements", b->vertex_count,
                         b->element_count);
    char *used = bake_alloc((size_t)b->vertex_count, 1);
    int failed = 0;
    for (int e = 0; e < b->element_count && !failed; e++)
        failed = check_element(b, e, used, error);
    if (!failed)
        failed = check_vertices(b, used, error);
    free(used);
    return failed;
}

static void forget(body *b)
{
    free(b->mass);
    free(b->elements);
    b->mass = NULL;
    b->elements = NULL;
}

int body_prepare(body *b, bake_error *error)
{
    forget(b);
    if (check_material(b, error) || check_mesh(b, error))
        return -1;
    b->mass = bake_alloc((size_t)b->vertex_count, sizeof *b->mass);
    int failed = b->kind == BODY_SOLID ? solid_prepare(b, error) : shell_prepare(b, error);
    if (failed)
        forget(b);
    return failed;
}

void body_free(body *b)
{
    forget(b);
    free(b->rest);
    free(b->element);
    memset(b, 0, sizeof *b);
}

double body_energy(const body *b, const double *x)
{
    return b->kind == BODY_SOLID ? solid_energy(b, x) : shell_energy(b, x);
}

void body_gradient(const body *b, const double *x, double *gradient)
{
    memset(gradient, 0, 3 * (size_t)b->vertex_count * sizeof *gradient);
    if (b->kind == BODY_SOLID)
        solid_gradient(b, x, gradient);
    else
        shell_gradient(b, x, gradient);
}

void body_hessian(const body *b, const double *x, body_blocks *out)
{
    if (b->kind == BODY_SOLID)
        solid_hessian(b, x, out);
    else
        shell_hessian(b, x, out);
}

/* ---- blocks ---------------------------------------------------------------------------------- */

body_block *body_blocks_room(body_blocks *list, size_t count)
{
    if (list->room - list->count < count) {
        size_t grown = list->room + list->room / 2;
        list->room = grown > list->count + count ? grown : list->count + count;
        list->at = bake_grow(list->at, list->room, sizeof *list->at);
    }
    body_block *first = list->at + list->count;
    memset(first, 0, count * sizeof *first);
    list->count += count;
    return first;
}

void body_blocks_add(body_blocks *list, int a, int b, const double k[9])
{
    body_block *block = body_blocks_room(list, 1);
    int turned = a < b;
    block->a = turned ? b : a;
    block->b = turned ? a : b;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            block->k[3 * i + j] = turned ? k[3 * j + i] : k[3 * i + j];
}

void body_blocks_free(body_blocks *list)
{
    free(list->at);
    memset(list, 0, sizeof *list);
}
