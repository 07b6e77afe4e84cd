/* The schema of a scene file for libcyaml, and what to say when a file does not follow it.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_yaml.h"
#include "scene_names.h"

#include <cyaml/cyaml.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define MANY                     CYAML_UNLIMITED
#define MAYBE                    (CYAML_FLAG_POINTER | CYAML_FLAG_OPTIONAL)
#define TEXT(type, field)        CYAML_FIELD_STRING_PTR(#field, MAYBE, type, field, 0, MANY)
#define LIST(type, field, entry) CYAML_FIELD_SEQUENCE(#field, MAYBE, type, field, &(entry), 0, MANY)
#define PART(type, field, parts) CYAML_FIELD_MAPPING_PTR(#field, MAYBE, type, field, parts)
#define FREE_FORM(field)         CYAML_FIELD_IGNORE(field, CYAML_FLAG_OPTIONAL)
#define ENTRY(type, fields)                                                                        \
    {                                                                                              \
        CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, type, fields)                                      \
    }

/* Nothing is required here: a missing field is reported by the stage that needs it, which can show
 * an example. */
static const cyaml_schema_value_t text_entry = {
    CYAML_VALUE_STRING(CYAML_FLAG_POINTER, char *, 0, MANY)};

static const cyaml_schema_field_t source_fields[] = {TEXT(yaml_source, name),
                                                     TEXT(yaml_source, file),
                                                     TEXT(yaml_source, animation), CYAML_FIELD_END};
static const cyaml_schema_value_t source_entry = ENTRY(yaml_source, source_fields);

static const cyaml_schema_field_t channel_fields[] = {TEXT(yaml_channel, name),
                                                      TEXT(yaml_channel, unit),
                                                      TEXT(yaml_channel, rest),
                                                      TEXT(yaml_channel, tolerance),
                                                      LIST(yaml_channel, range, text_entry),
                                                      CYAML_FIELD_END};
static const cyaml_schema_value_t channel_entry = ENTRY(yaml_channel, channel_fields);

static const cyaml_schema_field_t key_fields[] = {
    TEXT(yaml_key, time),         TEXT(yaml_key, value),  TEXT(yaml_key, velocity),
    TEXT(yaml_key, acceleration), TEXT(yaml_key, weight), CYAML_FIELD_END};
static const cyaml_schema_value_t key_entry = ENTRY(yaml_key, key_fields);

static const cyaml_schema_field_t curve_fields[] = {TEXT(yaml_curve, channel),
                                                    TEXT(yaml_curve, kind),
                                                    TEXT(yaml_curve, frequency),
                                                    TEXT(yaml_curve, damping),
                                                    TEXT(yaml_curve, lambda),
                                                    TEXT(yaml_curve, delta),
                                                    TEXT(yaml_curve, force),
                                                    TEXT(yaml_curve, periodic),
                                                    LIST(yaml_curve, regularise, text_entry),
                                                    FREE_FORM("start"),
                                                    FREE_FORM("end"),
                                                    LIST(yaml_curve, keys, key_entry),
                                                    TEXT(yaml_curve, source),
                                                    TEXT(yaml_curve, node),
                                                    TEXT(yaml_curve, component),
                                                    TEXT(yaml_curve, column),
                                                    FREE_FORM("axis"),
                                                    TEXT(yaml_curve, scale),
                                                    TEXT(yaml_curve, offset),
                                                    TEXT(yaml_curve, from),
                                                    TEXT(yaml_curve, to),
                                                    CYAML_FIELD_END};
static const cyaml_schema_value_t curve_entry = ENTRY(yaml_curve, curve_fields);

static const cyaml_schema_field_t mark_fields[] = {TEXT(yaml_mark, name), TEXT(yaml_mark, time),
                                                   CYAML_FIELD_END};
static const cyaml_schema_value_t mark_entry = ENTRY(yaml_mark, mark_fields);

static const cyaml_schema_field_t motion_fields[] = {
    TEXT(yaml_motion, mesh), TEXT(yaml_motion, file), TEXT(yaml_motion, rate),
    LIST(yaml_motion, frames, text_entry), CYAML_FIELD_END};
