/* Meshes: frames compared with the bytes of MD2, MD3 and glTF files read here, parts, welding.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#define SCRATCH "build/mesh_test.yaml"
#include "mesh_scene.h"

#include <math.h>

static const char faerie[] = MODELS "MD2/faerie.md2";
static const char pak[] = "/usr/share/games/openarena/baseoa/pak0.pk3";

static int half(const unsigned char *at)
{
    return (int16_t)((unsigned)at[0] | (unsigned)at[1] << 8);
}

/* ---- vertex frames ----------------------------------------------------------------------------- */

/* Quake's axes: x to the front, y to the left, z up; corners run clockwise. */
static void check_md2_frame(const unsigned char *file, int frame, const double *got)
{
    const unsigned char *head = file + word(file + 56) + frame * word(file + 16);
    const unsigned char *corners = file + word(file + 52);
    for (int i = 0; i < m.triangle_count; i++)
        for (int j = 0; j < 3; j++) {
            const unsigned char *v = head + 40 + 4 * half(corners + 12 * i + 2 * (2 - j));
            double p[3];
            for (int k = 0; k < 3; k++)
                p[k] = v[k] * real(head + 4 * k) + real(head + 12 + 4 * k);
            place(p[0], p[2], -p[1], got + 3 * m.triangle[i][j]);
        }
}

static void md2_frames_are_those_of_the_file(void)
{
    char fields[200];
    size_t size;
    unsigned char *file = read_file(faerie, &size);
    snprintf(fields, sizeof fields, "file: %s", faerie);
    CHECK_EQ(load(fields, ""), 0);
    CHECK_EQ(m.vertex_count, 366);
    CHECK_EQ(m.triangle_count, 654);
    CHECK_EQ(word(file + 32), 654);
    CHECK_EQ(m.frames_count, 1);
    CHECK_EQ(m.frames[0].count, 198);
    CHECK_NEAR(m.frames[0].rate, 30, 0);
    CHECK(m.frames[0].clip == 1 && m.frames[0].motion == 0);
    for (int i = 0; i < m.frames[0].count; i++)
        check_md2_frame(file, i, frame_at(i));
    check_md2_frame(file, 0, m.rest);
    CHECK(volume(m.rest) > 0);
    unload();
    free(file);
}

static void frames_are_chosen_by_number_and_rate(void)
{
    char fields[200];
    size_t size;
    unsigned char *file = read_file(faerie, &size);
    snprintf(fields, sizeof fields, "file: %s", faerie);
    CHECK_EQ(load(fields, ", frames: [40, 45], rate: 9 Hz"), 0);
    CHECK_EQ(m.frames[0].count, 6);
    CHECK_NEAR(m.frames[0].rate, 9, 0);
    check_md2_frame(file, 40, frame_at(0));
    check_md2_frame(file, 45, frame_at(5));
    check_md2_frame(file, 0, m.rest);
    unload();
    free(file);
    refuse(fields, ", frames: [190, 198]",
           "has 198 frames, 0 to 197; 'frames' asks for 190 to 198");
}

static void a_frame_count_that_lies_is_refused(void)
{
    static const int lies[] = {0, -1, 2147483647, 8025, 207};
    size_t size;
    unsigned char *file = read_file(faerie, &size);
    for (int i = 0; i < 5; i++) {
        for (int j = 0; j < 4; j++)
            file[40 + j] = (unsigned char)((unsigned)lies[i] >> 8 * j);
        write_file("build/lie.md2", file, size);
        int err = load("file: lie.md2", ", frames: [0, 1]");
        CHECK_EQ(err, -1);
        if (err == 0)
            unload();
    }
    free(file);
}

