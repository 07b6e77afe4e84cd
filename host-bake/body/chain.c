/* Planar chains of rigid links: kinetic and potential energy in generalised coordinates.
 * Source: Schulz 2013, 2.3.1, 5.1, 5.2; errata S14, S15. Own: trees of any shape, gravity.
 *   q   d          coordinates, see chain.h
 *   J   2 x d      of a link's start: its velocity is J q'
 *   M   d x d      sum of m J^T J + I1 (J^T n e^T + e n^T J) + I2 e e^T over the links' rods: 5.2
 *     with
 *                  n = (-sin, cos) of the link, e the unit vector of its coordinate
 * The heights of all masses are sums of sines, y_0 + sum over links of (I1 + length * all masses
 * beyond) sin theta, so that gravity's Hessian is diagonal.
 * Christoffel terms (2.4) are left out of d2V: they are multiplied with dV, 0 at an equilibrium.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "chain.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define COORDINATES_MAX (CHAIN_LINKS_MAX + 2)

/* Where a link's angle comes from: q[coordinate] + offset; -1: offset alone (welded to the
 * ground). */
typedef struct {
    int size, coordinate[CHAIN_LINKS_MAX];
    double offset[CHAIN_LINKS_MAX];
} layout;

static layout layout_of(const chain *c)
{
    layout at = {.size = c->free_root ? 2 : 0};
    for (int i = 0; i < c->link_count; i++) {
        const chain_link *l = &c->link[i];
        if (!l->stiff) {
            at.coordinate[i] = at.size++;
        } else if (l->parent < 0) {
            at.coordinate[i] = -1;
            at.offset[i] = l->angle;
        } else {
            at.coordinate[i] = at.coordinate[l->parent];
            at.offset[i] = at.offset[l->parent] + l->angle - c->link[l->parent].angle;
        }
    }
    return at;
}

static double angle_of(const layout *at, const double *q, int i)
{
    return (at->coordinate[i] < 0 ? 0 : q[at->coordinate[i]]) + at->offset[i];
}

int chain_size(const chain *c)
{
    return layout_of(c).size;
}

void chain_rest(const chain *c, double *q)
{
    layout at = layout_of(c);
    memset(q, 0, (size_t)at.size * sizeof *q);
    for (int i = 0; i < c->link_count; i++) {
        if (!c->link[i].stiff)
            q[at.coordinate[i]] = c->link[i].angle;
    }
}

void chain_points(const chain *c, const double *q, double *out)
{
    layout at = layout_of(c);
    for (int i = 0; i < c->link_count; i++) {
        const chain_link *l = &c->link[i];
        double angle = angle_of(&at, q, i), *p = out + 4 * i;
        for (int k = 0; k < 2; k++)
            p[k] = l->parent >= 0 ? out[4 * l->parent + 2 + k] : c->free_root ? q[k] : 0;
        p[2] = p[0] + l->length * cos(angle);
        p[3] = p[1] + l->length * sin(angle);
    }
}

/* ---- masses ------------------------------------------------------------------------------------ */

/* [0] mass, [1] and [2] first and second moment about the start, of the rod alone [Schulz 5.2]. */
static void rod_moments(const chain_link *l, double moment[3])
{
    double a = l->density[0], b = l->density[1], length = l->length;
    moment[0] = length * (a + b) / 2;
    moment[1] = length * length * (a / 2 + b) / 3;
    moment[2] = length * length * length * (a / 3 + b) / 4;
}

/* M += m J^T J */
static void add_point(double m, int d, double (*J)[COORDINATES_MAX], double *M)
{
    for (int i = 0; i < d; i++) {
        for (int j = 0; j < d; j++)
            M[i * d + j] += m * (J[0][i] * J[0][j] + J[1][i] * J[1][j]);
    }
}

/* What the rod's turn about its start adds, in coordinate e. normal: n. */
static void add_turn(const double moment[3], const double normal[2], int d, int e,
                     double (*J)[COORDINATES_MAX], double *M)
{
    for (int i = 0; i < d; i++) {
        double mixed = moment[1] * (J[0][i] * normal[0] + J[1][i] * normal[1]);
        M[i * d + e] += mixed;
        M[e * d + i] += mixed;
    }
    M[e * d + e] += moment[2];
}

