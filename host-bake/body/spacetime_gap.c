/* One gap of a coupled motion: its energy, its conditions, and the elimination of its switch.
 * Source: Schulz 2013, 2.8.2, (2.40); errata S8, S9. Letters: spacetime_gap.h.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spacetime_gap.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- pieces ---------------------------------------------------------------------------------- */

/* The curve that is 1 in one of (w0, v0, w1, v1), or in none of them but has the force (column 4).
 */
static bake_segment unit_curve(const gap_piece *p, int column)
{
    bake_part part = p->part;
    bake_segment unit = p->segment;
    double u[5] = {0.0};
    u[column] = 1.0;
    if (column < 4)
        part.part[0] = part.part[1] = unit.rest = unit.drive = 0.0;
    const double w[2] = {u[0], u[2]}, v[2] = {u[1], u[3]};
    bake_part_coefficients(&part, w, v, &unit);
    return unit;
}

/* Both curves solve (2.22), so that f_a'' - 2 delta f_a' + lambda f_a = 0 and the integral of f_a
 * f_b is what f_a b' - f_a' b + 2 delta f_a b gains; b is 1 in one value or velocity at one end. */
static void closed_form(gap_piece *p, const bake_mode *mode)
{
    double Q[5][4], delta = mode->delta, lambda = mode->lambda;
    for (int a = 0; a < 5; a++) {
        bake_segment unit = unit_curve(p, a);
        for (int end = 0; end < 2; end++) {
            double w[4], sign = end ? 1.0 : -1.0;
            bake_segment_eval(&unit, end ? unit.t1 : unit.t0, w);
            double f = w[2] + 2.0 * delta * w[1] + lambda * w[0] + (a == 4 ? mode->g : 0.0);
            double slope = w[3] + 2.0 * delta * w[2] + lambda * w[1];
            Q[a][2 * end] = sign * (2.0 * delta * f - slope);
            Q[a][2 * end + 1] = sign * f;
        }
    }
    for (int a = 0; a < 4; a++) {
        p->Q[5 * a + 4] = p->Q[20 + a] = Q[4][a];
        for (int b = 0; b < 4; b++)
            p->Q[5 * a + b] = 0.5 * (Q[a][b] + Q[b][a]);
    }
}

static void regularised_form(gap_piece *p, const bake_mode *mode, const double *regularise)
{
    double w[25] = {0.0};
    for (int a = 0; a < 5; a++) {
        bake_segment unit = unit_curve(p, a);
        memcpy(w + 5 * a, unit.w, sizeof unit.w);
    }
    w[24] = 1.0;
    const motion_gram gram = {&p->segment, mode, regularise, 5, w, p->Q};
    motion_gram_add(&gram);
}

/* like: the same mode on another interval, or NULL; equal intervals share everything. */
static void prepare_piece(const gap *g, int side, int mode, const gap_piece *like)
{
    gap_piece *p = &g->piece[side][mode];
    const bake_mode *m = &g->mode[side][mode];
    double middle = 0.5 * (g->time[0] + g->time[1]); /* erratum S8 */
    double t0 = side ? middle : g->time[0], t1 = side ? g->time[1] : middle;
    bake_segment_prepare(&p->segment, m, t0, t1);
    if (like && t1 - t0 == like->segment.t1 - like->segment.t0) {
        p->part = like->part;
        memcpy(p->Q, like->Q, sizeof p->Q);
        return;
    }
    bake_part_prepare(&p->part, &p->segment);
    if (g->regularise[0] > 0.0 || g->regularise[1] > 0.0 || g->regularise[2] > 0.0)
        regularised_form(p, m, g->regularise);
    else
        closed_form(p, m);
}

void gap_prepare(gap *g, const gap *before)
{
    size_t d = (size_t)g->d;
    const double *Phi = g->model[0]->Phi, *next = g->model[1]->Phi;
    g->R = bake_alloc(d * d, sizeof *g->R);
    g->Z = bake_alloc(3 * d * (4 * d + 1), sizeof *g->Z);
    for (int side = 0; side < 2; side++) {
        g->piece[side] = bake_alloc(d, sizeof *g->piece[side]);
        for (int i = 0; i < g->d; i++)
            prepare_piece(g, side, i, side == 0 && before ? &before->piece[1][i] : NULL);
    }
    /* exactly 1 for one model, which then stays decoupled */
    for (size_t i = 0; i < d; i++)
        g->R[i * (d + 1)] = 1.0;
    if (Phi != next)
        cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, g->d, g->d, g->d, 1.0, Phi, g->d, next,
                    g->d, 0.0, g->R, g->d);
}

void gap_free(gap *g)
{
    for (int side = 0; side < 2; side++)
        free(g->piece[side]);
    free(g->R);
    free(g->Z);
    *g = (gap){0};
}

/* ---- equations ------------------------------------------------------------------------------- */

/* side: whose model's coordinates the quantities added have. */
typedef struct {
    const gap *g;
    int side, n;
    double *M, *r, *room; /* n x n, n, 2 d x d */
} equations;

