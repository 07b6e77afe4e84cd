/* Domains of flat shapes and solids: what is meshed, and which vertices a handle holds.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "domain_model.h"

/* ---- flat ------------------------------------------------------------------------------------- */

/* A flower with a square hole in which an island stands. */
enum { PETALS = 120 };
static double points[2 * (PETALS + 8)];
static const int loops[4] = {0, PETALS, PETALS + 4, PETALS + 8};

static outline flower(void)
{
    static const double hole[16] = {-0.4, -0.4, -0.4, 0.4,  0.4, 0.4, 0.4,  -0.4,
                                    -0.2, -0.2, 0.2,  -0.2, 0.2, 0.2, -0.2, 0.2};
    for (int i = 0; i < PETALS; i++) {
        double angle = 2 * acos(-1.0) * i / PETALS, radius = 1 + 0.2 * cos(5 * angle);
        points[2 * i] = radius * cos(angle);
        points[2 * i + 1] = radius * sin(angle);
    }
    memcpy(points + 2 * PETALS, hole, sizeof hole);
    return (outline){2, PETALS + 4, loops, points};
}

/* By the shoelace formula. */
static double area_of_loop(const outline *o, int loop)
{
    double twice = 0;
    for (int i = o->loop[loop]; i < o->loop[loop + 1]; i++) {
        int next = i + 1 < o->loop[loop + 1] ? i + 1 : o->loop[loop];
        twice += o->at[2 * i] * o->at[2 * next + 1] - o->at[2 * i + 1] * o->at[2 * next];
    }
    return fabs(twice) / 2;
}

static double area_of(int i)
{
    const double *p = corner(i, 0), *q = corner(i, 1), *r = corner(i, 2);
    return ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])) / 2;
}

static double least_angle(int i)
{
    double least = HUGE_VAL;
    for (int k = 0; k < 3; k++) {
        double u = tets_distance(corner(i, k), corner(i, (k + 1) % 3));
        double v = tets_distance(corner(i, k), corner(i, (k + 2) % 3));
        least = fmin(least, asin(fmin(1, 2 * area_of(i) / (u * v))));
    }
    return least * 180 / acos(-1.0);
}

static void check_flat(const outline *o, double area, int euler)
{
    double sum = 0;
    CHECK_EQ(d.dimension, 2);
    for (int i = 0; i < o->point_count; i++) {
        CHECK(memcmp(d.at + 3 * i, o->at + 2 * i, 2 * sizeof *d.at) == 0);
        CHECK(d.at[3 * i + 2] == 0.0);
    }
    for (int i = 0; i < d.element_count; i++) {
        CHECK(area_of(i) > 0);
        CHECK_EQ(d.element[i][3], -1);
        sum += area_of(i);
    }
    /* Each area is right to 4 products of coordinates below 2. */
    CHECK_NEAR(sum, area, d.element_count * 16 * ldexp(1, -53));
    surface s = as_surface();
    tets_edge *edge = tets_edges(&s);
    int edges = 0;
    for (int i = 0, n; i < 3 * s.triangle_count; i += n, edges++) {
        n = tets_edge_count(&s, edge, i);
        CHECK(n <= 2);
    }
    CHECK_EQ(d.vertex_count - edges + d.element_count, euler);
    free(edge);
    free((void *)(uintptr_t)s.triangle);
}

static void a_flat_shape_is_what_is_inside_an_odd_number_of_loops(void)
{
    outline o = flower();
    o.loop_count = 3; /* the island too */
    o.point_count += 4;
    double area = area_of_loop(&o, 0) - area_of_loop(&o, 1) + area_of_loop(&o, 2);
    no_handles();
    CHECK_EQ(make_flat(&o, 0.05), 0);
    check_flat(&o, area, 1); /* a ring has 0, a disc 1 */
    finish();
}

/* No corner of the flower is sharper than 90 degrees. Edges are one cell long in the mean; that of
 * the usual cell makes about 10,000 triangles. */
static void triangles_have_the_size_and_the_angles_asked_for(void)
{
    outline o = flower();
    o.loop_count = 1;
    o.point_count = PETALS;
    no_handles();
    for (int usual = 0; usual < 2; usual++) {
        double sum = 0;
        CHECK_EQ(make_flat(&o, usual ? 0 : 0.04), 0);
        CHECK(usual || d.cell == 0.04);
        for (int i = 0; i < d.element_count; i++) {
            CHECK(least_angle(i) > 20);
            for (int k = 0; k < 3; k++)
                sum += tets_distance(corner(i, k), corner(i, (k + 1) % 3)) / 3;
        }
        CHECK_NEAR(sum / d.element_count, d.cell, 0.1 * d.cell);
        CHECK(!usual || (d.element_count > 8000 && d.element_count < 12500));
        finish();
    }
}