static const cyaml_schema_value_t motion_entry = ENTRY(yaml_motion, motion_fields);

static const cyaml_schema_field_t axes_fields[] = {TEXT(yaml_axes, x), TEXT(yaml_axes, y),
                                                   TEXT(yaml_axes, z), CYAML_FIELD_END};
static const cyaml_schema_field_t ball_fields[] = {
    TEXT(yaml_ball, radius), LIST(yaml_ball, centre, text_entry), CYAML_FIELD_END};
static const cyaml_schema_field_t region_fields[] = {TEXT(yaml_region, name),
                                                     FREE_FORM("box"),
                                                     PART(yaml_region, ball, ball_fields),
                                                     PART(yaml_region, above, axes_fields),
                                                     PART(yaml_region, below, axes_fields),
                                                     LIST(yaml_region, vertices, text_entry),
                                                     CYAML_FIELD_END};
static const cyaml_schema_value_t region_entry = ENTRY(yaml_region, region_fields);

static const cyaml_schema_field_t slide_fields[] = {TEXT(yaml_slide, region), FREE_FORM("normal"),
                                                    CYAML_FIELD_END};
static const cyaml_schema_value_t slide_entry = ENTRY(yaml_slide, slide_fields);

static const cyaml_schema_field_t pose_mode_fields[] = {TEXT(yaml_pose_mode, mode),
                                                        TEXT(yaml_pose_mode, by), CYAML_FIELD_END};
static const cyaml_schema_value_t pose_mode_entry = ENTRY(yaml_pose_mode, pose_mode_fields);

static const cyaml_schema_field_t joint_fields[] = {TEXT(yaml_joint, link), TEXT(yaml_joint, angle),
                                                    CYAML_FIELD_END};
static const cyaml_schema_value_t joint_entry = ENTRY(yaml_joint, joint_fields);

static const cyaml_schema_field_t pose_fields[] = {TEXT(yaml_pose, name),
                                                   TEXT(yaml_pose, of),
                                                   TEXT(yaml_pose, file),
                                                   LIST(yaml_pose, modes, pose_mode_entry),
                                                   FREE_FORM("drag"),
                                                   FREE_FORM("turn"),
                                                   LIST(yaml_pose, move, text_entry),
                                                   LIST(yaml_pose, joints, joint_entry),
                                                   CYAML_FIELD_END};
static const cyaml_schema_value_t pose_entry = ENTRY(yaml_pose, pose_fields);

static const cyaml_schema_field_t output_fields[] = {
    TEXT(yaml_output, channel), TEXT(yaml_output, region), TEXT(yaml_output, joint),
    FREE_FORM("direction"),     FREE_FORM("turn"),         CYAML_FIELD_END};
static const cyaml_schema_value_t output_entry = ENTRY(yaml_output, output_fields);

static const cyaml_schema_field_t link_fields[] = {
    TEXT(yaml_link, name),   TEXT(yaml_link, parent),
    TEXT(yaml_link, stiff),  TEXT(yaml_link, length),
    TEXT(yaml_link, angle),  TEXT(yaml_link, mass),
    TEXT(yaml_link, spring), LIST(yaml_link, density, text_entry),
    CYAML_FIELD_END};
static const cyaml_schema_value_t link_entry = ENTRY(yaml_link, link_fields);

static const cyaml_schema_field_t body_fields[] = {TEXT(yaml_body, name),
                                                   TEXT(yaml_body, kind),
                                                   TEXT(yaml_body, mesh),
                                                   LIST(yaml_body, attached, text_entry),
                                                   TEXT(yaml_body, unit),
                                                   FREE_FORM("material"),
                                                   TEXT(yaml_body, thickness),
                                                   TEXT(yaml_body, cell),
                                                   LIST(yaml_body, gravity, text_entry),
                                                   LIST(yaml_body, fixed, text_entry),
                                                   LIST(yaml_body, sliding, slide_entry),
                                                   TEXT(yaml_body, modes),
                                                   LIST(yaml_body, damping, text_entry),
                                                   LIST(yaml_body, regions, region_entry),
                                                   LIST(yaml_body, poses, pose_entry),
                                                   LIST(yaml_body, outputs, output_entry),
                                                   LIST(yaml_body, links, link_entry),
                                                   TEXT(yaml_body, free_root),
                                                   TEXT(yaml_body, root_mass),
                                                   TEXT(yaml_body, width),
                                                   CYAML_FIELD_END};
