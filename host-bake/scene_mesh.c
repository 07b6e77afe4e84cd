/* Meshes of a scene, their shapes, and the frames that clips show of them.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <string.h>

/* Frames: a clip holds 65535 ticks, and a frame takes at least one. */
enum { FRAMES_MAX = 65535, EVERY_MAX = 1000, PIECES_MAX = 255 };

static const char mesh_example[] = "- {name: faerie, file: faerie.md2}";
static const char shape_example[] = "shapes: [{channel: smile, file: smile.obj}]";
static const char motion_example[] = "meshes: [{mesh: faerie, frames: [40, 45], rate: 9 Hz}]";

static int read_shape(loader *l, const yaml_shape *from, scene_mesh *to, int index)
{
    const scene *s = l->out;
    scene_shape *shape = &to->shapes[index];
    shape->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_need(l, "channel", from->channel, shape_example) ||
        loader_reference(l, "channel", from->channel, SCENE_NAMES(s->channels, s->channel_count),
                         &shape->channel))
        return -1;
    if ((from->file != NULL) == (from->target != NULL))
        return loader_fail(l, "target",
                           "a shape is a 'file', or a 'target' that the mesh's own file names; "
                           "write for example:  %s",
                           shape_example);
    for (int i = 0; i < index; i++)
        if (to->shapes[i].channel == shape->channel)
            return loader_fail(l, "channel", "the channel '%s' has a shape already, in line %d",
                               from->channel, to->shapes[i].line);
    if (from->target != NULL) {
        shape->target = bake_copy(from->target);
        return 0;
    }
    return loader_need(l, "file", from->file, shape_example) ||
                   loader_file(l, from->file, &shape->file)
               ? -1
               : 0;
}

/* Shapes are stored as they are: what steers the decomposition of frames has nothing to work on. */
static int check_fields(const loader *l)
{
    static const char *const frames_only[] = {"bases", "mean", "affine", "every", "pieces"};
    for (size_t i = 0; i < sizeof frames_only / sizeof *frames_only; i++)
        if (loader_has(l, frames_only[i]))
            return loader_fail(l, frames_only[i],
                               "'%s' is for meshes that clips show frames of; this one has shapes",
                               frames_only[i]);
    return 0;
}

static int read_shapes(loader *l, const yaml_mesh *from, scene_mesh *to)
{
    if (from->shapes_count == 0)
        return 0;
    if (from->shapes_count > MESH_SHAPES_MAX)
        return loader_fail(l, "shapes", "'shapes' has %u entries; a mesh has at most %d",
                           from->shapes_count, MESH_SHAPES_MAX);
    if (check_fields(l))
        return -1;
    to->shape_count = (int)from->shapes_count;
    to->shapes = bake_alloc(from->shapes_count, sizeof *to->shapes);
    int mesh = l->node;
    l->node = l->tree->nodes[scene_tree_find(l->tree, mesh, "shapes")].child;
    for (int i = 0; i < to->shape_count; i++, l->node = l->tree->nodes[l->node].next)
        if (read_shape(l, &from->shapes[i], to, i))
            return -1;
    l->node = mesh;
    return 0;
}

/* How frames become bases, and how they are stored. */
static int read_coding(const loader *l, const yaml_mesh *from, scene_mesh *to)
{
    static const scene_word bits[] = {{"8", 8}, {"16", 16}, {"auto", 0}, {NULL, 0}};
    static const scene_word affine[] = {{"true", 1}, {"false", 0}, {"yes", 1},
                                        {"no", 0},   {"auto", -1}, {NULL, 0}};
    static const int bases[2] = {1, WG_BASES_MAX}, every[2] = {1, EVERY_MAX};
    static const int pieces[2] = {1, PIECES_MAX};
    return loader_number(l, "tolerance", from->tolerance, &scene_length, &to->tolerance) ||
                   loader_integer(l, "bases", from->bases, bases, &to->bases) ||
                   loader_word(l, "bits", from->bits, bits, &to->bits) ||
                   loader_flag(l, "mean", from->mean, &to->mean) ||
                   loader_word(l, "affine", from->affine, affine, &to->affine) ||
                   loader_integer(l, "every", from->every, every, &to->every) ||
                   loader_integer(l, "pieces", from->pieces, pieces, &to->pieces)
               ? -1
               : 0;
}