static void the_same_shape_twice_is_the_same_to_the_bit(void)
{
    outline o = flower();
    int skeleton_count = add_bone("a", 0.5, 0, 1.1, 0.05);
    CHECK_EQ(skeleton_count, 1);
    CHECK_EQ(make_flat(&o, 0.05), 0);
    domain first = d;
    CHECK_EQ(make_flat(&o, 0.05), 0);
    CHECK_EQ(first.vertex_count, d.vertex_count);
    CHECK_EQ(first.element_count, d.element_count);
    CHECK(memcmp(first.at, d.at, 3 * (size_t)d.vertex_count * sizeof *d.at) == 0);
    CHECK(memcmp(first.element, d.element, (size_t)d.element_count * sizeof *d.element) == 0);
    domain_free(&first);
    finish();
}

static void wrong_outlines_are_refused_where_they_are_wrong(void)
{
    double bow[8] = {0, 0, 2, 2, 2, 0, 0, 2}, line[6] = {0, 0, 1, 1, 2, 2};
    double twice[12] = {0, 0, 4, 0, 0, 4, 1, 1, 1, 2, 4, 0};
    double touching[12] = {0, 0, 4, 0, 0, 4, 2, 2, 1, 1, 1.5, 1};
    const int one[2] = {0, 4}, short_loop[3] = {0, 3, 5}, two[3] = {0, 3, 6}, flat[2] = {0, 3};
    outline o = {1, 4, one, bow};
    no_handles();
    refuse_flat(&o, "crosses or touches itself in 1 places, the first at (1, 1)");
    o = (outline){2, 6, two, touching};
    refuse_flat(&o, "crosses or touches itself in 2 places, the first at (2, 2)");
    o = (outline){2, 6, two, twice};
    refuse_flat(&o, "is twice at (4, 0)");
    o = (outline){2, 5, short_loop, twice};
    refuse_flat(&o, "loop 1 of the outline has fewer than 3 points");
    o = (outline){1, 3, flat, line};
    refuse_flat(&o, "crosses or touches itself");
    bow[3] = NAN;
    o = (outline){1, 4, one, bow};
    refuse_flat(&o, "point 1 of the outline is nowhere");
    o = (outline){0, 0, one, bow};
    refuse_flat(&o, "no outline");
}

/* ---- solids ----------------------------------------------------------------------------------- */

static void a_solid_has_the_surface_first_and_its_volume(void)
{
    double sum = 0;
    make_sphere(12, 20);
    no_handles();
    add_bone3("a", (const double[]){-0.5, 0, 0}, (const double[]){0.5, 0.1, 0.2});
    CHECK_EQ(make_solid(0.15, 0), 0);
    CHECK_EQ(d.dimension, 3);
    CHECK_EQ(d.wrapped, 0);
    CHECK(d.vertex_of == NULL);
    CHECK(memcmp(d.at, at, sizeof *at * (size_t)vertices) == 0);
    for (int i = 0; i < d.element_count; i++) {
        double det = tets_det(corner(i, 0), corner(i, 1), corner(i, 2), corner(i, 3));
        CHECK(det > 0);
        sum += det / 6;
    }
    CHECK_NEAR(sum, volume_inside(), (d.element_count + triangles) * 4.0 * ldexp(1, -53));
    finish();
}

static void a_solid_without_a_cell_has_about_50000_tetrahedra_at_most(void)
{
    make_cube();
    no_handles();
    CHECK_EQ(make_solid(0, 0), 0);
    CHECK(d.element_count > 5000 && d.element_count < 75000);
    finish();
    make_sphere(30, 60); /* 3,480 triangles, more than that cell asks for at the poles alone */
    CHECK_EQ(make_solid(0, 0), 0);
    CHECK(d.element_count > 25000 && d.element_count < 75000);
    finish();
}

/* ---- handles ---------------------------------------------------------------------------------- */

