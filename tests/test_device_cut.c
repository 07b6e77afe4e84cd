/* Triangles that reach behind the viewer or far out of the picture, and clips that mean harm.
 * SPDX-License-Identifier: MIT */
#include "draw.h"
#include "picture_model.h"

#define SIDE 96

static pc_mesh mesh;
static pc_scene scene;
static pm_model model;
static uint32_t seed = 11;

static uint32_t bits(void)
{
    seed = seed * 1664525u + 1013904223u;
    return seed >> 8;
}

static double dice(double low, double high)
{
    return low + (high - low) * bits() / 16777216.0;
}

static void open_scene(uint8_t projection, uint8_t shading)
{
    const wg_size size = {SIDE, SIDE};
    pc_open(&scene, &mesh, projection, shading, size);
}

/* ---- cut triangles against rays -------------------------------------------------------------- */

/* The coarsest unit that a vertex outside is kept in: 8^e/128 pixel of the target's plane across and
 * 8^e/4 steps deep, cut down. */
static double coarsest(void)
{
    unsigned e = 0;
    for (unsigned i = 0; i < mesh.vertices; i++) {
        unsigned own = scene.vertices[i].z >> 13 & 3u;
        e = scene.vertices[i].z >> 15 && own > e ? own : e;
    }
    return ldexp(1, (int)(3 * e));
}

/* How far from the model a cut edge may be seen where something at `depth` is: by that unit and by one
 * of the finest for the cut itself; nearness magnifies it by distance/depth. What is not cut is off
 * by 1/16. */
static double cut_error(double unit, double depth, double off_middle)
{
    double nearer = model.flat ? 1 : model.distance / depth;
    double deep = model.flat ? 0 : (unit / 4 + 0.5) * model.distance / 4096 / depth * off_middle;
    return (unit + 1) / 128 * nearer + deep + 1.0 / 16;
}

/* Nearness may be off by what the edges are: as far as the surface gets in as many pixels, and by as
 * many steps. */
static double depth_error(unsigned triangle, double x, double y, double reach)
{
    double d = pm_depth(&model, triangle, x, y), error = 0;
    for (int i = 0; i < 4; i++) {
        double way = i & 2 ? reach : -reach;
        double there = pm_depth(&model, triangle, x + (i & 1 ? way : 0), y + (i & 1 ? 0 : way));
        error = fmax(error, fabs(there - d));
    }
    return 2 * error + (coarsest() / 4 + 0.5) * model.distance / 4096;
}

static double nearness(double depth)
{
    double steps = depth / model.distance * scene.picture.view.distance / 4096;
    return model.flat ? 65535 - 2 * steps : scene.picture.view.nearness / steps;
}

/* Returns how many pixels were compared. */
static unsigned compare_pixels(const uint32_t *pixels)
{
    static uint8_t marked[SIDE * SIDE];
    unsigned compared = 0;
    double unit = coarsest();
    for (int p = 0; p < SIDE * SIDE; p++) {
        double x = p % SIDE + 0.5, y = p / SIDE + 0.5;
        double reach = cut_error(unit, model.distance, 0);
        pm_hit hit = pm_look(&model, x, y);
        if (hit.triangle >= 0) {
            reach = cut_error(unit, hit.depth, hypot(x - SIDE / 2, y - SIDE / 2));
        }
        if (p == 0) {
            pm_mark_edges(&model, 1, marked);
        }
        if (reach > 1 || marked[p]) {
            continue;
        }
        compared++;
        CHECK_EQ(WG_PIXEL_PART(pixels[p]),
                 hit.triangle < 0 ? 0u : pm_part(&mesh, (unsigned)hit.triangle) + 1);
        if (hit.triangle >= 0) {
            double off = depth_error((unsigned)hit.triangle, x, y, reach);
            double low = nearness(hit.depth + off), high = nearness(fmax(hit.depth - off, 1e-9));
            CHECK(WG_PIXEL_NEAR(pixels[p]) >= low - 4 && WG_PIXEL_NEAR(pixels[p]) <= high + 4);
        }
    }
    return compared;
}

static void compare_view(const pc_camera *camera, uint8_t projection, unsigned least)
{
    pc_look(&scene, camera);
    pm_make(&model, &mesh, &scene, projection == WG_ORTHOGRAPHIC);
    unsigned compared = compare_pixels(pc_draw(&scene));
    CHECK(compared >= least);
}

