/* Nodes of a file: hierarchy, bind pose, keys.
 * Source: own. That vertices follow G(t) offset and the file draws them at rest at N, so that a
 * bone's bind pose is N offset^-1, is how Assimp has it for every format.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_nodes.h"

#include "isolate.h"

#include <assimp/cimport.h>
#include <assimp/config.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Assimp leaves 0 where a format says nothing; 25 is what its own tools then use. */
static const double default_ticks = 25;

/* A scaling by 0 hides a thing; which way it is turned is still asked for. */
static const double scaling_least = 1e-6;

const struct aiScene *rig_nodes_open(const char *path)
{
    struct aiPropertyStore *settings = aiCreatePropertyStore();
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    /* Otherwise an FBX joint is a chain of helper nodes, none of which has the joint's name. */
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, 0);
    const struct aiScene *file = aiImportFileExWithProperties(path, 0, NULL, settings);
    aiReleasePropertyStore(settings);
    if (file == NULL) {
        isolate_complaint(aiGetErrorString());
    }
    return file;
}

/* ---- the list -------------------------------------------------------------------------------- */

static void split(const struct aiNode *from, rig_node *to)
{
    struct aiVector3D scaling, position;
    struct aiQuaternion rotation;
    aiDecomposeMatrix(&from->mTransformation, &scaling, &rotation, &position);
    const double parts[3][4] = {
        {(double)position.x, (double)position.y, (double)position.z, 0},
        {(double)rotation.w, (double)rotation.x, (double)rotation.y, (double)rotation.z},
        {(double)scaling.x, (double)scaling.y, (double)scaling.z, 0}};
    memcpy(to->still, parts, sizeof parts);
}

static void normalise(double q[4])
{
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; k++) {
        q[k] /= length;
    }
}

static void add_node(rig_nodes *n, const struct aiNode *from, int parent)
{
    rig_node *to = &n->node[n->count++];
    to->name = from->mName.data;
    to->parent = parent;
    to->own = affine_of(&from->mTransformation);
    split(from, to);
    normalise(to->still[1]);
}

static int count_nodes(const struct aiNode *node)
{
    int count = 1;
    for (unsigned i = 0; i < node->mNumChildren; i++) {
        count += count_nodes(node->mChildren[i]);
    }
    return count;
}

/* Breadth first: a queue that is kept. */
static const struct aiNode **list(const struct aiNode *root, rig_nodes *n)
{
    int count = count_nodes(root);
    const struct aiNode **from = bake_alloc((size_t)count, sizeof *from);
    n->node = bake_alloc((size_t)count, sizeof *n->node);
    from[0] = root;
    add_node(n, root, -1);
    for (int i = 0; i < n->count; i++) {
        for (unsigned k = 0; k < from[i]->mNumChildren; k++) {
            from[n->count] = from[i]->mChildren[k];
            add_node(n, from[i]->mChildren[k], i);
        }
    }
    return from;
}

int rig_nodes_find(const rig_nodes *n, const char *name)
{
    for (int i = 0; i < n->count; i++) {
        if (strcmp(n->node[i].name, name) == 0) {
            return i;
        }
    }
    return -1;
}

/* The bones of a mesh that a node places. */
static void bind_mesh(rig_nodes *n, const struct aiMesh *mesh, const affine *place)
{
    for (unsigned i = 0; i < mesh->mNumBones; i++) {
        int node = rig_nodes_find(n, mesh->mBones[i]->mName.data);
        affine offset = affine_of(&mesh->mBones[i]->mOffsetMatrix), back;
        if (node < 0 || n->node[node].skinned || affine_inverse(&offset, &back)) {
            continue;
        }
        n->node[node].skinned = 1;
        n->node[node].bind = affine_product(place, &back);
    }
}

/* How far a node at `at` would have its bound children from where they are. */
static double distance(const rig_nodes *n, int node, const affine *at, const char *bound)
{
    double sum = 0;
    for (int i = node + 1; i < n->count; i++) {
        if (n->node[i].parent == node && bound[i]) {
            affine there = affine_product(at, &n->node[i].own);
            for (int k = 0; k < 3; k++) {
                sum += fabs(there.at[k][3] - n->node[i].bind.at[k][3]);
            }
        }
    }
    return sum;
}

/* A node above bound ones: turned as in the file, or as any of them has it, whichever has all of
 * them where they are best. An animated file may show it anywhere. */