/* One surface; i16 / 64. Corners are shared by position: shading and texture split vertices. */
static void check_md3(const unsigned char *file)
{
    const unsigned char *surface = file + word(file + 100);
    const unsigned char *corners = surface + word(surface + 88);
    const unsigned char *at = surface + word(surface + 100);
    int vertices = word(surface + 80);
    CHECK_EQ(word(file + 84), 1);
    CHECK_EQ(word(surface + 84), 506);
    for (int f = 0; f < m.frames[0].count; f++)
        for (int i = 0; i < m.triangle_count; i++)
            for (int j = 0; j < 3; j++) {
                int corner = j == 0 ? 0 : 3 - j;
                const unsigned char *v =
                    at + 8 * (vertices * f + word(corners + 12 * i + 4 * corner));
                const double *got = frame_at(f) + 3 * m.triangle[i][j];
                CHECK_NEAR(got[0], half(v) / 64.0, 0);
                CHECK_NEAR(got[1], half(v + 4) / 64.0, 0);
                CHECK_NEAR(got[2], -half(v + 2) / 64.0, 0);
            }
}

static void md3_frames_weld_to_a_closed_surface(void)
{
    char command[400];
    size_t size;
    snprintf(command, sizeof command,
             "/usr/bin/python3 -c 'import zipfile; open(\"build/lower.md3\", \"wb\").write("
             "zipfile.ZipFile(\"%s\").read(\"models/players/sarge/lower.md3\"))'",
             pak);
    if (access(pak, R_OK) != 0) {
        printf("skipped md3_frames_weld_to_a_closed_surface: openarena-data is not installed\n");
        return;
    }
    CHECK_EQ(system(command), 0);
    unsigned char *file = read_file("build/lower.md3", &size);
    CHECK_EQ(load("file: lower.md3", ", rate: 15"), 0);
    CHECK_EQ(m.vertex_count, 255);
    CHECK_EQ(m.triangle_count, 506);
    CHECK_EQ(m.frames[0].count, 213);
    CHECK(is_closed());
    CHECK(volume(m.rest) > 0);
    check_md3(file);
    unload();
    free(file);
}

/* ---- morph targets ----------------------------------------------------------------------------- */

/* Accessors 2, 4, 7, 10, 11 of AnimatedMorphCube.gltf lie in its buffer at these bytes. Its node
 * scales by 100 and turns by the quaternion (0, r, -r, 0): (x, y, z) -> (-x, -z, -y). */
static void morph_frames_are_sums_of_targets(void)
{
    const char *folder = MODELS "glTF2/glTF-Sample-Models/AnimatedMorphCube-glTF/";
    char path[300], fields[400];
    size_t size;
    snprintf(path, sizeof path, "%sAnimatedMorphCube.bin", folder);
    unsigned char *bin = read_file(path, &size);
    snprintf(fields, sizeof fields, "file: %sAnimatedMorphCube.gltf", folder);
    CHECK_EQ(load(fields, ""), 0);
    CHECK_EQ(m.vertex_count, 8);
    CHECK_EQ(m.triangle_count, 12);
    CHECK_EQ(m.frames[0].count, 127);
    CHECK(is_closed());
    for (int f = 0; f < 127; f++) {
        /* A key each 1/30 s, stored as a float: the weight at frame/30 s is off by the way it moves
         * in the rounding of times in milliseconds, 4200 2^-24 ms, at most 2 a second. */
        const unsigned char *w = bin + 3268 + 8 * f;
        int found = 0;
        CHECK_NEAR(real(bin + 2760 + 4 * f), f / 30.0, 1e-5);
        for (int v = 0; v < 24; v++) {
            double p[3];
            for (int k = 0; k < 3; k++)
                p[k] = 100 * (real(bin + 672 + 12 * v + 4 * k) +
                              real(w) * real(bin + 1248 + 12 * v + 4 * k) +
                              real(w + 4) * real(bin + 2112 + 12 * v + 4 * k));
            for (int i = 0; i < 8; i++) {
                const double *got = frame_at(f) + 3 * i;
                found += fabs(got[0] + p[0]) < 2e-5 && fabs(got[1] + p[2]) < 2e-5 &&
                         fabs(got[2] + p[1]) < 2e-5;
            }
        }
        CHECK(found >= 24);
    }
    unload();
    free(bin);
}

