/* Weights that a file has for its vertices, on the mesh that the baker made of them.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"
#include "rig_file.h"
#include "rig_file_parts.h"
#include "scene_names.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the mesh's size: how far apart a vertex's places in the file and in the mesh may be. */
static const double same_place = 1e-6;

/* Sums of weights need not be 1, but these are not what somebody made: Assimp 5.2.5 takes the bytes
 * and words of glTF's normalised weights for floats. */
static const double least_sum = 1e-3, most_sum = 16;

/*   w      vertex_count x bone_count, column by column
 *   first  of each id: a vertex that has its weights, next[] the one after it; -1: none */
typedef struct {
    const scene *s;
    const scene_rig *rig;
    const char *path;
    const mesh *m;
    double *w;
    mesh_reader r;
    rig_nodes nodes;
    file_bones list;
    double *at, *total; /* of each id: its place, the sum of its weights */
    int *first, *next;
} weighing;

/* The rig's bone that a node of the file is: by the name that its bones get, or by `node`. */
static int bone_of_node(const weighing *q, const char *name)
{
    for (int i = 0; i < q->list.count; i++) {
        if (strcmp(q->nodes.node[q->list.bone[i].node].name, name) == 0) {
            scene_names bones = SCENE_NAMES(q->rig->bones, q->rig->bone_count);
            int found = scene_names_find(&bones, q->list.bone[i].name);
            if (found >= 0) {
                return found;
            }
        }
    }
    for (int i = 0; i < q->rig->bone_count; i++) {
        if (q->rig->bones[i].node != NULL && strcmp(q->rig->bones[i].node, name) == 0) {
            return i;
        }
    }
    return -1;
}

/* The bone that a mesh without weights hangs on, or -1. */
static int bone_above(const weighing *q, const char *node)
{
    int bone = -1;
    for (int i = rig_nodes_find(&q->nodes, node); i >= 0 && bone < 0; i = q->nodes.node[i].parent) {
        bone = bone_of_node(q, q->nodes.node[i].name);
    }
    return bone;
}

/* ---- every weight of the file once ----------------------------------------------------------- */

typedef void weight_use(weighing *q, int bone, int id, double weight);

static int id_of(const weighing *q, const mesh_place *place, unsigned vertex)
{
    return q->r.rest.id[place->first + (int)vertex];
}

static int each_of_bone(weighing *q, const mesh_place *place, const struct aiBone *from,
                        weight_use *use)
{
    int bone = bone_of_node(q, from->mName.data);
    for (unsigned i = 0; i < from->mNumWeights; i++) {
        const struct aiVertexWeight *weight = &from->mWeights[i];
        if (!(weight->mWeight > 0)) {
            continue;
        }
        if (bone < 0) {
            return mesh_fail(&q->r, q->path,
                             "has vertices that follow '%.60s', no bone of the rig "
                             "'%s'; add it to 'bones', or solve for weights",
                             from->mName.data, q->rig->name);
        }
        if (weight->mVertexId >= place->mesh->mNumVertices || !isfinite(weight->mWeight)) {
            return mesh_fail(&q->r, q->path,
                             "has a weight of '%.60s' that is no number, or of a "
                             "vertex that is not there",
                             from->mName.data);
        }
        use(q, bone, id_of(q, place, weight->mVertexId), (double)weight->mWeight);
    }
    return 0;
}

static int each_weight(weighing *q, weight_use *use)
{
    for (int i = 0; i < q->r.rest.place_count; i++) {
        const mesh_place *place = &q->r.rest.places[i];
        const struct aiMesh *from = place->mesh;
        int all = from->mNumBones == 0 ? bone_above(q, place->node) : -1;
        for (unsigned k = 0; k < from->mNumVertices && all >= 0; k++) {
            use(q, all, id_of(q, place, k), 1);
        }
        for (unsigned k = 0; k < from->mNumBones; k++) {
            if (each_of_bone(q, place, from->mBones[k], use)) {
                return -1;
            }
        }
    }
    return 0;
}

static void add_total(weighing *q, int bone, int id, double weight)
{
    (void)bone;
    q->total[id] += weight;
}

static void add_weight(weighing *q, int bone, int id, double weight)
{
    size_t column = (size_t)bone * (size_t)q->m->vertex_count;
    for (int v = q->first[id]; v >= 0; v = q->next[v]) {
        q->w[column + (size_t)v] += weight / q->total[id];
    }
}

/* ---- places ---------------------------------------------------------------------------------- */

typedef struct {
    double key;
    int id;
} sorted;

static int by_key(const void *a, const void *b)
{
    double x = ((const sorted *)a)->key, y = ((const sorted *)b)->key;
    return (x > y) - (x < y);
}

/* Along a direction that no modeller uses: planes of equal keys are no planes of vertices. */
static double key_of(const double at[3])
{
    return 0.5436 * at[0] + 0.6981 * at[1] + 0.4661 * at[2];
}

static double size_of(const mesh *m)
{
    double size = 0;
    for (int k = 0; k < 3; k++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (int i = 0; i < m->vertex_count; i++) {
            low = fmin(low, m->rest[3 * i + k]);
            high = fmax(high, m->rest[3 * i + k]);
        }
        size = fmax(size, high - low);
    }
    return size;
}

