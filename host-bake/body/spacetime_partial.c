/* Partial keys: the values of all modes there, from one quadratic program.
 * Source: own. A mode's least energy is a quadratic function of its values at the P partial keys,
 * because its solution is affine in them:  w = w_0 + sum_k x_k w_k,  w_0 with the data and zeros,
 * w_k with a unit at partial key k and no data. Its P + 1 solutions share segments, so that the
 * energies' Gram matrix is one integral a segment.
 *
 *   x    P x d    modal values at the partial keys, the unknowns (x = values, key by key)
 *   G    (P+1)^2  of each mode: E = (1, x)^T G (1, x)
 *   D    P x d    scale: y = D x makes the energy's diagonal 1
 *   C    r x d    independent rows of S Phi / D of a hard key: C y = e
 *   N    d x f    orthonormal, C N = 0: y = y_0 + N z (soft keys: y_0 = 0, N = 1)
 *   A    F x F    energy in z, F = sum of the f
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spacetime_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rows of S that move less than this part of what its strongest combination moves are left to the
 * energy: what space_make calls independent. */
#define RANK_LIMIT      1e-7
/* Smallest singular value of A, whose diagonal is 1: below, fewer than 3 digits of z remain. */
#define CONDITION_LIMIT 1e-13
#define RESIDUAL_LIMIT  1e-10

typedef struct {
    int key;           /* of the input; a loop's last key is its first */
    int rank, freedom; /* r, f = d - r; soft: 0, d */
    int first;         /* of its z in the system */
    double *y0, *N;    /* d; d x f, column-major */
    double *target;    /* soft: S^T p weight, d */
    double *soft;      /* soft: weight S^T S, d x d; in modal coordinates, as target */
} partial_key;

typedef struct {
    const motion_input *in;
    const linear_model *model;
    int d, count, size; /* count: P, size: F */
    partial_key *key;
    double *G; /* d x (P+1) x (P+1) */
    double *D; /* P x d */
    double *A, *right;
} partial_system;

static int is_loop(const motion_input *in)
{
    return in->settings->end[0] == BAKE_END_PERIODIC;
}

/* Partial keys in order; what a loop's last key wants, its first one wants already. */
static int list_keys(const motion_input *in, partial_key *out)
{
    int count = 0;
    for (int k = 0; k < in->key_count - is_loop(in); k++)
        if (in->keys[k].rows > 0) {
            if (out)
                out[count] = (partial_key){.key = k};
            count++;
        }
    return count;
}

/* ---- the energy of a mode -------------------------------------------------------------------- */

/* Keys and problem of w_which: 0 has the data, 1 .. P a unit at partial key which - 1. */
static void response_problem(const partial_system *s, int mode, int which,
                             bake_spline_problem *problem, bake_key *keys)
{
    int count = s->in->key_count;
    double *values = bake_alloc((size_t)count * (size_t)s->d, sizeof *values);
    motion_mode_problem(s->model, s->in->settings, mode, problem);
    motion_keys_of_mode(s->in, s->model, mode, values, keys);
    free(values);
    if (which == 0)
        return;
    problem->mode.g = problem->end_value[0] = problem->end_value[1] = 0.0;
    for (int k = 0; k < count; k++)
        memset(keys[k].target, 0, sizeof keys[k].target);
    int unit = s->key[which - 1].key;
    keys[unit].target[0] = 1.0;
    if (unit == 0 && is_loop(s->in))
        keys[count - 1].target[0] = 1.0;
}

static int solve_responses(const partial_system *s, int mode, bake_curve *curves, bake_error *error)
{
    bake_key *keys = bake_alloc((size_t)s->in->key_count, sizeof *keys);
    bake_spline_problem problem;
    int failed = 0;
    for (int i = 0; i <= s->count && !failed; i++) {
        bake_error own = {""};
        char name[64];
        response_problem(s, mode, i, &problem, keys);
        failed = motion_solve_mode(&problem, keys, s->in->key_count, &curves[i], &own);
        motion_mode_name(s->model, s->in->settings, mode, name);
        if (failed)
            bake_fail(error, "%s: %.900s", name, own.text);
    }
    free(keys);
    return failed;
}

