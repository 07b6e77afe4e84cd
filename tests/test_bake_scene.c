/* Scene files: what is read from the examples, what is said about 173 wrong ones, and that no
 * damaged one does harm.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_text.h"
#include "wiggly_format.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PI 3.14159265358979323846

static const char nod[] = "examples/nod/nod.yaml";
static const char buses[] = "tests/scenes/buses.yaml";
static const char meshes[] = "tests/scenes/meshes.yaml";
static const char puppet[] = "examples/puppet/puppet.yaml";

static const scene_curve *curve_of(const char *clip, const char *channel)
{
    for (int i = 0; i < s.clip_count; i++)
        for (int j = 0; strcmp(s.clips[i].name, clip) == 0 && j < s.clips[i].curve_count; j++)
            if (strcmp(s.channels[s.clips[i].curves[j].channel].name, channel) == 0)
                return &s.clips[i].curves[j];
    printf("no curve %s %s\n", clip, channel);
    exit(1);
}

static void nod_channels_clips_and_layers_are_read(void)
{
    CHECK_EQ(load(nod), 0);
    CHECK_EQ(s.channel_count, 12);
    CHECK_EQ(s.channels[0].unit, WG_UNIT_DEGREE);
    CHECK_NEAR(s.channels[2].rest, 2, 0);
    CHECK_NEAR(s.channels[0].tolerance, 0.1, 0);
    CHECK_NEAR(s.channels[0].range[1], 30, 0);
    CHECK_NEAR(s.tick_rate, 120, 0);
    CHECK_EQ(s.clip_count, 3);
    CHECK_EQ(s.clips[0].end, WG_END_LOOP);
    CHECK_NEAR(s.clips[0].duration, 6, 0);
    CHECK(!s.clips[0].additive && s.clips[1].additive && s.clips[2].additive);
    CHECK_EQ(s.event_name_count, 1);
    CHECK_EQ(s.clips[0].event_count, 2);
    CHECK_NEAR(s.clips[0].events[1].time, 5.25, 0);
    CHECK_EQ(s.layers[0].clip, 0);
    CHECK_EQ(s.layers[1].clip, -1);
    CHECK_EQ(s.layers[2].mode, WG_MODE_ADD);
    CHECK_EQ(s.layers[2].mask, 1);
    CHECK_NEAR(s.masks[1].weight[0], 0.5, 1e-15);
    CHECK_NEAR(s.masks[1].weight[1], 0, 0);
    CHECK_EQ(s.filters[0].op, WG_FILTER_CLAMP);
    CHECK_NEAR(s.filters[0].b, 45, 0);
    CHECK_EQ(s.filters[2].op, WG_FILTER_MIN);
    CHECK_EQ(s.triggers[0].layer, 1);
    CHECK_EQ(s.triggers[0].clip, 1);
    for (int i = 1; i < s.clips[0].curve_count; i++)
        CHECK(s.clips[0].curves[i].channel > s.clips[0].curves[i - 1].channel);
    scene_free(&s);
}

static void nod_curves_are_read(void)
{
    CHECK_EQ(load(nod), 0);
    const scene_curve *c = curve_of("nod", "antenna_left");
    double omega = 2 * PI * 2.9;
    CHECK_EQ(c->kind, CURVE_WIGGLY);
    CHECK_NEAR(c->mode.lambda, omega * omega, 1e-9);
    CHECK_NEAR(c->mode.delta, 0.1 * omega, 1e-12);
    CHECK(c->end[0] == BAKE_END_PERIODIC && c->end[1] == BAKE_END_PERIODIC);
    CHECK(c->keys[3].weight[0] == BAKE_HARD && c->keys[3].weight[1] == 0);
    c = curve_of("startle", "antenna_left");
    CHECK_NEAR(c->mode.lambda, 332, 0);
    CHECK_NEAR(c->mode.delta, 1.28, 0);
    c = curve_of("startle", "ear_left");
    CHECK(c->end[0] == BAKE_END_VELOCITY && c->end_value[0] == 0 && c->end[1] == BAKE_END_FREE);
    CHECK_NEAR(c->keys[2].weight[0], 5, 0);
    CHECK_EQ(curve_of("nod", "lid_left")->kind, CURVE_BSPLINE);
    CHECK_EQ(curve_of("nod", "lid_right")->kind, CURVE_LINEAR);
    CHECK_EQ(curve_of("nod", "glow")->kind, CURVE_HELD);
    CHECK_EQ(curve_of("nod", "jaw")->kind, CURVE_CUBIC);
    scene_free(&s);
}

/* Positions: quarter microseconds. */
static void nod_servos_are_in_protocol_units(void)
{
    CHECK_EQ(load(nod), 0);
    CHECK_EQ(s.servo_count, 11);
    const scene_servo *turn = &s.servos[1], *jaw = &s.servos[2], *ear = &s.servos[6];
    for (int i = 0; i < s.servo_count; i++)
        CHECK_EQ(s.servos[i].protocol, WG_PROTOCOL_MAESTRO);
    CHECK_NEAR(turn->centre, 4 * 1500, 0);
    CHECK_NEAR(turn->min, 4 * 900, 0);
    CHECK_NEAR(turn->velocity, 300 * 40, 1e-9);
    CHECK_NEAR(turn->acceleration, 6000 * 40, 1e-9);
    CHECK_EQ(jaw->id, 0);
    CHECK_NEAR(jaw->centre, 4 * (1400 + 12), 0);
    CHECK_NEAR(jaw->gain, 40, 0);
    CHECK_NEAR(jaw->max, 6800, 0);
    CHECK_NEAR(jaw->velocity, 0, 0);
    CHECK_NEAR(ear->gain, -4 * 900.0 / 90, 1e-12);
    scene_free(&s);
}

