/* Bodies in scene files: what is read from a scene with all of it, and what is said when one thing of it
 * is wrong: each case changes one text of the good scene.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bodies_wrong.h"
#include "wiggly_format.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char good[] = "tests/scenes/bodies.yaml";

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

static void a_solid_is_read(void)
{
    need_good();
    CHECK_EQ(s.body_count, 3);
    const scene_body *b = &s.bodies[0];
    CHECK(strcmp(b->name, "plant") == 0 && b->line == 16);
    CHECK_EQ(b->kind, SCENE_SOLID);
    CHECK(b->mesh == 0 && b->attached_count == 1 && b->attached[0] == 1);
    CHECK_NEAR(b->unit, 0.01, 1e-15);
    CHECK_NEAR(b->young, 2e6, 1e-6);
    CHECK(b->poisson == 0.45 && b->density == 1100 && b->thickness == 0 && b->cell == 4);
    CHECK(is_vector(b->gravity, 0, -9.81, 0));
    CHECK(b->modes == 15 && b->damping[0] == 0.5 && b->damping[1] == 0.002);
    CHECK(b->fixed_count == 2 && b->fixed[0] == 0 && b->fixed[1] == 2);
    CHECK_EQ(b->slide_count, 2);
    CHECK(b->slides[0].region == 3 && is_vector(b->slides[0].normal, 0, 1, 0));
    CHECK(b->slides[1].region == 1 && is_vector(b->slides[1].normal, 0, 0.6, 0.8));
    CHECK_EQ(b->link_count, 0);
    for (int i = 0; i < 5; i++) {
        static const int owner[5] = {0, 0, 1, 2, -1};
        CHECK_EQ(scene_body_of_mesh(&s, i), owner[i]);
    }
    scene_free(&s);
}

static void regions_are_read(void)
{
    need_good();
    const scene_region *r = s.bodies[0].regions;
    CHECK_EQ(s.bodies[0].region_count, 4);
    CHECK(r[0].kind == REGION_BOX && strcmp(r[0].name, "base") == 0 && r[0].line == 27);
    CHECK(is_vector(r[0].box[0], -10, 0, -10) && is_vector(r[0].box[1], 10, 2, 10));
    CHECK(r[1].kind == REGION_BALL && is_vector(r[1].centre, 0, 90, 0) && r[1].radius == 5);
    CHECK(r[2].kind == REGION_VERTICES && r[2].vertex_count == 3);
    CHECK(r[2].vertex[0] == 0 && r[2].vertex[1] == 3 && r[2].vertex[2] == 8);
    CHECK(r[3].kind == REGION_BOX && r[3].box[0][0] == -1 && r[3].box[0][1] == 20);
    CHECK(r[3].box[1][1] == 60 && isinf(r[3].box[1][0]) && isinf(r[3].box[1][2]));
    CHECK(isinf(r[3].box[0][2]) && r[3].box[0][2] < 0);
    scene_free(&s);
}

static void poses_are_read(void)
{
    need_good();
    const scene_pose *p = s.bodies[0].poses;
    CHECK_EQ(s.bodies[0].pose_count, 5);
    CHECK(strcmp(p[0].name, "rest") == 0 && p[0].of == -1);
    CHECK(p[1].of == -1 && strcmp(p[1].file, "tests/scenes/house.obj") == 0 && p[1].line == 34);
    CHECK(p[2].file == NULL && p[2].drag_count == 2 && p[2].angle == 0);
    CHECK(p[2].drags[0].region == 1 && is_vector(p[2].drags[0].by, 10, 0, 0));
    CHECK(p[2].drags[0].angle == 0 && p[2].drags[1].region == -1 && p[2].drags[1].angle == 5);
    CHECK(is_vector(p[2].drags[1].axis, 0, 0, 1) && is_vector(p[2].drags[1].by, 0, 0, 0));
    CHECK(p[3].of == 1 && p[3].mode_count == 2 && p[3].modes[0].mode == 2);
    CHECK(p[3].modes[0].by == 15 && p[3].modes[1].by == -1);
    CHECK(p[4].of == 2 && is_vector(p[4].move, 0, 80, 0) && p[4].angle == 20);
    CHECK(is_vector(p[4].axis, 0, 0, 1));
    scene_free(&s);
}

static void outputs_are_read(void)
{
    need_good();
    const scene_output *o = s.bodies[0].outputs;
    CHECK_EQ(s.bodies[0].output_count, 2);
    CHECK(o[0].kind == OUTPUT_SHIFT && o[0].channel == 0 && o[0].region == 1 && o[0].line == 39);
    CHECK(is_vector(o[0].direction, 0.6, 0, 0.8));
    CHECK(o[1].kind == OUTPUT_TURN && o[1].channel == 1 && o[1].region == -1);
    CHECK(is_vector(o[1].direction, 0, 0, 1));
    o = s.bodies[2].outputs;
    CHECK(o[0].kind == OUTPUT_JOINT && o[0].channel == 2 && o[0].joint == 1);
    scene_free(&s);
}

/* cotton and what a body has by default; thickness: scene units of 1 mm. */
static void a_shell_is_read(void)
{
    need_good();
    const scene_body *b = &s.bodies[1];
    CHECK_EQ(b->kind, SCENE_SHELL);
    CHECK(b->young > 1e6 && b->young < 1e9 && b->poisson > 0 && b->poisson < 0.5);
    CHECK(b->density > 100 && b->density < 1000);
    CHECK_NEAR(b->thickness, 0.5e-3, 1e-18);
    CHECK(b->unit == 1e-3 && b->modes == 20 && b->cell == 0 && is_vector(b->gravity, 0, 0, 0));
    CHECK(b->damping[0] == 0 && b->damping[1] == 0 && b->pose_count == 1);
    scene_free(&s);
}