static void bind_above(rig_nodes *n, int node, const affine *rest, const char *bound)
{
    double least = HUGE_VAL;
    for (int i = node + 1; i < n->count; i++) {
        affine back, tried = rest[node];
        if (n->node[i].parent != node || !bound[i]) {
            continue;
        }
        for (int way = 0; way < 2; way++) {
            if (way == 1 && affine_inverse(&n->node[i].own, &back) == 0) {
                tried = affine_product(&n->node[i].bind, &back);
            }
            affine there = affine_product(&tried, &n->node[i].own);
            for (int k = 0; k < 3; k++) {
                tried.at[k][3] += n->node[i].bind.at[k][3] - there.at[k][3];
            }
            double apart = distance(n, node, &tried, bound);
            if (apart < least) {
                least = apart;
                n->node[node].bind = tried;
            }
        }
    }
}

/* The bind poses of nodes that no vertex follows. */
static void bind_others(rig_nodes *n, const affine *rest)
{
    char *bound = bake_alloc((size_t)n->count, 1); /* from below: something below it is */
    char *hangs = bake_alloc((size_t)n->count, 1); /* from above */
    for (int i = 0; i < n->count; i++) {
        int parent = n->node[i].parent;
        hangs[i] = n->node[i].skinned || (parent >= 0 && hangs[parent]);
        bound[i] = (char)n->node[i].skinned;
    }
    for (int i = n->count - 1; i > 0; i--) {
        bound[n->node[i].parent] |= bound[i];
    }
    for (int i = n->count - 1; i >= 0; i--) {
        if (bound[i] && !hangs[i]) {
            bind_above(n, i, rest, bound);
        }
    }
    for (int i = 0; i < n->count; i++) {
        rig_node *node = &n->node[i];
        if (!node->skinned && (hangs[i] || !bound[i])) {
            node->bind = affine_product(node->parent < 0 ? &n->world : &n->node[node->parent].bind,
                                        &node->own);
        }
    }
    free(bound);
    free(hangs);
}

static void bind_all(rig_nodes *n, const struct aiScene *file, const struct aiNode **from)
{
    affine *rest = bake_alloc((size_t)n->count, sizeof *rest);
    for (int i = 0; i < n->count; i++) {
        int parent = n->node[i].parent;
        rest[i] = affine_product(parent < 0 ? &n->world : &rest[parent], &n->node[i].own);
        for (unsigned k = 0; k < from[i]->mNumMeshes; k++) {
            if (from[i]->mMeshes[k] < file->mNumMeshes && file->mMeshes[from[i]->mMeshes[k]]) {
                bind_mesh(n, file->mMeshes[from[i]->mMeshes[k]], &rest[i]);
            }
        }
    }
    bind_others(n, rest);
    free(rest);
}

void rig_nodes_make(const struct aiScene *file, const affine *world, rig_nodes *out)
{
    *out = (rig_nodes){.world = *world};
    const struct aiNode **from = list(file->mRootNode, out);
    bind_all(out, file, from);
    free(from);
}

void rig_nodes_free(rig_nodes *n)
{
    for (int i = 0; i < n->count; i++) {
        for (int k = 0; k < 3; k++) {
            free(n->node[i].keys[k].time);
            free(n->node[i].keys[k].value);
        }
    }
    free(n->node);
    *n = (rig_nodes){0};
}

int rig_nodes_child(const rig_nodes *n, int node, double way[3])
{
    for (int i = node + 1; i < n->count; i++) {
        if (n->node[i].parent != node) {
            continue;
        }
        double length = 0, size = 0;
        for (int k = 0; k < 3; k++) {
            double a = n->node[node].bind.at[k][3], b = n->node[i].bind.at[k][3];
            way[k] = b - a;
            length += fabs(way[k]);
            size += fabs(a) + fabs(b);
        }
        if (length > 1e-6 * size && isfinite(length)) {
            return i;
        }
    }
    return -1;
}

/* ---- keys ------------------------------------------------------------------------------------ */

static void to_side(double q[4], const double before[4])
{
    double dot = q[0] * before[0] + q[1] * before[1] + q[2] * before[2] + q[3] * before[3];
    for (int k = 0; k < 4 && dot < 0; k++) {
        q[k] = -q[k];
    }
}

static void start_keys(node_keys *to, unsigned count, int width)
{
    free(to->time); /* a second channel of the same node replaces the first */
    free(to->value);
    to->count = 0;
    to->width = width;
    to->time = bake_alloc((size_t)count + 1, sizeof(double));
    to->value = bake_alloc((size_t)count + 1, (size_t)width * sizeof(double));
}

