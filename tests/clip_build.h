/* Builds clips for tests, record by record, as SPEC.md lays them down. Header-only: it shares no
 * code with the baker and none with the player. Values are written as given, right or wrong. Skins
 * are in clip_build_skin.h.
 * SPDX-License-Identifier: MIT */
#ifndef CLIP_BUILD_H
#define CLIP_BUILD_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "wiggly_format.h"

#define BUILD_SECTIONS (WG_SECTION_KNOWN + 2u) /* the last one is of a kind nobody knows */

typedef struct {
    uint8_t *at;
    uint32_t bytes, room;
    uint16_t count;
} build_section;

typedef struct {
    build_section section[BUILD_SECTIONS];
    uint8_t minor;
} build;

/* A run: `params` are the 32-bit words and `values` the knots or coefficients of SPEC 4.4. */
typedef struct {
    uint16_t start, segments;
    uint8_t kind, shift, aux;
    int32_t base;
    const uint16_t *ends;
    const uint32_t *params;
    const int16_t *values;
} build_run_data;

typedef struct {
    uint8_t protocol, id;
    uint16_t channel;
    int32_t offset;
    int16_t gain;
    uint8_t gain_shift;
    int16_t min, max;
    uint16_t velocity, acceleration;
} build_servo_data;

typedef struct {
    uint16_t vertices;
    int8_t frac;
    uint16_t affine;
    int32_t origin[3];
    const int16_t *rest; /* 3 vertices */
} build_shape_data;

/* Components of 8 bits are given as int16_t too. */
typedef struct {
    uint16_t a, b, first, count;
    uint8_t bits;
    const int16_t *of_a, *of_b; /* 3 count; of_b only for a pair */
} build_block_data;

typedef struct {
    uint16_t shape, normals, triangles;
    uint8_t sides, colour[3];
    const uint16_t *corners; /* 3 triangles */
} build_part_data;

/* ---- bytes ----------------------------------------------------------------------------------- */

static inline void build_put(uint8_t *at, unsigned bytes, uint32_t value)
{
    for (unsigned i = 0; i < bytes; i++) {
        at[i] = (uint8_t)(value >> (8u * i));
    }
}

static inline uint32_t build_get(const uint8_t *at, unsigned bytes)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < bytes; i++) {
        value |= (uint32_t)at[i] << (8u * i);
    }
    return value;
}

static inline void build_add(build *b, unsigned kind, unsigned bytes, uint32_t value)
{
    build_section *s = &b->section[kind];
    if (s->bytes + 4u > s->room) {
        s->room = s->room * 2u + 256u;
        s->at = realloc(s->at, s->room);
        if (!s->at) {
            abort();
        }
    }
    build_put(s->at + s->bytes, bytes, value);
    s->bytes += bytes;
}

static inline void build_align(build *b, unsigned kind, uint32_t unit)
{
    while (b->section[kind].bytes % unit != 0) {
        build_add(b, kind, 1, 0);
    }
}

/* ---- records --------------------------------------------------------------------------------- */

static inline void build_channel(build *b, int frac, uint8_t unit, int32_t rest)
{
    build_add(b, WG_SECTION_CHANNELS, 1, (uint32_t)frac);
    build_add(b, WG_SECTION_CHANNELS, 1, unit);
    build_add(b, WG_SECTION_CHANNELS, 2, 0);
    build_add(b, WG_SECTION_CHANNELS, 4, (uint32_t)rest);
    b->section[WG_SECTION_CHANNELS].count++;
}

/* mul = tick_rate 2^16 / 10^6 2^shift, rounded, with shift as large as keeps it below 2^32; the
 * largest, 65535 2^16 / 10^6 = 4294.9, has shift 19, the smallest, 0.0655, shift 35. */
static inline uint32_t build_mul(uint16_t tick_rate, uint8_t *shift)
{
    uint64_t mul = 0;
    for (*shift = 36; *shift > 0; (*shift)--) {
        /* 2^16 / 10^6 = 2^10 / 15625; 65535 2^46 fits. */
        mul = (((uint64_t)tick_rate << (*shift + 10u)) + 7812u) / 15625u;
        if (mul >> 32 == 0) {
            break;
        }
    }
    return (uint32_t)mul;
}

