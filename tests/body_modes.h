/* Modes of a body that is held in some way, expanded to all coordinates.
 * SPDX-License-Identifier: MIT */
#ifndef BODY_MODES_H
#define BODY_MODES_H

#include "body_shapes.h"
#include "modes_check.h"

static inline void all_free(const body *b, freedom *f)
{
    freedom_make(b->vertex_count, f);
}

/* Modes of a body, which is prepared here, as `hold` holds it. phi is expanded: 3 vertex_count rows. */
static inline void modes_of(body *b, void (*hold)(const body *, freedom *), int count, modes *out)
{
    bake_error error = {""};
    body_blocks blocks = {0};
    freedom f;
    sparse K;
    CHECK_EQ(body_prepare(b, &error), 0);
    hold(b, &f);
    freedom_finish(&f);
    body_hessian(b, b->rest, &blocks);
    CHECK_EQ(sparse_from_blocks(&blocks, &f, &K, &error), 0);
    double *M = bake_alloc((size_t)f.count, sizeof *M);
    for (int i = 0; i < b->vertex_count; i++)
        for (int j = f.first[i]; j < f.first[i + 1]; j++)
            M[j] = b->mass[i];
    CHECK_EQ(modes_solve(&K, M, count, out, &error), 0);
    if (error.text[0])
        printf("%s\n", error.text);
    check_modes(out, M);
    int n = 3 * b->vertex_count;
    double *phi = bake_alloc((size_t)n * (size_t)count, sizeof *phi);
    for (int j = 0; j < count; j++)
        freedom_expand(&f, out->phi + (size_t)j * (size_t)out->n, phi + (size_t)j * (size_t)n);
    free(out->phi);
    out->phi = phi;
    out->n = n;
    free(M);
    sparse_free(&K);
    body_blocks_free(&blocks);
    freedom_free(&f);
}

static inline void hold_left(const body *b, freedom *f)
{
    freedom_make(b->vertex_count, f);
    for (int i = 0; i < b->vertex_count; i++)
        if (b->rest[3 * i] == 0)
            freedom_fix(f, i);
}

#endif
