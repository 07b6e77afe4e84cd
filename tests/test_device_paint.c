/* Pictures on parts, against rays in double precision and against parts of plain colours.
 * SPDX-License-Identifier: MIT */
#include "picture_model.h"
#include "pixels.h"

#define SIDE   96
#define WIDTH  64 /* of the picture on the plate, texels */
#define HEIGHT 48
#define STEP   (410 << 10) /* about WIDTH texels on 80 units of 2^7 raw */

static pc_mesh mesh;
static pc_scene scene;
static pm_model model;
static uint8_t texels[WIDTH * HEIGHT], palette[WG_PALETTE_BYTES];
static build_paint_data paint;
static uint32_t seed = 3;

static uint32_t bits(void)
{
    seed = seed * 1664525u + 1013904223u;
    return seed >> 8;
}

static double dice(double low, double high)
{
    return low + (high - low) * bits() / 16777216.0;
}

/* An eighth of the texels are not drawn. */
static void make_picture(void)
{
    const build_paint_data centred = {
        0, WG_PAINT_PICTURE, WIDTH, HEIGHT, palette, texels, STEP, {WIDTH << 15, HEIGHT << 15}};
    paint = centred;
    for (unsigned i = 0; i < sizeof texels; i++) {
        texels[i] = (uint8_t)(bits() % 8 ? 1 + bits() % 255 : 0);
    }
    for (unsigned i = 0; i < sizeof palette; i++) {
        palette[i] = (uint8_t)bits();
    }
}

static void add_paint(build *b)
{
    build_paint(b, &paint);
}

/* A sheet of nx x ny vertices at depth z, shaken in its plane but for the rim; one part. */
static void sheet(unsigned nx, unsigned ny, const double half[2], double z)
{
    unsigned first = mesh.vertices;
    pc_part(&mesh);
    for (unsigned i = 0; i < nx * ny; i++) {
        unsigned x = i % nx, y = i / nx;
        int in = x > 0 && y > 0 && x + 1 < nx && y + 1 < ny;
        double u = x + (in ? dice(-0.4, 0.4) : 0), v = y + (in ? dice(-0.4, 0.4) : 0);
        pc_vertex(&mesh, half[0] * (2 * u / (nx - 1) - 1), half[1] * (2 * v / (ny - 1) - 1), z);
    }
    for (unsigned i = 0; i < (nx - 1) * (ny - 1); i++) {
        unsigned a = first + i / (nx - 1) * nx + i % (nx - 1);
        pc_triangle(&mesh, a, a + 1, a + nx + 1);
        pc_triangle(&mesh, a, a + nx + 1, a + nx);
    }
}

/* The plate with the picture, and a plain one behind it. `n` vertices along. */
static void open_plate(uint8_t projection, uint8_t shading, unsigned n)
{
    static const double FRONT[2] = {40, 30}, BACK[2] = {30, 60};
    const wg_size size = {SIDE, SIDE};
    memset(&mesh, 0, sizeof mesh);
    mesh.sides = 1;
    mesh.more = add_paint;
    sheet(n, n, FRONT, 0);
    sheet(2, 2, BACK, -15);
    pc_open(&scene, &mesh, projection, shading, size);
}

/* ---- texels against rays --------------------------------------------------------------------- */

/* test_device_picture.c derives it: how far a projected vertex is off, in pixels. */
#define VERTEX_ERROR (1.0 / 32 + 0.75 * SIDE * (3.0 / 32768 + 1.0 / 8192))

/* Texel coordinates of a place on the plate, in raw units. */
static void texel_at(double x, double y, double *uv)
{
    double step = ldexp((int32_t)paint.step, -26);
    uv[0] = ldexp(paint.corner[0], -16) + step * x;
    uv[1] = ldexp(paint.corner[1], -16) - step * y;
}

/* What the ray through a pixel finds on the plate. */
static void texel_of_ray(double x, double y, double *uv)
{
    double eye[3], way[3], depth = pm_depth(&model, 0, x, y), q[3];
    pm_ray(&model, x, y, eye, way);
    for (unsigned k = 0; k < 3; k++) {
        q[k] = eye[k] + depth * way[k];
    }
    for (unsigned k = 0; k < 2; k++) { /* back into the world: the turn's transpose */
        uv[k] = model.target[k];
        for (unsigned i = 0; i < 3; i++) {
            uv[k] += model.turn[i][k] * q[i];
        }
    }
    texel_at(ldexp(uv[0], PC_FRAC), ldexp(uv[1], PC_FRAC), uv);
}

