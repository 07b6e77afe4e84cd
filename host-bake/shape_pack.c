/* Shapes, parts and views as bytes.
 * Source: SPEC 4.13-4.17, 6.8. Paints: paint_pack.c.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "paint_pack.h"

#include "wiggly_format.h"

#include <math.h>
#include <string.h>

/* One value of w moves the vertex that moves most by (32767 or 32512)/32768 raw units (SPEC 6.8). */
static double weights_a_raw(const build *b, const shape_form *form, const shape_basis *basis)
{
    double largest = form->bits == 8 ? 127.0 * 256 : 32767.0;
    return ldexp(basis->scale, form->frac - b->frac[basis->channel]) * 32768 / largest;
}

static int pack_basis(const build *b, const shape_form *form, const shape_basis *basis, packed *out,
                      bake_error *error)
{
    double ratio = weights_a_raw(b, form, basis);
    int shift = 15;
    while (shift > 1 && ldexp(ratio, 16 + shift) > 32767) {
        shift--;
    }
    double gain = floor(ldexp(ratio, 16 + shift) + 0.5);
    if (gain > 32767) {
        return bake_fail(error,
                         "%s: channel %s is too coarse for the shape that it moves, by %g: give "
                         "it a smaller `range`, or the mesh a larger scale",
                         b->scene->path, b->scene->channels[basis->channel].name, gain / 32767);
    }
    bytes *o = &out->at[WG_SECTION_BASES];
    put16(o, (uint32_t)basis->channel);
    put16(o, (uint32_t)gain);
    put8(o, (uint32_t)shift);
    put8(o, 0);
    put16(o, 0);
    out->count[WG_SECTION_BASES]++;
    return 0;
}

/* Component i of a basis; an odd block in 8 bits has one more, which is 0. */
static void put_entry(const int16_t *entry, int bits, const int i[2], bytes *data)
{
    int value = i[0] < i[1] ? entry[i[0]] : 0;
    if (bits == 8) {
        put8(data, (uint32_t)(value / 256) & 255u);
    } else {
        put16(data, (uint32_t)value & 65535u);
    }
}

/* The table of SPEC 4.15. */
static void put_entries(const shape_form *form, const shape_block *block, bytes *data)
{
    int bits = shape_block_bits(form, block);
    int n = 3 * block->count, group = bits == 8 && block->b >= 0 ? 2 : 1;
    for (int i = 0; i < n; i += group) {
        for (int half = 0; half < (block->b >= 0 ? 2 : 1); half++) {
            for (int k = 0; k < group; k++) {
                const int at[2] = {i + k, n};
                const shape_basis *basis = &form->basis[half ? block->b : block->a];
                put_entry(basis->entry + 3 * block->first, bits, at, data);
            }
        }
    }
}

static void pack_block(const shape_form *form, const shape_block *block, packed *out)
{
    bytes *o = &out->at[WG_SECTION_BLOCKS], *data = &out->at[WG_SECTION_DATA];
    put_align(data, 4);
    put16(o, (uint32_t)block->a);
    put16(o, block->b < 0 ? WG_ABSENT : (uint32_t)block->b);
    put16(o, (uint32_t)block->first);
    put16(o, (uint32_t)block->count);
    put8(o, (uint32_t)shape_block_bits(form, block));
    put8(o, 0);
    put16(o, 0);
    put32(o, (uint32_t)data->count);
    put_entries(form, block, data);
    out->count[WG_SECTION_BLOCKS]++;
}

static int pack_form(const build *b, const shape_form *form, packed *out, bake_error *error)
{
    bytes *o = &out->at[WG_SECTION_SHAPES], *data = &out->at[WG_SECTION_DATA];
    put_align(data, 4);
    put16(o, (uint32_t)form->vertex_count);
    put8(o, (uint32_t)form->frac & 255u);
    put8(o, 0);
    put16(o, (uint32_t)out->count[WG_SECTION_BASES]);
    put16(o, (uint32_t)form->basis_count);
    put16(o, (uint32_t)out->count[WG_SECTION_BLOCKS]);
    put16(o, (uint32_t)form->block_count);
    put16(o, form->affine < 0 ? WG_ABSENT : (uint32_t)form->affine);
    put16(o, 0);
    put32(o, (uint32_t)data->count);
    for (int k = 0; k < 3; k++) { /* with an affine part, its translation holds the origin */
        double origin = form->affine < 0 ? form->origin[k] : 0;
        put32(o, (uint32_t)(int32_t)lround(ldexp(origin, form->frac)));
    }
    for (int i = 0; i < 3 * form->vertex_count; i++) {
        put16(data, (uint32_t)form->rest[i] & 65535u);
    }
    for (int j = 0; j < form->basis_count; j++) {
        if (pack_basis(b, form, &form->basis[j], out, error) < 0) {
            return -1;
        }
    }
    for (int i = 0; i < form->block_count; i++) {
        pack_block(form, &form->block[i], out);
    }
    out->count[WG_SECTION_SHAPES]++;
    return 0;
}

