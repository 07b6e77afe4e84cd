/* Pixels to the bytes of panels, against formulas.
 * SPDX-License-Identifier: MIT */
#include "picture_clip.h"
#include "pixels.h"

#define WIDTH  48
#define HEIGHT 32
#define COUNT  (WIDTH * HEIGHT)

typedef uint32_t (*packer)(const wg_picture *, wg_rect, const uint32_t *, uint8_t *);

static pc_mesh mesh;
static pc_scene scene;
static uint32_t pixels[COUNT];
static uint8_t out[4 * COUNT];
static uint32_t seed = 5;

static uint32_t dice(uint32_t sides)
{
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) % sides;
}

/* Three parts with colours, a background, and random pixels. */
static void open_scene(void)
{
    const wg_size size = {WIDTH, HEIGHT};
    memset(&mesh, 0, sizeof mesh);
    for (unsigned i = 0; i < 3; i++) {
        pc_part(&mesh);
        pc_triangle(&mesh, pc_vertex(&mesh, 0, 0, i), pc_vertex(&mesh, 1, 0, i),
                    pc_vertex(&mesh, 0, 1, i));
    }
    pc_open(&scene, &mesh, WG_PERSPECTIVE, WG_SHADING_FLAT, size);
    uint8_t *view = scene.clip + build_where(scene.clip, WG_SECTION_VIEWS, 0);
    view[WG_VIEW_BACKGROUND] = 10;
    view[WG_VIEW_BACKGROUND + 1] = 60;
    view[WG_VIEW_BACKGROUND + 2] = 200;
    for (unsigned i = 0; i < COUNT; i++) {
        pixels[i] = dice(4) ? 0x10000u * (1 + dice(60000)) + 256u * dice(256) + 1 + dice(3) : 0;
        pixels[i] |= i % 7 == 0 ? 0 : 0x10000u;
        pixels[i] = pixels[i] & 255u ? pixels[i] : pixels[i] & 0xffff0000u;
    }
}

/* One colour everywhere, of part 0, at full brightness. */
static void paint(uint8_t red, uint8_t green, uint8_t blue)
{
    uint8_t *part = scene.clip + build_where(scene.clip, WG_SECTION_PARTS, 0) + WG_PART_COLOUR;
    part[0] = red;
    part[1] = green;
    part[2] = blue;
    for (unsigned i = 0; i < COUNT; i++) {
        pixels[i] = 0x1000ff01u;
    }
}

/* Part and view as the clip stores them; c s / 255 is cut by less than one. */
static void model_colour(uint32_t pixel, double *rgb)
{
    const uint8_t *at = scene.clip;
    if (WG_PIXEL_PART(pixel)) {
        at += build_where(at, WG_SECTION_PARTS, WG_PIXEL_PART(pixel) - 1u) + WG_PART_COLOUR;
    } else {
        at += build_where(at, WG_SECTION_VIEWS, 0) + WG_VIEW_BACKGROUND;
    }
    for (unsigned i = 0; i < 3; i++) {
        rgb[i] = WG_PIXEL_PART(pixel) ? at[i] * WG_PIXEL_SHADE(pixel) / 255.0 : at[i];
    }
}

static double model_grey(uint32_t pixel)
{
    double c[3];
    model_colour(pixel, c);
    return (77 * c[0] + 150 * c[1] + 29 * c[2]) / 256;
}

static const wg_rect ALL = {0, 0, WIDTH, HEIGHT};

/* A colour is cut by less than one and a bit; then its lowest bits go: 8 of 256 (red, blue), 4
 * (green). */
static void colours_are_high_byte_first_565(void)
{
    open_scene();
    CHECK_EQ(wg_pixels_rgb565(&scene.picture, ALL, pixels, out), 2 * COUNT);
    for (unsigned i = 0; i < COUNT; i++) {
        unsigned word = (unsigned)out[2 * i] << 8 | out[2 * i + 1];
        double want[3];
        model_colour(pixels[i], want);
        CHECK_NEAR((word >> 11) * 8.0, want[0] - 4, 5);
        CHECK_NEAR((word >> 5 & 63u) * 4.0, want[1] - 2.5, 3);
        CHECK_NEAR((word & 31u) * 8.0, want[2] - 4, 5);
    }
    paint(255, 255, 255);
    wg_pixels_rgb565(&scene.picture, ALL, pixels, out);
    CHECK(out[0] == 0xff && out[1] == 0xff);
    paint(255, 0, 8);
    wg_pixels_rgb565(&scene.picture, ALL, pixels, out);
    CHECK(out[0] == 0xf8 && out[1] == 0x01);
    pc_close(&scene);
}

/* Grey is cut by at most two (colour, then sum), and rounds to the next of 16 levels. */
static void grey_has_sixteen_even_levels(void)
{
    open_scene();
    CHECK_EQ(wg_pixels_grey4(&scene.picture, ALL, pixels, out), COUNT / 2);
    for (unsigned i = 0; i < COUNT; i++) {
        unsigned level = (unsigned)out[i / 2] >> (i % 2 ? 0 : 4) & 15u;
        CHECK_NEAR(level * 17.0, model_grey(pixels[i]) - 1, 8.5 + 1);
    }
    for (unsigned grey = 0; grey < 256; grey++) {
        paint((uint8_t)grey, (uint8_t)grey, (uint8_t)grey);
        wg_pixels_grey4(&scene.picture, ALL, pixels, out);
        CHECK_EQ(out[0], 17 * lrint(grey / 17.0));
    }
    pc_close(&scene);
}

