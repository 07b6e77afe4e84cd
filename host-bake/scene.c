/* Loads a scene: the small parts here, clips in scene_clip.c and scene_curve.c, the others in files
 * of their own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SOURCES_MAX = 255, MESHES_MAX = 8, OWNERS_MAX = 8, NAME_BYTES = 64 };

int scene_read_channel(loader *l, int index)
{
    static const scene_word units[] = {{"none", WG_UNIT_NONE},
                                       {"deg", WG_UNIT_DEGREE},
                                       {"us", WG_UNIT_MICROSECOND},
                                       {"mm", WG_UNIT_MILLIMETRE},
                                       {NULL, 0}};
    const yaml_scene *y = l->yaml;
    const yaml_channel *from = &y->channels[index];
    scene_channel *to = &l->out->channels[index];
    if (loader_name(l, SCENE_NAMES(y->channels, y->channels_count), index,
                    "- {name: jaw, unit: deg}", &to->name) ||
        loader_word(l, "unit", from->unit, units, &to->unit) ||
        loader_number(l, "rest", from->rest, &scene_value[to->unit][0], &to->rest) ||
        loader_number(l, "tolerance", from->tolerance, &scene_value[to->unit][0], &to->tolerance))
        return -1;
    if (to->tolerance < 0)
        return loader_fail(l, "tolerance", "'tolerance' is %g; it must not be negative",
                           to->tolerance);
    if (from->range == NULL)
        return 0;
    if (from->range_count != 2)
        return loader_fail(l, "range", "'range' has %u numbers; write two:  range: [-30, 30]",
                           from->range_count);
    for (int i = 0; i < 2; i++)
        if (loader_number(l, "range", from->range[i], &scene_value[to->unit][0], &to->range[i]))
            return -1;
    if (to->range[0] >= to->range[1])
        return loader_fail(l, "range", "'range' must ascend, as in  range: [-30, 30]");
    if (to->rest < to->range[0] || to->rest > to->range[1])
        return loader_fail(l, "rest", "'rest' is %g, outside 'range' %g .. %g", to->rest,
                           to->range[0], to->range[1]);
    return 0;
}

int scene_read_source(loader *l, int index)
{
    static const int animations[2] = {0, 9999};
    const yaml_scene *y = l->yaml;
    const yaml_source *from = &y->sources[index];
    scene_source *to = &l->out->sources[index];
    if (loader_name(l, SCENE_NAMES(y->sources, y->sources_count), index,
                    "- {name: walk, file: walk.bvh}", &to->name) ||
        loader_need(l, "file", from->file, "- {name: walk, file: walk.bvh}") ||
        loader_integer(l, "animation", from->animation, animations, &to->animation))
        return -1;
    return loader_file(l, from->file, &to->file);
}

/* What captures fill of the rig that a mesh follows. */
static void weigh_captured(const scene *s, int mesh, scene_mask *to)
{
    int rig = scene_rig_of_mesh(s, mesh);
    for (int i = 0; rig >= 0 && i < s->rigs[rig].bone_count; i++) {
        const scene_bone *b = &s->rigs[rig].bones[i];
        for (int k = 0; b->captured >= 0 && k < 4; k++)
            to->weight[b->captured + k] = to->mesh_weight[mesh];
        for (int k = 0; b->travels >= 0 && k < 3; k++)
            to->weight[b->travels + k] = to->mesh_weight[mesh];
    }
}

/* Of a mesh, or of a channel. Meshes come first, so that a channel's own weight holds. */
static int read_weight(loader *l, const scene_node *entry, int meshes, scene_mask *to)
{
    const scene *s = l->out;
    scene_names names = SCENE_NAMES(s->meshes, s->mesh_count);
    int channel = 0, mesh = s->mesh_count > 0 ? scene_names_find(&names, entry->key) : -1;
    if ((mesh >= 0) != meshes)
        return 0;
    if (mesh < 0 &&
        loader_reference(l, s->mesh_count > 0 ? "mesh or channel" : "channel", entry->key,
                         SCENE_NAMES(s->channels, s->channel_count), &channel))
        return -1;
    if (entry->kind != NODE_SCALAR)
        return loader_fail(l, NULL, "the weight of '%s' must be a number from 0 to 1", entry->key);
    if (loader_number(l, entry->key, entry->value, &scene_fraction,
                      mesh >= 0 ? &to->mesh_weight[mesh] : &to->weight[channel]))
        return -1;
    if (mesh >= 0)
        weigh_captured(s, mesh, to);
    return 0;
}