static unsigned outside_count(void)
{
    unsigned count = 0;
    for (unsigned i = 0; i < mesh.vertices; i++) {
        count += scene.vertices[i].z >> 15;
    }
    return count;
}

/* The viewer stands in a room of 200: all around is some wall, and walls reach behind the viewer. The
 * farthest corner is less than 4 distances away. */
static void inside_a_room_every_pixel_is_a_wall(void)
{
    memset(&mesh, 0, sizeof mesh);
    pc_box(&mesh, 100, 1);
    open_scene(WG_PERSPECTIVE, WG_SHADING_FLAT);
    for (unsigned i = 0; i < 10; i++) {
        pc_camera c = {dice(-180, 180), dice(-90, 90),
                       dice(-180, 180), {dice(-8, 8), dice(-8, 8), dice(-8, 8)},
                       dice(66, 85),    dice(30, 66)};
        compare_view(&c, WG_PERSPECTIVE, SIDE * SIDE / 2);
        CHECK(outside_count() > 0);
        for (int p = 0; p < SIDE * SIDE; p++) {
            CHECK(scene.pixels[p] != 0);
        }
    }
    pc_close(&scene);
}

/* Whether a line's pixel lies within 1.5 pixels of a place. */
static int line_near(double x, double y)
{
    for (int p = 0; p < SIDE * SIDE; p++) {
        if (WG_PIXEL_PART(scene.pixels[p]) && hypot(p % SIDE + 0.5 - x, p / SIDE + 0.5 - y) < 1.5) {
            return 1;
        }
    }
    return 0;
}

/* Places on the edges of triangles whose fronts are turned to the viewer, and to be seen from the
 * middle of a room or outside of a box: none hides another. */
static void check_lines(int inside)
{
    static uint8_t marked[SIDE * SIDE];
    unsigned seen = 0;
    pm_mark_edges(&model, 1.5, marked);
    for (int p = 0; p < SIDE * SIDE; p++) {
        CHECK(WG_PIXEL_PART(scene.pixels[p]) == 0 || marked[p]);
        seen += WG_PIXEL_PART(scene.pixels[p]) != 0;
    }
    CHECK(seen > 50);
    for (unsigned i = 0; i < 3 * mesh.triangles * 40; i++) {
        const uint16_t *c = mesh.corner[i / 120];
        double q[3], x, y, normal[3], to[3], t = (i % 40 + 0.5) / 40;
        for (unsigned k = 0; k < 3; k++) {
            q[k] = model.at[c[i / 40 % 3]][k];
            q[k] += t * (model.at[c[(i / 40 + 1) % 3]][k] - q[k]);
            to[k] = q[k] - (k == 2 ? model.distance : 0);
        }
        pm_normal(&model, i / 120, normal);
        double depth = pm_project(&model, q, &x, &y);
        if (depth > model.distance / 8 && pm_dot(normal, to) < 0 && x > 2 && x < SIDE - 2 &&
            y > 2 && y < SIDE - 2) {
            CHECK(line_near(x, y));
        }
    }
    CHECK(!inside || outside_count() > 0);
}

static void lines_are_drawn_where_edges_are_seen(void)
{
    for (int inside = 0; inside < 2; inside++) {
        memset(&mesh, 0, sizeof mesh);
        pc_box(&mesh, inside ? 100 : 25, inside);
        open_scene(WG_PERSPECTIVE, WG_SHADING_WIRE);
        for (unsigned i = 0; i < 8; i++) {
            pc_camera c = {dice(-180, 180), dice(-60, 60), 0, {0, 0, 0}, inside ? 80 : 200, 90};
            pc_look(&scene, &c);
            pm_make(&model, &mesh, &scene, 0);
            pc_draw(&scene);
            check_lines(inside);
        }
        pc_close(&scene);
    }
}

/* Nobody shares its edges: each is drawn by this triangle alone, cut where it enters and where it
 * leaves. */
static void a_lone_triangle_keeps_its_edges(void)
{
    const pc_camera c = {0, 0, 0, {0, 0, 0}, 100, 10};
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    pc_triangle(&mesh, pc_vertex(&mesh, -250, -1, 0), pc_vertex(&mesh, 3, -2, 0),
                pc_vertex(&mesh, 2, 3, 0));
    open_scene(WG_PERSPECTIVE, WG_SHADING_WIRE);
    pc_look(&scene, &c);
    pm_make(&model, &mesh, &scene, 0);
    pc_draw(&scene);
    check_lines(1);
    pc_close(&scene);
}

