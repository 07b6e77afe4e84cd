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
#include "steps.h"

static const uint8_t *part_of(const wg_file *file, uint16_t part)
{
    return wg_record(file, WG_SECTION_PARTS, part, WG_PART_BYTES);
}

/* The next shape with parts from `m->shape` on. */
static bool mesh_find(const wg_file *file, wg_picture_mesh *m)
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

static void mesh_next(wg_picture_mesh *m)
{
    m->first += m->count;
    m->shape++;
}

/* No light falls on any part of a shape. */
#define UNLIT (WG_ABSENT - 1u)

/* The shape that holds the normals of `shape`, or WG_ABSENT, or UNLIT. */
static uint16_t normals_of(const wg_picture *picture, uint16_t shape)
{
    uint16_t found = UNLIT;
    for (uint16_t i = 0; i < picture->file->section[WG_SECTION_PARTS].count; i++) {
        const uint8_t *part = part_of(picture->file, i);
        if (wg_rd16(part + WG_PART_SHAPE) == shape &&
            !wg_paint_of(picture->file, picture->paints, i)) {
            found = wg_rd16(part + WG_PART_NORMALS);
            if (found != WG_ABSENT) {
                break;
            }
        }
    }
    return found;
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

void wg_picture_paint(wg_picture *picture, wg_picture_skins *skins)
{
    picture->skins = skins;
    picture->paints = (uint8_t)picture->file->section[WG_SECTION_PAINTS].count;
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

/* ---- the vertices of a frame, in steps -------------------------------------------------------- */

/* Goes to the next mesh from work.mesh on, if there is one. */
static void start_mesh(wg_picture *picture)
{
    wg_picture_work *w = &picture->work;
    w->stage = WG_STEP_DONE;
    w->vertex = 0;
    if (mesh_find(picture->file, &w->mesh)) {
        w->stage = WG_STEP_POSITIONS;
        wg_pose_init(&w->pose, picture->file, (uint8_t)w->mesh.shape, picture->memory.weights);
        wg_pose_set(&w->pose, w->values, picture->bases, &picture->view.camera);
    }
}

static void finish_mesh(wg_picture *picture)
{
    mesh_next(&picture->work.mesh);
    start_mesh(picture);
}

/* So many vertices more of the mesh have their brightness. */
static void light_done(wg_picture *picture, uint16_t count)
{
    picture->work.vertex += count;
    if (picture->work.vertex >= picture->work.mesh.count) {
        finish_mesh(picture);
    }
}

/* After its positions: brightness of a mesh, if it is due and there is memory for it. */
static void start_light(wg_picture *picture)
{
    wg_picture_work *w = &picture->work;
    const wg_normals none = {0, 0, 0, 0, false};
    uint16_t bit = (uint16_t)(1u << w->mesh.shape), shape = normals_of(picture, w->mesh.shape);
    if (!w->renew || !picture->memory.shades || (shape == WG_ABSENT && !picture->memory.normals) ||
        shape == UNLIT || (picture->fields & bit)) {
        finish_mesh(picture);
        return;
    }
    picture->lit |= bit;
    w->vertex = 0;
    w->normals = none;
    w->stage = WG_STEP_SUMS;
    if (shape != WG_ABSENT) {
        const wg_pose positions = w->pose;
        wg_pose_init(&w->pose, picture->file, (uint8_t)shape, picture->memory.weights);
        wg_pose_set_normals(&w->pose, w->values, picture->bases, &positions);
        w->stage = WG_STEP_NORMALS;
    }
}

uint16_t wg_step_count(const wg_picture_work *work)
{
    uint32_t left = work->mesh.count - work->vertex;
    return (uint16_t)(left < WG_STEP_RANGE ? left : WG_STEP_RANGE);
}

void wg_step_positions(wg_picture *picture, const int32_t *xyz, uint16_t count)
{
    wg_picture_work *w = &picture->work;
    wg_vertex *vertices = picture->memory.vertices + w->mesh.first + w->vertex;
    wg_view_project(&picture->view, w->pose.frac, xyz, count, vertices);
    for (uint16_t i = 0; i < count; i++) {
        cover(&picture->covers, &vertices[i]);
    }
    w->vertex += count;
    if (w->vertex >= w->mesh.count) {
        start_light(picture);
    }
}

/* Positions or normals of the mesh. */
static void step_pose(wg_picture *picture)
{
    const wg_picture_work *w = &picture->work;
    uint16_t count = wg_step_count(w);
    int32_t xyz[3 * WG_STEP_RANGE];
    wg_pose_vertices(&w->pose, (uint16_t)w->vertex, count, xyz);
    if (w->stage == WG_STEP_POSITIONS) {
        wg_step_positions(picture, xyz, count);
    } else {
        wg_view_light(&picture->view, xyz, count,
                      picture->memory.shades + w->mesh.first + w->vertex);
        light_done(picture, count);
    }
}

static void step_lights(wg_picture *picture)
{
    uint16_t count = wg_step_count(&picture->work);
    uint32_t first = picture->work.mesh.first + picture->work.vertex;
    const int16_t *sum = picture->memory.normals + 3u * first;
    for (uint16_t i = 0; i < count; i++, sum += 3) {
        const int32_t normal[3] = {sum[0], sum[1], sum[2]};
        wg_view_light(&picture->view, normal, 1, picture->memory.shades + first + i);
    }
    light_done(picture, count);
}

bool wg_picture_step(wg_picture *picture)
{
    wg_picture_work *w = &picture->work;
    if (w->stage == WG_STEP_SUMS) {
        const wg_surface surface = {picture->file, &picture->view,
                                    picture->memory.vertices + w->mesh.first, w->mesh.shape,
                                    w->mesh.count};
        if (!wg_normals_step(&surface, &w->normals, picture->memory.normals + 3u * w->mesh.first)) {
            w->stage = WG_STEP_LIGHTS;
        }
    } else if (w->stage == WG_STEP_LIGHTS) {
        step_lights(picture);
    } else if (w->stage != WG_STEP_DONE) {
        step_pose(picture);
    }
    return w->stage != WG_STEP_DONE;
}

void wg_picture_begin(wg_picture *picture, const int32_t *values)
{
    const wg_picture_mesh first = {0, 0, 0};
    bool smooth = picture->shading == WG_SHADING_SMOOTH;
    bool renew = picture->frame == 0 || picture->frame >= picture->normals_every;
    picture->covered = picture->covers;
    for (unsigned k = 0; k < 2; k++) { /* nothing */
        picture->covers.low[k] = INT16_MAX;
        picture->covers.high[k] = INT16_MIN;
    }
    picture->lit = smooth && !renew ? picture->lit : 0;
    picture->fields = 0;
    picture->fresh = (uint8_t)(picture->fresh >> 1);
    picture->frame = (uint8_t)(!smooth ? 0 : renew ? 1 : picture->frame + 1);
    wg_view_set(&picture->view, picture->file, picture->index, values, picture->size);
    picture->work.values = values;
    picture->work.renew = smooth && renew;
    picture->work.mesh = first;
    start_mesh(picture);
}

void wg_picture_set(wg_picture *picture, const int32_t *values)
{
    wg_picture_begin(picture, values);
    while (wg_picture_step(picture)) { /* once every 32 vertices or triangles */
    }
}

/* ---- pixels ----------------------------------------------------------------------------------- */

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

/* How a part of a shape is shaded. A shape with a field has its brightness alone. */
static uint8_t shading_of(const wg_picture *picture, uint16_t shape, const uint8_t *paint)
{
    unsigned bit = 1u << shape;
    bool smooth = picture->shading == WG_SHADING_SMOOTH && (picture->lit & bit);
    if (picture->shading == WG_SHADING_WIRE) {
        return WG_SHADING_WIRE;
    }
    if (picture->fields & bit) {
        smooth = paint && wg_rd8(paint + WG_PAINT_KIND) == WG_PAINT_FIELD;
    }
    return smooth ? WG_SHADING_SMOOTH : WG_SHADING_FLAT;
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
        for (unsigned k = 0; k < 3; k++) {
            uint16_t vertex = wg_rd16(at + 2u * k);
            if (canvas->texture) {
                wg_texture_at(canvas->texture, vertex, t.texel[k]);
            } else if (shades) {
                t.shade[k] = shades[vertex];
            }
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
    wg_canvas canvas = {&picture->view, pixels, rect, 0, 0, 0, NULL};
    wg_texture texture;
    wg_picture_mesh m = {0, 0, 0};
    uint32_t count = (uint32_t)(rect.x1 - rect.x0) * (uint32_t)(rect.y1 - rect.y0);
    memset(pixels, 0, (size_t)count * sizeof *pixels);
    for (; mesh_find(file, &m); mesh_next(&m)) { /* <= WG_SHAPES_MAX */
        for (uint16_t i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
            const uint8_t *part = part_of(file, i);
            if (wg_rd16(part + WG_PART_SHAPE) == m.shape) {
                const uint8_t *paint = wg_paint_of(file, picture->paints, i);
                canvas.part = (uint8_t)(i + 1);
                canvas.sides = wg_rd8(part + WG_PART_SIDES);
                canvas.shading = shading_of(picture, m.shape, paint);
                canvas.texture = NULL;
                if (paint && wg_rd8(paint + WG_PAINT_KIND) == WG_PAINT_PICTURE &&
                    canvas.shading != WG_SHADING_WIRE) {
                    wg_texture_set(&texture, file, paint, m.shape);
                    canvas.texture = &texture;
                }
                draw_part(picture, &canvas, part, m.first);
            }
        }
    }
}
