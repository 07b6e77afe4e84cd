/* Vertices of rigs in doubles, by other evaluations of the same formulas and by closed forms.
 * A tolerance of 1e-12 of the size is rounding: a dozen products and sums of numbers of that size, each with
 * a relative error of 1.1e-16, through chains of four bones; 1e-13 where there is no chain.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_model.h"

static const double near = 1e-12; /* of sizes around 1 */

/* Bone 0 is a point that carries all others: its channels 0 to 6 are a quaternion and a way. */
static void make_any(model *m)
{
    static const double origin[3] = {0};
    *m = (model){.rig.ends = ENDS_BOUNDED, .value = {1}};
    add_bone(m, -1, origin, origin);
    for (int k = 0; k < 3; k++) {
        scene_joint *j = add_joint(m, 0, WG_JOINT_MOVE, 4 + k);
        memset(j->axis, 0, sizeof j->axis);
        j->axis[k] = 1;
    }
    add_joint(m, 0, WG_JOINT_QUATERNION, 0);
    for (int i = 1; i < BONES; i++) {
        double from[3] = {any(), any(), any()}, to[3] = {any(), any(), any()};
        add_bone(m, i == 3 ? 0 : i - 1, from, to);
        add_joint(m, i, WG_JOINT_TURN, 7 + 4 * i);
        for (int k = 0; k < 3; k++)
            m->joint[i][0].axis[k] = any();
        unit(m->joint[i][0].axis);
        add_joint(m, i, WG_JOINT_STRETCH, 8 + 4 * i);
        add_joint(m, i, WG_JOINT_TWIST_START, 9 + 4 * i);
        add_joint(m, i, WG_JOINT_TWIST_END, 10 + 4 * i);
        m->value[8 + 4 * i] = 1;
    }
}

static void move_any(model *m)
{
    for (int i = 1; i < BONES; i++) {
        m->value[7 + 4 * i] = 170 * any();
        m->value[8 + 4 * i] = 1.5 + any();
        m->value[9 + 4 * i] = 400 * any();
        m->value[10 + 4 * i] = 400 * any();
    }
}

static void any_influence(model *m)
{
    double sum = 0;
    for (int i = 0; i < m->rig.bone_count; i++) {
        sum += m->weight[i] = fabs(any());
        m->end[i] = fabs(any());
    }
    for (int i = 0; i < m->rig.bone_count; i++)
        m->weight[i] /= sum;
}

/* T1 */
static void at_rest_nothing_moves(void)
{
    static const unsigned methods[] = {WG_SKIN_LINEAR, WG_SKIN_DUAL, WG_SKIN_SHIFT};
    model m;
    make_any(&m);
    pose(&m);
    for (int i = 0; i < POINTS; i++) {
        double p[3] = {any(), any(), any()}, out[3];
        any_influence(&m);
        for (int k = 0; k < 3; k++) {
            m.rig.method = (int)methods[k];
            skin(&m, m.end, p, out);
            CHECK_NEAR(distance(out, p), 0, near);
            skin(&m, NULL, p, out);
            CHECK_NEAR(distance(out, p), 0, near);
        }
    }
}

/* (6.4), (6.5) from the matrices of the bones alone: sum of w (a' + R K (e s + p - a)). */
static void direct(const model *m, const double p[3], double out[3])
{
    memset(out, 0, 3 * sizeof *out);
    for (int i = 0; i < BONES; i++) {
        const scene_bone *b = &m->bone[i];
        const rig_bone *now = &m->posed[i];
        double u[3], q[3], e = m->end[i], length = distance(b->from, b->to);
        double angle = (1 - e) * now->twist[0] + e * now->twist[1];
        for (int k = 0; k < 3; k++) {
            u[k] = length > 0 ? (b->to[k] - b->from[k]) / length : 0;
            q[k] = p[k] - b->from[k] + e * now->stretch * u[k];
        }
        if (length > 0)
            turned(u, angle, (double[3]){q[0], q[1], q[2]}, q);
        for (int k = 0; k < 3; k++)
            out[k] += m->weight[i] * (now->at[k] + dot(now->turn + 3 * k, q));
    }
}