/* Tracks and events added next belong to this clip. */
static inline void build_clip(build *b, uint16_t tick_rate, uint16_t ticks, uint8_t end)
{
    uint8_t shift;
    uint32_t mul = build_mul(tick_rate, &shift);
    uint64_t us_q16 = ((((uint64_t)ticks * 1000000u) << 16) + tick_rate / 2u) / tick_rate;
    build_add(b, WG_SECTION_CLIPS, 4, mul);
    build_add(b, WG_SECTION_CLIPS, 1, shift);
    build_add(b, WG_SECTION_CLIPS, 1, end);
    build_add(b, WG_SECTION_CLIPS, 2, ticks);
    build_add(b, WG_SECTION_CLIPS, 4, (uint32_t)(us_q16 >> 16));
    build_add(b, WG_SECTION_CLIPS, 2, (uint32_t)us_q16 & 0xffffu);
    build_add(b, WG_SECTION_CLIPS, 2, tick_rate);
    build_add(b, WG_SECTION_CLIPS, 2, b->section[WG_SECTION_TRACKS].count);
    build_add(b, WG_SECTION_CLIPS, 2, 0);
    build_add(b, WG_SECTION_CLIPS, 2, b->section[WG_SECTION_EVENTS].count);
    build_add(b, WG_SECTION_CLIPS, 2, 0);
    b->section[WG_SECTION_CLIPS].count++;
}

/* One more in a 16-bit count of a section's last record; `back` bytes before the section's end. */
static inline void build_count(build *b, unsigned kind, uint32_t back)
{
    uint8_t *count = b->section[kind].at + b->section[kind].bytes - back;
    build_put(count, 2, build_get(count, 2) + 1u);
}

/* Runs added next belong to this track. */
static inline void build_track(build *b, uint16_t channel)
{
    build_add(b, WG_SECTION_TRACKS, 2, channel);
    build_add(b, WG_SECTION_TRACKS, 2, b->section[WG_SECTION_RUNS].count);
    build_add(b, WG_SECTION_TRACKS, 2, 0);
    b->section[WG_SECTION_TRACKS].count++;
    build_count(b, WG_SECTION_CLIPS, WG_CLIP_BYTES - WG_CLIP_TRACK_COUNT);
}

static inline unsigned build_param_words(uint8_t kind)
{
    static const unsigned char WORDS[8] = {0, 0, 0, 4, 2, 2, 4, 2};
    return WORDS[kind & 7u];
}

/* How many 16-bit values a run of the kind has. */
static inline uint32_t build_value_count(uint8_t kind, uint16_t segments)
{
    return kind < 2u ? segments + 1u : kind == 2u ? 2u * (segments + 1u) : 4u * (uint32_t)segments;
}

static inline void build_run(build *b, const build_run_data *r)
{
    build_section *data = &b->section[WG_SECTION_DATA];
    build_align(b, WG_SECTION_DATA, 2);
    uint32_t times = data->bytes;
    for (uint32_t i = 0; i < r->segments; i++) {
        build_add(b, WG_SECTION_DATA, 2, r->ends[i]);
    }
    build_align(b, WG_SECTION_DATA, 4);
    build_add(b, WG_SECTION_RUNS, 2, r->start);
    build_add(b, WG_SECTION_RUNS, 2, r->segments);
    build_add(b, WG_SECTION_RUNS, 1, r->kind);
    build_add(b, WG_SECTION_RUNS, 1, r->shift);
    build_add(b, WG_SECTION_RUNS, 2, r->aux);
    build_add(b, WG_SECTION_RUNS, 4, (uint32_t)r->base);
    build_add(b, WG_SECTION_RUNS, 4, times);
    build_add(b, WG_SECTION_RUNS, 4, data->bytes);
    b->section[WG_SECTION_RUNS].count++;
    build_count(b, WG_SECTION_TRACKS, WG_TRACK_BYTES - WG_TRACK_RUN_COUNT);
    for (unsigned i = 0; i < build_param_words(r->kind); i++) {
        build_add(b, WG_SECTION_DATA, 4, r->params[i]);
    }
    for (uint32_t i = 0; i < build_value_count(r->kind, r->segments); i++) {
        build_add(b, WG_SECTION_DATA, 2, (uint16_t)r->values[i]);
    }
}

static inline void build_event(build *b, uint16_t tick, uint16_t id)
{
    build_add(b, WG_SECTION_EVENTS, 2, tick);
    build_add(b, WG_SECTION_EVENTS, 2, id);
    b->section[WG_SECTION_EVENTS].count++;
    build_count(b, WG_SECTION_CLIPS, WG_CLIP_BYTES - WG_CLIP_EVENT_COUNT);
}

