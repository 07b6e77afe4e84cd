/* Skins in doubles, written from the papers: matrices from axes and angles, linear blend skinning,
 * stretchable and twistable bones [Jacobson 2013, (6.2), (6.5)], dual quaternions [Kavan et al. 2008].
 * Shares no code with the player. Lengths are raw units, angles degrees.
 * SPDX-License-Identifier: MIT */
#ifndef SKIN_MODEL_H
#define SKIN_MODEL_H

#include <math.h>
#include <string.h>

#include "wiggly_format.h"

#define RIG_BONES    24
#define RIG_JOINTS   8
#define RIG_CHANNELS 32
#define RIG_VERTICES 256
#define PI           3.14159265358979323846

typedef struct {
    int kind, channel;
    double axis[3];
    int count;       /* FOLLOW */
    uint8_t list[8]; /* FOLLOW */
} rig_joint;

typedef struct {
    int parent, along; /* parent -1: none */
    double origin[3], direction[3], length;
    int joints;
    rig_joint joint[RIG_JOINTS];
    int value; /* channel, -1: none */
} rig_bone;

typedef struct {
    int bones, vertices, influences, method, ends, channels;
    rig_bone bone[RIG_BONES];
    int16_t rest[3 * RIG_VERTICES];
    int32_t origin[3]; /* of the shape */
    uint8_t data[3 * 8 * RIG_VERTICES];
    int frac[RIG_CHANNELS];
    double value[RIG_CHANNELS]; /* degrees, lengths in raw units / 2^4, factors */
} rig;

#define RIG_FRAC 4 /* of the shape */

/* y = R (x - origin) + place, with what its ends do to x on the way. */
typedef struct {
    double R[9], place[3];
    double longer;   /* S */
    double twist[2]; /* degrees at start and end */
} model_bone;

/* ---- matrices -------------------------------------------------------------------------------- */

static inline double model_dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void model_cross(const double *a, const double *b, double *out)
{
    for (int c = 0; c < 3; c++) {
        out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
    }
}

static inline void model_apply(const double *R, const double *v, double *out)
{
    double in[3] = {v[0], v[1], v[2]};
    for (int r = 0; r < 3; r++) {
        out[r] = model_dot(R + 3 * r, in);
    }
}

/* R = R by. */
static inline void model_times(double *R, const double *by)
{
    double a[9];
    memcpy(a, R, sizeof a);
    for (int i = 0; i < 9; i++) {
        R[i] = 0;
        for (int k = 0; k < 3; k++) {
            R[i] += a[i / 3 * 3 + k] * by[3 * k + i % 3];
        }
    }
}

/* Rodrigues. */
static inline void model_turn(const double *axis, double degrees, double *R)
{
    double c = cos(degrees * PI / 180), s = sin(degrees * PI / 180);
    const double cross[9] = {0, -axis[2], axis[1], axis[2], 0, -axis[0], -axis[1], axis[0], 0};
    for (int i = 0; i < 9; i++) {
        R[i] = (i % 4 == 0 ? c : 0) + s * cross[i] + (1 - c) * axis[i / 3] * axis[i % 3];
    }
}

static inline void model_of_quaternion(const double *q, double *R)
{
    double n = sqrt(q[0] * q[0] + model_dot(q + 1, q + 1)), s = sqrt(model_dot(q + 1, q + 1));
    double axis[3] = {1, 0, 0};
    for (int c = 0; c < 3 && s > 0; c++) {
        axis[c] = q[c + 1] / s;
    }
    model_turn(axis, 360 / PI * atan2(s / n, q[0] / n), R);
}

/* Of the same rotation, w >= 0; by its largest diagonal. */
static inline void model_quaternion(const double *R, double *q)
{
    double trace[4] = {1 + R[0] + R[4] + R[8], 1 + R[0] - R[4] - R[8], 1 - R[0] + R[4] - R[8],
                       1 - R[0] - R[4] + R[8]};
    const double t[4][4] = {{trace[0], R[7] - R[5], R[2] - R[6], R[3] - R[1]},
                            {R[7] - R[5], trace[1], R[1] + R[3], R[2] + R[6]},
                            {R[2] - R[6], R[1] + R[3], trace[2], R[5] + R[7]},
                            {R[3] - R[1], R[2] + R[6], R[5] + R[7], trace[3]}};
    int best = 0;
    for (int i = 1; i < 4; i++) {
        best = trace[i] > trace[best] ? i : best;
    }
    double n = 2 * sqrt(trace[best]) * (t[best][0] < 0 ? -1 : 1);
    for (int i = 0; i < 4; i++) {
        q[i] = t[best][i] / n;
    }
}