static const cyaml_schema_value_t body_entry = ENTRY(yaml_body, body_fields);

static const cyaml_schema_field_t body_key_fields[] = {TEXT(yaml_body_key, time),
                                                       TEXT(yaml_body_key, pose),
                                                       FREE_FORM("velocity"),
                                                       TEXT(yaml_body_key, weight),
                                                       TEXT(yaml_body_key, velocity_weight),
                                                       TEXT(yaml_body_key, region),
                                                       CYAML_FIELD_END};
static const cyaml_schema_value_t body_key_entry = ENTRY(yaml_body_key, body_key_fields);

static const cyaml_schema_field_t action_fields[] = {TEXT(yaml_action, body),
                                                     TEXT(yaml_action, dynamics),
                                                     TEXT(yaml_action, about),
                                                     LIST(yaml_action, fixed, text_entry),
                                                     LIST(yaml_action, sliding, slide_entry),
                                                     TEXT(yaml_action, stiffness),
                                                     LIST(yaml_action, damping, text_entry),
                                                     LIST(yaml_action, regularise, text_entry),
                                                     FREE_FORM("start"),
                                                     FREE_FORM("end"),
                                                     TEXT(yaml_action, periodic),
                                                     TEXT(yaml_action, add),
                                                     LIST(yaml_action, keys, body_key_entry),
                                                     CYAML_FIELD_END};
static const cyaml_schema_value_t action_entry = ENTRY(yaml_action, action_fields);

static const cyaml_schema_field_t rig_joint_fields[] = {
    TEXT(yaml_rig_joint, channel), FREE_FORM("turn"),       FREE_FORM("move"),
    FREE_FORM("stretch"),          FREE_FORM("twist"),      FREE_FORM("twist-start"),
    FREE_FORM("twist-end"),        FREE_FORM("quaternion"), FREE_FORM("follow"),
    FREE_FORM("limits"),           CYAML_FIELD_END};
static const cyaml_schema_value_t rig_joint_entry = ENTRY(yaml_rig_joint, rig_joint_fields);

/* a region of bodies without its name */
#define PLACE_FIELDS (region_fields + 1)
static const cyaml_schema_field_t bone_fields[] = {TEXT(yaml_bone, name),
                                                   TEXT(yaml_bone, parent),
                                                   FREE_FORM("from"),
                                                   FREE_FORM("to"),
                                                   FREE_FORM("at"),
                                                   FREE_FORM("cage"),
                                                   PART(yaml_bone, region, PLACE_FIELDS),
                                                   TEXT(yaml_bone, depth),
                                                   TEXT(yaml_bone, value),
                                                   TEXT(yaml_bone, weightless),
                                                   TEXT(yaml_bone, node),
                                                   LIST(yaml_bone, joints, rig_joint_entry),
                                                   CYAML_FIELD_END};
static const cyaml_schema_value_t bone_entry = ENTRY(yaml_bone, bone_fields);

static const cyaml_schema_field_t brush_fields[] = {PART(yaml_brush, region, PLACE_FIELDS),
                                                    TEXT(yaml_brush, stiffness), CYAML_FIELD_END};
static const cyaml_schema_value_t brush_entry = ENTRY(yaml_brush, brush_fields);

static const cyaml_schema_field_t value_field_fields[] = {TEXT(yaml_field, channel),
                                                          FREE_FORM("at"), CYAML_FIELD_END};
static const cyaml_schema_value_t value_field_entry = ENTRY(yaml_field, value_field_fields);

