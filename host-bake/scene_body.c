/* Elastic bodies of a scene: what they are, which meshes they move, which channels they drive.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <string.h>

enum { MODES_DEFAULT = 20 };

#define BIT(kind) (1u << (kind))
#define CHAIN     BIT(SCENE_CHAIN)
#define ELASTIC   (BIT(SCENE_SOLID) | BIT(SCENE_SHELL))

static const scene_word kinds[] = {
    {"solid", SCENE_SOLID}, {"shell", SCENE_SHELL}, {"chain", SCENE_CHAIN}, {NULL, 0}};

static const char body_example[] = "- {name: cactus, kind: solid, mesh: cactus, material: rubber}";
static const char output_example[] = "{channel: tip, region: tip, direction: x}";

static scene_body *current(const loader *l)
{
    return &l->out->bodies[l->body];
}

int scene_body_of_mesh(const scene *s, int mesh)
{
    for (int i = 0; i < s->body_count; i++) {
        const scene_body *b = &s->bodies[i];
        if (b->mesh == mesh)
            return i;
        for (int j = 0; j < b->attached_count; j++)
            if (b->attached[j] == mesh)
                return i;
    }
    return -1;
}

/* A field that the kind ignores would be a surprise, so it is an error. */
static int check_fields(const loader *l, scene_body_kind kind)
{
    static const struct {
        const char *field;
        unsigned kinds;
    } uses[] = {{"material", ELASTIC},      {"thickness", BIT(SCENE_SHELL)},
                {"cell", BIT(SCENE_SOLID)}, {"attached", ELASTIC},
                {"regions", ELASTIC},       {"fixed", ELASTIC},
                {"sliding", ELASTIC},       {"modes", ELASTIC},
                {"links", CHAIN},           {"free_root", CHAIN},
                {"root_mass", CHAIN},       {"width", CHAIN}};
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++)
        if (loader_has(l, uses[i].field) && (uses[i].kinds & BIT(kind)) == 0)
            return loader_fail(l, uses[i].field, "a body of kind '%s' has no '%s'; remove it",
                               kinds[kind].word, uses[i].field);
    return 0;
}

/* A mesh that the body moves: its frames are made, so it brings none. */
static int take_mesh(const loader *l, const char *field, const char *text, int *out)
{
    const scene *s = l->out;
    int mesh = loader_find(l, field, "mesh", text, SCENE_NAMES(s->meshes, s->mesh_count));
    if (mesh < 0)
        return -1;
    int other = scene_body_of_mesh(s, mesh);
    if (other >= 0)
        return loader_fail(l, field, "the mesh '%s' is moved by the body '%s' already", text,
                           s->bodies[other].name);
    if (s->meshes[mesh].shape_count > 0)
        return loader_fail(l, field,
                           "the mesh '%s' has shapes, which curves move; a body cannot move it too",
                           text);
    *out = mesh;
    return 0;
}

static int read_meshes(loader *l, const yaml_body *from, scene_body *b)
{
    const scene *s = l->out;
    int chain = b->kind == SCENE_CHAIN;
    if (!chain && loader_need(l, "mesh", from->mesh, body_example))
        return -1;
    if (from->mesh != NULL && take_mesh(l, "mesh", from->mesh, &b->mesh))
        return -1;
    if (chain && b->mesh >= 0 && s->meshes[b->mesh].file != NULL)
        return loader_fail(l, "mesh",
                           "the chain '%s' draws its mesh from its links; remove 'file' from the "
                           "mesh '%s' in line %d",
                           b->name, from->mesh, s->meshes[b->mesh].line);
    if (from->attached_count == 0)
        return 0;
    b->attached = bake_alloc(from->attached_count, sizeof *b->attached);
    for (unsigned i = 0; i < from->attached_count; i++) {
        if (take_mesh(l, "attached", from->attached[i], &b->attached[i]))
            return -1;
        b->attached_count++;
    }
    return 0;
}