void chain_mass(const chain *c, const double *q, double *M)
{
    layout at = layout_of(c);
    int d = at.size;
    double J[CHAIN_LINKS_MAX + 1][2][COORDINATES_MAX]; /* of the root, then of each link's end */
    memset(J[0], 0, sizeof J[0]);
    for (int k = 0; k < 2 && c->free_root; k++)
        J[0][k][k] = 1;
    memset(M, 0, (size_t)d * (size_t)d * sizeof *M);
    add_point(c->root_mass, d, J[0], M);
    for (int i = 0; i < c->link_count; i++) {
        const chain_link *l = &c->link[i];
        int start = l->parent + 1, end = i + 1, e = at.coordinate[i];
        double angle = angle_of(&at, q, i), normal[2] = {-sin(angle), cos(angle)}, moment[3];
        rod_moments(l, moment);
        memcpy(J[end], J[start], sizeof J[end]);
        add_point(moment[0], d, J[start], M);
        if (e >= 0) {
            add_turn(moment, normal, d, e, J[start], M);
            J[end][0][e] += l->length * normal[0];
            J[end][1][e] += l->length * normal[1];
        }
        add_point(l->end_mass, d, J[end], M);
    }
}

/* ---- potential --------------------------------------------------------------------------------- */

/* Weights of sin theta in the sum of mass times height; returns all of the mass. */
static double height_weights(const chain *c, double *weight)
{
    double moment[3], beyond[CHAIN_LINKS_MAX], all = c->root_mass;
    for (int i = 0; i < c->link_count; i++)
        beyond[i] = c->link[i].end_mass;
    for (int i = c->link_count - 1; i >= 0; i--) {
        const chain_link *l = &c->link[i];
        rod_moments(l, moment);
        weight[i] = moment[1] + l->length * beyond[i];
        *(l->parent >= 0 ? &beyond[l->parent] : &all) += moment[0] + beyond[i];
    }
    return all;
}

/* The spring of link i: its stretch beyond rest, and the coordinates that stretch and relax it. */
typedef struct {
    double stretch;
    int plus, minus; /* -1: the ground */
} joint;

static joint joint_of(const chain *c, const layout *at, const double *q, int i)
{
    const chain_link *l = &c->link[i];
    joint j = {angle_of(at, q, i) - l->angle, at->coordinate[i], -1};
    if (l->parent >= 0) {
        j.stretch -= angle_of(at, q, l->parent) - c->link[l->parent].angle;
        j.minus = at->coordinate[l->parent];
    }
    return j;
}

double chain_energy(const chain *c, const double *q)
{
    layout at = layout_of(c);
    double weight[CHAIN_LINKS_MAX], all = height_weights(c, weight);
    double V = c->free_root ? c->gravity * all * q[1] : 0;
    for (int i = 0; i < c->link_count; i++) {
        V += c->gravity * weight[i] * sin(angle_of(&at, q, i));
        if (!c->link[i].stiff) {
            double stretch = joint_of(c, &at, q, i).stretch;
            V += c->link[i].spring / 2 * stretch * stretch;
        }
    }
    return V;
}

void chain_gradient(const chain *c, const double *q, double *gradient)
{
    layout at = layout_of(c);
    double weight[CHAIN_LINKS_MAX], all = height_weights(c, weight);
    memset(gradient, 0, (size_t)at.size * sizeof *gradient);
    if (c->free_root)
        gradient[1] = c->gravity * all;
    for (int i = 0; i < c->link_count; i++) {
        if (at.coordinate[i] >= 0)
            gradient[at.coordinate[i]] += c->gravity * weight[i] * cos(angle_of(&at, q, i));
        if (c->link[i].stiff)
            continue;
        joint j = joint_of(c, &at, q, i);
        gradient[j.plus] += c->link[i].spring * j.stretch;
        if (j.minus >= 0)
            gradient[j.minus] -= c->link[i].spring * j.stretch;
    }
}