static const cyaml_schema_field_t rig_fields[] = {TEXT(yaml_rig, name),
                                                  TEXT(yaml_rig, mesh),
                                                  TEXT(yaml_rig, method),
                                                  TEXT(yaml_rig, ends),
                                                  TEXT(yaml_rig, weights),
                                                  TEXT(yaml_rig, influences),
                                                  TEXT(yaml_rig, tolerance),
                                                  TEXT(yaml_rig, cell),
                                                  TEXT(yaml_rig, lift),
                                                  TEXT(yaml_rig, wrap),
                                                  TEXT(yaml_rig, file),
                                                  TEXT(yaml_rig, paint),
                                                  LIST(yaml_rig, bones, bone_entry),
                                                  FREE_FORM("cage"),
                                                  FREE_FORM("filter"),
                                                  LIST(yaml_rig, brush, brush_entry),
                                                  LIST(yaml_rig, fields, value_field_entry),
                                                  CYAML_FIELD_END};
static const cyaml_schema_value_t rig_entry = ENTRY(yaml_rig, rig_fields);

static const cyaml_schema_field_t take_fields[] = {
    TEXT(yaml_take, rig),   TEXT(yaml_take, source), TEXT(yaml_take, from), TEXT(yaml_take, to),
    TEXT(yaml_take, scale), TEXT(yaml_take, travel), CYAML_FIELD_END};
static const cyaml_schema_value_t take_entry = ENTRY(yaml_take, take_fields);

static const cyaml_schema_field_t clip_fields[] = {TEXT(yaml_clip, name),
                                                   TEXT(yaml_clip, duration),
                                                   TEXT(yaml_clip, end),
                                                   TEXT(yaml_clip, additive),
                                                   LIST(yaml_clip, events, mark_entry),
                                                   LIST(yaml_clip, curves, curve_entry),
                                                   LIST(yaml_clip, meshes, motion_entry),
                                                   LIST(yaml_clip, bodies, action_entry),
                                                   LIST(yaml_clip, rigs, take_entry),
                                                   CYAML_FIELD_END};
static const cyaml_schema_value_t clip_entry = ENTRY(yaml_clip, clip_fields);

static const cyaml_schema_field_t mask_fields[] = {TEXT(yaml_mask, name), FREE_FORM("weights"),
                                                   CYAML_FIELD_END};
static const cyaml_schema_value_t mask_entry = ENTRY(yaml_mask, mask_fields);

static const cyaml_schema_field_t layer_fields[] = {
    TEXT(yaml_layer, name), TEXT(yaml_layer, clip),   TEXT(yaml_layer, mode),
    TEXT(yaml_layer, mask), TEXT(yaml_layer, weight), CYAML_FIELD_END};
static const cyaml_schema_value_t layer_entry = ENTRY(yaml_layer, layer_fields);

static const cyaml_schema_field_t filter_fields[] = {TEXT(yaml_filter, op),
                                                     TEXT(yaml_filter, channel),
                                                     TEXT(yaml_filter, value),
                                                     TEXT(yaml_filter, about),
                                                     TEXT(yaml_filter, min),
                                                     TEXT(yaml_filter, max),
                                                     LIST(yaml_filter, channels, text_entry),
                                                     FREE_FORM("rows"),
                                                     CYAML_FIELD_END};
static const cyaml_schema_value_t filter_entry = ENTRY(yaml_filter, filter_fields);

static const cyaml_schema_field_t trigger_fields[] = {
    TEXT(yaml_trigger, event), TEXT(yaml_trigger, layer), TEXT(yaml_trigger, clip),
    TEXT(yaml_trigger, fade), CYAML_FIELD_END};
static const cyaml_schema_value_t trigger_entry = ENTRY(yaml_trigger, trigger_fields);

static const cyaml_schema_field_t servo_fields[] = {
    TEXT(yaml_servo, name),         TEXT(yaml_servo, channel),
    TEXT(yaml_servo, protocol),     TEXT(yaml_servo, id),
    TEXT(yaml_servo, centre),       TEXT(yaml_servo, per_unit),
    TEXT(yaml_servo, range),        TEXT(yaml_servo, direction),
    TEXT(yaml_servo, trim),         TEXT(yaml_servo, min),
    TEXT(yaml_servo, max),          TEXT(yaml_servo, velocity),
    TEXT(yaml_servo, acceleration), CYAML_FIELD_END};