/* T11 */
static void linear_equals_the_direct_formula(void)
{
    model m;
    make_any(&m);
    for (int i = 0; i < POINTS; i++) {
        double p[3] = {any(), any(), any()}, out[3], want[3];
        move_any(&m);
        pose(&m);
        any_influence(&m);
        skin(&m, m.end, p, out);
        direct(&m, p, want);
        CHECK_NEAR(distance(out, want), 0, 10 * near); /* angles of 7 rad, stretches of 2.5 */
    }
}

/* T11, (6.5) in cylindrical coordinates of the bone: along, radius, and angle about it. */
static void linear_equals_the_cylindrical_form(void)
{
    model m;
    make_any(&m);
    for (int i = 0; i < POINTS; i++) {
        double p[3] = {any(), any(), any()}, out[3], u[3], f[3], g[3], q[3], want[3];
        int bone = 1 + i % (BONES - 1);
        const scene_bone *b = &m.bone[bone];
        const rig_bone *now = &m.posed[bone];
        move_any(&m);
        pose(&m);
        any_influence(&m);
        memset(m.weight, 0, sizeof m.weight);
        m.weight[bone] = 1;
        double e = m.end[bone], phi = (1 - e) * now->twist[0] + e * now->twist[1];
        for (int k = 0; k < 3; k++) {
            u[k] = b->to[k] - b->from[k];
            q[k] = p[k] - b->from[k];
        }
        unit(u);
        cross(u, (double[3]){u[1], u[2], -u[0]}, f);
        unit(f);
        cross(u, f, g);
        double radius = hypot(dot(f, q), dot(g, q)), psi = atan2(dot(g, q), dot(f, q));
        double along = dot(u, q) + e * now->stretch;
        for (int k = 0; k < 3; k++) {
            const double *R = now->turn + 3 * k;
            want[k] = now->at[k] + along * dot(R, u) + radius * cos(phi + psi) * dot(R, f) +
                      radius * sin(phi + psi) * dot(R, g);
        }
        skin(&m, m.end, p, out);
        CHECK_NEAR(distance(out, want), 0, 10 * near);
    }
}

/* ---- dual quaternions by another way: (R, t) of (6.6), then Kavan's q and t q / 2 --------------- */

/* Of a rotation, by the largest of its four squares. */
static void quaternion_of(const double R[9], double q[4])
{
    double d[4] = {1 + R[0] + R[4] + R[8], 1 + R[0] - R[4] - R[8], 1 - R[0] + R[4] - R[8],
                   1 - R[0] - R[4] + R[8]};
    int most = 0;
    for (int k = 1; k < 4; k++)
        most = d[k] > d[most] ? k : most;
    double w = R[7] - R[5], x = R[2] - R[6], y = R[3] - R[1];
    double s = 1 / (2 * sqrt(d[most]));
    const double rows[4][4] = {{d[0], w, x, y},
                               {w, d[1], R[1] + R[3], R[2] + R[6]},
                               {x, R[1] + R[3], d[2], R[5] + R[7]},
                               {y, R[2] + R[6], R[5] + R[7], d[3]}};
    for (int k = 0; k < 4; k++)
        q[k] = s * rows[most][k];
}

/* The bone's motion at e: columns of R K(e) and t = a' + R (e s - K a) from three points and one. */
static void motion(const model *m, int bone, double R[9], double t[3])
{
    model one = *m;
    double corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, out[4][3];
    one.rig.bones = one.bone;
    memset(one.weight, 0, sizeof one.weight);
    one.weight[bone] = 1;
    for (int i = 0; i < 4; i++)
        direct(&one, corner[i], out[i]);
    for (int k = 0; k < 3; k++) {
        t[k] = out[0][k];
        for (int i = 0; i < 3; i++)
            R[3 * k + i] = out[i + 1][k] - out[0][k];
    }
}