/* Metres a scene unit. */
static int read_unit(const loader *l, const char *text, double *out)
{
    static const scene_measure unit = {"what a scene unit is, such as '1 mm', '1 cm' or '1 m'",
                                       {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}},
                                       1e-6,
                                       1e3};
    char suffix[LOADER_SUFFIX_BYTES];
    double value;
    if (loader_number(l, "unit", text, &unit, out))
        return -1;
    if (text != NULL && loader_quantity(l, "unit", text, &value, suffix) == 0 && suffix[0] == '\0')
        return loader_fail(l, "unit", "'unit' is '%.40s', without a unit; expected %s", text,
                           unit.example);
    return 0;
}

static int read_physics(loader *l, const yaml_body *from, scene_body *b)
{
    static const int modes[2] = {1, 120};
    static const scene_measure gravity = {
        "an acceleration in m/s2 such as -9.81", {{"m/s2", 1}}, -1e6, 1e6};
    static const scene_measure cell = {"a length such as 4", {{NULL, 0}}, 1e-6, 1e6};

    return loader_numbers(l, "gravity", 3, &gravity, b->gravity) ||
                   loader_numbers(l, "damping", 2, &scene_positive, b->damping) ||
                   loader_integer(l, "modes", from->modes, modes, &b->modes) ||
                   loader_number(l, "cell", from->cell, &cell, &b->cell) ||
                   (b->kind != SCENE_CHAIN && scene_read_material(l))
               ? -1
               : 0;
}

static int read_regions(loader *l, const yaml_body *from, scene_body *b)
{
    b->regions = bake_alloc(from->regions_count + 1, sizeof *b->regions);
    b->region_count = (int)from->regions_count;
    if (loader_each(l, "regions", scene_read_region) ||
        scene_read_fixed(l, from->fixed, from->fixed_count, &b->fixed) ||
        scene_read_slides(l, from->sliding, from->sliding_count, &b->slides))
        return -1;
    b->fixed_count = (int)from->fixed_count;
    b->slide_count = (int)from->sliding_count;
    return 0;
}

static int read_poses(loader *l, const yaml_body *from, scene_body *b)
{
    b->poses = bake_alloc(from->poses_count + 1, sizeof *b->poses);
    b->pose_count = (int)from->poses_count + 1;
    b->poses[0] = (scene_pose){.name = bake_copy("rest"), .line = b->line, .of = -1};
    return loader_each(l, "poses", scene_read_pose);
}

/* A channel is driven once: two outputs of it would be a sum that nobody asked for. */
static int check_channel(const loader *l, const scene_output *to)
{
    const scene *s = l->out;
    const scene_channel *channel = &s->channels[to->channel];
    int mm = channel->unit == WG_UNIT_MILLIMETRE || channel->unit == WG_UNIT_NONE;
    if (to->kind == OUTPUT_SHIFT ? !mm : channel->unit != WG_UNIT_DEGREE)
        return loader_fail(l, "channel", "the channel '%s' takes %s; give it 'unit: %s'",
                           channel->name, to->kind == OUTPUT_SHIFT ? "a length" : "an angle",
                           to->kind == OUTPUT_SHIFT ? "mm" : "deg");
    for (int i = 0; i < s->body_count; i++)
        for (int j = 0; j < s->bodies[i].output_count; j++) {
            const scene_output *other = &s->bodies[i].outputs[j];
            if (other == to)
                return 0;
            if (other->channel == to->channel)
                return loader_fail(
                    l, "channel",
                    "the channel '%s' is an output of the body '%s' already, in line "
                    "%d",
                    channel->name, s->bodies[i].name, other->line);
        }
    return 0;
}