int scene_read_mask(loader *l, int index)
{
    const yaml_scene *y = l->yaml;
    scene *s = l->out;
    const char *example = "- {name: head, weights: {jaw: 1, neck: 0.5}}";
    scene_mask *to = &s->masks[index];
    if (loader_name(l, SCENE_NAMES(y->masks, y->masks_count), index, example, &to->name))
        return -1;
    to->weight = bake_alloc((size_t)s->channel_count, sizeof *to->weight);
    to->mesh_weight = bake_alloc((size_t)s->mesh_count, sizeof *to->mesh_weight);
    int weights = scene_tree_find(l->tree, l->node, "weights");
    if (weights < 0 || l->tree->nodes[weights].kind != NODE_MAPPING)
        return loader_fail(l, "weights", "a mask needs 'weights'; write for example:  %s", example);
    for (int meshes = 1; meshes >= 0; meshes--)
        for (int i = l->tree->nodes[weights].child; i >= 0; i = l->tree->nodes[i].next) {
            l->node = i;
            if (read_weight(l, &l->tree->nodes[i], meshes, to))
                return -1;
        }
    return 0;
}

/* A layer that adds needs differences, one that overrides needs values: a clip is one or the other.
 */
static int check_additive(const loader *l, int clip, int mode)
{
    const scene_clip *c = &l->out->clips[clip];
    if (c->additive == (mode == WG_MODE_ADD))
        return 0;
    return loader_fail(l, "clip",
                       c->additive
                           ? "the clip '%s' is additive, the layer overrides; give the layer "
                             "'mode: add' or remove 'additive: true' in line %d"
                           : "the layer adds, the clip '%s' is not additive; give the layer "
                             "'mode: override' or the clip 'additive: true' in line %d",
                       c->name, c->line);
}

int scene_read_layer(loader *l, int index)
{
    static const scene_word modes[] = {
        {"override", WG_MODE_OVERRIDE}, {"add", WG_MODE_ADD}, {NULL, 0}};
    const yaml_scene *y = l->yaml;
    const yaml_layer *from = &y->layers[index];
    scene *s = l->out;
    scene_layer *to = &s->layers[index];
    *to = (scene_layer){.clip = -1, .mode = WG_MODE_OVERRIDE, .mask = -1, .weight = 1};
    const char *clip = from->clip, *mask = from->mask;
    if (clip != NULL && strcmp(clip, "none") == 0)
        clip = NULL;
    if (mask != NULL && strcmp(mask, "none") == 0)
        mask = NULL;
    if (loader_name(l, SCENE_NAMES(y->layers, y->layers_count), index, "- {name: base, clip: walk}",
                    &to->name) ||
        loader_reference(l, "clip", clip, SCENE_NAMES(s->clips, s->clip_count), &to->clip) ||
        loader_word(l, "mode", from->mode, modes, &to->mode) ||
        loader_reference(l, "mask", mask, SCENE_NAMES(s->masks, s->mask_count), &to->mask) ||
        loader_number(l, "weight", from->weight, &scene_fraction, &to->weight))
        return -1;
    return to->clip >= 0 ? check_additive(l, to->clip, to->mode) : 0;
}

