/* Joints of bones, and points that follow others, by closed forms.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_model.h"

/* ---- joints -------------------------------------------------------------------------------------- */

static void joints_act_in_their_order(void)
{
    static const double from[3] = {1, 2, 3}, to[3] = {2, 2, 3};
    for (int turn_first = 0; turn_first < 2; turn_first++) {
        model m = {.value = {90, 5}};
        add_bone(&m, -1, from, to);
        if (turn_first)
            add_joint(&m, 0, WG_JOINT_TURN, 0);
        scene_joint *j = add_joint(&m, 0, WG_JOINT_MOVE, 1);
        memcpy(j->axis, (double[3]){1, 0, 0}, sizeof j->axis);
        if (!turn_first)
            add_joint(&m, 0, WG_JOINT_TURN, 0);
        pose(&m);
        double moved[3] = {1 + (turn_first ? 0 : 5), 2 + (turn_first ? 5 : 0), 3};
        CHECK_NEAR(distance(m.posed[0].at, moved), 0, 1e-13);
        CHECK_NEAR(m.posed[0].turn[1], -1, 1e-15);
    }
}

/* What skins_prepare writes as joints and what it has not yet written are the same motion. */
static void depth_travel_and_captures_are_joints(void)
{
    static const double from[3] = {1, 2, 3}, to[3] = {2, 2, 3};
    model a = {.value = {0.5, 0.5, -0.5, 0.5, 7, 8, 9, 33, 4}}, b = a;
    add_bone(&a, -1, from, to);
    add_joint(&a, 0, WG_JOINT_TURN, 7);
    a.bone[0].depth = 4;
    a.bone[0].travels = 4;
    a.bone[0].captured = 0;
    pose(&a);
    scene_joint joints[6];
    add_bone(&b, -1, from, to);
    b.bone[0].joints = joints;
    add_joint(&b, 0, WG_JOINT_MOVE, 8);
    for (int k = 0; k < 3; k++) {
        scene_joint *j = add_joint(&b, 0, WG_JOINT_MOVE, 4 + k);
        memset(j->axis, 0, sizeof j->axis);
        j->axis[k] = 1;
    }
    add_joint(&b, 0, WG_JOINT_TURN, 7);
    add_joint(&b, 0, WG_JOINT_QUATERNION, 0);
    pose(&b);
    CHECK_NEAR(distance(a.posed[0].at, (double[3]){8, 10, 16}), 0, 1e-13);
    CHECK(memcmp(&a.posed[0], &b.posed[0], sizeof a.posed[0]) == 0);
}

/* The player's limits: a bone is not shorter than a point, nor more than nine times as long. */
static void stretches_are_limited(void)
{
    model m;
    make_one(&m);
    for (int i = 0; i < 3; i++) {
        static const double value[3] = {-3, 9.5, 4}, longer[3] = {-10, 80, 30};
        m.value[0] = value[i];
        pose(&m);
        CHECK_NEAR(m.posed[0].stretch, longer[i], 1e-13);
    }
}

/* Between keys a captured quaternion is shorter; its direction is what turns. */
static void quaternions_turn_at_any_length(void)
{
    static const double from[3] = {0}, to[3] = {1, 0, 0};
    for (int i = 0; i < 4; i++) {
        static const double length[4] = {1, 0.6, 1.0 / 33, 0};
        model m = {.value = {length[i] * cos(pi / 6), 0, 0, length[i] * sin(pi / 6)}};
        add_bone(&m, -1, from, to);
        add_joint(&m, 0, WG_JOINT_QUATERNION, 0);
        pose(&m);
        CHECK_NEAR(m.posed[0].turn[0], i < 3 ? 0.5 : 1, 1e-15);
        CHECK_NEAR(m.posed[0].turn[3], i < 3 ? sqrt(0.75) : 0, 1e-15);
    }
}

/* ---- points that follow others ------------------------------------------------------------------- */

/* A point at the origin that follows `count` points, each moved by channels 3 i .. 3 i + 2. */
static void make_star(model *m, const double (*at)[3], int count)
{
    static int order[BONES] = {1, 2, 3, 4, 5};
    static const double origin[3] = {0};
    *m = (model){0};
    add_bone(m, -1, origin, origin);
    for (int i = 0; i < count; i++) {
        add_bone(m, -1, at[i], at[i]);
        for (int k = 0; k < 3; k++) {
            scene_joint *j = add_joint(m, i + 1, WG_JOINT_MOVE, 3 * i + k);
            memset(j->axis, 0, sizeof j->axis);
            j->axis[k] = 1;
        }
    }
    scene_joint *j = add_joint(m, 0, WG_JOINT_FOLLOW, -1);
    j->follow = order;
    j->follow_count = count;
}

