/* Captured curves from BVH, glTF, FBX, Collada and whatever else Assimp animates.
 *
 * What Assimp 5.2 does with BVH, found by reading its output: every joint keeps its name and gets
 * one node channel; the Euler channels of a joint become one quaternion key a frame (float32); the
 * bind transformation is the OFFSET alone, without rotation; times are frame numbers and
 * mTicksPerSecond is 1 / "Frame Time" in float32 precision, never 0; a root keeps its position
 * channels, other joints have one constant position key; a mesh of the skeleton is added unless
 * AI_CONFIG_IMPORT_NO_SKELETON_MESHES forbids it.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "capture.h"
#include "isolate.h"
#include "scene_names.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* A sample a millisecond for a day. */
#define CAPTURE_SAMPLES_MAX 86400000

/* Assimp leaves 0 where a format says nothing; 25 is what its own tools then use. */
static const double default_ticks = 25;

/* Keys further apart than this are not samples but poses, between which a joint turns along the
 * shortest arc: 2 degree steps keep what the arc does to the hinge angle. */
static const double sparse_time = 0.05, arc_step = 2 * PI / 180;

/* A swing of more than 179.9 degrees across the axis: its twist is noise. */
static const double twist_least = 1e-3;

typedef struct {
    double w, x, y, z;
} quaternion;

static quaternion from_assimp(const struct aiQuaternion *q)
{
    double w = (double)q->w, x = (double)q->x, y = (double)q->y, z = (double)q->z;
    double length = sqrt(w * w + x * x + y * y + z * z);
    return (quaternion){w / length, x / length, y / length, z / length};
}

/* a b^-1 */
static quaternion relative(quaternion a, quaternion b)
{
    return (quaternion){a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z,
                        -a.w * b.x + a.x * b.w - a.y * b.z + a.z * b.y,
                        -a.w * b.y + a.x * b.z + a.y * b.w - a.z * b.x,
                        -a.w * b.z - a.x * b.y + a.y * b.x + a.z * b.w};
}

static double dot(quaternion a, quaternion b)
{
    return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}

static quaternion slerp(quaternion a, quaternion b, double part)
{
    double cosine = dot(a, b), sign = cosine < 0 ? -1 : 1;
    double angle = acos(fmin(fabs(cosine), 1));
    double u = 1 - part, v = part;
    if (angle > 1e-6) {
        u = sin((1 - part) * angle) / sin(angle);
        v = sin(part * angle) / sin(angle);
    }
    v *= sign;
    return (quaternion){u * a.w + v * b.w, u * a.x + v * b.x, u * a.y + v * b.y, u * a.z + v * b.z};
}

/* Appends the hinge angle of one orientation, on the turn nearest to the sample before. */
static int add_angle(capture_reader *r, double time, quaternion q)
{
    const double *axis = r->curve->axis;
    double along = q.x * axis[0] + q.y * axis[1] + q.z * axis[2];
    if (!(hypot(along, q.w) >= twist_least))
        return bake_fail(
            r->error,
            "%s:%d: at %g s the node '%s' is turned by 180 degrees across the axis, so "
            "it has no angle about it; choose another axis",
            r->scene_path, r->curve->line, time, r->curve->node);
    double angle = 2 * atan2(along, q.w) * 180 / PI;
    if (r->out->count > 0)
        angle -= 360 * round((angle - r->out->value[r->out->count - 1]) / 360);
    capture_add(r, time, angle);
    return 0;
}

static int add_arc(capture_reader *r, double time, quaternion to, quaternion from)
{
    const capture *c = r->out;
    double start = c->time[c->count - 1], length = time - start;
    int steps = 1;
    if (length > sparse_time)
        steps = 1 + (int)(2 * acos(fmin(fabs(dot(from, to)), 1)) / arc_step);
    for (int i = 1; i <= steps; i++) {
        double part = (double)i / steps;
        if (add_angle(r, i == steps ? time : start + part * length, slerp(from, to, part)))
            return -1;
    }
    return 0;
}

static int fail_key(const capture_reader *r, double time)
{
    return bake_fail(r->error, "%s: the key of '%s' at %g s is no finite number", r->source->file,
                     r->curve->node, time);
}

/* The keys of `channel` in seconds; equal times, which some exporters write, count once. */
static int add_rotations(capture_reader *r, const struct aiNodeAnim *channel, double ticks,
                         quaternion bind)
{
    quaternion before = {1, 0, 0, 0};
    for (unsigned i = 0; i < channel->mNumRotationKeys; i++) {
        double time = channel->mRotationKeys[i].mTime / ticks;
        quaternion q = relative(from_assimp(&channel->mRotationKeys[i].mValue), bind);
        if (!isfinite(time) || !isfinite(dot(q, q)))
            return fail_key(r, time);
        if (r->out->count > 0 && time <= r->out->time[r->out->count - 1])
            continue;
        if (r->out->count == 0 ? add_angle(r, time, q) : add_arc(r, time, q, before))
            return -1;
        before = q;
    }
    return 0;
}

static int add_translations(capture_reader *r, const struct aiNodeAnim *channel, double ticks,
                            struct aiVector3D bind)
{
    const double *axis = r->curve->axis;
    for (unsigned i = 0; i < channel->mNumPositionKeys; i++) {
        const struct aiVector3D *p = &channel->mPositionKeys[i].mValue;
        double time = channel->mPositionKeys[i].mTime / ticks;
        double way = ((double)p->x - (double)bind.x) * axis[0] +
                     ((double)p->y - (double)bind.y) * axis[1] +
                     ((double)p->z - (double)bind.z) * axis[2];
        if (!isfinite(time) || !isfinite(way))
            return fail_key(r, time);
        if (r->out->count == 0 || time > r->out->time[r->out->count - 1])
            capture_add(r, time, way);
    }
    return 0;
}

