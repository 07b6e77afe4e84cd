/* Builds clips with skins for tests (SPEC 4.18-4.23), beside clip_build.h.
 * SPDX-License-Identifier: MIT */
#ifndef CLIP_BUILD_SKIN_H
#define CLIP_BUILD_SKIN_H

#include "clip_build.h"

/* `frame` is row-major, Q14; place and length in raw units / 2^8. */
typedef struct {
    uint16_t parent, value;
    uint8_t along;
    int32_t origin[3], length;
    const int16_t *frame; /* 9 */
} build_bone_data;

typedef struct {
    uint8_t kind, count;
    uint16_t channel;
    uint32_t data;
    int32_t axis[3];
} build_joint_data;

/* `palette` and `texels` may be NULL: offset 0. */
typedef struct {
    uint16_t part;
    uint8_t kind;
    uint16_t width, height;
    const uint8_t *palette, *texels; /* 768; width height */
    uint32_t step;
    int32_t corner[2];
} build_paint_data;

/* `count` bytes into DATA on a multiple of `unit`; where they start. */
static inline uint32_t build_data(build *b, uint32_t unit, const uint8_t *bytes, uint32_t count)
{
    build_align(b, WG_SECTION_DATA, unit);
    uint32_t at = b->section[WG_SECTION_DATA].bytes;
    for (uint32_t i = 0; i < count; i++) {
        build_add(b, WG_SECTION_DATA, 1, bytes[i]);
    }
    return at;
}

/* Bones and spans added next belong to this skin. */
static inline void build_skin(build *b, uint16_t shape, uint8_t method, uint8_t ends)
{
    build_add(b, WG_SECTION_SKINS, 2, shape);
    build_add(b, WG_SECTION_SKINS, 1, method);
    build_add(b, WG_SECTION_SKINS, 1, ends);
    build_add(b, WG_SECTION_SKINS, 4, b->section[WG_SECTION_BONES].count);
    build_add(b, WG_SECTION_SKINS, 4, b->section[WG_SECTION_SPANS].count);
    build_add(b, WG_SECTION_SKINS, 4, 0);
    b->section[WG_SECTION_SKINS].count++;
}

/* Joints added next belong to this bone. */
static inline void build_bone(build *b, const build_bone_data *d)
{
    static const unsigned char ORDER[9] = {0, 1, 3, 4, 6, 7, 2, 5, 8}; /* as SPEC 4.18 has F */
    build_add(b, WG_SECTION_BONES, 2, d->parent);
    build_add(b, WG_SECTION_BONES, 2, b->section[WG_SECTION_JOINTS].count);
    build_add(b, WG_SECTION_BONES, 1, 0);
    build_add(b, WG_SECTION_BONES, 1, d->along);
    build_add(b, WG_SECTION_BONES, 2, d->value);
    for (unsigned c = 0; c < 3; c++) {
        build_add(b, WG_SECTION_BONES, 4, (uint32_t)d->origin[c]);
    }
    build_add(b, WG_SECTION_BONES, 4, (uint32_t)d->length);
    for (unsigned i = 0; i < 9; i++) {
        build_add(b, WG_SECTION_BONES, 2, (uint16_t)d->frame[ORDER[i]]);
    }
    build_add(b, WG_SECTION_BONES, 2, 0);
    build_add(b, WG_SECTION_BONES, 4, 0);
    b->section[WG_SECTION_BONES].count++;
    build_count(b, WG_SECTION_SKINS, WG_SKIN_BYTES - WG_SKIN_BONE_COUNT);
}

static inline void build_joint(build *b, const build_joint_data *j)
{
    build_section *bones = &b->section[WG_SECTION_BONES];
    build_add(b, WG_SECTION_JOINTS, 1, j->kind);
    build_add(b, WG_SECTION_JOINTS, 1, j->count);
    build_add(b, WG_SECTION_JOINTS, 2, j->channel);
    build_add(b, WG_SECTION_JOINTS, 4, j->data);
    for (unsigned c = 0; c < 3; c++) {
        build_add(b, WG_SECTION_JOINTS, 4, (uint32_t)j->axis[c]);
    }
    b->section[WG_SECTION_JOINTS].count++;
    bones->at[bones->bytes - WG_BONE_BYTES + WG_BONE_JOINT_COUNT]++;
}

/* A FOLLOW joint and its list. */
static inline void build_follow(build *b, uint8_t count, const uint8_t *bones)
{
    const build_joint_data j = {
        WG_JOINT_FOLLOW, count, 0, build_data(b, 1, bones, count), {0, 0, 0}};
    build_joint(b, &j);
}

/* `data` as SPEC 4.21 has it: 2 or, with ends, 3 bytes an influence. */
static inline void build_span(build *b, uint16_t first, uint16_t count, uint8_t influences,
                              const uint8_t *data)
{
    const build_section *skins = &b->section[WG_SECTION_SKINS];
    uint32_t each = 2u + skins->at[skins->bytes - WG_SKIN_BYTES + WG_SKIN_ENDS];
    build_add(b, WG_SECTION_SPANS, 2, first);
    build_add(b, WG_SECTION_SPANS, 2, count);
    build_add(b, WG_SECTION_SPANS, 4, influences);
    build_add(b, WG_SECTION_SPANS, 4, build_data(b, 1, data, each * influences * count));
    b->section[WG_SECTION_SPANS].count++;
    build_count(b, WG_SECTION_SKINS, WG_SKIN_BYTES - WG_SKIN_SPAN_COUNT);
}

static inline void build_field(build *b, uint16_t channel, uint8_t count, const uint16_t *channels,
                               const uint8_t *weights)
{
    uint32_t at = build_data(b, 2, NULL, 0);
    for (unsigned i = 0; i < count; i++) {
        build_add(b, WG_SECTION_DATA, 2, channels[i]);
    }
    build_data(b, 1, weights, count);
    build_add(b, WG_SECTION_FIELDS, 2, channel);
    build_add(b, WG_SECTION_FIELDS, 2, count);
    build_add(b, WG_SECTION_FIELDS, 4, at);
    b->section[WG_SECTION_FIELDS].count++;
}

static inline void build_paint(build *b, const build_paint_data *p)
{
    uint32_t area = (uint32_t)p->width * p->height;
    uint32_t palette = p->palette ? build_data(b, 1, p->palette, WG_PALETTE_BYTES) : 0;
    uint32_t texels = p->texels ? build_data(b, 1, p->texels, area) : 0;
    build_add(b, WG_SECTION_PAINTS, 2, p->part);
    build_add(b, WG_SECTION_PAINTS, 2, p->kind);
    build_add(b, WG_SECTION_PAINTS, 2, p->width);
    build_add(b, WG_SECTION_PAINTS, 2, p->height);
    build_add(b, WG_SECTION_PAINTS, 4, palette);
    build_add(b, WG_SECTION_PAINTS, 4, texels);
    build_add(b, WG_SECTION_PAINTS, 4, p->step);
    build_add(b, WG_SECTION_PAINTS, 4, (uint32_t)p->corner[0]);
    build_add(b, WG_SECTION_PAINTS, 4, (uint32_t)p->corner[1]);
    b->section[WG_SECTION_PAINTS].count++;
}

#endif
