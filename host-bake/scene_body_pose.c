/* Poses of a body.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <string.h>

enum { MODES_MAX = 120 };

static const char pose_example[] = "- {name: reach, drag: [{region: tip, by: [10, 0, 0]}]}";
static const char drag_example[] = "drag: [{region: tip, by: [10, 0, 0]}]";
static const char mode_example[] = "modes: [{mode: 2, by: 15}]";
static const char joint_example[] = "joints: [{link: arm, angle: 40 deg}]";

static const yaml_pose *source(const loader *l)
{
    return &l->yaml->bodies[l->body].poses[l->pose - 1];
}

static scene_pose *current(const loader *l)
{
    return &l->out->bodies[l->body].poses[l->pose];
}

int scene_read_pose_name(const loader *l, const char *field, const char *text, int count, int *out)
{
    if (text == NULL)
        return 0;
    const scene_body *b = &l->out->bodies[l->body];
    *out = loader_find(l, field, count < b->pose_count ? "earlier pose" : "pose", text,
                       SCENE_NAMES(b->poses, count));
    return *out < 0 ? -1 : 0;
}

static int read_mode(loader *l, int index)
{
    static const int range[2] = {1, MODES_MAX};
    const yaml_pose_mode *from = &source(l)->modes[index];
    scene_pose_mode *to = &current(l)->modes[index];
    int chain = l->out->bodies[l->body].kind == SCENE_CHAIN;
    return loader_need(l, "mode", from->mode, mode_example) ||
                   loader_integer(l, "mode", from->mode, range, &to->mode) ||
                   loader_need(l, "by", from->by, mode_example) ||
                   loader_number(l, "by", from->by,
                                 chain ? &scene_value[WG_UNIT_DEGREE][0] : &scene_way, &to->by)
               ? -1
               : 0;
}

static int read_drag(loader *l, int index)
{
    return scene_read_shift(l, 0, &current(l)->drags[index]);
}

static int read_joint(loader *l, int index)
{
    const scene_body *b = &l->out->bodies[l->body];
    const yaml_joint *from = &source(l)->joints[index];
    scene_pose *to = current(l);
    if (loader_need(l, "link", from->link, joint_example) ||
        loader_reference(l, "link", from->link, SCENE_NAMES(b->links, b->link_count),
                         &to->joint[index]) ||
        loader_need(l, "angle", from->angle, joint_example) ||
        loader_number(l, "angle", from->angle, &scene_value[WG_UNIT_DEGREE][0],
                      &to->joint_angle[index]))
        return -1;
    if (b->links[to->joint[index]].stiff)
        return loader_fail(l, "link", "the link '%s' is stiff and has no angle of its own",
                           from->link);
    for (int i = 0; i < index; i++)
        if (to->joint[i] == to->joint[index])
            return loader_fail(l, "link", "the link '%s' has an angle already in this pose",
                               from->link);
    return 0;
}

static int is_planar(const double v[3])
{
    return fabs(v[0]) < 1e-9 && fabs(v[1]) < 1e-9;
}

/* What the body's kind cannot do. */
static int check_fields(const loader *l, const scene_body *b)
{
    static const char *const no_chain[] = {"file", "drag"};
    if (b->kind != SCENE_CHAIN)
        return loader_has(l, "joints")
                   ? loader_fail(l, "joints", "the body '%s' is no chain and has no joints",
                                 b->name)
                   : 0;
    for (int i = 0; i < 2; i++)
        if (loader_has(l, no_chain[i]))
            return loader_fail(l, no_chain[i], "a chain's pose has no '%s'; write for example:  %s",
                               no_chain[i], joint_example);
    for (int i = 0; i < 2 && !b->free_root; i++) {
        const char *field = i ? "turn" : "move";
        if (loader_has(l, field))
            return loader_fail(
                l, field, "'%s' moves the root of the chain '%s', which needs 'free_root: true'",
                field, b->name);
    }
    return 0;
}

/* After everything else: turn and move, of a chain within its plane. */
static int read_place(loader *l, scene_pose *to)
{
    int chain = l->out->bodies[l->body].kind == SCENE_CHAIN;
    if (scene_read_turn(l, 0, to->axis, &to->angle) ||
        loader_numbers(l, "move", 3, &scene_way, to->move))
        return -1;
    if (chain && !is_planar(to->axis))
        return loader_fail(l, "turn", "a chain turns about z only");
    if (chain && fabs(to->move[2]) > 0)
        return loader_fail(l, "move",
                           "a chain moves in its plane only: the third number must be 0");
    return 0;
}

static int read_parts(loader *l, const yaml_pose *from, scene_pose *to)
{
    to->drag_count = loader_list_count(l, "drag");
    to->mode_count = (int)from->modes_count;
    to->joint_count = (int)from->joints_count;
    size_t joints = from->joints_count + 1;
    to->modes = bake_alloc(from->modes_count + 1, sizeof *to->modes);
    to->drags = bake_alloc((size_t)to->drag_count + 1, sizeof *to->drags);
    to->joint = bake_alloc(joints, sizeof *to->joint);
    to->joint_angle = bake_alloc(joints, sizeof *to->joint_angle);
    return loader_each(l, "modes", read_mode) || loader_list(l, "drag", drag_example, read_drag) ||
                   loader_each(l, "joints", read_joint) || read_place(l, to)
               ? -1
               : 0;
}

int scene_read_pose(loader *l, int index)
{
    const yaml_body *y = &l->yaml->bodies[l->body];
    const yaml_pose *from = &y->poses[index];
    scene_body *b = &l->out->bodies[l->body];
    l->pose = index + 1;
    scene_pose *to = current(l);
    to->line = scene_tree_line(l->tree, l->node, NULL);
    to->of = -1;
    if (loader_name(l, SCENE_NAMES(y->poses, y->poses_count), index, pose_example, &to->name))
        return -1;
    if (strcmp(to->name, "rest") == 0)
        return loader_fail(l, "name",
                           "every body has a pose 'rest', as it was made; choose another name");
    if (check_fields(l, b) || scene_read_pose_name(l, "of", from->of, l->pose, &to->of) ||
        read_parts(l, from, to))
        return -1;
    if (to->of == 0)
        to->of = -1;
    if (from->file != NULL && (loader_need(l, "file", from->file, "file: bent.obj") ||
                               loader_file(l, from->file, &to->file)))
        return -1;
    if (from->file == NULL && to->mode_count + to->drag_count + to->joint_count == 0 &&
        !loader_has(l, "turn") && !loader_has(l, "move"))
        return loader_fail(l, NULL,
                           "the pose '%s' differs in nothing from '%s'; write for example:  %s",
                           to->name, to->of < 0 ? "rest" : b->poses[to->of].name,
                           b->kind == SCENE_CHAIN ? joint_example : drag_example);
    return 0;
}
