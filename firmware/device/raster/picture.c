/* Frames of a clip's shapes: vertices once a frame, then pixels, rectangle by rectangle.
 * Source: own.
 * SPDX-License-Identifier: MIT */
#include "picture.h"

#include <stddef.h>
#include <string.h>

#include "clip.h"
#include "draw.h"
#include "fix.h"
#include "normals.h"

/* Vertices posed at a time: 384 bytes of stack. */
#define RANGE 32u

/* A shape that parts have as positions, and where its vertices start. */
typedef struct {
    uint16_t shape, count;
    uint32_t first;
} mesh;

static const uint8_t *part_of(const wg_file *file, uint16_t part)
{
    return wg_record(file, WG_SECTION_PARTS, part, WG_PART_BYTES);
}

/* The next shape with parts from `m->shape` on. */
static bool mesh_find(const wg_file *file, mesh *m)
{
    for (; m->shape < file->section[WG_SECTION_SHAPES].count; m->shape++) {
        for (uint16_t i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
            if (wg_rd16(part_of(file, i) + WG_PART_SHAPE) == m->shape) {
                const uint8_t *shape =
                    wg_record(file, WG_SECTION_SHAPES, m->shape, WG_SHAPE_BYTES);
                m->count = wg_rd16(shape + WG_SHAPE_VERTICES);
                return true;
            }
        }
    }
    return false;
}

static void mesh_next(mesh *m)
{
    m->first += m->count;
    m->shape++;
}

/* The shape that holds the normals of `shape`, or WG_ABSENT. */
static uint16_t normals_of(const wg_file *file, uint16_t shape)
{
    for (uint16_t i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
        const uint8_t *part = part_of(file, i);
        uint16_t normals = wg_rd16(part + WG_PART_NORMALS);
        if (wg_rd16(part + WG_PART_SHAPE) == shape && normals != WG_ABSENT) {
            return normals;
        }
    }
    return WG_ABSENT;
}

static bool is_smooth(const wg_picture *picture, uint16_t shape)
{
    return picture->shading == WG_SHADING_SMOOTH && picture->memory.shades &&
           (picture->memory.normals || normals_of(picture->file, shape) != WG_ABSENT);
}

void wg_picture_look(wg_picture *picture, uint8_t view)
{
    const uint8_t *record = wg_record(picture->file, WG_SECTION_VIEWS, view, WG_VIEW_BYTES);
    picture->index = view;
    picture->shading = wg_rd8(record + WG_VIEW_SHADING);
    picture->frame = 0;
    picture->fresh = 2;
}

void wg_picture_init(wg_picture *picture, const wg_file *file, wg_size size,
                     const wg_picture_memory *memory)
{
    memset(picture, 0, sizeof *picture);
    picture->file = file;
    picture->memory = *memory;
    picture->size = size;
    picture->bases = WG_BASES_MAX;
    picture->normals_every = 1;
    wg_picture_look(picture, 0);
}

/* Pixels that hold vertices, as far as they lie in the picture. One that lies outside the view's
 * limits may belong to a triangle that shows anywhere. */
static void cover(wg_picture *picture, const wg_vertex *vertices, uint16_t count)
{
    wg_rect *c = &picture->covers;
    for (uint16_t i = 0; i < count; i++) {
        const wg_vertex *v = &vertices[i];
        if (v->z & 0x8000u) {
            wg_rect all = {0, 0, picture->size.width, picture->size.height};
            *c = all;
            return;
        }
        int32_t x = v->x >> 4, y = v->y >> 4;
        uint16_t x0 = (uint16_t)fix_clamp(x, 0, picture->size.width);
        uint16_t y0 = (uint16_t)fix_clamp(y, 0, picture->size.height);
        uint16_t x1 = (uint16_t)fix_clamp(x + 1, 0, picture->size.width);
        uint16_t y1 = (uint16_t)fix_clamp(y + 1, 0, picture->size.height);
        c->x0 = x0 < c->x0 ? x0 : c->x0;
        c->y0 = y0 < c->y0 ? y0 : c->y0;
        c->x1 = x1 > c->x1 ? x1 : c->x1;
        c->y1 = y1 > c->y1 ? y1 : c->y1;
    }
}

