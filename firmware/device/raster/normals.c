/* Normals of vertices, recomputed from projected triangles.
 * Source: area-weighted sums; H. Gouraud, 1971; the scale is own.
 * SPDX-License-Identifier: MIT */
#include "normals.h"

#include <string.h>

#include "clip.h"
#include "fix.h"

#define SLICE 32u

/* Counts a triangle at its corners, or adds its normal / 2^scale there. */
static void triangle_of(const wg_surface *surface, wg_normals *n, const uint8_t *corners,
                        int16_t *normals)
{
    const wg_vertex *at[3];
    int32_t normal[3];
    for (unsigned i = 0; i < 3; i++) {
        at[i] = &surface->vertices[wg_rd16(corners + 2u * i)];
    }
    uint8_t down = (uint8_t)wg_view_face(surface->view, at, normal);
    uint8_t bits = (uint8_t)(wg_bits_3(normal) + down);
    n->bits = bits > n->bits ? bits : n->bits;
    for (unsigned i = 0; i < 3; i++) {
        int16_t *sum = normals + 3u * (uint32_t)wg_rd16(corners + 2u * i);
        if (!n->adding) {
            sum[0] = (int16_t)(sum[0] + (sum[0] < 32767));
            continue;
        }
        for (unsigned k = 0; k < 3; k++) {
            int32_t all = sum[k] + wg_scaled(normal[k], (int16_t)(n->scale - down));
            sum[k] = (int16_t)fix_clamp(all, -32767, 32767);
        }
    }
}

/* Up to SLICE triangles more; whether there are others. */
static bool slice(const wg_surface *surface, wg_normals *n, int16_t *normals)
{
    const wg_file *file = surface->file;
    uint8_t left = SLICE;
    for (; n->part < file->section[WG_SECTION_PARTS].count; n->part++, n->triangle = 0) {
        const uint8_t *part = wg_record(file, WG_SECTION_PARTS, n->part, WG_PART_BYTES);
        if (wg_rd16(part + WG_PART_SHAPE) != surface->shape) {
            continue;
        }
        const uint8_t *corners = file->section[WG_SECTION_DATA].at + wg_rd32(part + WG_PART_DATA);
        for (; n->triangle < wg_rd16(part + WG_PART_TRIANGLES); n->triangle++, left--) {
            if (left == 0) {
                return true;
            }
            triangle_of(surface, n, corners + (uint32_t)n->triangle * WG_TRIANGLE_BYTES, normals);
        }
    }
    return false;
}

/* From counts to sums. (2^n - 1) triangles of at most 2^bits each, over 2^scale: at most
 * 2^15 - 2^(15 - n). */
static void start_adding(const wg_surface *surface, wg_normals *n, const int16_t *normals)
{
    uint32_t around = 0;
    for (uint32_t i = 0; i < surface->count; i++) {
        around |= (uint16_t)normals[3u * i];
    }
    n->scale = (int16_t)(n->bits + wg_bits(around) - 15);
    n->adding = true;
    n->part = 0;
    n->triangle = 0;
}

bool wg_normals_step(const wg_surface *surface, wg_normals *at, int16_t *normals)
{
    if (at->part == 0 && at->triangle == 0) {
        memset(normals, 0, 3u * (size_t)surface->count * sizeof *normals);
    }
    if (slice(surface, at, normals)) {
        return true;
    }
    if (at->adding) {
        return false;
    }
    start_adding(surface, at, normals);
    return true;
}
