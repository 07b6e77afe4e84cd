/* Bones: channel values to the rotation and place of each, then to what its method takes.
 *   q_i    quaternion, rest to pose               a_i   place where the bone starts
 *   S      stretch along the bone                 A, B  twist: A + B e at the part e of the bone
 *   F      frame of the bone at rest, 3 x 3       G     R F^T, 3 x 3
 * Source: Jacobson 2013, 4.3.4 (pseudo-edges), 6.2 (6.4)-(6.6); the integer form is ours (SPEC 6.9).
 * SPDX-License-Identifier: MIT */
#include "skin.h"

#define LONGER_MIN (-(INT32_C(1) << 14)) /* of length 0 */
#define LONGER_MAX (INT32_C(1) << 17)    /* 9 times as long */

typedef struct {
    const wg_skin *skin;
    const int32_t *values;
    int frac; /* of the shape */
} bones_at;

/* A bone while it is placed. */
typedef struct {
    int32_t *q, *a;
    int32_t longer;    /* l, Q14 */
    uint32_t twist[2]; /* t_0, t_1, turns / 2^24 */
} bone_now;

static int32_t scaled(const bones_at *at, uint16_t channel, int bits)
{
    return fix_scale(at->values[channel], bits - wg_channel_frac(at->skin->file, channel));
}

/* a += R way. */
static void go(int32_t *a, const int32_t *R, const int32_t *way)
{
    int32_t x = fix_shl(way[0], 2), y = fix_shl(way[1], 2), z = fix_shl(way[2], 2);
    for (unsigned r = 0; r < 3; r++) {
        a[r] = fix_add(fix_add(a[r], fix_mulh(R[0], x)),
                       fix_add(fix_mulh(R[1], y), fix_mulh(R[2], z)));
        R += 3;
    }
}

/* ---- step 1: where the parent takes it ------------------------------------------------------- */

static void place_child(const bones_at *at, const uint8_t *record, bone_now *now)
{
    uint16_t parent = wg_rd16(record + WG_BONE_PARENT);
    const uint8_t *up_record = wg_skin_bone(at->skin, parent);
    const int32_t *up = at->skin->bones[parent].word;
    uint16_t e = wg_part(wg_rd8(record + WG_BONE_ALONG));
    int32_t far = fix_shl(fix_weigh(up[BONE_S], (uint16_t)(128u * e)), 2);
    int32_t way[3], R[9];
    for (unsigned c = 0; c < 4; c++) {
        now->q[c] = up[BONE_Q + c];
    }
    if ((up[BONE_A] | up[BONE_B]) != 0) {
        wg_direction(up_record, way);
        wg_quat_turn(now->q, way, (uint32_t)up[BONE_A] + (uint32_t)up[BONE_B] * e);
    }
    for (unsigned c = 0; c < 3; c++) {
        now->a[c] = up[BONE_PLACE + c];
        way[c] = fix_add(fix_sub(wg_origin(record, c), wg_origin(up_record, c)),
                         fix_mulq(far, wg_frame(up_record, 0, c)));
    }
    wg_quat_rotation(now->q, R);
    go(now->a, R, way);
}

static void place(const bones_at *at, const uint8_t *record, bone_now *now)
{
    if (wg_rd16(record + WG_BONE_PARENT) != WG_ABSENT) {
        place_child(at, record, now);
        return;
    }
    for (unsigned c = 0; c < 3; c++) {
        now->q[c + 1u] = 0;
        now->a[c] = wg_origin(record, c);
    }
    now->q[0] = WG_QUAT_ONE;
}

/* ---- steps 2 and 3: its joints ---------------------------------------------------------------- */

static void read_axis(const uint8_t *joint, int32_t axis[3])
{
    for (unsigned c = 0; c < 3; c++) {
        axis[c] = (int32_t)wg_rd32(joint + WG_JOINT_AXIS + 4u * c);
    }
}

static void move(const bones_at *at, const uint8_t *joint, bone_now *now)
{
    int32_t R[9], way[3];
    uint16_t channel = wg_rd16(joint + WG_JOINT_CHANNEL);
    int32_t m = fix_shl(scaled(at, channel, (int)WG_POSE_BITS + at->frac), 2);
    read_axis(joint, way);
    for (unsigned c = 0; c < 3; c++) {
        way[c] = fix_mulh(way[c], m);
    }
    wg_quat_rotation(now->q, R);
    go(now->a, R, way);
}

