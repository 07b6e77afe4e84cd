/* Bones that a file brings along.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_file.h"
#include "isolate.h"
#include "rig_file_parts.h"
#include "scene_names.h"

#include <assimp/cimport.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NODE_NAME_MAX = 1024, NAME_LEAST = 8 };

typedef struct {
    scene *s;
    scene_rig *rig;
    int count;
    scene_bone *bone; /* the file's */
} reading;

static void free_bone(scene_bone *b)
{
    free(b->name);
    free(b->node);
}

static void free_reading(reading *r)
{
    for (int i = 0; i < r->count; i++) {
        free_bone(&r->bone[i]);
    }
    free(r->bone);
}

/* ---- in the process that reads --------------------------------------------------------------- */

static void place_of(const rig_nodes *n, int node, double at[3])
{
    for (int k = 0; k < 3; k++) {
        at[k] = n->node[node].bind.at[k][3];
    }
}

/* Where a bone ends; 0: nowhere, it is a point. */
static int find_end(const rig_nodes *n, const file_bones *list, int i, scene_bone *bones)
{
    scene_bone *b = &bones[i];
    const scene_bone *parent = b->parent >= 0 ? &bones[b->parent] : NULL;
    double way[3];
    memcpy(b->to, b->from, sizeof b->to);
    if (list->bone[i].child >= 0) {
        place_of(n, list->bone[list->bone[i].child].node, b->to);
        return 1;
    }
    if (rig_nodes_child(n, list->bone[i].node, way) < 0) {
        for (int k = 0; k < 3; k++) {
            way[k] = parent ? 0.5 * (parent->to[k] - parent->from[k]) : 0;
        }
    }
    for (int k = 0; k < 3; k++) {
        b->to[k] += way[k];
    }
    return way[0] != 0 || way[1] != 0 || way[2] != 0;
}

static void make_bones(const rig_nodes *n, const file_bones *list, reading *r)
{
    r->count = list->count;
    r->bone = bake_alloc((size_t)list->count, sizeof *r->bone);
    for (int i = 0; i < list->count; i++) {
        const file_bone *from = &list->bone[i];
        scene_bone *b = &r->bone[i];
        *b = (scene_bone){.name = bake_copy(from->name),
                          .line = r->rig->line,
                          .parent = from->parent,
                          .value = -1,
                          .weightless = !n->node[from->node].skinned,
                          .node = bake_copy(n->node[from->node].name),
                          .captured = -1,
                          .travels = -1};
        place_of(n, from->node, b->from);
        b->kind = find_end(n, list, i, r->bone) ? BONE_BONE : BONE_POINT;
    }
}

static int fail_file(const reading *r, bake_error *error, const char *what)
{
    return bake_fail(error, "%s:%d: '%s' %s", r->s->path, r->rig->line, r->rig->file, what);
}

static int read_scene(reading *r, const struct aiScene *file, bake_error *error)
{
    rig_nodes nodes;
    file_bones list;
    affine world = file_world(&r->s->meshes[r->rig->mesh]);
    if (file == NULL) {
        return bake_fail(error, "%s:%d: '%s' cannot be read: %s", r->s->path, r->rig->line,
                         r->rig->file, aiGetErrorString());
    }
    if (file->mRootNode == NULL) {
        return fail_file(r, error, "is empty");
    }
    rig_nodes_make(file, &world, &nodes);
    file_bones_list(&nodes, file_name_longest(r->rig), &list);
    make_bones(&nodes, &list, r);
    file_bones_free(&list);
    rig_nodes_free(&nodes);
    return r->count > 0 ? 0
                        : fail_file(r, error,
                                    "has no bones: no vertex of it follows a node; export it with "
                                    "its skin, or list the rig's 'bones'");
}

