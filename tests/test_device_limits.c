/* What happens at the limits of the raster's numbers: the nearest plane, the largest picture.
 * SPDX-License-Identifier: MIT */
#include "draw.h"
#include "picture_clip.h"
#include "pixels.h"

#define SIDE  96
#define STEPS 256 /* of the nearest plane when the distance is 2^24 fine units */

static pc_mesh mesh;
static pc_scene scene;

/* ---- the nearest plane ----------------------------------------------------------------------- */

/* A corner away from the viewer and two on the nearest plane, as cutting leaves them: each has a pixel
 * so close to the edge between these that its slope, off by 2^-15, leads beyond the nearest plane. */
static const struct {
    int x[3], y[3];
    unsigned z;
} NEAREST[] = {{{-567, 118, 563}, {1937, 535, 1235}, 8214},
               {{111, 236, 1493}, {-540, 1709, -380}, 10514},
               {{2098, -455, 966}, {1081, -541, 2171}, 12346},
               {{4001, 219, 1133}, {-3388, 1334, -2194}, 3011},
               {{-3682, 2231, -320}, {269, -1043, 2517}, 30114},
               {{-237, 1216, 1464}, {1845, -731, 1777}, 20528},
               {{-11148, 1833, -2193}, {-3635, -93, 4050}, 13728}};

static double plane_at(const wg_vertex *v, const double *value, double x, double y)
{
    double ux = (v[1].x - v[0].x) / 16.0, uy = (v[1].y - v[0].y) / 16.0;
    double wx = (v[2].x - v[0].x) / 16.0, wy = (v[2].y - v[0].y) / 16.0;
    double area = ux * wy - wx * uy, px = x - v[0].x / 16.0, py = y - v[0].y / 16.0;
    return value[0] + (px * wy - wx * py) / area * (value[1] - value[0]) +
           (ux * py - px * uy) / area * (value[2] - value[0]);
}

/* Nearness is off by 2^-14.9 of a difference below 65536, by 2^-15 a pixel on the way, which has less
 * than 1000, and by what is cut: 2.2 + 0.04 + 1. */
static void nothing_wraps_at_the_nearest_plane(void)
{
    static uint32_t pixels[SIDE * SIDE];
    const wg_size size = {SIDE, SIDE};
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    pc_triangle(&mesh, pc_vertex(&mesh, 0, 0, 0), pc_vertex(&mesh, 1, 0, 0),
                pc_vertex(&mesh, 0, 1, 0));
    pc_open(&scene, &mesh, WG_PERSPECTIVE, WG_SHADING_FLAT, size);
    const pc_camera camera = {0, 0, 0, {0, 0, 0}, 256, 100};
    pc_look(&scene, &camera);
    CHECK_EQ(scene.picture.view.distance, 1 << 24);
    for (unsigned n = 0; n < sizeof NEAREST / sizeof *NEAREST; n++) {
        const wg_canvas canvas = {
            &scene.picture.view, pixels, {0, 0, SIDE, SIDE}, WG_SHADING_SMOOTH, 1, 1, NULL};
        wg_triangle t = {{NULL, NULL, NULL}, NULL, {200, 200, 200}, 0, {{0}}};
        wg_vertex corner[3];
        double near[3];
        for (unsigned i = 0; i < 3; i++) {
            corner[i].x = (int16_t)NEAREST[n].x[i];
            corner[i].y = (int16_t)NEAREST[n].y[i];
            corner[i].z = (uint16_t)(i == 0 ? NEAREST[n].z : STEPS);
            near[i] = (double)scene.picture.view.nearness / corner[i].z;
            t.at[i] = &corner[i];
        }
        memset(pixels, 0, sizeof pixels);
        wg_draw_triangle(&canvas, &t);
        unsigned seen = 0;
        for (int p = 0; p < SIDE * SIDE; p++) {
            if (pixels[p] != 0) {
                double want = plane_at(corner, near, p % SIDE + 0.5, p / SIDE + 0.5);
                CHECK_NEAR(WG_PIXEL_NEAR(pixels[p]), want, 3.24);
                seen++;
            }
        }
        CHECK(seen > 100);
    }
    pc_close(&scene);
}

/* A target so far to the side that depth is counted in steps of 2^18 fine units, of which the nearest
 * plane has 4.4; a picture so high that the vertices are in reach; and vertices 4 of them away. */