/* Positions: 4096ths of a turn. */
static void dynamixels_are_in_steps(void)
{
    CHECK_EQ(load(buses), 0);
    CHECK_EQ(s.servo_count, 5);
    const scene_servo *a = &s.servos[0], *b = &s.servos[1];
    CHECK_EQ(a->protocol, WG_PROTOCOL_DYNAMIXEL2);
    CHECK_NEAR(a->centre, 2048, 1e-9);
    CHECK_NEAR(a->gain, 4096.0 / 360, 1e-12);
    CHECK_NEAR(a->min, 120 * 4096.0 / 360, 1e-9);
    CHECK_NEAR(b->centre, 2048, 0);
    CHECK_NEAR(b->max, 3000, 0);
    CHECK_NEAR(b->velocity, 300 * 4096.0 / 360, 1e-9);
    CHECK_NEAR(b->acceleration, 4000 * 4096.0 / 360, 1e-9);
    CHECK_EQ(s.servos[3].protocol, WG_PROTOCOL_PCA9685);
    scene_free(&s);
}

static void the_puppet_is_read(void)
{
    CHECK_EQ(load(puppet), 0);
    CHECK_EQ(s.servo_count, 12);
    for (int i = 0; i < s.servo_count; i++)
        CHECK_EQ(s.servos[i].id, i);
    CHECK(strcmp(s.servos[3].name, "hip_right") == 0);
    CHECK_NEAR(s.servos[0].velocity, 650 * 40, 1e-9);
    const scene_curve *c = curve_of("boxing", "elbow_left");
    CHECK_EQ(c->kind, CURVE_CAPTURED);
    CHECK_EQ(c->source, 0);
    CHECK_EQ(c->component, CAPTURE_ROTATION);
    CHECK(strcmp(c->node, "LeftElbow") == 0 && c->column == NULL);
    CHECK_NEAR(c->axis[1], -0.9 / hypot(0.9, 0.44), 1e-12);
    CHECK_NEAR(c->scale, 0.4, 0);
    CHECK_NEAR(c->offset, -31, 0);
    CHECK(c->from == 6 && c->to == 14);
    scene_free(&s);
}

/* Every joint of the puppet stays inside its servo's limits and below its velocity. */
static void the_puppets_motion_suits_its_servos(void)
{
    CHECK_EQ(load(puppet), 0);
    for (int i = 0; i < s.clips[0].curve_count; i++) {
        const scene_curve *c = &s.clips[0].curves[i];
        const scene_servo *servo = &s.servos[i];
        capture samples;
        CHECK_EQ(capture_load(&s, c, &samples, &error), 0);
        CHECK_EQ(samples.count, 801);
        for (int k = 0; k < samples.count; k++) {
            double at = servo->centre + servo->gain * samples.value[k];
            CHECK(at >= servo->min && at <= servo->max);
        }
        capture_free(&samples);
    }
    scene_free(&s);
}

