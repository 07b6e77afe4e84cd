/* Captures on rigs: bones turn as an independent reader of BVH says joints do, whatever way they
 * point at rest; cuts, corners, and what damaged sources do.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_take.h"
#include "check.h"
#include "rig.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BVH    "/usr/share/assimp/models/BVH/" /* Debian package assimp-testmodels */
#define SCENES "tests/scenes/"
#define ORACLE "/usr/bin/python3 -B tests/reference/rig_oracle.py "

static const char scratch[] = "build/take_scene.yaml", damaged[] = "build/take_damaged.bvh";

/* Assimp makes a quaternion of three Euler angles in float32: a few units of 2^-24 in a component,
 * less than 8e-7 rad for a joint. 10 joints above one another sum up to 8e-6 at the most. */
static const double turn_tolerance = 1e-5;

static scene s;
static bake_error error;
static double *values;

static void write_text(const char *path, const char *text, size_t size)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(text, 1, size, file) != size) {
        printf("%s: cannot be written\n", path);
        exit(1);
    }
    fclose(file);
}

static void run(const char *command)
{
    if (system(command) != 0) {
        printf("failed: %s\n", command);
        exit(1);
    }
}

/* 0: the scene of build/take_scene.yaml has its takes; the caller frees it. */
static int take_scene(void)
{
    error.text[0] = '\0';
    if (scene_load(scratch, &s, &error)) {
        printf("%s\n", error.text);
        exit(1);
    }
    int err = rig_takes(&s, &error);
    values = bake_alloc((size_t)s.channel_count, sizeof *values);
    return err;
}

static void drop_scene(void)
{
    free(values);
    scene_free(&s);
}

/* A scene around one rig with the bones `bones`, its clip with the take's fields `take`. */
static int take_text(const char *source, const char *bones, const char *take)
{
    char text[2048];
    int size =
        snprintf(text, sizeof text,
                 "channels: [{name: a}]\nsources: [{name: motion, file: %s}]\n"
                 "meshes: [{name: body, file: ../tests/scenes/house.obj}]\nrigs:\n- name: man\n  "
                 "mesh: body\n"
                 "  bones: [%s]\nclips:\n- name: go\n  rigs: [{rig: man, source: motion%s}]\n",
                 source, bones, take);
    write_text(scratch, text, (size_t)size);
    return take_scene();
}

/* All channels at sample i of every curve. */
static void pose_sample(int i, rig_bone *bones)
{
    for (int k = 0; k < s.channel_count; k++)
        values[k] = s.channels[k].rest;
    for (int k = 0; k < s.clips[0].curve_count; k++) {
        const scene_curve *c = &s.clips[0].curves[k];
        values[c->channel] = c->samples->value[i];
    }
    rig_pose(&s.rigs[0], values, bones);
}

static double unit_quaternions(void)
{
    double worst = 0;
    for (int b = 0; b < s.rigs[0].bone_count; b++) {
        const scene_curve *c = s.clips[0].curves;
        while (c->channel != s.rigs[0].bones[b].captured)
            c++;
        for (int i = 0; i < c->samples->count; i++) {
            double square = 0, dot = 0;
            for (int k = 0; k < 4; k++) {
                square += c[k].samples->value[i] * c[k].samples->value[i];
                dot += i > 0 ? c[k].samples->value[i] * c[k].samples->value[i - 1] : 1;
            }
            worst = fmax(worst, fabs(square - 1));
            CHECK(dot > 0); /* no jump to the other side */
            CHECK(i > 0 || c[0].samples->value[0] >= 0);
        }
    }
    return worst;
}

static void curves_ascend(void)
{
    const scene_clip *clip = &s.clips[0];
    for (int k = 1; k < clip->curve_count; k++)
        CHECK(clip->curves[k].channel > clip->curves[k - 1].channel);
}

/* ---- against the oracle ---------------------------------------------------------------------- */

/* Of a joint in one frame. */
typedef struct {
    double at[3], turn[9], end[3];
} joint_now;