static void kavan(const model *m, const double p[3], double out[3])
{
    double sum[8] = {0}, q[BONES][4], t[BONES][3], R[9], first[4], side[3], twice[3];
    int most = 0;
    for (int i = 0; i < BONES; i++) {
        motion(m, i, R, t[i]);
        quaternion_of(R, q[i]);
        most = m->weight[i] > m->weight[most] ? i : most;
    }
    memcpy(first, q[most], sizeof first);
    for (int i = 0; i < BONES; i++) {
        double same = q[i][0] * first[0] + dot(q[i] + 1, first + 1);
        double w = same < 0 ? -m->weight[i] : m->weight[i];
        cross(t[i], q[i] + 1, side);
        sum[4] += w * -dot(t[i], q[i] + 1) / 2;
        sum[0] += w * q[i][0];
        for (int k = 0; k < 3; k++) {
            sum[k + 1] += w * q[i][k + 1];
            sum[k + 5] += w * (q[i][0] * t[i][k] + side[k]) / 2;
        }
    }
    double length = sqrt(sum[0] * sum[0] + dot(sum + 1, sum + 1));
    for (int k = 0; k < 8; k++)
        sum[k] /= length;
    /* Kavan et al. 2008: v + 2 d x (d x v + a v) + 2 (a e - b d + d x e) */
    cross(sum + 1, p, side);
    for (int k = 0; k < 3; k++)
        side[k] += sum[0] * p[k];
    cross(sum + 1, side, twice);
    cross(sum + 1, sum + 5, side);
    for (int k = 0; k < 3; k++)
        out[k] = p[k] + 2 * twice[k] + 2 * (sum[0] * sum[k + 5] - sum[4] * sum[k + 1] + side[k]);
}

/* T11. Where the largest weight is only just that, or a quaternion is nearly at right angles to the
 * first, rounding decides: then either answer is right, and the poses here have none of it. A blend
 * whose length is l is l times less exact: the tolerance is for 1/50. */
static void dual_equals_kavans_algorithm(void)
{
    model m;
    make_any(&m);
    m.rig.method = WG_SKIN_DUAL;
    for (int i = 0; i < POINTS; i++) {
        double p[3] = {any(), any(), any()}, out[3], want[3];
        move_any(&m);
        pose(&m);
        any_influence(&m);
        skin(&m, m.end, p, out);
        kavan(&m, p, want);
        CHECK_NEAR(distance(out, want), 0, 500 * near);
    }
}

/* T2 */
static void unstretched_untwisted_bones_ignore_ends(void)
{
    model m;
    make_any(&m);
    for (int i = 0; i < POINTS; i++) {
        double p[3] = {any(), any(), any()}, with[3], without[3];
        move_any(&m);
        for (int k = 1; k < BONES; k++) {
            m.value[8 + 4 * k] = 1;
            m.value[9 + 4 * k] = m.value[10 + 4 * k] = 0;
        }
        pose(&m);
        any_influence(&m);
        for (unsigned k = 0; k < 2; k++) {
            m.rig.method = (int)(k ? WG_SKIN_DUAL : WG_SKIN_LINEAR);
            skin(&m, m.end, p, with);
            skin(&m, NULL, p, without);
            CHECK_NEAR(distance(with, without), 0, near);
        }
    }
}

/* T3: e = 0 at the start goes to the start, e = 1 at the end to the end, as children go. */
static void ends_go_where_children_start(void)
{
    static const unsigned methods[] = {WG_SKIN_LINEAR, WG_SKIN_DUAL};
    model m;
    make_any(&m);
    for (int i = 0; i < POINTS; i++) {
        int bone = 1 + i % (BONES - 2);
        double out[3];
        move_any(&m);
        scene_bone *child = &m.bone[bone + 1];
        child->parent = bone;
        child->along = i % 3 / 2.0;
        for (int k = 0; k < 3; k++)
            child->from[k] =
                (1 - child->along) * m.bone[bone].from[k] + child->along * m.bone[bone].to[k];
        pose(&m);
        memset(m.weight, 0, sizeof m.weight);
        m.weight[bone] = 1;
        for (int k = 0; k < 2; k++) {
            m.rig.method = (int)methods[k];
            m.end[bone] = 0;
            skin(&m, m.end, m.bone[bone].from, out);
            CHECK_NEAR(distance(out, m.posed[bone].at), 0, near);
            m.end[bone] = child->along;
            skin(&m, m.end, child->from, out);
            CHECK_NEAR(distance(out, m.posed[bone + 1].at), 0, 10 * near);
        }
    }
}

