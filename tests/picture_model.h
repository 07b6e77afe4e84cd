/* Pictures in double precision, ray by ray, from SPEC 4.17: what the raster is compared with.
 * SPDX-License-Identifier: MIT */
#ifndef PICTURE_MODEL_H
#define PICTURE_MODEL_H

#include "picture_clip.h"

typedef struct {
    const pc_mesh *mesh;
    double turn[3][3], target[3], distance, size, width, height;
    int flat; /* orthographic */
    int sides;
    double at[PC_VERTICES][3]; /* in the view's axes, relative to the target */
} pm_model;

typedef struct {
    int triangle; /* -1: background */
    double depth;
    double behind; /* depth of the nearest hit of another part */
} pm_hit;

static inline double pm_dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void pm_cross(const double *a, const double *b, double *out)
{
    for (unsigned i = 0; i < 3; i++) {
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }
}

static inline void pm_minus(const double *a, const double *b, double *out)
{
    for (unsigned i = 0; i < 3; i++) {
        out[i] = a[i] - b[i];
    }
}

static inline void pm_product(double a[3][3], double b[3][3], double out[3][3])
{
    for (unsigned i = 0; i < 9; i++) {
        out[i / 3][i % 3] = 0;
        for (unsigned k = 0; k < 3; k++) {
            out[i / 3][i % 3] += a[i / 3][k] * b[k][i % 3];
        }
    }
}

/* R = Z X Y from angles in degrees. */
static inline void pm_turn(double yaw, double pitch, double roll, double out[3][3])
{
    double r = atan(1) / 45, y = yaw * r, p = pitch * r, z = roll * r, zx[3][3];
    double Y[3][3] = {{cos(y), 0, -sin(y)}, {0, 1, 0}, {sin(y), 0, cos(y)}};
    double X[3][3] = {{1, 0, 0}, {0, cos(p), -sin(p)}, {0, sin(p), cos(p)}};
    double Z[3][3] = {{cos(z), sin(z), 0}, {-sin(z), cos(z), 0}, {0, 0, 1}};
    pm_product(Z, X, zx);
    pm_product(zx, Y, out);
}

/* The model of what a scene shows now: of the channel values as stored. */
static inline void pm_make(pm_model *m, const pc_mesh *mesh, const pc_scene *s, int flat)
{
    double v[WG_VIEW_CHANNELS];
    for (unsigned i = 0; i < WG_VIEW_CHANNELS; i++) {
        v[i] = ldexp(s->values[i], i < 3 ? -PC_ANGLE : -PC_LENGTH);
    }
    m->mesh = mesh;
    m->flat = flat;
    m->sides = mesh->sides;
    m->distance = v[6];
    m->size = v[7];
    m->width = s->picture.size.width;
    m->height = s->picture.size.height;
    pm_turn(v[0], v[1], v[2], m->turn);
    for (unsigned i = 0; i < mesh->vertices; i++) {
        double p[3];
        pm_minus(mesh->at[i], v + 3, p);
        for (unsigned k = 0; k < 3; k++) {
            m->at[i][k] = pm_dot(m->turn[k], p);
        }
    }
}

/* Where a point of the view is seen, in pixels; returns its depth. */
static inline double pm_project(const pm_model *m, const double *q, double *x, double *y)
{
    double depth = m->distance - q[2];
    double f = m->height / m->size * (m->flat ? 1 : m->distance / depth);
    *x = m->width / 2 + f * q[0];
    *y = m->height / 2 - f * q[1];
    return depth;
}

/* The ray through a place of the picture: a point at depth 0 and what a unit of depth adds. */
static inline void pm_ray(const pm_model *m, double x, double y, double *eye, double *way)
{
    double right = (x - m->width / 2) * m->size / m->height;
    double up = (m->height / 2 - y) * m->size / m->height;
    eye[0] = m->flat ? right : 0;
    eye[1] = m->flat ? up : 0;
    eye[2] = m->distance;
    way[0] = m->flat ? 0 : right / m->distance;
    way[1] = m->flat ? 0 : up / m->distance;
    way[2] = -1;
}

static inline void pm_normal(const pm_model *m, unsigned triangle, double *normal)
{
    const uint16_t *c = m->mesh->corner[triangle];
    double p[3], q[3];
    pm_minus(m->at[c[1]], m->at[c[0]], p);
    pm_minus(m->at[c[2]], m->at[c[0]], q);
    pm_cross(p, q, normal);
}

/* Depth at which a triangle's plane is seen there. */
static inline double pm_depth(const pm_model *m, unsigned triangle, double x, double y)
{
    double eye[3], way[3], normal[3], to[3];
    pm_ray(m, x, y, eye, way);
    pm_normal(m, triangle, normal);
    pm_minus(m->at[m->mesh->corner[triangle][0]], eye, to);
    return pm_dot(normal, to) / pm_dot(normal, way);
}

