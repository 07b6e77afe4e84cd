/* As few bytes of stored bases as a tolerance takes.
 * Source: own, on Alexa 2002, 7.2.1. Rounding a basis to 8 bits costs most where its weights are
 * large: the first ones may take 16 bits, the others then 8. Where 8 bits are asked for, what a
 * basis lost is a later one's to give back: the leading direction of what is left, rounding
 * included.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include "wiggly_format.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of power iteration from the frame that is farthest off; with singular values a ratio q apart the
 * wrong part shrinks by q^32. Directions closer together than that are as good as each other. */
#define ITERATIONS 16

/* 8 bits are the upper half of 16 (SPEC 6.8): bases of both widths in one shape have one unit. */
#define NARROW_TOP 127
#define MIXED_TOP  (127 * 256)

double shape_entry(int bits, int16_t entry)
{
    return entry / (bits == 16 ? 32767.0 : (double)MIXED_TOP);
}

/* Steps of the largest component, each `unit` of the entry. */
static double round_to(const double *vector, int rows, const int steps_unit[2], int16_t *entry)
{
    double top = 0;
    for (int i = 0; i < rows; i++) {
        top = fmax(top, fabs(vector[i]));
    }
    for (int i = 0; i < rows; i++) {
        double e = top > 0 ? floor(vector[i] / top * steps_unit[0] + 0.5) : 0;
        entry[i] = (int16_t)(steps_unit[1] * e);
    }
    return top;
}

double shape_quantise(const double *vector, int rows, int bits, int16_t *entry)
{
    static const int NARROW[2] = {NARROW_TOP, 256}, WIDE[2] = {32767, 1};
    return round_to(vector, rows, bits == 8 ? NARROW : WIDE, entry);
}

double shape_quantise_mixed(const double *vector, int rows, int wide, int16_t *entry)
{
    static const int NARROW[2] = {NARROW_TOP, 256}, MIXED[2] = {MIXED_TOP, 1};
    return round_to(vector, rows, wide ? MIXED : NARROW, entry);
}

static double *column(const shape_reduction *r, int f)
{
    return r->residual + (size_t)f * (size_t)r->rows;
}

static double column_worst(const shape_reduction *r, int f)
{
    double worst = 0;
    for (int i = 0; i < r->rows; i += 3) {
        worst = fmax(worst, shape_distance(r->turn ? &r->turn[f] : NULL, column(r, f) + i));
    }
    return worst;
}

double shape_reduction_worst(const shape_reduction *r, shape_span span)
{
    double worst = 0;
    for (int f = span.first; f < span.first + span.count; f++) {
        worst = fmax(worst, column_worst(r, f));
    }
    return worst;
}

/* ---- how many, and how wide ------------------------------------------------------------------- */

/* The first `wide` of `count` directions in 16 bits, the others in 8. */
typedef struct {
    const shape_reduction *r;
    shape_span span;
    const shape_directions *from;
    double limit;
    int wide, count;
    int16_t *entry; /* rows x count */
    double *X, *E;  /* weights, count x span.count; what is left */
} choice;

static void stored(const shape_reduction *r, const int16_t *entry, double *vector)
{
    for (int i = 0; i < r->rows; i++) {
        vector[i] = shape_entry(r->bits, entry[i]);
    }
}

/* Rounds and weighs the bases of a choice; how far vertices are off then. */
static double weigh_choice(choice *c)
{
    static const int NARROW[2] = {NARROW_TOP, 256}, WIDE[2] = {32767, 1}, MIXED[2] = {MIXED_TOP, 1};
    const shape_reduction *r = c->r;
    size_t rows = (size_t)r->rows, n = (size_t)c->span.count;
    double *Q = bake_alloc(rows * (size_t)c->count + 1, sizeof *Q);
    for (int j = 0; j < c->count; j++) {
        size_t at = rows * (size_t)j;
        round_to(c->from->B + at, r->rows,
                 j >= c->wide    ? NARROW
                 : r->bits == 16 ? WIDE
                                 : MIXED,
                 c->entry + at);
        stored(r, c->entry + at, Q + at);
    }
    memcpy(c->E, r->residual + rows * (size_t)c->span.first, rows * n * sizeof *c->E);
    memset(c->X, 0, (size_t)c->count * n * sizeof *c->X);
    const shape_design design = {r, c->span, c->limit, c->count, Q};
    double worst = shape_refit(&design, c->E, c->X);
    free(Q);
    return worst;
}