static void pack_part(const shape_mesh *m, int part, int shape, packed *out)
{
    bytes *o = &out->at[WG_SECTION_PARTS], *data = &out->at[WG_SECTION_DATA];
    const mesh_part *p = &m->mesh.parts[part];
    int count = 0;
    put_align(data, 2);
    uint32_t at = (uint32_t)data->count;
    for (int t = 0; t < m->mesh.triangle_count; t++) {
        for (int k = 0; k < 3 && m->mesh.part[t] == part; k++) {
            put16(data, (uint32_t)m->mesh.triangle[t][k]);
        }
        count += m->mesh.part[t] == part;
    }
    if (count == 0) {
        return;
    }
    put16(o, (uint32_t)shape);
    put16(o, m->has_normals ? (uint32_t)shape + 1 : WG_ABSENT);
    put16(o, (uint32_t)count);
    put8(o, (uint32_t)p->sides);
    put8(o, 0);
    put_copy(o, p->colour, 3);
    put8(o, 0);
    put32(o, at);
    out->count[WG_SECTION_PARTS]++;
}

static int pack_mesh(const build *b, const shape_mesh *m, packed *out, bake_error *error)
{
    int shape = out->count[WG_SECTION_SHAPES];
    if (pack_form(b, &m->form, out, error) < 0 ||
        (m->has_normals && pack_form(b, &m->normals, out, error) < 0)) {
        return -1;
    }
    for (int i = 0; i < m->mesh.part_count; i++) {
        int before = out->count[WG_SECTION_PARTS];
        pack_part(m, i, shape, out);
        if (out->count[WG_SECTION_PARTS] > before) { /* it has triangles */
            paint_pack(b, m, out);
        }
    }
    return 0;
}

static uint32_t signed8(double x)
{
    return (uint32_t)(int32_t)lround(127 * x) & 255u;
}

static void pack_views(const scene *s, packed *out)
{
    bytes *o = &out->at[WG_SECTION_VIEWS];
    for (int i = 0; i < s->view_count; i++) {
        const scene_view *v = &s->views[i];
        put8(o, (uint32_t)v->projection);
        put8(o, (uint32_t)v->shading);
        put8(o, (uint32_t)lround(255 * v->ambient));
        put8(o, 0);
        for (int k = 0; k < 3; k++) {
            put8(o, signed8(v->light[k]));
        }
        put8(o, 0);
        put_copy(o, v->background, 3);
        put8(o, 0);
        for (int k = 0; k < (int)WG_VIEW_CHANNELS; k++) {
            put16(o, (uint32_t)v->channel[k]);
        }
    }
    out->count[WG_SECTION_VIEWS] = s->view_count;
}

static int check_limits(const scene *s, const packed *out, bake_error *error)
{
    static const struct {
        unsigned kind, most;
        const char *what, *help;
    } LIMIT[] = {
        {WG_SECTION_SHAPES, WG_SHAPES_MAX, "shapes", "fewer meshes, or `normals: none`"},
        {WG_SECTION_PARTS, WG_PARTS_MAX, "parts", "fewer meshes, or one `colour` for each"},
    };
    for (size_t i = 0; i < sizeof LIMIT / sizeof *LIMIT; i++) {
        if (out->count[LIMIT[i].kind] > (int)LIMIT[i].most) {
            return bake_fail(error, "%s: %d %s, the format has room for %u: use %s", s->path,
                             out->count[LIMIT[i].kind], LIMIT[i].what, LIMIT[i].most,
                             LIMIT[i].help);
        }
    }
    return 0;
}

int shapes_pack(const build *b, packed *out, bake_error *error)
{
    for (int i = 0; b->shapes && i < b->shapes->count; i++) {
        if (pack_mesh(b, &b->shapes->mesh[i], out, error) < 0) {
            return -1;
        }
    }
    pack_views(b->scene, out);
    return check_limits(b->scene, out, error);
}
