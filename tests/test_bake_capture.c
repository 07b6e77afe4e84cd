/* Captured curves: hinge angles against an independent BVH reader, CSV rows, cuts and errors.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "check.h"
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MODELS "/usr/share/assimp/models/" /* Debian package assimp-testmodels */
#define SCENES "tests/scenes/"

/* Assimp multiplies float32 matrices, so a quaternion is off by a few units of 2^-24 per component,
 * and takes the time from 1 / "Frame Time" in float32. The angle 2 atan2(s, c) is then off by
 * 2 x 4e-7 / hypot(s, c) rad; all joints below keep hypot >= 0.25: 1.9e-4 degrees. */
static const double angle_tolerance = 2e-4;
static const double time_tolerance = 1e-5;

static scene_source source;
static scene_curve curve;
static bake_error error;

/* One curve of one source, as a scene would hold it. */
static int load(capture *out)
{
    scene s = {.path = "a.yaml", .source_count = 1, .sources = &source};
    error.text[0] = '\0';
    return capture_load(&s, &curve, out, &error);
}

static void ask_node(const char *file, const char *node, double x, double y, double z)
{
    source = (scene_source){.name = "motion", .file = (char *)(size_t)file};
    curve = (scene_curve){.line = 7,
                          .kind = CURVE_CAPTURED,
                          .node = (char *)(size_t)node,
                          .axis = {x, y, z},
                          .scale = 1};
}

static void ask_column(const char *file, const char *column)
{
    ask_node(file, NULL, 0, 0, 0);
    curve.column = (char *)(size_t)column;
}

static int message_is(const char *start, const char *part)
{
    int ok = strncmp(error.text, start, strlen(start)) == 0 && strstr(error.text, part) != NULL;
    if (!ok)
        printf("message: %s\n", error.text);
    return ok;
}

/* Compares every sample of the asked curve with the oracle's line for it. */
static void compare_with_oracle(const char *extra, double tolerance)
{
    char command[400];
    snprintf(command, sizeof command,
             "/usr/bin/python3 tests/reference/bvh_oracle.py %s %s %.17g %.17g %.17g %s",
             source.file, curve.node, curve.axis[0], curve.axis[1], curve.axis[2], extra);
    capture got;
    CHECK_EQ(load(&got), 0);
    FILE *oracle = popen(command, "r");
    CHECK(oracle != NULL && error.text[0] == '\0');
    double time, value, worst = 0, worst_time = 0, turn = 0;
    int count = 0;
    for (; count < got.count && fscanf(oracle, "%lf %lf", &time, &value) == 2; count++) {
        if (count == 0 && extra[0] == '\0')
            turn = 360 * round((got.value[0] - value) / 360);
        worst = fmax(worst, fabs(got.value[count] - value - turn));
        worst_time = fmax(worst_time, fabs(got.time[count] - time));
    }
    CHECK(count > 1 && fscanf(oracle, "%lf", &time) != 1); /* no line is left */
    CHECK_EQ(pclose(oracle), 0);
    CHECK_EQ(count, got.count);
    CHECK_NEAR(worst, 0, tolerance);
    CHECK_NEAR(worst_time, 0, time_tolerance);
    printf("%-16s %5d samples, off by %.1e at most\n", curve.node, count, worst);
    capture_free(&got);
}

static void hinge_angles_equal_the_oracles_for_every_euler_order(void)
{
    ask_node(SCENES "arm.bvh", "Upper", 1, 0, 0);
    compare_with_oracle("", angle_tolerance);
    ask_node(SCENES "arm.bvh", "Lower", 0, 0, 1);
    compare_with_oracle("", angle_tolerance);
    ask_node(SCENES "arm.bvh", "Lower", 0.6, 0, 0.8);
    compare_with_oracle("", angle_tolerance);
}

static void a_turn_of_800_degrees_is_unwrapped(void)
{
    ask_node(SCENES "arm.bvh", "Body", 0, 1, 0);
    compare_with_oracle("", angle_tolerance);
    capture got;
    CHECK_EQ(load(&got), 0);
    CHECK(got.value[0] > -180 && got.value[0] <= 180);
    CHECK_NEAR(got.value[got.count - 1] - got.value[0], 800, 1);
    capture_free(&got);
}

static void walking_hips_knees_and_elbows_equal_the_oracles(void)
{
    ask_node(MODELS "BVH/01_01.bvh", "LeftUpLeg", 1, 0, 0);
    compare_with_oracle("", angle_tolerance);
    ask_node(MODELS "BVH/01_01.bvh", "RightLeg", 1, 0, 0);
    compare_with_oracle("", angle_tolerance);
    ask_node(MODELS "BVH/01_01.bvh", "LeftForeArm", 0, -0.8, 0.6);
    compare_with_oracle("", angle_tolerance);
    ask_node(MODELS "BVH/01_03.bvh", "RightArm", 0, 0, 1);
    compare_with_oracle("", angle_tolerance);
}