static const cyaml_schema_value_t servo_entry = ENTRY(yaml_servo, servo_fields);

static const cyaml_schema_field_t shape_fields[] = {
    TEXT(yaml_shape, channel), TEXT(yaml_shape, file), TEXT(yaml_shape, target), CYAML_FIELD_END};
static const cyaml_schema_value_t shape_entry = ENTRY(yaml_shape, shape_fields);

static const cyaml_schema_field_t mesh_fields[] = {TEXT(yaml_mesh, name),
                                                   TEXT(yaml_mesh, file),
                                                   TEXT(yaml_mesh, up),
                                                   TEXT(yaml_mesh, scale),
                                                   TEXT(yaml_mesh, tolerance),
                                                   TEXT(yaml_mesh, bases),
                                                   TEXT(yaml_mesh, bits),
                                                   TEXT(yaml_mesh, mean),
                                                   TEXT(yaml_mesh, affine),
                                                   TEXT(yaml_mesh, every),
                                                   TEXT(yaml_mesh, pieces),
                                                   TEXT(yaml_mesh, normals),
                                                   TEXT(yaml_mesh, sides),
                                                   TEXT(yaml_mesh, cell),
                                                   TEXT(yaml_mesh, texels),
                                                   LIST(yaml_mesh, colour, text_entry),
                                                   LIST(yaml_mesh, shapes, shape_entry),
                                                   CYAML_FIELD_END};
static const cyaml_schema_value_t mesh_entry = ENTRY(yaml_mesh, mesh_fields);

static const cyaml_schema_field_t view_fields[] = {TEXT(yaml_view, name),
                                                   TEXT(yaml_view, projection),
                                                   TEXT(yaml_view, shading),
                                                   TEXT(yaml_view, yaw),
                                                   TEXT(yaml_view, pitch),
                                                   TEXT(yaml_view, roll),
                                                   TEXT(yaml_view, distance),
                                                   TEXT(yaml_view, size),
                                                   TEXT(yaml_view, ambient),
                                                   LIST(yaml_view, target, text_entry),
                                                   LIST(yaml_view, light, text_entry),
                                                   LIST(yaml_view, background, text_entry),
                                                   CYAML_FIELD_END};
static const cyaml_schema_value_t view_entry = ENTRY(yaml_view, view_fields);

static const cyaml_schema_field_t target_fields[] = {TEXT(yaml_target, flash),
                                                     TEXT(yaml_target, ram), CYAML_FIELD_END};

static const cyaml_schema_field_t scene_fields[] = {TEXT(yaml_scene, name),
                                                    TEXT(yaml_scene, tick_rate),
                                                    LIST(yaml_scene, sources, source_entry),
                                                    LIST(yaml_scene, channels, channel_entry),
                                                    LIST(yaml_scene, clips, clip_entry),
                                                    LIST(yaml_scene, masks, mask_entry),
                                                    LIST(yaml_scene, layers, layer_entry),
                                                    LIST(yaml_scene, filters, filter_entry),
                                                    LIST(yaml_scene, triggers, trigger_entry),
                                                    LIST(yaml_scene, servos, servo_entry),
                                                    LIST(yaml_scene, meshes, mesh_entry),
                                                    LIST(yaml_scene, views, view_entry),
                                                    LIST(yaml_scene, bodies, body_entry),
                                                    LIST(yaml_scene, rigs, rig_entry),
                                                    PART(yaml_scene, target, target_fields),
                                                    CYAML_FIELD_END};
static const cyaml_schema_value_t scene_schema = {
    CYAML_VALUE_MAPPING(CYAML_FLAG_POINTER, yaml_scene, scene_fields)};

/* ---- explaining a refusal ----------------------------------------------------------------------
 * libcyaml says "Unexpected key: vaule" with the position of the mapping around it. The tree knows
 * the key's own line and the schema knows the nearest key, so both are walked side by side. */

static const char *const kind_words[] = {[NODE_SCALAR] = "a single value",
                                         [NODE_MAPPING] = "a mapping {key: value}",
                                         [NODE_SEQUENCE] = "a list [..]"};

