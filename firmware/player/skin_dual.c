/* Dual quaternions, blended over the influences of a vertex, with stretch and twist along each bone.
 *   b  sum of w q, Q27        B  sum of w dual, raw units / 2^7        T  vector part of B b*
 * Source: Kavan et al. 2008, Geometric skinning with approximate dual quaternion blending; Jacobson
 * 2013, (6.6); the integer form is ours (SPEC 6.10).
 * SPDX-License-Identifier: MIT */
#include "skin.h"

#define DUAL 4u /* where a motion's dual part starts, after its quaternion: as in a bone */

/* q_e and its dual part at the part e / 256 of a bone, made in `m`; or the bone's own. */
static const int32_t *bend(const wg_skin *skin, uint8_t index, uint16_t e, int32_t *m)
{
    const wg_bone *bone = skin->bones + index;
    const int32_t *word = bone->word;
    int32_t S = word[BONE_DUAL_S], A = word[BONE_DUAL_A], B = word[BONE_DUAL_B];
    if ((S | A | B) == 0) { /* its dual part is what the rest of this would find */
        return word;
    }
    const uint8_t *record = wg_skin_bone(skin, index), *shape = wg_skin_shape(skin);
    int32_t x[3], o[3], axis[3], far = fix_shl(fix_weigh(S, (uint16_t)(128u * e)), 2);
    for (unsigned c = 0; c < 3; c++) {
        m[c + 1u] = word[BONE_DUAL_Q + 1u + c];
        x[c] = fix_add(word[BONE_DUAL_X + c], fix_mulq(far, bone->half[BONE_DUAL_ALONG + c]));
        o[c] = wg_offset(record, shape, c);
    }
    m[0] = word[BONE_DUAL_Q];
    if ((A | B) != 0) {
        wg_direction(record, axis);
        wg_quat_turn(m, axis, (uint32_t)A + (uint32_t)B * e);
    }
    wg_quat_dual(m, x, o, m + DUAL);
    return m;
}

/* Whether a b < 0: then -b is the same rotation, and nearer. */
static bool apart(const int32_t *a, const int32_t *b)
{
    int32_t sum = fix_add(fix_mulh(a[0], b[0]), fix_mulh(a[1], b[1]));
    sum = fix_add(sum, fix_add(fix_mulh(a[2], b[2]), fix_mulh(a[3], b[3])));
    return sum < 0;
}

/* sum +- of w / 2^10, rounded down before its sign, which is 0 or -1. */
static inline int32_t plus(int32_t sum, int32_t of, uint16_t w, int32_t sign)
{
    return fix_add(sum, fix_sub(fix_share(of, w) ^ sign, sign));
}

/* b and B. Not a loop: with 4 influences a vertex takes a Cortex-M3 754 instructions, and 838 so. */
static void add(int32_t *sum, const int32_t *of, uint16_t w, bool minus)
{
    int32_t sign = minus ? -1 : 0;
    sum[0] = plus(sum[0], of[0], w, sign);
    sum[1] = plus(sum[1], of[1], w, sign);
    sum[2] = plus(sum[2], of[2], w, sign);
    sum[3] = plus(sum[3], of[3], w, sign);
    sum[4] = plus(sum[4], of[4], w, sign);
    sum[5] = plus(sum[5], of[5], w, sign);
    sum[6] = plus(sum[6], of[6], w, sign);
    sum[7] = plus(sum[7], of[7], w, sign);
}

static void blend(const wg_skin_piece *piece, const uint8_t *data, int32_t *sum)
{
    int32_t made[8], first[4];
    uint8_t more = 1; /* the first weight counts one more */
    for (unsigned c = 0; c < 8; c++) {
        sum[c] = 0;
    }
    for (uint8_t n = piece->influences; n > 0; n--) {
        uint8_t bone = wg_rd8(data);
        const int32_t *m = piece->ends ? bend(piece->skin, bone, wg_part(wg_rd8(data + 2)), made)
                                       : piece->skin->bones[bone].word;
        for (unsigned c = 0; more && c < 4; c++) {
            first[c] = m[c];
        }
        add(sum, m, (uint16_t)(wg_rd8(data + 1) + more), !more && apart(first, m));
        more = 0;
        data += piece->ends ? 3 : 2;
    }
}

/* T_x, T_y or T_z: b and B begin with that component, and go on cyclically to d and e. */
static inline int32_t translation(const int32_t *sum, unsigned c, unsigned d, unsigned e)
{
    const int32_t *B = sum + DUAL;
    int32_t straight =
        fix_sub(fix_mulh(sum[0], fix_shl(B[c], 4)), fix_mulh(sum[c], fix_shl(B[0], 4)));
    int32_t cross = fix_sub(fix_mulh(sum[d], fix_shl(B[e], 4)), fix_mulh(sum[e], fix_shl(B[d], 4)));
    return fix_add(straight, cross);
}

static void turn(const wg_skin *skin, const int32_t *sum, const wg_quat_size *size, int32_t *xyz)
{
    int32_t R[9], p[3];
    int32_t T[3] = {translation(sum, 1, 2, 3), translation(sum, 2, 3, 1),
                    translation(sum, 3, 1, 2)};
    wg_quat_matrix(sum, size, R);
    for (unsigned c = 0; c < 3; c++) {
        p[c] = fix_shl((int16_t)(xyz[c] >> 15), 10);
    }
    for (unsigned r = 0; r < 3; r++) {
        const int32_t *row = R + 3u * r;
        int32_t t = fix_mulh(fix_shl(T[r], 4), size->inverse);
        t = size->shift < 8 ? wg_shr(t, 8 - size->shift) : fix_shl(t, size->shift - 8);
        t = fix_add(fix_add(t, fix_mulh(row[0], p[0])),
                    fix_add(fix_mulh(row[1], p[1]), fix_mulh(row[2], p[2])));
        xyz[r] = fix_add(t, skin->move[r]);
    }
}

/* Rotations that cancel each other leave nothing to turn by: the rest pose. */
static void stay(const wg_skin *skin, int32_t *xyz)
{
    const uint8_t *shape = wg_skin_shape(skin);
    for (unsigned c = 0; c < 3; c++) {
        int32_t zero = (int32_t)wg_rd32(shape + WG_SHAPE_ORIGIN + 4u * c);
        xyz[c] = fix_shl(fix_add((int16_t)(xyz[c] >> 15), zero), WG_POSE_BITS);
    }
}

void wg_skin_dual(const wg_skin_piece *piece, int32_t *xyz)
{
    const uint8_t *data = piece->data;
    unsigned bytes = piece->influences * (piece->ends ? 3u : 2u);
    for (uint16_t left = piece->count; left > 0; left--) {
        int32_t sum[8];
        wg_quat_size size;
        blend(piece, data, sum);
        if (wg_quat_measure(sum, &size)) {
            turn(piece->skin, sum, &size, xyz);
        } else {
            stay(piece->skin, xyz);
        }
        data += bytes;
        xyz += 3;
    }
}