/* This file has one row more than its header says. */
static void the_puppets_joints_equal_the_oracles(void)
{
    ask_node(MODELS "BVH/Boxing_Toes.bvh", "LeftKnee", 1, 0, 0);
    compare_with_oracle("", angle_tolerance);
    ask_node(MODELS "BVH/Boxing_Toes.bvh", "RightShoulder", 0, 0, 1);
    compare_with_oracle("", angle_tolerance);
    ask_node(MODELS "BVH/Boxing_Toes.bvh", "Neck", 0, 1, 0);
    compare_with_oracle("", angle_tolerance);
}

/* Positions up to 30 in float32: 2^-24 x 32. */
static void a_translation_is_the_way_from_the_bind_position(void)
{
    ask_node(SCENES "arm.bvh", "Body", 0, 0.6, 0.8);
    curve.component = CAPTURE_TRANSLATION;
    compare_with_oracle("way", 5e-6);
}

static void a_cut_starts_at_zero_with_interpolated_ends(void)
{
    capture all, part;
    ask_node(SCENES "arm.bvh", "Upper", 1, 0, 0);
    CHECK_EQ(load(&all), 0);
    curve.from = 0.51;
    curve.to = 1.24;
    curve.scale = -2;
    curve.offset = 100;
    CHECK_EQ(load(&part), 0);
    /* Frames 0.525 .. 1.225 s are inside: 29 of them, and the two ends. */
    CHECK_EQ(part.count, 31);
    CHECK_NEAR(part.time[0], 0, 0);
    CHECK_NEAR(part.time[30], 0.73, 1e-6);
    CHECK_NEAR(part.time[1], 0.015, 1e-6);
    CHECK_NEAR(part.value[1], 100 - 2 * all.value[21], 1e-9);
    CHECK_NEAR(part.value[0], 100 - 2 * (0.6 * all.value[20] + 0.4 * all.value[21]), 1e-3);
    capture_free(&all);
    capture_free(&part);
    curve.to = 2.5;
    CHECK_EQ(load(&part), -1);
    CHECK(message_is("a.yaml:7: ", "lasts from 0 to 2 s"));
    CHECK(part.time == NULL && part.count == 0);
}

/* The sample's node turns about z in 0.5 s steps: 0, 0, 45, 90, 90, 90 degrees and back. */
static void gltf_poses_are_joined_by_arcs_in_steps_of_two_degrees(void)
{
    capture got;
    ask_node(MODELS "glTF2/simple_skin/simple_skin.gltf", "nodes[2]", 0, 0, 1);
    CHECK_EQ(load(&got), 0);
    CHECK_NEAR(got.time[got.count - 1], 5.5, 1e-6);
    double highest = 0, step = 0;
    for (int i = 0; i < got.count; i++) {
        highest = fmax(highest, got.value[i]);
        if (i > 0)
            step = fmax(step, fabs(got.value[i] - got.value[i - 1]));
    }
    CHECK_NEAR(highest, 90, 0.01); /* the file writes 0.707 for sin 45 deg */
    CHECK(step <= 2.0001 && got.count > 90);
    capture_free(&got);
}

/* At rest turned by 50 degrees about (1, 2, -1), the node turns about its parent's (2, -1, 2). */
static void the_bind_rotation_is_taken_off(void)
{
    capture got;
    ask_node(SCENES "bent.gltf", "Bent", 2.0 / 3, -1.0 / 3, 2.0 / 3);
    CHECK_EQ(load(&got), 0);
    CHECK_EQ(got.count, 11);
    for (int i = 0; i < got.count; i++)
        CHECK_NEAR(got.value[i], 10 * i - 30, angle_tolerance);
    capture_free(&got);
}

static void an_fbx_joint_is_found_by_its_own_name(void)
{
    capture got;
    ask_node(MODELS "FBX/animation_with_skeleton.fbx", "Bone.001", 0, 0, 1);
    CHECK_EQ(load(&got), 0);
    CHECK_NEAR(got.time[got.count - 1], 20.0 / 24, 1e-6);
    CHECK(fabs(got.value[got.count - 1] - got.value[0]) < 90);
    capture_free(&got);
}

static void names_and_numbers_that_are_not_there_are_explained(void)
{
    capture got;
    ask_node(SCENES "arm.bvh", "Uper", 1, 0, 0);
    CHECK_EQ(load(&got), -1);
    CHECK(message_is("a.yaml:7: ", "did you mean 'Upper'?"));
    ask_node(SCENES "arm.bvh", "EndSite_Lower", 1, 0, 0);
    CHECK_EQ(load(&got), -1);
    CHECK(message_is("a.yaml:7: ", "does not move the node 'EndSite_Lower'"));
    ask_node(SCENES "arm.bvh", "Upper", 1, 0, 0);
    source.animation = 1;
    CHECK_EQ(load(&got), -1);
    CHECK(message_is("a.yaml:7: ", "has 1 animations"));
    ask_node(SCENES "plain.csv", "Upper", 1, 0, 0); /* no format of Assimp's */
    CHECK_EQ(load(&got), -1);
    CHECK(message_is("a.yaml:7: ", "cannot be read"));
}