/* Brightness from posed normals. */
static void light_posed(wg_picture *picture, const mesh *m, const wg_pose *normals)
{
    int32_t xyz[3 * RANGE];
    for (uint32_t i = 0; i < m->count; i += RANGE) {
        uint16_t count = (uint16_t)(m->count - i < RANGE ? m->count - i : RANGE);
        wg_pose_vertices(normals, (uint16_t)i, count, xyz);
        wg_view_light(&picture->view, xyz, count, picture->memory.shades + m->first + i);
    }
}

/* Brightness from the frame's triangles. */
static void light_made(wg_picture *picture, const mesh *m)
{
    const wg_surface surface = {picture->file, &picture->view,
                                picture->memory.vertices + m->first, m->shape, m->count};
    int16_t *made = picture->memory.normals + 3 * m->first;
    wg_normals_make(&surface, made);
    for (uint32_t i = 0; i < m->count; i++) {
        int32_t normal[3] = {made[3 * i], made[3 * i + 1], made[3 * i + 2]};
        wg_view_light(&picture->view, normal, 1, picture->memory.shades + m->first + i);
    }
}

static void light(wg_picture *picture, const int32_t *values, const mesh *m,
                  const wg_pose *positions)
{
    uint16_t shape = normals_of(picture->file, m->shape);
    if (shape == WG_ABSENT) {
        light_made(picture, m);
        return;
    }
    wg_pose normals;
    wg_pose_init(&normals, picture->file, (uint8_t)shape, picture->memory.weights);
    wg_pose_set_normals(&normals, values, picture->bases, positions);
    light_posed(picture, m, &normals);
}

static void project(wg_picture *picture, const mesh *m, const wg_pose *pose)
{
    int32_t xyz[3 * RANGE];
    wg_vertex *vertices = picture->memory.vertices + m->first;
    for (uint32_t i = 0; i < m->count; i += RANGE) {
        uint16_t count = (uint16_t)(m->count - i < RANGE ? m->count - i : RANGE);
        wg_pose_vertices(pose, (uint16_t)i, count, xyz);
        wg_view_project(&picture->view, pose->frac, xyz, count, vertices + i);
        cover(picture, vertices + i, count);
    }
}

void wg_picture_set(wg_picture *picture, const int32_t *values)
{
    const wg_rect none = {picture->size.width, picture->size.height, 0, 0};
    bool smooth = picture->shading == WG_SHADING_SMOOTH;
    bool renew = smooth && picture->frame == 0;
    mesh m = {0, 0, 0};
    picture->covered = picture->covers;
    picture->covers = none;
    picture->fresh = picture->fresh > 0 ? (uint8_t)(picture->fresh - 1) : 0;
    wg_view_set(&picture->view, picture->file, picture->index, values, picture->size);
    for (; mesh_find(picture->file, &m); mesh_next(&m)) { /* <= WG_SHAPES_MAX */
        wg_pose pose;
        wg_pose_init(&pose, picture->file, (uint8_t)m.shape, picture->memory.weights);
        wg_pose_set(&pose, values, picture->bases, &picture->view.camera);
        project(picture, &m, &pose);
        if (renew && is_smooth(picture, m.shape)) {
            light(picture, values, &m, &pose);
        }
    }
    picture->frame = (uint8_t)(smooth && picture->frame + 1 < picture->normals_every
                                   ? picture->frame + 1
                                   : 0);
}

/* The smallest multiple of `unit` from `a` on, but not above `most`. */
static uint16_t round_up(uint16_t a, uint16_t unit, uint16_t most)
{
    uint32_t up = unit > 1 ? (a + (uint32_t)unit - 1) / unit * unit : a;
    return (uint16_t)(up > most ? most : up);
}

