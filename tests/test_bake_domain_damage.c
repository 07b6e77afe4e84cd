/* Broken surfaces: every vertex of each gets a place in a domain that handles hold, or an error names
 * where it is broken; nothing crashes. `--all`: ten meshes in all ways, with a table of times.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "check.h"
#include "domain_parts.h"
#include "laplacian.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#define DATA  "/usr/share/doc/libcgal-dev/data.tar.gz" /* of Debian's libcgal-demo */
#define THERE "build/cgal/data/meshes/"

enum { ROOM = 150000, POINTS = 6 };
static double at[ROOM][3], before[ROOM][3];
static int triangle[ROOM][3], vertices, triangles, verbose;
static const surface_origin origin = {"scene.yaml", "thing", 7};
static bake_error error;
static domain d;

/* ---- meshes ----------------------------------------------------------------------------------- */

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
    if (file == NULL || fscanf(file, "%*[COF] %d %d %*d", &v, &t) != 2 || 3 * t > ROOM) {
        printf("%s: not there or not OFF; install libcgal-demo\n", path);
        exit(1);
    }
    skip_rest(file);
    for (; vertices < v; vertices++, skip_rest(file)) {
        double *p = at[vertices];
        if (fscanf(file, "%lf %lf %lf", &p[0], &p[1], &p[2]) != 3)
            break;
    }
    for (; triangles < t; triangles++, skip_rest(file)) {
        int *c = triangle[triangles];
        if (fscanf(file, "%d %d %d %d", &three, &c[0], &c[1], &c[2]) != 4 || three != 3)
            break;
    }
    CHECK(vertices == v && triangles == t);
    fclose(file);
}

static unsigned seed;

/* 0 .. 1, the same everywhere. */
static double chance(void)
{
    seed = (seed * 1103515245u + 12345u) & 0x7fffffffu;
    return seed / 2147483648.0;
}

static int any_of(int count)
{
    return (int)(chance() * count);
}

static double extent(double low[3])
{
    double high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (int k = 0; k < 3; k++)
        low[k] = HUGE_VAL;
    for (int i = 0; i < vertices; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], at[i][k]);
            high[k] = fmax(high[k], at[i][k]);
        }
    return tets_distance(low, high);
}

/* ---- damage ----------------------------------------------------------------------------------- */

static void soup(void)
{
    memcpy(before, at, sizeof at);
    vertices = 0;
    for (int i = 0; i < triangles; i++)
        for (int k = 0; k < 3; k++) {
            memcpy(at[vertices], before[triangle[i][k]], sizeof *at);
            triangle[i][k] = vertices++;
        }
}

static void missing(void)
{
    int kept = 0;
    for (int i = 0; i < triangles; i++)
        if (chance() >= 0.1)
            memmove(triangle[kept++], triangle[i], sizeof *triangle);
    triangles = kept;
}

static void shells(void)
{
    double low[3], size = extent(low);
    int more = vertices;
    for (int i = 0; i < more; i++, vertices++)
        for (int k = 0; k < 3; k++)
            at[vertices][k] = at[i][k] + 0.05 * size * (k + 1);
    for (int i = 0, count = triangles; i < count; i++, triangles++)
        for (int k = 0; k < 3; k++)
            triangle[triangles][k] = triangle[i][k] + more;
}

/* Half with two corners alike, half with a corner in the middle of the others. */
static void degenerate(void)
{
    for (int i = 0; i < 50; i++) {
        const int *from = triangle[any_of(triangles)];
        int added[3] = {from[0], from[1], from[1]};
        if (i % 2) {
            for (int k = 0; k < 3; k++)
                at[vertices][k] = (at[from[0]][k] + at[from[1]][k]) / 2;
            added[2] = vertices++;
        }
        memcpy(triangle[triangles++], added, sizeof added);
    }
}