static int read_joint(FILE *from, joint_now *to)
{
    double *all[3] = {to->at, to->turn, to->end};
    const int count[3] = {3, 9, 3};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < count[i]; k++)
            if (fscanf(from, "%lf", &all[i][k]) != 1)
                return -1;
    return 0;
}

/* The largest distances of places, elements of rotations, and directions from the oracle's. */
typedef struct {
    double at, turn, way;
} distances;

static void compare_bone(const scene_bone *b, const rig_bone *now, const joint_now *want,
                         distances *worst)
{
    double way[3], rest[3], length = 0, other = 0;
    for (int k = 0; k < 3; k++) {
        worst->at = fmax(worst->at, fabs(now->at[k] - want->at[k]));
        rest[k] = b->to[k] - b->from[k];
        way[k] = want->end[k] - want->at[k];
        length += rest[k] * rest[k];
        other += way[k] * way[k];
    }
    for (int k = 0; k < 9; k++)
        worst->turn = fmax(worst->turn, fabs(now->turn[k] - want->turn[k]));
    for (int r = 0; r < 3 && length > 0 && other > 0; r++) {
        const double *row = now->turn + 3 * r;
        double got = (row[0] * rest[0] + row[1] * rest[1] + row[2] * rest[2]) / sqrt(length);
        worst->way = fmax(worst->way, fabs(got - way[r] / sqrt(other)));
    }
}

/* The joints of a file that the rig's bones follow, in the file's order. */
static int list_joints(const char *path, int *bone, int room)
{
    FILE *file = fopen(path, "r");
    char word[256];
    int count = 0, named = 0;
    while (count < room && fscanf(file, "%255s", word) == 1 && strcmp(word, "MOTION") != 0) {
        if (named) {
            bone[count] = -1;
            for (int i = 0; i < s.rigs[0].bone_count; i++)
                if (strcmp(s.rigs[0].bones[i].node, word) == 0)
                    bone[count] = i;
            count++;
        }
        named = strcmp(word, "ROOT") == 0 || strcmp(word, "JOINT") == 0;
    }
    fclose(file);
    return count;
}

static distances compare_poses(const char *path)
{
    char command[400];
    int bone[64];
    snprintf(command, sizeof command, ORACLE "bvh-poses %s", path);
    FILE *oracle = popen(command, "r");
    int joints = list_joints(path, bone, 64), frames = s.clips[0].curves[0].samples->count;
    rig_bone *now = bake_alloc((size_t)s.rigs[0].bone_count, sizeof *now);
    distances worst = {0, 0, 0};
    joint_now want;
    double start[3] = {0};
    for (int f = 0; f < frames && check_ok; f++) {
        pose_sample(f, now);
        for (int j = 0; j < joints; j++) {
            CHECK_EQ(read_joint(oracle, &want), 0);
            for (int k = 0; k < 3; k++) { /* the root begins where the rig's stands */
                start[k] = f + j == 0 ? want.at[k] - s.rigs[0].bones[bone[0]].from[k] : start[k];
                want.at[k] -= start[k];
                want.end[k] -= start[k];
            }
            if (bone[j] >= 0)
                compare_bone(&s.rigs[0].bones[bone[j]], &now[bone[j]], &want, &worst);
        }
    }
    CHECK_EQ(read_joint(oracle, &want), -1); /* no frame is left */
    CHECK_EQ(pclose(oracle), 0);
    free(now);
    printf("%s: %d bones, %d frames: places off by %.1e, rotations %.1e, directions %.1e\n", path,
           s.rigs[0].bone_count, frames, worst.at, worst.turn, worst.way);
    return worst;
}

static void take_oracles_rig(const char *path, const char *kind)
{
    char command[400];
    snprintf(command, sizeof command, ORACLE "bvh-scene %s %s > %s", path, kind, scratch);
    run(command);
    CHECK_EQ(take_scene(), 0);
    CHECK(error.text[0] == '\0');
    CHECK_NEAR(unit_quaternions(), 0, 1e-12); /* what rounding leaves of 1 */
    curves_ascend();
}