static const struct aiNode *find_node(const struct aiNode *node, const char *name)
{
    if (strcmp(node->mName.data, name) == 0)
        return node;
    for (unsigned i = 0; i < node->mNumChildren; i++) {
        const struct aiNode *found = find_node(node->mChildren[i], name);
        if (found != NULL)
            return found;
    }
    return NULL;
}

static const struct aiNodeAnim *find_channel(const struct aiAnimation *animation, const char *name)
{
    for (unsigned i = 0; i < animation->mNumChannels; i++)
        if (strcmp(animation->mChannels[i]->mNodeName.data, name) == 0)
            return animation->mChannels[i];
    return NULL;
}

static int fail_node(const capture_reader *r, const struct aiScene *file,
                     const struct aiAnimation *animation)
{
    char hint[SCENE_HINT_BYTES];
    const char *wanted = r->curve->node;
    const char **names = bake_alloc(animation->mNumChannels, sizeof *names);
    for (unsigned i = 0; i < animation->mNumChannels; i++)
        names[i] = animation->mChannels[i]->mNodeName.data;
    scene_names_hint(&SCENE_NAMES(names, animation->mNumChannels), wanted, hint);
    free(names);
    return bake_fail(r->error, "%s:%d: animation %d of '%s' %s '%.60s'; %s", r->scene_path,
                     r->curve->line, r->source->animation, r->source->file,
                     find_node(file->mRootNode, wanted) ? "does not move the node" : "has no node",
                     wanted, hint);
}

static int read_channel(capture_reader *r, const struct aiScene *file,
                        const struct aiAnimation *animation)
{
    const struct aiNodeAnim *channel = find_channel(animation, r->curve->node);
    const struct aiNode *node = find_node(file->mRootNode, r->curve->node);
    if (channel == NULL || node == NULL)
        return fail_node(r, file, animation);
    struct aiVector3D scaling, position;
    struct aiQuaternion rotation;
    aiDecomposeMatrix(&node->mTransformation, &scaling, &rotation, &position);
    double ticks = animation->mTicksPerSecond > 0 ? animation->mTicksPerSecond : default_ticks;
    int err = r->curve->component == CAPTURE_ROTATION
                  ? add_rotations(r, channel, ticks, from_assimp(&rotation))
                  : add_translations(r, channel, ticks, position);
    if (err || r->out->count > 1)
        return err;
    /* One key is a joint that stands still for the whole animation. */
    double length = animation->mDuration / ticks;
    if (r->out->count == 0 || !(length > r->out->time[0]))
        return bake_fail(r->error, "%s:%d: animation %d of '%s' has no keys for '%s'",
                         r->scene_path, r->curve->line, r->source->animation, r->source->file,
                         r->curve->node);
    capture_add(r, length, r->out->value[0]);
    return 0;
}

static int read_scene(capture_reader *r, const struct aiScene *file)
{
    int index = r->source->animation;
    if (file == NULL)
        isolate_complaint(aiGetErrorString());
    if (file == NULL)
        return bake_fail(r->error, "%s:%d: '%s' cannot be read: %s", r->scene_path, r->curve->line,
                         r->source->file, aiGetErrorString());
    if (file->mRootNode == NULL || (unsigned)index >= file->mNumAnimations)
        return bake_fail(r->error,
                         "%s:%d: '%s' has %u animations; 'animation' counts from 0 and "
                         "is %d",
                         r->scene_path, r->curve->line, r->source->file, file->mNumAnimations,
                         index);
    return read_channel(r, file, file->mAnimations[index]);
}

static int read_here(void *what, isolate_note *now, bake_error *error)
{
    capture_reader *r = what;
    r->error = error;
    isolate_now(now, r->curve->line, r->source->file);
    struct aiPropertyStore *settings = aiCreatePropertyStore();
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_NO_SKELETON_MESHES, 1);
    /* Otherwise an FBX joint is a chain of helper nodes, none of which has the joint's name. */
    aiSetImportPropertyInteger(settings, AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, 0);
    const struct aiScene *file = aiImportFileExWithProperties(r->source->file, 0, NULL, settings);
    int err = read_scene(r, file);
    aiReleaseImport(file);
    aiReleasePropertyStore(settings);
    return err;
}

static void send(const void *what, FILE *to)
{
    const capture *c = ((const capture_reader *)what)->out;
    fwrite(&c->count, sizeof c->count, 1, to);
    fwrite(c->time, sizeof *c->time, (size_t)c->count, to);
    fwrite(c->value, sizeof *c->value, (size_t)c->count, to);
}

static int take(void *what, FILE *from)
{
    capture *c = ((capture_reader *)what)->out;
    int count;
    if (fread(&count, sizeof count, 1, from) != 1 || count < 2 || count > CAPTURE_SAMPLES_MAX)
        return -1;
    c->time = isolate_get(from, (size_t)count, sizeof *c->time);
    c->value = isolate_get(from, (size_t)count, sizeof *c->value);
    c->count = count;
    int good = c->time != NULL && c->value != NULL;
    for (int i = 0; i < count && good; i++)
        good = isfinite(c->time[i]) && isfinite(c->value[i]) &&
               (i == 0 || c->time[i] > c->time[i - 1]);
    return good ? 0 : -1;
}

int capture_read_node(capture_reader *r)
{
    const isolate_job job = {r->scene_path, r, read_here, send, take};
    return isolate(&job, r->error);
}