static void turn_quaternion(const bones_at *at, uint16_t channel, bone_now *now)
{
    int32_t by[4];
    for (unsigned c = 0; c < 4; c++) {
        by[c] = scaled(at, (uint16_t)(channel + c), 29);
    }
    if (wg_quat_unit(by)) {
        wg_quat_mul(now->q, by);
    }
}

static void add_joint(const bones_at *at, const uint8_t *joint, bone_now *now)
{
    uint8_t kind = wg_rd8(joint + WG_JOINT_KIND);
    uint16_t channel = wg_rd16(joint + WG_JOINT_CHANNEL);
    uint32_t rate = wg_rd32(joint + WG_JOINT_DATA);
    int32_t axis[3];
    switch (kind) {
    case WG_JOINT_TURN:
        read_axis(joint, axis);
        wg_quat_turn(now->q, axis, fix_phase(at->values[channel], rate));
        break;
    case WG_JOINT_MOVE:
        move(at, joint, now);
        break;
    case WG_JOINT_QUATERNION:
        turn_quaternion(at, channel, now);
        break;
    case WG_JOINT_STRETCH:
        now->longer =
            fix_clamp(scaled(at, channel, 14) - (INT32_C(1) << 14), LONGER_MIN, LONGER_MAX);
        break;
    case WG_JOINT_TWIST_START:
    case WG_JOINT_TWIST_END:
        now->twist[kind - WG_JOINT_TWIST_START] = fix_phase(at->values[channel], rate);
        break;
    default: /* FOLLOW: when all bones are placed */
        break;
    }
}

static const uint8_t *joints(const wg_skin *skin, const uint8_t *record)
{
    return wg_record(skin->file, WG_SECTION_JOINTS, wg_rd16(record + WG_BONE_JOINT_FIRST),
                     WG_JOINT_BYTES);
}

static void set_bone(const bones_at *at, uint16_t index)
{
    const uint8_t *record = wg_skin_bone(at->skin, index);
    const uint8_t *joint = joints(at->skin, record);
    int32_t *word = at->skin->bones[index].word;
    bone_now now = {word + BONE_Q, word + BONE_PLACE, 0, {0, 0}};
    place(at, record, &now);
    for (uint8_t left = wg_rd8(record + WG_BONE_JOINT_COUNT); left > 0; left--) {
        add_joint(at, joint, &now);
        joint += WG_JOINT_BYTES;
    }
    int32_t length = (int32_t)wg_rd32(record + WG_BONE_LENGTH);
    word[BONE_S] = fix_shl(fix_mulh(fix_shl(length, 4), fix_shl(now.longer, 12)), 2);
    word[BONE_A] = (int32_t)(now.twist[0] << 8);
    word[BONE_B] = (int32_t)(now.twist[1] - now.twist[0]);
}

/* ---- step 4: bones that follow others --------------------------------------------------------- */

static int32_t dot(const int32_t *u, const int32_t *w)
{
    return fix_mulh(u[0], w[0]) + fix_mulh(u[1], w[1]) + fix_mulh(u[2], w[2]); /* < 3 2^26 */
}

/* h: the shortest turn from u to w, as a quaternion; false if there is none. */
static bool shortest(int32_t *u, int32_t *w, int32_t h[4])
{
    if (!wg_normalise(u, 3) || !wg_normalise(w, 3)) {
        return false;
    }
    uint32_t lengths = (uint32_t)fix_sqrt((uint32_t)dot(u, u) << 4) *
                       fix_sqrt((uint32_t)dot(w, w) << 4); /* both below 2^16 */
    h[0] = (int32_t)(lengths >> 4) + dot(u, w);
    h[1] = fix_mulh(u[1], w[2]) - fix_mulh(u[2], w[1]);
    h[2] = fix_mulh(u[2], w[0]) - fix_mulh(u[0], w[2]);
    h[3] = fix_mulh(u[0], w[1]) - fix_mulh(u[1], w[0]);
    return wg_quat_unit(h);
}

/* How bone j has moved about `word`'s bone; false if one of its vectors is 0. */
static bool turn_to(const wg_skin *skin, uint8_t j, const uint8_t *record, const int32_t *word,
                    int32_t h[4])
{
    const uint8_t *other = wg_skin_bone(skin, j);
    int32_t u[3], w[3];
    for (unsigned c = 0; c < 3; c++) {
        u[c] = fix_sub(wg_origin(other, c), wg_origin(record, c));
        w[c] = fix_sub(skin->bones[j].word[BONE_PLACE + c], word[BONE_PLACE + c]);
    }
    return shortest(u, w, h);
}

