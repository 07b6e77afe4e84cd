/* Equilibria under drags and forces: Newton's method with a line search, in load steps.
 *   x   3 n   positions      r   3 n   dV(x) - force: what holds the body where it is not free
 *   Z   3 n x c              free directions (held, without the dragged vertices)
 *   g   c     Z^T r: 0 in equilibrium       K   3 n x 3 n   d2V(x)
 *   A   c x c Z^T K Z + shift M: shifted until it is positive definite, so that steps go downhill
 * Source: own. A load step begins with the tangent of the path of equilibria, A dy = -Z^T K dx of
 * the dragged vertices: moved alone they would turn the elements beside them inside out.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "statics.h"
#include "sparse.h"

#include <cblas.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The smallest share of the whole drag that a step may have, and how many factors all of it may
 * take. */
#define LEAST_STEP  (1.0 / 1024)
#define MOST_SOLVES 400

/* Newton's iterations for one load step: less than ten, but on the way down from a ridge. */
#define MOST_ITERATIONS 100

/* An eigenvalue below this share of the stiffest is unstable; nearer to 0 it may be a free turn,
 * with what is left of forces in it. How often a load step leaves a ridge. */
#define UNSTABLE    1e-9
#define MOST_RIDGES 2

#define CONVERGED 1e-8

typedef struct {
    const body *b;
    const double *force; /* or NULL */
    freedom f;
    double *M;             /* c */
    double *x, *trial, *r; /* 3 n */
    double *g, *y;         /* c */
    body_blocks K;
    sparse A;
    sparse_factor *factor;
    double stiffest; /* the largest A_ii / M_i */
    double rounding; /* |g| that rounding in x makes */
    double shift;    /* what made the last indefinite A positive definite; 0 = none was */
    int solves;
} statics;

/* ---- what is free ---------------------------------------------------------------------------- */

/* `held` without the dragged vertices. */
static void keep_free(const freedom *held, const statics_drag *drag, freedom *out)
{
    int n = held->vertex_count;
    char *dragged = bake_alloc((size_t)n, 1);
    for (int i = 0; i < drag->count; i++) {
        dragged[drag->vertex[i]] = 1;
    }
    *out = (freedom){.vertex_count = n};
    out->first = bake_alloc((size_t)n + 1, sizeof *out->first);
    out->axis = bake_alloc((size_t)held->count, sizeof *out->axis);
    for (int i = 0; i < n; i++) {
        out->first[i] = out->count;
        for (int j = held->first[i]; j < held->first[i + 1] && !dragged[i]; j++) {
            memcpy(out->axis[out->count++], held->axis[j], sizeof *out->axis);
        }
    }
    out->first[n] = out->count;
    free(dragged);
}

static void statics_make(statics *s, const body *b, const freedom *held, const statics_drag *drag)
{
    size_t n = 3 * (size_t)b->vertex_count;
    memset(s, 0, sizeof *s);
    s->b = b;
    keep_free(held, drag, &s->f);
    s->x = bake_alloc(n, sizeof *s->x);
    s->trial = bake_alloc(n, sizeof *s->trial);
    s->r = bake_alloc(n, sizeof *s->r);
    s->M = bake_alloc((size_t)s->f.count, sizeof *s->M);
    s->g = bake_alloc((size_t)s->f.count, sizeof *s->g);
    s->y = bake_alloc((size_t)s->f.count, sizeof *s->y);
    for (int i = 0; i < b->vertex_count; i++) {
        for (int j = s->f.first[i]; j < s->f.first[i + 1]; j++) {
            s->M[j] = b->mass[i];
        }
    }
}

static void statics_free(statics *s)
{
    freedom_free(&s->f);
    body_blocks_free(&s->K);
    sparse_free(&s->A);
    sparse_factor_free(s->factor);
    free(s->x);
    free(s->trial);
    free(s->r);
    free(s->M);
    free(s->g);
    free(s->y);
}

/* ---- energy ---------------------------------------------------------------------------------- */

