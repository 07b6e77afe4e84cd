/* Morph targets: poses that a file names, and animations of their weights.
 *
 * A vertex stands at base + sum w_i (target_i - base). Between keys a weight moves along a straight
 * line: Assimp does not say when a file asks for steps or cubics.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"
#include "scene_names.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Times are floats of a few seconds, in milliseconds: a thousandth of a frame is far above their
 * rounding and far below a frame. */
static const double same_frame = 1e-3;

/* Assimp leaves 0 where a format says nothing; 25 is what its own tools then use. */
static const double default_ticks = 25;

/* Keys belong to a node, in some formats to a mesh ("name*0"). */
static int moves(const struct aiMeshMorphAnim *channel, const mesh_place *place)
{
    const char *name = channel->mName.data, *whole = place->mesh->mName.data;
    size_t length = strcspn(name, "*");
    if (place->mesh->mNumAnimMeshes == 0)
        return 0;
    return strcmp(name, place->node) == 0 ||
           (length > 0 && strlen(whole) == length && strncmp(name, whole, length) == 0);
}

static const struct aiMeshMorphAnim *find_channel(const struct aiAnimation *animation,
                                                  const mesh_place *place)
{
    for (unsigned i = 0; i < animation->mNumMorphMeshChannels; i++)
        if (moves(animation->mMorphMeshChannels[i], place) &&
            animation->mMorphMeshChannels[i]->mNumKeys > 0)
            return animation->mMorphMeshChannels[i];
    return NULL;
}

/* The first animation that moves a target of the mesh. */
static const struct aiAnimation *find_animation(const mesh_file *f)
{
    for (unsigned i = 0; i < f->file->mNumAnimations; i++)
        for (int j = 0; j < f->place_count; j++)
            if (find_channel(f->file->mAnimations[i], &f->places[j]) != NULL)
                return f->file->mAnimations[i];
    return NULL;
}

static void add_key(const struct aiMeshMorphKey *key, double part, double *weight, unsigned count)
{
    for (unsigned i = 0; i < key->mNumValuesAndWeights; i++)
        if (key->mValues[i] < count)
            weight[key->mValues[i]] += part * key->mWeights[i];
}

/* Weights at a time in the animation's ticks. */
static void weights_at(const struct aiMeshMorphAnim *channel, double ticks, double *weight,
                       unsigned count)
{
    const struct aiMeshMorphKey *keys = channel->mKeys;
    unsigned next = 0;
    while (next < channel->mNumKeys && keys[next].mTime <= ticks)
        next++;
    memset(weight, 0, count * sizeof *weight);
    if (next == 0 || next == channel->mNumKeys) {
        add_key(&keys[next == 0 ? 0 : next - 1], 1, weight, count);
        return;
    }
    double part = (ticks - keys[next - 1].mTime) / (keys[next].mTime - keys[next - 1].mTime);
    add_key(&keys[next - 1], 1 - part, weight, count);
    add_key(&keys[next], part, weight, count);
}

/* The weights a file shows without animation. */
static void own_weights(const struct aiMesh *from, double *weight)
{
    for (unsigned i = 0; i < from->mNumAnimMeshes; i++)
        weight[i] = (double)from->mAnimMeshes[i]->mWeight;
}

static void put_place(const mesh_file *f, const mesh_place *place, const double *weight, double *at)
{
    const struct aiMesh *from = place->mesh;
    for (unsigned j = 0; j < from->mNumVertices; j++) {
        const struct aiVector3D *base = &from->mVertices[j];
        double point[3] = {(double)base->x, (double)base->y, (double)base->z};
        for (unsigned k = 0; k < from->mNumAnimMeshes; k++) {
            const struct aiAnimMesh *target = from->mAnimMeshes[k];
            if (target->mVertices == NULL || j >= target->mNumVertices || weight[k] == 0)
                continue;
            const struct aiVector3D *to = &target->mVertices[j];
            point[0] += weight[k] * ((double)to->x - (double)base->x);
            point[1] += weight[k] * ((double)to->y - (double)base->y);
            point[2] += weight[k] * ((double)to->z - (double)base->z);
        }
        mesh_put(place, point, at + 3 * (size_t)f->id[place->first + (int)j]);
    }
}

