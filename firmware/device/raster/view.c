/* Camera, projection and light of a picture.
 * Source: own; the conventions are SPEC 4.17.
 * SPDX-License-Identifier: MIT */
#include "view.h"

#include "clip.h"
#include "fix.h"

/* A channel of the view: raw / 2^frac. */
typedef struct {
    int32_t raw;
    int frac;
} number;

/* The record, and the values of all channels. */
typedef struct {
    const wg_file *file;
    const uint8_t *record;
    const int32_t *values;
} source;

static number channel_of(const source *from, unsigned which)
{
    uint16_t channel = wg_rd16(from->record + WG_VIEW_CHANNEL + 2u * which);
    const uint8_t *at = wg_record(from->file, WG_SECTION_CHANNELS, channel, WG_CHANNEL_BYTES);
    number n = {fix_clamp(from->values[channel], -FIX_VALUE_MAX, FIX_VALUE_MAX),
                (int8_t)wg_rd8(at + WG_CHANNEL_FRAC)};
    return n;
}

/* Degrees to turns / 2^32. 2^39/360 has 31 bits; what does not fit beside the fraction bits goes
 * first: the phase is off by raw 2^-16 at the most, 2^-19 turns. */
static fix_turn turn_of(const source *from, unsigned which)
{
    number n = channel_of(from, which);
    int32_t per_degree = INT32_C(1527099483);
    uint32_t phase = n.frac > 9 ? wg_mulsm(n.raw, wg_shr(per_degree, (unsigned)(n.frac - 9)))
                                : wg_mulsm(n.raw, per_degree);
    if (n.frac < 9) {
        phase = 9 - n.frac > 31 ? 0 : phase << (9 - n.frac);
    }
    return fix_sincos(phase);
}

/* a b of two numbers in Q30, within 2^-28. */
static int32_t product(int32_t a, int32_t b)
{
    return fix_shl(fix_mulh(a, b), 2);
}

/* Z X Y, row-major (SPEC 4.17): each turns two rows of what is to its right. */
static void set_turn(const source *from, int32_t *turn)
{
    for (unsigned i = 0; i < 9; i++) {
        turn[i] = i % 4u == 0 ? WG_FAR : 0;
    }
    for (unsigned i = 0; i < 3; i++) {
        fix_turn by = turn_of(from, WG_VIEW_YAW + i);
        int32_t *p = turn + (i == 0 ? 0 : 3), *q = turn + (i == 2 ? 0 : 6);
        for (unsigned k = 0; k < 3; k++) {
            int32_t a = p[k], b = q[k];
            p[k] = product(by.cosine, a) - product(by.sine, b);
            q[k] = product(by.sine, a) + product(by.cosine, b);
        }
    }
}

/* The target with as many fraction bits as all three coordinates have room for. */
static void set_centre(const source *from, wg_rigid *camera)
{
    number n[3];
    int frac = 30;
    for (unsigned i = 0; i < 3; i++) {
        n[i] = channel_of(from, WG_VIEW_X + i);
        int most = n[i].frac + 30 - wg_bits(wg_magnitude(n[i].raw));
        frac = n[i].raw != 0 && most < frac ? most : frac;
    }
    camera->centre_frac = (int8_t)frac;
    for (unsigned i = 0; i < 3; i++) { /* |raw| < 2^30 */
        camera->centre[i] = wg_scaled(n[i].raw, n[i].frac - frac);
    }
}

static uint32_t length_of(number n)
{
    return n.raw < 1 ? 1 : (uint32_t)n.raw;
}

static void set_scale(wg_view *view, const source *from, uint16_t height)
{
    number distance = channel_of(from, WG_VIEW_DISTANCE), size = channel_of(from, WG_VIEW_SIZE);
    wg_ratio_set(&view->focal, length_of(distance));
    view->distance = view->focal.m >> 6;
    view->fine_bits = distance.frac + view->focal.bits - 6;
    wg_ratio_set(&view->scale, 16 * (uint32_t)height);
    wg_ratio_divide(&view->scale, length_of(size));
    view->scale.bits += view->fine_bits - size.frac;
    view->focal.bits = 6;
    wg_ratio_times(&view->focal, &view->scale);
    view->inverse = (int32_t)wg_inverse((unsigned)(view->distance >> 9)) << 11;
}

