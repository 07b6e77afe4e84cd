/* What a scene file says, as text: the shape libcyaml loads. Numbers, words and units are still
 * strings here, because people write "1500 us"; scene*.c turns them into scene.h's arrays. NULL or
 * a count of 0 means absent. Fields with free-form values are read from the tree instead:
 * mask.weights, filter.rows, curve.start, curve.end, curve.axis; region.box, slide.normal,
 * output.direction, output.turn, pose.drag, pose.turn, body.material, body_key.velocity, action.start,
 * action.end; joint's turn to follow, bone.from, bone.to, bone.at, bone.cage, field.at, rig.cage,
 * rig.filter.
 * Every struct begins with the text that names it, so that scene_names can walk arrays of them.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SCENE_YAML_H
#define BAKE_SCENE_YAML_H

#include "scene_tree.h"

typedef struct {
    char *name, *file, *animation;
} yaml_source;

typedef struct {
    char *name, *unit, *rest, *tolerance;
    char **range;
    unsigned range_count;
} yaml_channel;

typedef struct {
    char *time, *value, *velocity, *acceleration, *weight;
} yaml_key;

typedef struct {
    char *channel, *kind;
    char *frequency, *damping, *lambda, *delta, *force, *periodic;
    char **regularise;
    unsigned regularise_count;
    yaml_key *keys;
    unsigned keys_count;
    char *source, *node, *component, *column, *scale, *offset, *from, *to;
} yaml_curve;

typedef struct {
    char *name, *time;
} yaml_mark;

typedef struct {
    char *channel, *file, *target;
} yaml_shape;

typedef struct {
    char *name, *file, *up, *scale, *tolerance, *bases, *bits, *mean, *affine, *every, *pieces;
    char *normals, *sides, *cell, *texels;
    char **colour;
    unsigned colour_count;
    yaml_shape *shapes;
    unsigned shapes_count;
} yaml_mesh;

typedef struct {
    char *mesh, *file, *rate;
    char **frames;
    unsigned frames_count;
} yaml_motion;

typedef struct {
    char *name, *projection, *shading, *yaw, *pitch, *roll, *distance, *size, *ambient;
    char **target, **light, **background;
    unsigned target_count, light_count, background_count;
} yaml_view;

typedef struct {
    char *flash, *ram;
} yaml_target;

typedef struct {
    char *x, *y, *z;
} yaml_axes;

typedef struct {
    char *radius;
    char **centre;
    unsigned centre_count;
} yaml_ball;

typedef struct {
    char *name;
    yaml_ball *ball;
    yaml_axes *above, *below;
    char **vertices;
    unsigned vertices_count;
} yaml_region;

typedef struct {
    char *region;
} yaml_slide;

typedef struct {
    char *mode, *by;
} yaml_pose_mode;

typedef struct {
    char *link, *angle;
} yaml_joint;

typedef struct {
    char *name, *of, *file;
    yaml_pose_mode *modes;
    char **move;
    yaml_joint *joints;
    unsigned modes_count, move_count, joints_count;
} yaml_pose;

typedef struct {
    char *channel, *region, *joint;
} yaml_output;

typedef struct {
    char *name, *parent, *stiff, *length, *angle, *mass, *spring;
    char **density;
    unsigned density_count;
} yaml_link;

typedef struct {
    char *name, *kind, *mesh, *unit, *thickness, *cell, *modes, *free_root, *root_mass, *width;
    char **attached, **gravity, **fixed, **damping;
    yaml_slide *sliding;
    yaml_region *regions;
    yaml_pose *poses;
    yaml_output *outputs;
    yaml_link *links;
    unsigned attached_count, gravity_count, fixed_count, damping_count, sliding_count;
    unsigned regions_count, poses_count, outputs_count, links_count;
} yaml_body;

typedef struct {
    char *time, *pose, *weight, *velocity_weight, *region;
} yaml_body_key;

/* what the joint does and its limits are read from the tree */
typedef struct {
    char *channel;
} yaml_rig_joint;

typedef struct {
    char *name, *parent, *depth, *value, *weightless, *node;
    yaml_region *region;
    yaml_rig_joint *joints;
    unsigned joints_count;
} yaml_bone;

typedef struct {
    char *stiffness;
    yaml_region *region;
} yaml_brush;

typedef struct {
    char *channel;
} yaml_field;

typedef struct {
    char *name, *mesh, *method, *ends, *weights, *influences, *tolerance, *cell, *lift, *wrap;
    char *file, *paint;
    yaml_bone *bones;
    yaml_brush *brush;
    yaml_field *fields;
    unsigned bones_count, brush_count, fields_count;
} yaml_rig;

typedef struct {
    char *rig, *source, *from, *to, *scale, *travel;
} yaml_take;

typedef struct {
    char *body, *dynamics, *about, *stiffness, *periodic, *add;
    char **fixed, **damping, **regularise;
    yaml_slide *sliding;
    yaml_body_key *keys;
    unsigned fixed_count, damping_count, regularise_count, sliding_count, keys_count;
} yaml_action;

typedef struct {
    char *name, *duration, *end, *additive;
    yaml_mark *events;
    unsigned events_count;
    yaml_curve *curves;
    unsigned curves_count;
    yaml_motion *meshes;
    unsigned meshes_count;
    yaml_action *bodies;
    unsigned bodies_count;
    yaml_take *rigs;
    unsigned rigs_count;
} yaml_clip;

typedef struct {
    char *name;
} yaml_mask;

typedef struct {
    char *name, *clip, *mode, *mask, *weight;
} yaml_layer;

typedef struct {
    char *op, *channel, *value, *about, *min, *max;
    char **channels;
    unsigned channels_count;
} yaml_filter;

typedef struct {
    char *event, *layer, *clip, *fade;
} yaml_trigger;

typedef struct {
    char *name, *channel, *protocol, *id, *centre, *per_unit, *range, *direction, *trim;
    char *min, *max, *velocity, *acceleration;
} yaml_servo;

typedef struct {
    char *name, *tick_rate;
    yaml_source *sources;
    yaml_channel *channels;
    yaml_clip *clips;
    yaml_mask *masks;
    yaml_layer *layers;
    yaml_filter *filters;
    yaml_trigger *triggers;
    yaml_servo *servos;
    yaml_mesh *meshes;
    yaml_view *views;
    yaml_body *bodies;
    yaml_rig *rigs;
    yaml_target *target;
    unsigned sources_count, channels_count, clips_count, masks_count;
    unsigned layers_count, filters_count, triggers_count, servos_count;
    unsigned meshes_count, views_count, bodies_count, rigs_count;
} yaml_scene;

/* Checks the tree's text against the schema and loads it. */
int scene_yaml_load(const scene_tree *tree, yaml_scene **out, bake_error *error);
void scene_yaml_free(yaml_scene *scene);

#endif
