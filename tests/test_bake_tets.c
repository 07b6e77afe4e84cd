/* Surfaces become tetrahedra of the size asked for.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "tets_model.h"

#define DATA  "/usr/share/doc/libcgal-dev/data.tar.gz" /* of Debian's libcgal-demo */
#define THERE "build/cgal/data/meshes/"

static void skip_rest(FILE *file)
{
    int c;
    while ((c = getc(file)) != '\n' && c != EOF) {
    }
}

static void read_off(const char *name)
{
    char path[200];
    int v = 0, t = 0, three;
    snprintf(path, sizeof path, THERE "%s.off", name);
    FILE *file = fopen(path, "r");
    vertices = triangles = 0;
    if (file == NULL || fscanf(file, "%*[COF] %d %d %*d", &v, &t) != 2 || v > ROOM ||
        t > 2 * ROOM) {
        printf("%s: not there or not OFF; install libcgal-demo\n", path);
        exit(1);
    }
    skip_rest(file);
    for (; vertices < v; vertices++) {
        double *p = at[vertices];
        if (fscanf(file, "%lf %lf %lf", &p[0], &p[1], &p[2]) != 3)
            break;
        skip_rest(file); /* colours */
    }
    for (; triangles < t; triangles++) {
        int *c = triangle[triangles];
        if (fscanf(file, "%d %d %d %d", &three, &c[0], &c[1], &c[2]) != 4 || three != 3)
            break;
        skip_rest(file);
    }
    CHECK(vertices == v && triangles == t);
    fclose(file);
}

/* ---- what is filled ---------------------------------------------------------------------------- */

static void a_cube_is_filled_with_cells_of_the_size_asked_for(void)
{
    int before = 0;
    make_cube();
    for (double cell = 1.0; cell > 0.1; cell /= 2) {
        CHECK_EQ(fill(cell), 0);
        check_filled(8.0);
        /* A volume of 8 in regular tetrahedra; TetGen's have half of the largest volume or so. */
        double regular = 8.0 / (cell * cell * cell / (6 * sqrt(2.0)));
        CHECK(b.element_count > regular / 4 && b.element_count < 4 * regular);
        CHECK(b.element_count > 4 * before);
        before = b.element_count;
        drop();
    }
}

/* Powers of two change no digit: TetGen's answer may not depend on the unit. */
static void the_unit_changes_nothing(void)
{
    make_sphere(12, 20);
    CHECK_EQ(fill(0.25), 0);
    body first = b;
    for (int power = -30; power <= 30; power += 60) {
        make_sphere(12, 20);
        for (int i = 0; i < vertices; i++)
            for (int k = 0; k < 3; k++)
                at[i][k] = ldexp(at[i][k], power);
        CHECK_EQ(fill(ldexp(0.25, power)), 0);
        CHECK_EQ(b.vertex_count, first.vertex_count);
        CHECK_EQ(b.element_count, first.element_count);
        check_filled(volume_inside());
        drop();
    }
    b = first;
    drop();
}

