/* Rigs of a scene: which mesh follows which bones, and how its weights are found.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "ends.h"
#include "scene_load.h"

#include "wiggly_format.h"

#include <string.h>

enum {
    INFLUENCES_DEFAULT = (int)WG_INFLUENCES_MAX,
    BRUSHES_MAX = 64,
    FACETS_MAX = 1024,
    FILTER_MAX = 32
};

static const char rig_example[] =
    "- {name: arm, mesh: bar, bones: [{name: upper, from: [0, 90, 0], to: [40, 90, 0]}]}";
static const char cage_example[] = "cage: [[c0, c1, c2], [c0, c2, c3]]";
static const char brush_example[] =
    "brush: [{region: {ball: {centre: [0, 90, 0], radius: 5}}, stiffness: 100}]";
static const char field_example[] = "fields: [{channel: led, at: [10, 40, 0]}]";
static const char filter_example[] = "filter: [[0.2, 0.1], [0.8, 0.9]]";

static scene_rig *current(const loader *l)
{
    return &l->out->rigs[l->rig];
}

int scene_rig_of_mesh(const scene *s, int mesh)
{
    for (int i = 0; i < s->rig_count; i++)
        if (s->rigs[i].mesh == mesh)
            return i;
    return -1;
}

/* ---- the mesh -------------------------------------------------------------------------------- */

/* What else moves it, or asks for what a skin does not have. */
static int check_mesh(const loader *l, const scene_mesh *mesh, int index)
{
    const scene *s = l->out;
    int other = scene_body_of_mesh(s, index);
    if (other >= 0)
        return loader_fail(l, "mesh", "the mesh '%s' is moved by the body '%s' already", mesh->name,
                           s->bodies[other].name);
    if (mesh->normals != NORMALS_NONE)
        return loader_fail(l, "mesh",
                           "the normals of a skinned mesh are computed as it moves; remove "
                           "'normals' from the mesh '%s' in line %d",
                           mesh->name, mesh->line);
    return mesh->affine == 1
               ? loader_fail(l, "mesh",
                             "the rig moves all of the mesh '%s'; remove 'affine: true' in line %d",
                             mesh->name, mesh->line)
               : 0;
}

static int read_mesh(loader *l, const yaml_rig *from, scene_rig *to)
{
    const scene *s = l->out;
    int mesh = -1;
    if (loader_need(l, "mesh", from->mesh, rig_example))
        return -1;
    mesh = loader_find(l, "mesh", "mesh", from->mesh, SCENE_NAMES(s->meshes, s->mesh_count));
    if (mesh < 0)
        return -1;
    int other = scene_rig_of_mesh(s, mesh);
    if (other >= 0)
        return loader_fail(l, "mesh", "the mesh '%s' follows the rig '%s' already", from->mesh,
                           s->rigs[other].name);
    to->mesh = mesh;
    return check_mesh(l, &s->meshes[mesh], mesh);
}

/* ---- how ------------------------------------------------------------------------------------- */

static int read_words(loader *l, const yaml_rig *from, scene_rig *to)
{
    static const scene_word methods[] = {
        {"linear", WG_SKIN_LINEAR}, {"dual", WG_SKIN_DUAL}, {"shift", WG_SKIN_SHIFT}, {NULL, 0}};
    static const scene_word ends[] = {
        {"none", ENDS_NONE},         {"bounded", ENDS_BOUNDED}, {"projection", ENDS_PROJECTION},
        {"distance", ENDS_DISTANCE}, {"joints", ENDS_JOINTS},   {NULL, 0}};
    static const scene_word weights[] = {{"bounded", WEIGHTS_BOUNDED},
                                         {"coupled", WEIGHTS_COUPLED},
                                         {"biharmonic", WEIGHTS_BIHARMONIC},
                                         {"harmonic", WEIGHTS_HARMONIC},
                                         {"file", WEIGHTS_FILE},
                                         {NULL, 0}};
    int kind = WEIGHTS_BOUNDED;
    if (loader_word(l, "method", from->method, methods, &to->method) ||
        loader_word(l, "ends", from->ends, ends, &to->ends) ||
        loader_word(l, "weights", from->weights, weights, &kind))
        return -1;
    to->weights = (scene_weights)kind;
    if (to->weights == WEIGHTS_FILE && from->file == NULL)
        return loader_fail(l, "weights",
                           "'weights: file' are those of a rigged file; write for example:  file: "
                           "hero.glb");
    return to->ends != ENDS_NONE && to->method == (int)WG_SKIN_SHIFT
               ? loader_fail(l, "ends",
                             "'method: shift' neither stretches nor twists; remove 'ends'")
               : 0;
}

