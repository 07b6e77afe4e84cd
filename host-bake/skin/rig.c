/* A rig in doubles: the mathematics of SPEC 6.9 and 6.10 without its roundings.
 * Source: Jacobson 2013, 4.3.4 (pseudo-edges), (6.2), (6.5), (6.6); Kavan et al. 2008 (dual
 * quaternions). Own: the order of joints.
 *
 *   R  3 x 3, row by row                     q  w x y z
 *   u  a bone's direction at rest, length 1  e  0 at a bone's start, 1 at its end
 *   S  by how much a bone is longer
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig.h"
#include "vector.h"

#include "wiggly_format.h"

#include <math.h>
#include <string.h>

static const double radian = 3.14159265358979323846 / 180;

/* The player's limits of a bone's length over that at rest, less 1. */
static const double least_stretch = -1, most_stretch = 8;

/* The player has no direction for quaternions whose squares sum to less. */
static const double least_square = 1.0 / 1024;

static void multiply(const double a[4], const double b[4], double out[4])
{
    const double product[4] = {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                               a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                               a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                               a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
    memcpy(out, product, sizeof product);
}

static void about(const double axis[3], double angle, double out[4])
{
    double s = sin(angle / 2);
    out[0] = cos(angle / 2);
    for (int k = 0; k < 3; k++)
        out[k + 1] = s * axis[k];
}

static double square(const double q[4])
{
    return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
}

/* The rotation of a quaternion of any length. */
static void matrix(const double q[4], double R[9])
{
    double n = square(q), t = n < least_square ? 0 : 2 / n;
    double w = q[0], x = q[1], y = q[2], z = q[3];
    const double all[9] = {
        1 - t * (y * y + z * z), t * (x * y - w * z),     t * (x * z + w * y),
        t * (x * y + w * z),     1 - t * (x * x + z * z), t * (y * z - w * x),
        t * (x * z - w * y),     t * (y * z + w * x),     1 - t * (x * x + y * y)};
    memcpy(R, all, sizeof all);
}

static void rotate(const double R[9], const double p[3], double out[3])
{
    for (int r = 0; r < 3; r++)
        out[r] = vector_dot(R + 3 * r, p);
}

/* The bone's length at rest; u = 0 where it has none. */
static double direction(const scene_bone *b, double u[3])
{
    for (int k = 0; k < 3; k++)
        u[k] = b->to[k] - b->from[k];
    double length = sqrt(vector_dot(u, u));
    for (int k = 0; k < 3; k++)
        u[k] = length > 0 ? u[k] / length : 0;
    return length;
}

static double twist(const rig_bone *b, double e)
{
    return (1 - e) * b->twist[0] + e * b->twist[1];
}

/* ---- bones: SPEC 6.9 ------------------------------------------------------------------------- */

/* Where its parent puts it. */
static void hang(const scene_rig *rig, int bone, rig_bone *all)
{
    const scene_bone *b = &rig->bones[bone];
    rig_bone *to = &all[bone];
    *to = (rig_bone){.quaternion = {1}};
    memcpy(to->at, b->from, sizeof to->at);
    if (b->parent >= 0) {
        const scene_bone *p = &rig->bones[b->parent];
        const rig_bone *from = &all[b->parent];
        double u[3], turn[4], way[3], e = b->along;
        direction(p, u);
        about(u, twist(from, e), turn);
        multiply(from->quaternion, turn, to->quaternion);
        matrix(to->quaternion, to->turn);
        for (int k = 0; k < 3; k++)
            way[k] = b->from[k] - p->from[k] + e * from->stretch * u[k];
        rotate(to->turn, way, to->at);
        for (int k = 0; k < 3; k++)
            to->at[k] += from->at[k];
    }
    matrix(to->quaternion, to->turn);
}

static void turn_by(rig_bone *b, const double q[4])
{
    multiply(b->quaternion, q, b->quaternion);
    matrix(b->quaternion, b->turn);
}

/* By the rotation of a quaternion of any length but 0, as the player divides it out: a dual quaternion
 * blend weighs by lengths. */
static void turn_by_any(rig_bone *b, const double q[4])
{
    double one[4], length = sqrt(square(q));
    for (int k = 0; k < 4 && length > 0; k++)
        one[k] = q[k] / length;
    if (length > 0)
        turn_by(b, one);
}

static void move_by(rig_bone *b, const double axis[3], double way)
{
    for (int r = 0; r < 3; r++)
        b->at[r] += way * vector_dot(b->turn + 3 * r, axis);
}

static void act(const scene_joint *j, const double *values, double length, rig_bone *b)
{
    double v = j->channel >= 0 ? values[j->channel] : 0, q[4];
    switch ((unsigned)j->kind) {
    case WG_JOINT_TURN:
        about(j->axis, v * radian, q);
        turn_by(b, q);
        break;
    case WG_JOINT_MOVE:
        move_by(b, j->axis, v);
        break;
    case WG_JOINT_QUATERNION:
        turn_by_any(b, values + j->channel);
        break;
    case WG_JOINT_STRETCH:
        b->stretch = fmin(most_stretch, fmax(least_stretch, v - 1)) * length;
        break;
    case WG_JOINT_TWIST_START:
        b->twist[0] = v * radian;
        break;
    case WG_JOINT_TWIST_END:
        b->twist[1] = v * radian;
        break;
    default: /* FOLLOW: when all bones are placed */
        break;
    }
}

/* What moves a bone in the order in which skins_prepare makes it joints, where
 * it has not yet. */
static void pose_bone(const scene_bone *from, const double *values, rig_bone *b)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double u[3], length = direction(from, u);
    move_by(b, axes[2], from->depth);
    for (int k = 0; k < 3 && from->travels >= 0; k++)
        move_by(b, axes[k], values[from->travels + k]);
    for (int i = 0; i < from->joint_count; i++)
        act(&from->joints[i], values, length, b);
    if (from->captured >= 0)
        turn_by_any(b, values + from->captured);
}