/* Vertices on a bone, from its start: not more than a cell apart, and nowhere off it. */
static void check_bone(int index)
{
    const handle *h = &list[index];
    double length = tets_distance(h->from, h->to), reached = 0;
    for (int step = 0; step <= 1000; step++) {
        double t = step / 1000.0, nearest = HUGE_VAL;
        for (int i = 0; i < f.count; i++) {
            const double *p = d.at + 3 * f.vertex[i];
            double from = tets_distance(p, h->from);
            /* On the bone: the detour over p is no longer than the bone, to rounding. */
            if (f.value[f.handle_count * i + index] > 0 &&
                from + tets_distance(p, h->to) <= length * (1 + 1e-12))
                nearest = fmin(nearest, fabs(from - t * length));
        }
        reached = fmax(reached, nearest);
    }
    CHECK(reached <= d.cell / 2 * (1 + 1e-9) + length / 1000);
}

static void bones_are_vertices_all_along(void)
{
    make_cube();
    no_handles();
    add_bone3("a", (const double[]){-0.7, -0.1, 0}, (const double[]){0, 0.2, 0.1});
    add_bone3("b", (const double[]){0, 0.2, 0.1}, (const double[]){0.7, 0, 0.3});
    CHECK_EQ(make_solid(0.17, 0), 0);
    hold();
    check_bone(0);
    check_bone(1);
    int joints = 0;
    for (int i = 0; i < f.count; i++) {
        const double *v = f.value + 2 * i;
        int joint = tets_distance(d.at + 3 * f.vertex[i], list[0].to) == 0;
        joints += joint;
        CHECK(joint ? v[0] == 0.5 && v[1] == 0.5 : (v[0] == 1) != (v[1] == 1) && v[0] + v[1] == 1);
        CHECK(i == 0 || f.vertex[i] > f.vertex[i - 1]);
    }
    CHECK_EQ(joints, 1);
    finish();
    outline o = flower();
    no_handles();
    add_bone("a", 0.5, 0, 1.1, 0.05);
    CHECK_EQ(make_flat(&o, 0.05), 0);
    hold();
    check_bone(0);
    finish();
}

static void find_value(const double *place, const double *want)
{
    int found = 0;
    for (int i = 0; i < f.count; i++)
        if (tets_distance(d.at + 3 * f.vertex[i], place) < 1e-12) {
            found++;
            for (int k = 0; k < f.handle_count; k++)
                CHECK_NEAR(f.value[f.handle_count * i + k], want[k], 1e-15);
        }
    CHECK_EQ(found, 1);
}

/* Three bones of a star; a fourth begins along one of them. */
static void a_joint_belongs_to_its_bones_in_equal_parts(void)
{
    const double o[3] = {0, 0, 0}, x[3] = {0.6, 0, 0}, y[3] = {0, 0.6, 0}, z[3] = {0, 0, 0.6},
                 middle[3] = {0, 0.3, 0}, off[3] = {-0.4, 0.3, 0.1};
    make_cube();
    no_handles();
    add_bone3("x", o, x);
    add_bone3("y", o, y);
    add_bone3("z", z, o);
    add_bone3("branch", middle, off);
    CHECK_EQ(make_solid(0.2, 0), 0);
    hold();
    find_value(o, (const double[]){1 / 3.0, 1 / 3.0, 1 / 3.0, 0});
    find_value(middle, (const double[]){0, 0.5, 0, 0.5});
    find_value(x, (const double[]){1, 0, 0, 0});
    find_value(off, (const double[]){0, 0, 0, 1});
    finish();
}

static void points_and_regions_hold_what_they_are(void)
{
    static const int north[] = {0, 2, 1}, other[] = {5, 1};
    make_sphere(8, 12);
    no_handles();
    add_point("inside", 0.1, 0.2, 0.05);
    add_point("corner", at[60][0], at[60][1], at[60][2]);
    add_region("cap", north, 3);
    CHECK_EQ(make_solid(0.3, 0), 0);
    hold();
    CHECK_EQ(f.count, 5);
    find_value(list[0].from, (const double[]){1, 0, 0});
    find_value(at[60], (const double[]){0, 1, 0});
    for (int i = 0; i < 3; i++) {
        CHECK_EQ(f.vertex[i], i);
        find_value(at[i], (const double[]){0, 0, 1});
    }
    add_region("other", other, 2);
    refuse_hold("scene.yaml:13: region 'cap' and region 'other' are in one place, at (");
    finish();
}