/* How far a vertex may be off the middle, so that its place in the picture stays within +-16383, and
 * the planes that the clipper cuts at. A vertex within the limit is on the inner side of every
 * plane: one pixel is more than all roundings. */
static void set_limits(wg_view *view, wg_size size)
{
    int32_t longer = size.width > size.height ? size.width : size.height;
    int32_t room = 16383 - 32 - 8 * longer, quarters = view->distance >> 10;
    view->edge = 8 * room;
    view->guard = 0;
    if (!WG_VIEW_IS_FLAT(view)) {
        view->guard = (int16_t)(view->edge / (quarters + 1));
        view->edge = 0;
        room = view->guard * quarters / 8;
    }
    view->limit = (int16_t)(room - 16);
    view->x = (int16_t)(8 * size.width);
    view->y = (int16_t)(8 * size.height);
}

void wg_view_set(wg_view *view, const wg_file *file, uint8_t index, const int32_t *values,
                 wg_size size)
{
    const source from = {file, wg_record(file, WG_SECTION_VIEWS, index, WG_VIEW_BYTES), values};
    set_turn(&from, view->camera.turn_q30);
    set_centre(&from, &view->camera);
    set_scale(view, &from, size.height);
    /* 65024 at distance / 16, which is 256..511 steps, 508 or more at the last step. Not 65535: a slope
     * that is off by 2^-15 goes beyond its corner by 2, a sliver's by more, and that must not wrap. */
    view->nearness = 0;
    if (wg_rd8(from.record + WG_VIEW_PROJECTION) != WG_ORTHOGRAPHIC) {
        view->nearness = UINT32_C(65024) * (uint32_t)(view->distance >> 16);
    }
    set_limits(view, size);
    for (unsigned i = 0; i < 3; i++) {
        view->light[i] = (int8_t)wg_rd8(from.record + WG_VIEW_LIGHT + i);
    }
    view->ambient = wg_rd8(from.record + WG_VIEW_AMBIENT);
}

/* A vertex that is too near, or too far off: coordinates times 8^-e, e = 0..3 in bits 14..13 of z.
 * What is still too large is moved towards the eye, which leaves it where it is seen. */
static void keep_outside(const wg_view *view, const int32_t *at, wg_vertex *v)
{
    wg_ratio spot = view->scale;
    spot.bits -= 3;
    int32_t to[3] = {wg_ratio_mul(at[0], &spot), wg_ratio_mul(at[1], &spot), at[2] >> 10};
    unsigned e = 0;
    /* |x|, |y| <= 2^30 fit after 6 steps, |depth| < 2^21 after 3. */
    for (;
         e < 6 && (to[0] != (int16_t)to[0] || to[1] != (int16_t)to[1] || (to[2] + 4096) >> 13 != 0);
         e++) {
        to[0] >>= 3;
        to[1] >>= 3;
        to[2] >>= 3;
    }
    v->x = (int16_t)to[0];
    v->y = (int16_t)to[1];
    v->z = (uint16_t)(0x8000u | (uint16_t)((e > 3 ? 3u : e) << 13) | ((uint16_t)to[2] & 0x1fffu));
}

/* Puts it at `at` times f; returns whether that lies within the limit. */
static bool place(const wg_view *view, const int32_t *at, const wg_ratio *f, wg_vertex *v)
{
    int32_t x = wg_ratio_mul(at[0], f), y = wg_ratio_mul(at[1], f);
    v->x = (int16_t)(view->x + x);
    v->y = (int16_t)(view->y - y);
    return wg_magnitude(x) <= (uint32_t)view->limit && wg_magnitude(y) <= (uint32_t)view->limit;
}

