/* Point caches and numbered files: which vertex of the file every number moves, and what is said
 * about files that are wrong.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#define SCRATCH "build/cache_test.yaml"
#include "mesh_scene.h"

#include <math.h>

enum { POINTS = 7, CACHED = 3, CACHE_BYTES = CACHED * POINTS * 12 };

/* The floats of frame f, point i: all different, so that a mix-up shows. In frame 1 points 4 and 5,
 * which coincide at rest, are apart if `apart`. */
static float cached(int f, int i, int k, int apart)
{
    static const float rest[POINTS][3] = {{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
                                          {0, 2, 0},  {0, 2, 0}, {9, 9, 9}};
    int twin = i == 5 && !(apart && f == 1) ? 4 : i;
    return f == 0 ? rest[i][k] : rest[i][k] + (float)(f * 0.125 + twin * 0.25 + k * 0.0625);
}

static void put_word(unsigned char *at, uint32_t value, int big)
{
    for (int i = 0; i < 4; i++)
        at[big ? 3 - i : i] = (unsigned char)(value >> 8 * i);
}

static void put_real(unsigned char *at, float value, int big)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_word(at, bits, big);
}

static void put_points(unsigned char *at, int apart, int big)
{
    for (int f = 0; f < CACHED; f++)
        for (int i = 0; i < POINTS; i++)
            for (int k = 0; k < 3; k++, at += 4)
                put_real(at, cached(f, i, k, apart), big);
}

static size_t make_pc2(unsigned char *out, int apart)
{
    memcpy(out, "POINTCACHE2", 12);
    put_word(out + 12, 1, 0);
    put_word(out + 16, POINTS, 0);
    put_real(out + 20, 0, 0);
    put_real(out + 24, 2, 0); /* every second frame: 15 a second */
    put_word(out + 28, CACHED, 0);
    put_points(out + 32, apart, 0);
    return 32 + CACHE_BYTES;
}

static size_t make_mdd(unsigned char *out, int apart)
{
    put_word(out, CACHED, 1);
    put_word(out + 4, POINTS, 1);
    for (int f = 0; f < CACHED; f++)
        put_real(out + 8 + 4 * f, (float)f / 25, 1);
    put_points(out + 8 + 4 * CACHED, apart, 1);
    return 8 + 4 * CACHED + CACHE_BYTES;
}

/* The file's vertex at each vertex of the mesh, in its order; 5 is 4 unless they are apart. */
static void check_house(int first, int apart)
{
    static const int faces[6][3] = {{0, 1, 4}, {1, 2, 4}, {2, 3, 5},
                                    {3, 0, 4}, {0, 3, 2}, {0, 2, 1}};
    int seen[6] = {0};
    CHECK_EQ(m.vertex_count, apart ? 6 : 5);
    CHECK_EQ(m.triangle_count, 6);
    for (int f = 0; f < m.frames[0].count; f++)
        for (int i = 0; i < m.vertex_count; i++)
            for (int k = 0; k < 3; k++)
                CHECK_NEAR(frame_at(f)[3 * i + k], (double)cached(first + f, i, k, apart), 0);
    for (int i = 0; i < m.triangle_count; i++)
        for (int j = 0; j < 6; j++)
            for (int turn = 0; turn < 3; turn++) {
                int same = 1;
                for (int k = 0; k < 3; k++) {
                    int want = faces[j][(k + turn) % 3];
                    same &= m.triangle[i][k] == (want == 5 && !apart ? 4 : want);
                }
                seen[j] += same;
            }
    /* The base is cut along 0-2 or 1-3, as the triangulation likes; the sides are all there. */
    CHECK(seen[0] == 1 && seen[1] == 1 && seen[2] == 1 && seen[3] == 1);
    CHECK_NEAR(volume(m.rest), 8.0 / 3, 1e-12);
    CHECK_EQ(is_closed(), !apart);
}

static void caches_move_the_files_own_vertices(void)
{
    static unsigned char data[2048];
    for (int apart = 0; apart < 2; apart++) {
        write_file("build/house.pc2", data, make_pc2(data, apart));
        CHECK_EQ(load("file: ../tests/scenes/house.obj", ", file: house.pc2"), 0);
        CHECK_EQ(m.frames[0].count, CACHED);
        CHECK_NEAR(m.frames[0].rate, 15, 0);
        check_house(0, apart);
        unload();
        write_file("build/house.mdd", data, make_mdd(data, apart));
        CHECK_EQ(load("file: ../tests/scenes/house.obj", ", file: house.mdd, frames: [1, 2]"), 0);
        CHECK_EQ(m.frames[0].count, 2);
        CHECK_NEAR(m.frames[0].rate, 25, 1e-5);
        check_house(1, apart);
        unload();
    }
}

