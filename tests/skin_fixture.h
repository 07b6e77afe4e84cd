/* A rig of skin_model.h as an open clip, posed by the player.
 * SPDX-License-Identifier: MIT */
#ifndef SKIN_FIXTURE_H
#define SKIN_FIXTURE_H

#include "check.h"
#include "clip_build_skin.h"
#include "skin_model.h"
#include "wiggly.h"

typedef struct {
    uint8_t *clip;
    wg_file file;
    wg_bone bones[RIG_BONES];
    wg_pose pose;
    wg_skin skin;
    int32_t values[RIG_CHANNELS];
    int32_t xyz[3 * RIG_VERTICES];
} skin_fixture;

static uint32_t skin_seed = 7;

static inline double skin_random(double low, double high)
{
    skin_seed = skin_seed * 1664525u + 1013904223u;
    return low + (high - low) * (skin_seed >> 8) / 16777216.0;
}

static inline int32_t skin_q(double x, int bits)
{
    return (int32_t)floor(x * ldexp(1, bits) + 0.5);
}

/* Rows: the direction, and two that complete it. */
static inline void skin_frame(const double *direction, int16_t *frame)
{
    double rows[9];
    int least = 0;
    for (int c = 1; c < 3; c++) {
        least = fabs(direction[c]) < fabs(direction[least]) ? c : least;
    }
    double other[3] = {least == 0, least == 1, least == 2}, n;
    memcpy(rows, direction, 3 * sizeof *rows);
    model_cross(direction, other, rows + 3);
    n = sqrt(model_dot(rows + 3, rows + 3));
    for (int c = 0; c < 3; c++) {
        rows[3 + c] /= n;
    }
    model_cross(rows, rows + 3, rows + 6);
    for (int i = 0; i < 9; i++) {
        frame[i] = (int16_t)skin_q(rows[i], 14);
    }
}

/* Of a degree: turns / 2^32 a raw unit, Q16; of a twist, turns / 2^24. */
static inline uint32_t skin_rate(const rig *r, const rig_joint *j)
{
    if (j->kind == WG_JOINT_TURN) {
        return (uint32_t)(ldexp(1, 48 - r->frac[j->channel]) / 360 + 0.5);
    }
    return j->kind == WG_JOINT_TWIST_START || j->kind == WG_JOINT_TWIST_END
               ? (uint32_t)(ldexp(1, 40 - r->frac[j->channel]) / 360 + 0.5)
               : 0;
}

static inline void skin_add_bone(build *b, const rig *r, const rig_bone *bone)
{
    int16_t frame[9];
    build_bone_data d = {(uint16_t)(bone->parent < 0 ? (int)WG_ABSENT : bone->parent),
                         (uint16_t)(bone->value < 0 ? (int)WG_ABSENT : bone->value),
                         (uint8_t)bone->along,
                         {0, 0, 0},
                         skin_q(bone->length, 8),
                         frame};
    skin_frame(bone->direction, frame);
    for (int c = 0; c < 3; c++) {
        d.origin[c] = skin_q(bone->origin[c], 8);
    }
    build_bone(b, &d);
    for (int i = 0; i < bone->joints; i++) {
        const rig_joint *j = &bone->joint[i];
        if (j->kind == WG_JOINT_FOLLOW) {
            build_follow(b, (uint8_t)j->count, j->list);
        } else {
            build_joint_data data = {
                (uint8_t)j->kind,
                0,
                (uint16_t)j->channel,
                skin_rate(r, j),
                {skin_q(j->axis[0], 30), skin_q(j->axis[1], 30), skin_q(j->axis[2], 30)}};
            build_joint(b, &data);
        }
    }
}