static int expected_kind(const cyaml_schema_value_t *schema)
{
    return schema->type == CYAML_MAPPING    ? NODE_MAPPING
           : schema->type == CYAML_SEQUENCE ? NODE_SEQUENCE
                                            : NODE_SCALAR;
}

static int explain_kind(const scene_tree *tree, int node, const cyaml_schema_value_t *schema,
                        bake_error *error)
{
    const scene_node *found = &tree->nodes[node];
    int want = expected_kind(schema);
    if (schema->type == CYAML_IGNORE || (int)found->kind == want)
        return 0;
    const char *name = found->key;
    for (int up = node; name == NULL && up >= 0; up = tree->nodes[up].parent)
        name = tree->nodes[up].key;
    return bake_fail(error, "%s:%d: %s'%s' must be %s, found %s", tree->path, found->line,
                     found->key ? "" : "an entry of ", name ? name : "scene", kind_words[want],
                     found->kind == NODE_SCALAR && found->value[0] == '\0'
                         ? "nothing; indent what belongs to it, or remove the key"
                         : kind_words[found->kind]);
}

static int explain_key(const scene_tree *tree, int node, const scene_names *keys, bake_error *error)
{
    char hint[SCENE_HINT_BYTES];
    const scene_node *found = &tree->nodes[node];
    return bake_fail(error, "%s:%d: unknown key '%s'; %s", tree->path, found->line, found->key,
                     scene_names_hint(keys, found->key, hint));
}

/* Recursion follows the tree, so it is at most DEPTH_MAX deep. */
static int explain(const scene_tree *tree, int node, const cyaml_schema_value_t *schema,
                   bake_error *error)
{
    if (explain_kind(tree, node, schema, error))
        return -1;
    if (schema->type != CYAML_MAPPING && schema->type != CYAML_SEQUENCE)
        return 0;
    const cyaml_schema_field_t *fields = schema->mapping.fields;
    scene_names keys = {0};
    if (schema->type == CYAML_MAPPING) {
        keys = (scene_names){fields, sizeof *fields, 0};
        while (fields[keys.count].key != NULL)
            keys.count++;
    }
    for (int i = tree->nodes[node].child; i >= 0; i = tree->nodes[i].next) {
        const cyaml_schema_value_t *value = schema->sequence.entry;
        if (schema->type == CYAML_MAPPING) {
            int field = scene_names_find(&keys, tree->nodes[i].key);
            if (field < 0)
                return explain_key(tree, i, &keys, error);
            value = &fields[field].value;
        }
        if (explain(tree, i, value, error))
            return -1;
    }
    return 0;
}

/* Keeps libcyaml's first complaint: the ones after it are its way through the file. */
static void keep_first(cyaml_log_t level, void *context, const char *format, va_list arguments)
{
    char *first = context;
    if (level >= CYAML_LOG_ERROR && first[0] == '\0')
        vsnprintf(first, 200, format, arguments);
}

static cyaml_config_t config(char *first_complaint)
{
    return (cyaml_config_t){.log_fn = keep_first,
                            .log_ctx = first_complaint,
                            .log_level = CYAML_LOG_ERROR,
                            .mem_fn = cyaml_mem,
                            .flags = CYAML_CFG_NO_ALIAS};
}

int scene_yaml_load(const scene_tree *tree, yaml_scene **out, bake_error *error)
{
    char complaint[200] = "";
    cyaml_config_t settings = config(complaint);
    *out = NULL;
    cyaml_err_t err = cyaml_load_data(tree->text, tree->size, &settings, &scene_schema,
                                      (cyaml_data_t **)out, NULL);
    if (err == CYAML_OK && *out != NULL)
        return 0;
    if (explain(tree, 0, &scene_schema, error))
        return -1;
    complaint[strcspn(complaint, "\n")] = '\0';
    return bake_fail(error, "%s:1: not a scene: %s (%s)", tree->path, complaint,
                     cyaml_strerror(err));
}

void scene_yaml_free(yaml_scene *scene)
{
    char complaint[200] = "";
    cyaml_config_t settings = config(complaint);
    if (scene != NULL)
        cyaml_free(&settings, &scene_schema, scene, 0);
}