static int read_joint(loader *l, const char *text, scene_output *to)
{
    const scene_body *b = current(l);
    to->kind = OUTPUT_JOINT;
    if (loader_has(l, "region") || loader_has(l, "direction") || loader_has(l, "turn"))
        return loader_fail(l, "joint",
                           "'joint' excludes 'region', 'direction' and 'turn': one output is one "
                           "number");
    to->joint = loader_find(l, "joint", "link", text, SCENE_NAMES(b->links, b->link_count));
    if (to->joint < 0)
        return -1;
    return b->links[to->joint].stiff
               ? loader_fail(l, "joint", "the link '%s' is stiff; its joint never turns", text)
               : 0;
}

static int read_measured(loader *l, const yaml_output *from, scene_output *to)
{
    int turn = loader_has(l, "turn");
    if (turn == loader_has(l, "direction"))
        return loader_fail(l, NULL,
                           "an output of a region is a 'direction' or a 'turn'%s; write for "
                           "example:  %s",
                           turn ? ", not both" : "", output_example);
    to->kind = turn ? OUTPUT_TURN : OUTPUT_SHIFT;
    return loader_need(l, "region", from->region, output_example) ||
                   scene_read_region_name(l, from->region, 1, &to->region) ||
                   loader_direction(l, turn ? "turn" : "direction", output_example, to->direction)
               ? -1
               : 0;
}

static int read_output(loader *l, int index)
{
    const scene *s = l->out;
    const yaml_output *from = &l->yaml->bodies[l->body].outputs[index];
    scene_body *b = current(l);
    scene_output *to = &b->outputs[index];
    *to =
        (scene_output){.line = scene_tree_line(l->tree, l->node, NULL), .region = -1, .joint = -1};
    b->output_count = index + 1;
    int chain = b->kind == SCENE_CHAIN;
    if (loader_need(l, "channel", from->channel, output_example) ||
        loader_reference(l, "channel", from->channel, SCENE_NAMES(s->channels, s->channel_count),
                         &to->channel))
        return -1;
    if (chain != (from->joint != NULL))
        return loader_fail(l, from->joint ? "joint" : NULL,
                           chain ? "the chain '%s' has joints as outputs:  {channel: hip, joint: "
                                   "thigh}"
                                 : "the body '%s' is no chain and has no joints",
                           b->name);
    if (chain ? read_joint(l, from->joint, to) : read_measured(l, from, to))
        return -1;
    return check_channel(l, to);
}

static int read_outputs(loader *l, const yaml_body *from, scene_body *b)
{
    if (from->outputs_count == 0)
        return b->mesh >= 0 ? 0
                            : loader_fail(l, NULL,
                                          "nothing shows of the chain '%s': give it a 'mesh' or "
                                          "'outputs'",
                                          b->name);
    b->outputs = bake_alloc(from->outputs_count, sizeof *b->outputs);
    return loader_each(l, "outputs", read_output);
}

int scene_read_body(loader *l, int index)
{
    const yaml_scene *y = l->yaml;
    const yaml_body *from = &y->bodies[index];
    scene_body *b = &l->out->bodies[index];
    int kind = SCENE_SOLID;
    *b = (scene_body){.line = scene_tree_line(l->tree, l->node, NULL),
                      .mesh = -1,
                      .unit = 1e-3,
                      .modes = MODES_DEFAULT};
    l->body = index;
    l->out->body_count = index + 1;
    if (loader_name(l, SCENE_NAMES(y->bodies, y->bodies_count), index, body_example, &b->name) ||
        loader_need(l, "kind", from->kind, body_example) ||
        loader_word(l, "kind", from->kind, kinds, &kind) || check_fields(l, (scene_body_kind)kind))
        return -1;
    b->kind = (scene_body_kind)kind;
    return read_meshes(l, from, b) || read_unit(l, from->unit, &b->unit) ||
                   read_physics(l, from, b) || (b->kind == SCENE_CHAIN && scene_read_chain(l)) ||
                   read_regions(l, from, b) || read_poses(l, from, b) || read_outputs(l, from, b)
               ? -1
               : 0;
}