static inline void skin_open(skin_fixture *f, const rig *r)
{
    static int16_t weights[1];
    build b = {{{0}}, 2};
    uint32_t size;
    for (int c = 0; c < r->channels; c++) {
        build_channel(&b, r->frac[c], WG_UNIT_NONE, 0);
        f->values[c] = skin_q(r->value[c], r->frac[c]);
    }
    build_clip(&b, 1000, 1, WG_END_HOLD);
    const build_shape_data shape = {(uint16_t)r->vertices,
                                    RIG_FRAC,
                                    WG_ABSENT,
                                    {r->origin[0], r->origin[1], r->origin[2]},
                                    r->rest};
    build_shape(&b, &shape);
    build_skin(&b, 0, (uint8_t)r->method, (uint8_t)r->ends);
    for (int i = 0; i < r->bones; i++) {
        skin_add_bone(&b, r, &r->bone[i]);
    }
    build_span(&b, 0, (uint16_t)r->vertices, (uint8_t)r->influences, r->data);
    f->clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&f->file, f->clip, size), 0);
    CHECK_EQ(wg_open_shapes(&f->file), 0);
    CHECK_EQ(wg_open_skins(&f->file), 0);
    wg_pose_init(&f->pose, &f->file, 0, weights);
    CHECK(wg_skin_init(&f->skin, &f->file, 0, f->bones));
}

static inline void skin_pose(skin_fixture *f, const wg_rigid *camera)
{
    wg_pose_set(&f->pose, f->values, WG_BASES_MAX, NULL);
    wg_skin_set(&f->skin, f->values, camera);
    wg_skin_vertices(&f->skin, &f->pose, 0, f->pose.vertices, f->xyz);
}

static inline void skin_close(skin_fixture *f)
{
    free(f->clip);
}

/* Vertex v of the player, raw units. */
static inline void skin_vertex(const skin_fixture *f, int v, double *out)
{
    for (int c = 0; c < 3; c++) {
        out[c] = f->xyz[3 * v + c] / 256.0;
    }
}

/* The largest component of player minus model, raw units. */
static inline double skin_worst(const skin_fixture *f, const rig *r)
{
    model_bone bones[RIG_BONES];
    double worst = 0;
    model_bones(r, bones);
    for (int v = 0; v < r->vertices; v++) {
        double want[3], got[3];
        model_vertex(r, bones, v, want);
        skin_vertex(f, v, got);
        for (int c = 0; c < 3; c++) {
            worst = fmax(worst, fabs(want[c] - got[c]));
        }
    }
    return worst;
}

/* ---- rigs ------------------------------------------------------------------------------------- */

/* A channel of so many fraction bits, at a value. */
static inline int rig_channel(rig *r, int frac, double value)
{
    r->frac[r->channels] = frac;
    r->value[r->channels] = value;
    return r->channels++;
}

static inline rig_bone *rig_add_bone(rig *r, int parent, double x, double y, double z)
{
    rig_bone bone = {parent, 0, {x, y, z}, {1, 0, 0}, 0, 0, {{0, 0, {0, 0, 0}, 0, {0}}}, -1};
    r->bone[r->bones] = bone;
    return &r->bone[r->bones++];
}

static inline rig_joint *rig_add_joint(rig_bone *b, int kind, int channel)
{
    rig_joint j = {kind, channel, {0, 0, 0}, 0, {0}};
    b->joint[b->joints] = j;
    return &b->joint[b->joints++];
}

static inline void rig_axis(rig_joint *j, double x, double y, double z)
{
    double n = sqrt(x * x + y * y + z * z);
    j->axis[0] = x / n;
    j->axis[1] = y / n;
    j->axis[2] = z / n;
}

static inline void rig_turn(rig *r, rig_bone *b, const double *axis, double degrees)
{
    rig_joint *j = rig_add_joint(b, WG_JOINT_TURN, rig_channel(r, 12, degrees));
    rig_axis(j, axis[0], axis[1], axis[2]);
}

/* Random rest positions within +-size of the shape's origin, random bones, weights and ends. */
static inline void rig_vertices(rig *r, int count, int influences, double size)
{
    uint8_t *at = r->data;
    r->vertices = count;
    r->influences = influences;
    for (int i = 0; i < 3 * count; i++) {
        r->rest[i] = (int16_t)skin_random(-size, size);
    }
    for (int v = 0; v < count; v++) {
        int left = (int)WG_WEIGHT_SUM;
        for (int i = 0; i < influences; i++) {
            int w = i == influences - 1 ? left : (int)skin_random(0, left);
            left -= w;
            *at++ = (uint8_t)skin_random(0, r->bones);
            *at++ = (uint8_t)w;
            if (r->ends) {
                *at++ = (uint8_t)skin_random(0, 256);
            }
        }
    }
}

static inline double rig_place(double size)
{
    return floor(skin_random(-size, size));
}