/* Linear between the corners of a triangle, as they are seen. */
static void texel_of_corners(unsigned triangle, double x, double y, double *uv)
{
    const uint16_t *c = mesh.corner[triangle];
    double px[3], py[3], t[3][2];
    for (unsigned i = 0; i < 3; i++) {
        pm_project(&model, model.at[c[i]], &px[i], &py[i]);
        texel_at(ldexp(mesh.at[c[i]][0], PC_FRAC), ldexp(mesh.at[c[i]][1], PC_FRAC), t[i]);
    }
    double area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0]);
    double v = ((x - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (y - py[0])) / area;
    double w = ((px[1] - px[0]) * (y - py[0]) - (x - px[0]) * (py[1] - py[0])) / area;
    for (unsigned k = 0; k < 2; k++) {
        uv[k] = t[0][k] + v * (t[1][k] - t[0][k]) + w * (t[2][k] - t[0][k]);
    }
}

/* `rays`: the picture keeps to its plate; otherwise to each triangle's corners. */
static void model_texel(int rays, unsigned triangle, const double at[2], double *uv)
{
    rays ? texel_of_ray(at[0], at[1], uv) : texel_of_corners(triangle, at[0], at[1], uv);
}

/* Off by what moving the corners by `reach` pixels across and down does, by 2^-14.9 of the way from a
 * corner (1/area; the picture's whole way at the most), by 2^-10 for a corner and as much again for slopes
 * of 2^-20 and SIDE pixels; cut corners twice. */
static void texel_error(int rays, unsigned triangle, const double at[2], double reach, double *e)
{
    double here[2];
    model_texel(rays, triangle, at, here);
    e[0] = WIDTH / 16384.0 + 4.0 / 1024;
    e[1] = HEIGHT / 16384.0 + 4.0 / 1024;
    for (unsigned axis = 0; axis < 2; axis++) {
        double there[2], place[2] = {at[0], at[1]};
        place[axis] += 1;
        model_texel(rays, triangle, place, there);
        e[0] += reach * fabs(there[0] - here[0]);
        e[1] += reach * fabs(there[1] - here[1]);
    }
}

static int limited(double texel, int count)
{
    return (int)fmin(fmax(texel, 0), count - 1);
}

/* Which texels a place may show. */
static unsigned candidates(const double *uv, const double *e, uint8_t *found)
{
    unsigned count = 0;
    for (int y = limited(uv[1] - e[1], HEIGHT); y <= limited(uv[1] + e[1], HEIGHT); y++) {
        for (int x = limited(uv[0] - e[0], WIDTH); x <= limited(uv[0] + e[0], WIDTH); x++) {
            found[count++] = texels[y * WIDTH + x];
        }
    }
    return count;
}

/* Whether a pixel shows one of the texels, or what is behind those that are not drawn. */
static int shows(uint32_t pixel, const uint8_t *found, unsigned count, int behind)
{
    for (unsigned i = 0; i < count; i++) {
        if (found[i] == 0 ? WG_PIXEL_PART(pixel) == (behind ? 2 : 0)
                          : WG_PIXEL_PART(pixel) == 1 && WG_PIXEL_SHADE(pixel) == found[i]) {
            return 1;
        }
    }
    return 0;
}

/* Returns how many pixels had one texel to show. */
static unsigned compare_texels(int rays, double reach)
{
    static uint8_t marked[SIDE * SIDE];
    const uint32_t *pixels = pc_draw(&scene);
    unsigned certain = 0, through = 0, wrong = 0;
    pm_mark_edges(&model, reach, marked);
    for (int p = 0; p < SIDE * SIDE; p++) {
        const double at[2] = {p % SIDE + 0.5, p / SIDE + 0.5};
        double uv[2], e[2];
        uint8_t found[16];
        pm_hit hit = pm_look(&model, at[0], at[1]);
        if (marked[p] || hit.triangle < 0 || pm_part(&mesh, (unsigned)hit.triangle) != 0) {
            continue;
        }
        unsigned t = (unsigned)hit.triangle;
        model_texel(rays, t, at, uv);
        texel_error(rays, t, at, reach, e);
        if (e[0] > 0.5 || e[1] > 0.5) {
            continue;
        }
        unsigned count = candidates(uv, e, found);
        wrong += !shows(pixels[p], found, count, hit.behind < HUGE_VAL);
        certain += count == 1;
        through += count == 1 && found[0] == 0;
    }
    CHECK_EQ(wrong, 0);
    CHECK(through > 20);
    return certain;
}