static void two_handles_in_one_place_are_refused_by_name(void)
{
    const double o[3] = {-0.5, 0, 0}, x[3] = {0.5, 0, 0}, y[3] = {0, -0.5, 0}, z[3] = {0, 0.5, 0};
    make_cube();
    no_handles();
    add_bone3("along", o, x);
    add_bone3("across", y, z);
    CHECK_EQ(make_solid(0.25, 0), 0); /* four pieces: both have a vertex in the middle */
    refuse_hold("scene.yaml:11: bone 'along' and bone 'across' are in one place, at (0, 0, 0)");
    finish();
    no_handles();
    add_point("first", 0.1, 0.1, 0.1);
    add_point("second", 0.1, 0.1, 0.1);
    CHECK_EQ(make_solid(0.2, 0), 0);
    refuse_hold("point 'first' and point 'second' are in one place, at (0.1, 0.1, 0.1)");
    finish();
    no_handles();
    add_bone3("arm", o, x);
    add_point("dot", 0.5, 0, 0);
    CHECK_EQ(make_solid(0.2, 0), 0);
    refuse_hold("point 'dot' and bone 'arm' are in one place, at (0.5, 0, 0)");
    finish();
}

/* Another surface would not help. */
static void cells_that_are_too_small_are_refused(void)
{
    outline o = flower();
    make_cube();
    no_handles();
    silence();
    CHECK_EQ(make_solid(0.004, 1), -1);
    CHECK(strcmp(spoken(), "") == 0);
    CHECK(strstr(error.text, "; give it a 'cell' of 0.0") != NULL);
    add_bone3("a", (const double[]){-0.9, 0, 0}, (const double[]){0.9, 0, 0});
    silence();
    CHECK_EQ(make_solid(1e-5, 1), -1);
    CHECK(strcmp(spoken(), "") == 0);
    CHECK(strstr(error.text, "; give it a larger 'cell'") != NULL);
    no_handles();
    refuse_cell(&o, 1e-4, "; give it a larger 'cell'");
}

static void a_handle_outside_is_refused_with_its_distance(void)
{
    make_cube();
    no_handles();
    add_point("in", 0, 0, 0);
    add_bone3("out", (const double[]){3, 0, 0}, (const double[]){1.5, 0, 0});
    CHECK_EQ(make_solid(0.3, 0), 0);
    refuse_hold("scene.yaml:11: bone 'out' holds nothing: at (1.5, 0, 0) it is outside of mesh "
                "thing, 0.5 away");
    finish();
    outline o = flower();
    no_handles();
    add_point("hole", 0, 0.1, 0);
    CHECK_EQ(make_flat(&o, 0.05), 0);
    refuse_hold("point 'hole' holds nothing: at (0, 0.1, 0) it is outside of mesh thing, 0.3 away");
    finish();
    no_handles();
    add_region("none", NULL, 0);
    CHECK_EQ(make_flat(&o, 0.05), 0);
    refuse_hold("region 'none' has no vertices of mesh thing");
    finish();
}

/* What is nearly on the border gets no vertex of its own, which would be that near to it. */
static void samples_near_the_border_take_a_vertex_that_is_there(void)
{
    const double depth = 1e-4;
    make_cube();
    no_handles();
    add_bone3("a", (const double[]){-0.5, 0.03, 1 - depth}, (const double[]){0.5, 0.03, 1 - depth});
    add_point("b", 0.31, -0.57, -1 - depth);
    CHECK_EQ(make_solid(0.2, 0), 0);
    hold();
    CHECK(f.count >= 4);
    for (int i = 0; i < f.count; i++)
        CHECK(fabs(d.at[3 * f.vertex[i] + 2]) == 1);
    for (int i = 0; i < d.vertex_count; i++)
        CHECK(fabs(d.at[3 * i + 2]) == 1 || fabs(d.at[3 * i + 2]) < 1 - 0.1 * d.cell);
    finish();
}

/* A plate thinner than a quarter of a cell: no sample is inside of it by more than that. */
static void bones_in_what_is_thin_are_held(void)
{
    make_cube();
    for (int i = 0; i < vertices; i++)
        at[i][2] *= 0.02;
    no_handles();
    add_bone3("a", (const double[]){-0.8, 0.03, 0}, (const double[]){0, 0.03, 0});
    add_bone3("b", (const double[]){0, 0.03, 0}, (const double[]){0.8, 0.03, 0});
    CHECK_EQ(make_solid(0.2, 0), 0);
    hold();
    double share[2] = {0, 0};
    for (int i = 0; i < f.count; i++)
        for (int k = 0; k < 2; k++)
            share[k] += f.value[2 * i + k] == 1;
    CHECK(share[0] >= 2 && share[1] >= 2);
    finish();
}

