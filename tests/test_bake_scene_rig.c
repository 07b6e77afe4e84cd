/* Rigs in scene files: what is read from a scene with all of it, and what is said when one thing of it is
 * wrong: each case changes one text of the good scene.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "ends.h"
#include "rigs_wrong.h"
#include "wiggly_format.h"

#include <math.h>

static const char good[] = "tests/scenes/rigs.yaml";

/* Of the good scene: eleven and the view's eight come before those of rigs. */
enum { WRIST = 20, HIPS = 24, CHEST = 31, TAIL = 35, CHANNELS = 42 };

static void need_good(void)
{
    if (load(good) != 0) {
        printf("%s\n", error.text);
        exit(1);
    }
}

static int is_vector(const double *v, double x, double y, double z)
{
    return fabs(v[0] - x) + fabs(v[1] - y) + fabs(v[2] - z) < 1e-12;
}

static void rigs_are_read(void)
{
    need_good();
    CHECK_EQ(s.rig_count, 5);
    const scene_rig *r = &s.rigs[0];
    CHECK(strcmp(r->name, "arm") == 0 && r->line == 33 && r->mesh == 0 && r->file == NULL);
    CHECK(r->method == WG_SKIN_LINEAR && r->ends == ENDS_JOINTS && r->weights == WEIGHTS_COUPLED);
    CHECK(r->influences == 6 && r->tolerance == 0.5 && r->cell == 4 && r->lift == 0.25);
    CHECK(r->wrap == 0 && r->paint == 1 && r->bone_count == 7 && r->facet_count == 0);
    CHECK(r->filter_count == 3 && r->filter_x[0] == 0.2 && r->filter_y[1] == 0);
    CHECK(r->filter_x[2] == 0.8 && r->filter_y[2] == 0.9);
    CHECK(r->brush_count == 1 && r->brushes[0].stiffness == 100);
    CHECK(r->brushes[0].region.kind == REGION_VERTICES && r->brushes[0].region.vertex[1] == 4);
    CHECK(r->field_count == 1 && r->fields[0].channel == 6 && r->fields[0].line == 59);
    CHECK(is_vector(r->fields[0].at, 10, 40, 0));
    for (int i = 0; i < s.mesh_count; i++) {
        static const int owner[8] = {0, 1, 2, 3, 4, -1, -1, -1};
        CHECK_EQ(scene_rig_of_mesh(&s, i), owner[i]);
    }
    CHECK(s.meshes[1].cell == 3 && s.meshes[1].texels == 0 && s.meshes[2].texels == 64);
    scene_free(&s);
}

static void what_is_not_said_has_defaults(void)
{
    need_good();
    const scene_rig *r = &s.rigs[1];
    CHECK(r->method == WG_SKIN_SHIFT && r->ends == ENDS_NONE && r->weights == WEIGHTS_BOUNDED);
    CHECK(r->influences == 8 && r->tolerance == 0 && r->cell == 0 && r->lift == 0);
    CHECK(r->wrap == 1 && r->paint == 0 && r->filter_count == 0 && r->brush_count == 0);
    CHECK(s.rigs[3].ends == ENDS_NONE); /* it twists, and says none */
    CHECK(s.meshes[0].cell == 0 && s.meshes[0].texels == 0);
    scene_free(&s);
}

/* Endpoint weights by default are where something stretches or twists. */
static void bones_that_twist_get_endpoint_weights(void)
{
    char *text = read_good(good), *at = strstr(text, "ends: none");
    memcpy(at, "wrap: true", 10);
    CHECK_EQ(load_text(text, strlen(text)), 0);
    CHECK_EQ(s.rigs[3].ends, ENDS_BOUNDED);
    CHECK_EQ(s.rigs[2].ends, ENDS_NONE);
    scene_free(&s);
    free(text);
}

