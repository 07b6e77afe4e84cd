/* Triangles of a mesh file, and the colours they have.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* glTF's colours are linear, those of other files are meant for a screen. IEC 61966-2-1. */
static double to_srgb(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static unsigned char level(double value, int linear)
{
    if (!(value > 0))
        return 0;
    return (unsigned char)lround(255 * fmin(linear ? to_srgb(value) : value, 1));
}

static mesh_part read_part(const mesh_reader *r, const struct aiMaterial *material,
                           struct aiString *name)
{
    int linear = mesh_ends(r->rest.path, ".gltf") || mesh_ends(r->rest.path, ".glb");
    struct aiColor4D colour = {0.8f, 0.8f, 0.8f, 1};
    int both = 0;
    unsigned one = 1;
    mesh_part part = {0};
    aiGetMaterialColor(material, AI_MATKEY_COLOR_DIFFUSE, &colour);
    aiGetMaterialIntegerArray(material, AI_MATKEY_TWOSIDED, &both, &one);
    aiGetMaterialString(material, AI_MATKEY_NAME, name);
    part.colour[0] = level((double)colour.r, linear);
    part.colour[1] = level((double)colour.g, linear);
    part.colour[2] = level((double)colour.b, linear);
    if (r->mesh->has_colour)
        memcpy(part.colour, r->mesh->colour, sizeof part.colour);
    part.sides = r->mesh->sides > 0 ? r->mesh->sides == 2 : both != 0;
    return part;
}

/* The part of a material: materials that look alike share one. */
static int find_part(const mesh_reader *r, const struct aiMaterial *material, mesh *out)
{
    struct aiString name = {0};
    mesh_part part = read_part(r, material, &name);
    for (int i = 0; i < out->part_count; i++)
        if (memcmp(out->parts[i].colour, part.colour, sizeof part.colour) == 0 &&
            out->parts[i].sides == part.sides)
            return i;
    part.name = bake_copy(name.data);
    out->parts = bake_grow(out->parts, (size_t)out->part_count + 1, sizeof part);
    out->parts[out->part_count] = part;
    return out->part_count++;
}

/* A transformation that mirrors turns the corners' order round. */
static int mirrors(const mesh_place *place)
{
    const double(*m)[4] = place->to;
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]) <
           0;
}

static void add_triangles(const mesh_reader *r, const mesh_place *place, mesh *out)
{
    const struct aiMesh *from = place->mesh;
    int part = find_part(r, r->rest.file->mMaterials[from->mMaterialIndex], out);
    int mirrored = mirrors(place);
    size_t room = (size_t)out->triangle_count + from->mNumFaces;
    out->triangle = bake_grow(out->triangle, room, sizeof *out->triangle);
    out->part = bake_grow(out->part, room, sizeof *out->part);
    for (unsigned i = 0; i < from->mNumFaces; i++) {
        const struct aiFace *face = &from->mFaces[i];
        if (face->mNumIndices != 3) /* a point or a line */
            continue;
        int *corner = out->triangle[out->triangle_count];
        for (int j = 0; j < 3; j++)
            corner[mirrored ? 2 - j : j] = r->rest.id[place->first + (int)face->mIndices[j]];
        out->part[out->triangle_count++] = part;
    }
}

int mesh_triangles(mesh_reader *r, mesh *out)
{
    isolate_now(r->now, r->line, r->rest.path);
    r->rest.file = aiApplyPostProcessing(r->rest.file, aiProcess_Triangulate);
    if (r->rest.file == NULL)
        return mesh_fail(r, r->rest.path, "cannot be cut into triangles: %s", aiGetErrorString());
    for (int i = 0; i < r->rest.place_count; i++)
        add_triangles(r, &r->rest.places[i], out);
    if (out->part_count > (int)WG_PARTS_MAX)
        return mesh_fail(r, r->rest.path, "has %d colours; a clip holds %u", out->part_count,
                         WG_PARTS_MAX);
    return 0;
}
