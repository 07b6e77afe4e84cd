/* Surfaces that cannot be filled are refused with the place of what is wrong.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "tets_model.h"
#include "isolate.h"

#include <signal.h>

/* ---- what is refused --------------------------------------------------------------------------- */

/* The first place in a message; 0 if there is none. */
static int place_in(const char *text, double out[3])
{
    for (const char *p = strchr(text, '('); p; p = strchr(p + 1, '('))
        if (sscanf(p, "(%lf, %lf, %lf)", &out[0], &out[1], &out[2]) == 3)
            return 1;
    return 0;
}

/* Refused in these words, with this place to the six digits that are told. */
static void refuse_at(const char *words, double x, double y, double z)
{
    const double want[3] = {x, y, z};
    double got[3] = {1e9, 1e9, 1e9};
    CHECK_EQ(fill(0.5), -1);
    CHECK(strncmp(error.text, "scene.yaml:7: mesh thing", 24) == 0);
    CHECK(strstr(error.text, words) != NULL);
    CHECK(strstr(error.text, "; ") != NULL);
    CHECK(place_in(error.text, got));
    for (int k = 0; k < 3; k++)
        CHECK_NEAR(got[k], want[k], 1e-5);
    if (!check_ok)
        printf("%s\n", error.text);
}

static void broken_surfaces_are_refused_where_they_are_broken(void)
{
    make_cube();
    triangles--; /* 3 7 5 */
    refuse_at("has a hole", 1.0, 1.0 / 3, 1.0 / 3);
    make_cube();
    triangles -= 3; /* 1 3 5 and 3 7 5, and the lower left half of x = -1 */
    refuse_at("has 2 holes, the largest", 1.0, 0.0, 0.0);
    make_cube();
    memcpy(triangle[triangles++], triangle[0], sizeof *triangle); /* 0 2 1 */
    refuse_at("has 3 edges with more than two triangles, the first", 0.0, -1.0, -1.0);
    make_cube();
    at[7][0] = at[7][1] = at[7][2] = -3.0; /* along the diagonal, through vertex 0 */
    CHECK_EQ(fill(0.5), -1);
    CHECK(strstr(error.text, "that cross or touch, the first at (") != NULL);
    make_cube();
    at[7][0] = at[5][0] = at[7][1] = 1.0;
    add_vertex(1.0, 0.0, 0.0); /* splits the diagonal 3 5 on one side alone: flat */
    triangles--;
    add_triangle(3, 7, 5);
    add_triangle(3, 5, 8);
    refuse_at("has a triangle without area", 1.0, 0.0, 0.0);
    make_cube();
    add_vertex(3.0, 4.0, 5.0);
    refuse_at("has a vertex without triangles", 3.0, 4.0, 5.0);
}

static void overlapping_and_nested_parts_are_refused(void)
{
    double got[3];
    make_cube();
    add_cube(0.0, 2.0);
    CHECK_EQ(fill(0.5), -1);
    CHECK(strstr(error.text, "pairs of triangles that cross or touch, the first at") != NULL);
    /* Somewhere on both cubes, so on the boundary of [0, 1]^3. */
    CHECK(place_in(error.text, got));
    for (int k = 0; k < 3; k++)
        CHECK(got[k] > -1e-5 && got[k] < 1 + 1e-5);
    make_cube();
    add_cube(1.0, 2.0); /* a corner on a corner, as two vertices */
    refuse_at("has", 1.0, 1.0, 1.0);
    make_cube();
    add_cube(-0.5, 1.0);
    refuse_at("has a closed part inside another", -0.5, -0.5, -0.5);
    /* As one vertex. */
    make_cube();
    add_cube(1.0, 2.0);
    vertices--;
    for (int i = 12; i < 24; i++)
        for (int k = 0; k < 3; k++)
            triangle[i][k] = triangle[i][k] == 8 ? 7 : triangle[i][k] - 1;
    memmove(at[8], at[9], 7 * sizeof *at);
    refuse_at("has a vertex in which parts touch", 1.0, 1.0, 1.0);
}

static void what_is_no_surface_is_refused(void)
{
    make_cube();
    at[3][1] = NAN;
    CHECK_EQ(fill(0.5), -1);
    CHECK(strstr(error.text, "vertex 3 is at (1, nan, -1)") != NULL);
    make_cube();
    triangle[5][1] = 8;
    CHECK_EQ(fill(0.5), -1);
    CHECK(strstr(error.text, "triangle 5 has a corner 8, and there are 8 vertices") != NULL);
    make_cube();
    vertices = 3;
    triangles = 1;
    triangle[0][0] = 0;
    triangle[0][1] = 1;
    triangle[0][2] = 2;
    refuse_at("has 3 vertices and 1 triangles", -1.0, -1.0, -1.0);
    vertices = triangles = 0;
    refuse_at("has 0 vertices and 0 triangles", 0.0, 0.0, 0.0);
    /* Two sides of one rectangle: no volume. */
    make_cube();
    for (int i = 0; i < 8; i++)
        at[i][0] = 0.0;
    CHECK_EQ(fill(0.5), -1);
    CHECK(strstr(error.text, "triangles without area") != NULL);
    make_cube();
    CHECK_EQ(fill(1e-4), -1);
    CHECK(strstr(error.text, "and 1000000 are the most; give it a 'cell' of 0.0") != NULL);
}