/* ---- cages ------------------------------------------------------------------------------------ */

/* Values that are linear on facets give each held vertex its own place back. */
static void check_places(void)
{
    for (int i = 0; i < f.count; i++) {
        double sum = 0, place[3] = {0, 0, 0};
        for (int k = 0; k < f.handle_count; k++) {
            double value = f.value[f.handle_count * i + k];
            CHECK(value >= 0 && (value == 0 || list[k].kind == HANDLE_CAGE));
            sum += value;
            for (int x = 0; x < 3; x++)
                place[x] += value * list[k].from[x];
        }
        CHECK_NEAR(sum, 1, 1e-14);
        CHECK(tets_distance(place, d.at + 3 * f.vertex[i]) < 1e-13);
    }
}

static void add_cage_cube(double half)
{
    for (int i = 0; i < 8; i++)
        add_cage("c", i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half);
    memcpy(facet, triangle, 12 * sizeof *facet);
    facet_count = 12;
}

static void a_closed_cage_around_a_solid_is_the_border(void)
{
    no_handles();
    make_cube(); /* for its triangles */
    add_cage_cube(1.5);
    make_sphere(8, 12);
    triangles -= 3; /* what is inside may be anything */
    CHECK_EQ(make_solid(0.4, 0), 0);
    CHECK(d.vertex_of != NULL);
    CHECK_EQ(d.from_count, vertices);
    hold();
    check_places();
    int border = 0;
    for (int i = 0; i < d.vertex_count; i++) {
        const double *p = d.at + 3 * i;
        border += fmax(fabs(p[0]), fmax(fabs(p[1]), fabs(p[2]))) == 1.5;
    }
    CHECK_EQ(f.count, border);
    CHECK(border > 100);
    check_embedding(at[0], vertices, 0);
    finish();
}

static void a_closed_cage_around_a_flat_shape_is_the_border(void)
{
    static const double square[8] = {-2, -2, 2, -2, 2, 2, -2, 2};
    outline o = flower();
    no_handles();
    for (int i = 0; i < 4; i++) {
        add_cage("c", square[2 * i], square[2 * i + 1], 0);
        add_facet(i, (i + 1) % 4, -1);
    }
    CHECK_EQ(make_flat(&o, 0.1), 0);
    double sum = 0;
    for (int i = 0; i < d.element_count; i++)
        sum += area_of(i);
    CHECK_NEAR(sum, 16, 1e-11);
    hold();
    check_places();
    CHECK(f.count >= 16 / 0.15);
    CHECK_EQ(d.from_count, o.point_count);
    finish();
}

static void an_open_cage_holds_what_is_inside(void)
{
    no_handles();
    add_cage("a", -0.5, -0.5, 0.1);
    add_cage("b", 0.5, -0.5, 0);
    add_cage("c", 0, 0.6, 0.2);
    add_facet(0, 1, 2);
    make_cube();
    CHECK_EQ(make_solid(0.2, 0), 0);
    CHECK(memcmp(d.at, at, sizeof *at * (size_t)vertices) == 0);
    hold();
    check_places();
    CHECK(f.count >= 15); /* 6 edges of it long: 28 samples, less some that are near others */
    finish();
    outline o = flower();
    no_handles();
    add_cage("a", 0.5, 0, 0);
    add_cage("b", 1.1, 0.05, 0);
    add_facet(0, 1, -1);
    CHECK_EQ(make_flat(&o, 0.05), 0);
    hold();
    check_places();
    CHECK(f.count >= 10);
    add_cage("far", 5, 5, 0);
    refuse_hold("cage vertex 'far' holds nothing: at (5, 5, 0) it is outside of mesh thing");
    finish();
}

static void facets_of_other_handles_are_refused(void)
{
    no_handles();
    add_point("a", 0, 0, 0);
    add_cage("b", 0.5, 0, 0);
    add_facet(0, 1, -1);
    make_cube();
    CHECK_EQ(make_solid(0.5, 0), -1);
    CHECK(strstr(error.text, "scene.yaml:7: a cage's facet joins what is no vertex") != NULL);
}