/* Tetrahedra around the mesh, and some in it. */
static void specks(void)
{
    static const int side[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    double low[3], size = extent(low);
    for (int i = 0; i < 13; i++) {
        int first = vertices;
        double centre[3];
        for (int k = 0; k < 3; k++)
            centre[k] = low[k] + size * (1.2 * chance() - 0.1);
        for (int j = 0; j < 4; j++, vertices++)
            for (int k = 0; k < 3; k++)
                at[vertices][k] = centre[k] + (j == k + 1 ? 0.01 * size : 0);
        for (int j = 0; j < 4; j++, triangles++)
            for (int k = 0; k < 3; k++)
                triangle[triangles][k] = first + side[j][k];
    }
}

static void inverted(void)
{
    for (int i = 0; i < triangles; i++)
        if (chance() < 0.2) {
            int first = triangle[i][0];
            triangle[i][0] = triangle[i][1];
            triangle[i][1] = first;
        }
}

static void everything(void)
{
    degenerate();
    specks();
    missing();
    inverted();
    soup();
}

static const struct {
    const char *name;
    void (*make)(void);
} ways[] = {{"soup", soup},
            {"missing", missing},
            {"shells", shells},
            {"degenerate", degenerate},
            {"specks", specks},
            {"inverted", inverted},
            {"everything", everything}};
enum { WAYS = sizeof ways / sizeof *ways };

/* ---- handles ---------------------------------------------------------------------------------- */

/* A bone in the largest ball that is found inside: it needs a domain that is not hollow. */
static void add_bone(handle *bone)
{
    const surface s = {vertices, triangles, at[0], (const int(*)[3])triangle};
    const handles none = {0, 0, NULL, NULL};
    domain_places in;
    double box[2][3], deepest = 0;
    domain_measure(&s, box);
    domain_places_find(&s, &none, (const double(*)[3])box, &in);
    *bone = (handle){.name = "bone", .line = 20, .kind = HANDLE_BONE};
    for (int i = 0; i < in.count; i++) {
        double nearest = HUGE_VAL;
        for (int v = 0; v < vertices; v++)
            nearest = fmin(nearest, tets_distance(in.at + 3 * i, at[v]));
        if (nearest <= deepest)
            continue;
        deepest = nearest;
        for (int k = 0; k < 3; k++) {
            bone->from[k] = in.at[3 * i + k] - 0.3 * nearest;
            bone->to[k] = in.at[3 * i + k] + 0.3 * nearest;
        }
    }
    CHECK(deepest > 0);
    free(in.at);
}

/* The vertices that are farthest from those before them, by their places before the damage. */
static void choose_handles(handle *list)
{
    int next = 0;
    for (int i = 0; i < POINTS; i++) {
        double most = -1;
        list[i] = (handle){.name = "tip", .line = 10 + i, .kind = HANDLE_POINT};
        memcpy(list[i].from, at[next], sizeof list[i].from);
        for (int v = 0; v < vertices; v++) {
            double nearest = HUGE_VAL;
            for (int j = 0; j <= i; j++)
                nearest = fmin(nearest, tets_distance(list[j].from, at[v]));
            next = nearest > most ? v : next;
            most = fmax(most, nearest);
        }
    }
    add_bone(&list[POINTS]);
}

/* ---- what must be true --------------------------------------------------------------------------- */

static void check_embedding(void)
{
    embedding *e = bake_alloc((size_t)vertices, sizeof *e);
    double far;
    CHECK_EQ(domain_embed(&d, at[0], vertices, e, &far, &error), 0);
    for (int i = 0; i < vertices; i++) {
        double sum = 0;
        for (int k = 0; k < 4; k++) {
            CHECK(e[i].weight[k] >= 0 && e[i].vertex[k] >= 0 && e[i].vertex[k] < d.vertex_count);
            sum += e[i].weight[k];
        }
        CHECK_NEAR(sum, 1, 1e-13);
    }
    free(e);
}

/* From the held vertices over edges everything is reached: K's kernel has no constant that is
 * free. */
static void check_reached(const held *f)
{
    char *reached = bake_alloc((size_t)d.vertex_count, 1);
    int before_count = -1, count = 0;
    for (int i = 0; i < f->count; i++)
        reached[f->vertex[i]] = 1;
    while (count != before_count) {
        before_count = count;
        for (int i = 0; i < d.element_count; i++) {
            const int *c = d.element[i];
            int any = reached[c[0]] | reached[c[1]] | reached[c[2]] | reached[c[3]];
            for (int k = 0; k < 4 && any; k++)
                reached[c[k]] = 1;
        }
        count = 0;
        for (int i = 0; i < d.vertex_count; i++)
            count += reached[i];
    }
    CHECK_EQ(count, d.vertex_count);
    free(reached);
}

static void check_operators(void)
{
    double *length = bake_alloc((size_t)d.element_count, 6 * sizeof *length);
    double *mass = bake_alloc((size_t)d.vertex_count, sizeof *mass);
    sparse k = {0};
    laplacian_lengths(&d, length);
    CHECK_EQ(laplacian_make(&d, length, MASS_VORONOI, &k, mass, &error), 0);
    for (int i = 0; i < d.vertex_count; i++)
        CHECK(mass[i] > 0);
    sparse_free(&k);
    free(mass);
    free(length);
}

static void check_domain(const handles *h, const domain_options *how)
{
    held f;
    int err = domain_hold(&d, h, how, &f, &error);
    CHECK_EQ(err, 0);
    if (err == 0)
        check_reached(&f);
    else
        printf("%s\n", error.text);
    check_embedding();
    check_operators();
    held_free(&f);
}

/* An error has to say where. */
static void check_error(void)
{
    double p[3];
    const char *place = strstr(error.text, " at (");
    CHECK(strncmp(error.text, "scene.yaml:", 11) == 0);
    CHECK(place != NULL && sscanf(place, " at (%lf, %lf, %lf)", &p[0], &p[1], &p[2]) == 3);
    printf("%s\n", error.text);
}

/* Of the processor, children's too: others may use this machine. */
static double seconds(void)
{
    double sum = 0;
    for (int who = 0; who < 2; who++) {
        struct rusage used;
        getrusage(who ? RUSAGE_CHILDREN : RUSAGE_SELF, &used);
        sum += (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
               1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
    }
    return sum;
}

static double damage(const char *mesh, int way, int wrap)
{
    handle list[POINTS + 1];
    const handles h = {POINTS + 1, 0, list, NULL};
    const domain_options how = {0, &origin, wrap};
    read_off(mesh);
    choose_handles(list);
    seed = 1;
    ways[way].make();
    const surface s = {vertices, triangles, at[0], (const int(*)[3])triangle};
    double start = seconds();
    int err = domain_solid(&s, &h, &how, &d, &error);
    double took = seconds() - start;
    if (verbose)
        printf("%-12s %-11s %6d %6d  %7d %7d  %d %5.2f s%s\n", mesh, ways[way].name, vertices,
               triangles, d.vertex_count, d.element_count, d.wrapped, took, err ? "  refused" : "");
    if (err)
        check_error();
    else
        check_domain(&h, &how);
    if (wrap)
        CHECK_EQ(err, 0);
    domain_free(&d);
    return took;
}

/* ---- tests ------------------------------------------------------------------------------------ */

static void broken_meshes_are_weighted(void)
{
    for (int way = 0; way < WAYS; way++) {
        damage("triceratops", way, 1);
        if (way % 2 == 0)
            damage("hand", way, 1);
    }
}

static void broken_meshes_are_refused_where_they_are_broken(void)
{
    for (int way = 0; way < WAYS; way++)
        damage("hand", way, 0);
}

/* What was a closed surface before its triangles were torn apart needs no wrap. */
static void equal_vertices_are_one(void)
{
    handle tip[POINTS + 1];
    const handles h = {POINTS + 1, 0, tip, NULL};
    const domain_options how = {0, &origin, 1};
    read_off("hand");
    choose_handles(tip);
    soup();
    const surface s = {vertices, triangles, at[0], (const int(*)[3])triangle};
    CHECK_EQ(domain_solid(&s, &h, &how, &d, &error), 0);
    CHECK_EQ(d.wrapped, 0);
    CHECK_EQ(d.from_count, vertices);
    for (int i = 0; i < vertices && d.vertex_of; i++)
        CHECK(memcmp(d.at + 3 * d.vertex_of[i], at[i], sizeof *at) == 0);
    domain_free(&d);
}

static void add_vertex(double x, double y, double z)
{
    memcpy(at[vertices++], (const double[]){x, y, z}, sizeof *at);
}

static void add_triangle(int p, int q, int r)
{
    memcpy(triangle[triangles++], (const int[]){p, q, r}, sizeof *triangle);
}

/* A prism over 40 corners without its top: closed, it has the volume of one. */
static void a_hole_is_closed_with_what_is_missing(void)
{
    const double turn = 2 * acos(-1.0) / 40;
    handle middle = {.name = "p", .line = 9, .kind = HANDLE_POINT, .from = {0, 0, 0.5}};
    const handles h = {1, 0, &middle, NULL};
    const domain_options how = {0.2, &origin, 1};
    double sum = 0;
    vertices = triangles = 0;
    for (int i = 0; i < 80; i++)
        add_vertex(cos(i / 2 * turn), sin(i / 2 * turn), i % 2);
    for (int i = 0; i < 80; i++)
        add_triangle(i, (i + (i % 2 ? 1 : 2)) % 80, (i + (i % 2 ? 2 : 1)) % 80);
    for (int i = 1; i < 39; i++)
        add_triangle(0, 2 * i + 2, 2 * i);
    const surface s = {vertices, triangles, at[0], (const int(*)[3])triangle};
    CHECK_EQ(domain_solid(&s, &h, &how, &d, &error), 0);
    CHECK_EQ(d.wrapped, 0);
    for (int i = 0; i < d.element_count; i++) {
        const int *c = d.element[i];
        sum += tets_det(d.at + 3 * c[0], d.at + 3 * c[1], d.at + 3 * c[2], d.at + 3 * c[3]) / 6;
    }
    CHECK_NEAR(sum, 20 * sin(turn),
               1e-12); /* 40 triangles, to rounding of some 10,000 tetrahedra */
    check_domain(&h, &how);
    domain_free(&d);
}

/* One square in two triangles: a plate as thin as the wrap is off. */
static void a_sheet_is_wrapped(void)
{
    handle corner[2] = {{.name = "p", .line = 9, .kind = HANDLE_POINT, .from = {0, 0, 0}},
                        {.name = "q", .line = 10, .kind = HANDLE_POINT, .from = {1, 1, 0}}};
    const handles h = {2, 0, corner, NULL};
    const domain_options how = {0, &origin, 1};
    vertices = triangles = 0;
    for (int i = 0; i < 4; i++)
        add_vertex(i & 1, i >> 1, 0);
    add_triangle(0, 1, 2);
    add_triangle(1, 3, 2);
    const surface s = {vertices, triangles, at[0], (const int(*)[3])triangle};
    CHECK_EQ(domain_solid(&s, &h, &how, &d, &error), 0);
    CHECK_EQ(d.wrapped, 1);
    for (int i = 0; i < d.vertex_count; i++)
        CHECK(fabs(d.at[3 * i + 2]) < 0.01);
    check_domain(&h, &how);
    domain_free(&d);
}

static void numbers_that_are_none_are_refused(void)
{
    const handles none = {0, 0, NULL, NULL};
    const domain_options how = {0, &origin, 1};
    read_off("hand");
    const surface s = {vertices, triangles, at[0], (const int(*)[3])triangle};
    at[30][1] = NAN;
    CHECK_EQ(domain_solid(&s, &none, &how, &d, &error), -1);
    CHECK(strstr(error.text, "vertex 30 is at (") != NULL);
    read_off("hand");
    triangle[11][2] = -1;
    CHECK_EQ(domain_solid(&s, &none, &how, &d, &error), -1);
    CHECK(strstr(error.text, "triangle 11 has a corner -1") != NULL);
    read_off("hand");
    for (int i = 0; i < vertices; i++)
        memcpy(at[i], at[0], sizeof *at);
    CHECK_EQ(domain_solid(&s, &none, &how, &d, &error), -1);
    CHECK(strstr(error.text, "triangles without area") != NULL);
}

static void the_whole_corpus_is_weighted(void)
{
    static const char *const names[] = {"elephant", "bull", "cow",    "homer", "hand",
                                        "man",      "bear", "cactus", "pig",   "triceratops"};
    double sum = 0, most = 0;
    int count = 0;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        for (int way = 0; way < WAYS; way++, count++) {
            double took = damage(names[i], way, 1);
            sum += took;
            most = fmax(most, took);
            fflush(stdout);
        }
    printf("%d surfaces, mean %.2f s, most %.2f s\n", count, sum / count, most);
}

int main(int argc, char **argv)
{
    verbose = argc > 1 && strcmp(argv[1], "--all") == 0;
    if (system("mkdir -p build/cgal && tar -xzf " DATA " -C build/cgal data/meshes") != 0) {
        printf(DATA ": not there; install libcgal-demo\n");
        return 1;
    }
    if (verbose) {
        TEST(the_whole_corpus_is_weighted);
        return check_done();
    }
    TEST(broken_meshes_are_weighted);
    TEST(broken_meshes_are_refused_where_they_are_broken);
    TEST(equal_vertices_are_one);
    TEST(a_hole_is_closed_with_what_is_missing);
    TEST(a_sheet_is_wrapped);
    TEST(numbers_that_are_none_are_refused);
    return check_done();
}
