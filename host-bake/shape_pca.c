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

/* B and S of the chosen columns. The divide-and-conquer driver, economical: rank columns of B. */
static int decompose(double *chosen, int columns, shape_pca *out, bake_error *error)
{
    double *Vt = bake_alloc((size_t)out->rank * (size_t)columns, sizeof *Vt);
    out->B = bake_alloc((size_t)out->rows * (size_t)out->rank, sizeof *out->B);
    out->S = bake_alloc((size_t)out->rank, sizeof *out->S);
    int info = LAPACKE_dgesdd(LAPACK_COL_MAJOR, 'S', out->rows, columns, chosen, out->rows, out->S,
                              out->B, out->rows, Vt, out->rank);
    free(Vt);
    return info == 0 ? 0
                     : bake_fail(error,
                                 "the singular value decomposition of %d x %d numbers "
                                 "failed with %d: are they all finite?",
                                 out->rows, columns, info);
}

int shape_pca_make(const double *F, int rows, int columns, int every, shape_pca *out,
                   bake_error *error)
{
    int kept = (columns + every - 1) / every;
    size_t column = (size_t)rows * sizeof *F;
    double *chosen = bake_alloc((size_t)kept * (size_t)rows, sizeof *chosen);
    memset(out, 0, sizeof *out);
    out->rows = rows;
    out->columns = columns;
    out->rank = rows < kept ? rows : kept;
    for (int i = 0; i < kept; i++) {
        memcpy(chosen + (size_t)i * (size_t)rows, F + (size_t)i * (size_t)every * (size_t)rows,
               column);
    }
    int err = decompose(chosen, kept, out, error);
    free(chosen);
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