/* A tetrahedron of StVK may be turned inside out at a finite price: that is no pose. */
static int inside_out(const body *b, const double *x)
{
    for (int e = 0; b->kind == BODY_SOLID && e < b->element_count; e++) {
        double m[3][3];
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 3; i++) {
                m[k][i] = x[3 * b->element[e][k + 1] + i] - x[3 * b->element[e][0] + i];
            }
        }
        double det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                     m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                     m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
        if (!(det > 0)) {
            return 1;
        }
    }
    return 0;
}

static double potential(const statics *s, const double *x)
{
    int n = 3 * s->b->vertex_count;
    if (inside_out(s->b, x)) {
        return HUGE_VAL;
    }
    return body_energy(s->b, x) - (s->force ? cblas_ddot(n, s->force, 1, x, 1) : 0);
}

/* r, g; returns |g| over what it should be at most. */
static double unbalance(statics *s)
{
    int n = 3 * s->b->vertex_count;
    body_gradient(s->b, s->x, s->r);
    if (s->force) {
        cblas_daxpy(n, -1, s->force, 1, s->r, 1);
    }
    freedom_restrict(&s->f, s->r, s->g);
    double all = cblas_dnrm2(n, s->r, 1), open = cblas_dnrm2(s->f.count, s->g, 1);
    double reactions = sqrt(fmax(all * all - open * open, 0));
    return open > 0 ? open / fmax(CONVERGED * reactions, s->rounding) : 0;
}

/* K and A at x, and what follows from their size. */
static int linearise(statics *s, bake_error *error)
{
    double stiffest = 0, size = 0;
    s->K.count = 0;
    sparse_free(&s->A);
    body_hessian(s->b, s->x, &s->K);
    if (sparse_from_blocks(&s->K, &s->f, &s->A, error) < 0) {
        return -1;
    }
    s->stiffest = 0;
    for (int j = 0; j < s->A.n; j++) {
        double diagonal = fabs(s->A.value[s->A.column[j]]);
        stiffest = fmax(stiffest, diagonal);
        s->stiffest = fmax(s->stiffest, diagonal / s->M[j]);
    }
    for (int i = 0; i < 3 * s->b->vertex_count; i++) {
        size = fmax(size, fabs(s->x[i]));
    }
    /* each x is off by eps / 2 of its size, each force by the stiffness times that, a few times */
    s->rounding = 4 * DBL_EPSILON * stiffest * size * sqrt(s->A.n);
    return 0;
}

/* A factor of A + shift M. The first shift is for bodies that may still turn freely: far below what
 * any mode has, but enough for a factor. Where K is indefinite, the best shift is little more than
 * its lowest eigenvalue: a larger one slows everything that is soft. So each search begins with
 * half of what the last one found. 1 = there is none. */
static int factorise(statics *s, bake_error *error)
{
    double shift = 1e-12 * s->stiffest, grow = s->shift > 0 ? 2 : 8;
    if (!s->factor && !(s->factor = sparse_analyse(&s->A, error))) {
        return -1;
    }
    int err = sparse_refactor(s->factor, &s->A, shift, s->M, error);
    s->solves++;
    for (shift = s->shift > 0 ? s->shift / 2 : 1e-6 * s->stiffest;
         err == 1 && shift < 1e3 * s->stiffest; shift *= grow) {
        err = sparse_refactor(s->factor, &s->A, shift, s->M, error);
        s->solves++;
        s->shift = shift;
    }
    return err;
}

/* ---- steps ----------------------------------------------------------------------------------- */

/* trial = x + share Z y */
static void move(statics *s, double share)
{
    int n = 3 * s->b->vertex_count;
    freedom_expand(&s->f, s->y, s->trial);
    cblas_dscal(n, share, s->trial, 1);
    cblas_daxpy(n, 1, s->x, 1, s->trial, 1);
}