/* `at`: x, y in fine units and depth, all divided by 2^over. */
static void project(const wg_view *view, const int32_t *at, int over, wg_vertex *v)
{
    if (at[2] > 0 && at[2] >= wg_scaled(view->distance, over + 4)) {
        wg_ratio f = view->scale;
        f.bits -= over;
        if (!WG_VIEW_IS_FLAT(view)) {
            f = view->focal;
            wg_ratio_divide(&f, (uint32_t)at[2]);
        }
        if (place(view, at, &f, v)) {
            int32_t z = wg_scaled(at[2], 12 - over);
            /* A depth that is counted coarsely may come out nearer than the nearest plane. */
            v->z = (uint16_t)fix_clamp(z, view->distance >> 16, 0x7fff);
            return;
        }
    }
    keep_outside(view, at, v);
}

void wg_view_project(const wg_view *view, int8_t frac, const int32_t *xyz, uint16_t count,
                     wg_vertex *vertices)
{
    int bits = frac + (int)WG_POSE_BITS - view->fine_bits;
    for (; count > 0; count--, xyz += 3, vertices++) {
        int over = wg_bits_3(xyz) - bits - 29; /* beyond 16 to 32 distances */
        over = over > 0 ? over : 0;
        int down = bits + over;
        const int32_t at[3] = {wg_scaled(xyz[0], down), wg_scaled(xyz[1], down),
                               wg_scaled(view->distance, over) - wg_scaled(xyz[2], down)};
        project(view, at, over, vertices);
    }
}

void wg_view_spot(const wg_view *view, const wg_vertex *vertex, int32_t *at)
{
    if (vertex->z & 0x8000u) {
        unsigned up = 3u * (vertex->z >> 13 & 3u);
        at[0] = fix_shl(vertex->x, up);
        at[1] = fix_shl(vertex->y, up);
        at[2] = fix_shl((int16_t)(uint16_t)(vertex->z << 3) >> 3, up);
        return;
    }
    int32_t z = vertex->z;
    at[0] = 8 * ((int32_t)vertex->x - view->x);
    at[1] = 8 * ((int32_t)view->y - vertex->y);
    at[2] = 4 * z;
    if (!WG_VIEW_IS_FLAT(view)) { /* |x| z < 2^29 */
        for (unsigned i = 0; i < 2; i++) {
            at[i] = fix_round(fix_mulh((at[i] >> 2) * z, view->inverse), 6);
        }
    }
}

void wg_view_seen(const wg_view *view, const int32_t *at, wg_vertex *vertex)
{
    wg_ratio f = {WG_FAR, 33}; /* 1/8 */
    if (!WG_VIEW_IS_FLAT(view)) {
        f.m = view->distance << 6; /* quarters of a step, / 8 */
        f.bits = 19;
        wg_ratio_divide(&f, (uint32_t)at[2]);
    }
    int32_t z = (at[2] + 2) >> 2;
    place(view, at, &f, vertex);
    vertex->z = (uint16_t)(z > 0x7fff ? 0x7fff : z);
}

int wg_view_face(const wg_view *view, const wg_vertex *const *vertices, int32_t *normal)
{
    int32_t from[3], edge[2][3];
    int down = 0;
    wg_view_spot(view, vertices[0], from);
    for (unsigned i = 0; i < 2; i++) {
        int32_t *e = edge[i];
        wg_view_spot(view, vertices[i + 1], e);
        e[0] -= from[0];
        e[1] -= from[1];
        e[2] = from[2] - e[2]; /* depth to z */
        int n = wg_bits_3(e), over = n > 15 ? n - 15 : 0;
        for (unsigned k = 0; k < 3;
             k++) { /* -2^15 .. 2^15 - 1: the products below differ by < 2^31 */
            e[k] = wg_shr(e[k], (unsigned)over);
        }
        down += over;
    }
    const int32_t *p = edge[0], *q = edge[1];
    /* Spots are `scale` 2^13 times finer across than deep: a normal is as many times longer there. */
    int up = 45 - view->scale.bits, less = up < 0 ? -up : 0;
    normal[0] = wg_scaled(fix_mulh(p[1] * q[2] - p[2] * q[1], view->scale.m), less);
    normal[1] = wg_scaled(fix_mulh(p[2] * q[0] - p[0] * q[2], view->scale.m), less);
    normal[2] = wg_scaled(p[0] * q[1] - p[1] * q[0], up > 0 ? up : 0);
    return down;
}
