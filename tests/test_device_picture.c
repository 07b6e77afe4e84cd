/* Whole pictures against rays in double precision.
 * SPDX-License-Identifier: MIT */
#include "picture_model.h"

#define SIDE 96

static pc_mesh mesh;
static pc_scene scene;
static pm_model model;
static uint32_t seed = 7;

static double dice(double low, double high)
{
    seed = seed * 1664525u + 1013904223u;
    return low + (high - low) * (seed >> 8) / 16777216.0;
}

/* A torus in parts of ten triangles, so that a part says where one looks at. */
static void make_torus(void)
{
    memset(&mesh, 0, sizeof mesh);
    pc_torus(&mesh, 24, 12, 30, 12);
    for (unsigned i = 0; i < mesh.triangles; i += 10) {
        mesh.part[mesh.parts++] = i;
    }
}

static void open_scene(uint8_t projection, uint8_t shading)
{
    const wg_size size = {SIDE, SIDE};
    pc_open(&scene, &mesh, projection, shading, size);
}

/* How far a projected vertex may be off, in pixels: half of 1/16; its way from the middle, 3/4 SIDE at
 * most, times 3 2^-15 for the three reciprocals of scale and depth and 2^-13 for what posing leaves:
 * entries within 2^-15 of three coordinates, each below the distance / 4, and 2^-8 raw twice. */
#define VERTEX_ERROR (1.0 / 32 + 0.75 * SIDE * (3.0 / 32768 + 1.0 / 8192))

/* How much deeper or nearer a pixel may be than the ray finds its triangle: vertices by half a step
 * (at most distance / 4096) and by their error across; its nearness by 4 of 65535 (see
 * test_device_raster.c). */
static double depth_error(unsigned triangle, double x, double y)
{
    double d = pm_depth(&model, triangle, x, y), slope = 0;
    for (int i = 0; i < 4; i++) {
        double way = i & 2 ? 0.5 : -0.5;
        double there = pm_depth(&model, triangle, x + (i & 1 ? way : 0), y + (i & 1 ? 0 : way));
        slope = fmax(slope, 2 * fabs(there - d));
    }
    double unit = model.flat ? model.distance / 8192 : d * d * 16 / 65280 / model.distance;
    return 0.5 * model.distance / 4096 + slope * 1.5 * VERTEX_ERROR + 4 * unit;
}

static double steps(double depth)
{
    return depth / model.distance * scene.picture.view.distance / 4096;
}

static double nearness(double depth)
{
    return model.flat ? 65535 - 2 * steps(depth) : scene.picture.view.nearness / steps(depth);
}

/* Brightness of a flat face: its corners are off by VERTEX_ERROR pixels across and half a step (and
 * posing) in depth, in all `off` units of length; over the triangle's height h that tilts it by less
 * than 2 off/h about either of two axes. One for rounding. */
static double shade_error(unsigned triangle)
{
    const uint16_t *c = mesh.corner[triangle];
    double normal[3], side = 0, pixel = model.size / model.height;
    pm_normal(&model, triangle, normal);
    for (unsigned i = 0; i < 3; i++) {
        double edge[3];
        pm_minus(model.at[c[i]], model.at[c[(i + 1) % 3]], edge);
        side = fmax(side, sqrt(pm_dot(edge, edge)));
    }
    double off = hypot(1.5 * VERTEX_ERROR * pixel * 1.2, 0.75 * model.distance / 4096);
    double h = sqrt(pm_dot(normal, normal)) / side;
    return (255 - scene.picture.view.ambient) * 2 * sqrt(2) * off / h + 1;
}

/* Towards the viewer, also from behind. */
static void seen_normal(unsigned triangle, double x, double y, double *normal)
{
    double eye[3], way[3];
    pm_ray(&model, x, y, eye, way);
    pm_normal(&model, triangle, normal);
    double side = pm_dot(normal, way) > 0 ? -1 : 1;
    for (unsigned i = 0; i < 3; i++) {
        normal[i] *= side;
    }
}