/* ---- surfaces and points ------------------------------------------------------------------------- */

static void a_surface_is_held_where_it_is_nearest(void)
{
    make_sphere(20, 40);
    no_handles();
    add_bone3("a", (const double[]){-0.9, 0, 0}, (const double[]){0, 0, 0.1});
    add_bone3("b", (const double[]){0, 0, 0.1}, (const double[]){0.9, 0.1, 0});
    add_point("c", 0, 0, -2);
    surface s = whole();
    CHECK_EQ(domain_surface(&s, &d, &error), 0);
    CHECK_EQ(d.dimension, 2);
    hold();
    find_value(at[vertices - 1], (const double[]){0, 0, 1}); /* the south pole */
    int own[2] = {0, 0};
    for (int i = 0; i < f.count; i++)
        for (int k = 0; k < 2; k++)
            if (f.value[3 * i + k] == 1) {
                own[k]++;
                CHECK((k ? 1 : -1) * d.at[3 * f.vertex[i]] > -0.2);
            }
    CHECK(own[0] > 1 && own[1] > 1);
    finish();
    triangle[3][1] = vertices;
    CHECK_EQ(domain_surface(&s, &d, &error), -1);
    CHECK(strstr(error.text, "triangle 3 of a surface has a corner") != NULL);
}

/* Linear functions come out right inside; outside as at the nearest point, which on a cube is the
 * point with its coordinates cut off. */
static void points_are_means_of_vertices(void)
{
    enum { COUNT = 500 };
    double place[COUNT][3];
    make_cube();
    no_handles();
    CHECK_EQ(make_solid(0.3, 0), 0);
    for (int i = 0; i < 3 * COUNT; i++)
        place[i / 3][i % 3] = 3 * chance() - 1.5;
    check_embedding(place[0], COUNT, 1);
    finish();
}

/* ---- parts that nothing holds -------------------------------------------------------------------- */

static void parts_without_handles_follow_the_nearest_part(void)
{
    make_cube();
    add_cube(1.5, 0.5);
    no_handles();
    add_point("a", 0, 0, 0);
    silence();
    CHECK_EQ(make_solid(0.3, 0), 0);
    CHECK(strstr(spoken(), "scene.yaml:7: mesh thing: warning: 1 part touches no handle, the first "
                           "at (1.5, 1.5, 1.5)") != NULL);
    for (int i = 0; i < 3 * d.vertex_count; i++)
        CHECK(fabs(d.at[i]) <= 1);
    CHECK_EQ(d.from_count, 16);
    for (int i = 0; i < 16; i++) /* vertex 7 is the corner at (1, 1, 1) */
        CHECK(tets_distance(d.at + 3 * d.vertex_of[i], at[i < 8 ? i : 7]) == 0);
    hold();
    CHECK_EQ(f.count, 1);
    finish();
    add_point("b", 1.75, 1.75, 1.75);
    CHECK_EQ(make_solid(0.3, 0), 0);
    CHECK(d.vertex_of == NULL);
    finish();
}

int main(void)
{
    TEST(a_flat_shape_is_what_is_inside_an_odd_number_of_loops);
    TEST(triangles_have_the_size_and_the_angles_asked_for);
    TEST(the_same_shape_twice_is_the_same_to_the_bit);
    TEST(wrong_outlines_are_refused_where_they_are_wrong);
    TEST(a_solid_has_the_surface_first_and_its_volume);
    TEST(a_solid_without_a_cell_has_about_50000_tetrahedra_at_most);
    TEST(bones_are_vertices_all_along);
    TEST(a_joint_belongs_to_its_bones_in_equal_parts);
    TEST(points_and_regions_hold_what_they_are);
    TEST(two_handles_in_one_place_are_refused_by_name);
    TEST(cells_that_are_too_small_are_refused);
    TEST(a_handle_outside_is_refused_with_its_distance);
    TEST(samples_near_the_border_take_a_vertex_that_is_there);
    TEST(bones_in_what_is_thin_are_held);
    TEST(a_closed_cage_around_a_solid_is_the_border);
    TEST(a_closed_cage_around_a_flat_shape_is_the_border);
    TEST(an_open_cage_holds_what_is_inside);
    TEST(facets_of_other_handles_are_refused);
    TEST(a_surface_is_held_where_it_is_nearest);
    TEST(points_are_means_of_vertices);
    TEST(parts_without_handles_follow_the_nearest_part);
    return check_done();
}