/* The id at a place, one with weights if there is one; -1: none. */
static int find_id(const weighing *q, const sorted *list, const double at[3], double tolerance)
{
    double key = key_of(at);
    int low = 0, high = q->r.rest.id_count, found = -1;
    while (low < high) { /* bisection */
        int middle = (low + high) / 2;
        if (list[middle].key < key - 2 * tolerance) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    for (; low < q->r.rest.id_count && list[low].key <= key + 2 * tolerance; low++) {
        const double *other = q->at + 3 * (size_t)list[low].id;
        if (fabs(other[0] - at[0]) <= tolerance && fabs(other[1] - at[1]) <= tolerance &&
            fabs(other[2] - at[2]) <= tolerance) {
            found = list[low].id;
            if (q->total[found] > least_sum) {
                break;
            }
        }
    }
    return found;
}

/* A vertex of the mesh and what the file has there. */
static int check_vertex(const weighing *q, int v, int id)
{
    const double *at = q->m->rest + 3 * (size_t)v;
    const char *what = "does not have", *advice = "use 'weights: file' with the mesh's own file";
    double sum = id >= 0 ? q->total[id] : 0;
    if (sum > least_sum && sum < most_sum) {
        return 0;
    }
    if (id >= 0) {
        what = sum > 0 ? "has weights that sum to nonsense for" : "has no weights for";
        advice = sum > 0 ? "of glTF, export them as floats"
                         : "give it some, or let the baker solve for weights";
    }
    return mesh_fail(&q->r, q->path, "%s vertex %d of the mesh '%s', at (%g, %g, %g); %s", what, v,
                     q->r.mesh->name, at[0], at[1], at[2], advice);
}

static int own_vertices(weighing *q)
{
    int ids = q->r.rest.id_count, err = 0;
    double tolerance = same_place * size_of(q->m);
    sorted *list = bake_alloc((size_t)ids, sizeof *list);
    for (int i = 0; i < ids; i++) {
        list[i] = (sorted){key_of(q->at + 3 * (size_t)i), i};
        q->first[i] = -1;
    }
    qsort(list, (size_t)ids, sizeof *list, by_key);
    for (int v = 0; v < q->m->vertex_count && err == 0; v++) {
        int id = find_id(q, list, q->m->rest + 3 * (size_t)v, tolerance);
        err = check_vertex(q, v, id);
        if (err == 0) {
            q->next[v] = q->first[id];
            q->first[id] = v;
        }
    }
    free(list);
    return err;
}

/* ---- the process ----------------------------------------------------------------------------- */

static int weigh(weighing *q)
{
    size_t ids = (size_t)q->r.rest.id_count;
    affine world = file_world(q->r.mesh);
    rig_nodes_make(q->r.rest.file, &world, &q->nodes);
    file_bones_list(&q->nodes, file_name_longest(q->rig), &q->list);
    q->at = bake_alloc(ids, 3 * sizeof *q->at);
    q->total = bake_alloc(ids, sizeof *q->total);
    q->first = bake_alloc(ids, sizeof *q->first);
    q->next = bake_alloc((size_t)q->m->vertex_count, sizeof *q->next);
    mesh_morph_rest(&q->r.rest, q->at);
    return mesh_check_pose(&q->r, q->path, -1, q->at) || each_weight(q, add_total) ||
                   own_vertices(q) || each_weight(q, add_weight)
               ? -1
               : 0;
}

static int read_here(void *what, isolate_note *now, bake_error *error)
{
    weighing *q = what;
    q->r.error = error;
    q->r.now = now;
    if (mesh_file_open(&q->r, q->path, 0, &q->r.rest)) {
        return -1;
    }
    int err = weigh(q);
    mesh_file_close(&q->r.rest);
    rig_nodes_free(&q->nodes);
    file_bones_free(&q->list);
    free(q->at);
    free(q->total);
    free(q->first);
    free(q->next);
    return err;
}

static void send(const void *what, FILE *to)
{
    const weighing *q = what;
    fwrite(q->w, sizeof *q->w, (size_t)q->m->vertex_count * (size_t)q->rig->bone_count, to);
}

static int take(void *what, FILE *from)
{
    weighing *q = what;
    size_t size = (size_t)q->m->vertex_count * (size_t)q->rig->bone_count;
    if (fread(q->w, sizeof *q->w, size, from) != size) {
        return -1;
    }
    for (int v = 0; v < q->m->vertex_count; v++) {
        double sum = 0;
        for (int i = 0; i < q->rig->bone_count; i++) {
            double w = q->w[(size_t)i * (size_t)q->m->vertex_count + (size_t)v];
            sum += w >= 0 ? w : -1;
        }
        if (!(fabs(sum - 1) < 1e-6)) {
            return -1;
        }
    }
    return 0;
}

int rig_file_weights(const scene *s, int rig, const mesh *m, double *w, bake_error *error)
{
    const scene_mesh *from = &s->meshes[s->rigs[rig].mesh];
    weighing q = {.s = s, .rig = &s->rigs[rig], .path = s->rigs[rig].file, .m = m, .w = w};
    if (q.path == NULL) {
        q.path = from->file;
    }
    q.r = (mesh_reader){.s = s, .mesh = from, .line = q.rig->line};
    memset(w, 0, (size_t)m->vertex_count * (size_t)q.rig->bone_count * sizeof *w);
    const isolate_job job = {s->path, &q, read_here, send, take};
    return isolate(&job, error);
}