static void bones_are_read(void)
{
    need_good();
    const scene_bone *b = s.rigs[0].bones;
    CHECK(strcmp(b[0].name, "upper") == 0 && b[0].line == 45 && b[0].kind == BONE_BONE);
    CHECK(is_vector(b[0].from, 0, 90, 0) && is_vector(b[0].to, 40, 90, 0) && b[0].parent == -1);
    CHECK(b[0].value == -1 && b[0].captured == -1 && b[0].travels == -1 && b[0].depth == 0);
    CHECK(b[1].parent == 0 && is_vector(b[1].from, 40, 90, 0) && b[1].along == 1);
    CHECK(is_vector(b[1].to, 40, 50, 0) && b[1].value == 5);
    /* lower goes from (40, 90) to (40, 50): (42, 60) is nearest to three quarters of it */
    CHECK_NEAR(b[2].along, 0.75, 1e-15);
    CHECK(b[3].kind == BONE_POINT && b[3].weightless && is_vector(b[3].to, 30, 100, 0));
    CHECK_NEAR(b[3].along, 0.75, 1e-15);
    CHECK(b[4].parent == 3 && b[4].along == 0 && is_vector(b[4].from, 1, 1, 1));
    CHECK(b[5].kind == BONE_REGION && b[5].region->kind == REGION_BALL && b[5].depth == -2.5);
    CHECK(is_vector(b[5].from, 0, 1, 2) && is_vector(b[5].to, 0, 1, 2));
    CHECK(is_vector(b[5].region->centre, 0, 0, 9) && b[5].region->radius == 5);
    CHECK(b[6].kind == BONE_REGION && isnan(b[6].from[0]) && isnan(b[6].along));
    CHECK(b[6].region->box[0][1] == 20 && isinf(b[6].region->box[1][2]));
    scene_free(&s);
}

/* Two coordinates are a place in z = 0, and a box through all z. */
static void flat_places_are_read(void)
{
    need_good();
    const scene_rig *r = &s.rigs[1];
    CHECK(r->bones[1].kind == BONE_CAGE && is_vector(r->bones[1].from, 9, 0, 0));
    CHECK(is_vector(r->bones[3].region->centre, 1, 2, 0));
    const double(*box)[3] = (const double(*)[3])r->bones[4].region->box;
    CHECK(box[0][0] == 1 && box[1][1] == 4 && isinf(box[0][2]) && isinf(box[1][2]));
    CHECK(r->facet_count == 2 && r->facets[1][0] == 1 && r->facets[1][1] == 2);
    CHECK(r->facets[1][2] == -1);
    scene_free(&s);
}

static void joints_are_read(void)
{
    need_good();
    const scene_bone *b = s.rigs[0].bones;
    const scene_joint *j = b[0].joints;
    CHECK_EQ(b[0].joint_count, 3);
    CHECK(j[0].kind == WG_JOINT_TURN && j[0].channel == 0 && is_vector(j[0].axis, 0, 0, 1));
    CHECK(j[1].kind == WG_JOINT_MOVE && j[1].channel == 1 && is_vector(j[1].axis, 0, 0.6, 0.8));
    CHECK(j[2].kind == WG_JOINT_MOVE && j[2].channel == 2);
    j = b[1].joints;
    CHECK(b[1].joint_count == 4 && j[0].kind == WG_JOINT_STRETCH && j[0].channel == 3);
    CHECK(j[1].kind == WG_JOINT_TWIST_END && j[2].kind == WG_JOINT_TWIST_START);
    CHECK(j[3].kind == WG_JOINT_QUATERNION && j[3].channel == WRIST);
    CHECK(b[4].joints[0].kind == WG_JOINT_QUATERNION && b[4].joints[0].channel == 7);
    j = s.rigs[2].bones[0].joints;
    CHECK(j[0].kind == WG_JOINT_FOLLOW && j[0].follow_count == 2);
    CHECK(j[0].follow[0] == 2 && j[0].follow[1] == 1);
    CHECK(s.rigs[2].bones[2].joints[1].kind == WG_JOINT_FOLLOW);
    CHECK_EQ(s.rigs[2].bones[2].joints[1].follow[0], 0);
    scene_free(&s);
}

/* Behind the scene's own and those of views: rotations at rest, without a unit. */
static void channels_are_added(void)
{
    static const struct {
        int index;
        const char *name;
        double rest;
    } added[] = {{WRIST, "wrist_w", 1},
                 {WRIST + 1, "wrist_x", 0},
                 {WRIST + 3, "wrist_z", 0},
                 {HIPS, "boxer_hips_w", 1},
                 {HIPS + 3, "boxer_hips_z", 0},
                 {HIPS + 4, "boxer_hips_move_x", 0},
                 {HIPS + 6, "boxer_hips_move_z", 0},
                 {CHEST, "boxer_chest_w", 1},
                 {TAIL + 6, "boxer_tail_move_z", 0}};
    need_good();
    CHECK_EQ(s.channel_count, CHANNELS);
    for (size_t i = 0; i < sizeof added / sizeof *added; i++) {
        const scene_channel *c = &s.channels[added[i].index];
        CHECK(strcmp(c->name, added[i].name) == 0 && c->unit == WG_UNIT_NONE);
        CHECK(c->tolerance == 0 && fabs(c->rest - added[i].rest) == 0);
    }
    const scene_bone *b = s.rigs[3].bones;
    CHECK(strcmp(b[1].node, "Chest 2") == 0 && b[1].captured == CHEST && b[1].travels == -1);
    CHECK(b[0].captured == HIPS && b[0].travels == HIPS + 4 && b[0].joint_count == 1);
    CHECK(b[2].captured == TAIL && b[2].travels == TAIL + 4);
    scene_free(&s);
}

