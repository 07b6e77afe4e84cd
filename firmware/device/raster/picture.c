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
                const uint8_t *shape = wg_record(file, WG_SECTION_SHAPES, m->shape, WG_SHAPE_BYTES);
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

/* One vertex more. One that lies outside the view's limits may belong to a triangle that shows
 * anywhere. */
static void cover(wg_box *box, const wg_vertex *v)
{
    bool outside = v->z & 0x8000u;
    for (unsigned k = 0; k < 2; k++) {
        int16_t at = k == 0 ? v->x : v->y, low = outside ? 0 : at, high = outside ? INT16_MAX : at;
        box->low[k] = low < box->low[k] ? low : box->low[k];
        box->high[k] = high > box->high[k] ? high : box->high[k];
    }
}

/* Poses a range of vertices after the other, and projects or lights them. */
static void pose_ranges(wg_picture *picture, const mesh *m, const wg_pose *pose, bool normals)
{
    int32_t xyz[3 * RANGE];
    for (uint32_t i = 0; i < m->count; i += RANGE) {
        uint16_t count = (uint16_t)(m->count - i < RANGE ? m->count - i : RANGE);
        wg_pose_vertices(pose, (uint16_t)i, count, xyz);
        if (normals) {
            wg_view_light(&picture->view, xyz, count, picture->memory.shades + m->first + i);
        } else {
            wg_vertex *vertices = picture->memory.vertices + m->first + i;
            wg_view_project(&picture->view, pose->frac, xyz, count, vertices);
            for (uint16_t k = 0; k < count; k++) {
                cover(&picture->covers, &vertices[k]);
            }
        }
    }
}

/* Brightness from the frame's triangles. */
static void light_made(wg_picture *picture, const mesh *m)
{
    const wg_surface surface = {picture->file, &picture->view, picture->memory.vertices + m->first,
                                m->shape, m->count};
    const int16_t *made = picture->memory.normals + 3 * m->first;
    uint8_t *shade = picture->memory.shades + m->first;
    wg_normals_make(&surface, picture->memory.normals + 3 * m->first);
    for (uint16_t i = 0; i < m->count; i++, made += 3) {
        const int32_t normal[3] = {made[0], made[1], made[2]};
        wg_view_light(&picture->view, normal, 1, shade++);
    }
}

/* Brightness of a mesh, if there is memory for it. */
static void light(wg_picture *picture, const int32_t *values, const mesh *m,
                  const wg_pose *positions)
{
    uint16_t shape = normals_of(picture->file, m->shape);
    if (!picture->memory.shades || (shape == WG_ABSENT && !picture->memory.normals)) {
        return;
    }
    picture->lit |= (uint16_t)(1u << m->shape);
    if (shape == WG_ABSENT) {
        light_made(picture, m);
    } else {
        wg_pose normals;
        wg_pose_init(&normals, picture->file, (uint8_t)shape, picture->memory.weights);
        wg_pose_set_normals(&normals, values, picture->bases, positions);
        pose_ranges(picture, m, &normals, true);
    }
}

void wg_picture_set(wg_picture *picture, const int32_t *values)
{
    bool smooth = picture->shading == WG_SHADING_SMOOTH;
    bool renew = picture->frame == 0 || picture->frame >= picture->normals_every;
    mesh m = {0, 0, 0};
    picture->covered = picture->covers;
    for (unsigned k = 0; k < 2; k++) { /* nothing */
        picture->covers.low[k] = INT16_MAX;
        picture->covers.high[k] = INT16_MIN;
    }
    picture->lit = smooth && !renew ? picture->lit : 0;
    picture->fresh = (uint8_t)(picture->fresh >> 1);
    wg_view_set(&picture->view, picture->file, picture->index, values, picture->size);
    for (; mesh_find(picture->file, &m); mesh_next(&m)) { /* <= WG_SHAPES_MAX */
        wg_pose pose;
        wg_pose_init(&pose, picture->file, (uint8_t)m.shape, picture->memory.weights);
        wg_pose_set(&pose, values, picture->bases, &picture->view.camera);
        pose_ranges(picture, &m, &pose, false);
        if (smooth && renew) {
            light(picture, values, &m, &pose);
        }
    }
    picture->frame = (uint8_t)(!smooth ? 0 : renew ? 1 : picture->frame + 1);
}

