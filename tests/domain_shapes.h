/* Regular domains for tests of weights and of what they are made from, and random numbers.
 * SPDX-License-Identifier: MIT */
#ifndef DOMAIN_SHAPES_H
#define DOMAIN_SHAPES_H

#include "body_shapes.h"
#include "domain.h"

#include <string.h>

static inline double shape_random(unsigned *state, double low, double high)
{
    *state = *state * 1664525u + 1013904223u;
    return low + (high - low) * (*state >> 8) / 16777216.0;
}

static inline domain shape_from_body(body *b, int dimension, double cell)
{
    domain d = {.dimension = dimension,
                .vertex_count = b->vertex_count,
                .element_count = b->element_count,
                .at = b->rest,
                .element = b->element,
                .cell = cell};
    memset(b, 0, sizeof *b);
    return d;
}

/* [0, size] each way, in triangles: cells cut alternately along one diagonal and the other. */
static inline domain shape_sheet(double x, double y, int columns, int rows)
{
    body b = {0};
    sheet_triangles(&b, (const double[]){x, y}, (const int[]){columns, rows}, 0);
    return shape_from_body(&b, 2, x / columns);
}

static inline domain shape_box(const double size[3], const int cells[3])
{
    body b = {0};
    box_tets(&b, size, cells);
    return shape_from_body(&b, 3, size[0] / cells[0]);
}

static inline void shape_free(domain *d)
{
    free(d->at);
    free(d->element);
    free(d->lift);
    memset(d, 0, sizeof *d);
}

/* 1 on the border of the box that the vertices span. */
static inline int shape_on_border(const domain *d, int v, const double *size)
{
    for (int k = 0; k < d->dimension; k++)
        if (d->at[3 * v + k] <= 0 || d->at[3 * v + k] >= size[k])
            return 1;
    return 0;
}

/* Moves inner vertices by up to `by` a coordinate. */
static inline void shape_jitter(domain *d, const double *size, double by, unsigned seed)
{
    for (int v = 0; v < d->vertex_count; v++)
        for (int k = 0, border = shape_on_border(d, v, size); k < d->dimension && !border; k++)
            d->at[3 * v + k] += shape_random(&seed, -by, by);
}

/* The vertex nearest to (x, y, z). */
static inline int shape_vertex(const domain *d, double x, double y, double z)
{
    int best = 0;
    double least = HUGE_VAL;
    for (int v = 0; v < d->vertex_count; v++) {
        const double *at = d->at + 3 * v;
        double d2 =
            (at[0] - x) * (at[0] - x) + (at[1] - y) * (at[1] - y) + (at[2] - z) * (at[2] - z);
        if (d2 < least) {
            least = d2;
            best = v;
        }
    }
    return best;
}

#endif