static void an_angle_across_the_axis_is_refused(void)
{
    capture got;
    ask_node(SCENES "half_turn.bvh", "Arm", 1, 0, 0);
    CHECK_EQ(load(&got), -1);
    CHECK(message_is("a.yaml:7: at 0.2 s", "choose another axis"));
    ask_node(SCENES "half_turn.bvh", "Arm", 0, 0, 1);
    CHECK_EQ(load(&got), 0);
    double highest = 0;
    for (int i = 0; i < got.count; i++)
        highest = fmax(highest, got.value[i]);
    CHECK_NEAR(highest, 180, angle_tolerance);
    CHECK_NEAR(got.value[got.count - 1], 170, angle_tolerance);
    capture_free(&got);
}

static void csv_columns_are_found_by_name_and_by_number(void)
{
    capture got;
    ask_column(SCENES "log.csv", "hip angle");
    CHECK_EQ(load(&got), 0);
    CHECK_EQ(got.count, 4);
    CHECK_NEAR(got.time[0], 0, 0);
    CHECK_NEAR(got.time[3], 1.5, 1e-12);
    CHECK_NEAR(got.value[2], -7.25, 1e-12);
    capture_free(&got);
    ask_column(SCENES "log.csv", "1");
    CHECK_EQ(load(&got), 0);
    CHECK_NEAR(got.value[1], 11, 1e-12);
    capture_free(&got);
    ask_column(SCENES "plain.csv", "3");
    curve.scale = 2;
    CHECK_EQ(load(&got), 0);
    CHECK_EQ(got.count, 3);
    CHECK_NEAR(got.value[2], 600, 1e-12);
    capture_free(&got);
}

/* Writes a CSV of its own, loads its column and returns the result. */
static int load_text(const char *text, const char *column)
{
    capture got;
    FILE *file = fopen("build/capture_test.csv", "w");
    CHECK(file != NULL);
    fputs(text, file);
    fclose(file);
    ask_column("build/capture_test.csv", column);
    int err = load(&got);
    capture_free(&got);
    return err;
}

static void csv_errors_name_the_file_and_the_line(void)
{
    const char *file = "build/capture_test.csv:";
    CHECK_EQ(load_text("time,a\n0,1\n1,x\n", "a"), -1);
    CHECK(message_is(file, ":3: expected a number, found 'x'"));
    CHECK_EQ(load_text("time,a\n0,1\n\n1,nan\n", "a"), -1);
    CHECK(message_is(file, ":4: expected a number, found 'nan'"));
    CHECK_EQ(load_text("time,a\n0,1\n1\n", "a"), -1);
    CHECK(message_is(file, ":3: the row has 1 columns, 2 are needed"));
    CHECK_EQ(load_text("time,a\n0,1\n0,2\n", "a"), -1);
    CHECK(message_is(file, ":3: times must ascend"));
    CHECK_EQ(load_text("time,a\n0,1\n", "a"), -1);
    CHECK(message_is(file, ":2: the file has 1 rows of numbers"));
    CHECK_EQ(load_text("", "a"), -1);
    CHECK(message_is(file, ":0: the file has 0 rows"));
    CHECK_EQ(load_text("time,speed\n0,1\n1,2\n", "sped"), -1);
    CHECK(message_is("a.yaml:7: ", "did you mean 'speed'?"));
    CHECK_EQ(load_text("0,1\n1,2\n", "speed"), -1);
    CHECK(message_is("a.yaml:7: ", "no header row"));
    CHECK_EQ(load_text("0,1\n1,2\n", "3"), -1);
    CHECK(message_is("a.yaml:7: ", "no column '3'"));
    CHECK_EQ(load_text("a,time\n0,1\n1,2\n", "time"), -1);
    CHECK(message_is("a.yaml:7: ", "holds the times"));
    CHECK_EQ(load_text("\xef\xbb\xbftime;a\r\n0;1\r\n1;2\r\n", "a"), 0);
}

int main(void)
{
    TEST(hinge_angles_equal_the_oracles_for_every_euler_order);
    TEST(a_turn_of_800_degrees_is_unwrapped);
    TEST(walking_hips_knees_and_elbows_equal_the_oracles);
    TEST(the_puppets_joints_equal_the_oracles);
    TEST(a_translation_is_the_way_from_the_bind_position);
    TEST(a_cut_starts_at_zero_with_interpolated_ends);
    TEST(gltf_poses_are_joined_by_arcs_in_steps_of_two_degrees);
    TEST(the_bind_rotation_is_taken_off);
    TEST(an_fbx_joint_is_found_by_its_own_name);
    TEST(names_and_numbers_that_are_not_there_are_explained);
    TEST(an_angle_across_the_axis_is_refused);
    TEST(csv_columns_are_found_by_name_and_by_number);
    TEST(csv_errors_name_the_file_and_the_line);
    return check_done();
}
