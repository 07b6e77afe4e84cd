/* Bounded weights of one handle by IPOPT, an interior point solver of others, for comparison.
 * Its tolerances are those of the objective times SCALE over the mean of diag(Q): a weight that is off by
 * 1e-5 in a flat direction changes the objective by little.
 * SPDX-License-Identifier: MIT */
#ifndef IPOPT_ORACLE_H
#define IPOPT_ORACLE_H

#include "bounded.h"

#include <coin/IpStdCInterface.h>

#include <stdlib.h>

#define IPOPT_SCALE 1e4

static inline Bool ipopt_value(Index n, Number *x, Bool is_new, Number *out, UserDataPtr data)
{
    const sparse *q = data;
    double *y = bake_alloc((size_t)n, sizeof *y), sum = 0;
    (void)is_new;
    sparse_multiply(q, x, y);
    for (int i = 0; i < n; i++) {
        sum += x[i] * y[i] / 2;
    }
    *out = sum;
    free(y);
    return TRUE;
}

static inline Bool ipopt_slope(Index n, Number *x, Bool is_new, Number *out, UserDataPtr data)
{
    (void)n;
    (void)is_new;
    sparse_multiply(data, x, out);
    return TRUE;
}

static inline Bool ipopt_no_rows(Index n, Number *x, Bool is_new, Index m, Number *g,
                                 UserDataPtr data)
{
    (void)n, (void)x, (void)is_new, (void)m, (void)g, (void)data;
    return TRUE;
}

static inline Bool ipopt_no_slopes(Index n, Number *x, Bool is_new, Index m, Index nele,
                                   Index *at_row, Index *column, Number *values, UserDataPtr data)
{
    (void)n, (void)x, (void)is_new, (void)m, (void)nele, (void)at_row, (void)column, (void)values;
    (void)data;
    return TRUE;
}

static inline Bool ipopt_curvature(Index n, Number *x, Bool is_new, Number factor, Index m,
                                   Number *lambda, Bool is_lambda, Index nele, Index *at_row,
                                   Index *column, Number *values, UserDataPtr data)
{
    const sparse *q = data;
    (void)x, (void)is_new, (void)m, (void)lambda, (void)is_lambda, (void)nele;
    for (int j = 0; j < n; j++) {
        for (int p = q->column[j]; p < q->column[j + 1]; p++) {
            if (values) {
                values[p] = factor * q->value[p];
            } else {
                at_row[p] = q->row[p];
                column[p] = j;
            }
        }
    }
    return TRUE;
}

/* One handle: 0, or IPOPT's status. */
static inline int ipopt_weights(const sparse *q, const held *h, int which, double *x)
{
    double *low = bake_alloc(2 * (size_t)q->n, sizeof *low), *high = low + q->n, energy,
           diagonal = 0;
    for (int i = 0; i < q->n; i++) {
        high[i] = 1;
        x[i] = 0.5;
        diagonal += q->value[q->column[i]];
    }
    for (int i = 0; i < h->count; i++) {
        int v = h->vertex[i];
        x[v] = low[v] = high[v] = h->value[i * h->handle_count + which];
    }
    IpoptProblem p =
        CreateIpoptProblem(q->n, low, high, 0, NULL, NULL, 0, q->column[q->n], 0, ipopt_value,
                           ipopt_no_rows, ipopt_slope, ipopt_no_slopes, ipopt_curvature);
    AddIpoptIntOption(p, "print_level", 0);
    AddIpoptStrOption(p, "sb", "yes");
    AddIpoptStrOption(p, "hessian_constant", "yes");
    AddIpoptNumOption(p, "bound_relax_factor", 0);
    AddIpoptNumOption(p, "tol", 1e-10);
    AddIpoptStrOption(p, "nlp_scaling_method", "none");
    AddIpoptNumOption(p, "obj_scaling_factor", IPOPT_SCALE * q->n / diagonal);
    int status = (int)IpoptSolve(p, x, NULL, &energy, NULL, NULL, NULL, (void *)(size_t)q);
    FreeIpoptProblem(p);
    free(low);
    return status;
}

#endif
