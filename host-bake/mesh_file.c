/* One mesh file through Assimp: where its nodes put the vertices, and its faces.
 *
 * What Assimp delivers, measured with 5.2.5 against the files: vertices that share a place in an
 * OBJ, MD2, MD3 or STL file come once a corner, those of PLY, OFF and glTF come in the file's order;
 * MD2 and MD3 files have z upwards and look along x, and a rotation of the root node makes y of z;
 * the order of corners is turned so that they run counter-clockwise.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <assimp/cimport.h>
#include <assimp/config.h>

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* From 16-bit coordinates in steps of at most 2^8. */
static const double farthest = 1e6;

typedef struct {
    double at[3][4];
} transform;

int mesh_fail(const mesh_reader *r, const char *path, const char *format, ...)
{
    char what[600];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return bake_fail(r->error, "%s:%d: '%s' %s", r->s->path, r->line, path, what);
}

int mesh_ends(const char *path, const char *extension)
{
    size_t length = strlen(path), tail = strlen(extension);
    return length >= tail && strcasecmp(path + length - tail, extension) == 0;
}

char *mesh_read_bytes(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    long length = file != NULL && fseek(file, 0, SEEK_END) == 0 ? ftell(file) : 0;
    char *bytes = bake_alloc((size_t)(length > 0 ? length : 0) + 1, 1);
    *size = 0;
    if (file != NULL) {
        rewind(file);
        *size = length > 0 ? fread(bytes, 1, (size_t)length, file) : 0;
        fclose(file);
    }
    bytes[*size] = '\0';
    return bytes;
}

/* a b */
static transform product(const transform *a, const transform *b)
{
    transform out;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            out.at[i][j] = j == 3 ? a->at[i][3] : 0;
            for (int k = 0; k < 3; k++)
                out.at[i][j] += a->at[i][k] * b->at[k][j];
        }
    return out;
}

static transform from_assimp(const struct aiMatrix4x4 *m)
{
    return (transform){{{(double)m->a1, (double)m->a2, (double)m->a3, (double)m->a4},
                        {(double)m->b1, (double)m->b2, (double)m->b3, (double)m->b4},
                        {(double)m->c1, (double)m->c2, (double)m->c3, (double)m->c4}}};
}

/* Recursion is as deep as the file's nodes; Assimp's own walk over them is recursive as well. */
static void place_node(mesh_file *out, const struct aiScene *file, const struct aiNode *node,
                       const transform *above)
{
    transform own = from_assimp(&node->mTransformation), to = product(above, &own);
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= file->mNumMeshes || file->mMeshes[node->mMeshes[i]] == NULL)
            continue; /* what an MD3 file's empty surface leaves */
        mesh_place place = {.mesh = file->mMeshes[node->mMeshes[i]],
                            .node = node->mName.data,
                            .first = out->vertex_count};
        memcpy(place.to, to.at, sizeof place.to);
        if (place.mesh->mNumVertices > MESH_PLACES_MAX - out->vertex_count) {
            out->too_large = 1;
            return;
        }
        out->places = bake_grow(out->places, (size_t)out->place_count + 1, sizeof place);
        out->places[out->place_count++] = place;
        out->vertex_count += (int)place.mesh->mNumVertices;
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        place_node(out, file, node->mChildren[i], &to);
}

void mesh_places(const mesh_reader *r, const struct aiScene *file, mesh_file *out)
{
    double s = r->mesh->scale;
    transform y_up = {{{s, 0, 0, 0}, {0, s, 0, 0}, {0, 0, s, 0}}};
    transform z_up = {{{s, 0, 0, 0}, {0, 0, s, 0}, {0, -s, 0, 0}}};
    if (file->mRootNode != NULL)
        place_node(out, file, file->mRootNode, r->mesh->up == 'z' ? &z_up : &y_up);
}

static void number_vertices(mesh_file *f)
{
    f->id_count = f->vertex_count;
    for (int i = 0; i < f->vertex_count; i++)
        f->id[i] = i;
    /* These have one mesh, and Assimp keeps its order. */
    f->ordered = f->place_count == 1 && (mesh_ends(f->path, ".ply") || mesh_ends(f->path, ".off"));
}

static int add_polygon(mesh_file *f, int *room, const mesh_place *place, const struct aiFace *face)
{
    int corners = (int)face->mNumIndices;
    if (corners < 3) /* a point or a line */
        return 0;
    if (f->polygon_size + corners + 1 > *room) {
        *room = 2 * *room + corners + 1;
        f->polygon = bake_grow(f->polygon, (size_t)*room, sizeof(int));
    }
    f->polygon[f->polygon_size++] = corners;
    for (int i = 0; i < corners; i++) {
        if (face->mIndices[i] >= place->mesh->mNumVertices)
            return -1;
        f->polygon[f->polygon_size++] = f->id[place->first + (int)face->mIndices[i]];
    }
    return 0;
}