/* A child that does nothing itself moves as what is beside it of its parent does. */
static void children_move_with_their_part_of_the_parent(void)
{
    model m;
    make_any(&m);
    for (int i = 0; i < POINTS; i++) {
        double p[3] = {any(), any(), any()}, alone[3], with[3];
        int bone = 1 + i % (BONES - 2), child = bone + 1;
        move_any(&m);
        m.value[8 + 4 * child] = 1;
        m.value[7 + 4 * child] = m.value[9 + 4 * child] = m.value[10 + 4 * child] = 0;
        m.bone[child].parent = bone;
        m.bone[child].along = fabs(any());
        pose(&m);
        memset(m.weight, 0, sizeof m.weight);
        m.weight[child] = 1;
        skin(&m, m.end, p, alone);
        memset(m.weight, 0, sizeof m.weight);
        m.weight[bone] = 1;
        m.end[bone] = m.bone[child].along;
        skin(&m, m.end, p, with);
        CHECK_NEAR(distance(alone, with), 0, 10 * near);
    }
}

/* T4 */
static void what_all_hangs_on_moves_all_rigidly(void)
{
    static const unsigned methods[] = {WG_SKIN_LINEAR, WG_SKIN_DUAL};
    model m;
    make_any(&m);
    for (int i = 0; i < POINTS; i++) {
        double p[3] = {any(), any(), any()}, before[3], after[3], moved[3];
        double axis[3] = {any(), any(), any()}, angle = 3 * any(), way[3] = {any(), any(), any()};
        unit(axis);
        move_any(&m);
        any_influence(&m);
        for (int k = 0; k < 2; k++) {
            m.rig.method = (int)methods[k];
            memset(m.value, 0, 7 * sizeof *m.value);
            m.value[0] = 1;
            pose(&m);
            skin(&m, m.end, p, before);
            turned(axis, angle, before, moved);
            m.value[0] = cos(angle / 2);
            for (int c = 0; c < 3; c++) {
                m.value[c + 1] = sin(angle / 2) * axis[c];
                m.value[c + 4] = way[c];
                moved[c] += way[c];
            }
            pose(&m);
            skin(&m, m.end, p, after);
            CHECK_NEAR(distance(after, moved), 0, 500 * near); /* as for Kavan's */
        }
    }
}

/* ---- one and two bones: figures ---------------------------------------------------------------- */

/* T5: beyond the end (e = 1) a cigar moves as it is; scaled bones (6.3) make it twice as long. */
static void a_stretched_bone_does_not_stretch_its_cap(void)
{
    model m;
    make_one(&m);
    m.value[0] = 2;
    pose(&m);
    double scaled = 0;
    for (int i = 0; i < POINTS; i++) {
        double p[2][3] = {{10 + 2 * fabs(any()), any(), any()},
                          {10 + 2 * fabs(any()), any(), any()}};
        double out[2][3];
        m.end[0] = 1;
        skin(&m, m.end, p[0], out[0]);
        skin(&m, m.end, p[1], out[1]);
        CHECK_NEAR(out[0][0] - p[0][0], 10, 1e-12);
        CHECK_NEAR(distance(out[0], out[1]), distance(p[0], p[1]), 1e-12);
        scaled = fmax(scaled, fabs(2 * p[0][0] - out[0][0])); /* what (6.3) would do */
    }
    CHECK(scaled > 1);
}