/* More bases do not make up for rounding that leaves more than this many limits. */
#define HOPELESS 2

/* Choices in the order of their bytes until one is within the limit. next[i]: the count to try with
 * 2 i wide ones. */
static int search(choice *c, int least, int most)
{
    int next[WG_BASES_MAX / 2 + 2], widths = c->r->bits == 0 ? most / 2 + 1 : 1;
    double wide = c->r->rows, basis = wide + WG_BASIS_BYTES + 2 * c->r->columns; /* bytes */
    for (int i = 0; i < widths; i++) {
        next[i] = 2 * i > least ? 2 * i : least;
    }
    for (;;) {
        int best = -1;
        for (int i = 0; i < widths; i++) {
            if (next[i] <= most && (best < 0 || i * 2 * wide + next[i] * basis <
                                                    best * 2 * wide + next[best] * basis)) {
                best = i;
            }
        }
        if (best < 0) {
            return 0;
        }
        c->count = next[best]++;
        c->wide = c->r->bits == 16 ? c->count : 2 * best;
        double worst = weigh_choice(c);
        if (worst <= c->limit) {
            return 1;
        }
        if (worst > HOPELESS * c->limit && c->count >= c->from->enough) {
            next[best] = most + 1;
        }
    }
}

/* All directions together do not reach the limit: as wide as it takes for the rounding to add
 * little to what they leave. */
#define ROUNDING 1.05

static void fill(choice *c, int count)
{
    double limit = c->limit;
    c->count = c->wide = count;
    if (c->r->bits == 0) {
        c->limit = fmax(limit, ROUNDING * weigh_choice(c));
    }
    if (c->r->bits == 0 && search(c, count, count)) {
        c->limit = limit;
        return;
    }
    c->limit = limit;
    c->wide = c->r->bits == 8 ? 0 : count;
    weigh_choice(c);
}

static void take(shape_reduction *r, const choice *c, int piece)
{
    size_t rows = (size_t)r->rows;
    for (int j = 0; j < c->count; j++) {
        shape_basis *b = &r->basis[r->count++];
        b->piece = piece;
        b->scale = 1;
        b->entry = bake_alloc(rows, sizeof *b->entry);
        b->weight = bake_alloc((size_t)r->columns, sizeof *b->weight);
        memcpy(b->entry, c->entry + rows * (size_t)j, rows * sizeof *b->entry);
        for (int f = 0; f < c->span.count; f++) {
            b->weight[c->span.first + f] = c->X[j + f * c->count];
        }
    }
    memcpy(column(r, c->span.first), c->E, rows * (size_t)c->span.count * sizeof *c->E);
}

static void choose(shape_reduction *r, const shape_directions *d, shape_span span, int piece,
                   double limit)
{
    size_t rows = (size_t)r->rows, n = (size_t)span.count, most = (size_t)d->count;
    choice c = {.r = r, .span = span, .from = d, .limit = limit};
    c.entry = bake_alloc(rows * most + 1, sizeof *c.entry);
    c.X = bake_alloc(most * n + 1, sizeof *c.X);
    c.E = bake_alloc(rows * n, sizeof *c.E);
    int least = d->enough - 1 - d->enough / 12;
    if (d->enough > d->count || !search(&c, least > 0 ? least : 0, d->count)) {
        fill(&c, d->enough < d->count && r->bits == 8 ? d->enough : d->count);
    }
    take(r, &c, piece);
    free(c.entry);
    free(c.X);
    free(c.E);
}