static void look(double yaw, double pitch, double distance, double size)
{
    const pc_camera c = {yaw,      pitch, dice(-180, 180), {dice(-3, 3), dice(-3, 3), 0},
                         distance, size};
    pc_look(&scene, &c);
    pm_make(&model, &mesh, &scene, WG_VIEW_IS_FLAT(&scene.picture.view));
    for (unsigned k = 0; k < 3; k++) {
        model.target[k] = ldexp(scene.values[WG_VIEW_X + k], -PC_LENGTH);
    }
}

static void an_orthographic_view_shows_the_texels_that_rays_find(void)
{
    make_picture();
    open_plate(WG_ORTHOGRAPHIC, WG_SHADING_FLAT, 7);
    for (unsigned i = 0; i < 6; i++) {
        look(dice(-60, 60), dice(-40, 40), 200, dice(60, 90));
        CHECK(compare_texels(1, VERTEX_ERROR) > 1500);
    }
    look(150, 20, 200, 80); /* from behind: a mirror's picture */
    compare_texels(1, VERTEX_ERROR);
    pc_close(&scene);
}

static void a_plate_that_faces_the_camera_shows_the_texels_that_rays_find(void)
{
    make_picture();
    open_plate(WG_PERSPECTIVE, WG_SHADING_SMOOTH, 7);
    for (unsigned i = 0; i < 4; i++) {
        look(0, 0, dice(100, 300), dice(60, 90));
        CHECK(compare_texels(1, VERTEX_ERROR) > 2000);
    }
    pc_close(&scene);
}

static void otherwise_texels_run_from_corner_to_corner(void)
{
    make_picture();
    open_plate(WG_PERSPECTIVE, WG_SHADING_FLAT, 9);
    for (unsigned i = 0; i < 4; i++) {
        look(dice(20, 50), dice(-40, 40), 200, 75);
        CHECK(compare_texels(0, VERTEX_ERROR) > 1200);
    }
    pc_close(&scene);
}

/* Corners far outside are kept in units of 8^e / 128 pixels, e = 0..3, and cut down; see
 * test_device_cut.c: cut_error. */
static double cut_error(void)
{
    unsigned e = 0, outside = 0;
    for (unsigned i = 0; i < mesh.vertices; i++) {
        unsigned own = scene.vertices[i].z >> 13 & 3u;
        outside += scene.vertices[i].z >> 15;
        e = scene.vertices[i].z >> 15 && own > e ? own : e;
    }
    CHECK(outside > 0);
    return (ldexp(1, (int)(3 * e)) + 1) / 128 + 1.0 / 16;
}

static void cut_triangles_show_the_same_texels(void)
{
    make_picture();
    open_plate(WG_ORTHOGRAPHIC, WG_SHADING_FLAT, 2);
    for (unsigned i = 0; i < 4; i++) {
        look(dice(-30, 30), dice(-30, 30), 200, dice(1, 3));
        for (unsigned k = 0; k < sizeof texels; k++) { /* few are seen: some of them empty */
            texels[k] = (uint8_t)(k % 3 ? 1 + bits() % 255 : 0);
        }
        uint8_t *file = scene.clip + build_where(scene.clip, WG_SECTION_DATA, 0);
        const uint8_t *r = scene.clip + build_where(scene.clip, WG_SECTION_PAINTS, 0);
        memcpy(file + build_get(r + WG_PAINT_TEXELS, 4), texels, sizeof texels);
        CHECK(compare_texels(1, cut_error()) > SIDE * SIDE / 2);
    }
    pc_close(&scene);
}

/* Whatever step and corner are: nothing is read outside (ASan), and beyond the rim there is the rim. */
static void texels_stay_inside_the_picture(void)
{
    make_picture();
    for (unsigned i = 0; i < 40; i++) {
        paint.step = bits() * 257u >> bits() % 30;
        paint.corner[0] = (int32_t)(bits() * 257u);
        paint.corner[1] = (int32_t)(bits() * 257u);
        if (i == 0) { /* left of it and below it */
            paint.step = 0;
            paint.corner[0] = -5 * 65536;
            paint.corner[1] = HEIGHT << 16;
            texels[(HEIGHT - 1) * WIDTH] = 77;
        }
        open_plate(WG_PERSPECTIVE, WG_SHADING_FLAT, i % 2 ? 2 : 7);
        look(i * 7.0, 20, i % 3 ? 200 : 30, 70);
        pc_draw(&scene);
        for (int p = 0; p < SIDE * SIDE && i == 0; p++) {
            CHECK(WG_PIXEL_PART(scene.pixels[p]) != 1 || WG_PIXEL_SHADE(scene.pixels[p]) == 77);
        }
        pc_close(&scene);
    }
}