/* T6: how far a section has turned, past a whole turn too. */
static void a_twist_is_spread_by_ends(void)
{
    static const double end[] = {180, 315, 360, -700};
    model m;
    make_one(&m);
    for (int i = 0; i < 4; i++)
        for (int k = 0; k <= 10; k++) {
            double e = k / 10.0, p[3] = {10 * e, 2, 0}, out[3], start = 30.0 * i;
            m.value[1] = end[i];
            m.value[2] = start;
            m.end[0] = e;
            pose(&m);
            double angle = ((1 - e) * start + e * end[i]) * pi / 180;
            for (unsigned d = 0; d < 2; d++) {
                m.rig.method = (int)(d ? WG_SKIN_DUAL : WG_SKIN_LINEAR);
                skin(&m, m.end, p, out);
                CHECK_NEAR(out[0], p[0], 1e-12);
                CHECK_NEAR(out[1], 2 * cos(angle), 1e-12);
                CHECK_NEAR(out[2], 2 * sin(angle), 1e-12);
            }
        }
}

/* T7: two bones in a row; the second is turned about `axis` by `angle`; half of each at x = 10. Linear
 * blending shrinks what is across the axis by cos(angle / 2), dual quaternions do not. */
static double elbow(unsigned method, const double axis[3], double angle, const double p[3])
{
    static const double middle[3] = {10, 0, 0}, end[3] = {20, 0, 0};
    model m;
    make_one(&m);
    add_bone(&m, 0, middle, end);
    memcpy(add_joint(&m, 1, WG_JOINT_TURN, 3)->axis, axis, 3 * sizeof *axis);
    m.value[3] = angle;
    m.weight[0] = m.weight[1] = 0.5;
    m.rig.method = (int)method;
    pose(&m);
    double out[3];
    skin(&m, NULL, p, out);
    return distance(out, middle);
}

static void elbows_shrink_as_the_theory_says(void)
{
    static const double x[3] = {1, 0, 0}, z[3] = {0, 0, 1}, p[3] = {10, 3, 0};
    for (int i = 0; i <= 17; i++) {
        double angle = 10 * i, half = angle * pi / 360;
        CHECK_NEAR(elbow(WG_SKIN_LINEAR, x, angle, p), 3 * cos(half), 1e-12);
        CHECK_NEAR(elbow(WG_SKIN_LINEAR, z, angle, p), 3 * cos(half), 1e-12);
        CHECK_NEAR(elbow(WG_SKIN_DUAL, x, angle, p), 3, 1e-11);
        CHECK_NEAR(elbow(WG_SKIN_DUAL, z, angle, p), 3, 1e-11);
    }
    /* half a turn: the candy wrapper; dual quaternions know no side but stay at their size */
    CHECK_NEAR(elbow(WG_SKIN_LINEAR, x, 180, p), 0, 1e-12);
    CHECK_NEAR(elbow(WG_SKIN_DUAL, x, 179.9, p), 3, 1e-9);
}

/* The same half turn as a twist of one bone: the section keeps its size with linear blending too. */
static void a_twisted_bone_keeps_its_girth(void)
{
    model m;
    make_one(&m);
    m.value[1] = 180;
    pose(&m);
    for (int k = 0; k <= 20; k++) {
        double p[3] = {k / 2.0, 3, 0}, out[3];
        m.end[0] = k / 20.0;
        skin(&m, m.end, p, out);
        CHECK_NEAR(hypot(out[1], out[2]), 3, 1e-13 * 10);
    }
}

int main(void)
{
    TEST(at_rest_nothing_moves);
    TEST(linear_equals_the_direct_formula);
    TEST(linear_equals_the_cylindrical_form);
    TEST(dual_equals_kavans_algorithm);
    TEST(unstretched_untwisted_bones_ignore_ends);
    TEST(ends_go_where_children_start);
    TEST(children_move_with_their_part_of_the_parent);
    TEST(what_all_hangs_on_moves_all_rigidly);
    TEST(a_stretched_bone_does_not_stretch_its_cap);
    TEST(a_twist_is_spread_by_ends);
    TEST(elbows_shrink_as_the_theory_says);
    TEST(a_twisted_bone_keeps_its_girth);
    return check_done();
}