static int read_here(void *what, isolate_note *now, bake_error *error)
{
    reading *r = what;
    isolate_now(now, r->rig->line, r->rig->file);
    const struct aiScene *file = rig_nodes_open(r->rig->file);
    int err = read_scene(r, file, error);
    if (file != NULL) {
        aiReleaseImport(file);
    }
    return err;
}

static void send_text(const char *text, FILE *to)
{
    int length = (int)strlen(text);
    fwrite(&length, sizeof length, 1, to);
    fwrite(text, 1, (size_t)length, to);
}

static void send(const void *what, FILE *to)
{
    const reading *r = what;
    fwrite(&r->count, sizeof r->count, 1, to);
    for (int i = 0; i < r->count; i++) {
        fwrite(&r->bone[i], sizeof r->bone[i], 1, to);
        send_text(r->bone[i].name, to);
        send_text(r->bone[i].node, to);
    }
}

/* ---- in the baker ---------------------------------------------------------------------------- */

static char *take_text(FILE *from, int longest)
{
    int length;
    char *text = NULL;
    if (fread(&length, sizeof length, 1, from) == 1 && length >= 0 && length <= longest) {
        text = bake_alloc((size_t)length + 1, 1);
        if (fread(text, 1, (size_t)length, from) != (size_t)length) {
            free(text);
            text = NULL;
        }
    }
    return text;
}

static int good_bone(const scene_bone *b, int index)
{
    int good = b->name != NULL && b->node != NULL && b->parent >= -1 && b->parent < index;
    for (int k = 0; k < 3; k++) {
        good = good && fabs(b->from[k]) < 1e9 && fabs(b->to[k]) < 1e9;
    }
    return good;
}

static int take(void *what, FILE *from)
{
    reading *r = what;
    int count;
    if (fread(&count, sizeof count, 1, from) != 1 || count < 1 || count > NODE_NAME_MAX * 1024) {
        return -1;
    }
    r->bone = bake_alloc((size_t)count, sizeof *r->bone);
    for (int i = 0; i < count; i++) {
        scene_bone got, *b = &r->bone[i];
        if (fread(&got, sizeof got, 1, from) != 1) {
            return -1;
        }
        *b = (scene_bone){.line = r->rig->line,
                          .parent = got.parent,
                          .value = -1,
                          .weightless = got.weightless != 0,
                          .kind = got.kind == BONE_BONE ? BONE_BONE : BONE_POINT,
                          .captured = -1,
                          .travels = -1};
        memcpy(b->from, got.from, sizeof b->from);
        memcpy(b->to, got.to, sizeof b->to);
        b->name = take_text(from, FILE_NAME_BYTES);
        b->node = take_text(from, NODE_NAME_MAX);
        r->count = i + 1;
        if (!good_bone(b, i)) {
            return -1;
        }
    }
    return 0;
}

/* ---- the scene's bones among them ------------------------------------------------------------ */

static int has_place(const scene_bone *b)
{
    return b->kind != BONE_BONE || !isnan(b->from[0]);
}

static int check_joined(const reading *r, const scene_bone *own, const int *to, int at,
                        bake_error *error)
{
    return own->parent < 0 || to[own->parent] == r->bone[at].parent
               ? 0
               : bake_fail(error,
                           "%s:%d: the bone '%s' is one of '%s', which says what it hangs on; "
                           "remove 'parent'",
                           r->s->path, own->line, own->name, r->rig->file);
}

static int check_added(const reading *r, const scene_bone *own, bake_error *error)
{
    char hint[SCENE_HINT_BYTES];
    scene_names names = SCENE_NAMES(r->bone, r->count);
    return has_place(own) ? 0
                          : bake_fail(error,
                                      "%s:%d: '%s' has no bone '%s', and a bone of the scene's own "
                                      "needs a place; %s",
                                      r->s->path, own->line, r->rig->file, own->name,
                                      scene_names_hint(&names, own->name, hint));
}

/* Where every bone of the scene goes among those of the file, and behind them. Returns how many
 * bones there are then, or -1. */