/* All of a wall has one brightness, however its triangles are cut: here it is the room's own axes
 * that decide. Corners are kept to 1/16 pixel and 2 steps of a wall that is thousands long; 2. */
static void a_cut_wall_has_one_brightness(void)
{
    memset(&mesh, 0, sizeof mesh);
    pc_box(&mesh, 100, 1);
    open_scene(WG_PERSPECTIVE, WG_SHADING_FLAT);
    for (unsigned i = 0; i < 10; i++) {
        pc_camera c = {dice(-180, 180), dice(-60, 60), 0, {dice(-8, 8), 0, 0}, 70, 60};
        pc_look(&scene, &c);
        pm_make(&model, &mesh, &scene, 0);
        scene.picture.view.light[0] = 70;
        scene.picture.view.light[1] = 90;
        scene.picture.view.light[2] = 55;
        pc_draw(&scene);
        for (int p = 0; p < SIDE * SIDE; p++) {
            double normal[3];
            pm_normal(&model, mesh.part[WG_PIXEL_PART(scene.pixels[p]) - 1], normal);
            CHECK_NEAR(WG_PIXEL_SHADE(scene.pixels[p]), pm_shade(&scene.picture.view, normal), 2);
        }
    }
    pc_close(&scene);
}

/* A floor of squares that share their corners, seen from low above it. No crack: where the model sees
 * floor a row below the horizon, it is drawn. */
static void cut_neighbours_leave_no_crack(void)
{
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    for (unsigned i = 0; i < 144; i++) {
        pc_vertex(&mesh, (i % 12) * 40 - 220.0 + dice(-9, 9), 0,
                  (double)(i / 12) * 40 - 220 + dice(-9, 9));
    }
    for (unsigned i = 0; i < 121; i++) {
        unsigned v = i / 11 * 12 + i % 11;
        pc_triangle(&mesh, v, v + 12, v + 13);
        pc_triangle(&mesh, v, v + 13, v + 1);
    }
    open_scene(WG_PERSPECTIVE, WG_SHADING_FLAT);
    for (unsigned i = 0; i < 8; i++) {
        unsigned holes = 0, floor = 0;
        pc_camera c = {dice(-180, 180),      dice(2, 40), dice(-30, 30),
                       {0, dice(0.1, 3), 0}, dice(4, 40), dice(4, 40)};
        pc_look(&scene, &c);
        pm_make(&model, &mesh, &scene, 0);
        CHECK(outside_count() > 0);
        pc_draw(&scene);
        for (int p = 0; p < SIDE * SIDE; p++) {
            double x = p % SIDE + 0.5, y = p / SIDE + 0.5;
            int in = pm_look(&model, x, y).triangle >= 0;
            for (int k = 0; k < 4 && in; k++) { /* well inside: all around as well */
                in = pm_look(&model, x + (k % 2 * 4 - 2), y + (k / 2 * 4 - 2)).triangle >= 0;
            }
            floor += in != 0;
            holes += in && scene.pixels[p] == 0;
        }
        CHECK_EQ(holes, 0);
        CHECK(floor > 500);
    }
    pc_close(&scene);
}

/* Nothing is drawn outside the rectangle that may have changed. */
static void check_dirty(void)
{
    const wg_size one = {1, 1};
    wg_rect r = wg_picture_dirty(&scene.picture, one);
    for (int p = 0; p < SIDE * SIDE; p++) {
        int x = p % SIDE, y = p / SIDE;
        CHECK((x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1) || scene.pixels[p] == 0);
    }
}

/* Corners hundreds of pictures away: the guard planes cut. */
static void huge_triangles_are_drawn_right(void)
{
    for (uint8_t projection = 0; projection < 2; projection++) {
        memset(&mesh, 0, sizeof mesh);
        for (unsigned i = 0; i < 3; i++) {
            double a = 2.1 * i, b = a + 2, c = a + 4.2;
            pc_part(&mesh);
            pc_triangle(&mesh, pc_vertex(&mesh, 120 * cos(a), 120 * sin(a), 2 * i),
                        pc_vertex(&mesh, 120 * cos(b), 120 * sin(b), 2 * i),
                        pc_vertex(&mesh, 120 * cos(c) + 1, 120 * sin(c), 2 * i));
        }
        mesh.sides = 1;
        open_scene(projection, WG_SHADING_FLAT);
        for (unsigned i = 0; i < 10; i++) {
            pc_camera c = {dice(-60, 60),   dice(-60, 60),
                           dice(-180, 180), {dice(-30, 30), dice(-30, 30), 0},
                           dice(60, 100),   dice(1, 8)};
            compare_view(&c, projection, SIDE * SIDE / 2);
            CHECK(outside_count() > 0);
            check_dirty();
        }
        pc_close(&scene);
    }
}