/* How far any part of the body is from its root. */
static double reach(void)
{
    double most = 0;
    for (int i = 0; i < s.rigs[0].bone_count; i++)
        for (int k = 0; k < 3; k++)
            most = fmax(most, fabs(s.rigs[0].bones[i].to[k]));
    return most;
}

static void a_rig_like_the_capture_stands_where_its_joints_are(void)
{
    static const char *const files[] = {BVH "Boxing_Toes.bvh", BVH "01_01.bvh", SCENES "arm.bvh"};
    for (int i = 0; i < 3; i++) {
        take_oracles_rig(files[i], "own");
        distances d = compare_poses(files[i]);
        /* The root's place is a float32 of at most 256. */
        CHECK_NEAR(d.at, 0, turn_tolerance * reach() + 1.6e-5);
        CHECK_NEAR(d.turn, 0, turn_tolerance);
        drop_scene();
    }
}

/* One of its bones points against the capture's. */
static void bones_that_rest_elsewhere_point_where_the_capture_does(void)
{
    take_oracles_rig(BVH "Boxing_Toes.bvh", "turned");
    distances d = compare_poses(BVH "Boxing_Toes.bvh");
    CHECK_NEAR(d.way, 0, turn_tolerance);
    CHECK(d.turn > 1); /* they are turned otherwise */
    drop_scene();
}

static void a_rig_of_few_bones_turns_with_the_joints_between_them(void)
{
    take_oracles_rig(BVH "Boxing_Toes.bvh", "few");
    distances d = compare_poses(BVH "Boxing_Toes.bvh");
    CHECK_NEAR(d.turn, 0, turn_tolerance);
    drop_scene();
}

/* ---- cuts ------------------------------------------------------------------------------------ */

static const char body[] = "{name: Body, at: [0, 0, 0], node: Body}";

static const capture *curve_of(int channel)
{
    for (int k = 0; k < s.clips[0].curve_count; k++)
        if (s.clips[0].curves[k].channel == channel)
            return s.clips[0].curves[k].samples;
    return NULL;
}

/* Frames of 1/24 s (float32 in Assimp): half way between two the turn is half way on the arc. */
static void a_cut_begins_and_ends_between_frames(void)
{
    CHECK_EQ(take_text("../" SCENES "arm.bvh", body, ""), 0);
    int channel = s.rigs[0].bones[0].captured;
    const capture *c[4];
    double before[4], after[4], half[4], length = 0;
    double from = 0, to = 0;
    for (int k = 0; k < 4; k++) {
        c[k] = curve_of(channel + k);
        before[k] = c[k]->value[3];
        after[k] = c[k]->value[4];
        half[k] = before[k] + after[k];
        length += half[k] * half[k];
    }
    from = (c[0]->time[3] + c[0]->time[4]) / 2;
    to = c[0]->time[9];
    drop_scene();
    char take[100];
    snprintf(take, sizeof take, ", from: %.9f, to: %.9f", from, to);
    CHECK_EQ(take_text("../" SCENES "arm.bvh", body, take), 0);
    const capture *w = curve_of(channel);
    CHECK_EQ(w->count, 7); /* the cut, frames 4 .. 9 */
    CHECK(w->time[0] == 0);
    CHECK_NEAR(w->time[6], to - from, 2e-9);
    double sign = half[0] < 0 ? -1 : 1;
    for (int k = 0; k < 4; k++)
        CHECK_NEAR(curve_of(channel + k)->value[0], sign * half[k] / sqrt(length), 1e-7);
    drop_scene();
}

static void a_root_travels_from_where_it_begins_times_scale(void)
{
    CHECK_EQ(take_text(BVH "01_01.bvh", "{name: hip, at: [0, 50, 0], node: Hips}",
                       ", travel: true, scale: 2.5"),
             0);
    /* The file's first frame begins "9.3722 17.8693 -17.3198", its last "8.8787 17.8124 38.5426".
     * Float32, of numbers below 64: 2^-19 each. */
    int first = s.rigs[0].bones[0].travels;
    CHECK(first >= 0);
    int last = curve_of(first)->count - 1;
    const double way[3] = {8.8787 - 9.3722, 17.8124 - 17.8693, 38.5426 + 17.3198};
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(curve_of(first + k)->value[0], 0, 1e-12);
        CHECK_NEAR(curve_of(first + k)->value[last], 2.5 * way[k], 2.5 * 2 * 2e-6);
    }
    drop_scene();
    CHECK_EQ(take_text(BVH "01_01.bvh", "{name: hip, at: [0, 50, 0], node: Hips}", ""), 0);
    CHECK(s.rigs[0].bones[0].travels < 0);
    CHECK_EQ(s.clips[0].curve_count, 4);
    drop_scene();
}