/* Soft keys weigh values and velocities of the responses against their targets: (w - target)^2,
 * where only w_0 has a target. */
static void add_soft_terms(const partial_system *s, const bake_key *keys, const bake_curve *curves,
                           double *G)
{
    int n = s->count + 1;
    double *x = bake_alloc((size_t)n, sizeof *x), at[4];
    for (int k = 0; k < s->in->key_count; k++)
        for (int order = 0; order < 2; order++) {
            double weight = keys[k].weight[order];
            if (weight <= 0.0)
                continue;
            for (int i = 0; i < n; i++) {
                bake_curve_eval(&curves[i], keys[k].time, at);
                x[i] = at[order] - (i == 0 ? keys[k].target[order] : 0.0);
            }
            cblas_dger(CblasRowMajor, n, n, weight, x, 1, x, 1, G, n);
        }
    free(x);
}

static void gram_of_mode(const partial_system *s, int mode, const bake_curve *curves, double *G)
{
    int n = s->count + 1;
    double *w = bake_alloc((size_t)(5 * n), sizeof *w);
    bake_key *keys = bake_alloc((size_t)s->in->key_count, sizeof *keys);
    bake_spline_problem problem;
    response_problem(s, mode, 0, &problem, keys);
    for (int k = 0; k < s->in->key_count - 1; k++) {
        motion_gram gram = {
            &curves[0].segment[k], &problem.mode, s->in->settings->regularise, n, w, G};
        for (int i = 0; i < n; i++) {
            memcpy(w + 5 * i, curves[i].segment[k].w, sizeof curves[i].segment[k].w);
            w[5 * i + 4] = i == 0 ? 1.0 : 0.0;
        }
        motion_gram_add(&gram);
    }
    add_soft_terms(s, keys, curves, G);
    free(keys);
    free(w);
}

static int find_energies(const partial_system *s, bake_error *error)
{
    size_t n = (size_t)s->count + 1;
    bake_curve *curves = bake_alloc(n, sizeof *curves);
    int failed = 0;
    for (int i = 0; i < s->d && !failed; i++) {
        failed = solve_responses(s, i, curves, error);
        if (!failed)
            gram_of_mode(s, i, curves, s->G + (size_t)i * n * n);
        for (size_t k = 0; k < n; k++)
            bake_curve_free(&curves[k]);
    }
    free(curves);
    return failed;
}

/* ---- what the keys want ---------------------------------------------------------------------- */

/* rows x d, row-major: S Phi */
static double *modal_rows(const partial_system *s, const space_key *key)
{
    double *out = bake_alloc((size_t)key->rows * (size_t)s->d, sizeof *out);
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasTrans, key->rows, s->d, s->d, 1.0, key->S, s->d,
                s->model->Phi, s->d, 0.0, out, s->d);
    return out;
}

static void add_soft_key(const partial_system *s, partial_key *p)
{
    const space_key *key = &s->in->keys[p->key];
    size_t d = (size_t)s->d;
    double weight = key->weight[0], *rows = modal_rows(s, key);
    p->freedom = s->d;
    p->target = bake_alloc(d, sizeof *p->target);
    p->soft = bake_alloc(d * d, sizeof *p->soft);
    cblas_dgemv(CblasRowMajor, CblasTrans, key->rows, s->d, weight, rows, s->d, key->p, 1, 0.0,
                p->target, 1);
    cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, s->d, s->d, key->rows, weight, rows, s->d,
                rows, s->d, 0.0, p->soft, s->d);
    p->y0 = bake_alloc(d, sizeof *p->y0);
    p->N = bake_alloc(d * d, sizeof *p->N);
    for (size_t i = 0; i < d; i++)
        p->N[i * (d + 1)] = 1.0;
    free(rows);
}