/* Returns how many pixels could be compared. */
static unsigned compare_pixels(const uint32_t *pixels, const uint8_t *marked, int shades)
{
    unsigned compared = 0;
    for (int p = 0; p < SIDE * SIDE; p++) {
        double x = p % SIDE + 0.5, y = p / SIDE + 0.5, normal[3];
        pm_hit hit = pm_look(&model, x, y);
        if (marked[p]) {
            continue;
        }
        if (hit.triangle < 0) {
            CHECK_EQ(pixels[p], 0);
            compared++;
            continue;
        }
        unsigned t = (unsigned)hit.triangle;
        double off = depth_error(t, x, y);
        if (hit.behind - hit.depth < 4 * off) {
            continue; /* two parts too close to each other */
        }
        CHECK_EQ(WG_PIXEL_PART(pixels[p]), pm_part(&mesh, t) + 1);
        CHECK_NEAR(WG_PIXEL_NEAR(pixels[p]), nearness(hit.depth),
                   fabs(nearness(hit.depth - off) - nearness(hit.depth)) + 1);
        if (shades) {
            seen_normal(t, x, y, normal);
            CHECK_NEAR(WG_PIXEL_SHADE(pixels[p]), pm_shade(&scene.picture.view, normal),
                       shade_error(t));
        }
        compared++;
    }
    return compared;
}

static void compare_view(const pc_camera *camera, uint8_t projection)
{
    uint8_t marked[SIDE * SIDE];
    pc_look(&scene, camera);
    scene.picture.view.light[0] = 60;
    scene.picture.view.light[1] = 80;
    scene.picture.view.light[2] = 78;
    pm_make(&model, &mesh, &scene, projection == WG_ORTHOGRAPHIC);
    pm_mark_edges(&model, VERTEX_ERROR, marked);
    CHECK(compare_pixels(pc_draw(&scene), marked, 1) > SIDE * SIDE / 2);
}

static void compare_views(uint8_t projection)
{
    make_torus();
    open_scene(projection, WG_SHADING_FLAT);
    for (unsigned i = 0; i < 4; i++) {
        pc_camera c = {dice(-180, 180), dice(-90, 90), dice(-40, 40), {dice(-9, 9), dice(-9, 9), 0},
                       dice(170, 400),  dice(70, 120)};
        compare_view(&c, projection);
    }
    pc_close(&scene);
}

static void perspective_shows_what_rays_find(void)
{
    compare_views(WG_PERSPECTIVE);
}

static void orthographic_shows_what_rays_find(void)
{
    compare_views(WG_ORTHOGRAPHIC);
}

/* An open surface: from some sides its back is seen, lit as if it were a front. */
static void both_sides_are_lit_when_both_are_seen(void)
{
    make_torus();
    mesh.triangles /= 2;
    mesh.sides = 1;
    for (mesh.parts = 0; 10 * mesh.parts < mesh.triangles; mesh.parts++) {
    }
    open_scene(WG_PERSPECTIVE, WG_SHADING_FLAT);
    for (unsigned i = 0; i < 3; i++) {
        const pc_camera c = {150.0 * i, 20, 0, {0, 0, 0}, 300, 100};
        compare_view(&c, WG_PERSPECTIVE);
    }
    pc_close(&scene);
}

/* Brightness of a smooth face at a place of the picture, and how much it changes in a pixel. */
static double model_smooth(unsigned triangle, double x, double y, double *change)
{
    const uint16_t *c = mesh.corner[triangle];
    double px[3], py[3], s[3], area, v, w;
    for (unsigned i = 0; i < 3; i++) {
        pm_project(&model, model.at[c[i]], &px[i], &py[i]);
        s[i] = scene.shades[c[i]];
    }
    area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0]);
    v = ((x - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (y - py[0])) / area;
    w = ((px[1] - px[0]) * (y - py[0]) - (x - px[0]) * (py[1] - py[0])) / area;
    *change = hypot(((s[1] - s[0]) * (py[2] - py[0]) - (s[2] - s[0]) * (py[1] - py[0])) / area,
                    ((s[2] - s[0]) * (px[1] - px[0]) - (s[1] - s[0]) * (px[2] - px[0])) / area);
    return s[0] + v * (s[1] - s[0]) + w * (s[2] - s[0]);
}

