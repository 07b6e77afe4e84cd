/* What the files of the spline solver share, and nobody else needs.
 * Source: Schulz 2013, 2.5; the reduction to knot values and velocities is our own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SPLINE_PARTS_H
#define BAKE_SPLINE_PARTS_H

#include "spline.h"

/* One segment as a map from its knots. All basis functions are even or odd in s, so the two ends
 * split into  even: ((w0 + w1)/2, H (v1 - v0)/2)  and  odd: ((w1 - w0)/2, H (v0 + v1)/2),
 * each with two functions. The 2 x 2 systems are never singular: w = w' = 0 at both ends makes the
 * minimiser of a positive definite energy vanish [Schulz lemma 3]. */
typedef struct {
    double H;
    double end[4][4];        /* derivative x function at s = +H, in units of 1/H^derivative */
    double part[4];          /* the particular solution there, same units; it is even */
    double inverse[2][2][2]; /* [parity] coefficients from (value, H velocity) */
    double right[4];         /* acceleration at t1 = right . (w0, v0, w1, v1) + shift */
    double left[4];          /* acceleration at t0 = left . (w0, v0, w1, v1) + shift */
    double shift;
} bake_part;

/* The two even (parity 0) or odd (parity 1) functions of a family. */
int bake_family_index(bake_family family, int parity, int which);

void bake_part_prepare(bake_part *part, const bake_segment *segment);

/* Sets segment->w so that the segment takes values w and velocities v at its two ends. */
void bake_part_coefficients(const bake_part *part, const double w[2], const double v[2],
                            bake_segment *segment);

/* Basis functions 0..3 and the particular solution 4 at s = t - midpoint: out[derivative][5]. */
void bake_segment_functions(const bake_segment *segment, double s, double out[4][5]);

/* Calls visit(context, s, weight) at the nodes of a composite 16-point Gauss-Legendre rule on one
 * segment: panels double away from each end (layers of width 1/a) and never exceed half a period.
 *   error   <= 1e-12 of the boundary terms the energy integrates to (test_bake_families) */
typedef void bake_visit(void *context, double s, double weight);
void bake_segment_quadrature(const bake_segment *segment, bake_visit *visit, void *context);

/* A problem in the form both solvers use. */
typedef struct {
    const bake_spline_problem *problem;
    const bake_key *keys;
    int key_count;
    bake_segment *segments; /* key_count - 1 */
    bake_part *parts;       /* key_count - 1 */
    double *w, *v;          /* key_count values and velocities */
    double condition;
} bake_work;

/* Values are hard everywhere, nothing else is prescribed: tridiagonal system for the velocities. */
int bake_solve_banded(bake_work *work, bake_error *error);

/* Everything else: constrained minimiser. */
int bake_solve_energy(bake_work *work, bake_error *error);

/* Measures the finished curve, fails on a residual, explains resonance. report may be NULL. */
int bake_spline_check(const bake_work *work, bake_spline_report *report, bake_error *error);

/* The segment whose length is nearest a multiple of half a period, within a quarter; else -1. */
int bake_resonant_segment(const bake_work *work);

/* Fails with `what`, the resonating keys if there are any, and the remedies. */
int bake_fail_resonant(const bake_work *work, const char *what, bake_error *error);

#endif
