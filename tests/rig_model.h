/* For tests of rigs: vectors, a turn without quaternions, and a rig under construction.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef RIG_MODEL_H
#define RIG_MODEL_H

#include "check.h"
#include "ends.h"
#include "rig.h"
#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BONES = 6, CHANNELS = 40, POINTS = 200 };

static const double pi = 3.14159265358979323846;
static unsigned long state = 1;

/* -1 .. 1 */
static inline double any(void)
{
    state = (state * 1103515245 + 12345) & 0x7fffffff;
    return (double)(state >> 3) / (double)(0x7fffffff >> 3) * 2 - 1;
}

static inline double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static inline double distance(const double a[3], const double b[3])
{
    double way[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(dot(way, way));
}

static inline void unit(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

/* p turned about an axis through the origin: Rodrigues, where the rig has quaternions. */
static inline void turned(const double axis[3], double angle, const double p[3], double out[3])
{
    double side[3], along = dot(axis, p);
    cross(axis, p, side);
    for (int k = 0; k < 3; k++)
        out[k] = p[k] * cos(angle) + side[k] * sin(angle) + axis[k] * along * (1 - cos(angle));
}

/* A rig, values for its channels, what they make of it, and how one vertex follows. */
typedef struct {
    scene_rig rig;
    scene_bone bone[BONES];
    scene_joint joint[BONES][4];
    double value[CHANNELS], weight[BONES], end[BONES];
    rig_bone posed[BONES];
} model;

static inline void add_bone(model *m, int parent, const double from[3], const double to[3])
{
    int index = m->rig.bone_count++;
    scene_bone *b = &m->bone[index];
    *b = (scene_bone){.parent = parent,
                      .kind = distance(from, to) > 0 ? BONE_BONE : BONE_POINT,
                      .joints = m->joint[index],
                      .value = -1,
                      .captured = -1,
                      .travels = -1};
    memcpy(b->from, from, sizeof b->from);
    memcpy(b->to, to, sizeof b->to);
    if (parent >= 0)
        b->along = scene_bone_along(&m->bone[parent], from);
    m->rig.bones = m->bone;
}

static inline scene_joint *add_joint(model *m, int bone, unsigned kind, int channel)
{
    scene_bone *b = &m->bone[bone];
    scene_joint *j = &b->joints[b->joint_count++];
    *j = (scene_joint){.kind = (int)kind, .channel = channel, .axis = {0, 0, 1}};
    return j;
}

static inline void skin(const model *m, const double *end, const double p[3], double out[3])
{
    rig_skin(&m->rig, m->posed, m->weight, end, p, out);
}

static inline void pose(model *m)
{
    rig_pose(&m->rig, m->value, m->posed);
}

/* From 0 to 10 along x, stretched and twisted by channels 0 and 1. */
static inline void make_one(model *m)
{
    static const double from[3] = {0}, to[3] = {10, 0, 0};
    *m = (model){.rig.ends = ENDS_BOUNDED, .value = {1}, .weight = {1}};
    add_bone(m, -1, from, to);
    add_joint(m, 0, WG_JOINT_STRETCH, 0);
    add_joint(m, 0, WG_JOINT_TWIST_END, 1);
    add_joint(m, 0, WG_JOINT_TWIST_START, 2);
}

#endif