/* The pixels that hold points of either frame along an axis, moved out to multiples of `unit` and cut
 * to 0 .. most. */
static void axis_of(const wg_picture *picture, unsigned axis, uint16_t unit, uint16_t *from,
                    uint16_t *to)
{
    const wg_box *a = &picture->covers, *b = &picture->covered;
    int32_t low = a->low[axis] < b->low[axis] ? a->low[axis] : b->low[axis];
    int32_t high = a->high[axis] > b->high[axis] ? a->high[axis] : b->high[axis];
    int32_t most = *to, step = unit > 0 ? unit : 1;
    low = fix_clamp(low >> 4, 0, most) / step * step;
    high = (fix_clamp((high >> 4) + 1, 0, most) + step - 1) / step * step;
    *from = (uint16_t)low;
    *to = (uint16_t)(high > most ? most : high);
}

wg_rect wg_picture_dirty(const wg_picture *picture, wg_size align)
{
    wg_rect r = {0, 0, picture->size.width, picture->size.height};
    if (picture->fresh == 0) {
        axis_of(picture, 0, align.width, &r.x0, &r.x1);
        axis_of(picture, 1, align.height, &r.y0, &r.y1);
        if (r.x0 >= r.x1 || r.y0 >= r.y1) {
            memset(&r, 0, sizeof r);
        }
    }
    return r;
}

/* Whether a triangle may touch the rows top .. bottom, in 1/16 pixel. It does not if its corners' ways
 * from one of them have one sign: on bands of few rows, most triangles are looked at for that alone. */
static bool reaches(const wg_triangle *t, int_fast16_t top, int_fast16_t bottom)
{
    const wg_vertex *a = t->at[0], *b = t->at[1], *c = t->at[2];
    return (((a->y - top) & (b->y - top) & (c->y - top)) |
            ((bottom - a->y) & (bottom - b->y) & (bottom - c->y))) >= 0;
}

static bool reaches_outside(const wg_triangle *t)
{
    return (t->at[0]->z | t->at[1]->z | t->at[2]->z) & 0x8000u;
}

static void draw_part(const wg_picture *picture, const wg_canvas *canvas, const uint8_t *part,
                      uint32_t first)
{
    const wg_vertex *vertices = picture->memory.vertices + first;
    const uint8_t *at = picture->file->section[WG_SECTION_DATA].at + wg_rd32(part + WG_PART_DATA);
    const uint8_t *shades =
        canvas->shading == WG_SHADING_SMOOTH ? picture->memory.shades + first : NULL;
    const int_fast16_t top = 16 * (int_fast16_t)canvas->rect.y0;
    const int_fast16_t bottom = 16 * (int_fast16_t)canvas->rect.y1 - 1;
    wg_triangle t;
    memset(&t, 0, sizeof t);
    t.edges = WG_EDGES;
    for (uint16_t n = wg_rd16(part + WG_PART_TRIANGLES); n > 0; n--, at += WG_TRIANGLE_BYTES) {
        t.at[0] = vertices + wg_rd16(at);
        t.at[1] = vertices + wg_rd16(at + 2);
        t.at[2] = vertices + wg_rd16(at + 4);
        bool outside = reaches_outside(&t);
        if (!outside && !reaches(&t, top, bottom)) {
            continue;
        }
        for (unsigned k = 0; k < 3 && shades; k++) {
            t.shade[k] = shades[wg_rd16(at + 2u * k)];
        }
        if (outside) {
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
        if (canvas.shading == WG_SHADING_SMOOTH && ((unsigned)picture->lit >> m.shape & 1u) == 0) {
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