/* S Phi = U sigma V^T: C becomes the first r rows of V^T (r x d, row-major), e = sigma^-1 U^T p. */
static int independent_rows(const partial_system *s, partial_key *p, double **C, double **e)
{
    const space_key *key = &s->in->keys[p->key];
    int least = key->rows < s->d ? key->rows : s->d;
    size_t n = (size_t)least;
    double *rows = modal_rows(s, key), *sigma = bake_alloc(n, sizeof *sigma);
    double *U = bake_alloc((size_t)key->rows * n, sizeof *U);
    *C = bake_alloc(n * (size_t)s->d, sizeof **C);
    *e = bake_alloc(n, sizeof **e);
    int info = LAPACKE_dgesdd(LAPACK_ROW_MAJOR, 'S', key->rows, s->d, rows, s->d, sigma, U, least,
                              *C, s->d);
    p->rank = 0;
    while (info == 0 && p->rank < least && sigma[p->rank] > RANK_LIMIT * sigma[0])
        p->rank++;
    if (p->rank > 0)
        cblas_dgemv(CblasRowMajor, CblasTrans, key->rows, p->rank, 1.0, U, least, key->p, 1, 0.0,
                    *e, 1);
    for (int i = 0; i < p->rank; i++)
        (*e)[i] /= sigma[i];
    free(rows);
    free(sigma);
    free(U);
    return info;
}

/* D^-1 C^T = Q R: y_0 = Q_1 R^-T e and N = Q_2. */
static int split_freedom(const partial_system *s, partial_key *p, const double *C, const double *e,
                         const double *D)
{
    int d = s->d, r = p->rank;
    size_t size = (size_t)d;
    double *Q = bake_alloc(size * size, sizeof *Q), *tau = bake_alloc(size, sizeof *tau);
    p->freedom = d - r;
    p->y0 = bake_alloc(size, sizeof *p->y0);
    p->N = bake_alloc(size * size, sizeof *p->N);
    for (int i = 0; i < r; i++)
        for (int l = 0; l < d; l++)
            Q[i * d + l] = C[i * d + l] / D[l];
    memcpy(p->y0, e, (size_t)r * sizeof *e);
    int info = LAPACKE_dgeqrf(LAPACK_COL_MAJOR, d, r, Q, d, tau);
    if (info == 0)
        info = LAPACKE_dtrtrs(LAPACK_COL_MAJOR, 'U', 'T', 'N', r, 1, Q, d, p->y0, d);
    if (info == 0)
        info = LAPACKE_dorgqr(LAPACK_COL_MAJOR, d, d, r, Q, d, tau);
    if (info == 0) {
        memcpy(tau, p->y0, size * sizeof *tau);
        cblas_dgemv(CblasColMajor, CblasNoTrans, d, r, 1.0, Q, d, tau, 1, 0.0, p->y0, 1);
        memcpy(p->N, Q + (size_t)r * size, (size_t)(d - r) * size * sizeof *Q);
    }
    free(Q);
    free(tau);
    return info;
}

static int add_hard_key(const partial_system *s, partial_key *p, const double *D, bake_error *error)
{
    double *C, *e, time = s->in->keys[p->key].time;
    int failed = independent_rows(s, p, &C, &e);
    if (!failed && p->rank > 0)
        failed = split_freedom(s, p, C, e, D);
    free(C);
    free(e);
    if (failed)
        return bake_fail(error, "the singular values of the partial key at %.6g s were not found",
                         time);
    return p->rank > 0
               ? 0
               : bake_fail(error, "the partial key at %.6g s asks for a part that cannot move",
                           time);
}

/* The energy's diagonal, with a floor where there is none: such a value is free or given by rows.
 * The floor is 1e-9 of the root of the energy that a unit of this mode's terms has: rounding is
 * 1e-16 of that. */