static inline void rig_direction(double *out)
{
    double n;
    do {
        for (int c = 0; c < 3; c++) {
            out[c] = skin_random(-1, 1);
        }
        n = sqrt(model_dot(out, out));
    } while (n < 0.1 || n > 1);
    for (int c = 0; c < 3; c++) {
        out[c] /= n;
    }
}

/* `bones` bones anywhere, each on an earlier one if `chains`. */
static inline void rig_random(rig *r, int bones, int chains)
{
    for (int i = 0; i < bones; i++) {
        int parent = chains && i > 0 ? (int)skin_random(0, i) : -1;
        rig_bone *b = rig_add_bone(r, parent, rig_place(3000), rig_place(3000), rig_place(3000));
        rig_direction(b->direction);
        b->length = floor(skin_random(500, 3000));
        b->along = (int)skin_random(0, 256);
    }
}

/* Each bone gets a turn, a way, a quaternion, a stretch and twists of up to `degrees`; or the values
 * they have at rest. */
static inline void rig_joints(rig *r, int bone, int kinds, double degrees)
{
    rig_bone *b = &r->bone[bone];
    double axis[3];
    rig_direction(axis);
    if (kinds & 1 << WG_JOINT_TURN) {
        rig_turn(r, b, axis, skin_random(-degrees, degrees));
    }
    if (kinds & 1 << WG_JOINT_MOVE) {
        double way = degrees > 0 ? skin_random(-60, 60) : 0;
        rig_joint *j = rig_add_joint(b, WG_JOINT_MOVE, rig_channel(r, 14, way));
        rig_axis(j, axis[1], axis[2], axis[0]);
    }
    if (kinds & 1 << WG_JOINT_QUATERNION) {
        int first = rig_channel(r, 24, 1);
        for (int c = 0; c < 3; c++) { /* of any length */
            rig_channel(r, 24, degrees > 0 ? axis[c] * 2 : 0);
        }
        rig_add_joint(b, WG_JOINT_QUATERNION, first);
    }
}

static inline void rig_stretch(rig *r, int bone, double longer, double from, double to)
{
    rig_bone *b = &r->bone[bone];
    rig_add_joint(b, WG_JOINT_STRETCH, rig_channel(r, 16, longer));
    rig_add_joint(b, WG_JOINT_TWIST_START, rig_channel(r, 12, from));
    rig_add_joint(b, WG_JOINT_TWIST_END, rig_channel(r, 12, to));
}

/* ---- bounds ------------------------------------------------------------------------------------
 *
 * In raw units. D: the largest |x| + |y| + |z| of a vertex from a bone, chains included; k: how
 * many turns lie behind each other. A turn's sine is 2^-20.7 off (fix.h), its product with a quaternion
 * 32 2^-29, so each component by less than 2^-20.5, and an entry of the matrix, a sum of two products
 * doubled, by 8 2^-20.5 = 2^-17.5. LINEAR rounds entries to 2^-14: D (2^-15 + k 2^-17.5). A place is
 * rounded down three times a bone, 3/256 each, and once more in the vertex. */

static inline double bound(double D, int k)
{
    return D * (ldexp(1, -15) + k * pow(2, -17.5)) + (6.0 * k + 6) / 256;
}

/* With ends, entries of F are rounded too, and products of both: 3 more of 2^-15. A vertex is rounded
 * to pairs of raw units along the frame, then after its turn: at most 1 each in three directions. A
 * turn is (pi / 256)^2 / 2 too long; twists are 2^-24 of a turn, their rates 2^-20 of 720 degrees. */
static inline double bound_ends(double D, int k)
{
    return bound(D, k) + D * (3 * ldexp(1, -15) + 8e-5 + 8 * PI * ldexp(1, -20)) + 2 * sqrt(3);
}

/* Quaternions of 2^-20.5 a turn, blended, made of length 1 within 2^-13, which does not show; 8 more
 * roundings of 1/64 of a raw unit in the translation. */
static inline double bound_dual(double D, int k)
{
    return D * ((k + 2) * pow(2, -17.5)) + (6.0 * k + 6) / 256 + 8 / 64.0;
}

static inline void skin_compare(rig *r, double tolerance)
{
    skin_fixture f;
    skin_open(&f, r);
    skin_pose(&f, NULL);
    CHECK_NEAR(skin_worst(&f, r), 0, tolerance);
    skin_close(&f);
}

#endif
