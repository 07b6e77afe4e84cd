/* Camera, projection and light of a picture.
 * Source: own; the conventions are SPEC 4.17.
 * SPDX-License-Identifier: MIT */
#include "view.h"

#include "clip.h"
#include "fix.h"

/* A channel of the view: raw / 2^frac. */
typedef struct {
    int32_t raw;
    int8_t frac;
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

/* Z X Y, row-major (SPEC 4.17). */
static void set_turn(const source *from, int32_t *turn)
{
    fix_turn yaw = turn_of(from, WG_VIEW_YAW), pitch = turn_of(from, WG_VIEW_PITCH);
    fix_turn roll = turn_of(from, WG_VIEW_ROLL);
    int32_t right[3] = {yaw.cosine, 0, -yaw.sine};
    int32_t up[3] = {-product(pitch.sine, yaw.sine), pitch.cosine,
                     -product(pitch.sine, yaw.cosine)};
    for (unsigned i = 0; i < 3; i++) {
        turn[i] = product(roll.cosine, right[i]) + product(roll.sine, up[i]);
        turn[3 + i] = product(roll.cosine, up[i]) - product(roll.sine, right[i]);
    }
    turn[6] = product(pitch.cosine, yaw.sine);
    turn[7] = pitch.sine;
    turn[8] = product(pitch.cosine, yaw.cosine);
}

/* The target with as many fraction bits as all three coordinates have room for. */
static void set_centre(const source *from, wg_rigid *camera)
{
    number n[3];
    int16_t frac = 30;
    for (unsigned i = 0; i < 3; i++) {
        n[i] = channel_of(from, WG_VIEW_X + i);
        int16_t most = (int16_t)(n[i].frac + 30 - wg_bits(wg_magnitude(n[i].raw)));
        if (n[i].raw != 0 && most < frac) {
            frac = most;
        }
    }
    for (unsigned i = 0; i < 3; i++) {
        int32_t raw = wg_scaled(n[i].raw, (int16_t)(n[i].frac - frac));
        camera->centre[i] = fix_clamp(raw, 1 - WG_FAR, WG_FAR - 1);
    }
    camera->centre_frac = (int8_t)frac;
}

/* Distance, scale and focal length; h = 16 height / size. */
static void set_scale(wg_view *view, const source *from, uint16_t height)
{
    number distance = channel_of(from, WG_VIEW_DISTANCE), size = channel_of(from, WG_VIEW_SIZE);
    uint32_t far = distance.raw < 1 ? 1 : (uint32_t)distance.raw;
    uint8_t n = wg_bits(far);
    view->distance = (int32_t)(n > 25 ? far >> (n - 25) : far << (25 - n));
    view->fine_bits = (int16_t)(distance.frac + 25 - n);
    view->scale = wg_ratio_times(wg_ratio_of(16 * (uint32_t)height),
                                 wg_ratio_inverse(size.raw < 1 ? 1 : (uint32_t)size.raw));
    view->scale.bits = (int16_t)(view->scale.bits - size.frac + view->fine_bits);
    view->focal = wg_ratio_times(view->scale, wg_ratio_of((uint32_t)view->distance));
    view->inverse = wg_ratio_inverse((uint32_t)view->distance);
    view->inverse.bits = (int16_t)(view->inverse.bits - 15);
}

/* What a vertex may be off the middle, so that its place in the picture stays within +-16383, and
 * the planes that the clipper cuts at. A vertex within the limit is on the inner side of every
 * plane: one pixel is more than all roundings. */
static void set_limits(wg_view *view, wg_size size)
{
    uint16_t longer = size.width > size.height ? size.width : size.height;
    int32_t room = 16383 - 32 - 8 * (int32_t)longer;
    int32_t quarters = (view->distance >> 10) + 1;
    bool flat = WG_VIEW_IS_FLAT(view);
    view->guard = (int16_t)(flat ? 0 : 8 * room / quarters);
    view->edge = flat ? 8 * room : 0;
    view->limit = (int16_t)((flat ? room : view->guard * (quarters - 1) / 8) - 16);
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
    /* 65535 at distance / 16, which is 256..511 steps, 512 or more at the last step. */
    view->nearness = UINT32_C(65535) * (uint32_t)(view->distance >> 16);
    if (wg_rd8(from.record + WG_VIEW_PROJECTION) == WG_ORTHOGRAPHIC) {
        view->nearness = 0;
    }
    set_limits(view, size);
    for (unsigned i = 0; i < 3; i++) {
        view->light[i] = (int8_t)wg_rd8(from.record + WG_VIEW_LIGHT + i);
    }
    view->ambient = wg_rd8(from.record + WG_VIEW_AMBIENT);
}

/* A vertex that is too near, or too far off: coordinates times 8^-e, e = 0..3 in bits 14..13 of z.
 * What is still too large is moved towards the eye, which leaves it where it is seen. */
static wg_vertex outside(const wg_view *view, int32_t x, int32_t y, int32_t depth)
{
    wg_ratio spot = view->scale;
    spot.bits = (int16_t)(spot.bits - 3);
    x = wg_ratio_mul(x, spot);
    y = wg_ratio_mul(y, spot);
    depth >>= 10;
    uint8_t e = 0;
    for (; e < 9; e++) { /* |x|, |y| <= 2^30 fit at 2^15, |depth| < 2^21 fits at 2^9 */
        int32_t rest = (wg_shr(depth, 3u * e) + 4096) >> 13;
        if ((wg_shr(x, 3u * e) + 32768) >> 16 == 0 && (wg_shr(y, 3u * e) + 32768) >> 16 == 0 &&
            rest == 0) {
            break;
        }
    }
    uint16_t z = (uint16_t)((uint16_t)wg_shr(depth, 3u * e) & 0x1fffu);
    wg_vertex v = {(int16_t)wg_shr(x, 3u * e), (int16_t)wg_shr(y, 3u * e),
                   (uint16_t)(0x8000u | (uint16_t)((e > 3 ? 3u : e) << 13) | z)};
    return v;
}

static wg_vertex project(const wg_view *view, int32_t x, int32_t y, int32_t depth)
{
    if (depth >= view->distance >> 4) {
        wg_ratio f = view->scale;
        if (!WG_VIEW_IS_FLAT(view)) {
            f = wg_ratio_times(view->focal, wg_ratio_inverse((uint32_t)depth));
        }
        int32_t right = wg_ratio_mul(x, f), up = wg_ratio_mul(y, f);
        if (right <= view->limit && right >= -view->limit && up <= view->limit &&
            up >= -view->limit) {
            int32_t z = (depth + 2048) >> 12;
            wg_vertex v = {(int16_t)(view->x + right), (int16_t)(view->y - up),
                           (uint16_t)(z > 0x7fff ? 0x7fff : z)};
            return v;
        }
    }
    return outside(view, x, y, depth);
}

void wg_view_project(const wg_view *view, int8_t frac, const int32_t *xyz, uint16_t count,
                     wg_vertex *vertices)
{
    int16_t bits = (int16_t)(frac + (int)WG_POSE_BITS - view->fine_bits);
    for (uint16_t i = 0; i < count; i++, xyz += 3) {
        vertices[i] = project(view, wg_scaled(xyz[0], bits), wg_scaled(xyz[1], bits),
                              view->distance - wg_scaled(xyz[2], bits));
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
    int32_t x = vertex->x - (int32_t)view->x, y = (int32_t)view->y - vertex->y;
    at[2] = (int32_t)vertex->z << 2;
    if (WG_VIEW_IS_FLAT(view)) {
        at[0] = 8 * x;
        at[1] = 8 * y;
    } else {
        at[0] = wg_ratio_mul(x * (int32_t)vertex->z, view->inverse);
        at[1] = wg_ratio_mul(y * (int32_t)vertex->z, view->inverse);
    }
}

wg_vertex wg_view_seen(const wg_view *view, const int32_t *at)
{
    int32_t x, y, z = (at[2] + 2) >> 2;
    if (WG_VIEW_IS_FLAT(view)) {
        x = fix_round(at[0], 3);
        y = fix_round(at[1], 3);
    } else {
        wg_ratio f = wg_ratio_of((uint32_t)view->distance); /* 2^13 quarters of a step / 8 */
        f = wg_ratio_times(f, wg_ratio_inverse((uint32_t)at[2]));
        f.bits = (int16_t)(f.bits + 13);
        x = wg_ratio_mul(at[0], f);
        y = wg_ratio_mul(at[1], f);
    }
    wg_vertex v = {(int16_t)(view->x + x), (int16_t)(view->y - y),
                   (uint16_t)(z > 0x7fff ? 0x7fff : z)};
    return v;
}

/* to - from without the bits that do not fit in 15; returns how many those are. */
static uint8_t edge_of(const int32_t *from, const int32_t *to, int32_t *edge)
{
    uint32_t most = 0;
    for (unsigned i = 0; i < 3; i++) {
        edge[i] = to[i] - from[i];
        most |= wg_magnitude(edge[i]);
    }
    edge[2] = -edge[2]; /* depth to z */
    uint8_t n = wg_bits(most), down = n > 15 ? (uint8_t)(n - 15) : 0;
    for (unsigned i = 0; i < 3; i++) {
        edge[i] = wg_shr(edge[i], down);
    }
    return down;
}

uint8_t wg_view_face(const wg_view *view, const int32_t at[3][3], int32_t *normal)
{
    int32_t p[3], q[3];
    uint8_t down = edge_of(at[0], at[1], p);
    down = (uint8_t)(down + edge_of(at[0], at[2], q));
    /* |p|, |q| <= 32768: floor(-32767.5) may round there, but then not both products are 2^30. */
    int32_t x = fix_sub(p[1] * q[2], p[2] * q[1]), y = fix_sub(p[2] * q[0], p[0] * q[2]);
    int32_t z = fix_sub(p[0] * q[1], p[1] * q[0]);
    /* Spots are `scale` 2^13 times finer across than deep, so a normal is longer across by that. */
    int16_t up = (int16_t)(45 - view->scale.bits);
    x = fix_mulh(x, view->scale.m);
    y = fix_mulh(y, view->scale.m);
    normal[0] = up < 0 ? wg_scaled(x, (int16_t)-up) : x;
    normal[1] = up < 0 ? wg_scaled(y, (int16_t)-up) : y;
    normal[2] = up > 0 ? wg_scaled(z, up) : z;
    return down;
}