int scene_read_trigger(loader *l, int index)
{
    /* 16 bits of milliseconds. */
    static const scene_measure fade = {
        "a time such as 0.2 or '200 ms'", {{"s", 1}, {"ms", 1e-3}}, 0, 65.535};
    const char *example = "- {event: blink, layer: face, clip: smile, fade: 0.2}";
    const yaml_trigger *from = &l->yaml->triggers[index];
    scene *s = l->out;
    scene_trigger *to = &s->triggers[index];
    if (loader_need(l, "event", from->event, example) ||
        loader_need(l, "layer", from->layer, example) ||
        loader_need(l, "clip", from->clip, example) ||
        loader_reference(l, "event", from->event, SCENE_NAMES(s->event_names, s->event_name_count),
                         &to->event) ||
        loader_reference(l, "layer", from->layer, SCENE_NAMES(s->layers, s->layer_count),
                         &to->layer) ||
        loader_reference(l, "clip", from->clip, SCENE_NAMES(s->clips, s->clip_count), &to->clip) ||
        loader_number(l, "fade", from->fade, &fade, &to->fade))
        return -1;
    return check_additive(l, to->clip, s->layers[to->layer].mode);
}

/* A list's length against the format's limit. */
static int check_count(const loader *l, const char *field, unsigned count, unsigned most)
{
    if (count > most)
        return loader_fail(l, field, "'%s' has %u entries; the clip format holds %u", field, count,
                           most);
    return 0;
}

/* Of meshes, each of which has one. */
static int check_owners(const loader *l, const char *field, unsigned count)
{
    if (count > OWNERS_MAX)
        return loader_fail(l, field, "'%s' has %u entries; a scene has at most %d", field, count,
                           OWNERS_MAX);
    return 0;
}

static int check_counts(const loader *l)
{
    const yaml_scene *y = l->yaml;
    if (y->channels_count + y->meshes_count + y->views_count == 0)
        return loader_fail(l, "channels",
                           "a scene needs channels; write for example:  channels: "
                           "[{name: jaw, unit: deg}]");
    if (y->clips_count == 0)
        return loader_fail(l, "clips",
                           "a scene needs clips; write for example:  clips: [{name: "
                           "nod, curves: [{channel: jaw, kind: linear, keys: [{time: "
                           "0, value: 0}, {time: 1, value: 9}]}]}]");
    return check_count(l, "channels", y->channels_count, WG_CHANNELS_MAX) ||
                   check_count(l, "sources", y->sources_count, SOURCES_MAX) ||
                   check_count(l, "clips", y->clips_count, WG_CLIPS_MAX) ||
                   check_count(l, "masks", y->masks_count, WG_MASKS_MAX) ||
                   check_count(l, "layers", y->layers_count, WG_LAYERS_MAX) ||
                   check_count(l, "filters", y->filters_count, WG_FILTERS_MAX) ||
                   check_count(l, "triggers", y->triggers_count, WG_TRIGGERS_MAX) ||
                   check_count(l, "servos", y->servos_count, WG_SERVOS_MAX) ||
                   check_count(l, "meshes", y->meshes_count, MESHES_MAX) ||
                   check_count(l, "views", y->views_count, WG_VIEWS_MAX) ||
                   check_owners(l, "bodies", y->bodies_count) ||
                   check_owners(l, "rigs", y->rigs_count)
               ? -1
               : 0;
}

static void *allot(unsigned count, size_t size)
{
    return count > 0 ? bake_alloc(count, size) : NULL;
}

/* Allocates every array zeroed, so that scene_free may follow a failure anywhere. */
static void allot_all(scene *s, const yaml_scene *y)
{
    unsigned views = y->views_count > 0 || y->meshes_count == 0 ? y->views_count : 1;
    s->channels = bake_alloc(y->channels_count + views * WG_VIEW_CHANNELS, sizeof *s->channels);
    s->meshes = allot(y->meshes_count, sizeof *s->meshes);
    s->views = allot(views, sizeof *s->views);
    s->bodies = allot(y->bodies_count, sizeof *s->bodies); /* body_count: as they are read */
    s->rigs = allot(y->rigs_count, sizeof *s->rigs);       /* the same */
    s->sources = allot(y->sources_count, sizeof *s->sources);
    s->clips = allot(y->clips_count, sizeof *s->clips);
    s->masks = allot(y->masks_count, sizeof *s->masks);
    s->layers = bake_alloc(y->layers_count + 1, sizeof *s->layers); /* see add_base_layer */
    s->filters = allot(y->filters_count, sizeof *s->filters);
    s->triggers = allot(y->triggers_count, sizeof *s->triggers);
    s->servos = allot(y->servos_count, sizeof *s->servos);
    s->channel_count = (int)y->channels_count;
    s->source_count = (int)y->sources_count;
    s->clip_count = (int)y->clips_count;
    s->mask_count = (int)y->masks_count;
    s->layer_count = (int)y->layers_count;
    s->filter_count = (int)y->filters_count;
    s->trigger_count = (int)y->triggers_count;
    s->servo_count = (int)y->servos_count;
    s->mesh_count = (int)y->meshes_count;
    s->view_count = (int)y->views_count; /* see scene_add_view */
}

