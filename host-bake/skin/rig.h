/* A rig in doubles: what the player's integers are compared with, and what decides how many
 * influences a vertex needs.
 * Source: Jacobson 2013, 4.3.4 (pseudo-edges), (6.2), (6.5), (6.6); Kavan et al. 2008 (dual
 * quaternions); the order of joints is SPEC 6.9.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_RIG_H
#define BAKE_RIG_H

#include "influence.h"
#include "scene.h"

/* A bone at one moment: q -> at + turn K(e) (e stretch u + q - origin), K the turn about u by
 * (1 - e) twist[0] + e twist[1]. */
typedef struct {
    double turn[9], quaternion[4]; /* the same rotation */
    double at[3];                  /* where the origin is */
    double stretch;                /* (L'/L - 1) L, scene units */
    double twist[2];               /* radians, unbounded */
} rig_bone;

/* values: a number each channel of the scene, in its unit. out: bone_count. */
void rig_pose(const scene_rig *rig, const double *values, rig_bone *out);

/* Where the bones put a point of the rest pose. weight, end: bone_count (end NULL: 0). */
void rig_skin(const scene_rig *rig, const rig_bone *bones, const double *weight, const double *end,
              const double point[3], double out[3]);

#endif
