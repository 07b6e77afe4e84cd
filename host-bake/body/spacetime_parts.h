/* What the files of spacetime control share, and nobody else needs.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SPACETIME_PARTS_H
#define BAKE_SPACETIME_PARTS_H

#include "spacetime.h"
#include "spline_parts.h"

/* Times, numbers, ends; a loop's last key repeats the first. whole: each key must be a hard pose.
 */
int motion_check(const motion_input *in, int d, int whole, bake_error *error);

/* Allocates terms, modes and (empty) curves; fades last from end to end until they are set. */
void motion_begin(const motion_input *in, int d, int term_count, motion *out);

/* The mode with damping and stiffness applied. */
bake_mode motion_mode(const linear_model *model, const space_settings *settings, int mode);

/* Coordinate i of c = Phi^T q. */
double motion_project(const linear_model *model, int i, const double *q);

/* The keys of mode `mode`, key_count of them. values: as in motion_solve_term, NULL without partial
 * keys. */
void motion_keys_of_mode(const motion_input *in, const linear_model *model, int mode,
                         const double *values, bake_key *out);

/* How a mode is called in a message: `mode 3 (4.2 Hz)`. */
void motion_mode_name(const linear_model *model, const space_settings *settings, int mode,
                      char name[64]);

/* Warnings of many solves: the first, and how many more. */
typedef struct {
    int count;
    bake_error first;
} motion_warnings;
void motion_warn(motion_warnings *all, const char *who, const bake_error *one);
void motion_warned(const motion_warnings *all, bake_error *error);

/* bake_spline_solve from one inner key with a hard value and a hard velocity to the next. A C2
 * spline through given values has no freedom but its two ends; where a velocity is given as well,
 * least energy is only C1 and the two sides do not know of each other. (Not in loops.) */
int motion_solve_mode(const bake_spline_problem *problem, const bake_key *keys, int key_count,
                      bake_curve *curve, bake_error *error);

/* Solves the d splines of term->model. values: key_count x d, modal values at partial keys (the other
 * rows are not looked at); NULL if there are none. */
int motion_solve_term(const motion_input *in, const double *values, motion_term *term,
                      motion_warnings *warnings, bake_error *error);

/* spacetime_partial.c: values as above from the partial keys of `in`, NULL if there are none. */
int motion_partial_values(const motion_input *in, const linear_model *model, double **values,
                          bake_error *error);

/* Curves that share a segment, as coefficients of its four functions and of its particular
 * solution: w is count x 5. gram: count x count, row-major, added to: the integrals of f_i f_j +
 * regularise[0] w_i w_j + regularise[1] w_i' w_j' + regularise[2] w_i'' w_j''. */
typedef struct {
    const bake_segment *segment;
    const bake_mode *mode;
    const double *regularise; /* 3 */
    int count;
    const double *w;
    double *gram;
} motion_gram;
void motion_gram_add(const motion_gram *g);

/* Weight of a term at t, and its two derivatives. The switch at an end of the motion is none. */
void motion_weight(const motion *m, const motion_term *term, double t, double h[3]);

#endif
