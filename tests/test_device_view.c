/* Camera, projection, light and recomputed normals against double precision.
 * SPDX-License-Identifier: MIT */
#include "draw.h"
#include "normals.h"
#include "picture_model.h"

static pc_mesh mesh;
static pc_scene scene;
static pm_model model;
static uint32_t seed = 3;

static double dice(double low, double high)
{
    seed = seed * 1664525u + 1013904223u;
    return low + (high - low) * (seed >> 8) / 16777216.0;
}

/* One triangle is enough for a clip; its view is what counts. */
static void open_view(uint8_t projection, wg_size size)
{
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    pc_triangle(&mesh, pc_vertex(&mesh, 0, 0, 0), pc_vertex(&mesh, 1, 0, 0),
                pc_vertex(&mesh, 0, 1, 0));
    pc_open(&scene, &mesh, projection, WG_SHADING_FLAT, size);
}

static pc_camera any_camera(void)
{
    pc_camera c = {dice(-400, 400), dice(-400, 400),
                   dice(-400, 400), {dice(-300, 300), dice(-300, 300), dice(-300, 300)},
                   exp(dice(0, 9)), 0};
    c.size = c.distance * exp(dice(-4, 1));
    return c;
}

/* The phase is off by 2^-19 turns and the sine by 2^-20, 1.4e-5 together; three such angles. */
static void the_camera_is_turned_and_placed_right(void)
{
    const wg_size size = {128, 64};
    open_view(WG_PERSPECTIVE, size);
    for (unsigned n = 0; n < 500; n++) {
        pc_camera c = any_camera();
        pc_look(&scene, &c);
        pm_make(&model, &mesh, &scene, 0);
        const wg_rigid *camera = &scene.picture.view.camera;
        for (unsigned i = 0; i < 9; i++) {
            CHECK_NEAR(ldexp(camera->turn_q30[i], -30), model.turn[i / 3][i % 3], 4.2e-5);
        }
        for (unsigned i = 0; i < 3; i++) { /* exactly as stored */
            CHECK_NEAR(ldexp(camera->centre[i], -camera->centre_frac),
                       ldexp(scene.values[3 + i], -PC_LENGTH), 0);
            CHECK(camera->centre[i] < WG_FAR && camera->centre[i] > -WG_FAR);
        }
    }
    pc_close(&scene);
}

/* Posed coordinates go straight in. A seen vertex is off by 1/32 pixel, for the three reciprocals by 3
 * 2^-15 of its way from the middle, by a fine unit (2^-24 of the distance) of x, and by half of
 * one and 2^-15 of ... depth's own. Depth: half a step. */
static void check_vertex(const wg_vertex *v, const double *q, wg_size size)
{
    double x, y, depth = pm_project(&model, q, &x, &y);
    double off = hypot(x - size.width / 2.0, y - size.height / 2.0);
    double fine = ldexp(model.distance, -24) * size.height / model.size *
                  (model.flat ? 1 : model.distance / depth);
    double tolerance = 1.0 / 32 + off * 3 / 32768 + fine + 1e-9;
    double steps = depth / model.distance * scene.picture.view.distance / 4096;
    CHECK_NEAR(v->x / 16.0, x, tolerance);
    CHECK_NEAR(v->y / 16.0, y, tolerance);
    CHECK_NEAR(v->z, fmin(32767, steps), 0.51);
}

/* One outside is kept within a unit of 8^e/128 pixel and 8^e/4 steps, cut down, where e is no larger
 * than it must be; 2^-14 for the scale. Unless it had to be moved towards the eye. */