/* Slots: offsets of unknowns. Those of the switch are in coordinates of side 0, so that a quantity
 * of side 1 meets them through R. */
static int turned(const equations *e, int slot)
{
    return e->side == 1 && slot < 3 * e->g->d;
}

static void add_at(const equations *e, int row, int column, double value)
{
    e->M[(size_t)column * (size_t)e->n + (size_t)row] += value;
    if (row != column)
        e->M[(size_t)row * (size_t)e->n + (size_t)column] += value;
}

/* The block of slots (a, b), a != b, with its mirror image, or (a, a): `diagonal` in the side's own
 * coordinates. */
static void add_block(const equations *e, int a, int b, const double *diagonal)
{
    int d = e->g->d;
    double *B = e->room, *BR = B + (size_t)d * (size_t)d;
    const double *R = e->g->R;
    if (turned(e, b) && !turned(e, a)) { /* the mirror image is the same block of (b, a) */
        add_block(e, b, a, diagonal);
        return;
    }
    if (!turned(e, a)) {
        for (int i = 0; i < d; i++)
            add_at(e, a + i, b + i, diagonal[i]);
        return;
    }
    for (int j = 0; j < d; j++)
        for (int i = 0; i < d; i++)
            B[j * d + i] = R[j * d + i] * diagonal[j];
    if (turned(e, b))
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, d, d, d, 1.0, B, d, R, d, 0.0, BR, d);
    for (int j = 0; j < d; j++)
        for (int i = a == b ? j : 0; i < d; i++)
            add_at(e, a + i, b + j, (turned(e, b) ? BR : B)[j * d + i]);
}

static void add_right(const equations *e, int slot, const double *x)
{
    int d = e->g->d;
    if (turned(e, slot))
        cblas_dgemv(CblasColMajor, CblasNoTrans, d, d, 1.0, e->g->R, d, x, 1, 1.0, e->r + slot, 1);
    else
        cblas_daxpy(d, 1.0, x, 1, e->r + slot, 1);
}

/* Slots of (w0, v0, w1, v1) of a side's pieces; -1: the pose at the key, which is known. */
static int find_slots(const equations *e, int slot[4])
{
    int d = e->g->d;
    const int of[2][4] = {{-1, 3 * d, 0, d}, {0, d, -1, 5 * d}};
    memcpy(slot, of[e->side], sizeof of[0]);
    return e->side ? 2 : 0;
}

static void add_energy(const equations *e)
{
    const gap_piece *piece = e->g->piece[e->side];
    const double *pose = e->g->pose[e->side];
    double *x = bake_alloc((size_t)e->g->d, sizeof *x);
    int slot[4], known = find_slots(e, slot);
    for (int a = 0; a < 4; a++) {
        if (a == known)
            continue;
        for (int b = 0; b <= a; b++) {
            if (b == known)
                continue;
            for (int i = 0; i < e->g->d; i++)
                x[i] = piece[i].Q[5 * a + b];
            add_block(e, slot[a], slot[b], x);
        }
        for (int i = 0; i < e->g->d; i++)
            x[i] = -piece[i].Q[5 * a + known] * pose[i] - piece[i].Q[5 * a + 4];
        add_right(e, slot[a], x);
    }
    free(x);
}

/* sign times the acceleration at one end of the side's pieces, in the row of the multipliers k. */
static void add_acceleration(const equations *e, int end, double sign, int k)
{
    const double *pose = e->g->pose[e->side];
    double *x = bake_alloc((size_t)e->g->d, sizeof *x);
    int slot[4], known = find_slots(e, slot);
    for (int a = 0; a < 4; a++) {
        for (int i = 0; i < e->g->d; i++) {
            const bake_part *part = &e->g->piece[e->side][i].part;
            x[i] = sign * (end ? part->right : part->left)[a];
            if (a == known)
                x[i] = -x[i] * pose[i] - sign * part->shift;
        }
        if (a == known)
            add_right(e, k, x);
        else
            add_block(e, k, slot[a], x);
    }
    free(x);
}

/* C2 at a key has one half in this gap and the other, with the other sign, in its neighbour. */
static void build(equations *e)
{
    int d = e->g->d;
    for (e->side = 0; e->side < 2; e->side++) {
        add_energy(e);
        add_acceleration(e, !e->side, e->side ? -1.0 : 1.0, 2 * d);
        if (e->g->joins[e->side])
            add_acceleration(e, e->side, e->side ? 1.0 : -1.0, (e->side ? 6 : 4) * d);
    }
}

/* ---- elimination ----------------------------------------------------------------------------- */

typedef struct {
    lapack_int n, columns;
    double *A, *factor, *rows, *scale; /* A: scaled; scale: of its columns */
    lapack_int *pivot;
} dense;

