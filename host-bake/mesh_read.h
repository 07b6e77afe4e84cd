/* The readers behind mesh_load. A file's vertices get ids: what has one id is one vertex of the
 * file, however often Assimp repeats it. Poses are id_count x 3 doubles, in the scene's axes and
 * units.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_MESH_READ_H
#define BAKE_MESH_READ_H

#include "isolate.h"
#include "mesh.h"

#include <assimp/scene.h>

/* Frames of one motion, and vertices times frames or shapes of one mesh: 1.6 GB of doubles. */
#define MESH_FRAMES_MAX 65535
#define MESH_PLACES_MAX 67108864.0

/* Indices of vertices and triangles have 16 bits. */
#define MESH_VERTICES_MAX 65535

/* One mesh of the file, where a node puts it. */
typedef struct {
    const struct aiMesh *mesh;
    const char *node;
    double to[3][4]; /* from the mesh's own axes to the scene's */
    int first;       /* its vertex 0 among those of all places */
} mesh_place;

typedef struct {
    const char *path;
    const struct aiScene *file;
    int place_count, vertex_count, id_count;
    int too_large; /* some vertices are not counted */
    mesh_place *places;
    int *id;      /* vertex_count */
    int ordered;  /* ids are the file's own order of vertices */
    int *polygon; /* every face of three and more corners: how many, then their ids */
    int polygon_size;
} mesh_file;

typedef struct {
    const scene *s;
    const scene_mesh *mesh;
    bake_error *error;
    int line; /* of the scene file: what asks for what is being read */
    isolate_note *now;
    mesh_file rest;
} mesh_reader;

/* "scene:line: 'path' ..." */
int mesh_fail(const mesh_reader *r, const char *path, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* Whether a path ends so, in either case: ".md2". */
int mesh_ends(const char *path, const char *extension);

/* All of a file, with a 0 behind it; nothing of one that cannot be read. */
char *mesh_read_bytes(const char *path, size_t *size);

/* Opens a file as it is at `keyframe`, untriangulated; `path` must outlive it. */
int mesh_file_open(const mesh_reader *r, const char *path, int keyframe, mesh_file *out);
void mesh_file_close(mesh_file *f);

/* What a node hierarchy places, in its order. */
void mesh_places(const mesh_reader *r, const struct aiScene *file, mesh_file *out);

/* Numbers the vertices of an OBJ file, which Assimp repeats for every corner. */
int mesh_obj_ids(const mesh_reader *r, mesh_file *f);

/* Fails unless the faces are those of r->rest. */
int mesh_file_same(const mesh_reader *r, const mesh_file *f);

/* The pose the file was opened with. */
void mesh_file_pose(const mesh_file *f, double *at);

/* Puts one point. */
void mesh_put(const mesh_place *place, const double point[3], double *at);

/* Fails if a coordinate is no finite number, or too far away for any scene; `frame` is counted from
 * 0, -1 = a pose that is no frame. */
int mesh_check_pose(const mesh_reader *r, const char *path, int frame, const double *at);

/* The frames that `motion` asks for, of `available` ones: the first and how many. Fails when some
 * are not there, or more than a bake can hold. Allots out->at. */
int mesh_range(const mesh_reader *r, const char *path, int available, const scene_motion *motion,
               mesh_frames *out);

/* Frames of one motion, as raw poses in `out`. */
int mesh_read_motion(const mesh_reader *r, const scene_motion *motion, mesh_frames *out);
int mesh_read_cache(const mesh_reader *r, const char *path, const scene_motion *motion,
                    mesh_frames *out);
int mesh_read_md3(const mesh_reader *r, const char *path, const scene_motion *motion,
                  mesh_frames *out);
int mesh_read_morph(const mesh_reader *r, const mesh_file *f, const scene_motion *motion,
                    mesh_frames *out);

/* The pose that a file shows without animation. */
void mesh_morph_rest(const mesh_file *f, double *at);

/* The pose that a morph target of r->rest stands for; `name` may be its number. */
int mesh_read_target(const mesh_reader *r, const char *name, double *at);

/* The files of a series such as run_####.obj. */
typedef struct {
    int first, count, width;
    int head; /* characters in front of the #s */
} mesh_series;
int mesh_series_find(const mesh_reader *r, const char *path, mesh_series *out);
/* The path of file `index`, counted from 0; the caller's. */
char *mesh_series_path(const char *path, const mesh_series *series, int index);

/* Triangles and parts of r->rest, in ids. */
int mesh_triangles(mesh_reader *r, mesh *out);

/* Makes vertices of ids: those that coincide in every pose become one; what no triangle with three
 * different corners uses is dropped. */
int mesh_weld(const mesh_reader *r, mesh *m);

/* Pictures and drawings (mesh_flat.c): all of the mesh but frames and shapes; what they have beside
 * other meshes, on its way to the baker; and its end. */
int mesh_is_flat(const char *path);
int mesh_flat_load(mesh_reader *r, int index, mesh *out);
void mesh_flat_send(const mesh *m, FILE *to);
int mesh_flat_take(mesh *m, FILE *from);
void mesh_flat_free(mesh *m);

/* From the process that reads meshes to the baker. mesh_take: 0, or -1 when what comes is no mesh
 * that scene.meshes[index] could be. */
void mesh_send(const mesh *m, FILE *to);
int mesh_take(const scene *s, int index, FILE *from, mesh *out);

#endif