/* morph.gltf: a unit cube under a node that doubles it and one that mirrors it, both 10 further in
 * z. Target tall adds 0.75 y to y, lean adds (0.5 y, 0, -0.25 y). The animation moves the first. */
static void box_corner(int i, double tall, double lean, double out[3])
{
    double x = i & 1, y = i >> 1 & 1, z = i >> 2;
    out[0] = 2 * (x + 0.5 * y * lean);
    out[1] = 2 * (y + 0.75 * y * tall);
    out[2] = 10 + 2 * (z - 0.25 * y * lean);
}

static void places_and_weights_of_nodes_are_followed(void)
{
    /* 4 frames a second; keys (0, 0), (1, 0), (0.5, 1), (0, 0) at 0, 0.5, 1 and 2 s */
    static const double weights[9][2] = {{0, 0},      {0.5, 0},      {1, 0},
                                         {0.75, 0.5}, {0.5, 1},      {0.375, 0.75},
                                         {0.25, 0.5}, {0.125, 0.25}, {0, 0}};
    CHECK_EQ(load("file: ../tests/scenes/morph.gltf", ", rate: 4"), 0);
    CHECK_EQ(m.vertex_count, 16);
    CHECK_EQ(m.triangle_count, 24);
    CHECK_EQ(m.frames[0].count, 9);
    CHECK(is_closed());
    /* A reflection turns the corners round, so both boxes count in full. */
    CHECK_NEAR(volume(m.rest), 8 + 1, 1e-6);
    for (int f = 0; f < 9; f++)
        for (int i = 0; i < 16; i++) {
            double want[3] = {-5 - (i & 1), i >> 1 & 1, 10 + (i >> 2 & 1)};
            if (i < 8)
                box_corner(i, weights[f][0], weights[f][1], want);
            place(want[0], want[1], want[2], frame_at(f) + 3 * i);
        }
    CHECK_EQ(m.part_count, 1);
    CHECK(strcmp(m.parts[0].name, "clay") == 0);
    CHECK_EQ(m.parts[0].sides, 1);
    CHECK_EQ(m.parts[0].colour[0], 255);
    CHECK_EQ(m.parts[0].colour[1], 128); /* 0.2158605 = ((128/255 + 0.055) / 1.055)^2.4 */
    CHECK_EQ(m.parts[0].colour[2], 0);
    unload();
}

static void shapes_are_targets_or_files(void)
{
    CHECK_EQ(load("file: ../tests/scenes/morph.gltf, shapes: [{channel: a, target: lean}, "
                  "{channel: b, target: 0}]",
                  NULL),
             0);
    CHECK_EQ(m.shape_count, 2);
    for (int i = 0; i < 8; i++) {
        double lean[3], tall[3];
        box_corner(i, 0, 1, lean);
        box_corner(i, 1, 0, tall);
        place(lean[0], lean[1], lean[2], m.shape + 3 * i);
        place(tall[0], tall[1], tall[2], m.shape + 3 * (16 + i));
    }
    unload();
    refuse("file: ../tests/scenes/morph.gltf, shapes: [{channel: a, target: laen}]", NULL,
           "has no morph target 'laen' among 4; did you mean 'lean'?");
    refuse("file: ../tests/scenes/house.obj, shapes: [{channel: a, target: lean}]", NULL,
           "has no morph target 'lean' among 0; there are none");
    refuse("file: ../tests/scenes/house.obj", "", "has no frames");
}

/* ---- files of one pose -------------------------------------------------------------------------- */

