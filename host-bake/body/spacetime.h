/* Spacetime control in a reduced space: the motion through given poses with the least artificial
 * force.
 *                                                                   [Schulz 2.4-2.6, 2.8; errata
 *                                                                     S1-S9]
 * A motion is a sum of terms, each a linear model's wiggly splines, faded in and out:
 *   q(t) = sum_j h_j(t) Phi_j c_j(t)                                                   [Schulz
 *     (2.37)]
 * one-point: one term, h = 1. blending: n terms, quintic fades (S6, S7). coupling: n terms, hard
 * switches.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SPACETIME_H
#define BAKE_SPACETIME_H

#include "space.h"
#include "spline.h"

/* A pose at a time, in coordinates q of the space. weight as in bake_key: [0] of the pose, [1] of
 * the velocity; BAKE_HARD, 0 = free, > 0 soft. A partial pose has rows > 0: it wants S q = p (rows
 * x d, row-major; p rows) and q is not looked at. Hard: S q is as near to p as the space allows
 * (least squares), and the freedom that is left goes to the least force.
 * Soft: weight[0] |S q - p|^2 is added to the energy. */
typedef struct {
    double time;
    const double *q, *v; /* d; v NULL: free */
    double weight[2];
    int rows;
    const double *S, *p;
} space_key;

typedef struct {
    double alpha, beta; /* damping [1/s], [s] */
    double stiffness;   /* s > 0: scales lambda and inner */
    double regularise[3];
    bake_end end[2];        /* FREE, VELOCITY or PERIODIC */
    const double *end_v[2]; /* d, velocities for VELOCITY; NULL = 0 */
} space_settings;

/* What every way to make a motion is asked for. */
typedef struct {
    const space_settings *settings;
    const space_key *keys;
    int key_count;
} motion_input;

typedef struct {
    const linear_model *model;
    bake_mode *mode;      /* d: with damping and stiffness applied */
    bake_curve *curve;    /* d: of c */
    double in[2], out[2]; /* h rises over in, falls over out; in[0] = in[1]: a switch */
} motion_term;

typedef struct {
    int d, term_count;
    int periodic;
    double from, to;
    motion_term *term;
} motion;

/* Algorithm 1 with the model of a base point. Keys are solved mode by mode; partial keys couple
 * them: the values of all modes at these keys come from one quadratic program
 * (spacetime_partial.c). A failure names the mode (number, Hz) and the key times. Warnings
 * (resonance) are passed on in error->text with success, as bake_spline_solve does. An inner key
 * with a hard pose and a hard velocity splits the motion, which is C1 there: a C2 spline through
 * hard poses has no freedom but its two ends. For that reason a soft velocity at an inner key has
 * little effect (none in a loop, or with both end velocities given), and a loop refuses hard ones.
 * Coupled motions have the freedom: there both kinds work, and C2 stays,
 * where damping does not hide the key from the switches. */
int motion_one_point(const linear_model *model, const motion_input *in, motion *out,
                     bake_error *error);

/* The keys that motion_one_point gave to bake_spline_solve (from one hard inner velocity to the
 * next) for mode i: count of them, the caller's; for who wants to solve them again (partial keys
 * have become hard ones). */
void motion_mode_keys(const motion_input *in, int mode, const motion *solved, bake_key *out);
void motion_mode_problem(const linear_model *model, const space_settings *settings, int mode,
                         bake_spline_problem *out);

/* Blending (2.8.1): model j belongs to key j; all keys hard poses. Periodic: models[key_count - 1]
 * is models[0], fades wrap. */
int motion_blend(const linear_model *const *models, const motion_input *in, motion *out,
                 bake_error *error);

/* Coupling (2.8.2): the same keys; switches in the middle between keys (S8), C2 across them and
 * across keys. The thesis has one segment a model; here a model has a knot at its key as well,
 * which lowers the energy. C2 there is a condition too: velocities at keys move the accelerations
 * at the switches, so the minimum alone would not have it. Least among motions whose pieces solve
 * (2.22): without that, a jump of q'' at a switch could be smoothed at no cost and the condition
 * would mean nothing. */
int motion_couple(const linear_model *const *models, const motion_input *in, motion *out,
                  bake_error *error);
void motion_free(motion *m);

/* q, q', q'' at t, each d long, NULL = not wanted; t is clamped to [from, to], where it holds still
 * outside (derivatives 0), or wraps if periodic. */
void motion_eval(const motion *m, double t, double *q, double *v, double *a);

/* E_f2: the sum over the terms of the integral of h |f|^2. */
double motion_energy(const motion *m);

/* The same of the C2 cubic spline through the same poses with the same ends, seen by the same
 * model(s): what the physics saves. Fails where no such cubic is determined. */
int motion_cubic_energy(const motion *m, const motion_input *in, double *energy, bake_error *error);

#endif