/* Adds the rotation of the way from one point to another since rest, as a
 * quaternion of length 1. */
static void add_turn(const double rest[3], const double now[3], double sum[4])
{
    double h[4], sizes = sqrt(vector_dot(rest, rest) * vector_dot(now, now));
    h[0] = sizes + vector_dot(rest, now);
    vector_cross(rest, now, h + 1);
    double length = sqrt(square(h));
    for (int k = 0; k < 4 && sizes > 0 && length > 0; k++)
        sum[k] += h[k] / length;
}

/* A point turns as the ways to other points do, in the mean [4.3.4]. */
static void follow(const scene_rig *rig, int bone, rig_bone *all)
{
    const scene_bone *b = &rig->bones[bone];
    const scene_joint *j = b->joint_count > 0 ? &b->joints[b->joint_count - 1] : NULL;
    double sum[4] = {0};
    if (j == NULL || j->kind != (int)WG_JOINT_FOLLOW)
        return;
    for (int i = 0; i < j->follow_count; i++) {
        double rest[3], now[3];
        for (int k = 0; k < 3; k++) {
            rest[k] = rig->bones[j->follow[i]].from[k] - b->from[k];
            now[k] = all[j->follow[i]].at[k] - all[bone].at[k];
        }
        add_turn(rest, now, sum);
    }
    double length = sqrt(square(sum));
    for (int k = 0; k < 4 && length > 0; k++)
        sum[k] /= length; /* dual quaternions are weighed by their lengths */
    if (length > 0)
        turn_by(&all[bone], sum);
}

void rig_pose(const scene_rig *rig, const double *values, rig_bone *out)
{
    for (int i = 0; i < rig->bone_count; i++) {
        hang(rig, i, out);
        pose_bone(&rig->bones[i], values, &out[i]);
    }
    for (int i = 0; i < rig->bone_count; i++)
        follow(rig, i, out);
}

/* ---- vertices: SPEC 6.10 --------------------------------------------------------------------- */

/* Adds a bone's place of a point: at + R K(e) (e S u + p - o). e < 0: without endpoint weights, at +
 * R (p - o).                                                              [Jacobson (6.2), (6.5)] */