static unsigned seed = 1;

/* 0 .. 1, the same everywhere. */
static double chance(void)
{
    seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
    return seed / 2147483648.0;
}

static void damage(int kind)
{
    int i = (int)(chance() * triangles), v = (int)(chance() * vertices);
    if (kind == 0) {
        for (int k = 0; k < 3; k++)
            at[v][k] += 3.0 * (chance() - 0.5);
    } else if (kind == 1) {
        memcpy(triangle[i], triangle[--triangles], sizeof *triangle);
    } else if (kind == 2) {
        triangle[i][(int)(chance() * 3)] = v;
    } else if (kind == 3) {
        memcpy(at[v], at[(int)(chance() * vertices)], sizeof *at);
    } else {
        at[v][(int)(chance() * 3)] *= 1.0 + 1e-12 * chance();
    }
}

/* Every one is a mesh, or a message with a place; never the end of the process. Nor is TetGen's: with its own
 * tolerance 27 in 4,000 of these made it abort. */
static void damaged_surfaces_are_filled_or_refused(void)
{
    int filled = 0, refused = 0;
    for (int n = 0; n < 600; n++) {
        double place[3];
        make_sphere(5, 7);
        for (int i = 0; i <= n % 4; i++)
            damage(n % 5);
        if (fill(0.5) == 0) {
            check_filled(fabs(volume_inside()));
            filled++;
            drop();
        } else {
            CHECK(place_in(error.text, place) && strstr(error.text, "; ") != NULL);
            CHECK(strstr(error.text, "crashes") == NULL);
            refused++;
        }
        if (!check_ok) {
            printf("number %d: %s\n", n, error.text);
            return;
        }
    }
    CHECK(filled > 100 && refused > 300); /* both are tested */
}

static void soups_are_refused(void)
{
    vertices = triangles = 0;
    for (int i = 0; i < 100; i++) {
        for (int k = 0; k < 3; k++)
            add_vertex(chance(), chance(), chance());
        add_triangle(3 * i, 3 * i + 1, 3 * i + 2);
    }
    CHECK_EQ(fill(0.5), -1);
    CHECK(strstr(error.text, "has 100 holes, the largest at (") != NULL);
}

/* ---- a mesher that dies ------------------------------------------------------------------------ */

static int die(void *what, isolate_note *now, bake_error *unused)
{
    (void)unused;
    isolate_now(now, 7, "thing");
    signal(*(const int *)what, SIG_DFL); /* a sanitizer has handlers of its own */
    raise(*(const int *)what);
    return 0;
}

static void send_nothing(const void *what, FILE *to)
{
    (void)what;
    (void)to;
}

static int take_nothing(void *what, FILE *from)
{
    (void)what;
    (void)from;
    return -1;
}

static void a_death_is_told_in_the_words_of_the_job(void)
{
    const isolate_words words = {"mesh ", "", "fill", "filled", "crashes", "do A", "do B", "do C"};
    static const struct {
        int cause;
        const char *own, *file;
    } deaths[] = {
        {SIGSEGV, "mesh thing crashes (Segmentation fault); do C",
         "'thing' is damaged: the reader stopped (Segmentation fault); export it again, or in "
         "another format"},
        {SIGALRM, "mesh thing was not filled within 60 s; do A",
         "'thing' was not read within 60 s; if it is not damaged, give it fewer polygons"},
        {SIGKILL, "mesh thing takes more than 4 GB of memory to fill; do B",
         "'thing' takes more than 4 GB of memory to read; if it is not damaged, give it fewer "
         "polygons or frames"},
    };
    for (int i = 0; i < 3; i++) {
        int cause = deaths[i].cause;
        const isolate_job job = {"s.yaml", &cause, die, send_nothing, take_nothing};
        CHECK_EQ(isolate_as(&job, &words, &error), -1);
        CHECK(strcmp(error.text + strlen("s.yaml:7: "), deaths[i].own) == 0);
        CHECK_EQ(isolate(&job, &error), -1);
        CHECK(strcmp(error.text + strlen("s.yaml:7: "), deaths[i].file) == 0);
    }
}

int main(void)
{
    TEST(broken_surfaces_are_refused_where_they_are_broken);
    TEST(overlapping_and_nested_parts_are_refused);
    TEST(what_is_no_surface_is_refused);
    TEST(damaged_surfaces_are_filled_or_refused);
    TEST(soups_are_refused);
    TEST(a_death_is_told_in_the_words_of_the_job);
    return check_done();
}
