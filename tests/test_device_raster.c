/* Triangles and lines, pixel by pixel, against exact and double-precision models.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "draw.h"

#define SIDE      64 /* pixels */
#define TRIANGLES 120

static wg_view view;
static uint32_t pixels[SIDE * SIDE];
static uint32_t seed = 1;

static uint32_t dice(uint32_t sides)
{
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) % sides;
}

static wg_canvas canvas_of(uint8_t shading)
{
    wg_canvas c = {&view, pixels, {0, 0, SIDE, SIDE}, shading, 1, 0, NULL};
    memset(pixels, 0, sizeof pixels);
    return c;
}

static wg_vertex corner[3]; /* of the triangle */

static wg_triangle triangle_of(const int xy[3][2])
{
    wg_triangle t = {{&corner[0], &corner[1], &corner[2]}, NULL, {200, 200, 200}, WG_EDGES, {{0}}};
    for (unsigned i = 0; i < 3; i++) {
        corner[i].x = (int16_t)xy[i][0];
        corner[i].y = (int16_t)xy[i][1];
        corner[i].z = 4096;
    }
    return t;
}

/* ---- coverage -------------------------------------------------------------------------------- */

/* A centre belongs to the triangle that holds it when it is moved to the right by an infinitely
 * small e and down by e^2: what the rule about left and top edges says, without edges. e = 1/M and
 * all is multiplied by M^2; |dx|, |dy| < M, so the moves decide only where a centre lies on an
 * edge. Corners clockwise on the screen, which is the back; y points down. */
static int model_covers(const int xy[3][2], int x, int y)
{
    const int64_t M = 32768;
    for (unsigned i = 0; i < 3; i++) {
        const int *a = xy[i], *b = xy[(i + 1) % 3];
        int64_t px = (16 * x + 8 - a[0]) * M * M + M, py = (16 * y + 8 - a[1]) * M * M + 1;
        if (px * (b[1] - a[1]) - py * (b[0] - a[0]) <= 0) {
            return 0;
        }
    }
    return 1;
}

static int twice_area(const int *a, const int *b, const int *c)
{
    return (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1]);
}

/* A square cut into triangles by points that fall into one of them: slivers included. The first four
 * points are the square's corners, possibly outside of the picture. */
static unsigned tiles(int xy[TRIANGLES][3][2], int low, int high)
{
    const int a[2] = {low, low}, b[2] = {low, high}, c[2] = {high, high}, d[2] = {high, low};
    const int *first[2][3] = {{a, b, c}, {a, c, d}};
    unsigned count = 2;
    for (unsigned i = 0; i < 6; i++) {
        memcpy(xy[i / 3][i % 3], first[i / 3][i % 3], sizeof a);
    }
    for (unsigned tries = 0; tries < 4000 && count + 2 <= TRIANGLES; tries++) {
        int(*t)[2] = xy[dice(count)];
        int u = (int)dice(100), v = (int)dice(100u - (unsigned)u);
        int p[2];
        for (unsigned k = 0; k < 2; k++) {
            p[k] = (t[0][k] * u + t[1][k] * v + t[2][k] * (100 - u - v)) / 100;
        }
        if (twice_area(t[0], t[1], p) > 0 && twice_area(t[1], t[2], p) > 0 &&
            twice_area(t[2], t[0], p) > 0) {
            for (unsigned i = 0; i < 2; i++) {
                memcpy(xy[count], t, sizeof xy[count]);
                memcpy(xy[count++][i], p, sizeof p);
            }
            memcpy(t[2], p, sizeof p);
        }
    }
    return count;
}

/* The smallest height of a triangle, 1/16 pixel. */
static double height_of(void)
{
    double x[3], y[3], area, side = 0;
    for (unsigned i = 0; i < 3; i++) {
        x[i] = corner[i].x;
        y[i] = corner[i].y;
    }
    area = fabs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]));
    for (unsigned i = 0; i < 3; i++) {
        side = fmax(side, hypot(x[(i + 1) % 3] - x[i], y[(i + 1) % 3] - y[i]));
    }
    return area / side;
}