/* The scene's name; without one, the file's, with what no C name may hold made '_'. */
static int read_name(loader *l)
{
    if (l->yaml->name != NULL)
        return loader_name(l, SCENE_NAMES(&l->yaml->name, 1), 0, "name: nod", &l->out->name);
    const char *slash = strrchr(l->tree->path, '/');
    const char *file = slash != NULL ? slash + 1 : l->tree->path;
    char name[NAME_BYTES] = "scene";
    snprintf(name, sizeof name, "%.*s", (int)strcspn(file, "."), file);
    for (char *c = name; *c != '\0'; c++)
        if (!((*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') ||
              (*c >= '0' && *c <= '9' && c > name) || *c == '_' || *c == '-'))
            *c = '_';
    l->out->name = bake_copy(name[0] != '\0' ? name : "scene");
    return 0;
}

/* A scene that names no layers plays its first clip, so that a board does not stand still. */
static int add_base_layer(scene *s)
{
    if (s->layer_count == 0) {
        int mode = s->clips[0].additive ? (int)WG_MODE_ADD : (int)WG_MODE_OVERRIDE;
        s->layers[0] = (scene_layer){bake_copy("base"), 0, mode, -1, 1};
        s->layer_count = 1;
    }
    return 0;
}

static int read_views(loader *l)
{
    int none = l->out->mesh_count > 0 && l->out->view_count == 0;
    if (none ? scene_add_view(l) : loader_each(l, "views", scene_read_view))
        return -1;
    return check_count(l, "channels", (unsigned)l->out->channel_count, WG_CHANNELS_MAX);
}

static int read_all(loader *l)
{
    static const scene_measure rate = {
        "a rate such as 120 or '120 Hz'", {{"Hz", 1}}, 1, SCENE_RATE_MAX};
    scene *s = l->out;
    if (read_name(l) || check_counts(l) ||
        loader_number(l, "tick_rate", l->yaml->tick_rate, &rate, &s->tick_rate))
        return -1;
    if (s->tick_rate > (int)s->tick_rate)
        return loader_fail(l, "tick_rate", "'tick_rate' is %g; it must be a whole number",
                           s->tick_rate);
    allot_all(s, l->yaml);
    return loader_each(l, "channels", scene_read_channel) ||
                   loader_each(l, "sources", scene_read_source) ||
                   loader_each(l, "meshes", scene_read_mesh) || read_views(l) ||
                   loader_each(l, "bodies", scene_read_body) ||
                   loader_each(l, "rigs", scene_read_rig) ||
                   loader_each(l, "clips", scene_read_clip) || scene_check_takes(l) ||
                   loader_each(l, "masks", scene_read_mask) ||
                   loader_each(l, "layers", scene_read_layer) || add_base_layer(s) ||
                   loader_each(l, "filters", scene_read_filter) || scene_check_fields(l) ||
                   loader_each(l, "triggers", scene_read_trigger) ||
                   loader_each(l, "servos", scene_read_servo) || scene_read_target(l)
               ? -1
               : 0;
}

int scene_load(const char *path, scene *out, bake_error *error)
{
    *out = (scene){.path = bake_copy(path)};
    scene_tree tree;
    yaml_scene *yaml = NULL;
    int err = scene_tree_load(path, &tree, error);
    if (err == 0)
        err = scene_yaml_load(&tree, &yaml, error);
    if (err == 0) {
        loader l = {.tree = &tree, .yaml = yaml, .out = out, .error = error};
        err = read_all(&l);
    }
    scene_yaml_free(yaml);
    scene_tree_free(&tree);
    if (err)
        scene_free(out);
    return err;
}