static int read_numbers(loader *l, const yaml_rig *from, scene_rig *to)
{
    static const int influences[2] = {1, (int)WG_INFLUENCES_MAX};
    static const scene_measure lift = {"a factor such as 0.3", {{NULL, 0}}, 0, 1e3};
    return loader_integer(l, "influences", from->influences, influences, &to->influences) ||
                   loader_number(l, "tolerance", from->tolerance, &scene_length, &to->tolerance) ||
                   loader_number(l, "cell", from->cell, &scene_length, &to->cell) ||
                   loader_number(l, "lift", from->lift, &lift, &to->lift) ||
                   loader_flag(l, "wrap", from->wrap, &to->wrap) ||
                   loader_flag(l, "paint", from->paint, &to->paint) ||
                   (from->file != NULL && (loader_need(l, "file", from->file, "file: hero.glb") ||
                                           loader_file(l, from->file, &to->file)))
               ? -1
               : 0;
}

/* ---- bones ----------------------------------------------------------------------------------- */

/* Bones that stretch or twist do it through endpoint weights, unless the scene says 'ends: none'. */
static int wants_ends(const scene_rig *rig)
{
    for (int i = 0; i < rig->bone_count; i++)
        for (int j = 0; j < rig->bones[i].joint_count; j++) {
            int kind = rig->bones[i].joints[j].kind;
            if (kind == (int)WG_JOINT_STRETCH || kind == (int)WG_JOINT_TWIST_START ||
                kind == (int)WG_JOINT_TWIST_END)
                return 1;
        }
    return 0;
}

static int check_bones(const loader *l, const yaml_rig *from, scene_rig *to)
{
    int followed = to->file != NULL, values = 0;
    for (int i = 0; i < to->bone_count; i++) {
        followed |= !to->bones[i].weightless;
        values += to->bones[i].value >= 0;
    }
    if (!followed)
        return loader_fail(l, "bones", "every bone is 'weightless'; the mesh has none to follow");
    if (to->paint && values == 0)
        return loader_fail(l, "paint",
                           "'paint' shows the values of bones, and none has a 'value'; give one a "
                           "channel");
    if (from->ends == NULL && wants_ends(to))
        to->ends = ENDS_BOUNDED;
    return 0;
}

static int read_bones(loader *l, const yaml_rig *from, scene_rig *to)
{
    if (from->bones_count == 0 && to->file == NULL)
        return loader_fail(l, "bones",
                           "a rig needs 'bones' or a rigged 'file'; write for example:  "
                           "%s",
                           rig_example);
    if (from->bones_count > WG_BONES_MAX)
        return loader_fail(l, "bones", "'bones' has %u entries; a rig has at most %u",
                           from->bones_count, WG_BONES_MAX);
    to->bones = bake_alloc(from->bones_count, sizeof *to->bones);
    to->bone_count = (int)from->bones_count;
    return loader_each(l, "bones", scene_read_bone) || loader_each(l, "bones", scene_read_follows)
               ? -1
               : check_bones(l, from, to);
}

/* ---- cage, brush, fields, filter ------------------------------------------------------------- */

/* The names of one facet; its size, or -1. */
static int read_facet(const loader *l, const scene_node *list, const scene_rig *rig, int out[3])
{
    int count = list->kind == NODE_SEQUENCE ? list->child_count : 0, k = 0;
    out[2] = -1;
    if (count != 2 && count != 3)
        return loader_fail(l, "cage",
                           "a facet of the cage is three names, or two where the mesh is flat; "
                           "write for example:  %s",
                           cage_example);
    for (int i = list->child; i >= 0; i = l->tree->nodes[i].next, k++) {
        const scene_node *name = &l->tree->nodes[i];
        if (name->kind != NODE_SCALAR)
            return loader_fail(l, "cage", "a facet of the cage is a list of names:  %s",
                               cage_example);
        out[k] =
            loader_find(l, "cage", "bone", name->value, SCENE_NAMES(rig->bones, rig->bone_count));
        if (out[k] < 0)
            return -1;
        if (rig->bones[out[k]].kind != BONE_CAGE)
            return loader_fail(
                l, "cage",
                "the bone '%s' is no vertex of a cage; write it as  {name: %s, cage: "
                "[x, y, z]}",
                name->value, name->value);
        if (rig->bones[out[k]].weightless)
            return loader_fail(
                l, "cage",
                "the vertex '%s' of a cage is 'weightless', so that its facets would "
                "end nowhere; remove that",
                name->value);
        for (int m = 0; m < k; m++)
            if (out[m] == out[k])
                return loader_fail(l, "cage", "a facet of the cage names '%s' twice", name->value);
    }
    return count;
}