/* ---- what cannot be -------------------------------------------------------------------------- */

static void refuse(const char *source, const char *bones, const char *take, const char *words)
{
    CHECK_EQ(take_text(source, bones, take), -1);
    char start[80];
    snprintf(start, sizeof start, "%s:%d: ", scratch, 10);
    if (strncmp(error.text, start, strlen(start)) != 0 || strstr(error.text, words) == NULL) {
        check_ok = 0;
        printf("expected %s%s\n     got %s\n", start, words, error.text);
    }
    CHECK_EQ(s.clips[0].curve_count, 0);
    drop_scene();
}

static void messages_say_what_is_there(void)
{
    refuse(BVH "01_01.bvh", "{name: a, at: [0, 0, 0], node: LeftUpleg}", "",
           "has no node 'LeftUpleg'; did you mean 'LeftUpLeg'?");
    refuse("../" SCENES "house.obj", body, "", "has no animation");
    refuse("../" SCENES "morph.gltf", body, "", "node");
    refuse("../" SCENES "arm.bvh", body, ", from: 100, to: 200",
           "the capture is asked for 100 .. 200 s");
}

/* Whatever a file holds: curves, or one message of the scene's line. */
static void try_damaged(void)
{
    int err = take_text("take_damaged.bvh", body, ", travel: true");
    CHECK(err == 0 || (err == -1 && strstr(error.text, "take_scene.yaml:10: ") != NULL));
    for (int k = 0; k < s.clips[0].curve_count; k++) {
        const capture *c = s.clips[0].curves[k].samples;
        for (int i = 0; i < c->count; i++)
            if (!isfinite(c->value[i]) || !isfinite(c->time[i]))
                CHECK(!"a sample is no number");
    }
    drop_scene();
}

static void damaged_captures_are_told_and_crash_nothing(void)
{
    static char text[1 << 16];
    static const char *const poison[] = {"nan", "inf", "1e39", "-", "{", "}", "CHANNELS 99"};
    FILE *file = fopen(SCENES "arm.bvh", "rb");
    size_t size = fread(text, 1, sizeof text - 64, file);
    fclose(file);
    for (size_t i = 0; i < 20; i++) { /* cut off */
        write_text(damaged, text, size * i / 20);
        try_damaged();
    }
    unsigned random = 1;
    for (int i = 0; i < 60; i++) { /* a word replaced */
        static char copy[1 << 16];
        random = random * 1664525u + 1013904223u;
        size_t at = (random >> 8) % (size - 1), end = at;
        while (at > 0 && strchr(" \n\t", text[at - 1]) == NULL)
            at--;
        while (end < size && strchr(" \n\t", text[end]) == NULL)
            end++;
        const char *word = poison[i % 7];
        int head = snprintf(copy, sizeof copy, "%.*s%s", (int)at, text, word);
        memcpy(copy + head, text + end, size - end);
        write_text(damaged, copy, (size_t)head + size - end);
        try_damaged();
    }
}

int main(void)
{
    TEST(a_rig_like_the_capture_stands_where_its_joints_are);
    TEST(bones_that_rest_elsewhere_point_where_the_capture_does);
    TEST(a_rig_of_few_bones_turns_with_the_joints_between_them);
    TEST(a_cut_begins_and_ends_between_frames);
    TEST(a_root_travels_from_where_it_begins_times_scale);
    TEST(messages_say_what_is_there);
    TEST(damaged_captures_are_told_and_crash_nothing);
    return check_done();
}