static void a_chain_is_read(void)
{
    need_good();
    const scene_body *b = &s.bodies[2];
    CHECK_EQ(b->kind, SCENE_CHAIN);
    CHECK(b->mesh == 3 && s.meshes[3].file == NULL && s.meshes[3].sides == 2);
    CHECK(b->free_root == 1 && b->link_count == 3);
    CHECK_NEAR(b->root_mass, 0.1, 1e-15);
    CHECK_NEAR(b->width, 0.1 * (40 + 60 + 20) / 3, 1e-12);
    const scene_link *k = b->links;
    CHECK(k[0].parent == -1 && k[0].length == 40 && k[0].angle == 60 && !k[0].stiff);
    CHECK_NEAR(k[0].mass, 0.02, 1e-15);
    CHECK_NEAR(k[0].density[0], 1, 1e-15); /* 1 g/mm */
    CHECK_NEAR(k[0].density[1], 0.5, 1e-15);
    CHECK(k[0].spring == 0.02 && k[0].line == 49);
    CHECK_NEAR(k[1].mass, 0.01, 1e-15);
    CHECK(k[1].parent == 0 && k[1].spring == 0 && k[2].parent == 1 && k[2].stiff);
    const scene_pose *p = b->poses;
    CHECK(p[1].joint_count == 2 && p[1].joint[0] == 1 && p[1].joint_angle[0] == 150);
    CHECK(p[1].joint[1] == 0 && p[1].joint_angle[1] == 20 && is_vector(p[1].move, 1, 2, 0));
    CHECK(p[2].modes[0].mode == 1 && p[2].modes[0].by == 12 && p[2].angle == -9);
    scene_free(&s);
}