static void ply_caches_need_as_many_points(void)
{
    unsigned char data[32 + 2 * 8 * 12] = "POINTCACHE2";
    put_word(data + 12, 1, 0);
    put_word(data + 16, 8, 0);
    put_real(data + 24, 1, 0);
    put_word(data + 28, 2, 0);
    for (int i = 0; i < 48; i++)
        put_real(data + 32 + 4 * i, (float)(i * i % 53), 0);
    write_file("build/cube.pc2", data, sizeof data);
    CHECK_EQ(load("file: " MODELS "PLY/cube_binary.ply", ", file: cube.pc2"), 0);
    CHECK_EQ(m.vertex_count, 8);
    for (int i = 0; i < 48; i++)
        CHECK_NEAR(m.frames[0].at[i], i * i % 53, 0);
    CHECK(m.rest[3] == 0 && m.rest[4] == 0 && m.rest[5] == 1); /* the file's vertex 1 */
    unload();
    refuse("file: ../tests/scenes/house.obj", ", file: cube.pc2", "has 8 points, ");
    refuse("file: " MODELS "STL/triangle.stl", ", file: cube.pc2", "OBJ, PLY or OFF");
}

static void truncated_caches_are_refused_at_every_byte(void)
{
    static unsigned char data[2048];
    for (int big = 0; big < 2; big++) {
        const char *name = big ? "build/cut.mdd" : "build/cut.pc2";
        const char *motion = big ? ", file: cut.mdd" : ", file: cut.pc2";
        size_t size = big ? make_mdd(data, 0) : make_pc2(data, 0);
        for (size_t cut = 0; cut < size; cut++) {
            write_file(name, data, cut);
            refuse("file: ../tests/scenes/house.obj", motion, "cut.");
        }
        write_file(name, data, size + 1);
        refuse("file: ../tests/scenes/house.obj", motion, "bytes");
    }
}

static void absurd_counts_in_caches_are_refused(void)
{
    static const uint32_t counts[] = {0, 0xffffffff, 0x7fffffff, 0x80000000, 0x10000000, 4};
    static unsigned char data[2048];
    for (int i = 0; i < 12; i++) {
        size_t size = make_pc2(data, 0);
        put_word(data + (i & 1 ? 16 : 28), counts[i / 2], 0);
        write_file("build/cut.pc2", data, size);
        refuse("file: ../tests/scenes/house.obj", ", file: cut.pc2", "cut.pc2' ");
        size = make_mdd(data, 0);
        put_word(data + (i & 1 ? 4 : 0), counts[i / 2], 1);
        write_file("build/cut.mdd", data, size);
        refuse("file: ../tests/scenes/house.obj", ", file: cut.mdd", "cut.mdd' ");
    }
    size_t size = make_pc2(data, 0);
    data[12] = 2;
    write_file("build/cut.pc2", data, size);
    refuse("file: ../tests/scenes/house.obj", ", file: cut.pc2", "no PC2 file of version 1");
}

static void numbers_that_are_not_finite_are_named(void)
{
    static unsigned char data[2048];
    size_t size = make_pc2(data, 0);
    put_real(data + 32 + (2 * POINTS + 3) * 12 + 4, NAN, 0);
    write_file("build/cut.pc2", data, size);
    refuse("file: ../tests/scenes/house.obj", ", file: cut.pc2",
           "has no finite number as place of vertex 3 of frame 2");
    put_real(data + 32 + (2 * POINTS + 3) * 12 + 4, 2e6f, 0);
    write_file("build/cut.pc2", data, size);
    refuse("file: ../tests/scenes/house.obj", ", file: cut.pc2",
           "has vertex 3 of frame 2 at 2e+06, too far away; use 'scale'");
    refuse("file: " MODELS "glTF2/BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", NULL,
           "has no finite number as place of vertex 0");
    size = make_mdd(data, 0);
    put_real(data + 8 + 4, 0.07f, 1);
    write_file("build/cut.mdd", data, size);
    refuse("file: ../tests/scenes/house.obj", ", file: cut.mdd", "uneven times; say with 'rate'");
    CHECK_EQ(load("file: ../tests/scenes/house.obj", ", file: cut.mdd, rate: 12"), 0);
    CHECK_NEAR(m.frames[0].rate, 12, 0);
    unload();
}

/* Faces that lie across the base, which is concave in frame 1: cut there on the other diagonal. */
static void write_numbered(int number, const char *faces)
{
    char text[600], path[80];
    int used = snprintf(text, sizeof text, "mtllib none.mtl\n");
    for (int i = 0; i < POINTS; i++) {
        used += snprintf(text + used, sizeof text - (size_t)used, "v");
        for (int k = 0; k < 3; k++) {
            double x = (double)cached(number - 8, i, k, 0);
            if (number == 9 && i == 0 && k != 1)
                x = k == 0 ? 0.75 : -0.5;
            used += snprintf(text + used, sizeof text - (size_t)used, " %.9g", x);
        }
        used += snprintf(text + used, sizeof text - (size_t)used, "\n");
    }
    used += snprintf(text + used, sizeof text - (size_t)used, "%s", faces);
    snprintf(path, sizeof path, "build/run_%03d.obj", number);
    write_file(path, text, (size_t)used);
}