/* One pose; without `animation` the file's own. */
static void put_all(const mesh_file *f, const struct aiAnimation *animation, double ticks,
                    double *at)
{
    for (int i = 0; i < f->place_count; i++) {
        const mesh_place *place = &f->places[i];
        const struct aiMeshMorphAnim *channel =
            animation != NULL ? find_channel(animation, place) : NULL;
        double *weight = bake_alloc(place->mesh->mNumAnimMeshes, sizeof *weight);
        if (channel != NULL)
            weights_at(channel, ticks, weight, place->mesh->mNumAnimMeshes);
        else
            own_weights(place->mesh, weight);
        put_place(f, place, weight, at);
        free(weight);
    }
}

void mesh_morph_rest(const mesh_file *f, double *at)
{
    put_all(f, NULL, 0, at);
}

int mesh_read_morph(const mesh_reader *r, const mesh_file *f, const scene_motion *motion,
                    mesh_frames *out)
{
    const struct aiAnimation *animation = find_animation(f);
    if (animation == NULL)
        return mesh_fail(r, f->path,
                         "has no frames: no numbered files (run_####.obj), no MD2 or MD3, no "
                         "animated morph targets");
    double ticks = animation->mTicksPerSecond > 0 ? animation->mTicksPerSecond : default_ticks;
    double rate = motion->rate > 0 ? motion->rate : 30;
    double frames = floor(animation->mDuration / ticks * rate + same_frame) + 1;
    if (!(frames >= 1 && frames <= MESH_FRAMES_MAX))
        return mesh_fail(r, f->path, "has an animation of %g s, %g frames; lower 'rate'",
                         animation->mDuration / ticks, frames);
    if (mesh_range(r, f->path, (int)frames, motion, out))
        return -1;
    for (int i = 0; i < out->count; i++) {
        int frame = motion->first + i;
        double *at = out->at + 3 * (size_t)i * (size_t)r->rest.id_count;
        put_all(f, animation, frame / rate * ticks, at);
        if (mesh_check_pose(r, f->path, frame, at))
            return -1;
    }
    return 0;
}

/* The target's index in this mesh, or -1. */
static int find_target(const struct aiMesh *from, const char *name)
{
    char *end;
    long index = strtol(name, &end, 10);
    for (unsigned i = 0; i < from->mNumAnimMeshes; i++)
        if (strcmp(from->mAnimMeshes[i]->mName.data, name) == 0)
            return (int)i;
    return *end == '\0' && end != name && index >= 0 && index < (long)from->mNumAnimMeshes
               ? (int)index
               : -1;
}

static int fail_target(const mesh_reader *r, const char *name)
{
    char hint[SCENE_HINT_BYTES];
    const char **names = NULL;
    int count = 0;
    for (int i = 0; i < r->rest.place_count; i++) {
        const struct aiMesh *from = r->rest.places[i].mesh;
        names = bake_grow(names, (size_t)count + from->mNumAnimMeshes, sizeof *names);
        for (unsigned j = 0; j < from->mNumAnimMeshes; j++)
            names[count++] = from->mAnimMeshes[j]->mName.data;
    }
    int err = mesh_fail(r, r->rest.path, "has no morph target '%.60s' among %d; %s", name, count,
                        scene_names_hint(&SCENE_NAMES(names, count), name, hint));
    free(names);
    return err;
}

int mesh_read_target(const mesh_reader *r, const char *name, double *at)
{
    int found = 0;
    for (int i = 0; i < r->rest.place_count; i++) {
        const mesh_place *place = &r->rest.places[i];
        int target = find_target(place->mesh, name);
        double *weight = bake_alloc(place->mesh->mNumAnimMeshes, sizeof *weight);
        own_weights(place->mesh, weight);
        if (target >= 0)
            weight[target] += 1;
        put_place(&r->rest, place, weight, at);
        free(weight);
        found |= target >= 0;
    }
    return found ? mesh_check_pose(r, r->rest.path, -1, at) : fail_target(r, name);
}