static int find_places(const reading *r, int *to, bake_error *error)
{
    int count = r->count;
    scene_names names = SCENE_NAMES(r->bone, r->count);
    for (int i = 0; i < r->rig->bone_count; i++) {
        const scene_bone *own = &r->rig->bones[i];
        int found = scene_names_find(&names, own->name);
        to[i] = found >= 0 ? found : count++;
        if (found >= 0 ? check_joined(r, own, to, found, error) : check_added(r, own, error)) {
            return -1;
        }
    }
    return count <= (int)WG_BONES_MAX
               ? count
               : bake_fail(error, "%s:%d: the rig has %d bones; a clip holds %u", r->s->path,
                           r->rig->line, count, WG_BONES_MAX);
}

/* What the scene says of a bone of the file; `own` is used up. */
static void join(scene_bone *of_file, scene_bone *own)
{
    if (!has_place(own)) {
        own->kind = of_file->kind;
        memcpy(own->from, of_file->from, sizeof own->from);
        memcpy(own->to, of_file->to, sizeof own->to);
    }
    if (own->node == NULL) {
        own->node = of_file->node;
        of_file->node = NULL;
    }
    own->parent = of_file->parent;
    own->travels = own->parent < 0 ? own->travels : -1;
    own->weightless |= of_file->weightless;
    free_bone(of_file);
    *of_file = *own;
}

/* Everything that names bones by number; `along`, which needs the parent's place. */
static void renumber(scene_rig *rig, const int *to)
{
    for (int i = 0; i < rig->facet_count; i++) {
        for (int k = 0; k < 3; k++) {
            rig->facets[i][k] = rig->facets[i][k] >= 0 ? to[rig->facets[i][k]] : -1;
        }
    }
    for (int i = 0; i < rig->bone_count; i++) {
        scene_bone *b = &rig->bones[i];
        for (int j = 0; j < b->joint_count; j++) {
            for (int k = 0; k < b->joints[j].follow_count; k++) {
                b->joints[j].follow[k] = to[b->joints[j].follow[k]];
            }
        }
        if (b->parent >= 0 && !isnan(b->from[0]) && !isnan(rig->bones[b->parent].from[0])) {
            b->along = scene_bone_along(&rig->bones[b->parent], b->from);
        }
    }
}

/* Moves the scene's bones among those of the file, which become the rig's. */
static int merge(reading *r, bake_error *error)
{
    scene_rig *rig = r->rig;
    int *to = bake_alloc((size_t)rig->bone_count + 1, sizeof *to);
    int file_count = r->count, count = find_places(r, to, error);
    if (count > 0) {
        r->bone = bake_grow(r->bone, (size_t)count, sizeof *r->bone);
        for (int i = 0; i < rig->bone_count; i++) {
            scene_bone *own = &rig->bones[i];
            if (to[i] < file_count) {
                join(&r->bone[to[i]], own);
            } else {
                own->parent = own->parent >= 0 ? to[own->parent] : -1;
                r->bone[to[i]] = *own;
            }
        }
        free(rig->bones);
        rig->bones = r->bone;
        rig->bone_count = count;
        r->bone = NULL;
        r->count = 0;
        renumber(rig, to);
    }
    free(to);
    return count > 0 ? 0 : -1;
}

int rig_file_bones(scene *s, int rig, bake_error *error)
{
    reading r = {.s = s, .rig = &s->rigs[rig]};
    if (file_name_longest(r.rig) < NAME_LEAST) {
        return bake_fail(error,
                         "%s:%d: the rig's name is too long: channels of its bones are called "
                         "<rig>_<bone>_move_x, and names have at most %d characters",
                         s->path, r.rig->line, FILE_NAME_BYTES - 1);
    }
    const isolate_job job = {s->path, &r, read_here, send, take};
    int err = isolate(&job, error);
    if (err == 0) {
        err = merge(&r, error);
    }
    free_reading(&r);
    return err;
}
