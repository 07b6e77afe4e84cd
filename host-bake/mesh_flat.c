/* Pictures and drawings as meshes: the outline of what is opaque, filled with triangles, upright
 * about (0, 0, 0), and the picture that it is drawn with.
 * Source: own; Jacobson 2013, 4.8 (images).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include "domain.h"
#include "outline.h"
#include "texture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where nothing else is said: triangles along the longer side, texels of it. */
static const double cells = 24;
enum { TEXELS = 128 };

int mesh_is_flat(const char *path)
{
    return mesh_ends(path, ".png") || mesh_ends(path, ".svg");
}

static int is_drawing(const mesh_reader *r)
{
    return mesh_ends(r->mesh->file, ".svg");
}

static int flat_fail(const mesh_reader *r, const bake_error *why)
{
    return mesh_fail(r, r->mesh->file, "%s", why->text);
}

/* A picture has no other frames, and its shapes would need its vertices. */
static int check_use(mesh_reader *r, int index)
{
    const char *path = r->mesh->file;
    for (int i = 0; i < r->s->clip_count; i++)
        for (int j = 0; j < r->s->clips[i].motion_count; j++)
            if (r->s->clips[i].motions[j].mesh == index) {
                r->line = r->s->clips[i].motions[j].line;
                return mesh_fail(r, path, "is one picture and has no frames; move it with a rig");
            }
    if (r->mesh->shape_count > 0) {
        r->line = r->mesh->shapes[0].line;
        return mesh_fail(r, path, "is a picture and has no shapes; move it with a rig");
    }
    return 0;
}

/* Pixels to scene units: y upwards, the middle of the box at (0, 0). */
static void place(const outline *o, const picture_place *where)
{
    const double *box = where->box, unit = where->unit;
    double *at = (double *)o->at; /* outline_trace allotted it */
    for (int i = 0; i < o->point_count; i++) {
        at[2 * i] = unit * (at[2 * i] - (box[0] + box[2]) / 2);
        at[2 * i + 1] = unit * ((box[1] + box[3]) / 2 - at[2 * i + 1]);
    }
}

static int fill(const mesh_reader *r, const picture_place *where, mesh *out)
{
    const double *box = where->box;
    const scene_mesh *m = r->mesh;
    const surface_origin origin = {r->s->path, m->name, m->line};
    const handles none = {0};
    double longer = where->unit * fmax(box[2] - box[0], box[3] - box[1]);
    const domain_options how = {m->cell > 0 ? m->cell : longer / cells, &origin, 0};
    domain d;
    if (domain_flat(out->flat, &none, &how, &d, r->error))
        return -1;
    int err = d.vertex_count > MESH_VERTICES_MAX || d.element_count > MESH_VERTICES_MAX;
    if (err) {
        mesh_fail(
            r, m->file,
            "takes %d vertices and %d triangles; a shape holds %d of each: make 'cell' larger "
            "than %.3g, or smooth its border",
            d.vertex_count, d.element_count, MESH_VERTICES_MAX, how.cell);
    } else {
        out->vertex_count = d.vertex_count;
        out->triangle_count = d.element_count;
        out->rest = d.at;
        d.at = NULL;
        out->shape = bake_alloc(0, sizeof *out->shape);
        out->triangle = bake_alloc((size_t)d.element_count, sizeof *out->triangle);
        out->part = bake_alloc((size_t)d.element_count, sizeof *out->part);
        for (int i = 0; i < d.element_count; i++)
            memcpy(out->triangle[i], d.element[i], sizeof *out->triangle);
    }
    domain_free(&d);
    return err ? -1 : 0;
}

/* A colour of the scene replaces the picture's. */
static int colour(const mesh_reader *r, const pixels *p, picture_place *where, mesh *out)
{
    bake_error why;
    mesh_part *part = out->parts = bake_alloc(1, sizeof *part);
    out->part_count = 1;
    *part = (mesh_part){.name = bake_copy(r->mesh->name), .sides = r->mesh->sides != 1};
    pixels_main_colour(p, part->colour);
    if (r->mesh->has_colour)
        memcpy(part->colour, r->mesh->colour, sizeof part->colour);
    if (r->mesh->has_colour || is_drawing(r))
        return 0;
    out->picture = bake_alloc(1, sizeof *out->picture);
    where->texels = r->mesh->texels > 0 ? r->mesh->texels : TEXELS;
    return picture_make(p, where, out->picture, &why) ? flat_fail(r, &why) : 0;
}

/* Pixels that the outline may be off: half of the mesh's tolerance, or a thousandth of the longer
 * side; but not so little that pixels show. From 1/2 on, one of the two corners would go that the
 * traced outline has where the picture has one, and straight borders would turn a little. */