static void follow(const wg_skin *skin, uint16_t index)
{
    const uint8_t *record = wg_skin_bone(skin, index);
    uint8_t count = wg_rd8(record + WG_BONE_JOINT_COUNT);
    const uint8_t *joint = joints(skin, record);
    int32_t mean[4] = {0, 0, 0, 0}, h[4];
    if (count == 0) {
        return;
    }
    joint += (count - 1u) * WG_JOINT_BYTES; /* the last one */
    if (wg_rd8(joint + WG_JOINT_KIND) != WG_JOINT_FOLLOW) {
        return;
    }
    const uint8_t *list = skin->file->section[WG_SECTION_DATA].at + wg_rd32(joint + WG_JOINT_DATA);
    for (uint8_t left = wg_rd8(joint + WG_JOINT_COUNT); left > 0; left--, list++) { /* <= 8 */
        if (turn_to(skin, wg_rd8(list), record, skin->bones[index].word, h)) {
            for (unsigned c = 0; c < 4; c++) {
                mean[c] += h[c] >> 3;
            }
        }
    }
    if (wg_quat_unit(mean)) {
        wg_quat_mul(skin->bones[index].word + BONE_Q, mean);
    }
}

/* ---- what the methods take --------------------------------------------------------------------- */

/* R and place become those that the camera sees. */
static void look(const wg_rigid *camera, int32_t *R, int32_t *a)
{
    int32_t old[9], way[3];
    for (unsigned i = 0; i < 9; i++) {
        old[i] = R[i];
    }
    for (unsigned r = 0; r < 3; r++) {
        way[r] = fix_sub(a[r], camera->centre[r]);
    }
    for (unsigned r = 0; r < 3; r++) {
        for (unsigned c = 0; c < 3; c++) {
            R[3u * r + c] = wg_turned(camera->turn_q30 + 3u * r, old + c, 3);
        }
        a[r] = wg_turned(camera->turn_q30 + 3u * r, way, 1);
    }
}

static int16_t narrow(int32_t a, unsigned bits)
{
    return (int16_t)fix_clamp(fix_round(a, bits), -INT32_C(32767), INT32_C(32767));
}

/* t = 2^6 (a - g) - M o. */
static void make_linear(const int32_t *R, const int32_t *way, const int32_t *o, wg_bone *bone)
{
    int32_t x = fix_shl(o[0], 6), y = fix_shl(o[1], 6), z = fix_shl(o[2], 6);
    int16_t *half = bone->half + BONE_LINEAR_M;
    for (unsigned r = 0; r < 3; r++) {
        int16_t m = narrow(R[0], 16), n = narrow(R[1], 16), p = narrow(R[2], 16);
        int32_t t = fix_add(fix_mulq(x, m), fix_add(fix_mulq(y, n), fix_mulq(z, p)));
        half[2u * r] = m;
        half[2u * r + 1u] = n;
        half[6u + r] = p;
        bone->word[BONE_LINEAR_T + r] = fix_sub(fix_shl(way[r], 6), fix_shl(t, 2));
        R += 3;
    }
}

/* An entry of R F^T, Q14: a row of R and one of F. */
static int16_t turned_frame(const int32_t *R, const int16_t *F)
{
    return narrow(
        fix_add(fix_mulq(R[0], F[0]), fix_add(fix_mulq(R[1], F[1]), fix_mulq(R[2], F[2]))), 14);
}

/* Row r of F. */
static void read_frame(const uint8_t *record, unsigned r, int16_t F[3])
{
    F[0] = wg_frame(record, r, 0);
    F[1] = wg_frame(record, r, 1);
    F[2] = wg_frame(record, r, 2);
}

static void make_ends(const int32_t *R, const int32_t *way, const uint8_t *record, const int32_t *o,
                      wg_bone *bone)
{
    int32_t S = bone->word[BONE_S], A = bone->word[BONE_A], B = bone->word[BONE_B];
    int32_t x = fix_shl(o[0], 6), y = fix_shl(o[1], 6), z = fix_shl(o[2], 6);
    bone->word[BONE_ENDS_S] = S >> 1;
    bone->word[BONE_ENDS_A] = A;
    bone->word[BONE_ENDS_B] = B;
    for (unsigned c = 0; c < 3; c++) {
        int16_t F[3];
        read_frame(record, c, F);
        for (unsigned r = 0; r < 3; r++) {
            bone->half[BONE_ENDS_G + wg_frame_at(r, c)] = turned_frame(R + 3u * r, F);
        }
        int32_t h = fix_add(fix_mulq(x, F[0]), fix_add(fix_mulq(y, F[1]), fix_mulq(z, F[2])));
        bone->word[BONE_ENDS_H + c] = fix_sub(INT32_C(1) << 14, fix_shl(h, 2)); /* rounds l */
        bone->word[BONE_ENDS_PLACE + c] = fix_shl(way[c], 5);
    }
}