static inline void build_mask(build *b, const uint8_t *weights)
{
    for (uint16_t i = 0; i < b->section[WG_SECTION_CHANNELS].count; i++) {
        build_add(b, WG_SECTION_MASKS, 1, weights[i]);
    }
    b->section[WG_SECTION_MASKS].count++;
}

static inline void build_layer(build *b, uint8_t clip, uint8_t mode, uint8_t mask, uint16_t weight)
{
    build_add(b, WG_SECTION_LAYERS, 1, clip);
    build_add(b, WG_SECTION_LAYERS, 1, mode);
    build_add(b, WG_SECTION_LAYERS, 2, mask);
    build_add(b, WG_SECTION_LAYERS, 4, weight);
    b->section[WG_SECTION_LAYERS].count++;
}

static inline void build_filter(build *b, uint8_t op, uint16_t channel, int32_t p, int32_t q)
{
    build_add(b, WG_SECTION_FILTERS, 2, op);
    build_add(b, WG_SECTION_FILTERS, 2, channel);
    build_add(b, WG_SECTION_FILTERS, 4, (uint32_t)p);
    build_add(b, WG_SECTION_FILTERS, 4, (uint32_t)q);
    b->section[WG_SECTION_FILTERS].count++;
}

static inline void build_matrix(build *b, uint8_t n, const uint16_t *channels, const int16_t *m)
{
    build_align(b, WG_SECTION_DATA, 2);
    uint32_t list = b->section[WG_SECTION_DATA].bytes;
    for (unsigned i = 0; i < n; i++) {
        build_add(b, WG_SECTION_DATA, 2, channels[i]);
    }
    for (unsigned i = 0; i < (unsigned)n * n; i++) {
        build_add(b, WG_SECTION_DATA, 2, (uint16_t)m[i]);
    }
    build_filter(b, WG_FILTER_MATRIX, 0, (int32_t)list, 0);
    build_section *filters = &b->section[WG_SECTION_FILTERS];
    filters->at[filters->bytes - WG_FILTER_BYTES + WG_FILTER_N] = n;
}

static inline void build_trigger(build *b, uint16_t event, uint8_t layer, uint8_t clip, uint16_t ms)
{
    build_add(b, WG_SECTION_TRIGGERS, 2, event);
    build_add(b, WG_SECTION_TRIGGERS, 1, layer);
    build_add(b, WG_SECTION_TRIGGERS, 1, clip);
    build_add(b, WG_SECTION_TRIGGERS, 4, ms);
    b->section[WG_SECTION_TRIGGERS].count++;
}

static inline void build_servo(build *b, const build_servo_data *s)
{
    build_add(b, WG_SECTION_SERVOS, 1, s->protocol);
    build_add(b, WG_SECTION_SERVOS, 1, s->id);
    build_add(b, WG_SECTION_SERVOS, 2, s->channel);
    build_add(b, WG_SECTION_SERVOS, 4, (uint32_t)s->offset);
    build_add(b, WG_SECTION_SERVOS, 2, (uint16_t)s->gain);
    build_add(b, WG_SECTION_SERVOS, 2, s->gain_shift);
    build_add(b, WG_SECTION_SERVOS, 2, (uint16_t)s->min);
    build_add(b, WG_SECTION_SERVOS, 2, (uint16_t)s->max);
    build_add(b, WG_SECTION_SERVOS, 2, s->velocity);
    build_add(b, WG_SECTION_SERVOS, 2, s->acceleration);
    b->section[WG_SECTION_SERVOS].count++;
}

static inline void build_name(build *b, const char *text)
{
    do {
        build_add(b, WG_SECTION_NAMES, 1, (uint8_t)*text);
    } while (*text++);
    b->section[WG_SECTION_NAMES].count++;
}

/* ---- shapes ---------------------------------------------------------------------------------- */