static void check_tiling(int low, int high)
{
    static int xy[TRIANGLES][3][2];
    uint8_t times[SIDE * SIDE] = {0};
    unsigned count = tiles(xy, low, high), wrong = 0, slivers = 0;
    for (unsigned i = 0; i < count; i++) {
        wg_canvas canvas = canvas_of(WG_SHADING_SMOOTH);
        wg_triangle t = triangle_of((const int(*)[2])xy[i]);
        wg_draw_triangle(&canvas, &t);
        slivers += height_of() < 8;
        for (int p = 0; p < SIDE * SIDE; p++) {
            wrong += (pixels[p] != 0) != model_covers((const int(*)[2])xy[i], p % SIDE, p / SIDE);
            times[p] = (uint8_t)(times[p] + (pixels[p] != 0));
        }
    }
    CHECK_EQ(wrong, 0);
    CHECK(slivers > 3);
    for (int p = 0; p < SIDE * SIDE; p++) {
        int x = p % SIDE * 16 + 8, y = p / SIDE * 16 + 8;
        int in = x >= low && x < high && y >= low && y < high; /* left and top edges own theirs */
        wrong += times[p] != in;
    }
    CHECK_EQ(wrong, 0);
}

static void triangles_side_by_side_cover_each_pixel_once(void)
{
    for (unsigned i = 0; i < 4; i++) {
        check_tiling(40, 1000);      /* its edges pass through no centre, */
        check_tiling(56, 904);       /* or through centres */
        check_tiling(-16380, 16380); /* as far out as vertices may be */
    }
}

static void only_fronts_are_drawn_unless_both_sides_are(void)
{
    const int front[3][2] = {{100, 100}, {100, 900}, {900, 500}};
    const int back[3][2] = {{100, 100}, {900, 500}, {100, 900}};
    uint32_t seen[SIDE * SIDE];
    wg_canvas canvas = canvas_of(WG_SHADING_SMOOTH);
    wg_triangle t = triangle_of(back);
    wg_draw_triangle(&canvas, &t);
    memset(seen, 0, sizeof seen);
    CHECK(memcmp(seen, pixels, sizeof pixels) == 0);
    canvas.sides = 1;
    wg_draw_triangle(&canvas, &t);
    memcpy(seen, pixels, sizeof seen);
    CHECK(pixels[30 * SIDE + 20] != 0);
    canvas = canvas_of(WG_SHADING_SMOOTH);
    t = triangle_of(front);
    wg_draw_triangle(&canvas, &t);
    CHECK(memcmp(seen, pixels, sizeof pixels) == 0);
}

/* ---- what a pixel holds ---------------------------------------------------------------------- */

/* The value at a pixel's centre of what is linear over the picture. */
static double model_plane(const double *value, int x, int y)
{
    const wg_vertex *a = &corner[0], *b = &corner[1], *c = &corner[2];
    double px = 16.0 * x + 8 - a->x, py = 16.0 * y + 8 - a->y;
    double bx = b->x - a->x, by = b->y - a->y, cx = c->x - a->x, cy = c->y - a->y;
    double v = (px * cy - py * cx) / (bx * cy - by * cx);
    double w = (bx * py - by * px) / (bx * cy - by * cx);
    return value[0] + v * (value[1] - value[0]) + w * (value[2] - value[0]);
}

static double model_nearness(uint16_t z)
{
    return WG_VIEW_IS_FLAT(&view) ? 65535.0 - 2 * z : (double)view.nearness / z;
}

/* Nearness: the corners' is cut to 1/32, slopes and values to 2^-15, 1/area is 2^-15 of a difference
 * up to 65535 off, and the pixel's is cut: 0.04 + 2 + 1. Brightness: 1/area off by 2^-15 of 255.
 * Slopes end at 2^15 a pixel: a triangle two pixels high cannot have more. */