static void check_outside(const wg_vertex *v, const double *q)
{
    int32_t at[3];
    double unit = ldexp(1, 3 * (v->z >> 13 & 3)), depth = model.distance - q[2];
    double scale = model.height / model.size * 128;
    double steps = depth / model.distance * scene.picture.view.distance / 1024;
    wg_view_spot(&scene.picture.view, v, at);
    double most = fmax(fabs(q[0]), fmax(fabs(q[1]), fabs(q[2]))) / model.distance;
    if (most < 16 && fabs(scale * q[0]) < 1 << 23 && fabs(scale * q[1]) < 1 << 23 &&
        fabs(steps) < 1 << 20) {
        CHECK_NEAR(at[0], scale * q[0], 1 + unit + fabs(scale * q[0]) / 16384);
        CHECK_NEAR(at[1], scale * q[1], 1 + unit + fabs(scale * q[1]) / 16384);
        CHECK_NEAR(at[2], steps, 1 + unit);
        CHECK(unit < 2 || fabs(scale * q[0]) > unit * 4000 || fabs(scale * q[1]) > unit * 4000 ||
              fabs(steps) > unit * 500);
    } else if (hypot(at[0], at[1]) > 200 * 512) { /* still on its ray, in units of 512 */
        CHECK_NEAR(remainder(atan2(at[1], at[0]) - atan2(q[1], q[0]), 8 * atan(1)), 0, 0.01);
    }
}

static void vertices_are_seen_where_the_format_says(void)
{
    unsigned seen = 0, outside = 0;
    for (unsigned n = 0; n < 4000; n++) {
        const wg_size size = {(uint16_t)dice(16, 400), (uint16_t)dice(16, 400)};
        uint8_t projection = n & 1u;
        open_view(projection, size);
        pc_camera c = any_camera();
        pc_look(&scene, &c);
        pm_make(&model, &mesh, &scene, projection == WG_ORTHOGRAPHIC);
        int8_t frac = (int8_t)dice(0, 12);
        for (unsigned i = 0; i < 8; i++) {
            int32_t xyz[3];
            double q[3], reach = model.distance * exp(dice(-6, i == 7 ? 6 : 1)), x, y;
            wg_vertex v;
            for (unsigned k = 0; k < 3; k++) {
                double raw = fmax(-1e9, fmin(1e9, ldexp(dice(-reach, reach), frac + 8)));
                xyz[k] = (int32_t)raw;
                q[k] = ldexp(xyz[k], -frac - 8);
            }
            if (i == 6) { /* about the nearest depth there is */
                xyz[2] = (int32_t)ldexp(model.distance * dice(0.9, 1), frac + 8);
                q[2] = ldexp(xyz[2], -frac - 8);
            }
            wg_view_project(&scene.picture.view, frac, xyz, 1, &v);
            double depth = pm_project(&model, q, &x, &y);
            double off = fmax(fabs(x - size.width / 2.0), fabs(y - size.height / 2.0));
            if (depth > model.distance / 15.99 && off < 450) {
                CHECK(v.z < 0x8000u);
            }
            if (v.z < 0x8000u) {
                CHECK(depth > model.distance / 16.01);
                check_vertex(&v, q, size);
                seen++;
            } else {
                CHECK(depth < model.distance / 15.99 || off > 450);
                check_outside(&v, q);
                outside++;
            }
        }
        pc_close(&scene);
    }
    CHECK(seen > 5000 && outside > 5000);
}

/* 1 for rounding, 1/4 for 14 bits of a normal and the reciprocal of its length. */
static void brightness_follows_the_cosine(void)
{
    wg_view view = {.ambient = 0};
    for (unsigned n = 0; n < 20000; n++) {
        double size = exp(dice(0, 21)), normal[3], length = 0;
        int32_t raw[3];
        uint8_t shade;
        view.ambient = (uint8_t)dice(0, 256);
        for (unsigned i = 0; i < 3; i++) {
            normal[i] = dice(-1, 1);
            length += normal[i] * normal[i];
        }
        for (unsigned i = 0; i < 3; i++) {
            view.light[i] = (int8_t)lrint(127 * normal[i] / sqrt(length) * dice(0.9, 1));
            raw[i] = (int32_t)(dice(-1, 1) * size);
            normal[i] = raw[i];
        }
        if (raw[0] == 0 && raw[1] == 0 && raw[2] == 0) {
            normal[2] = 1; /* towards the viewer */
        }
        wg_view_light(&view, raw, 1, &shade);
        CHECK_NEAR(shade, pm_shade(&view, normal), 0.5 + 0.25);
    }
}