static int read_cage(loader *l, scene_rig *to)
{
    int rig = l->node, list = scene_tree_find(l->tree, rig, "cage");
    int count = loader_list_count(l, "cage"), size = 0;
    if (list < 0)
        return 0;
    if (count < 1 || count > FACETS_MAX)
        return loader_fail(l, "cage", "'cage' is a list of 1 to %d facets; write for example:  %s",
                           FACETS_MAX, cage_example);
    to->facets = bake_alloc((size_t)count, sizeof *to->facets);
    for (int i = l->tree->nodes[list].child; i >= 0; i = l->tree->nodes[i].next) {
        l->node = i;
        int corners = read_facet(l, &l->tree->nodes[i], to, to->facets[to->facet_count]);
        if (corners < 0)
            return -1;
        if (size > 0 && corners != size)
            return loader_fail(
                l, NULL,
                "this facet has %d names, those before it %d; a cage is of triangles "
                "or of edges",
                corners, size);
        size = corners;
        to->facet_count++;
    }
    l->node = rig;
    return 0;
}

static int read_brush(loader *l, int index)
{
    const yaml_brush *from = &l->yaml->rigs[l->rig].brush[index];
    scene_rig *rig = current(l);
    scene_brush *to = &rig->brushes[rig->brush_count++];
    int brush = l->node;
    if (from->region == NULL)
        return loader_fail(l, NULL, "'region' is missing; write for example:  %s", brush_example);
    if (loader_need(l, "stiffness", from->stiffness, brush_example) ||
        loader_number(l, "stiffness", from->stiffness, &scene_positive, &to->stiffness))
        return -1;
    l->node = scene_tree_find(l->tree, brush, "region");
    if (scene_read_region_form(l, from->region, "region: {ball: {centre: [0, 90, 0], radius: 5}}",
                               &to->region))
        return -1;
    l->node = brush;
    return 0;
}

/* A channel has one source: this field, or another field, an output, a capture. */
static int check_field(const loader *l, const scene_field *to)
{
    const scene *s = l->out;
    const char *name = s->channels[to->channel].name;
    for (int i = 0; i < s->rig_count; i++) {
        const scene_rig *r = &s->rigs[i];
        for (int j = 0; j < r->field_count; j++)
            if (&r->fields[j] != to && r->fields[j].channel == to->channel)
                return loader_fail(l, "channel", "the channel '%s' is a field already, in line %d",
                                   name, r->fields[j].line);
        for (int j = 0; j < r->bone_count; j++) {
            int captured = r->bones[j].captured, travels = r->bones[j].travels;
            if ((captured >= 0 && to->channel >= captured && to->channel < captured + 4) ||
                (travels >= 0 && to->channel >= travels && to->channel < travels + 3))
                return loader_fail(l, "channel",
                                   "the channel '%s' is what captures fill of the bone '%s'; "
                                   "another channel must be the field's",
                                   name, r->bones[j].name);
        }
    }
    for (int i = 0; i < s->body_count; i++)
        for (int j = 0; j < s->bodies[i].output_count; j++)
            if (s->bodies[i].outputs[j].channel == to->channel)
                return loader_fail(l, "channel",
                                   "the channel '%s' is an output of the body '%s', in line %d; "
                                   "another channel must be the field's",
                                   name, s->bodies[i].name, s->bodies[i].outputs[j].line);
    return 0;
}

static int read_field(loader *l, int index)
{
    const scene *s = l->out;
    const yaml_field *from = &l->yaml->rigs[l->rig].fields[index];
    scene_rig *rig = current(l);
    scene_field *to = &rig->fields[rig->field_count];
    to->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_need(l, "channel", from->channel, field_example) ||
        loader_reference(l, "channel", from->channel, SCENE_NAMES(s->channels, s->channel_count),
                         &to->channel))
        return -1;
    if (!loader_has(l, "at"))
        return loader_fail(l, NULL, "'at' is missing; write for example:  %s", field_example);
    if (loader_place(l, "at", to->at) || check_field(l, to))
        return -1;
    rig->field_count++;
    return 0;
}