static int add_polygons(const mesh_reader *r, mesh_file *f)
{
    int room = 0;
    for (int i = 0; i < f->place_count; i++)
        for (unsigned j = 0; j < f->places[i].mesh->mNumFaces; j++)
            if (add_polygon(f, &room, &f->places[i], &f->places[i].mesh->mFaces[j]))
                return mesh_fail(r, f->path, "has a face with a vertex that is not there");
    return f->polygon_size > 0 ? 0 : mesh_fail(r, f->path, "has no faces");
}

static int number_and_list(const mesh_reader *r, mesh_file *f)
{
    mesh_places(r, f->file, f);
    if (f->too_large)
        return mesh_fail(r, f->path, "has more than %.0f vertices: reduce it", MESH_PLACES_MAX);
    if (f->vertex_count == 0)
        return mesh_fail(r, f->path, "holds no mesh");
    f->id = bake_alloc((size_t)f->vertex_count, sizeof(int));
    number_vertices(f);
    if (mesh_ends(f->path, ".obj") && mesh_obj_ids(r, f))
        return -1;
    return add_polygons(r, f);
}

int mesh_file_open(const mesh_reader *r, const char *path, int keyframe, mesh_file *out)
{
    *out = (mesh_file){.path = path};
    struct aiPropertyStore *settings = aiCreatePropertyStore();
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_GLOBAL_KEYFRAME, keyframe);
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, 0);
    /* Otherwise lower.md3 brings head.md3 and upper.md3 along. */
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_MD3_HANDLE_MULTIPART, 0);
    isolate_now(r->now, r->line, path);
    out->file = aiImportFileExWithProperties(path, 0, NULL, settings);
    aiReleasePropertyStore(settings);
    if (out->file == NULL) {
        isolate_complaint(aiGetErrorString());
        return mesh_fail(r, path, "cannot be read: %s", aiGetErrorString());
    }
    if (number_and_list(r, out)) {
        mesh_file_close(out);
        return -1;
    }
    return 0;
}

void mesh_file_close(mesh_file *f)
{
    if (f->file != NULL)
        aiReleaseImport(f->file);
    free(f->places);
    free(f->id);
    free(f->polygon);
    *f = (mesh_file){0};
}

int mesh_file_same(const mesh_reader *r, const mesh_file *f)
{
    const mesh_file *rest = &r->rest;
    if (f->id_count != rest->id_count)
        return mesh_fail(r, f->path, "has %d vertices, '%s' has %d; frames must have the same ones",
                         f->id_count, rest->path, rest->id_count);
    int face = 0;
    for (int i = 0; i < f->polygon_size && i < rest->polygon_size; face++) {
        size_t words = (size_t)f->polygon[i] + 1;
        if (f->polygon[i] != rest->polygon[i] ||
            memcmp(&f->polygon[i], &rest->polygon[i], words * sizeof(int)) != 0)
            return mesh_fail(r, f->path,
                             "has other corners than '%s' in face %d, counted from 0; frames must "
                             "have the same faces in the same order",
                             rest->path, face);
        i += (int)words;
    }
    if (f->polygon_size != rest->polygon_size)
        return mesh_fail(
            r, f->path, "has %s faces than '%s'; frames must have the same faces in the same order",
            f->polygon_size > rest->polygon_size ? "more" : "fewer", rest->path);
    return 0;
}

void mesh_put(const mesh_place *place, const double point[3], double *at)
{
    for (int i = 0; i < 3; i++) {
        const double *row = place->to[i];
        /* + 0: -0 and 0 are one place */
        at[i] = row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + row[3] + 0.0;
    }
}

void mesh_file_pose(const mesh_file *f, double *at)
{
    for (int i = 0; i < f->place_count; i++) {
        const mesh_place *place = &f->places[i];
        for (int j = 0; j < (int)place->mesh->mNumVertices; j++) {
            const struct aiVector3D *v = &place->mesh->mVertices[j];
            double point[3] = {(double)v->x, (double)v->y, (double)v->z};
            mesh_put(place, point, at + 3 * (size_t)f->id[place->first + j]);
        }
    }
}

int mesh_check_pose(const mesh_reader *r, const char *path, int frame, const double *at)
{
    char where[32] = "";
    if (frame >= 0)
        snprintf(where, sizeof where, " of frame %d", frame);
    for (size_t i = 0; i < 3 * (size_t)r->rest.id_count; i++) {
        if (!isfinite(at[i]))
            return mesh_fail(r, path, "has no finite number as place of vertex %zu%s", i / 3,
                             where);
        if (fabs(at[i]) > farthest)
            return mesh_fail(r, path, "has vertex %zu%s at %g, too far away; use 'scale'", i / 3,
                             where, at[i]);
    }
    return 0;
}
