/* Views of a scene, with a channel for each of their numbers, and what the clip may cost.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What remains of 63 characters beside "_distance". */
enum { VIEW_NAME_MAX = 54, CHANNEL_NAME_BYTES = 80 };

static const char view_example[] = "- {name: front, yaw: 20, pitch: 10}";

/* Moves what lies 64 pixels from the axis by a tenth of a pixel. */
static const double angle_tolerance = 0.1;

static const struct {
    const char *suffix;
    int unit;
} numbers[WG_VIEW_CHANNELS] = {
    [WG_VIEW_YAW] = {"yaw", WG_UNIT_DEGREE},
    [WG_VIEW_PITCH] = {"pitch", WG_UNIT_DEGREE},
    [WG_VIEW_ROLL] = {"roll", WG_UNIT_DEGREE},
    [WG_VIEW_X] = {"x", WG_UNIT_MILLIMETRE},
    [WG_VIEW_Y] = {"y", WG_UNIT_MILLIMETRE},
    [WG_VIEW_Z] = {"z", WG_UNIT_MILLIMETRE},
    [WG_VIEW_DISTANCE] = {"distance", WG_UNIT_MILLIMETRE},
    [WG_VIEW_SIZE] = {"size", WG_UNIT_MILLIMETRE},
};

/* From the upper left, in front. */
static const double default_light[3] = {-0.48, 0.64, 0.6};
static const double default_ambient = 0.25;

/* Appends <view>_<suffix>; scene.c allotted the room. */
static int add_channel(scene *s, const char *view, int number, double rest)
{
    char name[CHANNEL_NAME_BYTES];
    int index = s->channel_count++, unit = numbers[number].unit;
    snprintf(name, sizeof name, "%s_%s", view, numbers[number].suffix);
    s->channels[index] = (scene_channel){.name = bake_copy(name),
                                         .unit = unit,
                                         .rest = rest,
                                         .tolerance = unit == WG_UNIT_DEGREE ? angle_tolerance : 0};
    return index;
}

static int refer(const loader *l, const char *field, const char *text, int number, int *out)
{
    const scene *s = l->out;
    if (loader_reference(l, "channel", text, SCENE_NAMES(s->channels, s->channel_count), out))
        return -1;
    int unit = s->channels[*out].unit, angle = numbers[number].unit == WG_UNIT_DEGREE;
    if (angle ? unit == WG_UNIT_DEGREE : unit == WG_UNIT_MILLIMETRE || unit == WG_UNIT_NONE)
        return 0;
    return loader_fail(l, field, "'%s' needs a channel in %s; '%s' is not", field,
                       angle ? "deg" : "mm", text);
}

/* A number, or the name of a channel; names begin with a letter. */
static int read_number(loader *l, const char *field, const char *text, int number, scene_view *to)
{
    if (text != NULL && strchr("0123456789+-.", text[0]) == NULL)
        return refer(l, field, text, number, &to->channel[number]);
    const scene_measure *measure = number == WG_VIEW_DISTANCE || number == WG_VIEW_SIZE
                                       ? &scene_length
                                       : &scene_value[numbers[number].unit][0];
    double rest = 0;
    if (loader_number(l, field, text, measure, &rest))
        return -1;
    to->channel[number] = add_channel(l->out, to->name, number, rest);
    return 0;
}

static int read_numbers(loader *l, const yaml_view *from, scene_view *to)
{
    const char *const text[WG_VIEW_CHANNELS] = {[WG_VIEW_YAW] = from->yaw,
                                                [WG_VIEW_PITCH] = from->pitch,
                                                [WG_VIEW_ROLL] = from->roll,
                                                [WG_VIEW_X] = from->target ? from->target[0] : NULL,
                                                [WG_VIEW_Y] = from->target ? from->target[1] : NULL,
                                                [WG_VIEW_Z] = from->target ? from->target[2] : NULL,
                                                [WG_VIEW_DISTANCE] = from->distance,
                                                [WG_VIEW_SIZE] = from->size};
    to->fit_target = from->target == NULL;
    to->fit_distance = from->distance == NULL;
    to->fit_size = from->size == NULL;
    for (int i = 0; i < (int)WG_VIEW_CHANNELS; i++) {
        int is_target = i == WG_VIEW_X || i == WG_VIEW_Y || i == WG_VIEW_Z;
        if (read_number(l, is_target ? "target" : numbers[i].suffix, text[i], i, to))
            return -1;
    }
    return 0;
}