static void nothing_projected_is_nearer_than_the_nearest_plane(void)
{
    const wg_size size = {SIDE, SIDE};
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    pc_triangle(&mesh, pc_vertex(&mesh, 0, 0, 1 / 128.0), pc_vertex(&mesh, -99, 0, 1 / 128.0),
                pc_vertex(&mesh, 0, 99, 1 / 128.0));
    pc_open(&scene, &mesh, WG_PERSPECTIVE, WG_SHADING_FLAT, size);
    const int32_t values[WG_VIEW_CHANNELS] = {0, 0, 0, 1 << 27, 0, -1, 35, 500000000};
    wg_picture_set(&scene.picture, values);
    for (unsigned i = 0; i < 3; i++) {
        CHECK(scene.vertices[i].z < 0x8000);
        CHECK(scene.vertices[i].z >= scene.picture.view.distance >> 16);
    }
    pc_close(&scene);
}

/* ---- the largest picture --------------------------------------------------------------------- */

/* A wall four pictures wide fills it, whatever the distance: the planes that cut it off lie outside.
 * They are counted in whole units, so how far outside depends on the distance. */
static void the_largest_picture_has_no_rim(void)
{
    const wg_size size = {WG_SIDE_MAX, WG_SIDE_MAX};
    memset(&mesh, 0, sizeof mesh);
    mesh.sides = 1;
    pc_part(&mesh);
    const unsigned a = pc_vertex(&mesh, -120, -120, 0), b = pc_vertex(&mesh, 120, -120, 0);
    const unsigned c = pc_vertex(&mesh, 120, 120, 0), d = pc_vertex(&mesh, -120, 120, 0);
    pc_triangle(&mesh, a, b, c);
    pc_triangle(&mesh, a, c, d);
    pc_open(&scene, &mesh, WG_PERSPECTIVE, WG_SHADING_FLAT, size);
    for (double distance = 64; distance < 128; distance += 1.7) { /* all mantissas */
        const pc_camera camera = {0, 0, 0, {0, 0, 0}, distance, 60};
        pc_look(&scene, &camera);
        const uint32_t *pixels = pc_draw(&scene);
        unsigned holes = 0;
        for (uint32_t p = 0; p < WG_SIDE_MAX * WG_SIDE_MAX; p++) {
            holes += pixels[p] == 0;
        }
        CHECK_EQ(holes, 0);
    }
    pc_close(&scene);
}

/* ---- full colours ---------------------------------------------------------------------------- */

/* The background, and every brightness of a colour: c s / 255, 1.5 below it and 0.5 above at the
 * most: s < 128 counts as s / 256, otherwise as (s + 1) / 256, and then it is cut. */
static void full_colours_are_those_of_the_clip(void)
{
    static const uint8_t PART[3] = {250, 3, 128}, BACK[3] = {1, 77, 255};
    const wg_size size = {SIDE, SIDE};
    const wg_rect row = {0, 0, SIDE, 3};
    uint32_t pixels[3 * SIDE];
    memset(&mesh, 0, sizeof mesh);
    pc_part(&mesh);
    pc_triangle(&mesh, pc_vertex(&mesh, 0, 0, 0), pc_vertex(&mesh, 1, 0, 0),
                pc_vertex(&mesh, 0, 1, 0));
    pc_open(&scene, &mesh, WG_PERSPECTIVE, WG_SHADING_FLAT, size);
    memcpy(scene.clip + build_where(scene.clip, WG_SECTION_PARTS, 0) + WG_PART_COLOUR, PART, 3);
    memcpy(scene.clip + build_where(scene.clip, WG_SECTION_VIEWS, 0) + WG_VIEW_BACKGROUND, BACK, 3);
    for (unsigned i = 0; i < 3 * SIDE; i++) {
        pixels[i] = i < 256 ? UINT32_C(0x10000) + 256 * i + 1 : 0;
    }
    CHECK_EQ(wg_pixels_rgb888(&scene.picture, row, pixels, (uint8_t *)pixels), 9 * SIDE);
    const uint8_t *rgb = (const uint8_t *)pixels;
    for (unsigned i = 0; i < 3 * SIDE; i++) {
        for (unsigned k = 0; k < 3; k++) {
            double want = i < 256 ? PART[k] * (i / 255.0) : BACK[k];
            double off = i == 0 || i >= 255 ? 0 : 1;
            CHECK(rgb[3 * i + k] >= want - 1.5 * off && rgb[3 * i + k] <= want + 0.5 * off);
        }
    }
    pc_close(&scene);
}

int main(void)
{
    TEST(nothing_wraps_at_the_nearest_plane);
    TEST(nothing_projected_is_nearer_than_the_nearest_plane);
    TEST(the_largest_picture_has_no_rim);
    TEST(full_colours_are_those_of_the_clip);
    return check_done();
}