/* ---- normals --------------------------------------------------------------------------------- */

/* The sum of the exact normals around each vertex of a torus, weighted by area. */
static void model_normals(double (*sum)[3])
{
    memset(sum, 0, PC_VERTICES * sizeof *sum);
    for (unsigned i = 0; i < mesh.triangles; i++) {
        double normal[3];
        pm_normal(&model, i, normal);
        for (unsigned k = 0; k < 9; k++) {
            sum[mesh.corner[i][k / 3]][k % 3] += normal[k % 3];
        }
    }
}

static double angle(const double *a, const double *b)
{
    double c[3];
    pm_cross(a, b, c);
    return atan2(sqrt(pm_dot(c, c)), pm_dot(a, b));
}

/* The height of the lowest triangle, and the area of the smallest over that of the largest. */
static double lowest_triangle(double *least)
{
    double low = HUGE_VAL, small = HUGE_VAL, large = 0;
    for (unsigned i = 0; i < mesh.triangles; i++) {
        double normal[3], side = 0;
        pm_normal(&model, i, normal);
        double area = sqrt(pm_dot(normal, normal));
        for (unsigned k = 0; k < 3; k++) {
            double edge[3];
            pm_minus(model.at[mesh.corner[i][k]], model.at[mesh.corner[i][(k + 1) % 3]], edge);
            side = fmax(side, sqrt(pm_dot(edge, edge)));
        }
        low = fmin(low, area / side);
        small = fmin(small, area);
        large = fmax(large, area);
    }
    *least = small / large;
    return low;
}

/* Each corner of the triangles around a vertex is off by 1/25 pixel across and 3/4 of a step (1/4096
 * of the distance) in depth, `off` in all, so each normal is tilted by less than 2 sqrt(2) off over
 * the triangle's height, and so is their sum. It is summed in whole numbers, where the largest
 * triangle has `room` or more: 2^14 over the next power of two of the triangles around a vertex. The
 * smallest has `least` of its area; each is half a unit off, which is as much of the sum. */
static void compare_normals(wg_size size, double shown, double room)
{
    static double sum[PC_VERTICES][3];
    for (uint8_t projection = 0; projection < 2; projection++) {
        pc_open(&scene, &mesh, projection, WG_SHADING_SMOOTH, size);
        for (unsigned n = 0; n < 10; n++) {
            pc_camera c = {dice(-180, 180), dice(-90, 90), 0, {0, 0, 0}, dice(150, 300), shown};
            pc_look(&scene, &c);
            pm_make(&model, &mesh, &scene, projection == WG_ORTHOGRAPHIC);
            double least, height = lowest_triangle(&least);
            model_normals(sum);
            double off = hypot(1.3 * shown / size.height / 25 * 1.4, 0.75 * c.distance / 4096);
            for (unsigned i = 0; i < mesh.vertices; i++) {
                const int16_t *raw = scene.normals + 3 * i;
                double got[3] = {raw[0], raw[1], raw[2]};
                CHECK(angle(got, sum[i]) <
                      2 * sqrt(2) * off / height + sqrt(3) / 2 / (room * least));
            }
        }
        pc_close(&scene);
    }
}

/* The second one is shown so large that its edges do not fit in 15 bits; in the third, 31 triangles
 * around a vertex add up in one direction. */