static void find_scale(const partial_system *s)
{
    size_t d = (size_t)s->d, n = (size_t)s->count + 1;
    int last = s->in->key_count - 1;
    double h = (s->in->keys[last].time - s->in->keys[0].time) / last;
    for (size_t k = 0; k + 1 < n; k++)
        for (size_t i = 0; i < d; i++) {
            const double *soft = s->key[k].soft;
            bake_mode mode = motion_mode(s->model, s->in->settings, (int)i);
            double sum = s->G[i * n * n + (k + 1) * (n + 1)] + (soft ? soft[i * (d + 1)] : 0.0);
            double terms = sqrt(h) * (1.0 / (h * h) + fabs(mode.delta) / h + fabs(mode.lambda));
            s->D[k * d + i] = fmax(sqrt(sum), 1e-9 * terms);
        }
}

static int find_freedom(partial_system *s, bake_error *error)
{
    for (int k = 0; k < s->count; k++)
        if (s->in->keys[s->key[k].key].weight[0] > 0.0)
            add_soft_key(s, &s->key[k]);
    find_scale(s);
    for (int k = 0; k < s->count; k++) {
        partial_key *p = &s->key[k];
        if (!p->soft && add_hard_key(s, p, s->D + (size_t)k * (size_t)s->d, error))
            return -1;
        p->first = s->size;
        s->size += p->freedom;
    }
    return 0;
}

/* ---- the quadratic program ------------------------------------------------------------------- */

/* out = (scaled energy block of keys k, l) x in, `columns` columns of d */
static void apply_block(const partial_system *s, const int pair[2], const double *x, int columns,
                        double *out)
{
    size_t d = (size_t)s->d, n = (size_t)s->count + 1, k = (size_t)pair[0], l = (size_t)pair[1];
    const double *Dk = s->D + k * d, *Dl = s->D + l * d, *soft = k == l ? s->key[k].soft : NULL;
    for (size_t c = 0; c < (size_t)columns; c++)
        for (size_t i = 0; i < d; i++) {
            double sum = s->G[i * n * n + (k + 1) * n + l + 1] / Dl[i] * x[c * d + i];
            for (size_t j = 0; soft && j < d; j++)
                sum += soft[i * d + j] / Dl[j] * x[c * d + j];
            out[c * d + i] = sum / Dk[i];
        }
}

/* right side of key k: minus the gradient at y_0, in z */
static void fill_right(const partial_system *s, int k, double *room)
{
    const partial_key *p = &s->key[k];
    size_t d = (size_t)s->d, n = (size_t)s->count + 1;
    double *minus = room + d;
    for (size_t i = 0; i < d; i++)
        minus[i] = ((p->target ? p->target[i] : 0.0) - s->G[i * n * n + ((size_t)k + 1) * n]) /
                   s->D[(size_t)k * d + i];
    for (int l = 0; l < s->count; l++) {
        const int pair[2] = {k, l};
        apply_block(s, pair, s->key[l].y0, 1, room);
        cblas_daxpy(s->d, -1.0, room, 1, minus, 1);
    }
    if (p->freedom > 0)
        cblas_dgemv(CblasColMajor, CblasTrans, s->d, p->freedom, 1.0, p->N, s->d, minus, 1, 0.0,
                    s->right + p->first, 1);
}

static void build(const partial_system *s)
{
    size_t d = (size_t)s->d;
    double *room = bake_alloc(d * (d + 2), sizeof *room);
    for (int k = 0; k < s->count; k++) {
        const partial_key *p = &s->key[k];
        fill_right(s, k, room);
        for (int l = 0; l <= k && p->freedom > 0; l++) {
            const partial_key *other = &s->key[l];
            const int pair[2] = {k, l};
            if (other->freedom == 0)
                continue;
            apply_block(s, pair, other->N, other->freedom, room);
            cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, p->freedom, other->freedom, s->d,
                        1.0, p->N, s->d, room, s->d, 0.0,
                        s->A + p->first + (size_t)other->first * (size_t)s->size, s->size);
        }
    }
    free(room);
}

