/* Regions of bodies and rigs, what of them is held, and how far they are moved.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { VERTEX_MAX = 10000000 };

const scene_measure scene_way = {"a number of scene units such as 10", {{NULL, 0}}, -1e6, 1e6};
const scene_measure scene_speed = {
    "a number of scene units a second such as 500", {{NULL, 0}}, -1e9, 1e9};

static const char region_example[] = "- {name: tip, ball: {centre: [0, 90, 0], radius: 5}}";
static const char slide_example[] = "sliding: [{region: base, normal: y}]";
static const char shift_example[] = "{region: tip, by: [10, 0, 0]}";
static const char turn_example[] = "turn: {axis: z, angle: 20}";

static scene_body *current(const loader *l)
{
    return &l->out->bodies[l->body];
}

int scene_read_region_name(const loader *l, const char *text, int all, int *out)
{
    const scene_body *b = current(l);
    if (text == NULL)
        return 0;
    if (strcmp(text, "everything") == 0) {
        *out = -1;
        return all ? 0
                   : loader_fail(l, "region",
                                 "'everything' cannot be held, for then nothing would move; name "
                                 "a region");
    }
    if (b->region_count == 0)
        return loader_fail(l, "region",
                           "there is no region '%.60s'; give the body '%s' one, for example:  "
                           "regions: [{name: %.60s, above: {y: 20}}]",
                           text, b->name, text);
    return loader_reference(l, "region", text, SCENE_NAMES(b->regions, b->region_count), out);
}

/* Corners in the tree: a list of two lists. */
static int read_box(loader *l, scene_region *to)
{
    int node = scene_tree_find(l->tree, l->node, "box");
    const scene_node *list = &l->tree->nodes[node];
    int good = list->kind == NODE_SEQUENCE && list->child_count == 2;
    to->box[0][2] = -HUGE_VAL;
    to->box[1][2] = HUGE_VAL;
    for (int i = 0, corner = good ? list->child : -1; good && i < 2; i++) {
        const scene_node *at = &l->tree->nodes[corner];
        good = at->kind == NODE_SEQUENCE &&
               (at->child_count == 3 || (at->child_count == 2 && l->flat));
        for (int k = 0, child = good ? at->child : -1; good && k < at->child_count; k++) {
            const scene_node *entry = &l->tree->nodes[child];
            good = entry->kind == NODE_SCALAR;
            if (good && loader_number(l, "box", entry->value, &scene_way, &to->box[i][k]))
                return -1;
            child = entry->next;
        }
        corner = at->next;
    }
    if (!good)
        return loader_fail(l, "box",
                           "'box' must be two opposite corners:  box: [[-10, 0, -10], [10, 2, "
                           "10]]");
    for (int k = 0; k < 3; k++)
        if (to->box[0][k] > to->box[1][k])
            return loader_fail(l, "box",
                               "'box' must ascend: its first corner has %c = %g, its second %g",
                               'x' + k, to->box[0][k], to->box[1][k]);
    return 0;
}

/* One side of the half spaces that above (0) and below (1) bound. */
static int read_half(loader *l, const char *field, const yaml_axes *from, int side,
                     scene_region *to)
{
    if (from == NULL)
        return 0;
    const char *const text[3] = {from->x, from->y, from->z};
    static const char *const axes[3] = {"x", "y", "z"};
    int outer = l->node, count = 0;
    l->node = scene_tree_find(l->tree, outer, field);
    for (int k = 0; k < 3; k++) {
        count += text[k] != NULL;
        if (loader_number(l, axes[k], text[k], &scene_way, &to->box[side][k]))
            return -1;
    }
    l->node = outer;
    if (count == 0)
        return loader_fail(l, field, "'%s' names no axis; write for example:  %s: {y: 20}", field,
                           field);
    return 0;
}

static int read_halves(loader *l, const yaml_region *from, scene_region *to)
{
    for (int k = 0; k < 3; k++) {
        to->box[0][k] = -HUGE_VAL;
        to->box[1][k] = HUGE_VAL;
    }
    if (read_half(l, "above", from->above, 0, to) || read_half(l, "below", from->below, 1, to))
        return -1;
    for (int k = 0; k < 3; k++)
        if (to->box[0][k] > to->box[1][k])
            return loader_fail(l, "below", "nothing is above %c = %g and below %g", 'x' + k,
                               to->box[0][k], to->box[1][k]);
    return 0;
}

static int read_ball(loader *l, const yaml_ball *from, scene_region *to)
{
    static const scene_measure radius = {"a radius such as 5", {{NULL, 0}}, 1e-6, 1e6};

    const char *example = "ball: {centre: [0, 90, 0], radius: 5}";
    int outer = l->node;
    l->node = scene_tree_find(l->tree, outer, "ball");
    if (from->centre == NULL)
        return loader_fail(l, NULL, "'centre' is missing; write for example:  %s", example);
    if ((l->flat ? loader_place(l, "centre", to->centre)
                 : loader_numbers(l, "centre", 3, &scene_way, to->centre)) ||
        loader_need(l, "radius", from->radius, example) ||
        loader_number(l, "radius", from->radius, &radius, &to->radius))
        return -1;
    l->node = outer;
    return 0;
}