/* The distance of the nearest triangle's plane from the origin. */
static double inner_radius(void)
{
    const double none[3] = {0, 0, 0};
    double nearest = HUGE_VAL;
    for (int i = 0; i < triangles; i++) {
        const double *p = at[triangle[i][0]], *q = at[triangle[i][1]], *r = at[triangle[i][2]];
        double u[3], v[3], n[3];
        for (int k = 0; k < 3; k++) {
            u[k] = q[k] - p[k];
            v[k] = r[k] - p[k];
        }
        for (int k = 0; k < 3; k++)
            n[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
        nearest = fmin(nearest, tets_det(none, p, q, r) / tets_distance(n, none));
    }
    return nearest;
}

/* The polyhedron lies in the ball and holds that of the nearest plane's distance. */
static void a_sphere_has_the_volume_of_a_sphere(void)
{
    const double ball = 4.0 / 3.0 * acos(-1.0);
    make_sphere(40, 80);
    double inner = inner_radius();
    CHECK(inner > 0.99);
    CHECK_EQ(fill(0), 0);
    check_filled(volume_inside());
    CHECK(volume_inside() < ball && volume_inside() > ball * inner * inner * inner);
    drop();
}

static void published_meshes_are_filled(void)
{
    static const char *const names[] = {"cactus", "homer",  "bear",        "elephant",    "blobby",
                                        "dino",   "anchor", "triceratops", "couplingdown"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        read_off(names[i]);
        int err = fill(0);
        CHECK_EQ(err, 0);
        if (err == 0) {
            check_filled(fabs(volume_inside()));
            CHECK(b.element_count < 200000);
            drop();
        } else {
            printf("%s\n", error.text);
        }
    }
}

static void which_way_triangles_turn_does_not_matter(void)
{
    for (int every = 1; every <= 3; every++) {
        make_cube();
        for (int i = 0; i < triangles; i += every) {
            int first = triangle[i][0];
            triangle[i][0] = triangle[i][1];
            triangle[i][1] = first;
        }
        CHECK_EQ(fill(0.5), 0);
        check_filled(8.0);
        drop();
    }
}

static void parts_that_stand_apart_are_filled(void)
{
    make_cube();
    add_cube(2.0, 1.0);
    CHECK_EQ(fill(0.5), 0);
    check_filled(9.0);
    drop();
}

static void long_edges_are_halved(void)
{
    make_cube();
    surface s = whole();
    tets_triangles halved;
    CHECK_EQ(tets_split(&s, 0.3, 1000000, &halved), 0);
    surface split = tets_look(&halved);
    int count = 3 * split.triangle_count;
    tets_edge *list = tets_edges(&split);
    for (int i = 0; i < count; i += 2) {
        CHECK_EQ(tets_edge_count(&split, list, i), 2);
        CHECK(tets_distance(split.at + 3 * list[i].a, split.at + 3 * list[i].b) <= 0.3);
    }
    CHECK_EQ(split.vertex_count - count / 2 + split.triangle_count, 2); /* Euler */
    CHECK(memcmp(split.at, at, sizeof *at * 8) == 0);
    free(list);
    tets_triangles_free(&halved);
    CHECK_EQ(tets_split(&s, 1e-9, 1000, &halved), -1);
}

/* ---- points that a body carries ---------------------------------------------------------------- */

enum { POINTS = 3000 };
static double point[POINTS][3];
static embedding found[POINTS];

static unsigned seed = 1;

/* 0 .. 1, the same everywhere. */
static double chance(void)
{
    seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
    return seed / 2147483648.0;
}

/* Around the origin. */
static void scatter(double radius)
{
    for (int i = 0; i < POINTS; i++)
        for (int k = 0; k < 3; k++)
            point[i][k] = radius * (2 * chance() - 1);
}

/* An affine map of what carries the point is that of the point. `largest`: of the weights, which carry
 * 2^-53 of rounding each, times what a tetrahedron's shape costs: an edge^3 over six volumes, below 1000
 * in these meshes. */
static double map(const double *p)
{
    return 3.0 + 2.0 * p[0] - 0.5 * p[1] + 0.25 * p[2];
}

static double check_carried(int i, double tolerance)
{
    double sum = 0, value = 0, largest = 0;
    for (int k = 0; k < 4; k++) {
        double weight = found[i].weight[k];
        CHECK(found[i].vertex[k] >= 0 && found[i].vertex[k] < b.vertex_count);
        sum += weight;
        value += weight * map(b.rest + 3 * found[i].vertex[k]);
        largest = fmax(largest, fabs(weight));
    }
    CHECK_NEAR(sum, 1.0, 1e-15 * (1 + 4 * largest));
    CHECK_NEAR(value, map(point[i]), tolerance * (1 + largest));
    return largest;
}

static void points_inside_are_means_of_the_corners_around_them(void)
{
    double far = -1;
    make_cube();
    CHECK_EQ(fill(0.3), 0);
    scatter(1.0);
    CHECK_EQ(tets_embed(&b, point[0], POINTS, found, &far, &error), 0);
    CHECK_NEAR(far, 0, 0);
    for (int i = 0; i < POINTS; i++) {
        check_carried(i, 1e-12);
        for (int k = 0; k < 4; k++)
            CHECK(found[i].weight[k] >= -1e-12 && found[i].weight[k] <= 1 + 4e-12);
    }
    drop();
}

/* The distance from a cube is known. */
static void points_outside_are_extrapolated_from_the_nearest_side(void)
{
    double far = -1, farthest = 0;
    make_cube();
    CHECK_EQ(fill(0.6), 0);
    scatter(1.7);
    CHECK_EQ(tets_embed(&b, point[0], POINTS, found, &far, &error), 0);
    for (int i = 0; i < POINTS; i++) {
        double off = 0, nearest = HUGE_VAL, one = -1;
        check_carried(i, 1e-12);
        for (int k = 0; k < 3; k++)
            off += pow(fmax(0, fabs(point[i][k]) - 1), 2);
        farthest = fmax(farthest, off);
        /* What carries it touches the cube where it is nearest: within an edge of a tetrahedron. */
        for (int k = 0; k < 4; k++)
            nearest = fmin(nearest, tets_distance(point[i], b.rest + 3 * found[i].vertex[k]));
        CHECK(nearest <= sqrt(off) + 1.0);
        if (i % 30 == 0) {
            CHECK_EQ(tets_embed(&b, point[i], 1, &found[i], &one, &error), 0);
            CHECK_NEAR(one, sqrt(off), 1e-14);
        }
    }
    CHECK_NEAR(far, sqrt(farthest), 1e-14);
    drop();
}

static void a_vertex_is_carried_by_itself(void)
{
    double far = -1;
    make_sphere(12, 20);
    CHECK_EQ(fill(0.2), 0);
    embedding *all = bake_alloc((size_t)b.vertex_count, sizeof *all);
    double *moved = bake_alloc((size_t)b.vertex_count, 3 * sizeof *moved);
    for (int i = 0; i < 3 * b.vertex_count; i++)
        moved[i] =
            b.rest[i] + 1e-9 * (2 * chance() - 1); /* of a size of 3.5, and the limit is 1e-9 */
    for (int times = 0; times < 2; times++) {
        CHECK_EQ(tets_embed(&b, times ? moved : b.rest, b.vertex_count, all, &far, &error), 0);
        for (int i = 0; i < b.vertex_count; i++)
            for (int k = 0; k < 4; k++)
                CHECK_NEAR(all[i].weight[k], all[i].vertex[k] == i, 0);
    }
    free(moved);
    free(all);
    drop();
}

/* A square of side 2 at z = 0, as a shell: the foot of each point is known. */
static void a_shell_carries_the_foot_of_a_point(void)
{
    static double rest[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    static int element[2][4] = {{0, 1, 2, -1}, {0, 2, 3, -1}};
    const body shell = {.kind = BODY_SHELL,
                        .vertex_count = 4,
                        .element_count = 2,
                        .rest = rest[0],
                        .element = element};
    double far = -1, farthest = 0;
    scatter(2.0);
    CHECK_EQ(tets_embed(&shell, point[0], POINTS, found, &far, &error), 0);
    for (int i = 0; i < POINTS; i++) {
        double foot[3] = {0, 0, 0}, want[3] = {0, 0, 0};
        for (int k = 0; k < 2; k++)
            want[k] = fmax(-1, fmin(1, point[i][k]));
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                foot[k] += found[i].weight[j] * rest[found[i].vertex[j]][k];
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(foot[k], want[k], 1e-14);
        CHECK_NEAR(found[i].weight[3], 0, 0);
        farthest = fmax(farthest, tets_distance(want, point[i]));
    }
    CHECK_NEAR(far, farthest, 1e-14);
}

/* The shell lies between two spheres, hence the distance between the distances from both. */
static void a_shell_carries_what_is_nearest_to_a_point(void)
{
    const double none[3] = {0, 0, 0};
    static int element[2 * ROOM][4];
    make_sphere(40, 80);
    double far, inner = inner_radius();
    for (int i = 0; i < triangles; i++)
        memcpy(element[i], triangle[i], sizeof *triangle);
    const body shell = {.kind = BODY_SHELL,
                        .vertex_count = vertices,
                        .element_count = triangles,
                        .rest = at[0],
                        .element = element};
    scatter(1.5);
    CHECK_EQ(tets_embed(&shell, point[0], POINTS, found, &far, &error), 0);
    for (int i = 0; i < POINTS; i++) {
        double foot[3] = {0, 0, 0}, from = tets_distance(point[i], none);
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++)
                foot[k] += found[i].weight[j] * at[found[i].vertex[j]][k];
        double off = tets_distance(foot, point[i]);
        CHECK(off > fmax(from - 1, inner - from) - 1e-14);
        CHECK(off < fmax(from - inner, 1 - from) + 1e-14);
    }
}

static void points_that_are_nowhere_are_refused(void)
{
    double far;
    make_cube();
    CHECK_EQ(fill(0), 0);
    scatter(1.0);
    point[17][2] = NAN;
    CHECK_EQ(tets_embed(&b, point[0], POINTS, found, &far, &error), -1);
    CHECK(strstr(error.text, "vertex 17, which a body is to carry, is at (") != NULL);
    drop();
}

int main(void)
{
    if (system("mkdir -p build/cgal && tar -xzf " DATA " -C build/cgal data/meshes") != 0) {
        printf(DATA ": not there; install libcgal-demo\n");
        return 1;
    }
    TEST(a_cube_is_filled_with_cells_of_the_size_asked_for);
    TEST(the_unit_changes_nothing);
    TEST(a_sphere_has_the_volume_of_a_sphere);
    TEST(published_meshes_are_filled);
    TEST(which_way_triangles_turn_does_not_matter);
    TEST(parts_that_stand_apart_are_filled);
    TEST(long_edges_are_halved);
    TEST(points_inside_are_means_of_the_corners_around_them);
    TEST(points_outside_are_extrapolated_from_the_nearest_side);
    TEST(a_vertex_is_carried_by_itself);
    TEST(a_shell_carries_the_foot_of_a_point);
    TEST(a_shell_carries_what_is_nearest_to_a_point);
    TEST(points_that_are_nowhere_are_refused);
    return check_done();
}