/* ---- the same picture, asked for in other ways ----------------------------------------------- */

static void check_rectangle(const uint32_t *all, wg_rect r)
{
    uint32_t count = (uint32_t)(r.x1 - r.x0) * (uint32_t)(r.y1 - r.y0), wrong = 0;
    uint32_t *part = malloc(count * sizeof *part);
    wg_picture_band(&scene.picture, r, part);
    for (uint16_t y = r.y0; y < r.y1; y++) {
        wrong += memcmp(part + (y - r.y0) * (r.x1 - r.x0), all + y * SIDE + r.x0,
                        (size_t)(r.x1 - r.x0) * sizeof *all) != 0;
    }
    CHECK_EQ(wrong, 0);
    free(part);
}

/* From afar, or so near that the plate reaches behind the viewer. */
static void look_from(int near)
{
    const pc_camera c = {near ? 65.0 : 30.0, 25, 5, {3, 2, 1}, near ? 12.0 : 200.0, near ? 14 : 90};
    pc_look(&scene, &c);
}

static void bands_of_any_height_make_one_picture(void)
{
    make_picture();
    for (int near = 0; near < 2; near++) {
        open_plate(WG_PERSPECTIVE, WG_SHADING_FLAT, 5);
        look_from(near);
        const uint32_t *all = pc_draw(&scene);
        for (uint16_t rows = 1; rows <= SIDE; rows = (uint16_t)(rows + 1 + rows / 8)) {
            for (uint16_t y = 0; y < SIDE; y = (uint16_t)(y + rows)) {
                wg_rect r = {0, y, SIDE, (uint16_t)(y + rows < SIDE ? y + rows : SIDE)};
                check_rectangle(all, r);
            }
        }
        const wg_rect odd = {17, 9, 64, 71};
        check_rectangle(all, odd);
        pc_close(&scene);
    }
}

static void the_order_of_triangles_does_not_matter(void)
{
    make_picture();
    for (int near = 0; near < 2; near++) {
        static uint32_t first[SIDE * SIDE];
        const wg_size size = {SIDE, SIDE};
        open_plate(WG_PERSPECTIVE, WG_SHADING_FLAT, 5);
        look_from(near);
        memcpy(first, pc_draw(&scene), sizeof first);
        pc_close(&scene);
        for (unsigned a = 0, b = mesh.part[1] - 1; a < b; a++, b--) {
            uint16_t swap[3];
            memcpy(swap, mesh.corner[a], sizeof swap);
            memcpy(mesh.corner[a], mesh.corner[b], sizeof swap);
            memcpy(mesh.corner[b], swap, sizeof swap);
        }
        pc_open(&scene, &mesh, WG_PERSPECTIVE, WG_SHADING_FLAT, size);
        look_from(near);
        CHECK(memcmp(first, pc_draw(&scene), sizeof first) == 0);
        pc_close(&scene);
    }
}

/* ---- shading and colours --------------------------------------------------------------------- */

/* Bytes of all the pixels in one of the packings of pixels.h. */
static uint32_t pack(unsigned kind, const uint32_t *pixels, uint8_t *out)
{
    static uint32_t (*const PACK[])(const wg_picture *, wg_rect, const uint32_t *, uint8_t *) = {
        wg_pixels_pages, wg_pixels_lines, wg_pixels_grey4, wg_pixels_rgb565, wg_pixels_rgb888};
    const wg_rect all = {0, 0, SIDE, SIDE};
    return PACK[kind](&scene.picture, all, pixels, out);
}

/* How many steps a frame takes. */
static unsigned steps(void)
{
    unsigned count = 1;
    wg_picture_begin(&scene.picture, scene.values);
    while (wg_picture_step_skinned(&scene.picture)) {
        count++;
    }
    return count;
}