/* Rows and columns of norm about 1 (powers of two), so that units do not matter. */
static int factorise(const dense *s, double *condition)
{
    double spread[3] = {0.0};
    size_t n = (size_t)s->n;
    *condition = 0.0;
    if (LAPACKE_dgeequb(LAPACK_COL_MAJOR, s->n, s->n, s->A, s->n, s->rows, s->scale, &spread[0],
                        &spread[1], &spread[2]) != 0)
        return -1;
    for (size_t j = 0; j < n; j++)
        for (size_t i = 0; i < n; i++)
            s->A[j * n + i] *= s->rows[i] * s->scale[j];
    memcpy(s->factor, s->A, n * n * sizeof *s->A);
    double norm = LAPACKE_dlange(LAPACK_COL_MAJOR, '1', s->n, s->n, s->A, s->n);
    if (LAPACKE_dgetrf(LAPACK_COL_MAJOR, s->n, s->n, s->factor, s->n, s->pivot) != 0)
        return -1;
    return LAPACKE_dgecon(LAPACK_COL_MAJOR, '1', s->n, s->factor, s->n, norm, condition) != 0;
}

/* Not the expert driver: it refines column by column, this all of them in one product. */
static void solve_refined(const dense *s, double *B, double *Z)
{
    size_t n = (size_t)s->n, size = n * (size_t)s->columns;
    for (size_t i = 0; i < size; i++)
        B[i] *= s->rows[i % n];
    memcpy(Z, B, size * sizeof *Z);
    LAPACKE_dgetrs(LAPACK_COL_MAJOR, 'N', s->n, s->columns, s->factor, s->n, s->pivot, Z, s->n);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, s->n, s->columns, s->n, -1.0, s->A, s->n,
                Z, s->n, 1.0, B, s->n);
    LAPACKE_dgetrs(LAPACK_COL_MAJOR, 'N', s->n, s->columns, s->factor, s->n, s->pivot, B, s->n);
    for (size_t i = 0; i < size; i++)
        Z[i] = (Z[i] + B[i]) * s->scale[i % n];
}

/* Z = M_xx^-1 (M_xy, r_x) */
static int find_Z(const equations *e, double *Z, double *condition)
{
    size_t n = 3 * (size_t)e->g->d, columns = 4 * (size_t)e->g->d + 1, all = (size_t)e->n;
    double *A = bake_alloc(2 * n * n + 2 * n + n * columns, sizeof *A);
    dense s = {.n = (lapack_int)n, .columns = (lapack_int)columns, .A = A, .factor = A + n * n};
    s.rows = s.factor + n * n;
    s.scale = s.rows + n;
    s.pivot = bake_alloc(n, sizeof *s.pivot);
    double *B = s.scale + n;
    for (size_t j = 0; j < n; j++)
        memcpy(A + j * n, e->M + j * all, n * sizeof *A);
    for (size_t j = 0; j < columns - 1; j++)
        memcpy(B + j * n, e->M + (n + j) * all, n * sizeof *B);
    memcpy(B + (columns - 1) * n, e->r, n * sizeof *B);
    int failed = factorise(&s, condition);
    if (!failed)
        solve_refined(&s, B, Z);
    free(A);
    free(s.pivot);
    return failed ? -1 : 0;
}

int gap_eliminate(gap *g, double *rest, double *condition)
{
    size_t d = (size_t)g->d, n = 7 * d, m = 4 * d;
    double *memory = bake_alloc(n * n + n + 2 * d * d, sizeof *memory);
    equations e = {.g = g, .n = (int)n, .M = memory, .r = memory + n * n};
    e.room = e.r + n;
    build(&e);
    int failed = find_Z(&e, g->Z, condition);
    for (size_t j = 0; j < m; j++)
        memcpy(rest + j * m, e.M + (3 * d + j) * n + 3 * d, m * sizeof *rest);
    memcpy(rest + m * m, e.r + 3 * d, m * sizeof *rest);
    if (!failed)
        cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)m, (int)m + 1, 3 * g->d, -1.0,
                    e.M + 3 * d, (int)n, g->Z, 3 * g->d, 1.0, rest, (int)m);
    free(memory);
    return failed;
}

void gap_finish(gap *g, const double *y)
{
    size_t d = (size_t)g->d;
    int rows = 3 * g->d;
    double *x = bake_alloc(5 * d, sizeof *x), *after = x + 3 * d;
    memcpy(x, g->Z + 4 * d * 3 * d, 3 * d * sizeof *x);
    cblas_dgemv(CblasColMajor, CblasNoTrans, rows, 4 * g->d, -1.0, g->Z, rows, y, 1, 1.0, x, 1);
    for (size_t i = 0; i < 2; i++)
        cblas_dgemv(CblasColMajor, CblasTrans, g->d, g->d, 1.0, g->R, g->d, x + i * d, 1, 0.0,
                    after + i * d, 1);
    for (size_t i = 0; i < d; i++) {
        const double w[2][2] = {{g->pose[0][i], x[i]}, {after[i], g->pose[1][i]}};
        const double v[2][2] = {{y[i], x[d + i]}, {after[d + i], y[2 * d + i]}};
        for (int side = 0; side < 2; side++)
            bake_part_coefficients(&g->piece[side][i].part, w[side], v[side],
                                   &g->piece[side][i].segment);
    }
    free(x);
}
