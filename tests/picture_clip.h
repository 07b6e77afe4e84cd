/* Clips for the tests of pictures: triangles that stand still, seen through one view whose numbers
 * are channels 0..7. The positions that the raster and the models see are the ones stored.
 * SPDX-License-Identifier: MIT */
#ifndef PICTURE_CLIP_H
#define PICTURE_CLIP_H

#include <math.h>
#include <stdlib.h>

#include "check.h"
#include "clip_build_skin.h"
#include "picture_skin.h"

#define PC_ANGLE     16 /* frac of the angles' channels */
#define PC_LENGTH    12 /* frac of the lengths' channels */
#define PC_FRAC      7  /* of the shape */
#define PC_VERTICES  4096
#define PC_TRIANGLES 8192
#define PC_PARTS     64
#define PC_SIDE      400 /* pixels at most */
#define PC_CHANNELS  16  /* those of the view first */
#define PC_BONES     8

/* Corners in units of length and triangles; part[i] is the first triangle of part i. */
typedef struct {
    unsigned vertices, triangles, parts;
    double at[PC_VERTICES][3];
    uint16_t corner[PC_TRIANGLES][3];
    unsigned part[PC_PARTS + 1];
    uint8_t sides;
    int fixed; /* a second shape holds normals: the vertices' directions from the middle */
    void (*more)(build *b); /* adds skins, paints and their channels, or NULL */
} pc_mesh;

/* What is looked at and how, and the raster's memory. */
typedef struct {
    uint8_t *clip;
    wg_file file;
    int32_t values[PC_CHANNELS];
    wg_picture picture;
    wg_picture_skins skins;
    wg_bone bones[PC_BONES];
    wg_vertex *vertices;
    uint8_t *shades;
    int16_t *normals;
    int16_t weights[1];
    uint32_t *pixels;
} pc_scene;

typedef struct {
    double yaw, pitch, roll, target[3], distance, size;
} pc_camera;

static inline unsigned pc_vertex(pc_mesh *m, double x, double y, double z)
{
    const double at[3] = {x, y, z};
    memcpy(m->at[m->vertices], at, sizeof at);
    return m->vertices++;
}

static inline void pc_triangle(pc_mesh *m, unsigned a, unsigned b, unsigned c)
{
    const uint16_t corner[3] = {(uint16_t)a, (uint16_t)b, (uint16_t)c};
    memcpy(m->corner[m->triangles++], corner, sizeof corner);
}

/* The triangles added next belong to another part. */
static inline void pc_part(pc_mesh *m)
{
    m->part[m->parts++] = m->triangles;
}

static inline void pc_shapes(build *b, pc_mesh *m)
{
    int16_t *rest = malloc(3u * m->vertices * sizeof *rest);
    for (unsigned i = 0; i < m->vertices; i++) {
        for (unsigned k = 0; k < 3; k++) {
            long raw = lrint(ldexp(m->at[i][k], PC_FRAC));
            rest[3 * i + k] = (int16_t)(raw > 32767 ? 32767 : raw < -32767 ? -32767 : raw);
            m->at[i][k] = ldexp(rest[3 * i + k], -PC_FRAC);
        }
    }
    const build_shape_data shape = {(uint16_t)m->vertices, PC_FRAC, WG_ABSENT, {0, 0, 0}, rest};
    build_shape(b, &shape);
    if (m->fixed) {
        build_shape(b, &shape);
    }
    free(rest);
}

/* The clip of a mesh, whose positions become the stored ones. */
static inline uint8_t *pc_clip(pc_mesh *m, uint8_t projection, uint8_t shading, uint32_t *size)
{
    static const uint16_t CHANNELS[WG_VIEW_CHANNELS] = {0, 1, 2, 3, 4, 5, 6, 7};
    build b = {{{0}}, 1};
    for (unsigned i = 0; i < WG_VIEW_CHANNELS; i++) {
        build_channel(&b, i < 3 ? PC_ANGLE : PC_LENGTH, WG_UNIT_NONE, 0);
    }
    build_clip(&b, 60, 60, WG_END_HOLD);
    pc_shapes(&b, m);
    m->part[m->parts] = m->triangles;
    for (unsigned i = 0; i < m->parts; i++) {
        const build_part_data part = {0,
                                      m->fixed ? 1 : WG_ABSENT,
                                      (uint16_t)(m->part[i + 1] - m->part[i]),
                                      m->sides,
                                      {(uint8_t)(200 - i), (uint8_t)(60 + 3 * i), 120},
                                      m->corner[m->part[i]]};
        build_part(&b, &part);
    }
    build_view(&b, projection, shading, CHANNELS);
    if (m->more) {
        m->more(&b);
    }
    return build_finish(&b, size);
}