static void colours_make_parts(void)
{
    CHECK_EQ(load("file: ../tests/scenes/house.obj", NULL), 0);
    CHECK_EQ(m.part_count, 2); /* red and dark are one colour */
    int red = m.parts[0].colour[0] == 255 ? 0 : 1, sides[2] = {0};
    CHECK_EQ(m.parts[1 - red].colour[1], 128);
    CHECK_EQ(m.parts[red].colour[1], 0);
    CHECK_EQ(m.parts[0].sides, 0);
    for (int i = 0; i < m.triangle_count; i++) {
        int flat = 1;
        for (int k = 0; k < 3; k++)
            flat &= m.rest[3 * m.triangle[i][k] + 1] <= 0;
        CHECK_EQ(m.part[i] == red, !flat);
        sides[m.part[i]]++;
    }
    CHECK_EQ(sides[red], 4);
    unload();
    CHECK_EQ(load("file: ../tests/scenes/house.obj, colour: [1, 2, 3], sides: 2, up: z, scale: 10",
                  NULL),
             0);
    CHECK_EQ(m.part_count, 1);
    CHECK_EQ(m.parts[0].colour[2], 3);
    CHECK_EQ(m.parts[0].sides, 1);
    place(-10, 10, 0, m.rest); /* (-1, 0, 1) with z up, ten times */
    place(0, 0, -20, m.rest + 12);
    unload();
}

/* Whether two corners of a binary STL file, three a triangle, stand in one place: the file is 80
 * bytes, u32 triangles, and 50 bytes each, of which 12 are a normal and 36 the corners. */
static int same_place(const unsigned char *file, int a, int b)
{
    int same = 1;
    for (int k = 0; k < 3; k++) {
        double x = real(file + 84 + 50 * (a / 3) + 12 * (a % 3 + 1) + 4 * k);
        double y = real(file + 84 + 50 * (b / 3) + 12 * (b % 3 + 1) + 4 * k);
        same &= !(x < y || x > y);
    }
    return same;
}

/* The places, and the triangles with three different ones. */
static int count_places(const char *path, int *triangles)
{
    size_t size;
    unsigned char *file = read_file(path, &size);
    int count = 0, all = word(file + 80);
    CHECK_EQ(size, 84 + 50 * all);
    *triangles = 0;
    for (int i = 0; i < all; i++)
        *triangles += !same_place(file, 3 * i, 3 * i + 1) && !same_place(file, 3 * i, 3 * i + 2) &&
                      !same_place(file, 3 * i + 1, 3 * i + 2);
    for (int i = 0; i < 3 * all; i++) {
        int known = 0;
        for (int j = 0; j < i && !known; j++)
            known = same_place(file, i, j);
        count += !known;
    }
    free(file);
    return count;
}

/* The same spider in formats that share vertices and formats that do not. */
static void every_format_welds_to_the_same_mesh(void)
{
    static const char *const files[] = {"STL/Spider_ascii.stl", "STL/Spider_binary.stl",
                                        "OBJ/spider.obj"};
    int triangles, places = count_places(MODELS "STL/Spider_binary.stl", &triangles);
    for (int i = 0; i < 3; i++) {
        char fields[200];
        snprintf(fields, sizeof fields, "file: " MODELS "%s", files[i]);
        CHECK_EQ(load(fields, NULL), 0);
        CHECK_EQ(m.vertex_count, places);
        CHECK_EQ(m.triangle_count, triangles);
        unload();
    }
}

static void files_without_a_surface_are_refused(void)
{
    static const char flat[] = "v 0 0 0\nv 0 0 0\nv 1 0 0\nf 1 2 3\n";
    write_file("build/flat.obj", flat, sizeof flat - 1);
    refuse("file: flat.obj", NULL, "no triangle with three different corners");
    refuse("file: " MODELS "OBJ/point_cloud.obj", NULL, "no faces");
    refuse("file: " MODELS "OFF/invalid.off", NULL, "invalid.off' ");
    refuse("file: mesh_test.yaml", NULL, "cannot be read: ");
}

int main(void)
{
    TEST(md2_frames_are_those_of_the_file);
    TEST(frames_are_chosen_by_number_and_rate);
    TEST(a_frame_count_that_lies_is_refused);
    TEST(md3_frames_weld_to_a_closed_surface);
    TEST(morph_frames_are_sums_of_targets);
    TEST(places_and_weights_of_nodes_are_followed);
    TEST(shapes_are_targets_or_files);
    TEST(colours_make_parts);
    TEST(every_format_welds_to_the_same_mesh);
    TEST(files_without_a_surface_are_refused);
    return check_done();
}