static void aim(model *m, int bone, const double to[3])
{
    for (int k = 0; k < 3; k++)
        m->value[3 * (bone - 1) + k] = to[k] - m->bone[bone].from[k];
}

/* The rotation takes each way's direction to where it has gone, whatever their lengths; of several
 * that turn alike it is theirs. */
static void a_point_turns_with_the_ways_to_others(void)
{
    for (int i = 0; i < POINTS; i++) {
        double at[3][3], to[3], axis[3] = {0, 0, any() < 0 ? -1 : 1}, angle = 3 * any(), way[3];
        model m;
        for (int k = 0; k < 9; k++)
            at[k / 3][k % 3] = k % 3 < 2 ? any() : 0;
        make_star(&m, (const double(*)[3])at, 1 + i % 3);
        for (int k = 1; k < m.rig.bone_count; k++) {
            turned(axis, angle, m.bone[k].from, to);
            for (int c = 0; c < 3; c++)
                to[c] *= 0.5 + k;
            aim(&m, k, to);
        }
        pose(&m);
        double p[3] = {any(), any(), 0}, out[3];
        turned(axis, angle, p, way);
        m.weight[0] = 1;
        skin(&m, NULL, p, out);
        CHECK_NEAR(distance(out, way), 0, 1e-10); /* ways of 1e-2 turn by rounding of places of 1 */
    }
}

/* The shortest arc in space. */
static void a_way_in_space_turns_by_the_shortest_arc(void)
{
    for (int i = 0; i < POINTS; i++) {
        double at[1][3] = {{any(), any(), any()}}, to[3] = {any(), any(), any()}, axis[3];
        model m;
        make_star(&m, (const double(*)[3])at, 1);
        aim(&m, 1, to);
        pose(&m);
        cross(at[0], to, axis);
        unit(axis);
        unit(at[0]);
        unit(to);
        double angle = acos(fmin(1, fmax(-1, dot(at[0], to)))), p[3] = {any(), any(), any()};
        double out[3], want[3];
        turned(axis, angle, p, want);
        m.weight[0] = 1;
        skin(&m, NULL, p, out);
        CHECK_NEAR(distance(out, want), 0, 1e-8); /* acos near 1 */
    }
}

/* Ways that turn by a and b in a plane: half way between. What has no direction is left out. */
static void several_ways_turn_by_their_mean(void)
{
    static const double at[3][3] = {{2, 0, 0}, {0, 3, 0}, {-1, 0, 0}};
    static const double z[3] = {0, 0, 1};
    model m;
    double to[3];
    make_star(&m, at, 3);
    turned(z, 0.3, at[0], to);
    aim(&m, 1, to);
    turned(z, 1.1, at[1], to);
    aim(&m, 2, to);
    aim(&m, 3, (double[3]){1, 0, 0}); /* half a turn, about no axis of its own */
    pose(&m);
    CHECK_NEAR(atan2(m.posed[0].turn[3], m.posed[0].turn[0]), 0.7, 1e-14);
    aim(&m, 3, (double[3]){0, 0, 0}); /* now in the point itself */
    pose(&m);
    CHECK_NEAR(atan2(m.posed[0].turn[3], m.posed[0].turn[0]), 0.7, 1e-14);
    aim(&m, 1, (double[3]){0, 0, 0});
    aim(&m, 2, (double[3]){0, 0, 0});
    pose(&m);
    CHECK(m.posed[0].turn[0] == 1 && m.posed[0].turn[3] == 0);
}

/* A bone alone moves what follows it; the weights of a shift need not be bounded. */
static void a_shift_is_the_mean_of_ways(void)
{
    static const double at[2][3] = {{1, 0, 0}, {0, 1, 0}};
    model m;
    make_star(&m, at, 2);
    m.rig.method = WG_SKIN_SHIFT;
    aim(&m, 1, (double[3]){1, 2, 0});
    aim(&m, 2, (double[3]){3, 1, 1});
    pose(&m);
    m.weight[0] = -0.25;
    m.weight[1] = 0.25;
    m.weight[2] = 1;
    double p[3] = {5, 6, 7}, out[3];
    skin(&m, NULL, p, out);
    CHECK_NEAR(distance(out, (double[3]){5 + 3, 6 + 0.5, 7 + 1}), 0, 1e-14);
}

int main(void)
{
    TEST(joints_act_in_their_order);
    TEST(depth_travel_and_captures_are_joints);
    TEST(stretches_are_limited);
    TEST(quaternions_turn_at_any_length);
    TEST(a_point_turns_with_the_ways_to_others);
    TEST(a_way_in_space_turns_by_the_shortest_arc);
    TEST(several_ways_turn_by_their_mean);
    TEST(a_shift_is_the_mean_of_ways);
    return check_done();
}