/* Equal times, which some exporters write, count once. */
static int add_key(node_keys *to, double time, const double *value)
{
    double *into = to->value + (size_t)to->count * (size_t)to->width;
    memcpy(into, value, (size_t)to->width * sizeof(double));
    if (to->width == 4) {
        normalise(into);
    }
    for (int k = 0; k < to->width; k++) {
        if (!isfinite(time) || !(fabs(into[k]) <= 1e30)) {
            return -1;
        }
    }
    if (to->count > 0 && time <= to->time[to->count - 1]) {
        return 0;
    }
    if (to->width == 4 && to->count > 0) {
        to_side(into, into - 4);
    }
    to->time[to->count++] = time;
    return 0;
}

static int add_vectors(node_keys *to, const struct aiVectorKey *from, unsigned count, double ticks)
{
    int err = 0;
    start_keys(to, count, 3);
    for (unsigned i = 0; i < count && err == 0; i++) {
        const struct aiVector3D *v = &from[i].mValue;
        const double value[3] = {(double)v->x, (double)v->y, (double)v->z};
        err = add_key(to, from[i].mTime / ticks, value);
    }
    return err;
}

static int add_channel(rig_node *node, const struct aiNodeAnim *from, double ticks)
{
    int err = add_vectors(&node->keys[0], from->mPositionKeys, from->mNumPositionKeys, ticks);
    start_keys(&node->keys[1], from->mNumRotationKeys, 4);
    for (unsigned i = 0; i < from->mNumRotationKeys && err == 0; i++) {
        const struct aiQuaternion *q = &from->mRotationKeys[i].mValue;
        const double value[4] = {(double)q->w, (double)q->x, (double)q->y, (double)q->z};
        err = add_key(&node->keys[1], from->mRotationKeys[i].mTime / ticks, value);
    }
    return err ? err
               : add_vectors(&node->keys[2], from->mScalingKeys, from->mNumScalingKeys, ticks);
}

const char *rig_nodes_animate(rig_nodes *n, const struct aiAnimation *animation)
{
    double ticks = animation->mTicksPerSecond > 0 ? animation->mTicksPerSecond : default_ticks;
    for (unsigned i = 0; i < animation->mNumChannels; i++) {
        const struct aiNodeAnim *from = animation->mChannels[i];
        int node = rig_nodes_find(n, from->mNodeName.data);
        if (node >= 0 && add_channel(&n->node[node], from, ticks)) {
            return n->node[node].name;
        }
    }
    return NULL;
}

static void slerp(const double a[4], const double b[4], double part, double out[4])
{
    double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    double angle = acos(fmax(fmin(cosine, 1), -1)), u = 1 - part, v = part;
    if (angle > 1e-6) {
        u = sin((1 - part) * angle) / sin(angle);
        v = sin(part * angle) / sin(angle);
    }
    for (int k = 0; k < 4; k++) {
        out[k] = u * a[k] + v * b[k];
    }
}

static void key_value(const node_keys *keys, double time, double out[4])
{
    int low = 0, high = keys->count - 1;
    while (high - low > 1) { /* bisection */
        int middle = (low + high) / 2;
        *(keys->time[middle] <= time ? &low : &high) = middle;
    }
    double way = keys->time[high] - keys->time[low];
    double part = way > 0 ? fmax(0, fmin(1, (time - keys->time[low]) / way)) : 0;
    const double *a = keys->value + (size_t)low * (size_t)keys->width;
    const double *b = keys->value + (size_t)high * (size_t)keys->width;
    if (keys->width == 4) {
        slerp(a, b, part, out);
        return;
    }
    for (int k = 0; k < 3; k++) {
        out[k] = a[k] + part * (b[k] - a[k]);
    }
}

/* Position, rotation, scaling. */
static affine compose(double part[3][4])
{
    affine out;
    for (int k = 0; k < 3; k++) {
        double unit[3] = {0}, turned[3], size = part[2][k];
        unit[k] = fabs(size) < scaling_least ? scaling_least : size;
        quaternion_turn(part[1], unit, turned);
        for (int r = 0; r < 3; r++) {
            out.at[r][k] = turned[r];
        }
        out.at[k][3] = part[0][k];
    }
    return out;
}

static affine local_pose(const rig_node *node, double time)
{
    double part[3][4];
    if (node->keys[0].count + node->keys[1].count + node->keys[2].count == 0) {
        return node->own;
    }
    memcpy(part, node->still, sizeof part);
    for (int k = 0; k < 3; k++) {
        if (node->keys[k].count > 0) {
            key_value(&node->keys[k], time, part[k]);
        }
    }
    return compose(part);
}

void rig_nodes_pose(const rig_nodes *n, int node, double time, affine *out)
{
    *out = local_pose(&n->node[node], time);
    for (int i = n->node[node].parent; i >= 0; i = n->node[i].parent) {
        affine above = local_pose(&n->node[i], time);
        *out = affine_product(&above, out);
    }
    *out = affine_product(&n->world, out);
}