static double outline_tolerance(const mesh_reader *r, const pixels *p)
{
    const scene_mesh *m = r->mesh;
    double side = p->width > p->height ? p->width : p->height;
    double wanted = m->tolerance > 0 ? m->tolerance / (2 * p->unit * m->scale) : side / 1000;
    return fmax(wanted, 0.45);
}

static int make(const mesh_reader *r, const pixels *p, mesh *out)
{
    bake_error why;
    picture_place where = {.unit = p->unit * r->mesh->scale};
    out->flat = bake_alloc(1, sizeof *out->flat);
    if (outline_trace(p, outline_tolerance(r, p), out->flat, &out->specks, &why))
        return flat_fail(r, &why);
    outline_box(out->flat, where.box);
    if (colour(r, p, &where, out))
        return -1;
    place(out->flat, &where);
    return fill(r, &where, out);
}

int mesh_flat_load(mesh_reader *r, int index, mesh *out)
{
    bake_error why;
    pixels p;
    isolate_now(r->now, r->line, r->mesh->file);
    if (check_use(r, index))
        return -1;
    if (is_drawing(r) ? pixels_read_svg(r->mesh->file, &p, &why)
                      : pixels_read_png(r->mesh->file, &p, &why))
        return flat_fail(r, &why);
    int err = make(r, &p, out);
    pixels_free(&p);
    return err;
}

/* ---- on their way to the baker --------------------------------------------------------------- */

enum { COUNTS = 3, POINTS_MAX = 1 << 20 };

void mesh_flat_send(const mesh *m, FILE *to)
{
    const int count[COUNTS] = {m->flat ? m->flat->loop_count : 0,
                               m->flat ? m->flat->point_count : 0, m->picture != NULL};
    fwrite(count, sizeof *count, COUNTS, to);
    fwrite(&m->specks, sizeof m->specks, 1, to);
    if (m->flat) {
        fwrite(m->flat->loop, sizeof(int), (size_t)count[0] + 1, to);
        fwrite(m->flat->at, sizeof(double), 2 * (size_t)count[1], to);
    }
    if (m->picture) {
        const mesh_picture *p = m->picture;
        fwrite(p, sizeof *p, 1, to);
        fwrite(p->texel, 1, (size_t)p->width * (size_t)p->height, to);
    }
}

static int good_outline(const outline *o)
{
    for (int i = 0; i < o->loop_count; i++)
        if (o->loop[i + 1] - o->loop[i] < 3 || o->loop[i + 1] > o->point_count)
            return 0;
    for (int i = 0; i < 2 * o->point_count; i++)
        if (!isfinite(o->at[i]))
            return 0;
    return o->loop[0] == 0 && o->loop[o->loop_count] == o->point_count;
}

static int take_outline(mesh *m, const int count[COUNTS], FILE *from)
{
    if (count[0] < 0 || count[0] > POINTS_MAX || count[1] < 0 || count[1] > POINTS_MAX)
        return -1;
    if (count[0] == 0)
        return 0;
    m->flat = bake_alloc(1, sizeof *m->flat);
    m->flat->loop = isolate_get(from, (size_t)count[0] + 1, sizeof(int));
    m->flat->at = isolate_get(from, 2 * (size_t)count[1], sizeof(double));
    m->flat->loop_count = count[0];
    m->flat->point_count = count[1];
    return m->flat->loop && m->flat->at && good_outline(m->flat) ? 0 : -1;
}

static int take_picture(mesh *m, FILE *from)
{
    mesh_picture *p = m->picture = bake_alloc(1, sizeof *m->picture);
    int whole = fread(p, sizeof *p, 1, from) == 1;
    p->texel = NULL;
    if (!whole || p->width < 1 || p->width > (int)WG_TEXELS_MAX || p->height < 1 ||
        p->height > (int)WG_TEXELS_MAX || !(p->step > 0) || !isfinite(p->step) ||
        !isfinite(p->corner[0]) || !isfinite(p->corner[1]))
        return -1;
    p->texel = isolate_get(from, (size_t)p->width * (size_t)p->height, 1);
    return p->texel ? 0 : -1;
}

int mesh_flat_take(mesh *m, FILE *from)
{
    int count[COUNTS];
    if (fread(count, sizeof *count, COUNTS, from) != COUNTS ||
        fread(&m->specks, sizeof m->specks, 1, from) != 1 || take_outline(m, count, from))
        return -1;
    return count[2] ? take_picture(m, from) : 0;
}

void mesh_flat_free(mesh *m)
{
    if (m->flat)
        outline_free(m->flat);
    if (m->picture)
        free(m->picture->texel);
    free(m->flat);
    free(m->picture);
}
