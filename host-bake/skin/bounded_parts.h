/* What the files of the weights' solver share. Free vertices are those that no handle holds, in the
 * order in which their matrix is factorised.
 *
 *   Q  n x n   of the free vertices, all entries    B  n x m   Q_free,held times the held values
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BOUNDED_PARTS_H
#define BAKE_BOUNDED_PARTS_H

#include "bounded.h"

#include <suitesparse/cholmod.h>

/* Work space of one thread. */
typedef struct {
    cholmod_common common;
    cholmod_dense *X, *Y, *E;
} bounded_desk;

void bounded_desk_make(bounded_desk *desk);
void bounded_desk_free(bounded_desk *desk);

/* Each thread has a factor of its own in work: 0.5 GB of 70,000 vertices. */
#define BOUNDED_THREADS 8

typedef struct {
    int n, m; /* free vertices, handles */
    int *column, *row;
    double *value;
    double *d;      /* n: the diagonal of Q */
    double *b;      /* B, column by column */
    double *metric; /* n: R, the steps' metric; NULL until it is made */
    int *vertex;    /* n: of the caller */
    int threads;
    bounded_desk desk[BOUNDED_THREADS];
} bounded_system;

/* error: also when a vertex has no handle that it could take a weight from. */
int bounded_system_make(const sparse *q, const held *hold, bounded_system *out, bake_error *error);
void bounded_system_free(bounded_system *s);

/* g = Q w + b of one handle */
void bounded_gradient(const bounded_system *s, const double *b, const double *w, double *g);

/* ---- factors ---------------------------------------------------------------------------------- */

/* The Cholesky factor of the rows and columns of Q that are `free`, in their order. */
typedef struct {
    int n;
    cholmod_factor *L;
    int columns; /* right-hand sides whose solution takes half as long as the factor did */
} bounded_factor;

/* member: 1 where a row is in, NULL = all. add: for the diagonal, or NULL. Returns 1 where it is not
 * positive definite, -1 without memory. */
int bounded_factor_make(bounded_desk *desk, const bounded_system *s, const char *member,
                        const double *add, bounded_factor *out);
void bounded_factor_free(bounded_desk *desk, bounded_factor *f);
int bounded_factor_solve(bounded_desk *desk, const bounded_factor *f, double *x, int count);

/* R = 0.3 / diag(Q^-1), from random vectors with L^T x = z: E x_i^2 is that diagonal. */
int bounded_metric(bounded_desk *desk, bounded_system *s, const bounded_factor *of_q);

/* The message of a factor that was not made (what it returned). */
int bounded_no_factor(const bounded_system *s, int result, bake_error *error);

/* ---- threads ---------------------------------------------------------------------------------- */

typedef struct {
    void (*run)(void *context, int item, bounded_desk *desk);
    void *context;
} bounded_work;

/* Every item once, by as many threads as there are processors for this process, each at its desk.
 * Whatever an item does must not depend on the others. */
void bounded_each(bounded_system *s, int items, const bounded_work *work);
int bounded_threads(void);

/* ---- first order ------------------------------------------------------------------------------ */

/* Weights near the exact ones; w: n x m. coupled: rows of w sum to 1, and they are exact. */
int bounded_approach(bounded_system *s, int coupled, double *w, bake_error *error);

/* ---- active sets ------------------------------------------------------------------------------ */

enum { BOUNDED_FREE_VERTEX, BOUNDED_LOW, BOUNDED_HIGH };

/* A factor of the free set that it was made of, and the changes of the set since. */
typedef struct {
    const bounded_system *s;
    bounded_factor factor;
    int *list, *place;     /* factor.n: its rows; n: where a row is in it, -1 = not */
    int *slot;             /* n: its column in V, -1 = none */
    int *changed;          /* rows that V has columns of */
    int count, room, made; /* made: factors so far */
    double *V;             /* factor.n x count: its inverse times what the changes add to it */
} bounded_border;

int bounded_border_set(bounded_desk *desk, bounded_border *f, const char *state);
int bounded_border_solve(bounded_desk *desk, bounded_border *f, const char *state, double *x);
void bounded_border_free(bounded_desk *desk, bounded_border *f);

/* Exact weights of one handle from near ones. 0, 1 = not found, -1 = no memory. */
int bounded_polish(bounded_desk *desk, const bounded_system *s, const double *b, double *w,
                   int *factors);

/* ---- optimality ------------------------------------------------------------------------------- */

/* Residuals and counts of all handles, which are 0 before. */
void bounded_judge(const bounded_system *s, bounded_kind kind, const double *w, bounded_report *r);

#endif