/* One pair of limits a channel, however often it stands there, behind the scene's own filters. */
static void limits_become_filters(void)
{
    need_good();
    CHECK_EQ(s.filter_count, 3);
    const scene_filter *f = s.filters;
    CHECK(f[0].op == WG_FILTER_OFFSET && f[0].channel == 11);
    CHECK(f[1].op == WG_FILTER_CLAMP && f[1].channel == 0 && f[1].a == -10 && f[1].b == 140);
    CHECK(f[2].op == WG_FILTER_CLAMP && f[2].channel == 3 && f[2].a == 0.5 && f[2].b == 2);
    scene_free(&s);
}

static void files_leave_places_to_the_baker(void)
{
    need_good();
    const scene_rig *r = &s.rigs[4];
    CHECK(r->weights == WEIGHTS_FILE && strcmp(r->file, "tests/scenes/bent.gltf") == 0);
    CHECK(r->bone_count == 2 && r->bones[0].kind == BONE_BONE && r->bones[0].value == 5);
    CHECK(isnan(r->bones[0].from[0]) && isnan(r->bones[0].to[2]) && r->bones[0].along == 0);
    CHECK(is_vector(r->bones[1].from, 0, 200, 0) && isnan(r->bones[1].along));
    scene_free(&s);
}

static void takes_are_read(void)
{
    need_good();
    const scene_clip *clip = &s.clips[0];
    CHECK_EQ(clip->take_count, 2);
    const scene_take *t = clip->takes;
    CHECK(t[0].line == 92 && t[0].rig == 3 && t[0].source == 0 && t[0].travel == 1);
    CHECK_NEAR(t[0].from, 0.1, 1e-15);
    CHECK_NEAR(t[0].to, 0.25, 1e-15);
    CHECK(t[0].scale == 0.5 && t[1].rig == 4 && t[1].from == 0 && t[1].to == 0);
    CHECK(t[1].scale == 1 && t[1].travel == 0 && s.clips[1].take_count == 0);
    scene_free(&s);
}

/* A mesh's weight in a mask is that of what captures fill, except where a channel has its own. */
static void masks_weigh_captures_with_the_mesh(void)
{
    need_good();
    const scene_mask *m = &s.masks[0];
    CHECK(m->mesh_weight[3] == 0.5 && m->weight[HIPS] == 0.5 && m->weight[HIPS + 1] == 0.25);
    CHECK(m->weight[HIPS + 6] == 0.5 && m->weight[TAIL + 6] == 0.5 && m->weight[WRIST] == 1);
    CHECK(m->weight[WRIST + 1] == 0 && m->weight[0] == 0);
    scene_free(&s);
}

/* What the baker appends once the scene is read: a name of its own, and a weight in every mask. */
static void channels_can_be_added_later(void)
{
    need_good();
    int depth = scene_add_channel(&s, "boxer", "hips", "depth", 7);
    CHECK(depth == CHANNELS && s.channel_count == CHANNELS + 1);
    CHECK(strcmp(s.channels[depth].name, "boxer_hips_depth") == 0 && s.channels[depth].rest == 7);
    CHECK(s.masks[0].weight[depth] == 0.5);
    int again = scene_add_channel(&s, "boxer", "hips", "depth", 7);
    CHECK(strcmp(s.channels[again].name, "boxer_hips_depth_") == 0);
    scene_bone *b = &s.rigs[4].bones[0];
    scene_add_captured(&s, &s.rigs[4], b, 1);
    CHECK(b->captured == CHANNELS + 2 && b->travels == CHANNELS + 6);
    CHECK(strcmp(s.channels[b->travels + 2].name, "hero_Bone_move_z") == 0);
    CHECK(s.masks[0].weight[b->captured] == 0 && s.channels[b->captured].rest == 1);
    scene_free(&s);
}

static void every_wrong_rig_is_explained_at_its_line(void)
{
    check_wrongs(good, wrongs, (int)(sizeof wrongs / sizeof *wrongs));
}

static void no_flipped_byte_does_harm(void)
{
    check_flips(good);
}