static void check_mesh(const scene_mesh *mesh)
{
    CHECK(strcmp(mesh->file, "tests/scenes/house.obj") == 0 && mesh->line == 8);
    CHECK_EQ(mesh->up, 'z');
    CHECK_NEAR(mesh->scale, 25.4, 0);
    CHECK_NEAR(mesh->tolerance, 0.2, 0);
    CHECK_EQ(mesh->bases, 24);
    CHECK_EQ(mesh->bits, 8);
    CHECK(mesh->mean == 0 && mesh->affine == 1 && mesh->every == 3 && mesh->pieces == 2);
    CHECK_EQ(mesh->normals, NORMALS_FIXED);
    CHECK(mesh->sides == 2 && mesh->has_colour && mesh->colour[1] == 180);
    mesh = &s.meshes[1];
    CHECK_EQ(mesh->up, 'y');
    CHECK(mesh->scale == 1 && mesh->tolerance == 0 && mesh->bases == 0 && mesh->bits == 0);
    CHECK(mesh->mean == 1 && mesh->affine == -1 && mesh->every == 1 && mesh->pieces == 1);
    CHECK(mesh->normals == NORMALS_NONE && mesh->sides == 0 && !mesh->has_colour);
    CHECK_EQ(mesh->shape_count, 1);
    CHECK(strcmp(mesh->shapes[0].target, "tall") == 0 && mesh->shapes[0].file == NULL);
    CHECK(mesh->shapes[0].channel == 0 && mesh->shapes[0].line == 14);
}

static void meshes_and_their_frames_are_read(void)
{
    CHECK_EQ(load(meshes), 0);
    CHECK_EQ(s.mesh_count, 2);
    check_mesh(&s.meshes[0]);
    const scene_motion *motion = &s.clips[0].motions[0];
    CHECK_EQ(s.clips[0].motion_count, 1);
    CHECK_EQ(s.clips[0].curve_count, 0);
    CHECK(motion->mesh == 0 && motion->first == 2 && motion->last == 5 && motion->line == 19);
    CHECK(strcmp(motion->file, "tests/scenes/house_##.obj") == 0);
    CHECK_NEAR(motion->rate, 9, 0);
    motion = &s.clips[1].motions[0];
    CHECK(motion->file == NULL && motion->first == 0 && motion->last == -1 && motion->rate == 0);
    CHECK_NEAR(s.masks[0].mesh_weight[0], 0.5, 0);
    CHECK_NEAR(s.masks[0].mesh_weight[1], 0, 0);
    CHECK_NEAR(s.masks[0].weight[1], 0.25, 0);
    CHECK_NEAR(s.flash_bytes, 65536, 0);
    CHECK_NEAR(s.ram_bytes, 8192, 0);
    scene_free(&s);
}

/* A view's numbers follow the scene's 3 channels: 8 of front, then side's pitch, roll, x, y, size.
 */
static void views_make_channels_of_their_numbers(void)
{
    static const int side[WG_VIEW_CHANNELS] = {1, 11, 12, 13, 14, 2, 2, 15};
    CHECK_EQ(load(meshes), 0);
    CHECK_EQ(s.view_count, 2);
    CHECK_EQ(s.channel_count, 16);
    const scene_view *front = &s.views[0], *view = &s.views[1];
    for (int i = 0; i < (int)WG_VIEW_CHANNELS; i++) {
        CHECK_EQ(front->channel[i], 3 + i);
        CHECK_EQ(view->channel[i], side[i]);
    }
    CHECK(front->fit_target && front->fit_distance && front->fit_size);
    CHECK(!view->fit_target && !view->fit_distance && !view->fit_size);
    CHECK(front->projection == WG_PERSPECTIVE && front->shading == WG_SHADING_SMOOTH);
    CHECK(view->projection == WG_ORTHOGRAPHIC && view->shading == WG_SHADING_WIRE);
    CHECK(strcmp(s.channels[3].name, "front_yaw") == 0);
    CHECK(strcmp(s.channels[15].name, "side_size") == 0);
    CHECK_EQ(s.channels[11].unit, WG_UNIT_DEGREE);
    CHECK_NEAR(s.channels[11].rest, 10, 0);
    CHECK_NEAR(s.channels[11].tolerance, 0.1, 0);
    CHECK_EQ(s.channels[14].unit, WG_UNIT_MILLIMETRE);
    CHECK_NEAR(s.channels[14].rest, 30, 0);
    CHECK_NEAR(s.channels[14].tolerance, 0, 0);
    CHECK(front->light[0] < 0 && front->light[1] > 0 && front->light[2] > 0);
    CHECK_NEAR(hypot(hypot(front->light[0], front->light[1]), front->light[2]), 1, 1e-12);
    CHECK(fabs(view->light[0] - 0.6) < 1e-15 && fabs(view->light[2] - 0.8) < 1e-15);
    CHECK_NEAR(front->ambient, 0.25, 0);
    CHECK_NEAR(view->ambient, 0.5, 0);
    CHECK(view->background[2] == 255 && front->background[0] == 0);
    CHECK_EQ(s.clips[2].curves[0].channel, 11); /* curves move views like anything else */
    scene_free(&s);
}