wg_rect wg_picture_dirty(const wg_picture *picture, wg_size align)
{
    const wg_rect *a = &picture->covers, *b = &picture->covered;
    wg_rect r = {0, 0, picture->size.width, picture->size.height};
    if (picture->fresh > 0) {
        return r;
    }
    r.x0 = a->x0 < b->x0 ? a->x0 : b->x0;
    r.y0 = a->y0 < b->y0 ? a->y0 : b->y0;
    r.x1 = a->x1 > b->x1 ? a->x1 : b->x1;
    r.y1 = a->y1 > b->y1 ? a->y1 : b->y1;
    if (r.x0 >= r.x1 || r.y0 >= r.y1) {
        const wg_rect nothing = {0, 0, 0, 0};
        return nothing;
    }
    r.x0 = (uint16_t)(r.x0 - (align.width > 1 ? r.x0 % align.width : 0));
    r.y0 = (uint16_t)(r.y0 - (align.height > 1 ? r.y0 % align.height : 0));
    r.x1 = round_up(r.x1, align.width, picture->size.width);
    r.y1 = round_up(r.y1, align.height, picture->size.height);
    return r;
}

/* Whether none of the rows of the rectangle holds a point of the triangle: on bands of few rows that
 * is what most triangles are looked at for. */
static bool misses(const wg_triangle *t, const wg_rect *rect)
{
    int16_t a = t->corner[0].at.y >> 4, b = t->corner[1].at.y >> 4, c = t->corner[2].at.y >> 4;
    int16_t y0 = (int16_t)rect->y0, y1 = (int16_t)rect->y1;
    return (a < y0 && b < y0 && c < y0) || (a >= y1 && b >= y1 && c >= y1);
}

static void draw_part(const wg_picture *picture, const wg_canvas *canvas, const uint8_t *part,
                      uint32_t first)
{
    const wg_vertex *vertices = picture->memory.vertices + first;
    const uint8_t *shades = picture->memory.shades ? picture->memory.shades + first : NULL;
    const uint8_t *at =
        picture->file->section[WG_SECTION_DATA].at + wg_rd32(part + WG_PART_DATA);
    uint16_t count = wg_rd16(part + WG_PART_TRIANGLES);
    wg_triangle t;
    t.normal = NULL;
    t.edges = WG_EDGES;
    for (; count > 0; count--, at += WG_TRIANGLE_BYTES) {
        uint16_t index[3], z = 0;
        for (unsigned k = 0; k < 3; k++) {
            index[k] = wg_rd16(at + 2u * k);
            t.corner[k].at = vertices[index[k]];
            z |= t.corner[k].at.z;
        }
        if ((z & 0x8000u) == 0 && misses(&t, &canvas->rect)) {
            continue;
        }
        for (unsigned k = 0; k < 3; k++) {
            t.corner[k].shade = shades ? shades[index[k]] : 255;
        }
        if (z & 0x8000u) {
            wg_draw_clipped(canvas, &t);
        } else {
            wg_draw_triangle(canvas, &t);
        }
    }
}

void wg_picture_band(const wg_picture *picture, wg_rect rect, uint32_t *pixels)
{
    const wg_file *file = picture->file;
    wg_canvas canvas = {&picture->view, pixels, rect, 0, 0, 0};
    mesh m = {0, 0, 0};
    uint32_t count = (uint32_t)(rect.x1 - rect.x0) * (uint32_t)(rect.y1 - rect.y0);
    memset(pixels, 0, (size_t)count * sizeof *pixels);
    for (; mesh_find(file, &m); mesh_next(&m)) { /* <= WG_SHAPES_MAX */
        canvas.shading = picture->shading;
        if (canvas.shading == WG_SHADING_SMOOTH && !is_smooth(picture, m.shape)) {
            canvas.shading = WG_SHADING_FLAT;
        }
        for (uint16_t i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
            const uint8_t *part = part_of(file, i);
            if (wg_rd16(part + WG_PART_SHAPE) == m.shape) {
                canvas.part = (uint8_t)(i + 1);
                canvas.sides = wg_rd8(part + WG_PART_SIDES);
                draw_part(picture, &canvas, part, m.first);
            }
        }
    }
}
