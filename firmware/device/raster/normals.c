/* Normals of vertices, recomputed from projected triangles.
 * Source: area-weighted sums; H. Gouraud, 1971; the scale is own.
 * SPDX-License-Identifier: MIT */
#include "normals.h"

#include <string.h>

#include "clip.h"
#include "fix.h"

/* Counts the triangles around each vertex, or adds their normals / 2^scale. */
typedef struct {
    const wg_surface *surface;
    int16_t *normals;
    bool adding;
    int bits; /* of the longest component of a normal */
    int scale;
} pass;

static void triangle_of(pass *p, const uint8_t *corners)
{
    const wg_vertex *at[3];
    int32_t normal[3];
    for (unsigned i = 0; i < 3; i++) {
        at[i] = &p->surface->vertices[wg_rd16(corners + 2u * i)];
    }
    int down = wg_view_face(p->surface->view, at, normal);
    int bits = wg_bits_3(normal) + down;
    p->bits = bits > p->bits ? bits : p->bits;
    for (unsigned i = 0; i < 3; i++) {
        int16_t *sum = p->normals + 3u * (uint32_t)wg_rd16(corners + 2u * i);
        if (!p->adding) {
            sum[0] = (int16_t)(sum[0] + (sum[0] < 32767));
            continue;
        }
        for (unsigned k = 0; k < 3; k++) {
            int32_t all = sum[k] + wg_scaled(normal[k], p->scale - down);
            sum[k] = (int16_t)fix_clamp(all, -32767, 32767);
        }
    }
}

static void all_triangles(pass *p)
{
    const wg_file *file = p->surface->file;
    for (uint16_t i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
        const uint8_t *part = wg_record(file, WG_SECTION_PARTS, i, WG_PART_BYTES);
        if (wg_rd16(part + WG_PART_SHAPE) != p->surface->shape) {
            continue;
        }
        const uint8_t *corners = file->section[WG_SECTION_DATA].at + wg_rd32(part + WG_PART_DATA);
        uint16_t count = wg_rd16(part + WG_PART_TRIANGLES);
        for (uint16_t k = 0; k < count; k++, corners += WG_TRIANGLE_BYTES) {
            triangle_of(p, corners);
        }
    }
}

void wg_normals_make(const wg_surface *surface, int16_t *normals)
{
    pass p = {surface, normals, false, 0, 0};
    uint32_t components = 3u * (uint32_t)surface->count;
    uint32_t around = 0;
    memset(normals, 0, (size_t)components * sizeof *normals);
    all_triangles(&p);
    for (uint32_t i = 0; i < components; i += 3) {
        around |= (uint16_t)normals[i];
    }
    memset(normals, 0, (size_t)components * sizeof *normals);
    /* (2^n - 1) triangles of at most 2^bits each, over 2^scale: at most 2^15 - 2^(15 - n). */
    p.scale = p.bits + wg_bits(around) - 15;
    p.adding = true;
    all_triangles(&p);
}