static unsigned line_dot(unsigned x, unsigned y)
{
    return (unsigned)out[(y * WIDTH + x) / 8] >> (7 - x % 8) & 1u;
}

static unsigned page_dot(unsigned x, unsigned y)
{
    return (unsigned)out[y / 8 * WIDTH + x] >> y % 8 & 1u;
}

/* Of each 8 x 8 dots as many as the brightness says: 1/2 of 64 by rounding, 1/4 for 256/255. */
static void dither_keeps_the_mean_brightness(void)
{
    open_scene();
    unsigned before = 0;
    for (unsigned grey = 0; grey < 256; grey++) {
        unsigned dots = 0;
        paint((uint8_t)grey, (uint8_t)grey, (uint8_t)grey);
        CHECK_EQ(wg_pixels_lines(&scene.picture, ALL, pixels, out), COUNT / 8);
        for (unsigned i = 0; i < 64; i++) {
            dots += line_dot(16 + i % 8, 8 + i / 8);
        }
        CHECK_NEAR(dots / 64.0, grey / 255.0, 0.75 / 64);
        CHECK(dots >= before);
        before = dots;
    }
    pc_close(&scene);
}

/* Bayer's matrix by its recursion: M(2n) = [4 M(n), 4 M(n) + 2; 4 M(n) + 3, 4 M(n) + 1]. */
static unsigned model_bayer(unsigned x, unsigned y, unsigned side)
{
    static const unsigned SMALL[2][2] = {{0, 2}, {3, 1}};
    unsigned half = side / 2;
    return side == 1
               ? 0
               : 4 * model_bayer(x % half, y % half, half) + SMALL[y / half % 2][x / half % 2];
}

static void dots_are_those_of_bayers_matrix_in_both_layouts(void)
{
    open_scene();
    uint8_t expected[COUNT];
    for (unsigned i = 0; i < COUNT; i++) { /* one brightness, so that grey is exact */
        pixels[i] = pixels[i] & 255u ? 0x1000ff00u + 1u + i % 3 : 0;
        expected[i] =
            (unsigned)model_grey(pixels[i]) >= 4 * model_bayer(i % WIDTH % 8, i / WIDTH % 8, 8) + 2;
    }
    wg_pixels_lines(&scene.picture, ALL, pixels, out);
    for (unsigned i = 0; i < COUNT; i++) {
        CHECK_EQ(line_dot(i % WIDTH, i / WIDTH), expected[i]);
    }
    CHECK_EQ(wg_pixels_pages(&scene.picture, ALL, pixels, out), COUNT / 8);
    for (unsigned i = 0; i < COUNT; i++) {
        CHECK_EQ(page_dot(i % WIDTH, i / WIDTH), expected[i]);
    }
    pc_close(&scene);
}

/* A part of the picture by itself has the bytes that the whole has there. */
static void rectangles_have_the_same_dots(void)
{
    const wg_rect r = {16, 8, 40, 24};
    uint32_t part[24 * 16];
    uint8_t all[COUNT / 8];
    open_scene();
    for (unsigned i = 0; i < 24 * 16; i++) {
        part[i] = pixels[(8 + i / 24) * WIDTH + 16 + i % 24];
    }
    wg_pixels_pages(&scene.picture, ALL, pixels, all);
    CHECK_EQ(wg_pixels_pages(&scene.picture, r, part, out), 48);
    for (unsigned i = 0; i < 48; i++) {
        CHECK_EQ(out[i], all[(1 + i / 24) * WIDTH + 16 + i % 24]);
    }
    wg_pixels_lines(&scene.picture, ALL, pixels, all);
    CHECK_EQ(wg_pixels_lines(&scene.picture, r, part, out), 48);
    for (unsigned i = 0; i < 48; i++) {
        CHECK_EQ(out[i], all[(8 + i / 3) * WIDTH / 8 + 2 + i % 3]);
    }
    pc_close(&scene);
}

static void packing_in_place_gives_the_same_bytes(void)
{
    static const packer PACKERS[] = {wg_pixels_pages, wg_pixels_lines, wg_pixels_grey4,
                                     wg_pixels_rgb565};
    open_scene();
    for (unsigned i = 0; i < 4; i++) {
        uint32_t *place = malloc(sizeof pixels);
        memcpy(place, pixels, sizeof pixels);
        uint32_t bytes = PACKERS[i](&scene.picture, ALL, pixels, out);
        CHECK_EQ(PACKERS[i](&scene.picture, ALL, place, (uint8_t *)place), bytes);
        CHECK(memcmp(place, out, bytes) == 0);
        free(place);
    }
    pc_close(&scene);
}

int main(void)
{
    TEST(colours_are_high_byte_first_565);
    TEST(grey_has_sixteen_even_levels);
    TEST(dither_keeps_the_mean_brightness);
    TEST(dots_are_those_of_bayers_matrix_in_both_layouts);
    TEST(rectangles_have_the_same_dots);
    TEST(packing_in_place_gives_the_same_bytes);
    return check_done();
}