static void check_planes(int spread)
{
    unsigned seen = 0;
    for (unsigned n = 0; n < 300; n++) {
        wg_canvas canvas = canvas_of(WG_SHADING_SMOOTH);
        const int none[3][2] = {{0, 0}, {0, 0}, {0, 0}};
        wg_triangle t = triangle_of(none);
        double near[3], shade[3];
        for (unsigned i = 0; i < 3; i++) {
            corner[i].x = (int16_t)((int)dice((uint32_t)spread) - spread / 2 + 512);
            corner[i].y = (int16_t)((int)dice((uint32_t)spread) - spread / 2 + 512);
            corner[i].z = (uint16_t)(300 + dice(dice(2) ? 32467 : 200));
            t.shade[i] = (uint8_t)dice(256);
            near[i] = model_nearness(corner[i].z);
            shade[i] = t.shade[i];
        }
        canvas.sides = 1;
        wg_draw_triangle(&canvas, &t);
        double low = fmin(near[0], fmin(near[1], near[2])) - 1;
        double high = fmax(near[0], fmax(near[1], near[2]));
        for (int p = 0; p < SIDE * SIDE; p++) {
            if (pixels[p] == 0) {
                continue;
            }
            double got = WG_PIXEL_NEAR(pixels[p]), dark = WG_PIXEL_SHADE(pixels[p]);
            CHECK(got >= low && got <= high && got >= 1);
            if (height_of() > 33) {
                CHECK_NEAR(got, model_plane(near, p % SIDE, p / SIDE), 3.04);
                CHECK_NEAR(dark, model_plane(shade, p % SIDE, p / SIDE), 1.02);
                seen++;
            }
        }
    }
    CHECK(seen > 1000);
}

static void nearness_and_brightness_are_linear_over_the_picture(void)
{
    view.nearness = 65535u * 300u;
    check_planes(1024);
    check_planes(32000);
    view.nearness = 0;
    check_planes(1024);
    check_planes(32000);
    view.nearness = 65535u * 300u;
}

static void rectangles_show_the_same_pixels(void)
{
    for (unsigned n = 0; n < 200; n++) {
        uint32_t part[SIDE * SIDE], all[SIDE * SIDE];
        wg_canvas canvas = canvas_of(n & 1u ? WG_SHADING_WIRE : WG_SHADING_SMOOTH);
        int xy[3][2];
        for (unsigned i = 0; i < 6; i++) {
            xy[i / 2][i % 2] = (int)dice(n & 2u ? 32000 : 1600) - (n & 2u ? 16000 : 300);
        }
        wg_triangle t = triangle_of((const int(*)[2])xy);
        corner[1].z = (uint16_t)(300 + dice(32000));
        t.shade[2] = (uint8_t)dice(256);
        canvas.sides = 1;
        wg_draw_triangle(&canvas, &t);
        memcpy(all, pixels, sizeof all);
        for (unsigned tries = 0; tries < 8; tries++) {
            uint16_t x0 = (uint16_t)dice(SIDE), y0 = (uint16_t)dice(SIDE);
            uint16_t x1 = (uint16_t)(x0 + 1 + dice(SIDE - x0));
            uint16_t y1 = (uint16_t)(y0 + 1 + dice(SIDE - y0));
            wg_rect rect = {x0, y0, x1, y1};
            canvas.rect = rect;
            canvas.pixels = part;
            memset(part, 0, sizeof part);
            wg_draw_triangle(&canvas, &t);
            unsigned wrong = 0;
            for (uint16_t y = y0; y < y1; y++) {
                wrong += memcmp(part + (y - y0) * (x1 - x0), all + y * SIDE + x0,
                                (size_t)(x1 - x0) * sizeof *all) != 0;
            }
            CHECK_EQ(wrong, 0);
        }
    }
}

/* ---- lines ----------------------------------------------------------------------------------- */

/* Only the pixels that a line has drawn: those with a part. */
static unsigned line_pixels(const int *a, const int *b, uint8_t edges, uint8_t *on)
{
    /* The third corner makes a front of the triangle. */
    int xy[3][2] = {{a[0], a[1]}, {b[0], b[1]}, {a[0] - (b[1] - a[1]), a[1] + b[0] - a[0]}};
    unsigned count = 0;
    if (twice_area(xy[0], xy[1], xy[2]) < 0) {
        xy[2][0] = a[0] + b[1] - a[1];
        xy[2][1] = a[1] - (b[0] - a[0]);
    }
    wg_canvas canvas = canvas_of(WG_SHADING_WIRE);
    wg_triangle t = triangle_of((const int(*)[2])xy);
    t.edges = edges;
    wg_draw_triangle(&canvas, &t);
    for (int p = 0; p < SIDE * SIDE; p++) {
        on[p] = WG_PIXEL_PART(pixels[p]) != 0;
        count += on[p];
        CHECK(WG_PIXEL_SHADE(pixels[p]) == (on[p] ? 255 : 0));
    }
    return count;
}