/* In an orthographic picture brightness is linear however a triangle is cut. All corners are hundreds
 * of pictures away, so it hardly changes: 1 for cutting it off, 1 for where the corners are. */
static void cut_corners_pass_their_brightness_on(void)
{
    memset(&mesh, 0, sizeof mesh);
    mesh.fixed = 1;
    pc_part(&mesh);
    pc_triangle(&mesh, pc_vertex(&mesh, -100, -70, 1), pc_vertex(&mesh, 110, -60, 90),
                pc_vertex(&mesh, 0, 120, 30));
    open_scene(WG_ORTHOGRAPHIC, WG_SHADING_SMOOTH);
    for (unsigned i = 0; i < 20; i++) {
        double x = dice(-30, 30), y = dice(-30, 30), area = 0, want = 0, share[3];
        const pc_camera c = {0, 0, 0, {x, y, 0}, 150, 1};
        pc_look(&scene, &c);
        CHECK_EQ(outside_count(), 3);
        pc_draw(&scene);
        for (unsigned k = 0; k < 3; k++) {
            const double *p = mesh.at[(k + 1) % 3], *q = mesh.at[(k + 2) % 3];
            share[k] = (p[0] - x) * (q[1] - y) - (q[0] - x) * (p[1] - y);
            area += share[k];
        }
        for (unsigned k = 0; k < 3; k++) {
            want += share[k] / area * scene.shades[k];
        }
        CHECK_NEAR(WG_PIXEL_SHADE(scene.pixels[SIDE * SIDE / 2 + SIDE / 2]), want - 0.5, 2);
    }
    pc_close(&scene);
}

/* A wall beside the viewer, on to behind him: it ends where it is nearer than 1/16 of the distance.
 * The cut is off by 2^-15 of the wall's 200 at the most, and by a step. */
static void nothing_is_seen_nearer_than_a_sixteenth(void)
{
    memset(&mesh, 0, sizeof mesh);
    mesh.sides = 1;
    pc_part(&mesh);
    unsigned a = pc_vertex(&mesh, 1, -90, -100), b = pc_vertex(&mesh, 1, -90, 100);
    unsigned c = pc_vertex(&mesh, 1, 90, 100), d = pc_vertex(&mesh, 1, 90, -100);
    pc_triangle(&mesh, a, b, c);
    pc_triangle(&mesh, a, c, d);
    const pc_camera camera = {0, 0, 0, {0, 0, 0}, 40, 40};
    unsigned wall = 0;
    open_scene(WG_PERSPECTIVE, WG_SHADING_FLAT);
    pc_look(&scene, &camera);
    pm_make(&model, &mesh, &scene, 0);
    pc_draw(&scene);
    for (int p = 0; p < SIDE * SIDE; p++) {
        double x = p % SIDE + 0.5, y = p / SIDE + 0.5, depth = pm_depth(&model, 0, x, y);
        double off = fmax(200.0 / 32768 + model.distance / 4096,
                          fabs(pm_depth(&model, 0, x + 0.1, y) - depth)); /* edges are 1/16 off */
        if (fabs(depth - model.distance / 16) > off) {
            CHECK_EQ(scene.pixels[p] != 0, pm_look(&model, x, y).triangle >= 0);
        }
        wall += scene.pixels[p] != 0;
    }
    CHECK(wall > 500);
    pc_close(&scene);
}

/* ---- clips that mean harm -------------------------------------------------------------------- */