/* Corners off by VERTEX_ERROR shift the slope as far; a slope on a triangle that is nearly an edge is
 * left out by the marks around edges. One and a bit for cutting (test_device_raster.c). */
static void smooth_faces_run_from_corner_to_corner(void)
{
    uint8_t marked[SIDE * SIDE];
    unsigned compared = 0;
    make_torus();
    open_scene(WG_PERSPECTIVE, WG_SHADING_SMOOTH);
    uint8_t *view = scene.clip + build_where(scene.clip, WG_SECTION_VIEWS, 0);
    view[WG_VIEW_LIGHT] = 90;
    view[WG_VIEW_LIGHT + 2] = 90;
    const pc_camera c = {30, 35, 0, {0, 0, 0}, 250, 90};
    pc_look(&scene, &c);
    pm_make(&model, &mesh, &scene, 0);
    pm_mark_edges(&model, 2 * VERTEX_ERROR, marked);
    const uint32_t *pixels = pc_draw(&scene);
    for (int p = 0; p < SIDE * SIDE; p++) {
        double x = p % SIDE + 0.5, y = p / SIDE + 0.5, change;
        pm_hit hit = pm_look(&model, x, y);
        if (marked[p] || hit.triangle < 0 ||
            hit.behind - hit.depth < 4 * depth_error((unsigned)hit.triangle, x, y)) {
            continue;
        }
        double want = model_smooth((unsigned)hit.triangle, x, y, &change);
        CHECK_NEAR(WG_PIXEL_SHADE(pixels[p]), want, 1.1 + 4 * VERTEX_ERROR * change);
        compared++;
    }
    CHECK(compared > 1500);
    pc_close(&scene);
}

/* ---- the same picture, asked for in other ways ----------------------------------------------- */

static void check_rectangle(const uint32_t *all, wg_rect r)
{
    uint32_t count = (uint32_t)(r.x1 - r.x0) * (uint32_t)(r.y1 - r.y0), wrong = 0;
    uint32_t *part = malloc(count * sizeof *part); /* exactly: a write outside is caught */
    wg_picture_band(&scene.picture, r, part);
    for (uint16_t y = r.y0; y < r.y1; y++) {
        wrong += memcmp(part + (y - r.y0) * (r.x1 - r.x0), all + y * SIDE + r.x0,
                        (size_t)(r.x1 - r.x0) * sizeof *all) != 0;
    }
    CHECK_EQ(wrong, 0);
    free(part);
}

static const pc_camera SOMEWHERE = {30, 25, 5, {3, 2, 1}, 200, 90};
static const pc_camera INSIDE = {70, 10, 0, {28, 0, 0}, 12, 14}; /* in the tube: all is cut */

static void bands_of_any_height_make_one_picture(void)
{
    for (uint8_t shading = 0; shading < 6; shading++) {
        make_torus();
        open_scene(WG_PERSPECTIVE, shading % 3);
        scene.picture.bases = 0;
        pc_look(&scene, shading < 3 ? &SOMEWHERE : &INSIDE);
        const uint32_t *all = pc_draw(&scene);
        for (uint16_t rows = 1; rows <= SIDE; rows = (uint16_t)(rows + 1 + rows / 8)) {
            for (uint16_t y = 0; y < SIDE; y = (uint16_t)(y + rows)) {
                wg_rect r = {0, y, SIDE, (uint16_t)(y + rows < SIDE ? y + rows : SIDE)};
                check_rectangle(all, r);
            }
        }
        for (unsigned i = 0; i < 100; i++) {
            uint16_t x = (uint16_t)dice(0, SIDE), y = (uint16_t)dice(0, SIDE);
            wg_rect r = {x, y, (uint16_t)(x + 1 + dice(0, SIDE - x)),
                         (uint16_t)(y + 1 + dice(0, SIDE - y))};
            check_rectangle(all, r);
        }
        pc_close(&scene);
    }
}