void chain_hessian(const chain *c, const double *q, double *H)
{
    layout at = layout_of(c);
    int d = at.size;
    double weight[CHAIN_LINKS_MAX];
    height_weights(c, weight);
    memset(H, 0, (size_t)d * (size_t)d * sizeof *H);
    for (int i = 0; i < c->link_count; i++) {
        double k = c->link[i].spring;
        if (at.coordinate[i] >= 0)
            H[at.coordinate[i] * (d + 1)] -= c->gravity * weight[i] * sin(angle_of(&at, q, i));
        if (c->link[i].stiff)
            continue;
        joint j = joint_of(c, &at, q, i);
        H[j.plus * (d + 1)] += k;
        if (j.minus >= 0) {
            H[j.minus * (d + 1)] += k;
            H[j.plus * d + j.minus] -= k;
            H[j.minus * d + j.plus] -= k;
        }
    }
}

/* ---- checks ------------------------------------------------------------------------------------ */

static int check_link(const chain *c, int i, bake_error *error)
{
    const chain_link *l = &c->link[i];
    if (l->parent < -1 || l->parent >= i)
        return bake_fail(error, "link %d: its parent must stand before it", i + 1);
    if (!(l->length > 0 && isfinite(l->length)))
        return bake_fail(error, "link %d: its length must be above 0", i + 1);
    if (!isfinite(l->angle))
        return bake_fail(error, "link %d: its angle is not a number", i + 1);
    const double none_below_0[4] = {l->end_mass, l->density[0], l->density[1], l->spring};
    for (int k = 0; k < 4; k++) {
        if (!(none_below_0[k] >= 0 && isfinite(none_below_0[k])))
            return bake_fail(error, "link %d: masses, densities and springs must not be below 0",
                             i + 1);
    }
    return 0;
}

/* Pivots of M scaled to a unit diagonal: sums of d products, so they are noise below some d^2 eps =
 * 3e-13, and a real chain's masses do not differ by 12 digits. */
#define PIVOT 1e-12

/* The first coordinate (from 0) without inertia of its own in the rest pose, or -1. */
static int first_weightless(const chain *c, int d)
{
    double q[COORDINATES_MAX], root[COORDINATES_MAX];
    double *M = bake_alloc((size_t)(d * d) + 1, sizeof *M);
    int found = -1;
    chain_rest(c, q);
    chain_mass(c, q, M);
    for (int i = 0; i < d && found < 0; i++) {
        root[i] = sqrt(M[i * (d + 1)]);
        found = root[i] > 0 && isfinite(root[i]) ? -1 : i;
    }
    for (int i = 0; i < d * d && found < 0; i++)
        M[i] /= root[i / d] * root[i % d];
    if (found < 0) {
        lapack_int info = LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'L', d, M, d);
        found = info > 0 ? (int)info - 1 : -1;
        for (int i = 0; i < d && found < 0; i++)
            found = M[i * (d + 1)] * M[i * (d + 1)] > PIVOT ? -1 : i;
    }
    free(M);
    return found;
}

static int link_of(const chain *c, int coordinate)
{
    layout at = layout_of(c);
    int i = 0;
    while (i < c->link_count && at.coordinate[i] != coordinate)
        i++;
    return i;
}

int chain_check(const chain *c, bake_error *error)
{
    if (c->link_count < 1 || c->link_count > CHAIN_LINKS_MAX)
        return bake_fail(error, "a chain has 1 to %d links, not %d", CHAIN_LINKS_MAX,
                         c->link_count);
    if (!(c->root_mass >= 0 && isfinite(c->root_mass)) || !isfinite(c->gravity))
        return bake_fail(error, "the root's mass must not be below 0, and gravity be a number");
    for (int i = 0; i < c->link_count; i++) {
        if (check_link(c, i, error) < 0)
            return -1;
    }
    int d = chain_size(c);
    if (d == 0)
        return bake_fail(error, "nothing of the chain can move: all links are stiff");
    int weightless = first_weightless(c, d);
    if (weightless < 0)
        return 0;
    if (c->free_root && weightless < 2)
        return bake_fail(error, "the chain has no mass: give its links a mass or a density");
    return bake_fail(error,
                     "link %d can turn without moving any mass: give it (or what it carries%s) "
                     "a mass or a density",
                     link_of(c, weightless) + 1, c->free_root ? ", or the root" : "");
}