static void recomputed_normals_are_those_of_the_mesh(void)
{
    const wg_size size = {128, 128}, large = {400, 400};
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    pc_torus(&mesh, 24, 12, 30, 12);
    mesh.part[mesh.parts++] = 100; /* a seam between two parts does not show */
    compare_normals(size, 100, 2048);
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    pc_torus(&mesh, 6, 5, 30, 12);
    compare_normals(large, 45, 2048);
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    unsigned middle = pc_vertex(&mesh, 0, 0, 0);
    for (unsigned i = 0; i < 31; i++) {
        double a = 8 * atan(1) * i / 31;
        pc_triangle(&mesh, middle, middle + 1 + i, middle + 1 + (i + 1) % 31);
        pc_vertex(&mesh, 80 * cos(a), 80 * sin(a), 0);
    }
    compare_normals(large, 200, 512);
}

/* The vertices' directions stand in for normals. Entries of the turned matrix have 14 bits; 2. */
static void fixed_normals_turn_with_the_view(void)
{
    const wg_size size = {64, 64};
    memset(&mesh, 0, sizeof mesh);
    mesh.fixed = 1;
    pc_part(&mesh);
    pc_torus(&mesh, 24, 12, 30, 12);
    pc_open(&scene, &mesh, WG_PERSPECTIVE, WG_SHADING_SMOOTH, size);
    uint8_t *view = scene.clip + build_where(scene.clip, WG_SECTION_VIEWS, 0);
    view[WG_VIEW_LIGHT] = 60;
    view[WG_VIEW_LIGHT + 1] = 80;
    view[WG_VIEW_LIGHT + 2] = 78;
    for (unsigned n = 0; n < 20; n++) {
        pc_camera c = any_camera();
        pc_look(&scene, &c);
        pm_make(&model, &mesh, &scene, 0);
        for (unsigned i = 0; i < mesh.vertices; i++) {
            double normal[3];
            for (unsigned k = 0; k < 3; k++) {
                normal[k] = pm_dot(model.turn[k], mesh.at[i]);
            }
            CHECK_NEAR(scene.shades[i], pm_shade(&scene.picture.view, normal), 2);
        }
    }
    pc_close(&scene);
}

/* Every second frame shades stay what they were; without memory the picture is flat. */
static void shades_can_be_renewed_less_often(void)
{
    const wg_size size = {64, 64};
    const pc_camera a = {0, 0, 0, {0, 0, 0}, 200, 100}, b = {50, 40, 0, {0, 0, 0}, 200, 100};
    uint8_t before[PC_VERTICES];
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    pc_torus(&mesh, 24, 12, 30, 12);
    pc_open(&scene, &mesh, WG_PERSPECTIVE, WG_SHADING_SMOOTH, size);
    scene.picture.normals_every = 2;
    pc_look(&scene, &a);
    memcpy(before, scene.shades, mesh.vertices);
    pc_look(&scene, &b);
    CHECK(memcmp(before, scene.shades, mesh.vertices) == 0);
    pc_look(&scene, &b);
    CHECK(memcmp(before, scene.shades, mesh.vertices) != 0);
    pc_draw(&scene);
    uint32_t *smooth = malloc(64 * 64 * sizeof *smooth);
    memcpy(smooth, scene.pixels, 64 * 64 * sizeof *smooth);
    scene.picture.memory.normals = NULL;
    scene.picture.normals_every = 1;
    pc_look(&scene, &b);
    pc_draw(&scene);
    CHECK(memcmp(smooth, scene.pixels, 64 * 64 * sizeof *smooth) != 0);
    memcpy(smooth, scene.pixels, 64 * 64 * sizeof *smooth);
    scene.picture.shading = WG_SHADING_FLAT;
    pc_draw(&scene);
    CHECK(memcmp(smooth, scene.pixels, 64 * 64 * sizeof *smooth) == 0);
    free(smooth);
    pc_close(&scene);
}

int main(void)
{
    TEST(the_camera_is_turned_and_placed_right);
    TEST(vertices_are_seen_where_the_format_says);
    TEST(brightness_follows_the_cosine);
    TEST(recomputed_normals_are_those_of_the_mesh);
    TEST(fixed_normals_turn_with_the_view);
    TEST(shades_can_be_renewed_less_often);
    return check_done();
}
