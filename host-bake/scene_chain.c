/* Bodies of kind chain: their links, root and width.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "chain.h"
#include "scene_load.h"

#include "wiggly_format.h"

static const char link_example[] =
    "- {name: arm, parent: base, length: 40, angle: 60 deg, mass: 20 g, spring: 0.02}";

/* In grams, as a plain number is; stored in kilograms. */
static int read_mass(const loader *l, const char *field, const char *text, double *out)
{
    static const scene_measure mass = {
        "a mass such as 20, '20 g' or '0.02 kg'", {{"g", 1}, {"kg", 1000}}, 0, 1e9};
    double grams = 0;
    if (loader_number(l, field, text, &mass, &grams))
        return -1;
    *out = grams * 1e-3;
    return 0;
}

/* Grams a scene unit, stored in kg/m. */
static int read_density(const loader *l, scene_link *to)
{
    static const scene_measure density = {
        "grams a scene unit of length, such as 0.5", {{NULL, 0}}, 0, 1e9};

    if (loader_numbers(l, "density", 2, &density, to->density))
        return -1;
    for (int i = 0; i < 2; i++)
        to->density[i] *= 1e-3 / l->out->bodies[l->body].unit;
    return 0;
}

static int read_place(const loader *l, const yaml_link *from, int index, scene_link *to)
{
    const scene_body *b = &l->out->bodies[l->body];
    char hint[SCENE_HINT_BYTES];
    scene_names before = SCENE_NAMES(b->links, index);
    to->parent = -1;
    if (from->parent == NULL)
        return 0;
    to->parent = index > 0 ? scene_names_find(&before, from->parent) : -1;
    if (to->parent < 0)
        return loader_fail(
            l, "parent",
            "there is no link '%.60s' before this one, and a parent comes before its "
            "links; %s",
            from->parent, scene_names_hint(&before, from->parent, hint));
    return 0;
}

int scene_read_link(loader *l, int index)
{
    static const scene_measure length = {"a length such as 40", {{NULL, 0}}, 1e-6, 1e6};
    static const scene_measure spring = {
        "a stiffness in N m/rad such as 0.02", {{NULL, 0}}, 0, 1e9};
    const yaml_body *y = &l->yaml->bodies[l->body];
    const yaml_link *from = &y->links[index];
    scene_link *to = &l->out->bodies[l->body].links[index];
    to->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_name(l, SCENE_NAMES(y->links, y->links_count), index, link_example, &to->name) ||
        read_place(l, from, index, to) || loader_flag(l, "stiff", from->stiff, &to->stiff) ||
        loader_need(l, "length", from->length, link_example) ||
        loader_number(l, "length", from->length, &length, &to->length) ||
        loader_need(l, "angle", from->angle, link_example) ||
        loader_number(l, "angle", from->angle, &scene_value[WG_UNIT_DEGREE][0], &to->angle) ||
        read_mass(l, "mass", from->mass, &to->mass) || read_density(l, to) ||
        loader_number(l, "spring", from->spring, &spring, &to->spring))
        return -1;
    if (to->stiff && from->spring != NULL)
        return loader_fail(l, "spring",
                           "the link '%s' is stiff, so its joint has no spring; keep 'stiff' or "
                           "'spring'",
                           to->name);
    return 0;
}

static int read_root(const loader *l, const yaml_body *from, scene_body *b)
{
    if (loader_flag(l, "free_root", from->free_root, &b->free_root) ||
        read_mass(l, "root_mass", from->root_mass, &b->root_mass))
        return -1;
    if (from->root_mass != NULL && !b->free_root)
        return loader_fail(l, "root_mass",
                           "a root that does not move needs no mass; write 'free_root: true' or "
                           "remove 'root_mass'");
    if (b->gravity[0] < 0 || b->gravity[0] > 0 || b->gravity[2] < 0 || b->gravity[2] > 0)
        return loader_fail(l, "gravity",
                           "gravity pulls a chain along y only:  gravity: [0, -9.81, 0]");
    return 0;
}

int scene_read_chain(loader *l)
{
    static const scene_measure width = {"a width such as 4", {{NULL, 0}}, 1e-6, 1e6};
    const yaml_body *from = &l->yaml->bodies[l->body];
    scene_body *b = &l->out->bodies[l->body];
    if (from->links_count == 0)
        return loader_fail(l, "links", "a chain needs 'links'; write for example:  links: [%s]",
                           link_example + 2);
    if (from->links_count > CHAIN_LINKS_MAX)
        return loader_fail(l, "links", "'links' has %u entries; a chain has at most %d",
                           from->links_count, CHAIN_LINKS_MAX);
    b->link_count = (int)from->links_count;
    b->links = bake_alloc(from->links_count, sizeof *b->links);
    if (read_root(l, from, b) || loader_each(l, "links", scene_read_link))
        return -1;
    for (int i = 0; i < b->link_count; i++)
        b->width += 0.1 * b->links[i].length / b->link_count;
    if (from->width != NULL && b->mesh < 0)
        return loader_fail(l, "width",
                           "'width' is that of bars, and without a 'mesh' none are drawn");
    return loader_number(l, "width", from->width, &width, &b->width);
}