static void make_dual(const int32_t *R, const int32_t *way, const uint8_t *record, const int32_t *o,
                      wg_bone *bone)
{
    int32_t S = bone->word[BONE_S], A = bone->word[BONE_A], B = bone->word[BONE_B];
    bone->word[BONE_DUAL_S] = S;
    bone->word[BONE_DUAL_A] = A;
    bone->word[BONE_DUAL_B] = B;
    int16_t F[3];
    read_frame(record, 0, F);
    for (unsigned r = 0; r < 3; r++) {
        bone->half[BONE_DUAL_ALONG + r] = turned_frame(R + 3u * r, F);
        bone->word[BONE_DUAL_X + r] = way[r];
    }
    wg_quat_dual(bone->word + BONE_DUAL_Q, way, o, bone->word + BONE_DUAL_DUAL);
}

/* From q, a, S, A and B to the words of the skin's method; move is g. */
static void make(const wg_skin *skin, uint16_t index)
{
    uint8_t method = wg_rd8(skin->record + WG_SKIN_METHOD);
    const uint8_t *record = wg_skin_bone(skin, index), *shape = wg_skin_shape(skin);
    wg_bone *bone = skin->bones + index;
    int32_t R[9], a[3], o[3], way[3];
    wg_quat_rotation(bone->word + BONE_Q, R);
    for (unsigned r = 0; r < 3; r++) {
        a[r] = bone->word[BONE_PLACE + r];
        o[r] = wg_offset(record, shape, r);
    }
    if (skin->looks && method == WG_SKIN_LINEAR) {
        look(&skin->camera, R, a);
    }
    for (unsigned r = 0; r < 3; r++) {
        way[r] = fix_sub(a[r], skin->move[r]);
    }
    if (method == WG_SKIN_SHIFT) {
        for (unsigned r = 0; r < 3; r++) {
            bone->word[BONE_SHIFT + r] = fix_shl(fix_sub(a[r], wg_origin(record, r)), 2);
        }
    } else if (method == WG_SKIN_DUAL) {
        make_dual(R, way, record, o, bone);
    } else if (wg_rd8(skin->record + WG_SKIN_ENDS) != 0) {
        make_ends(R, way, record, o, bone);
    } else {
        make_linear(R, way, o, bone);
    }
}

/* g: the place of the first bone, as the camera sees it where bones are seen by it. */
static void set_move(wg_skin *skin)
{
    int32_t R[9];
    for (unsigned i = 0; i < 9; i++) {
        R[i] = 0;
    }
    for (unsigned r = 0; r < 3; r++) {
        skin->move[r] = skin->bones[0].word[BONE_PLACE + r];
    }
    if (skin->looks && wg_rd8(skin->record + WG_SKIN_METHOD) == WG_SKIN_LINEAR) {
        look(&skin->camera, R, skin->move);
    }
}

void wg_skin_set(wg_skin *skin, const int32_t *values, const wg_rigid *camera)
{
    uint16_t count = wg_rd16(skin->record + WG_SKIN_BONE_COUNT);
    const bones_at at = {skin, values, (int8_t)wg_rd8(wg_skin_shape(skin) + WG_SHAPE_FRAC)};
    skin->looks = camera != 0;
    if (camera) { /* its centre in raw units / 2^8 */
        skin->camera = *camera;
        skin->camera.centre_frac = (int8_t)(at.frac + (int)WG_POSE_BITS);
        for (unsigned r = 0; r < 3; r++) {
            skin->camera.centre[r] =
                fix_scale(camera->centre[r], skin->camera.centre_frac - camera->centre_frac);
        }
    }
    for (uint16_t i = 0; i < count; i++) {
        set_bone(&at, i);
    }
    for (uint16_t i = 0; i < count; i++) {
        follow(skin, i);
    }
    set_move(skin);
    for (uint16_t i = 0; i < count; i++) {
        make(skin, i);
    }
}