static inline void pc_look(pc_scene *s, const pc_camera *c)
{
    const double numbers[WG_VIEW_CHANNELS] = {c->yaw,       c->pitch,     c->roll,     c->target[0],
                                              c->target[1], c->target[2], c->distance, c->size};
    for (unsigned i = 0; i < WG_VIEW_CHANNELS; i++) {
        s->values[i] = (int32_t)lrint(ldexp(numbers[i], i < 3 ? PC_ANGLE : PC_LENGTH));
    }
    wg_picture_set_skinned(&s->picture, s->values);
}

/* `smooth`: with memory for it. */
static inline void pc_open(pc_scene *s, pc_mesh *m, uint8_t projection, uint8_t shading,
                           wg_size size)
{
    uint32_t bytes;
    s->clip = pc_clip(m, projection, shading, &bytes);
    CHECK_EQ(wg_open(&s->file, s->clip, bytes), 0);
    CHECK_EQ(wg_open_shapes(&s->file), 0);
    s->vertices = malloc(m->vertices * sizeof *s->vertices);
    s->shades = malloc(m->vertices);
    s->normals = malloc(3u * m->vertices * sizeof *s->normals);
    s->pixels = malloc((size_t)size.width * size.height * sizeof *s->pixels);
    const wg_picture_memory memory = {s->vertices, s->shades, s->normals, s->weights};
    wg_picture_init(&s->picture, &s->file, size, &memory);
    if (m->more) {
        s->skins.bones = s->bones;
        CHECK_EQ(wg_open_skins(&s->file), 0);
        wg_picture_paint(&s->picture, &s->skins);
    }
}

static inline void pc_close(pc_scene *s)
{
    free(s->clip);
    free(s->vertices);
    free(s->shades);
    free(s->normals);
    free(s->pixels);
}

/* The whole picture in one piece. */
static inline const uint32_t *pc_draw(pc_scene *s)
{
    const wg_rect all = {0, 0, s->picture.size.width, s->picture.size.height};
    wg_picture_band(&s->picture, all, s->pixels);
    return s->pixels;
}

/* ---- meshes ---------------------------------------------------------------------------------- */

/* A torus about the y axis, `u` x `v` quadrilaterals, outside front. */
static inline void pc_torus(pc_mesh *m, unsigned u, unsigned v, double ring, double tube)
{
    unsigned first = m->vertices;
    for (unsigned i = 0; i < u; i++) {
        for (unsigned j = 0; j < v; j++) {
            double a = 2 * 3.14159265358979 * i / u, b = 2 * 3.14159265358979 * j / v;
            double r = ring + tube * cos(b);
            pc_vertex(m, r * cos(a), tube * sin(b), r * sin(a));
        }
    }
    for (unsigned i = 0; i < u; i++) {
        for (unsigned j = 0; j < v; j++) {
            unsigned i1 = (i + 1) % u, j1 = (j + 1) % v;
            unsigned p = first + i * v + j, q = first + i1 * v + j;
            unsigned r = first + i1 * v + j1, s = first + i * v + j1;
            pc_triangle(m, p, s, r);
            pc_triangle(m, p, r, q);
        }
    }
}

/* A box; `inward`: its front is inside. Two triangles a face, one part a face. */
static inline void pc_box(pc_mesh *m, double half, int inward)
{
    static const unsigned FACE[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    unsigned v[8];
    for (unsigned i = 0; i < 8; i++) {
        v[i] = pc_vertex(m, i & 1u ? half : -half, i & 2u ? half : -half, i & 4u ? half : -half);
    }
    for (unsigned f = 0; f < 6; f++) {
        const unsigned *c = FACE[f];
        pc_part(m);
        if (inward) {
            pc_triangle(m, v[c[0]], v[c[2]], v[c[1]]);
            pc_triangle(m, v[c[0]], v[c[3]], v[c[2]]);
        } else {
            pc_triangle(m, v[c[0]], v[c[1]], v[c[2]]);
            pc_triangle(m, v[c[0]], v[c[2]], v[c[3]]);
        }
    }
}

#endif
