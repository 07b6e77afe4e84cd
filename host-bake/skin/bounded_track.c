/* Extrapolated fixed point iterations: the mix of past steps whose residual is least.
 * Source: Anderson 1965; Walker and Ni 2011. The way back is own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_track.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RELAXATION 1.6

void bounded_track_make(track *t, size_t n)
{
    t->S = bake_alloc(n * HISTORY, sizeof *t->S);
    t->C = bake_alloc(n * HISTORY, sizeof *t->C);
    t->plain = bake_alloc(n, sizeof *t->plain);
    t->residual = bake_alloc(n, sizeof *t->residual);
    t->best = bake_alloc(n, sizeof *t->best);
}

void bounded_track_free(track *t)
{
    free(t->S);
    free(t->C);
    free(t->plain);
    free(t->residual);
    free(t->best);
}

void history_make(history *h)
{
    memset(h, 0, sizeof *h);
    h->fresh = 1;
    h->best = HUGE_VAL;
}

void bounded_track_measure(track *t, const double *root, int n)
{
    t->norm = t->far = 0;
    for (int i = 0; i < n; i++) {
        double f = t->x[i] - t->w[i], scaled = root[i] * f;
        t->norm += scaled * scaled;
        t->far = fmax(t->far, fabs(f));
    }
}

static int kept(const history *h)
{
    return h->count < HISTORY ? h->count : HISTORY;
}

/* A residual that has doubled was mixed badly. */
void history_begin(history *h, const track *tracks, int columns)
{
    double norm = 0;
    for (int j = 0; j < columns; j++) {
        norm += tracks[j].norm;
    }
    if (norm > 4 * h->best && h->count > 0) {
        history_make(h);
        h->back = 1;
        return;
    }
    h->back = 0;
    h->better = norm < h->best;
    h->best = fmin(h->best, norm);
    if (!h->fresh) {
        h->newest = h->count++ % HISTORY;
    }
}

void bounded_track_push(track *t, const double *root, int n, const history *h)
{
    double *S = t->S + (size_t)h->newest * (size_t)n, *C = t->C + (size_t)h->newest * (size_t)n;
    if (h->back) {
        memcpy(t->y, t->best, (size_t)n * sizeof *t->y);
        return;
    }
    for (int i = 0; i < n; i++) {
        double f = t->x[i] - t->w[i], step = t->y[i] + RELAXATION * f;
        if (!h->fresh) {
            S[i] = step - t->plain[i];
            C[i] = root[i] * f - t->residual[i];
        }
        t->plain[i] = t->y[i] = step;
        t->residual[i] = root[i] * f;
    }
    for (int k = 0; k < kept(h); k++) {
        const double *other = t->C + (size_t)k * (size_t)n;
        t->row[k] = cblas_ddot(n, C, 1, other, 1);
        t->dot[k] = cblas_ddot(n, t->residual, 1, other, 1);
    }
    if (h->better) {
        memcpy(t->best, t->plain, (size_t)n * sizeof *t->best);
    }
}

void history_mix(history *h, const track *tracks, int columns)
{
    double gram[HISTORY * HISTORY];
    int count = kept(h);
    h->mixed = 0;
    if (h->back) {
        return;
    }
    h->fresh = 0;
    for (int k = 0; k < count; k++) {
        double sum = 0;
        h->mix[k] = 0;
        for (int j = 0; j < columns; j++) {
            sum += tracks[j].row[k];
            h->mix[k] += tracks[j].dot[k];
        }
        h->gram[k][h->newest] = h->gram[h->newest][k] = sum;
    }
    for (int k = 0; k < count; k++) {
        for (int l = 0; l < count;
             l++) { /* 1e-10: nearly dependent columns are no reason to fail */
            gram[k * count + l] = h->gram[k][l] * (k == l ? 1 + 1e-10 : 1);
        }
    }
    if (count == 0 ||
        LAPACKE_dposv(LAPACK_COL_MAJOR, 'L', count, 1, gram, count, h->mix, count) != 0) {
        h->count = 0;
        return;
    }
    h->mixed = count;
}

void bounded_track_add(track *t, int n, const history *h)
{
    for (int k = 0; k < h->mixed; k++) {
        cblas_daxpy(n, -h->mix[k], t->S + (size_t)k * (size_t)n, 1, t->y, 1);
    }
}
