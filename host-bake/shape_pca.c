/* Principal components of frames.
 * Source: Alexa 2002, 7.2.1 (7.6)-(7.7); erratum: it is the key frames that (7.6) stacks, and the
 * columns of B, not its rows, that are the bases.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Every `every`-th column of F. */
static void choose(const double *F, int every, int kept, const shape_pca *out, double *chosen)
{
    size_t rows = (size_t)out->rows;
    for (size_t i = 0; i < (size_t)kept; i++) {
        memcpy(chosen + i * rows, F + i * (size_t)every * rows, rows * sizeof *F);
    }
}

/* B and S of the chosen columns. The divide-and-conquer driver, economical: rank columns of B. It
 * may not converge where many singular values are rounding; the slower one by QR does. */
static int decompose(const double *F, int every, int kept, shape_pca *out, bake_error *error)
{
    size_t rows = (size_t)out->rows, rank = (size_t)out->rank;
    double *chosen = bake_alloc(rows * (size_t)kept, sizeof *chosen);
    double *Vt = bake_alloc(rank * (size_t)kept, sizeof *Vt);
    double *super = bake_alloc(rank, sizeof *super);
    out->B = bake_alloc(rows * rank, sizeof *out->B);
    out->S = bake_alloc(rank, sizeof *out->S);
    choose(F, every, kept, out, chosen);
    int info = LAPACKE_dgesdd(LAPACK_COL_MAJOR, 'S', out->rows, kept, chosen, out->rows, out->S,
                              out->B, out->rows, Vt, out->rank);
    if (info > 0) {
        choose(F, every, kept, out, chosen);
        info = LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'S', 'S', out->rows, kept, chosen, out->rows,
                              out->S, out->B, out->rows, Vt, out->rank, super);
    }
    free(chosen);
    free(Vt);
    free(super);
    return info == 0 ? 0
                     : bake_fail(error,
                                 "the singular value decomposition of %d x %d numbers "
                                 "failed with %d: are they all finite?",
                                 out->rows, kept, info);
}

int shape_pca_make(const double *F, int rows, int columns, int every, shape_pca *out,
                   bake_error *error)
{
    int kept = (columns + every - 1) / every;
    memset(out, 0, sizeof *out);
    out->rows = rows;
    out->columns = columns;
    out->rank = rows < kept ? rows : kept;
    int err = decompose(F, every, kept, out, error);
    if (err < 0) {
        shape_pca_free(out);
        return -1;
    }
    out->W = bake_alloc((size_t)out->rank * (size_t)columns, sizeof *out->W);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, out->rank, columns, rows, 1, out->B, rows,
                F, rows, 0, out->W, out->rank);
    return 0;
}

void shape_pca_free(shape_pca *p)
{
    free(p->B);
    free(p->S);
    free(p->W);
    memset(p, 0, sizeof *p);
}