static const char house_faces[] = "f 1 2 5\nf 1 4 3 2\nf 2 3 5\nf 3 4 6\nf 4 1 5\n";

static void numbered_files_are_frames(void)
{
    for (int i = 8; i <= 10; i++)
        write_numbered(i, house_faces);
    CHECK_EQ(load("file: 'run_###.obj'", ", frames: [0, 2], rate: 5"), 0);
    CHECK_EQ(m.frames[0].count, 3);
    CHECK_EQ(m.vertex_count, 5);
    CHECK_EQ(m.triangle_count, 6);
    CHECK_NEAR(frame_at(1)[0], 0.75, 0);
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 3; k++) {
            CHECK_NEAR(m.rest[3 * i + k], (double)cached(0, i, k, 0), 0);
            CHECK_NEAR(frame_at(2)[3 * i + k], (double)cached(2, i, k, 0), 0);
        }
    unload();
    /* over a mesh of several materials and objects */
    CHECK_EQ(load("file: ../tests/scenes/house.obj", ", file: 'run_###.obj'"), 0);
    CHECK_EQ(m.frames[0].count, 3);
    CHECK_EQ(m.part_count, 2);
    CHECK_NEAR(frame_at(2)[12], (double)cached(2, 4, 0, 0), 0);
    unload();
    write_numbered(9, "f 1 2 5\nf 1 4 3 2\nf 2 3 5\nf 3 4 5\nf 4 1 5\n");
    refuse("file: 'run_###.obj'", "", "run_009.obj' has other corners than");
    write_numbered(9, "f 1 2 5\nf 1 4 3 2\nf 2 3 5\nf 3 4 6\n");
    refuse("file: 'run_###.obj'", "", "run_009.obj' has fewer faces than");
    write_numbered(9, "v 1 2 3\nf 1 2 5\nf 1 4 3 2\nf 2 3 5\nf 3 4 6\nf 4 1 5\n");
    refuse("file: 'run_###.obj'", "", "run_009.obj' has 8 vertices");
    remove("build/run_009.obj");
    refuse_at(3, "file: 'run_###.obj'", "", "there is no file 'build/run_009.obj'");
    refuse_at(3, "file: 'run_####.obj'", "", "stands for no file");
    refuse_at(3, "file: 'no#/run_1.obj'", "", "must have its #s in the file's name");
}

/* What OBJ files may contain besides: a continued line, a comment that swallows the next line, a
 * vertex behind a blank (which is none to Assimp), weights and colours, counting backwards. */
static void odd_obj_files_keep_their_numbers(void)
{
    static const char text[] = "# comment \\\nv 9 9 9\nv 0 0 \\\n 0\n  v 5 5 5\nv 1 0 0 1\r\n"
                               "v\t1 1 0\nv 0 1 0 1 0.5 0.25\nvn 0 0 1\nvt 0 0\n"
                               "f 1/1/1 2/1/1 3/1/1\nf -4 -2 \\\r\n -1\n";
    unsigned char data[32 + 48] = "POINTCACHE2";
    put_word(data + 12, 1, 0);
    put_word(data + 16, 4, 0);
    put_word(data + 28, 1, 0);
    for (int i = 0; i < 12; i++)
        put_real(data + 32 + 4 * i, (float)i, 0);
    write_file("build/odd.obj", text, sizeof text - 1);
    write_file("build/odd.pc2", data, sizeof data);
    CHECK_EQ(load("file: odd.obj", ", file: odd.pc2"), 0);
    CHECK_EQ(m.vertex_count, 4);
    CHECK_EQ(m.triangle_count, 2);
    for (int i = 0; i < 12; i++)
        CHECK_NEAR(m.frames[0].at[i], i, 0);
    CHECK(m.rest[3] == 1 && m.rest[10] == 1 && m.rest[9] == 0);
    CHECK(m.triangle[1][0] == 0 && m.triangle[1][1] == 2 && m.triangle[1][2] == 3);
    unload();
}

int main(void)
{
    TEST(caches_move_the_files_own_vertices);
    TEST(ply_caches_need_as_many_points);
    TEST(truncated_caches_are_refused_at_every_byte);
    TEST(absurd_counts_in_caches_are_refused);
    TEST(numbers_that_are_not_finite_are_named);
    TEST(numbered_files_are_frames);
    TEST(odd_obj_files_keep_their_numbers);
    return check_done();
}
