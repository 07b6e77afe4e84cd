/* Inside the player: quaternions, and what a wg_bone holds. q is a quaternion in Q29 (w, x, y, z),
 * places are raw units / 2^8, R a rotation in Q30, F a bone's frame in Q14 (SPEC 4.18, 6.9).
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_SKIN_H
#define WIGGLY_SKIN_H

#include "clip.h"
#include "fix.h"
#include "shape.h"

#define WG_QUAT_ONE (INT32_C(1) << 29)

/* ---- quaternions: skin_quat.c ---------------------------------------------------------------- */

/* q = q by. */
void wg_quat_mul(int32_t q[4], const int32_t by[4]);

/* q = q about(axis, phase); axis in Q30, phase in turns / 2^32. */
void wg_quat_turn(int32_t q[4], const int32_t axis[3], uint32_t phase);

/* Of length 1, within 2^-13; false, and h as it was, for 0. */
bool wg_quat_unit(int32_t h[4]);

/* count components shifted so that the largest has 29 bits; false for 0. */
bool wg_normalise(int32_t *v, unsigned count);

/* 1 / |q|^2: 2^60 / (n 2^shift) with n = sum of mulh(q_k, q_k) and n 2^shift in 2^30 .. 2^31 - 1.
 * False if n is below 2^16, or above 2^31 with a hostile clip. */
typedef struct {
    int32_t inverse;
    unsigned shift; /* 0..14 */
} wg_quat_size;
bool wg_quat_measure(const int32_t q[4], wg_quat_size *size);

void wg_quat_matrix(const int32_t q[4], const wg_quat_size *size, int32_t *R);

/* R of q, the identity if q is too short. */
void wg_quat_rotation(const int32_t q[4], int32_t *R);

/* dual = x q - q o: the dual part of a rotation q that takes o to x. */
void wg_quat_dual(const int32_t q[4], const int32_t x[3], const int32_t o[3], int32_t dual[4]);

/* ---- bones ----------------------------------------------------------------------------------- */

/* Words of a wg_bone while bones are placed ... */
#define BONE_Q     0u /* 4 */
#define BONE_PLACE 4u /* 3 */
#define BONE_S     7u
#define BONE_A     8u
#define BONE_B     9u

/* ... and then by method. LINEAR and the kernels: t, Q14; M, Q14, 9 halves in a frame's order. */
#define BONE_LINEAR_T 0u
#define BONE_LINEAR_M 6u /* half */

/* LINEAR with ends: h; S >> 1, A, B; 2^5 (a - g); G, 9 halves. */
#define BONE_ENDS_H     0u
#define BONE_ENDS_S     3u
#define BONE_ENDS_A     4u
#define BONE_ENDS_B     5u
#define BONE_ENDS_PLACE 6u
#define BONE_ENDS_G     18u /* half */

/* DUAL: q, its dual part without stretch and twist, x = a - g; S, A, B; column 0 of G. */
#define BONE_DUAL_Q     0u
#define BONE_DUAL_DUAL  4u
#define BONE_DUAL_X     8u
#define BONE_DUAL_S     11u
#define BONE_DUAL_A     12u
#define BONE_DUAL_B     13u
#define BONE_DUAL_ALONG 28u /* half, 3 */

/* SHIFT: 4 (a - origin). */
#define BONE_SHIFT 0u

/* Where element (r, c) of a frame lies among its halves: F00 F01 F10 F11 F20 F21 F02 F12 F22. */
static inline unsigned wg_frame_at(unsigned r, unsigned c)
{
    return c < 2 ? 2u * r + c : 6u + r;
}

static inline int16_t wg_frame(const uint8_t *record, unsigned r, unsigned c)
{
    return (int16_t)wg_rd16(record + WG_BONE_FRAME + 2u * wg_frame_at(r, c));
}

static inline int32_t wg_origin(const uint8_t *record, unsigned c)
{
    return (int32_t)wg_rd32(record + WG_BONE_ORIGIN + 4u * c);
}

/* Where the bone starts, from the place that the shape's coordinates count from. */
static inline int32_t wg_offset(const uint8_t *record, const uint8_t *shape, unsigned c)
{
    int32_t zero = (int32_t)wg_rd32(shape + WG_SHAPE_ORIGIN + 4u * c);
    return fix_sub(wg_origin(record, c), fix_shl(zero, WG_POSE_BITS));
}

/* Row 0 of the frame in Q30: the direction of the bone. */
static inline void wg_direction(const uint8_t *record, int32_t axis[3])
{
    for (unsigned c = 0; c < 3; c++) {
        axis[c] = fix_shl(wg_frame(record, 0, c), 16);
    }
}

/* Parts of 256 that a byte stands for; 255 is all of it. */
static inline uint16_t wg_part(uint8_t part)
{
    return (uint16_t)(part + (part >> 7));
}

static inline const uint8_t *wg_skin_bone(const wg_skin *skin, uint16_t bone)
{
    return wg_record(skin->file, WG_SECTION_BONES,
                     wg_rd16(skin->record + WG_SKIN_BONE_FIRST) + (uint32_t)bone, WG_BONE_BYTES);
}

static inline const uint8_t *wg_skin_shape(const wg_skin *skin)
{
    return wg_record(skin->file, WG_SECTION_SHAPES, wg_rd16(skin->record + WG_SKIN_SHAPE),
                     WG_SHAPE_BYTES);
}

/* ---- vertices -------------------------------------------------------------------------------- */

/* Vertices of one span: their sums become vertices in place. */
typedef struct {
    const wg_skin *skin;
    const uint8_t *data; /* of the first one's influences */
    uint16_t count;
    uint8_t influences;
    bool ends;
} wg_skin_piece;

void wg_skin_dual(const wg_skin_piece *piece, int32_t *xyz);

/* Of span `index` of the skin what lies in vertices range[0] .. range[1] - 1: `at` is where that
 * starts. Its count may be 0. */
typedef struct {
    const uint8_t *data;
    uint32_t at;
    uint16_t count;
    uint8_t influences;
} wg_skin_cut;

wg_skin_cut wg_skin_span(const wg_skin *skin, uint16_t index, const uint32_t range[2]);

#endif