static int solve(const partial_system *s, double *z, bake_error *error)
{
    lapack_int n = s->size;
    size_t size = (size_t)n;
    double *memory = bake_alloc(2 * size * size + 2 * size, sizeof *memory);
    double *factor = memory, *copy = memory + size * size, *scale = copy + size * size;
    double *left = scale + size, condition = 0.0, forward = 0.0, backward = 0.0;
    char scaled = 'N';
    memcpy(copy, s->A, size * size * sizeof *copy);
    memcpy(left, s->right, size * sizeof *left);
    lapack_int info = LAPACKE_dposvx(LAPACK_COL_MAJOR, 'N', 'L', n, 1, s->A, n, factor, n, &scaled,
                                     scale, s->right, n, z, n, &condition, &forward, &backward);
    double size_of = cblas_dnrm2(n, left, 1);
    cblas_dsymv(CblasColMajor, CblasLower, n, -1.0, copy, n, z, 1, 1.0, left, 1);
    double residual = cblas_dnrm2(n, left, 1);
    double norm = LAPACKE_dlansy(LAPACK_COL_MAJOR, '1', 'L', n, copy, n);
    size_of += cblas_dnrm2(n, z, 1);
    condition *= fmin(1.0, norm); /* a diagonal below 1 is rounding */
    free(memory);
    if (info != 0 || !(condition >= CONDITION_LIMIT))
        return bake_fail(error,
                         "the partial keys leave the motion undetermined (condition %.1e): many "
                         "motions need no force at all; add a key, give velocities at the ends, "
                         "or regularise",
                         condition);
    if (!(residual <= RESIDUAL_LIMIT * size_of))
        return bake_fail(error, "the solve for the partial keys left a residual of %.3g",
                         residual / size_of);
    return 0;
}

/* x = D^-1 (y_0 + N z) */
static void take(const partial_system *s, const double *z, double *values)
{
    size_t d = (size_t)s->d;
    for (int k = 0; k < s->count; k++) {
        const partial_key *p = &s->key[k];
        double *x = values + (size_t)p->key * d;
        memcpy(x, p->y0, d * sizeof *x);
        if (p->freedom > 0)
            cblas_dgemv(CblasColMajor, CblasNoTrans, s->d, p->freedom, 1.0, p->N, s->d,
                        z + p->first, 1, 1.0, x, 1);
        for (size_t i = 0; i < d; i++)
            x[i] /= s->D[(size_t)k * d + i];
        if (p->key == 0 && is_loop(s->in))
            memcpy(values + (size_t)(s->in->key_count - 1) * d, x, d * sizeof *x);
    }
}

static void release(partial_system *s)
{
    for (int k = 0; k < s->count; k++) {
        free(s->key[k].y0);
        free(s->key[k].N);
        free(s->key[k].target);
        free(s->key[k].soft);
    }
    free(s->key);
    free(s->G);
    free(s->D);
    free(s->A);
    free(s->right);
}

int motion_partial_values(const motion_input *in, const linear_model *model, double **values,
                          bake_error *error)
{
    partial_system s = {.in = in, .model = model, .d = model->d, .count = list_keys(in, NULL)};
    size_t d = (size_t)s.d, count = (size_t)s.count;
    double *z = NULL;
    *values = NULL;
    if (s.count == 0)
        return 0;
    s.key = bake_alloc(count, sizeof *s.key);
    list_keys(in, s.key);
    s.G = bake_alloc(d * (count + 1) * (count + 1), sizeof *s.G);
    s.D = bake_alloc(count * d, sizeof *s.D);
    int failed = find_energies(&s, error) || find_freedom(&s, error);
    if (!failed && s.size > 0) {
        s.A = bake_alloc((size_t)s.size * (size_t)s.size, sizeof *s.A);
        s.right = bake_alloc((size_t)s.size, sizeof *s.right);
        z = bake_alloc((size_t)s.size, sizeof *z);
        build(&s);
        failed = solve(&s, z, error);
    }
    if (!failed) {
        *values = bake_alloc((size_t)in->key_count * d, sizeof **values);
        take(&s, z, *values);
    }
    free(z);
    release(&s);
    return failed ? -1 : 0;
}