static int read_looks(const loader *l, const yaml_mesh *from, scene_mesh *to)
{
    static const scene_measure scale = {"a factor such as 25.4", {{NULL, 0}}, 1e-6, 1e6};
    static const scene_word ups[] = {{"y", 'y'}, {"z", 'z'}, {NULL, 0}};
    static const scene_word sides[] = {{"1", 1}, {"2", 2}, {NULL, 0}};
    static const scene_word normals[] = {{"none", NORMALS_NONE},
                                         {"fixed", NORMALS_FIXED},
                                         {"interpolated", NORMALS_INTERPOLATED},
                                         {NULL, 0}};
    int kind = NORMALS_NONE;
    if (loader_word(l, "up", from->up, ups, &to->up) ||
        loader_number(l, "scale", from->scale, &scale, &to->scale) ||
        loader_word(l, "normals", from->normals, normals, &kind) ||
        loader_word(l, "sides", from->sides, sides, &to->sides) ||
        loader_colour(l, "colour", from->colour, from->colour_count, to->colour))
        return -1;
    to->normals = (scene_normals)kind;
    to->has_colour = from->colour != NULL;
    return 0;
}

static int ends_with(const char *file, const char *ending)
{
    size_t length = strlen(file), size = strlen(ending);
    for (size_t i = 0; length >= size && i < size; i++) {
        char c = file[length - size + i];
        if ((c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c) != ending[i])
            return 0;
    }
    return length >= size;
}

/* Of flat shapes: a picture or a drawing. */
static int read_flat(const loader *l, const yaml_mesh *from, scene_mesh *to)
{
    static const int texels[2] = {1, (int)WG_TEXELS_MAX};
    int picture = to->file != NULL && ends_with(to->file, ".png");
    int drawing = to->file != NULL && ends_with(to->file, ".svg");
    if (from->cell != NULL && !picture && !drawing)
        return loader_fail(l, "cell",
                           "'cell' is of a flat shape, whose file is a .png or .svg; remove it, or "
                           "give it to the mesh's rig or body");
    if (from->texels != NULL && !picture)
        return loader_fail(l, "texels",
                           "'texels' is of a picture, a .png; remove it from this mesh");
    return loader_number(l, "cell", from->cell, &scene_length, &to->cell) ||
                   loader_integer(l, "texels", from->texels, texels, &to->texels)
               ? -1
               : 0;
}

/* The links of a chain make a mesh: it has no file, and nothing that a file's mesh is asked for. */
static int read_file(const loader *l, const yaml_mesh *from, scene_mesh *to)
{
    static const char *const of_files[] = {"up", "scale", "shapes"};
    int drawn = 0;
    for (unsigned i = 0; i < l->yaml->bodies_count; i++) {
        const yaml_body *b = &l->yaml->bodies[i];
        drawn |= b->kind != NULL && strcmp(b->kind, "chain") == 0 && b->mesh != NULL &&
                 strcmp(b->mesh, to->name) == 0;
    }
    if (from->file != NULL || !drawn)
        return loader_need(l, "file", from->file, mesh_example) ||
                       loader_file(l, from->file, &to->file)
                   ? -1
                   : 0;
    for (size_t i = 0; i < sizeof of_files / sizeof *of_files; i++)
        if (loader_has(l, of_files[i]))
            return loader_fail(l, of_files[i], "a mesh that a chain draws has no '%s'; remove it",
                               of_files[i]);
    return 0;
}