/* Anything that wg_open_shapes lets through: random coordinates, corners, channels, view. */
static uint8_t *hostile_clip(uint32_t *size)
{
    build b = {{{0}}, 1};
    static int16_t rest[3 * 40];
    uint16_t corners[3 * 60], channels[WG_VIEW_CHANNELS];
    for (unsigned i = 0; i < WG_VIEW_CHANNELS; i++) {
        build_channel(&b, (int)(bits() % 61) - 30, WG_UNIT_NONE, 0);
        channels[i] = (uint16_t)(bits() % WG_VIEW_CHANNELS);
    }
    build_clip(&b, 60, 60, WG_END_HOLD);
    for (unsigned i = 0; i < 3; i++) {
        for (unsigned k = 0; k < 3 * 40; k++) {
            rest[k] = (int16_t)(bits() % 7 ? bits() : bits() % 3);
        }
        const build_shape_data shape = {40,
                                        (int8_t)((int)(bits() % 29) - 8),
                                        WG_ABSENT,
                                        {(int32_t)(bits() << 5 & 0xfffffffu), 0, 0},
                                        rest};
        build_shape(&b, &shape);
    }
    for (unsigned i = 0; i < 3; i++) {
        for (unsigned k = 0; k < 3 * 60; k++) {
            corners[k] = (uint16_t)(bits() % 40);
        }
        const build_part_data part = {(uint16_t)(bits() % 3),
                                      (uint16_t)(bits() % 2 ? 2 : WG_ABSENT),
                                      60,
                                      (uint8_t)(bits() % 2),
                                      {1, 2, 3},
                                      corners};
        build_part(&b, &part);
    }
    build_view(&b, (uint8_t)(bits() % 2), (uint8_t)(bits() % 3), channels);
    uint8_t *clip = build_finish(&b, size);
    uint8_t *view = clip + build_where(clip, WG_SECTION_VIEWS, 0);
    for (unsigned i = WG_VIEW_AMBIENT; i < WG_VIEW_CHANNEL; i++) {
        view[i] = (uint8_t)bits();
    }
    build_seal(clip, *size);
    return clip;
}

static int32_t any_value(void)
{
    uint32_t raw = bits() << 8 ^ bits();
    return (int32_t)(bits() % 4 ? raw : raw >> bits() % 32);
}

static void no_clip_and_no_value_breaks_anything(void)
{
    static const uint8_t ALL = 40 * 3;
    for (unsigned n = 0; n < 600; n++) {
        uint32_t size;
        pc_scene s;
        const wg_size picture = {(uint16_t)(1 + bits() % 40), (uint16_t)(1 + bits() % 40)};
        s.clip = hostile_clip(&size);
        CHECK_EQ(wg_open(&s.file, s.clip, size), 0);
        CHECK_EQ(wg_open_shapes(&s.file), 0);
        s.vertices = malloc(ALL * sizeof *s.vertices);
        s.shades = malloc(ALL);
        s.normals = malloc(3u * ALL * sizeof *s.normals);
        s.pixels = malloc((size_t)picture.width * picture.height * sizeof *s.pixels);
        wg_picture_memory memory = {s.vertices, bits() % 2 ? s.shades : NULL,
                                    bits() % 2 ? s.normals : NULL, s.weights};
        wg_picture_init(&s.picture, &s.file, picture, &memory);
        for (unsigned frame = 0; frame < 3; frame++) {
            wg_rect band = {0, 0, picture.width, 1};
            uint32_t *row = malloc(picture.width * sizeof *row);
            for (unsigned i = 0; i < WG_VIEW_CHANNELS; i++) {
                s.values[i] = any_value();
            }
            wg_picture_set(&s.picture, s.values);
            pc_draw(&s);
            for (; band.y0 < picture.height; band.y0++) {
                band.y1 = (uint16_t)(band.y0 + 1);
                wg_picture_band(&s.picture, band, row);
                CHECK(memcmp(row, s.pixels + (uint32_t)band.y0 * picture.width,
                             picture.width * sizeof *row) == 0);
            }
            free(row);
            for (uint32_t p = 0; p < (uint32_t)picture.width * picture.height; p++) {
                CHECK(WG_PIXEL_PART(s.pixels[p]) <= 3);
                CHECK(s.pixels[p] == 0 || WG_PIXEL_NEAR(s.pixels[p]) > 0);
            }
        }
        pc_close(&s);
    }
}

int main(void)
{
    TEST(inside_a_room_every_pixel_is_a_wall);
    TEST(lines_are_drawn_where_edges_are_seen);
    TEST(a_lone_triangle_keeps_its_edges);
    TEST(a_cut_wall_has_one_brightness);
    TEST(cut_neighbours_leave_no_crack);
    TEST(huge_triangles_are_drawn_right);
    TEST(cut_corners_pass_their_brightness_on);
    TEST(nothing_is_seen_nearer_than_a_sixteenth);
    TEST(no_clip_and_no_value_breaks_anything);
    return check_done();
}