/* Bases and blocks added next belong to this shape. */
static inline void build_shape(build *b, const build_shape_data *s)
{
    build_align(b, WG_SECTION_DATA, 4);
    build_add(b, WG_SECTION_SHAPES, 2, s->vertices);
    build_add(b, WG_SECTION_SHAPES, 2, (uint8_t)s->frac);
    build_add(b, WG_SECTION_SHAPES, 4, b->section[WG_SECTION_BASES].count);
    build_add(b, WG_SECTION_SHAPES, 4, b->section[WG_SECTION_BLOCKS].count);
    build_add(b, WG_SECTION_SHAPES, 4, s->affine);
    build_add(b, WG_SECTION_SHAPES, 4, b->section[WG_SECTION_DATA].bytes);
    for (unsigned c = 0; c < 3; c++) {
        build_add(b, WG_SECTION_SHAPES, 4, (uint32_t)s->origin[c]);
    }
    b->section[WG_SECTION_SHAPES].count++;
    for (uint32_t i = 0; i < 3u * s->vertices; i++) {
        build_add(b, WG_SECTION_DATA, 2, (uint16_t)s->rest[i]);
    }
}

static inline void build_basis(build *b, uint16_t channel, int16_t gain, uint8_t gain_shift)
{
    build_add(b, WG_SECTION_BASES, 2, channel);
    build_add(b, WG_SECTION_BASES, 2, (uint16_t)gain);
    build_add(b, WG_SECTION_BASES, 4, gain_shift);
    b->section[WG_SECTION_BASES].count++;
    build_count(b, WG_SECTION_SHAPES, WG_SHAPE_BYTES - WG_SHAPE_BASIS_COUNT);
}

/* Component i of the block's data: a.c, b.c, .. or in groups of two (SPEC 4.15). */
static inline int16_t build_component(const build_block_data *k, uint32_t i)
{
    uint32_t n = 3u * k->count, group = k->bits == 8 ? 2u : 1u;
    if (k->b == WG_ABSENT) {
        return k->of_a[i];
    }
    uint32_t c = i / (2u * group) * group + i % group;
    return c >= n ? 0 : i / group % 2u == 0 ? k->of_a[c] : k->of_b[c];
}

static inline void build_block(build *b, const build_block_data *k)
{
    uint32_t n = 3u * k->count;
    n = k->b == WG_ABSENT ? n : k->bits == 8 ? (n + 1u) / 2u * 4u : 2u * n;
    build_align(b, WG_SECTION_DATA, 4);
    build_add(b, WG_SECTION_BLOCKS, 2, k->a);
    build_add(b, WG_SECTION_BLOCKS, 2, k->b);
    build_add(b, WG_SECTION_BLOCKS, 2, k->first);
    build_add(b, WG_SECTION_BLOCKS, 2, k->count);
    build_add(b, WG_SECTION_BLOCKS, 4, k->bits);
    build_add(b, WG_SECTION_BLOCKS, 4, b->section[WG_SECTION_DATA].bytes);
    b->section[WG_SECTION_BLOCKS].count++;
    build_count(b, WG_SECTION_SHAPES, WG_SHAPE_BYTES - WG_SHAPE_BLOCK_COUNT);
    for (uint32_t i = 0; i < n; i++) {
        build_add(b, WG_SECTION_DATA, k->bits == 8 ? 1 : 2, (uint16_t)build_component(k, i));
    }
}

static inline void build_part(build *b, const build_part_data *p)
{
    build_align(b, WG_SECTION_DATA, 2);
    build_add(b, WG_SECTION_PARTS, 2, p->shape);
    build_add(b, WG_SECTION_PARTS, 2, p->normals);
    build_add(b, WG_SECTION_PARTS, 2, p->triangles);
    build_add(b, WG_SECTION_PARTS, 2, p->sides);
    for (unsigned c = 0; c < 3; c++) {
        build_add(b, WG_SECTION_PARTS, 1, p->colour[c]);
    }
    build_add(b, WG_SECTION_PARTS, 1, 0);
    build_add(b, WG_SECTION_PARTS, 4, b->section[WG_SECTION_DATA].bytes);
    b->section[WG_SECTION_PARTS].count++;
    for (uint32_t i = 0; i < 3u * p->triangles; i++) {
        build_add(b, WG_SECTION_DATA, 2, p->corners[i]);
    }
}