/* A scene of one rig with `count` times `entry` in the place of the %s of `form`. */
static int load_many(const char *form, const char *entry, int count)
{
    enum { ROOM = 1 << 17, HEAD = 1 << 16 };
    char *text = bake_alloc(ROOM, 1), *list = bake_alloc(HEAD, 1), here[512];
    size_t used = 0;
    if (getcwd(here, sizeof here) == NULL)
        exit(1);
    for (int i = 0; i < count; i++)
        used += (size_t)snprintf(list + used, HEAD - used, entry, i, i);
    used = (size_t)snprintf(text, ROOM,
                            "channels: [{name: c, unit: deg}]\n"
                            "meshes: [{name: m, file: %s/tests/scenes/house.obj}]\n"
                            "clips: [{name: k, curves: [{channel: c, kind: linear, keys: [{time: "
                            "0, value: 0}, {time: 1, value: 1}]}]}]\n"
                            "rigs:\n",
                            here);
    used += (size_t)snprintf(text + used, ROOM - used, form, list);
    int err = load_text(text, used);
    free(text);
    free(list);
    return err;
}

/* The most that there may be is a scene; one more is an error at its line. */
static void limits_hold(void)
{
    static const struct {
        const char *form, *entry;
        int most;
        const char *message;
    } counts[] = {
        {"- {name: r, mesh: m, bones: [%s]}", "{name: b%d, at: [%d, 0]}, ", 256,
         "'bones' has 257 entries; a rig has at most 256"},
        {"- {name: r, mesh: m, bones: [{name: a, at: [0, 0], joints: [%s]}]}",
         "{turn: x, channel: c}, ", 16, "'joints' has 17 entries; a bone has at most 16"},
        {"- {name: r, mesh: m, bones: [{name: a, at: [0, 0]}], brush: [%s]}",
         "{region: {above: {y: %d}}, stiffness: 1}, ", 64,
         "'brush' has 65 entries; a rig has at most 64"},
        {"- {name: r, mesh: m, bones: [{name: a, cage: [0, 0]}, {name: b, cage: [0, 1]}], cage: "
         "[%s]}",
         "[a, b], ", 1024, "'cage' is a list of 1 to 1024 facets"},
        {"- {name: r, mesh: m, ends: bounded, bones: [{name: a, at: [0, 0]}], filter: [%s]}",
         "[0.0%.2d1, 0], ", 32, "'filter' is a list of 1 to 32 pairs"},
        /* 1 + 8 of the view + 61 x 4 = 253 of 256 */
        {"- {name: r, mesh: m, bones: [%s]}", "{name: b%d, at: [%d, 0], node: n}, ", 61,
         "'node' makes 4 channels of the bone, and with the 253 there are that is"}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        int err = load_many(counts[i].form, counts[i].entry, counts[i].most);
        CHECK_EQ(err, 0);
        if (err == 0)
            scene_free(&s);
        CHECK_EQ(load_many(counts[i].form, counts[i].entry, counts[i].most + 1), -1);
        CHECK(strstr(error.text, counts[i].message) != NULL && strstr(error.text, ":5: ") != NULL);
        if (!check_ok)
            printf("%s\n", error.text);
    }
}

/* Rigs that no vertex would follow. */
static void some_bone_is_followed(void)
{
    CHECK_EQ(load_many("- {name: r, mesh: m, bones: [%s]}", "", 0), -1);
    CHECK(strstr(error.text, ":5: a rig needs 'bones' or a rigged 'file'; write for") != NULL);
    CHECK_EQ(load_many("- {name: r, mesh: m, bones: [%s]}",
                       "{name: b%d, at: [%d, 0], weightless: true}, ", 2),
             -1);
    CHECK(strstr(error.text, "every bone is 'weightless'; the mesh has none to follow") != NULL);
}

int main(void)
{
    TEST(rigs_are_read);
    TEST(what_is_not_said_has_defaults);
    TEST(bones_that_twist_get_endpoint_weights);
    TEST(bones_are_read);
    TEST(flat_places_are_read);
    TEST(joints_are_read);
    TEST(channels_are_added);
    TEST(limits_become_filters);
    TEST(files_leave_places_to_the_baker);
    TEST(takes_are_read);
    TEST(masks_weigh_captures_with_the_mesh);
    TEST(channels_can_be_added_later);
    TEST(every_wrong_rig_is_explained_at_its_line);
    TEST(no_flipped_byte_does_harm);
    TEST(limits_hold);
    TEST(some_bone_is_followed);
    return check_done();
}