static void motions_are_read(void)
{
    need_good();
    const scene_clip *dance = &s.clips[0];
    CHECK_EQ(dance->action_count, 4);
    const scene_action *a = &dance->actions[0];
    CHECK(a->line == 60 && a->body == 0 && a->dynamics == DYNAMICS_ONE_POINT && a->about == 3);
    CHECK(a->has_fixed && a->fixed_count == 1 && a->fixed[0] == 0);
    CHECK(a->has_slides && a->slide_count == 0 && a->stiffness == 2);
    CHECK(a->damping[0] == 1 && a->damping[1] == 0 && a->regularise[2] == 1e-3 && !a->add);
    CHECK_EQ(a->key_count, 3);
    a = &dance->actions[1];
    CHECK(!a->has_fixed && !a->has_slides && a->dynamics == DYNAMICS_COUPLE && a->about == 0);
    CHECK(a->damping[0] == 0.5 && a->damping[1] == 0.002 && a->stiffness == 1);
    CHECK(dance->actions[2].dynamics == DYNAMICS_SPLINE && dance->actions[2].body == 1);
    CHECK(dance->actions[3].dynamics == DYNAMICS_BLEND && dance->actions[3].add == 1);
    CHECK(s.clips[1].actions[0].end[0] == BAKE_END_PERIODIC);
    CHECK(s.clips[1].actions[0].end[1] == BAKE_END_PERIODIC);
    CHECK_EQ(s.clips[1].actions[0].keys[0].has_velocity, 0);
    CHECK_EQ(s.clips[2].actions[0].add, 1);
    scene_free(&s);
}

static void keys_are_read(void)
{
    need_good();
    const scene_body_key *k = s.clips[0].actions[0].keys;
    CHECK(k[0].pose == 0 && k[0].weight == BAKE_HARD && k[0].region == -1 && !k[0].has_velocity);
    CHECK(k[1].time == 0.4 && k[1].pose == 2 && k[1].weight == 10 && k[1].velocity_weight == 3);
    CHECK(k[1].region == 1 && k[1].has_velocity && k[1].velocity_count == 2);
    CHECK(k[1].velocity[0].region == -1 && is_vector(k[1].velocity[0].by, 0, 9, 0));
    CHECK(k[1].velocity[1].region == 1 && k[1].velocity[1].angle == 90);
    CHECK(is_vector(k[1].velocity[1].axis, 0, 1, 0));
    CHECK_NEAR(k[2].time, 0.8, 1e-15);
    k = s.clips[0].actions[3].keys;
    CHECK(k[1].velocity_count == 1 && is_vector(k[1].velocity[0].by, 1, 2, 0));
    CHECK(k[1].rate_count == 1 && k[1].rate_link[0] == 0 && k[1].rate[0] == 90);
    scene_free(&s);
}

/* Whatever the scene said of an end, the keys say it. */
static void ends_are_in_the_keys(void)
{
    need_good();
    const scene_action *a = s.clips[0].actions;
    CHECK(a[0].end[0] == BAKE_END_FREE && a[0].end[1] == BAKE_END_VELOCITY);
    const scene_body_key *k = &a[0].keys[2];
    CHECK(k->has_velocity && k->velocity_count == 1 && k->velocity_weight == BAKE_HARD);
    CHECK(k->velocity[0].region == -1 && is_vector(k->velocity[0].by, 0, 500, 0));
    for (int i = 0; i < 2; i++) { /* one by default, one from its key */
        k = &a[1].keys[i];
        CHECK(a[1].end[i] == BAKE_END_VELOCITY && k->has_velocity && k->velocity_count == 0);
        CHECK(k->velocity_weight == BAKE_HARD);
    }
    CHECK(a[2].end[1] == BAKE_END_FREE && a[2].keys[1].velocity_weight == 7);
    k = s.clips[2].actions[0].keys;
    CHECK(k->has_velocity && k->velocity_count == 0 && k->rate_count == 0);
    scene_free(&s);
}

static void every_wrong_body_is_explained_at_its_line(void)
{
    check_wrongs(good, wrongs, (int)(sizeof wrongs / sizeof *wrongs));
}

static void no_flipped_byte_does_harm(void)
{
    check_flips(good);
}

int main(void)
{
    TEST(a_solid_is_read);
    TEST(regions_are_read);
    TEST(poses_are_read);
    TEST(outputs_are_read);
    TEST(a_shell_is_read);
    TEST(a_chain_is_read);
    TEST(motions_are_read);
    TEST(keys_are_read);
    TEST(ends_are_in_the_keys);
    TEST(every_wrong_body_is_explained_at_its_line);
    TEST(no_flipped_byte_does_harm);
    return check_done();
}