/* Any order of the triangles: reversed inside their parts. The normals are sums, so they stay too. */
static void the_order_of_triangles_does_not_matter(void)
{
    for (uint8_t shading = 0; shading < 6; shading++) {
        uint32_t first[SIDE * SIDE];
        make_torus();
        open_scene(WG_PERSPECTIVE, shading % 3);
        pc_look(&scene, shading < 3 ? &SOMEWHERE : &INSIDE);
        memcpy(first, pc_draw(&scene), sizeof first);
        pc_close(&scene);
        for (unsigned i = 0; i < mesh.parts; i++) {
            for (unsigned a = mesh.part[i], b = mesh.part[i + 1] - 1; a < b; a++, b--) {
                uint16_t swap[3];
                memcpy(swap, mesh.corner[a], sizeof swap);
                memcpy(mesh.corner[a], mesh.corner[b], sizeof swap);
                memcpy(mesh.corner[b], swap, sizeof swap);
            }
        }
        open_scene(WG_PERSPECTIVE, shading % 3);
        pc_look(&scene, shading < 3 ? &SOMEWHERE : &INSIDE);
        CHECK(memcmp(first, pc_draw(&scene), sizeof first) == 0);
        pc_close(&scene);
    }
}

/* ---- dirty rectangles ------------------------------------------------------------------------ */

static int is_whole(wg_rect r)
{
    return r.x0 == 0 && r.y0 == 0 && r.x1 == SIDE && r.y1 == SIDE;
}

static void check_outside(wg_rect r, const uint32_t *before, const uint32_t *after)
{
    unsigned wrong = 0;
    for (int p = 0; p < SIDE * SIDE; p++) {
        int in = p % SIDE >= r.x0 && p % SIDE < r.x1 && p / SIDE >= r.y0 && p / SIDE < r.y1;
        wrong += !in && (before[p] != 0 || after[p] != 0);
    }
    CHECK_EQ(wrong, 0);
}

static void nothing_changes_outside_the_dirty_rectangle(void)
{
    const wg_size none = {1, 1}, grid = {8, 4};
    static uint32_t before[SIDE * SIDE];
    unsigned parts = 0;
    make_torus();
    open_scene(WG_PERSPECTIVE, WG_SHADING_WIRE);
    CHECK(is_whole(wg_picture_dirty(&scene.picture, none)));
    for (unsigned i = 0; i < 20; i++) {
        pc_camera c = {dice(0, 90), dice(-40, 40), 0, {dice(-90, 90), dice(-90, 90), 0}, 300, 150};
        pc_look(&scene, &c);
        pc_draw(&scene);
        wg_rect r = wg_picture_dirty(&scene.picture, none);
        wg_rect g = wg_picture_dirty(&scene.picture, grid);
        if (i == 0) {
            CHECK(is_whole(r));
        } else {
            check_outside(r, before, scene.pixels);
            CHECK(g.x0 == r.x0 / 8 * 8 && g.y0 == r.y0 / 4 * 4);
            CHECK(g.x1 == (r.x1 + 7) / 8 * 8 && g.y1 == (r.y1 + 3) / 4 * 4);
            parts += !is_whole(r);
        }
        memcpy(before, scene.pixels, sizeof before);
    }
    CHECK(parts > 10);
    wg_picture_look(&scene.picture, 0);
    CHECK(is_whole(wg_picture_dirty(&scene.picture, none)));
    pc_look(&scene, &SOMEWHERE);
    CHECK(is_whole(wg_picture_dirty(&scene.picture, none)));
    const pc_camera away = {0, 0, 0, {900, 0, 0}, 300, 200};
    pc_look(&scene, &away);
    pc_look(&scene, &away);
    wg_rect r = wg_picture_dirty(&scene.picture, none);
    CHECK(r.x0 == r.x1);
    pc_look(&scene, &INSIDE); /* vertices outside: their triangles may be anywhere */
    CHECK(is_whole(wg_picture_dirty(&scene.picture, none)));
    pc_close(&scene);
}

int main(void)
{
    TEST(perspective_shows_what_rays_find);
    TEST(orthographic_shows_what_rays_find);
    TEST(both_sides_are_lit_when_both_are_seen);
    TEST(smooth_faces_run_from_corner_to_corner);
    TEST(bands_of_any_height_make_one_picture);
    TEST(the_order_of_triangles_does_not_matter);
    TEST(nothing_changes_outside_the_dirty_rectangle);
    return check_done();
}