/* ---- bones ----------------------------------------------------------------------------------- */

static inline double model_value(const rig *r, int channel)
{
    return floor(r->value[channel] * ldexp(1, r->frac[channel]) + 0.5) *
           ldexp(1, -r->frac[channel]);
}

static inline double model_e(int byte)
{
    return (byte + (byte >> 7)) / 256.0;
}

static inline void model_place(const rig *r, int i, model_bone *out)
{
    const rig_bone *b = &r->bone[i], *up = b->parent < 0 ? b : &r->bone[b->parent];
    model_bone *m = &out[i];
    const double zero[3] = {0, 0, 1};
    model_turn(zero, 0, m->R);
    memcpy(m->place, b->origin, sizeof m->place);
    if (b->parent >= 0) {
        const model_bone *p = &out[b->parent];
        double e = model_e(b->along), turn[9], way[3];
        model_turn(up->direction, p->twist[0] * (1 - e) + p->twist[1] * e, turn);
        memcpy(m->R, p->R, sizeof m->R);
        model_times(m->R, turn);
        for (int c = 0; c < 3; c++) {
            way[c] = b->origin[c] - up->origin[c] + e * p->longer * up->direction[c];
        }
        model_apply(m->R, way, way);
        for (int c = 0; c < 3; c++) {
            m->place[c] = p->place[c] + way[c];
        }
    }
}

static inline void model_joint(const rig *r, const rig_bone *b, const rig_joint *j, model_bone *m)
{
    double turn[9], way[3], q[4], v = model_value(r, j->channel);
    switch (j->kind) {
    case WG_JOINT_TURN:
        model_turn(j->axis, v, turn);
        model_times(m->R, turn);
        break;
    case WG_JOINT_MOVE:
        for (int c = 0; c < 3; c++) {
            way[c] = j->axis[c] * v * (1 << RIG_FRAC);
        }
        model_apply(m->R, way, way);
        for (int c = 0; c < 3; c++) {
            m->place[c] += way[c];
        }
        break;
    case WG_JOINT_QUATERNION:
        for (int c = 0; c < 4; c++) {
            q[c] = model_value(r, j->channel + c);
        }
        model_of_quaternion(q, turn);
        model_times(m->R, turn);
        break;
    case WG_JOINT_STRETCH:
        m->longer = b->length * fmin(fmax(v - 1, -1), 8);
        break;
    case WG_JOINT_TWIST_START:
    case WG_JOINT_TWIST_END:
        m->twist[j->kind == WG_JOINT_TWIST_END] = v;
        break;
    default:
        break;
    }
}

/* The mean of the shortest turns, as quaternions. */
static inline void model_follow(const rig *r, int i, const rig_joint *j, model_bone *out)
{
    double mean[4] = {0, 0, 0, 0}, turn[9];
    for (int k = 0; k < j->count; k++) {
        double u[3], w[3], axis[3];
        for (int c = 0; c < 3; c++) {
            u[c] = r->bone[j->list[k]].origin[c] - r->bone[i].origin[c];
            w[c] = out[j->list[k]].place[c] - out[i].place[c];
        }
        model_cross(u, w, axis);
        double sine = sqrt(model_dot(axis, axis)), angle = atan2(sine, model_dot(u, w));
        mean[0] += cos(angle / 2);
        for (int c = 0; c < 3 && sine > 0; c++) {
            mean[c + 1] += sin(angle / 2) * axis[c] / sine;
        }
    }
    model_of_quaternion(mean, turn);
    model_times(out[i].R, turn);
}

static inline void model_bones(const rig *r, model_bone *out)
{
    memset(out, 0, (size_t)r->bones * sizeof *out);
    for (int i = 0; i < r->bones; i++) {
        model_place(r, i, out);
        for (int j = 0; j < r->bone[i].joints; j++) {
            model_joint(r, &r->bone[i], &r->bone[i].joint[j], &out[i]);
        }
    }
    for (int i = 0; i < r->bones; i++) {
        for (int j = 0; j < r->bone[i].joints; j++) {
            if (r->bone[i].joint[j].kind == WG_JOINT_FOLLOW) {
                model_follow(r, i, &r->bone[i].joint[j], out);
            }
        }
    }
}