/* Halves the step along y until the potential falls. 1 = it does not. */
static int search(statics *s)
{
    int n = 3 * s->b->vertex_count;
    double before = potential(s, s->x), slope = cblas_ddot(s->f.count, s->g, 1, s->y, 1);
    double rounding = 16 * DBL_EPSILON * (fabs(before) + fabs(body_energy(s->b, s->x)));
    for (double share = 1; share > 1e-6; share /= 2) {
        move(s, share);
        if (potential(s, s->trial) <= before + 1e-4 * share * slope + rounding) {
            memcpy(s->x, s->trial, (size_t)n * sizeof *s->x);
            return 0;
        }
    }
    return 1;
}

/* In a symmetric drag Newton's method may balance on a ridge (a bar pushed along its axis). Then x
 * moves off it, along what A's factor says is softest. 1 = moved, 0 = nothing is unstable. */
static int leave_ridge(statics *s, bake_error *error)
{
    double most = 0, size = 0;
    int err = sparse_refactor(s->factor, &s->A, UNSTABLE * s->stiffest, s->M, error);
    s->solves++;
    if (err != 1) {
        return err;
    }
    if (factorise(s, error) != 0) {
        return -1;
    }
    for (int j = 0; j < s->f.count; j++) { /* any direction that no symmetry knows of */
        s->y[j] = s->M[j] * (1 + j % 7 - 0.01 * (j % 11));
    }
    for (int pass = 0; pass < 2; pass++) {
        sparse_solve(s->factor, s->y, 1);
        most = 0;
        for (int j = 0; j < s->f.count; j++) {
            most = fmax(most, fabs(s->y[j]));
            s->y[j] *= pass == 0 ? s->M[j] : 1;
        }
    }
    for (int i = 0; i < 3 * s->b->vertex_count; i++) {
        size = fmax(size, fabs(s->b->rest[i] - s->b->rest[i % 3]));
    }
    double share = 1e-3 * size / most;
    for (move(s, share); potential(s, s->trial) == HUGE_VAL && share > 0; move(s, share)) {
        share /= 2;
    }
    memcpy(s->x, s->trial, 3 * (size_t)s->b->vertex_count * sizeof *s->x);
    return linearise(s, error) < 0 ? -1 : 1;
}

/* Equilibrium from x, the dragged vertices where they are. 1 = not found. */
static int newton(statics *s, bake_error *error)
{
    int err = linearise(s, error), ridges = 0;
    for (int i = 0; err == 0 && i < MOST_ITERATIONS; i++) {
        if (unbalance(s) <= 1) {
            int moved = !s->factor || ridges++ == MOST_RIDGES ? 0 : leave_ridge(s, error);
            if (moved != 1) {
                return moved;
            }
            unbalance(s);
        }
        err = factorise(s, error);
        if (err == 0) {
            for (int j = 0; j < s->f.count; j++) {
                s->y[j] = -s->g[j];
            }
            sparse_solve(s->factor, s->y, 1);
            err = search(s);
        }
        err = err == 0 ? linearise(s, error) : err;
    }
    return err == 0 ? unbalance(s) > 1 : err;
}

/* w = K u; K's blocks are a lower triangle. */
static void multiply(const body_blocks *K, const double *u, double *w)
{
    for (size_t p = 0; p < K->count; p++) {
        const body_block *block = &K->at[p];
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                w[3 * block->a + i] += block->k[3 * i + j] * u[3 * block->b + j];
                if (block->a != block->b) {
                    w[3 * block->b + j] += block->k[3 * i + j] * u[3 * block->a + i];
                }
            }
        }
    }
}

/* The dragged vertices move by `share` of what is missing, the others along the tangent. 1 = that
 * turns something inside out. */
