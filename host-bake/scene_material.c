/* What a body is made of: presets, or numbers with their units.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include <string.h>

/* Young's modulus [Pa], Poisson's ratio, density [kg/m^3]. Starting points, not data: of a real
 * thing write its own. Rubber, soft-rubber, silicone: 60, 30 and 20 Shore A by Gent's relation
 * E/MPa = 0.0981 (56 + 7.62336 S) / (0.137505 (254 - 2.54 S)); ratio 0.45 in place of 0.4999,
 * with which linear tetrahedra lock. Wood (along its grain), plastic (ABS), steel, aluminium:
 * mid values of what engineering handbooks list. Foam (soft polyurethane), jelly (gelatine),
 * leather, paper, cotton (a plain weave as a sheet that bends): the usual order of magnitude, no
 * single source. */
static const struct {
    const char *name;
    double young, poisson, density;
} presets[] = {{"rubber", 3.6e6, 0.45, 1100},    {"soft-rubber", 1.1e6, 0.45, 1050},
               {"silicone", 0.73e6, 0.45, 1080}, {"foam", 60e3, 0.3, 40},
               {"jelly", 10e3, 0.45, 1050},      {"leather", 150e6, 0.3, 900},
               {"paper", 4e9, 0.3, 700},         {"cotton", 50e6, 0.3, 400},
               {"wood", 10e9, 0.35, 600},        {"plastic", 2.2e9, 0.39, 1050},
               {"steel", 205e9, 0.29, 7850},     {"aluminium", 70e9, 0.33, 2700}};

static const char material_example[] = "material: {young: 2 MPa, poisson: 0.45, density: 1100}";

static int read_preset(const loader *l, const char *word, scene_body *b)
{
    int found = loader_find(l, "material", "material", word,
                            SCENE_NAMES(presets, sizeof presets / sizeof *presets));
    if (found < 0)
        return -1;
    b->young = presets[found].young;
    b->poisson = presets[found].poisson;
    b->density = presets[found].density;
    return 0;
}

/* A tetrahedron with a ratio of 0.5 has no energy, with -1 no shear; both ends are left out. */
static int read_numbers(const loader *l, scene_body *b)
{
    static const scene_measure young = {"a modulus such as '2 MPa'",
                                        {{"Pa", 1}, {"kPa", 1e3}, {"MPa", 1e6}, {"GPa", 1e9}},
                                        1,
                                        1e13};
    static const scene_measure poisson = {"a ratio such as 0.45", {{NULL, 0}}, -0.99, 0.499};
    static const scene_measure density = {
        "a density such as 1100 or '1100 kg/m3'", {{"kg/m3", 1}}, 1e-3, 1e5};
    static const char *const keys[] = {"young", "poisson", "density", NULL};
    const scene_measure *const measures[3] = {&young, &poisson, &density};
    double *const out[3] = {&b->young, &b->poisson, &b->density};
    if (loader_known(l, keys))
        return -1;
    for (int i = 0; i < 3; i++) {
        const char *text;
        if (loader_scalar(l, keys[i], &text) || loader_need(l, keys[i], text, material_example) ||
            loader_number(l, keys[i], text, measures[i], out[i]))
            return -1;
    }
    return 0;
}

static int read_thickness(const loader *l, const char *text, scene_body *b)
{
    static const struct {
        const char *suffix;
        double metres;
    } units[] = {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}};
    char suffix[LOADER_SUFFIX_BYTES];
    double value = 0, factor = 0;
    if (loader_need(l, "thickness", text, "thickness: 0.5 mm") ||
        loader_quantity(l, "thickness", text, &value, suffix))
        return -1;
    if (suffix[0] == '\0')
        factor = b->unit;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (strcmp(suffix, units[i].suffix) == 0)
            factor = units[i].metres;
    b->thickness = value * factor;
    if (!(b->thickness >= 1e-7 && b->thickness <= 1))
        return loader_fail(
            l, "thickness",
            "'thickness' is '%.40s'; expected a length such as '0.5 mm', from 0.0001 "
            "mm to 1 m, a plain number being in scene units",
            text);
    return 0;
}

int scene_read_material(loader *l)
{
    scene_body *b = &l->out->bodies[l->body];
    int body = l->node, node = scene_tree_find(l->tree, body, "material");
    if (node < 0)
        return loader_fail(l, NULL,
                           "'material' is missing; write for example:  material: rubber  or  %s",
                           material_example);
    const scene_node *found = &l->tree->nodes[node];
    if (found->kind == NODE_SEQUENCE)
        return loader_fail(l, "material", "'material' must be a word or numbers:  %s",
                           material_example);
    if (found->kind == NODE_SCALAR && read_preset(l, found->value, b))
        return -1;
    l->node = node;
    if (found->kind == NODE_MAPPING && read_numbers(l, b))
        return -1;
    l->node = body;
    return b->kind == SCENE_SHELL ? read_thickness(l, l->yaml->bodies[l->body].thickness, b) : 0;
}