/* One [x, y] of `filter`. */
static int read_knot(const loader *l, const scene_node *pair, double out[2])
{
    int good = pair->kind == NODE_SEQUENCE && pair->child_count == 2, k = 0;
    for (int i = good ? pair->child : -1; good && i >= 0; i = l->tree->nodes[i].next, k++) {
        good = l->tree->nodes[i].kind == NODE_SCALAR;
        if (good && loader_number(l, "filter", l->tree->nodes[i].value, &scene_fraction, &out[k]))
            return -1;
    }
    return good ? 0
                : loader_fail(l, "filter", "'filter' is a list of pairs; write for example:  %s",
                              filter_example);
}

/* From (0, 0) to (1, 1) through the pairs: x ascends between them, y does not descend. */
static int read_filter(loader *l, scene_rig *to)
{
    int list = scene_tree_find(l->tree, l->node, "filter");
    int count = loader_list_count(l, "filter");
    double before[2] = {0, 0};
    if (list < 0)
        return 0;
    if (to->ends == ENDS_NONE)
        return loader_fail(l, "filter",
                           "'filter' shapes endpoint weights, and this rig has none; write for "
                           "example:  ends: bounded");
    if (count < 1 || count > FILTER_MAX)
        return loader_fail(l, "filter", "'filter' is a list of 1 to %d pairs:  %s", FILTER_MAX,
                           filter_example);
    to->filter_x = bake_alloc((size_t)count, sizeof *to->filter_x);
    to->filter_y = bake_alloc((size_t)count, sizeof *to->filter_y);
    for (int i = l->tree->nodes[list].child; i >= 0; i = l->tree->nodes[i].next) {
        double at[2];
        if (read_knot(l, &l->tree->nodes[i], at))
            return -1;
        if (at[0] <= before[0] || at[0] >= 1 || at[1] < before[1])
            return loader_fail(l, "filter",
                               "'filter' ascends between (0, 0) and (1, 1), which are not written: "
                               "[%g, %g] cannot follow [%g, %g]",
                               at[0], at[1], before[0], before[1]);
        to->filter_x[to->filter_count] = before[0] = at[0];
        to->filter_y[to->filter_count++] = before[1] = at[1];
    }
    return 0;
}

static int read_extras(loader *l, const yaml_rig *from, scene_rig *to)
{
    if (from->brush_count > BRUSHES_MAX)
        return loader_fail(l, "brush", "'brush' has %u entries; a rig has at most %d",
                           from->brush_count, BRUSHES_MAX);
    if (from->fields_count > WG_CHANNELS_MAX)
        return loader_fail(l, "fields", "'fields' has %u entries; a scene has at most %u channels",
                           from->fields_count, WG_CHANNELS_MAX);
    to->brushes = bake_alloc(from->brush_count, sizeof *to->brushes);
    to->fields = bake_alloc(from->fields_count, sizeof *to->fields);
    return read_cage(l, to) || loader_each(l, "brush", read_brush) ||
                   loader_each(l, "fields", read_field) || read_filter(l, to)
               ? -1
               : 0;
}

int scene_read_rig(loader *l, int index)
{
    const yaml_scene *y = l->yaml;
    const yaml_rig *from = &y->rigs[index];
    scene_rig *to = &l->out->rigs[index];
    *to = (scene_rig){.line = scene_tree_line(l->tree, l->node, NULL),
                      .mesh = -1,
                      .influences = INFLUENCES_DEFAULT,
                      .wrap = 1};
    l->rig = index;
    l->out->rig_count = index + 1;
    l->flat = 1;
    int err = loader_name(l, SCENE_NAMES(y->rigs, y->rigs_count), index, rig_example, &to->name) ||
              read_mesh(l, from, to) || read_words(l, from, to) || read_numbers(l, from, to) ||
              read_bones(l, from, to) || read_extras(l, from, to);
    l->flat = 0;
    return err ? -1 : 0;
}

static int filters_channel(const scene_filter *f, int channel)
{
    for (int i = 0; i < f->n; i++)
        if (f->channels[i] == channel)
            return 1;
    return f->channel == channel;
}

int scene_check_fields(const loader *l)
{
    const scene *s = l->out;
    for (int i = 0; i < s->rig_count; i++)
        for (int j = 0; j < s->rigs[i].field_count; j++)
            for (int k = 0; k < s->filter_count; k++) {
                const scene_field *f = &s->rigs[i].fields[j];
                if (filters_channel(&s->filters[k], f->channel))
                    return bake_fail(l->error,
                                     "%s:%d: the channel '%s' is made after all filters, and a "
                                     "filter or the 'limits' of a joint are for it; use them on "
                                     "the 'value' channels of the bones",
                                     l->tree->path, f->line, s->channels[f->channel].name);
            }
    return 0;
}