/* ---- vertices -------------------------------------------------------------------------------- */

/* One influence of vertex v: its weight, and the motion of its bone at its end. */
typedef struct {
    int bone;
    double weight, R[9], place[3];
} model_influence;

static inline void model_influence_of(const rig *r, const model_bone *bones, int v, int i,
                                      model_influence *out)
{
    const uint8_t *at = r->data + (v * r->influences + i) * (2 + r->ends);
    const model_bone *m = &bones[at[0]];
    const double *along = r->bone[at[0]].direction;
    double e = r->ends ? model_e(at[2]) : 0, turn[9], way[3];
    out->bone = at[0];
    out->weight = (at[1] + (i == 0)) / 256.0;
    memcpy(out->R, m->R, sizeof out->R);
    memcpy(out->place, m->place, sizeof out->place);
    if (r->ends) {
        model_turn(along, m->twist[0] * (1 - e) + m->twist[1] * e, turn);
        for (int c = 0; c < 3; c++) {
            way[c] = e * m->longer * along[c];
        }
        model_apply(m->R, way, way);
        model_times(out->R, turn);
        for (int c = 0; c < 3; c++) {
            out->place[c] += way[c];
        }
    }
}

static inline void model_linear(const rig *r, const model_bone *bones, int v, const double *p,
                                double *out)
{
    out[0] = out[1] = out[2] = 0;
    for (int i = 0; i < r->influences; i++) {
        model_influence in;
        double way[3];
        model_influence_of(r, bones, v, i, &in);
        for (int c = 0; c < 3; c++) {
            way[c] = p[c] - r->bone[in.bone].origin[c];
        }
        model_apply(in.R, way, way);
        for (int c = 0; c < 3; c++) {
            out[c] += in.weight * (r->method == WG_SKIN_SHIFT
                                       ? p[c] + in.place[c] - r->bone[in.bone].origin[c]
                                       : way[c] + in.place[c]);
        }
    }
}

/* Blended dual quaternions, made of length 1; b0 and be as Kavan has them: be = t b0 / 2. */
static inline void model_dual(const rig *r, const model_bone *bones, int v, const double *p,
                              double *out)
{
    double b0[4] = {0, 0, 0, 0}, be[4] = {0, 0, 0, 0}, first[4], R[9];
    for (int i = 0; i < r->influences; i++) {
        model_influence in;
        double q[4], t[3], cross[3];
        model_influence_of(r, bones, v, i, &in);
        model_quaternion(in.R, q);
        model_apply(in.R, r->bone[in.bone].origin, t);
        for (int c = 0; c < 3; c++) {
            t[c] = in.place[c] - t[c];
        }
        if (i == 0) {
            memcpy(first, q, sizeof q);
        }
        double side = first[0] * q[0] + model_dot(first + 1, q + 1) < 0 ? -1 : 1;
        model_cross(t, q + 1, cross);
        b0[0] += side * in.weight * q[0];
        be[0] -= side * in.weight * model_dot(t, q + 1) / 2;
        for (int c = 0; c < 3; c++) {
            b0[c + 1] += side * in.weight * q[c + 1];
            be[c + 1] += side * in.weight * (q[0] * t[c] + cross[c]) / 2;
        }
    }
    double n = sqrt(b0[0] * b0[0] + model_dot(b0 + 1, b0 + 1)), cross[3];
    for (int c = 0; c < 4; c++) {
        b0[c] /= n;
        be[c] /= n;
    }
    model_cross(b0 + 1, be + 1, cross);
    model_of_quaternion(b0, R);
    model_apply(R, p, out);
    for (int c = 0; c < 3; c++) { /* [Kavan et al. 2008, algorithm 1] */
        out[c] += 2 * (b0[0] * be[c + 1] - be[0] * b0[c + 1] + cross[c]);
    }
}

/* Where vertex v goes, raw units. */
static inline void model_vertex(const rig *r, const model_bone *bones, int v, double *out)
{
    double p[3];
    for (int c = 0; c < 3; c++) {
        p[c] = r->rest[3 * v + c] + r->origin[c];
    }
    if (r->method == WG_SKIN_DUAL) {
        model_dual(r, bones, v, p, out);
    } else {
        model_linear(r, bones, v, p, out);
    }
}

#endif