/* ---- what is still left ----------------------------------------------------------------------- */

/* The leading direction of the columns first, first + every, ... of the span, from the one that is
 * farthest off. 0 when nothing is left. */
static int leading(const shape_reduction *r, shape_span span, double *direction)
{
    int kept = (span.count + r->every - 1) / r->every, stride = r->rows * r->every;
    double *inner = bake_alloc((size_t)kept, sizeof *inner), norm = 0, most = -1;
    int at = span.first;
    for (int f = span.first; f < span.first + span.count; f += r->every) {
        double w = column_worst(r, f);
        at = w > most ? f : at;
        most = fmax(w, most);
    }
    memcpy(direction, column(r, at), (size_t)r->rows * sizeof *direction);
    for (int i = 0; i < ITERATIONS; i++) {
        cblas_dgemv(CblasColMajor, CblasTrans, r->rows, kept, 1, column(r, span.first), stride,
                    direction, 1, 0, inner, 1);
        cblas_dgemv(CblasColMajor, CblasNoTrans, r->rows, kept, 1, column(r, span.first), stride,
                    inner, 1, 0, direction, 1);
        norm = cblas_dnrm2(r->rows, direction, 1);
        if (!(norm > 0)) {
            break;
        }
        cblas_dscal(r->rows, 1 / norm, direction, 1);
    }
    free(inner);
    return norm > 0;
}

/* Weights of all bases that serve the span. */
static void refit(shape_reduction *r, shape_span span, int piece, double limit)
{
    int used = 0, *which = bake_alloc((size_t)r->count + 1, sizeof *which);
    size_t rows = (size_t)r->rows;
    double *Q = bake_alloc(rows * ((size_t)r->count + 1), sizeof *Q);
    for (int j = 0; j < r->count; j++) {
        if (r->basis[j].piece < 0 || r->basis[j].piece == piece) {
            stored(r, r->basis[j].entry, Q + rows * (size_t)used);
            which[used++] = j;
        }
    }
    double *X = bake_alloc((size_t)used * (size_t)span.count + 1, sizeof *X);
    const shape_design design = {r, span, limit, used, Q};
    shape_refit(&design, column(r, span.first), X);
    for (int i = 0; i < used * span.count; i++) {
        r->basis[which[i % used]].weight[span.first + i / used] += X[i];
    }
    free(which);
    free(Q);
    free(X);
}

static void add(shape_reduction *r, const double *direction, int piece)
{
    shape_basis *b = &r->basis[r->count++];
    b->piece = piece;
    b->scale = 1;
    b->entry = bake_alloc((size_t)r->rows, sizeof *b->entry);
    b->weight = bake_alloc((size_t)r->columns, sizeof *b->weight);
    shape_quantise(direction, r->rows, r->bits == 16 ? 16 : 8, b->entry);
}

int shape_reduce(shape_reduction *r, shape_span span, int piece, double limit, bake_error *error)
{
    shape_directions d;
    if (shape_reduction_worst(r, span) <= limit || r->count >= r->most) {
        return 0;
    }
    if (shape_weigh(r, span, limit, &d, error) < 0) {
        return -1;
    }
    choose(r, &d, span, piece, limit);
    free(d.B);
    double *direction = bake_alloc((size_t)r->rows, sizeof *direction);
    while (r->count < r->most && shape_reduction_worst(r, span) > limit) {
        if (!leading(r, span, direction)) {
            break; /* with `every`, the frames between may keep something */
        }
        add(r, direction, piece);
        refit(r, span, piece, limit);
    }
    free(direction);
    return 0;
}

void shape_reduction_free(shape_reduction *r)
{
    for (int i = 0; i < r->count; i++) {
        free(r->basis[i].entry);
        free(r->basis[i].weight);
    }
    free(r->basis);
    free(r->residual);
    memset(r, 0, sizeof *r);
}