static inline unsigned pm_part(const pc_mesh *mesh, unsigned triangle)
{
    unsigned part = 0;
    while (triangle >= mesh->part[part + 1]) {
        part++;
    }
    return part;
}

/* Whether the ray meets the triangle from the side that is seen. */
static inline int pm_meets(const pm_model *m, unsigned triangle, const double *eye,
                           const double *way)
{
    const uint16_t *c = m->mesh->corner[triangle];
    double normal[3], to[3][3], side[3], edge[3];
    pm_normal(m, triangle, normal);
    if (pm_dot(normal, way) >= 0 && !m->sides) {
        return 0;
    }
    for (unsigned i = 0; i < 3; i++) {
        pm_minus(m->at[c[i]], eye, to[i]);
    }
    for (unsigned i = 0; i < 3; i++) { /* the ray passes all edges on one side */
        pm_cross(to[i], to[(i + 1) % 3], edge);
        side[i] = pm_dot(edge, way);
    }
    return (side[0] > 0 && side[1] > 0 && side[2] > 0) ||
           (side[0] < 0 && side[1] < 0 && side[2] < 0);
}

static inline pm_hit pm_look(const pm_model *m, double x, double y)
{
    pm_hit hit = {-1, HUGE_VAL, HUGE_VAL};
    double eye[3], way[3];
    pm_ray(m, x, y, eye, way);
    for (unsigned i = 0; i < m->mesh->triangles; i++) {
        if (!pm_meets(m, i, eye, way)) {
            continue;
        }
        double depth = pm_depth(m, i, x, y);
        if (depth < m->distance / 16) {
            continue;
        }
        if (depth < hit.depth) {
            if (hit.triangle >= 0 &&
                pm_part(m->mesh, i) != pm_part(m->mesh, (unsigned)hit.triangle)) {
                hit.behind = hit.depth;
            }
            hit.depth = depth;
            hit.triangle = (int)i;
        } else if (pm_part(m->mesh, i) != pm_part(m->mesh, (unsigned)hit.triangle)) {
            hit.behind = fmin(hit.behind, depth);
        }
    }
    return hit;
}

/* Brightness in light from `light`, 127 = 1. */
static inline double pm_shade(const wg_view *view, const double *normal)
{
    double light[3] = {view->light[0] / 127.0, view->light[1] / 127.0, view->light[2] / 127.0};
    double lit = pm_dot(normal, light) / sqrt(pm_dot(normal, normal));
    return view->ambient + (255 - view->ambient) * fmin(1, fmax(0, lit));
}

/* Marks the pixels whose centre is nearer than `reach` to the edge from a to b, as far as that lies
 * at `near` or deeper. */
static inline void pm_mark(const pm_model *m, const double *a, const double *b, double reach,
                           uint8_t *marked)
{
    double p[2][3], x[2], y[2], near = m->distance / 16;
    double depth[2] = {m->distance - a[2], m->distance - b[2]};
    if (depth[0] < near && depth[1] < near) {
        return;
    }
    for (unsigned i = 0; i < 2; i++) {
        double back = depth[i] < near ? (near - depth[i]) / (depth[!i] - depth[i]) : 0;
        for (unsigned k = 0; k < 3; k++) {
            p[i][k] = (i ? b : a)[k] + back * ((i ? a : b)[k] - (i ? b : a)[k]);
        }
        pm_project(m, p[i], &x[i], &y[i]);
    }
    double dx = x[1] - x[0], dy = y[1] - y[0], length = dx * dx + dy * dy;
    double low_x = fmax(0, floor(fmin(x[0], x[1]) - reach)),
           low_y = fmax(0, floor(fmin(y[0], y[1]) - reach));
    double high_x = fmin(m->width - 1, fmax(x[0], x[1]) + reach);
    double high_y = fmin(m->height - 1, fmax(y[0], y[1]) + reach);
    for (int j = (int)low_y; j <= high_y; j++) {
        for (int i = (int)low_x; i <= high_x; i++) {
            double px = i + 0.5 - x[0], py = j + 0.5 - y[0];
            double t = length > 0 ? fmin(1, fmax(0, (px * dx + py * dy) / length)) : 0;
            if (hypot(px - t * dx, py - t * dy) < reach) {
                marked[j * (int)m->width + i] = 1;
            }
        }
    }
}

/* All edges of all triangles. */
static inline void pm_mark_edges(const pm_model *m, double reach, uint8_t *marked)
{
    memset(marked, 0, (size_t)(m->width * m->height));
    for (unsigned i = 0; i < m->mesh->triangles; i++) {
        for (unsigned k = 0; k < 3; k++) {
            const uint16_t *c = m->mesh->corner[i];
            pm_mark(m, m->at[c[k]], m->at[c[(k + 1) % 3]], reach, marked);
        }
    }
}

#endif
