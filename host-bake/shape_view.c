/* Views that say not, or not all of, where they look: fitted to everything that all clips show.
 * Source: own; the projection is that of SPEC 4.17.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include <math.h>

/* Room about the picture's content. */
#define BORDER 1.06

/* Of the radius about the target: a mesh that is flat and seen from its edge has no height. */
#define LEAST_SIZE 0.25

/* Distance in picture heights at the target: a field of view of 22 degrees. */
#define DISTANCE 2.5

/* Frame f; of a mesh with a rig a pose of it; of one without frames its rest pose, then its shapes. */
static const double *pose(const shape_mesh *m, int f)
{
    return m->frame_count > 0   ? m->frame[f]
           : f < m->shown_count ? m->shown + (size_t)f * 3 * (size_t)m->mesh.vertex_count
           : f == 0             ? m->mesh.rest
                    : m->mesh.shape + (size_t)(f - 1) * 3 * (size_t)m->mesh.vertex_count;
}

static int pose_count(const shape_mesh *m)
{
    return m->frame_count > 0   ? m->frame_count
           : m->shown_count > 0 ? m->shown_count
                                : 1 + m->mesh.shape_count;
}

static void box(const shapes *sh, double centre[3])
{
    double lo[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (int i = 0; i < sh->count; i++) {
        const shape_mesh *m = &sh->mesh[i];
        for (int f = 0; f < pose_count(m); f++) {
            for (int v = 0; v < 3 * m->mesh.vertex_count; v++) {
                lo[v % 3] = fmin(lo[v % 3], pose(m, f)[v]);
                hi[v % 3] = fmax(hi[v % 3], pose(m, f)[v]);
            }
        }
    }
    for (int k = 0; k < 3; k++) {
        centre[k] = (lo[k] + hi[k]) / 2;
    }
}

static double rest(const scene *s, const scene_view *v, unsigned number)
{
    return s->channels[v->channel[number]].rest;
}

/* Something turns the camera while it plays. */
static int turns(const scene *s, const scene_view *v)
{
    for (int i = 0; i < s->clip_count; i++) {
        for (int j = 0; j < s->clips[i].curve_count; j++) {
            int c = s->clips[i].curves[j].channel;
            if (c == v->channel[WG_VIEW_YAW] || c == v->channel[WG_VIEW_PITCH] ||
                c == v->channel[WG_VIEW_ROLL]) {
                return 1;
            }
        }
    }
    return 0;
}

/* R = Z X Y. */
static void camera(const scene *s, const scene_view *v, double R[9])
{
    const double turn = acos(-1) / 180;
    double y = turn * rest(s, v, WG_VIEW_YAW), x = turn * rest(s, v, WG_VIEW_PITCH);
    double z = turn * rest(s, v, WG_VIEW_ROLL);
    const double Y[9] = {cos(y), 0, -sin(y), 0, 1, 0, sin(y), 0, cos(y)};
    const double X[9] = {1, 0, 0, 0, cos(x), -sin(x), 0, sin(x), cos(x)};
    const double Z[9] = {cos(z), sin(z), 0, -sin(z), cos(z), 0, 0, 0, 1};
    double XY[9];
    for (int i = 0; i < 9; i++) {
        XY[i] = X[i / 3 * 3] * Y[i % 3] + X[i / 3 * 3 + 1] * Y[3 + i % 3] +
                X[i / 3 * 3 + 2] * Y[6 + i % 3];
    }
    for (int i = 0; i < 9; i++) {
        R[i] = Z[i / 3 * 3] * XY[i % 3] + Z[i / 3 * 3 + 1] * XY[3 + i % 3] +
               Z[i / 3 * 3 + 2] * XY[6 + i % 3];
    }
}

/* The least size for which a vertex at q, in the view's axes, is inside: y distance / d <= size / 2,
 * at a distance of DISTANCE sizes when the view leaves that open too: |y| DISTANCE size <=
 * (DISTANCE size - z) size / 2. */
static double needs(const scene_view *v, const double q[3], double distance)
{
    double y = 2 * fabs(q[1]);
    if (v->projection == (int)WG_ORTHOGRAPHIC) {
        return y;
    }
    return v->fit_distance ? y + q[2] / DISTANCE
                           : y * distance / fmax(distance - q[2], distance / 16);
}

/* Seen from everywhere, a vertex at radius r is somewhere on its sphere, which the picture shows with
 * a height of 2 r / sqrt(1 - (r / distance)^2). */
static double fit_size(const scene *s, const shapes *sh, const scene_view *v)
{
    double R[9], size = 0, target[3], radius = 0, distance = rest(s, v, WG_VIEW_DISTANCE);
    camera(s, v, R);
    for (int k = 0; k < 3; k++) {
        target[k] = rest(s, v, WG_VIEW_X + (unsigned)k);
    }
    for (int i = 0; i < sh->count; i++) {
        const shape_mesh *m = &sh->mesh[i];
        for (int f = 0; f < pose_count(m); f++) {
            for (int j = 0; j < m->mesh.vertex_count; j++) {
                const double *p = pose(m, f) + 3 * j;
                const double d[3] = {p[0] - target[0], p[1] - target[1], p[2] - target[2]};
                double q[3];
                for (int k = 0; k < 3; k++) {
                    q[k] = R[3 * k] * d[0] + R[3 * k + 1] * d[1] + R[3 * k + 2] * d[2];
                }
                size = fmax(size, needs(v, q, distance));
                radius = fmax(radius, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
            }
        }
    }
    if (turns(s, v)) {
        double share = v->projection == (int)WG_ORTHOGRAPHIC ? 0
                       : v->fit_distance                     ? 1 / (2 * DISTANCE)
                                                             : fmin(0.95, radius / distance);
        size = 2 * radius / sqrt(1 - share * share);
    }
    return BORDER * fmax(size, LEAST_SIZE * radius);
}

void shape_fit_views(scene *s, const shapes *sh)
{
    double centre[3];
    box(sh, centre);
    for (int i = 0; i < s->view_count && sh->count > 0; i++) {
        const scene_view *v = &s->views[i];
        for (int k = 0; k < 3 && v->fit_target; k++) {
            s->channels[v->channel[(int)WG_VIEW_X + k]].rest = centre[k];
        }
        if (v->fit_size) {
            s->channels[v->channel[WG_VIEW_SIZE]].rest = fit_size(s, sh, v);
        }
        if (v->fit_distance) {
            double size = rest(s, v, WG_VIEW_SIZE);
            s->channels[v->channel[WG_VIEW_DISTANCE]].rest = DISTANCE * size;
        }
    }
}