static void meshes_alone_are_looked_at(void)
{
    static const char text[] = "meshes: [{name: a, file: ../tests/scenes/house.obj}]\n"
                               "clips: [{name: c, duration: 1, meshes: [{mesh: a}]}]\n";
    CHECK_EQ(load_text(text, sizeof text - 1), 0);
    CHECK_EQ(s.channel_count, 8);
    CHECK_EQ(s.view_count, 1);
    CHECK(strcmp(s.views[0].name, "view") == 0 && s.views[0].shading == WG_SHADING_FLAT);
    CHECK(strcmp(s.channels[0].name, "view_yaw") == 0 && s.channels[0].rest == 0);
    CHECK(s.views[0].fit_target && s.views[0].fit_distance && s.views[0].fit_size);
    scene_free(&s);
}

static void ends_come_from_keys_fields_and_defaults(void)
{
    static const char text[] =
        "channels: [{name: a, unit: mm}, {name: b}]\n"
        "clips:\n"
        "- name: c\n"
        "  curves:\n"
        "  - {channel: b, kind: cubic, start: {acceleration: 9}, end: {velocity: -2 /s},\n"
        "     keys: [{time: 0, value: 0}, {time: 500 ms, value: 1}]}\n"
        "  - {channel: a, kind: wiggly, lambda: -4, force: 2, regularise: [0, 1e-3, 0],\n"
        "     keys: [{time: 0, value: 1 mm, velocity: 3 mm/s, acceleration: 5},\n"
        "            {time: 1 s, velocity: 0}, {time: 2, value: 4, velocity: 1, weight: 7}]}\n";
    CHECK_EQ(load_text(text, sizeof text - 1), 0);
    CHECK(strcmp(s.name, "scene_text") == 0);
    const scene_curve *a = curve_of("c", "a"), *b = curve_of("c", "b");
    CHECK(b->end[0] == BAKE_END_ACCELERATION && b->end_value[0] == 9);
    CHECK(b->end[1] == BAKE_END_VELOCITY && b->end_value[1] == -2);
    CHECK_NEAR(b->keys[1].time, 0.5, 1e-15);
    CHECK(a->mode.lambda == -4 && a->mode.g == 2 && a->regularise[1] == 1e-3);
    CHECK(a->end[0] == BAKE_END_VELOCITY && a->end_value[0] == 3);
    CHECK(a->keys[0].weight[1] == 0 && a->keys[0].weight[2] == BAKE_HARD);
    CHECK(a->keys[1].weight[0] == 0 && a->keys[1].weight[1] == BAKE_HARD);
    CHECK(a->end[1] == BAKE_END_FREE && a->keys[2].weight[1] == 7);
    CHECK_EQ(a->line, 7);
    scene_free(&s);
}

/* The whole file, with TESTS replaced by an absolute path. */
static char *read_cases(void)
{
    FILE *file = fopen("tests/scenes/bad_scenes.txt", "r");
    char line[1024], here[512];
    size_t used = 0;
    char *text = bake_alloc(1 << 20, 1);
    if (file == NULL || getcwd(here, sizeof here) == NULL) {
        printf("tests/scenes/bad_scenes.txt: cannot be read\n");
        exit(1);
    }
    while (fgets(line, sizeof line, file) != NULL) {
        char *place = strstr(line, "TESTS/");
        int head = place ? (int)(place - line) : (int)strlen(line);
        used += (size_t)snprintf(text + used, (1 << 20) - used, "%.*s%s%s%s", head, line,
                                 place ? here : "", place ? "/tests/scenes/" : "",
                                 place ? place + 6 : "");
    }
    fclose(file);
    return text;
}