static int predict(statics *s, const statics_drag *drag, double share, bake_error *error)
{
    int n = 3 * s->b->vertex_count;
    double *u = bake_alloc((size_t)n, sizeof *u), *w = bake_alloc((size_t)n, sizeof *w);
    int err = factorise(s, error);
    for (int i = 0; i < drag->count; i++) {
        for (int k = 0; k < 3; k++) {
            int at = 3 * drag->vertex[i] + k;
            u[at] = share * (drag->target[3 * i + k] - s->x[at]);
        }
    }
    if (err == 0) {
        multiply(&s->K, u, w);
        freedom_restrict(&s->f, w, s->y);
        cblas_dscal(s->f.count, -1, s->y, 1);
        sparse_solve(s->factor, s->y, 1);
        move(s, 1);
        cblas_daxpy(n, 1, u, 1, s->trial, 1);
        err = inside_out(s->b, s->trial) || body_energy(s->b, s->trial) == HUGE_VAL;
    }
    if (err == 0) {
        memcpy(s->x, s->trial, (size_t)n * sizeof *s->x);
    }
    free(u);
    free(w);
    return err;
}

/* From equilibrium to equilibrium, in steps that are halved when they fail. */
static int follow(statics *s, const statics_drag *drag, bake_error *error)
{
    size_t bytes = 3 * (size_t)s->b->vertex_count * sizeof *s->x;
    double *good = bake_alloc(bytes, 1), done = 0, step = 1;
    int err = 0;
    while (err >= 0 && done < 1 && step >= LEAST_STEP && s->solves < MOST_SOLVES) {
        double share = step / (1 - done);
        memcpy(good, s->x, bytes);
        err = predict(s, drag, fmin(share, 1), error);
        err = err == 0 ? newton(s, error) : err;
        if (err == 0) {
            done = share >= 1 ? 1 : done + step;
            step = fmin(2 * step, 1 - done);
        } else if (err == 1) {
            memcpy(s->x, good, bytes);
            err = linearise(s, error);
            step /= 2;
        }
    }
    free(good);
    if (err >= 0 && done < 1) {
        err = bake_fail(
            error,
            "the drag got %.0f%% of the way: beyond, the body has no equilibrium that can "
            "be followed without turning elements inside out; drag less far, or more of it",
            100 * done);
    }
    return err;
}

static int check_drag(const body *b, const statics_drag *drag, bake_error *error)
{
    for (int i = 0; i < drag->count; i++) {
        const double *at = &drag->target[3 * i];
        if (drag->vertex[i] < 0 || drag->vertex[i] >= b->vertex_count) {
            return bake_fail(error, "vertex %d of %d is dragged", drag->vertex[i], b->vertex_count);
        }
        if (!(isfinite(at[0]) && isfinite(at[1]) && isfinite(at[2]))) {
            return bake_fail(error, "vertex %d is dragged to (%g, %g, %g)", drag->vertex[i], at[0],
                             at[1], at[2]);
        }
    }
    return 0;
}

/* Nothing is free: the targets are all there is. */
static int put(const statics *s, const statics_drag *drag, double *x, bake_error *error)
{
    for (int i = 0; i < drag->count; i++) {
        memcpy(&x[3 * drag->vertex[i]], &drag->target[3 * i], 3 * sizeof *x);
    }
    return !inside_out(s->b, x) ? 0 : bake_fail(error, "the drag turns elements inside out");
}

int statics_solve(const body *b, const freedom *held, const statics_drag *drag, const double *force,
                  double *x, bake_error *error)
{
    statics s;
    size_t bytes = 3 * (size_t)b->vertex_count * sizeof *x;
    if (check_drag(b, drag, error) < 0) {
        return -1;
    }
    statics_make(&s, b, held, drag);
    s.force = force;
    memcpy(s.x, x, bytes);
    int err = s.f.count == 0 ? put(&s, drag, s.x, error) : newton(&s, error);
    if (err == 1) {
        err = bake_fail(error, "the drag got 0%% of the way: there is no equilibrium near the pose "
                               "it starts from; is something not held that forces push?");
    }
    if (err == 0 && s.f.count > 0 && drag->count > 0) {
        err = follow(&s, drag, error);
    }
    if (err == 0) {
        memcpy(x, s.x, bytes);
    }
    statics_free(&s);
    return err;
}