int scene_read_mesh(loader *l, int index)
{
    const yaml_scene *y = l->yaml;
    const yaml_mesh *from = &y->meshes[index];
    scene *s = l->out;
    scene_mesh *to = &s->meshes[index];
    scene_names channels = SCENE_NAMES(s->channels, s->channel_count);
    *to = (scene_mesh){.line = scene_tree_line(l->tree, l->node, NULL),
                       .scale = 1,
                       .up = 'y',
                       .mean = 1,
                       .affine = -1,
                       .every = 1,
                       .pieces = 1};
    if (loader_name(l, SCENE_NAMES(y->meshes, y->meshes_count), index, mesh_example, &to->name))
        return -1;
    int same = scene_names_find_macro(&channels, to->name);
    if (same >= 0)
        return loader_fail(l, "name",
                           "the mesh '%s' and the channel '%s' become the same C macro; change one",
                           to->name, s->channels[same].name);
    if (read_file(l, from, to) || read_coding(l, from, to) || read_looks(l, from, to) ||
        read_flat(l, from, to))
        return -1;
    return read_shapes(l, from, to);
}

static int read_range(const loader *l, const yaml_motion *from, scene_motion *to)
{
    static const int range[2] = {0, FRAMES_MAX - 1};
    to->last = -1;
    if (from->frames == NULL)
        return 0;
    if (from->frames_count != 2)
        return loader_fail(l, "frames",
                           "'frames' has %u numbers; write the first and the last:  %s",
                           from->frames_count, motion_example);
    if (loader_integer(l, "frames", from->frames[0], range, &to->first) ||
        loader_integer(l, "frames", from->frames[1], range, &to->last))
        return -1;
    if (to->first > to->last)
        return loader_fail(l, "frames", "'frames' ends at %d, before it begins at %d", to->last,
                           to->first);
    return 0;
}

static int read_motion(loader *l, const yaml_motion *from, scene_clip *clip, int index)
{
    static const scene_measure rate = {
        "a rate such as 25 or '25 Hz'", {{"Hz", 1}}, 1e-3, SCENE_RATE_MAX};
    const scene *s = l->out;
    scene_motion *to = &clip->motions[index];
    to->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_need(l, "mesh", from->mesh, motion_example) ||
        loader_reference(l, "mesh", from->mesh, SCENE_NAMES(s->meshes, s->mesh_count), &to->mesh) ||
        loader_number(l, "rate", from->rate, &rate, &to->rate) || read_range(l, from, to))
        return -1;
    const scene_mesh *mesh = &s->meshes[to->mesh];
    if (mesh->shape_count > 0)
        return loader_fail(l, "mesh",
                           "the mesh '%s' has shapes, which curves move; it cannot have frames too",
                           mesh->name);
    if (scene_body_of_mesh(s, to->mesh) >= 0)
        return loader_fail(l, "mesh",
                           "the mesh '%s' is moved by the body '%s'; it cannot have frames too",
                           mesh->name, s->bodies[scene_body_of_mesh(s, to->mesh)].name);
    if (scene_rig_of_mesh(s, to->mesh) >= 0)
        return loader_fail(l, "mesh",
                           "the mesh '%s' follows the rig '%s'; it cannot have frames too",
                           mesh->name, s->rigs[scene_rig_of_mesh(s, to->mesh)].name);
    for (int i = 0; i < index; i++)
        if (clip->motions[i].mesh == to->mesh)
            return loader_fail(l, "mesh", "the clip '%s' shows the mesh '%s' already, in line %d",
                               clip->name, mesh->name, clip->motions[i].line);
    if (from->file == NULL)
        return 0;
    return loader_need(l, "file", from->file, "file: walk.pc2") ||
                   loader_file(l, from->file, &to->file)
               ? -1
               : 0;
}

int scene_read_motions(loader *l, int clip)
{
    const yaml_clip *from = &l->yaml->clips[clip];
    scene_clip *to = &l->out->clips[clip];
    if (from->meshes_count == 0)
        return 0;
    if (to->additive)
        return loader_fail(l, "meshes",
                           "the clip '%s' is additive; the frames of a mesh are no differences",
                           to->name);
    to->motions = bake_alloc(from->meshes_count, sizeof *to->motions);
    to->motion_count = (int)from->meshes_count;
    int mapping = l->node;
    l->node = l->tree->nodes[scene_tree_find(l->tree, mapping, "meshes")].child;
    for (int i = 0; i < to->motion_count; i++, l->node = l->tree->nodes[l->node].next)
        if (read_motion(l, &from->meshes[i], to, i))
            return -1;
    l->node = mapping;
    return 0;
}
