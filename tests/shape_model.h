/* A deformed shape straight from SPEC 6.8, in 64-bit integers, with every displacement in a dense
 * array: what test_player_shape.c compares with. Shares no code with the player.
 * SPDX-License-Identifier: MIT */
#ifndef SHAPE_MODEL_H
#define SHAPE_MODEL_H

#include <stdbool.h>

#include "clip_build.h"

#define MODEL_VERTICES 48u
#define MODEL_BASES    12u
#define MODEL_N        (3u * MODEL_VERTICES)

typedef struct {
    unsigned vertices, bases;
    int16_t rest[MODEL_N];
    int64_t moved[MODEL_BASES][MODEL_N]; /* e_j */
    int16_t gain[MODEL_BASES];
    uint8_t gain_shift[MODEL_BASES];
    int32_t value[MODEL_BASES]; /* of channel j, which basis j listens to */
} model;

static inline uint32_t model_next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* -half .. half - 1; now and then one of the two. */
static inline int16_t model_component(uint32_t *state, int32_t half)
{
    uint32_t n = model_next(state);
    if (n % 16u == 0) {
        return (int16_t)(n & 16u ? half - 1 : -half);
    }
    return (int16_t)((int32_t)(model_next(state) % (2u * (uint32_t)half)) - half);
}

static inline int64_t model_floor(int64_t a, int64_t b) /* floor(a / b), b > 0 */
{
    return a / b - (a % b < 0);
}

/* round(mulq(v, gain), gain_shift), clamped. */
static inline int64_t model_weight(const model *m, unsigned j)
{
    int64_t product = model_floor((int64_t)m->value[j] * m->gain[j], 65536);
    int64_t unit = (int64_t)1 << m->gain_shift[j];
    int64_t w = model_floor(2 * product + unit, 2 * unit);
    return w > 32767 ? 32767 : w < -32767 ? -32767 : w;
}

/* p of step 3. */
static inline int64_t model_component_at(const model *m, unsigned bases, unsigned i)
{
    int64_t sum = 32768 * (int64_t)m->rest[i] + 16384;
    for (unsigned j = 0; j < m->bases && j < bases; j++) {
        sum += model_weight(m, j) * m->moved[j][i];
    }
    int64_t low = model_floor(sum, 32768) % 65536; /* 2^32 / 2^15 is a multiple of 2^16 */
    low = low < 0 ? low + 65536 : low;
    return low >= 32768 ? low - 65536 : low;
}

/* ---- random clips ---------------------------------------------------------------------------- */

static inline void model_block(model *m, build *b, uint32_t *state)
{
    int16_t a[MODEL_N], of_b[MODEL_N];
    unsigned first = model_next(state) % m->vertices;
    unsigned count = 1u + model_next(state) % (m->vertices - first);
    bool narrow = model_next(state) & 1u, pair = model_next(state) % 3u != 0;
    build_block_data k = {(uint16_t)(model_next(state) % m->bases),
                          WG_ABSENT,
                          (uint16_t)first,
                          (uint16_t)count,
                          narrow ? 8 : 16,
                          a,
                          of_b};
    if (pair) {
        k.b = (uint16_t)(model_next(state) % m->bases);
    }
    for (unsigned i = 0; i < 3u * count; i++) {
        a[i] = model_component(state, narrow ? 128 : 32768);
        of_b[i] = model_component(state, narrow ? 128 : 32768);
        m->moved[k.a][3u * first + i] += (int64_t)a[i] * (narrow ? 256 : 1);
        if (pair) {
            m->moved[k.b][3u * first + i] += (int64_t)of_b[i] * (narrow ? 256 : 1);
        }
    }
    build_block(b, &k);
}

/* Channel values; a third of them weigh nothing. */
static inline void model_values(model *m, uint32_t *state)
{
    for (unsigned j = 0; j < MODEL_BASES; j++) {
        int32_t big = (int32_t)(model_next(state) << 5) - (1 << 28);
        m->value[j] = model_next(state) % 3u == 0 ? 0 : big >> model_next(state) % 16u;
    }
}

/* The shape and its bases in `b`, which has a channel for every basis already. */
static inline void model_build(model *m, build *b, const build_shape_data *like, uint32_t *state)
{
    memset(m, 0, sizeof *m);
    m->vertices = 1u + model_next(state) % MODEL_VERTICES;
    m->bases = 1u + model_next(state) % MODEL_BASES;
    for (unsigned i = 0; i < 3u * m->vertices; i++) {
        m->rest[i] = model_component(state, 32768);
    }
    build_shape_data s = *like;
    s.vertices = (uint16_t)m->vertices;
    s.rest = m->rest;
    build_shape(b, &s);
    for (unsigned j = 0; j < m->bases; j++) {
        m->gain[j] = model_component(state, 32768);
        m->gain_shift[j] = (uint8_t)(1u + model_next(state) % 15u);
        build_basis(b, (uint16_t)j, m->gain[j], m->gain_shift[j]);
    }
    for (unsigned n = model_next(state) % 10u; n > 0; n--) {
        model_block(m, b, state);
    }
    model_values(m, state);
}

#endif