static void check_case(const char *header, const char *text, size_t size)
{
    int line = 0, words = 0;
    char start[80], expected[200] = "";
    CHECK(sscanf(header, "=== %d %n%199[^\n]", &line, &words, expected) == 2 && words > 0);
    snprintf(start, sizeof start, "%s:%d: ", scratch, line);
    int err = load_text(text, size);
    if (err != -1 || strncmp(error.text, start, strlen(start)) != 0 ||
        strstr(error.text, expected) == NULL) {
        check_ok = 0;
        printf("expected %s%s\n     got %s\n", start, expected, err == 0 ? "a scene" : error.text);
    }
    if (err == 0)
        scene_free(&s);
}

static void every_wrong_scene_is_explained_at_its_line(void)
{
    char *cases = read_cases(), *at = strstr(cases, "\n===");
    int count = 0;
    for (; at != NULL; count++) {
        char *header = at + 1;
        char *text = strchr(header, '\n') + 1;
        at = strstr(text - 1, "\n===");
        check_case(header, text, at != NULL ? (size_t)(at + 1 - text) : strlen(text));
    }
    CHECK_EQ(count, 173);
    free(cases);
}

static void a_missing_file_is_an_error(void)
{
    CHECK_EQ(load("build/no_such_scene.yaml"), -1);
    CHECK(strstr(error.text, "there is no such file") != NULL);
    CHECK_EQ(load("build"), -1);
    CHECK(strstr(error.text, "must be a regular file") != NULL);
}

static char *read_all(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    char *text = bake_alloc(1 << 16, 1);
    *size = file != NULL ? fread(text, 1, 1 << 16, file) : 0;
    CHECK(file != NULL && *size > 1000);
    fclose(file);
    return text;
}

/* A damaged scene either still is one, or its message begins with "path:line: ". */
static void try_damaged(const char *text, size_t size)
{
    int err = load_text(text, size), line = 0;
    if (err == 0) {
        scene_free(&s);
        return;
    }
    CHECK_EQ(err, -1);
    CHECK(strncmp(error.text, scratch, sizeof scratch - 1) == 0);
    CHECK(sscanf(error.text + sizeof scratch - 1, ":%d: ", &line) == 1 && line >= 1);
}

static void no_truncation_does_harm(void)
{
    const char *const paths[3] = {nod, puppet, meshes};
    for (int i = 0; i < 3; i++) {
        size_t size;
        char *text = read_all(paths[i], &size);
        for (size_t length = 0; length < size; length += 13)
            try_damaged(text, length);
        free(text);
    }
}

static void flip_bytes(const char *path)
{
    size_t size;
    char *text = read_all(path, &size);
    unsigned long random = 1;
    for (int i = 0; i < 2000; i++) {
        random = (random * 1103515245 + 12345) & 0x7fffffff;
        size_t at = (random >> 8) % size;
        random = (random * 1103515245 + 12345) & 0x7fffffff;
        char before = text[at];
        /* Half the time a character that means something to YAML. */
        text[at] =
            random & 1024 ? "{}[]:,-#&*!|>'\"%@`\n\t ?"[(random >> 12) % 23] : (char)(random >> 12);
        try_damaged(text, size);
        text[at] = before;
    }
    free(text);
}

static void no_flipped_byte_does_harm(void)
{
    flip_bytes(nod);
    flip_bytes(meshes);
}

int main(void)
{
    TEST(nod_channels_clips_and_layers_are_read);
    TEST(nod_curves_are_read);
    TEST(nod_servos_are_in_protocol_units);
    TEST(dynamixels_are_in_steps);
    TEST(the_puppet_is_read);
    TEST(the_puppets_motion_suits_its_servos);
    TEST(meshes_and_their_frames_are_read);
    TEST(views_make_channels_of_their_numbers);
    TEST(meshes_alone_are_looked_at);
    TEST(ends_come_from_keys_fields_and_defaults);
    TEST(every_wrong_scene_is_explained_at_its_line);
    TEST(a_missing_file_is_an_error);
    TEST(no_truncation_does_harm);
    TEST(no_flipped_byte_does_harm);
    return check_done();
}