static int ascending(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

static int read_vertices(loader *l, const yaml_region *from, scene_region *to)
{
    static const int range[2] = {0, VERTEX_MAX};
    if (from->vertices_count == 0)
        return loader_fail(l, "vertices", "'vertices' is empty; write for example:  [0, 3, 8]");
    to->vertex_count = (int)from->vertices_count;
    to->vertex = bake_alloc(from->vertices_count, sizeof *to->vertex);
    for (int i = 0; i < to->vertex_count; i++)
        if (loader_integer(l, "vertices", from->vertices[i], range, &to->vertex[i]))
            return -1;
    qsort(to->vertex, from->vertices_count, sizeof *to->vertex, ascending);
    for (int i = 1; i < to->vertex_count; i++)
        if (to->vertex[i] == to->vertex[i - 1])
            return loader_fail(l, "vertices", "'vertices' names %d twice", to->vertex[i]);
    return 0;
}

int scene_read_region_form(loader *l, const yaml_region *from, const char *example,
                           scene_region *to)
{
    to->line = scene_tree_line(l->tree, l->node, NULL);
    int half = from->above != NULL || from->below != NULL, box = loader_has(l, "box");
    int kinds = half + box + (from->ball != NULL) + loader_has(l, "vertices");
    if (kinds != 1)
        return loader_fail(
            l, NULL,
            "a region is one of 'box', 'ball', 'vertices', or 'above' and 'below'%s; "
            "write for example:  %s",
            kinds > 1 ? ", not several" : "", example);
    to->kind = from->ball != NULL          ? REGION_BALL
               : loader_has(l, "vertices") ? REGION_VERTICES
                                           : REGION_BOX;
    return half                      ? read_halves(l, from, to)
           : box                     ? read_box(l, to)
           : to->kind == REGION_BALL ? read_ball(l, from->ball, to)
                                     : read_vertices(l, from, to);
}

int scene_read_region(loader *l, int index)
{
    const yaml_body *y = &l->yaml->bodies[l->body];
    scene_region *to = &current(l)->regions[index];
    to->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_name(l, SCENE_NAMES(y->regions, y->regions_count), index, region_example, &to->name))
        return -1;
    if (strcmp(to->name, "everything") == 0)
        return loader_fail(l, "name", "'everything' is all of a body already; choose another name");
    return scene_read_region_form(l, &y->regions[index], region_example, to);
}

int scene_read_fixed(loader *l, char *const *text, unsigned count, int **out)
{
    *out = count > 0 ? bake_alloc(count, sizeof **out) : NULL;
    int outer = l->node, list = scene_tree_find(l->tree, outer, "fixed");
    int child = list >= 0 ? l->tree->nodes[list].child : -1;
    for (unsigned i = 0; i < count; i++, child = l->tree->nodes[child].next) {
        l->node = child;
        if (scene_read_region_name(l, text[i], 0, &(*out)[i]))
            return -1;
    }
    l->node = outer;
    return 0;
}

int scene_read_slides(loader *l, const yaml_slide *from, unsigned count, scene_slide **out)
{
    *out = count > 0 ? bake_alloc(count, sizeof **out) : NULL;
    int outer = l->node, list = scene_tree_find(l->tree, outer, "sliding");
    int child = list >= 0 ? l->tree->nodes[list].child : -1;
    for (unsigned i = 0; i < count; i++, child = l->tree->nodes[child].next) {
        l->node = child;
        if (loader_need(l, "region", from[i].region, slide_example) ||
            scene_read_region_name(l, from[i].region, 0, &(*out)[i].region) ||
            loader_direction(l, "normal", slide_example, (*out)[i].normal))
            return -1;
    }
    l->node = outer;
    return 0;
}

int scene_read_turn(loader *l, int rate, double axis[3], double *angle)
{
    static const char *const keys[] = {"axis", "angle", NULL};
    int outer = l->node, turn = scene_tree_find(l->tree, outer, "turn");
    if (turn < 0)
        return 0;
    if (l->tree->nodes[turn].kind != NODE_MAPPING)
        return loader_fail(l, "turn", "'turn' must be an axis and an angle:  %s", turn_example);
    l->node = turn;
    const char *text;
    if (loader_known(l, keys) || loader_direction(l, "axis", turn_example, axis) ||
        loader_scalar(l, "angle", &text) || loader_need(l, "angle", text, turn_example) ||
        loader_number(l, "angle", text, &scene_value[WG_UNIT_DEGREE][rate], angle))
        return -1;
    l->node = outer;
    return 0;
}

int scene_read_shift(loader *l, int rate, scene_shift *out)
{
    static const char *const keys[] = {"region", "by", "turn", NULL};
    const char *region;
    *out = (scene_shift){.line = scene_tree_line(l->tree, l->node, NULL), .region = -1};
    if (loader_known(l, keys) || loader_scalar(l, "region", &region) ||
        (!rate && loader_need(l, "region", region, shift_example)) ||
        scene_read_region_name(l, region, 1, &out->region) ||
        loader_numbers(l, "by", 3, rate ? &scene_speed : &scene_way, out->by) ||
        scene_read_turn(l, rate, out->axis, &out->angle))
        return -1;
    if (!loader_has(l, "by") && !loader_has(l, "turn"))
        return loader_fail(l, NULL, "this has neither 'by' nor 'turn'; write for example:  %s",
                           shift_example);
    return 0;
}
