/* Wiggly splines in doubles: exact pieces, and the two ways to determine them.
 * Source: Schulz 2013, 2.4-2.5; the midpoint basis is ours (DESIGN 4); errata S1-S4 (DESIGN 9).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SPLINE_H
#define BAKE_SPLINE_H

#include "bake.h"

/* The scalar oscillator  w'' + 2 delta w' + lambda w + g = f  whose f^2 is minimised (2.20).
 *   lambda [1/s^2] stiffness, may be negative   delta [1/s] damping   g [unit/s^2] constant force
 */
typedef struct {
    double lambda, delta, g;
} bake_mode;

/* Exact solution families in the midpoint basis; s = t - (t0 + t1)/2, H = (t1 - t0)/2.
 *   POLY   1, x, x^2, x^3                                  x = s/H
 *   OSC    {C(a s), S(a s)} x {cos(b s), sin(b s)}         order C cos, C sin, S cos, S sin
 *   CRIT   {C(a s), S(a s)} x {1, x}                       order C, C x, S, S x
 *   EXP    C(a s), S(a s), C(b s), S(b s)                  a > b >= 0
 *   HYP    {C(a s), S(a s)} x {C(b s), S(b s)}             EXP's space when its two rates are close
 *   SERIES P_0 .. P_3, P_j = x^j + O(x^4), power series    a = 2 (lambda - 2 delta^2), b = lambda^2
 * C(r s) = cosh(r s)/cosh(r H), S(r s) = sinh(r s)/sinh(r H); for r = 0: C = 1, S = x.
 * sin(b s) is divided by sin(b H) while b H < pi/2, so every function stays within [-1, 1]
 * (SERIES: [-1.5, 1.5]). HYP and SERIES serve the places where the other four lose digits. A
 * coefficient stays below 40 times the curve's amplitude in POLY, SERIES and OSC with b >= a, below
 * 40 + 4 a H times elsewhere (near critical damping): test_bake_families measures it. */
typedef enum { BAKE_POLY, BAKE_OSC, BAKE_CRIT, BAKE_EXP, BAKE_HYP, BAKE_SERIES } bake_family;

/* w(t) = sum_l w[l] b_l(t) + rest + drive P_4(t) on [t0, t1] seconds. rest = -g/lambda (erratum
 * S1), 0 for lambda = 0. g/lambda is unbounded for lambda -> 0 although the motion is not, so two
 * families have rest 0 and answer the force by a drive there: SERIES always, P_4 = x^4 + ...;
 * EXP while b H < 1e-3, P_4 = 2 (cosh(b s) - 1)/(b H)^2 = x^2 + ... Everywhere else drive is 0. */
typedef struct {
    double t0, t1;
    bake_family family;
    double a, b;
    double w[4];
    double rest, drive;
} bake_segment;

/* out[4]: value, velocity, acceleration, jerk at t (extrapolates beyond the ends). */
void bake_segment_eval(const bake_segment *segment, double t, double out[4]);

/* Chooses the best conditioned family for a mode on [t0, t1] and fills everything but w. */
void bake_segment_prepare(bake_segment *segment, const bake_mode *mode, double t0, double t1);

/* A curve is consecutive segments over [segment[0].t0, segment[count-1].t1]. At an inner knot the
 * later segment counts; outside it is held at its end values (derivatives 0). */
typedef struct {
    int count;
    bake_segment *segment;
} bake_curve;

void bake_curve_eval(const bake_curve *curve, double t, double out[4]);
void bake_curve_free(bake_curve *curve);

/* Moves the segments of `more`, which begins where `curve` ends, behind those of it. */
void bake_curve_append(bake_curve *curve, bake_curve *more);

/* A key. weight: 0 = free, BAKE_HARD = exact, > 0 = soft with that weight eta_j in (2.31).
 * [0] value, [1] velocity, [2] acceleration. */
#define BAKE_HARD (-1.0)
typedef struct {
    double time;
    double target[3];
    double weight[3];
} bake_key;

/* How an end is determined. FREE is the natural condition w'' + 2 delta w' + lambda w + g = 0: what
 * the minimiser of E_f2 does at an end nobody prescribes. (Beside a prescribed acceleration at the
 * other end the banded path imposes it, while the minimiser would trade one end against the other;
 * with a regulariser the minimiser decides.) PERIODIC (both or none) joins value, velocity and
 * acceleration of the first and last key. */
typedef enum {
    BAKE_END_FREE,
    BAKE_END_VELOCITY,
    BAKE_END_ACCELERATION,
    BAKE_END_PERIODIC
} bake_end;

typedef struct {
    bake_mode mode;
    bake_end end[2];           /* start, end */
    double end_value[2];       /* [unit/s] or [unit/s^2], by end[] */
    double alpha, beta, gamma; /* E_reg weights of w^2, w'^2, w''^2 (2.31); 0 = none */
} bake_spline_problem;

/* energy            E_f2 of the result
 * residual          largest violation of a constraint, relative to the terms it is summed from
 * overshoot         largest |w - middle of the keys| over the amplitude the data ask for: half the
 *                   keys' range plus what end speeds and force do in a mean interval
 * condition         reciprocal condition estimate of the solved system, 0..1
 * resonant_segment  the one nearest a multiple of half a period if overshoot > 10, else -1 */
typedef struct {
    double energy, residual, overshoot, condition;
    int resonant_segment;
} bake_spline_report;

/* Solves for the C2 spline through `keys` (strictly ascending times, count >= 2; every key is a
 * knot). All keys hard in value and nothing else prescribed but the ends (not periodic), no
 * regulariser: banded system of 2.5.3, reduced to the m knot velocities (tridiagonal). Otherwise:
 * constrained minimiser of 2.5.2 within the four functions of each segment. Periodic: the last key
 * is the first one a period later; hard values must agree. curve->segment is allocated here, NULL
 * on failure. Success with a non-empty error->text is a warning (overshoot > 10 near resonance).
 * `report` may be NULL, which saves the quadrature of the energy.
 *
 *   error   1e-9 of the amplitude in value, h x velocity, h^2 x acceleration (test_bake_spline);
 *           fails if condition < 1e-11 or residual > 1e-10 */
int bake_spline_solve(const bake_spline_problem *problem, const bake_key *keys, int key_count,
                      bake_curve *curve, bake_spline_report *report, bake_error *error);

/* Plain curves as POLY segments. held: value until the next key, the last until end_time. linear.
 * cubic: C2 interpolating spline is bake_spline_solve with lambda = delta = 0. bspline: keys are
 * control points of a non-uniform cubic B-spline whose knots are the key times. Clamped: starts and
 * ends at the outer keys, with one more control point at a third of each end leg of the polygon.
 * Closed (periodic): the last key repeats the first one a period later. */
int bake_curve_held(const bake_key *keys, int key_count, double end_time, bake_curve *curve,
                    bake_error *error);
int bake_curve_linear(const bake_key *keys, int key_count, bake_curve *curve, bake_error *error);
int bake_curve_bspline(const bake_key *keys, int key_count, int periodic, bake_curve *curve,
                       bake_error *error);

#endif