static void add_linear(const scene_bone *from, const rig_bone *b, const double w_e[2],
                       const double p[3], double out[3])
{
    double u[3], q[3], side[3], at[3], e = w_e[1];
    double angle = e < 0 ? 0 : twist(b, e), longer = e < 0 ? 0 : e * b->stretch;
    direction(from, u);
    for (int k = 0; k < 3; k++)
        q[k] = p[k] - from->from[k];
    double along = vector_dot(u, q);
    vector_cross(u, q, side);
    for (int k = 0; k < 3; k++)
        q[k] = (along + longer) * u[k] + cos(angle) * (q[k] - along * u[k]) + sin(angle) * side[k];
    rotate(b->turn, q, at);
    for (int k = 0; k < 3; k++)
        out[k] += w_e[0] * (b->at[k] + at[k]);
}

/* The bone's motion there as a dual quaternion: q_e = q K(e), and x_e q_e - q_e o, which is t q_e. e < 0:
 * without endpoint weights, q.
 *                                                                                 [Jacobson (6.6)] */
static void dual(const scene_bone *from, const rig_bone *b, double e, double real[4],
                 double imaginary[4])
{
    double u[3], turn[4], x[4] = {0}, o[4] = {0}, back[4], angle = e < 0 ? 0 : twist(b, e);
    e = fmax(e, 0);
    direction(from, u);
    about(u, angle, turn);
    multiply(b->quaternion, turn, real);
    for (int k = 0; k < 3; k++) {
        x[k + 1] = b->at[k] + e * b->stretch * vector_dot(b->turn + 3 * k, u);
        o[k + 1] = from->from[k];
    }
    multiply(x, real, imaginary);
    multiply(real, o, back);
    for (int k = 0; k < 4; k++)
        imaginary[k] -= back[k];
}

static double end_of(const double *end, int bone)
{
    return end != NULL ? end[bone] : -1;
}

static void skin_dual(const scene_rig *rig, const rig_bone *bones, const double *weight,
                      const double *end, const double point[3], double out[3])
{
    double first[4], real[4], imaginary[4], b[4] = {0}, B[4] = {0}, R[9], t[4];
    int most = 0;
    for (int i = 1; i < rig->bone_count; i++)
        most = weight[i] > weight[most] ? i : most;
    dual(&rig->bones[most], &bones[most], end_of(end, most), first, imaginary);
    for (int i = 0; i < rig->bone_count; i++) {
        if (!(fabs(weight[i]) > 0))
            continue;
        dual(&rig->bones[i], &bones[i], end_of(end, i), real, imaginary);
        double same = first[0] * real[0] + vector_dot(first + 1, real + 1);
        double w = same < 0 ? -weight[i] : weight[i];
        for (int k = 0; k < 4; k++) {
            b[k] += w * real[k];
            B[k] += w * imaginary[k];
        }
    }
    memcpy(out, point, 3 * sizeof *out);
    if (square(b) < least_square)
        return;
    multiply(B, (double[4]){b[0], -b[1], -b[2], -b[3]}, t);
    matrix(b, R);
    rotate(R, point, out);
    for (int k = 0; k < 3; k++)
        out[k] += t[k + 1] / square(b);
}

void rig_skin(const scene_rig *rig, const rig_bone *bones, const double *weight, const double *end,
              const double point[3], double out[3])
{
    if (rig->method == (int)WG_SKIN_DUAL) {
        double at[3];
        skin_dual(rig, bones, weight, end, point, at);
        memcpy(out, at, sizeof at);
        return;
    }
    double sum[3] = {0};
    if (rig->method == (int)WG_SKIN_SHIFT)
        memcpy(sum, point, sizeof sum);
    for (int i = 0; i < rig->bone_count; i++) {
        if (!(fabs(weight[i]) > 0))
            continue;
        if (rig->method == (int)WG_SKIN_SHIFT)
            for (int k = 0; k < 3; k++)
                sum[k] += weight[i] * (bones[i].at[k] - rig->bones[i].from[k]);
        else
            add_linear(&rig->bones[i], &bones[i], (double[2]){weight[i], end_of(end, i)}, point,
                       sum);
    }
    memcpy(out, sum, sizeof sum);
}