static void light_does_not_fall_on_painted_parts(void)
{
    static uint32_t seen[2][SIDE * SIDE];
    static uint8_t bytes[2][3 * SIDE * SIDE];
    make_picture();
    for (unsigned i = 0; i < 2; i++) {
        seed = 1; /* the same plate */
        open_plate(WG_PERSPECTIVE, i ? WG_SHADING_FLAT : WG_SHADING_SMOOTH, 7);
        look_from(0);
        memcpy(seen[i], pc_draw(&scene), sizeof seen[i]);
        pc_close(&scene);
    }
    for (int p = 0; p < SIDE * SIDE; p++) { /* the plate behind is lit */
        CHECK(WG_PIXEL_PART(seen[0][p]) == 2 || seen[0][p] == seen[1][p]);
    }
    for (unsigned i = 0; i < 2; i++) { /* in a wireframe parts have their own colours */
        seed = 1;
        open_plate(WG_PERSPECTIVE, WG_SHADING_WIRE, 7);
        scene.picture.paints = (uint8_t)(i ? scene.picture.paints : 0);
        look_from(0);
        memcpy(seen[i], pc_draw(&scene), sizeof seen[i]);
        pack(4, seen[i], bytes[i]);
        pc_close(&scene);
    }
    CHECK(memcmp(seen[0], seen[1], sizeof seen[0]) == 0);
    CHECK(memcmp(bytes[0], bytes[1], sizeof bytes[0]) == 0);
}

static void normals_of_painted_parts_are_not_computed(void)
{
    static const double HALF[2] = {40, 30};
    const wg_size size = {SIDE, SIDE};
    make_picture();
    for (unsigned smooth = 0; smooth < 2; smooth++) {
        memset(&mesh, 0, sizeof mesh);
        mesh.more = add_paint;
        sheet(8, 8, HALF, 0);
        pc_open(&scene, &mesh, WG_PERSPECTIVE, smooth ? WG_SHADING_SMOOTH : WG_SHADING_FLAT, size);
        look_from(0);
        CHECK_EQ(steps(), 2); /* 64 vertices */
        pc_close(&scene);
    }
}

/* Part 0 with a palette, part 1 plain, and the background. */
static void make_pixels(uint32_t *pixels)
{
    for (unsigned i = 0; i < SIDE * SIDE; i++) {
        uint32_t part = bits() % 4 ? 1 : bits() % 3;
        pixels[i] = part ? 0x10000u | bits() % 256 << 8 | part : 0;
    }
}

/* What all packers do with each pixel: the same as if its colour of the palette were that of its part,
 * in full light. Packings are compared as a whole, colour by colour: a pixel's bits depend on its own
 * colour and place. */
static void a_painted_pixel_has_its_colour_of_the_palette(void)
{
    static uint32_t pixels[SIDE * SIDE], plain[SIDE * SIDE];
    static uint8_t got[3 * SIDE * SIDE], want[3 * SIDE * SIDE];
    make_picture();
    open_plate(WG_PERSPECTIVE, WG_SHADING_FLAT, 2);
    look_from(0);
    uint8_t *colour = scene.clip + build_where(scene.clip, WG_SECTION_PARTS, 0) + WG_PART_COLOUR;
    for (unsigned shade = 0; shade < 256; shade++) {
        make_pixels(pixels);
        for (unsigned i = 0; i < SIDE * SIDE; i++) { /* one colour of the palette a time */
            int painted = WG_PIXEL_PART(pixels[i]) == 1;
            pixels[i] = painted ? 0x10001u | shade << 8 : pixels[i];
            plain[i] = painted ? 0x1ff01u : pixels[i];
        }
        memcpy(colour, palette + 3 * shade, 3);
        for (unsigned kind = 0; kind < 5; kind++) {
            scene.picture.paints = 1;
            uint32_t count = pack(kind, pixels, got);
            scene.picture.paints = 0;
            CHECK_EQ(pack(kind, plain, want), count);
            CHECK(memcmp(got, want, count) == 0);
        }
    }
    scene.picture.paints = 1;
    make_pixels(pixels); /* all colours side by side */
    pack(4, pixels, got);
    for (unsigned i = 0; i < SIDE * SIDE; i++) {
        CHECK(WG_PIXEL_PART(pixels[i]) != 1 ||
              memcmp(got + 3 * i, palette + 3 * WG_PIXEL_SHADE(pixels[i]), 3) == 0);
    }
    pc_close(&scene);
}

int main(void)
{
    TEST(an_orthographic_view_shows_the_texels_that_rays_find);
    TEST(a_plate_that_faces_the_camera_shows_the_texels_that_rays_find);
    TEST(otherwise_texels_run_from_corner_to_corner);
    TEST(cut_triangles_show_the_same_texels);
    TEST(texels_stay_inside_the_picture);
    TEST(bands_of_any_height_make_one_picture);
    TEST(the_order_of_triangles_does_not_matter);
    TEST(light_does_not_fall_on_painted_parts);
    TEST(normals_of_painted_parts_are_not_computed);
    TEST(a_painted_pixel_has_its_colour_of_the_palette);
    return check_done();
}