/* One pixel a column, its middle within half a pixel of the line, 1/16 for the line's own units and
 * 2^-15 of its length for its slope; at the ends the column's middle may lie beyond the line. */
static void lines_take_the_nearest_pixel_of_each_column(void)
{
    for (unsigned n = 0; n < 400; n++) {
        int a[2] = {(int)dice(1024), (int)dice(1024)}, b[2] = {(int)dice(1024), (int)dice(1024)};
        uint8_t on[SIDE * SIDE], turned[SIDE * SIDE];
        int steep = abs(b[1] - a[1]) > abs(b[0] - a[0]);
        int longer = abs(b[steep] - a[steep]);
        if (longer == 0) {
            continue;
        }
        int from = (a[steep] < b[steep] ? a : b)[steep] >> 4;
        int to = (a[steep] < b[steep] ? b : a)[steep] >> 4;
        CHECK_EQ(line_pixels(a, b, 1, on), to - from + 1);
        line_pixels(b, a, 1, turned);
        CHECK(memcmp(on, turned, sizeof on) == 0);
        for (int p = 0; p < SIDE * SIDE; p++) {
            double along = (steep ? p / SIDE : p % SIDE) * 16 + 8;
            double across = (steep ? p % SIDE : p / SIDE) * 16 + 8;
            double slope = (double)(b[!steep] - a[!steep]) / (b[steep] - a[steep]);
            double ends =
                fmax(0, fmax(fmin(a[steep], b[steep]) - along, along - fmax(a[steep], b[steep])));
            if (on[p]) {
                CHECK_NEAR(across, a[!steep] + slope * (along - a[steep]), 8 + ends + 1.1);
            }
        }
    }
    uint8_t none[SIDE * SIDE];
    const int a[2] = {100, 100}, b[2] = {800, 300};
    CHECK_EQ(line_pixels(a, b, 0, none), 0);
}

/* ---- numbers ---------------------------------------------------------------------------------- */

static void ratios_are_as_close_as_they_say(void)
{
    for (unsigned n = 0; n < 20000; n++) {
        uint32_t a = (dice(65536) << 16 | dice(65536)) >> dice(32), b = a ? a : 1;
        double real = b;
        wg_ratio r, i = {WG_FAR, 30}, t;
        wg_ratio_set(&r, b >> 1 ? b >> 1 : 1);
        wg_ratio_divide(&i, b);
        t = i;
        wg_ratio_times(&t, &r);
        CHECK(r.m >= 1 << 30 && i.m >= 1 << 30 && t.m >= 1 << 30);
        CHECK_EQ(ldexp(r.m, -r.bits), b >> 1 ? b >> 1 : 1);
        CHECK_NEAR(ldexp(i.m, -i.bits) * real, 1, ldexp(1, -15) + ldexp(1, -28));
        CHECK_NEAR(ldexp(t.m, -t.bits) / ldexp(r.m, -r.bits) / ldexp(i.m, -i.bits), 1,
                   ldexp(1, -28));
        CHECK_EQ(wg_bits(a), a ? ilogb(a) + 1 : 0);
        CHECK_EQ(wg_root(a), floor(sqrt(a)));
        int16_t bits = (int16_t)((int)dice(140) - 70);
        double want = bits > 30 ? 0 : floor(ldexp((int32_t)a, -bits) + 0.5);
        CHECK_EQ(wg_scaled((int32_t)a, bits), fmax(-WG_FAR, fmin(WG_FAR, want)));
    }
}

int main(void)
{
    view.nearness = 65535u * 300u;
    TEST(triangles_side_by_side_cover_each_pixel_once);
    TEST(only_fronts_are_drawn_unless_both_sides_are);
    TEST(nearness_and_brightness_are_linear_over_the_picture);
    TEST(rectangles_show_the_same_pixels);
    TEST(lines_take_the_nearest_pixel_of_each_column);
    TEST(ratios_are_as_close_as_they_say);
    return check_done();
}