/* None of the names that the view may add is there yet. */
static int check_names(const loader *l, const char *view)
{
    const scene *s = l->out;
    scene_names channels = SCENE_NAMES(s->channels, s->channel_count);
    scene_names meshes = SCENE_NAMES(s->meshes, s->mesh_count);
    if (strlen(view) > VIEW_NAME_MAX)
        return loader_fail(l, "name", "a view's name has at most %d characters", VIEW_NAME_MAX);
    for (int i = 0; i < (int)WG_VIEW_CHANNELS; i++) {
        char name[CHANNEL_NAME_BYTES];
        snprintf(name, sizeof name, "%s_%s", view, numbers[i].suffix);
        int channel = scene_names_find_macro(&channels, name);
        int mesh = scene_names_find_macro(&meshes, name);
        if (channel >= 0 || mesh >= 0)
            return loader_fail(l, "name",
                               "the view's channel '%s' and the %s '%s' become the same C macro; "
                               "change one name",
                               name, channel >= 0 ? "channel" : "mesh",
                               channel >= 0 ? s->channels[channel].name : s->meshes[mesh].name);
    }
    return 0;
}

static int read_light(const loader *l, const yaml_view *from, scene_view *to)
{
    if (from->light == NULL)
        return 0;
    if (from->light_count != 3)
        return loader_fail(l, "light",
                           "'light' has %u numbers; write the direction towards it: "
                           " [0.3, 0.6, 0.7]",
                           from->light_count);
    for (int i = 0; i < 3; i++)
        if (loader_number(l, "light", from->light[i], &scene_plain, &to->light[i]))
            return -1;
    double length = sqrt(to->light[0] * to->light[0] + to->light[1] * to->light[1] +
                         to->light[2] * to->light[2]);
    if (length < 1e-9)
        return loader_fail(l, "light", "'light' has no direction");
    for (int i = 0; i < 3; i++)
        to->light[i] /= length;
    return 0;
}

/* Smooth shading needs normals. */
static int default_shading(const scene *s)
{
    for (int i = 0; i < s->mesh_count; i++)
        if (s->meshes[i].normals != NORMALS_NONE)
            return WG_SHADING_SMOOTH;
    return WG_SHADING_FLAT;
}

static scene_view default_view(const scene *s)
{
    scene_view view = {
        .projection = WG_PERSPECTIVE, .shading = default_shading(s), .ambient = default_ambient};
    memcpy(view.light, default_light, sizeof view.light);
    return view;
}

int scene_read_view(loader *l, int index)
{
    static const scene_word projections[] = {
        {"perspective", WG_PERSPECTIVE}, {"orthographic", WG_ORTHOGRAPHIC}, {NULL, 0}};
    static const scene_word shadings[] = {{"wireframe", WG_SHADING_WIRE},
                                          {"flat", WG_SHADING_FLAT},
                                          {"smooth", WG_SHADING_SMOOTH},
                                          {NULL, 0}};
    const yaml_scene *y = l->yaml;
    const yaml_view *from = &y->views[index];
    scene_view *to = &l->out->views[index];
    *to = default_view(l->out);
    to->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_name(l, SCENE_NAMES(y->views, y->views_count), index, view_example, &to->name) ||
        check_names(l, to->name) ||
        loader_word(l, "projection", from->projection, projections, &to->projection) ||
        loader_word(l, "shading", from->shading, shadings, &to->shading) ||
        loader_number(l, "ambient", from->ambient, &scene_fraction, &to->ambient) ||
        loader_colour(l, "background", from->background, from->background_count, to->background) ||
        read_light(l, from, to))
        return -1;
    if (from->target != NULL && from->target_count != 3)
        return loader_fail(l, "target", "'target' has %u numbers; write a place:  [0, 30, 0]",
                           from->target_count);
    return read_numbers(l, from, to);
}

int scene_add_view(loader *l)
{
    scene *s = l->out;
    scene_view *view = &s->views[0];
    *view = default_view(s);
    view->line = s->meshes[0].line;
    view->fit_target = view->fit_size = view->fit_distance = 1;
    view->name = bake_copy("view");
    s->view_count = 1;
    if (check_names(l, view->name))
        return -1;
    for (int i = 0; i < (int)WG_VIEW_CHANNELS; i++)
        view->channel[i] = add_channel(s, view->name, i, 0);
    return 0;
}

int scene_read_target(loader *l)
{
    static const scene_measure size = {
        "a size such as 65536 or '64 KB'", {{"B", 1}, {"KB", 1024}, {"MB", 1048576}}, 1, 4e9};
    const yaml_target *from = l->yaml->target;
    int root = l->node;
    if (from == NULL)
        return 0;
    l->node = scene_tree_find(l->tree, root, "target");
    if (loader_number(l, "flash", from->flash, &size, &l->out->flash_bytes) ||
        loader_number(l, "ram", from->ram, &size, &l->out->ram_bytes))
        return -1;
    l->node = root;
    return 0;
}