/* Light from the viewer, a black background. */
static inline void build_view(build *b, uint8_t projection, uint8_t shading,
                              const uint16_t channel[WG_VIEW_CHANNELS])
{
    build_add(b, WG_SECTION_VIEWS, 1, projection);
    build_add(b, WG_SECTION_VIEWS, 1, shading);
    build_add(b, WG_SECTION_VIEWS, 2, 60);           /* ambient */
    build_add(b, WG_SECTION_VIEWS, 4, 127ul << 16u); /* light */
    build_add(b, WG_SECTION_VIEWS, 4, 0);
    for (unsigned c = 0; c < WG_VIEW_CHANNELS; c++) {
        build_add(b, WG_SECTION_VIEWS, 2, channel[c]);
    }
    b->section[WG_SECTION_VIEWS].count++;
}

/* ---- the file -------------------------------------------------------------------------------- */

/* CRC-32 (ISO-HDLC) of bytes 8 .. length-1, from the definition in SPEC 3.1. */
static inline void build_seal(uint8_t *file, uint32_t length)
{
    uint32_t crc = 0xffffffffu;
    for (uint32_t i = WG_HEADER_MAJOR; i < length; i++) {
        crc ^= file[i];
        for (unsigned bit = 0; bit < 8; bit++) {
            crc = crc & 1u ? crc >> 1 ^ 0xedb88320u : crc >> 1;
        }
    }
    build_put(file + WG_HEADER_CRC, 4, ~crc);
}

/* A heap block of exactly `size` bytes, so that a read past it is caught. */
static inline uint8_t *build_copy(const uint8_t *bytes, uint32_t size)
{
    uint8_t *copy = malloc(size ? size : 1u);
    if (!copy) {
        abort();
    }
    if (size) {
        memcpy(copy, bytes, size);
    }
    return copy;
}

static inline uint32_t build_directory(const build *b, uint8_t *file)
{
    uint32_t sections = 0, at = 0;
    for (unsigned k = 1; k < BUILD_SECTIONS; k++) {
        sections += b->section[k].bytes > 0 || b->section[k].count > 0;
    }
    at = WG_HEADER_BYTES + sections * WG_DIRECTORY_BYTES;
    build_put(file + WG_HEADER_SECTIONS, 2, sections);
    uint8_t *entry = file + WG_HEADER_BYTES;
    for (unsigned k = 1; k < BUILD_SECTIONS; k++) {
        const build_section *s = &b->section[k];
        if (s->bytes == 0 && s->count == 0) {
            continue;
        }
        build_put(entry, 2, k <= WG_SECTION_KNOWN ? k : 200u);
        build_put(entry + 2, 2, s->count);
        build_put(entry + 4, 4, at);
        build_put(entry + 8, 4, s->bytes);
        if (s->bytes) {
            memcpy(file + at, s->at, s->bytes);
        }
        at += (s->bytes + 3u) & ~3u;
        entry += WG_DIRECTORY_BYTES;
    }
    return at;
}

/* The clip file in an exact-size heap block; the builder is empty afterwards. */
static inline uint8_t *build_finish(build *b, uint32_t *size)
{
    uint32_t room = WG_HEADER_BYTES + BUILD_SECTIONS * (WG_DIRECTORY_BYTES + 4u);
    for (unsigned k = 0; k < BUILD_SECTIONS; k++) {
        room += b->section[k].bytes;
    }
    uint8_t *file = calloc(room, 1);
    if (!file) {
        abort();
    }
    *size = build_directory(b, file);
    build_put(file, 4, WG_FORMAT_MAGIC);
    file[WG_HEADER_MAJOR] = WG_FORMAT_MAJOR;
    file[WG_HEADER_MINOR] = b->minor;
    build_put(file + WG_HEADER_LENGTH, 4, *size);
    build_seal(file, *size);
    uint8_t *exact = build_copy(file, *size);
    for (unsigned k = 0; k < BUILD_SECTIONS; k++) {
        free(b->section[k].at);
    }
    memset(b, 0, sizeof *b);
    free(file);
    return exact;
}

/* Where record `index` of a section starts in a finished file. */
static inline uint32_t build_where(const uint8_t *file, uint32_t kind, uint32_t index)
{
    static const uint8_t STRIDE[] = {0, 8,  24, 6,  20, 1,  4,  1,  8,  12, 8, 20,
                                     1, 32, 8,  16, 16, 28, 48, 20, 16, 12, 8, 28};
    const uint8_t *entry = file + WG_HEADER_BYTES;
    while (build_get(entry, 2) != kind) {
        entry += WG_DIRECTORY_BYTES;
    }
    return build_get(entry + 4, 4) + (index ? index * STRIDE[kind] : 0);
}

#endif
