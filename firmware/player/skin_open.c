/* Opening a clip's bones, skins, fields and paints: the one place where they are checked (SPEC
 * 4.18-4.23).
 * Source: own. Apart from open.c, so that a firmware without skins does not carry it.
 * SPDX-License-Identifier: MIT */
#include "open.h"

static uint16_t records(const wg_file *file, uint8_t kind)
{
    return file->section[kind].count;
}

static bool is_channel(const wg_file *file, uint16_t channel)
{
    return channel < records(file, WG_SECTION_CHANNELS);
}

/* |value| <= most as int32, most below 2^31. */
static bool is_within(const uint8_t *value, uint32_t most)
{
    return wg_rd32(value) + most <= 2u * most;
}

/* ---- bones and joints ------------------------------------------------------------------------- */

/* A skin's bones, and one bit a bone that is a parent. */
typedef struct {
    const uint8_t *at;
    uint16_t count;
    uint8_t parents[WG_BONES_MAX / 8u];
} bone_set;

static bool is_parent(const bone_set *bones, uint16_t bone)
{
    return ((unsigned)bones->parents[bone / 8u] >> (bone % 8u) & 1u) != 0;
}

/* Neither is a child nor has one: what FOLLOW joints move and look at. */
static bool is_free(const bone_set *bones, uint16_t bone)
{
    return wg_rd16(bones->at + (uint32_t)bone * WG_BONE_BYTES + WG_BONE_PARENT) == WG_ABSENT &&
           !is_parent(bones, bone);
}

static bool is_bone(const wg_file *file, const bone_set *bones, uint16_t index)
{
    const uint8_t *r = bones->at + (uint32_t)index * WG_BONE_BYTES;
    uint16_t parent = wg_rd16(r + WG_BONE_PARENT), value = wg_rd16(r + WG_BONE_VALUE);
    return (parent < index || parent == WG_ABSENT) &&
           wg_is_range(wg_rd16(r + WG_BONE_JOINT_FIRST), wg_rd8(r + WG_BONE_JOINT_COUNT),
                       records(file, WG_SECTION_JOINTS)) &&
           (value == WG_ABSENT || is_channel(file, value)) &&
           is_within(r + WG_BONE_ORIGIN, WG_BONE_PLACE) &&
           is_within(r + WG_BONE_ORIGIN + 4, WG_BONE_PLACE) &&
           is_within(r + WG_BONE_ORIGIN + 8, WG_BONE_PLACE) &&
           wg_rd32(r + WG_BONE_LENGTH) <= WG_BONE_PLACE;
}

static bool is_follow(const wg_file *file, const bone_set *bones, const uint8_t *joint)
{
    uint8_t count = wg_rd8(joint + WG_JOINT_COUNT);
    uint32_t data = wg_rd32(joint + WG_JOINT_DATA);
    if (count == 0 || count > WG_FOLLOW_MAX || !wg_is_data(file, data, count, 1)) {
        return false;
    }
    const uint8_t *list = file->section[WG_SECTION_DATA].at + data;
    for (uint8_t i = 0; i < count; i++) {
        uint8_t bone = wg_rd8(list + i);
        if (bone >= bones->count || !is_free(bones, bone)) {
            return false;
        }
    }
    return true;
}

static bool is_joint(const wg_file *file, const uint8_t *r)
{
    uint8_t kind = wg_rd8(r + WG_JOINT_KIND);
    uint16_t channel = wg_rd16(r + WG_JOINT_CHANNEL);
    bool good = true;
    if (kind == WG_JOINT_QUATERNION) {
        return wg_is_range(channel, 4, records(file, WG_SECTION_CHANNELS));
    }
    if (kind == WG_JOINT_TURN || kind == WG_JOINT_MOVE) {
        for (unsigned c = 0; c < 3; c++) {
            good = good && is_within(r + WG_JOINT_AXIS + 4u * c, WG_JOINT_AXIS_ONE);
        }
    }
    if (kind != WG_JOINT_MOVE && kind != WG_JOINT_STRETCH) {
        good = good && wg_rd32(r + WG_JOINT_DATA) >> 31 == 0; /* a rate */
    }
    return good && kind < WG_JOINT_FOLLOW && is_channel(file, channel);
}

static int check_joints(const wg_file *file, const bone_set *bones, uint16_t index)
{
    const uint8_t *bone = bones->at + (uint32_t)index * WG_BONE_BYTES;
    const uint8_t *joint =
        wg_record(file, WG_SECTION_JOINTS, wg_rd16(bone + WG_BONE_JOINT_FIRST), WG_JOINT_BYTES);
    for (uint8_t left = wg_rd8(bone + WG_BONE_JOINT_COUNT); left > 0; left--) {
        bool follows = wg_rd8(joint + WG_JOINT_KIND) == WG_JOINT_FOLLOW;
        if (follows ? left > 1 || !is_free(bones, index) || !is_follow(file, bones, joint)
                    : !is_joint(file, joint)) {
            return WG_ERR_JOINT;
        }
        joint += WG_JOINT_BYTES;
    }
    return 0;
}

static int check_bones(const wg_file *file, const uint8_t *skin)
{
    bone_set bones = {
        wg_record(file, WG_SECTION_BONES, wg_rd16(skin + WG_SKIN_BONE_FIRST), WG_BONE_BYTES),
        wg_rd16(skin + WG_SKIN_BONE_COUNT),
        {0}};
    for (uint16_t i = 0; i < bones.count; i++) {
        uint16_t parent = wg_rd16(bones.at + (uint32_t)i * WG_BONE_BYTES + WG_BONE_PARENT);
        if (!is_bone(file, &bones, i)) {
            return WG_ERR_BONE;
        }
        if (parent != WG_ABSENT) {
            bones.parents[parent / 8u] = (uint8_t)(bones.parents[parent / 8u] | 1u << parent % 8u);
        }
    }
    int err = 0;
    for (uint16_t i = 0; i < bones.count && err == 0; i++) {
        err = check_joints(file, &bones, i);
    }
    return err;
}

/* ---- skins and spans -------------------------------------------------------------------------- */

static const uint8_t *shape_record(const wg_file *file, uint16_t shape)
{
    return wg_record(file, WG_SECTION_SHAPES, shape, WG_SHAPE_BYTES);
}

static const uint8_t *skin_record(const wg_file *file, uint16_t skin)
{
    return wg_record(file, WG_SECTION_SKINS, skin, WG_SKIN_BYTES);
}

/* Whether one of the first `count` skins is the shape's. */
static bool has_skin(const wg_file *file, uint16_t shape, uint16_t count)
{
    for (uint16_t i = 0; i < count; i++) {
        if (wg_rd16(skin_record(file, i) + WG_SKIN_SHAPE) == shape) {
            return true;
        }
    }
    return false;
}

static bool has_normals(const wg_file *file, uint16_t shape)
{
    for (uint16_t i = 0; i < records(file, WG_SECTION_PARTS); i++) {
        const uint8_t *part = wg_record(file, WG_SECTION_PARTS, i, WG_PART_BYTES);
        if (wg_rd16(part + WG_PART_SHAPE) == shape &&
            wg_rd16(part + WG_PART_NORMALS) != WG_ABSENT) {
            return true;
        }
    }
    return false;
}

static bool is_skin(const wg_file *file, uint16_t index)
{
    const uint8_t *r = skin_record(file, index);
    uint16_t shape = wg_rd16(r + WG_SKIN_SHAPE), bones = wg_rd16(r + WG_SKIN_BONE_COUNT);
    uint8_t method = wg_rd8(r + WG_SKIN_METHOD), ends = wg_rd8(r + WG_SKIN_ENDS);
    return shape < records(file, WG_SECTION_SHAPES) && !has_skin(file, shape, index) &&
           wg_rd16(shape_record(file, shape) + WG_SHAPE_AFFINE) == WG_ABSENT &&
           !has_normals(file, shape) && method <= WG_SKIN_SHIFT &&
           ends <= (method == WG_SKIN_SHIFT ? 0 : 1) && bones > 0 && bones <= WG_BONES_MAX &&
           wg_is_range(wg_rd16(r + WG_SKIN_BONE_FIRST), bones, records(file, WG_SECTION_BONES)) &&
           wg_is_range(wg_rd16(r + WG_SKIN_SPAN_FIRST), wg_rd16(r + WG_SKIN_SPAN_COUNT),
                       records(file, WG_SECTION_SPANS));
}

/* Every vertex has bones of the skin, and weights that sum to 255. */
static bool is_influences(const wg_file *file, const uint8_t *skin, const uint8_t *span)
{
    const uint8_t *at = file->section[WG_SECTION_DATA].at + wg_rd32(span + WG_SPAN_DATA);
    uint16_t bones = wg_rd16(skin + WG_SKIN_BONE_COUNT);
    uint8_t each = (uint8_t)(2u + wg_rd8(skin + WG_SKIN_ENDS));
    for (uint16_t left = wg_rd16(span + WG_SPAN_COUNT); left > 0; left--) {
        uint16_t sum = 0;
        for (uint8_t n = wg_rd8(span + WG_SPAN_INFLUENCES); n > 0; n--) {
            if (wg_rd8(at) >= bones) {
                return false;
            }
            sum = (uint16_t)(sum + wg_rd8(at + 1));
            at += each;
        }
        if (sum != WG_WEIGHT_SUM) {
            return false;
        }
    }
    return true;
}

/* A span that starts at vertex `first`. */
static bool is_span(const wg_file *file, const uint8_t *skin, const uint8_t *r, uint32_t first)
{
    uint16_t count = wg_rd16(r + WG_SPAN_COUNT);
    uint8_t influences = wg_rd8(r + WG_SPAN_INFLUENCES);
    uint32_t each = 2u + (uint32_t)wg_rd8(skin + WG_SKIN_ENDS);
    return wg_rd16(r + WG_SPAN_FIRST) == first && count > 0 && influences > 0 &&
           influences <= WG_INFLUENCES_MAX &&
           wg_is_data(file, wg_rd32(r + WG_SPAN_DATA), each * influences * count, 1) &&
           is_influences(file, skin, r);
}

/* They follow each other from the first vertex to the last. */
static int check_spans(const wg_file *file, const uint8_t *skin)
{
    uint32_t vertices =
        wg_rd16(shape_record(file, wg_rd16(skin + WG_SKIN_SHAPE)) + WG_SHAPE_VERTICES);
    const uint8_t *span =
        wg_record(file, WG_SECTION_SPANS, wg_rd16(skin + WG_SKIN_SPAN_FIRST), WG_SPAN_BYTES);
    uint32_t first = 0;
    for (uint16_t left = wg_rd16(skin + WG_SKIN_SPAN_COUNT); left > 0; left--) {
        if (first >= vertices || !is_span(file, skin, span, first)) {
            return WG_ERR_SPAN;
        }
        first += wg_rd16(span + WG_SPAN_COUNT);
        span += WG_SPAN_BYTES;
    }
    return first == vertices ? 0 : WG_ERR_SPAN;
}

static int check_skins(const wg_file *file)
{
    int err = 0;
    for (uint16_t i = 0; i < records(file, WG_SECTION_SKINS) && err == 0; i++) {
        const uint8_t *r = skin_record(file, i);
        err = is_skin(file, i) ? check_bones(file, r) : WG_ERR_SKIN;
        if (err == 0) {
            err = check_spans(file, r);
        }
    }
    return err;
}

/* ---- fields and paints ------------------------------------------------------------------------ */

static bool is_field(const wg_file *file, const uint8_t *r)
{
    uint8_t count = wg_rd8(r + WG_FIELD_COUNT);
    uint32_t data = wg_rd32(r + WG_FIELD_DATA);
    uint16_t sum = 0;
    if (!is_channel(file, wg_rd16(r + WG_FIELD_CHANNEL)) || count == 0 ||
        !wg_is_data(file, data, 3u * (uint32_t)count, 2)) {
        return false;
    }
    const uint8_t *from = file->section[WG_SECTION_DATA].at + data;
    for (uint8_t i = 0; i < count; i++) {
        if (!is_channel(file, wg_rd16(from + 2u * i))) {
            return false;
        }
        sum = (uint16_t)(sum + wg_rd8(from + 2u * count + i)); /* at most 255 255 */
    }
    return sum == WG_WEIGHT_SUM;
}

static int check_fields(const wg_file *file)
{
    for (uint16_t i = 0; i < records(file, WG_SECTION_FIELDS); i++) {
        if (!is_field(file, wg_record(file, WG_SECTION_FIELDS, i, WG_FIELD_BYTES))) {
            return WG_ERR_FIELD;
        }
    }
    return 0;
}

static bool is_picture(const wg_file *file, const uint8_t *r)
{
    uint16_t width = wg_rd16(r + WG_PAINT_WIDTH), height = wg_rd16(r + WG_PAINT_HEIGHT);
    return width > 0 && width <= WG_TEXELS_MAX && height > 0 && height <= WG_TEXELS_MAX &&
           wg_is_data(file, wg_rd32(r + WG_PAINT_TEXELS), (uint32_t)width * height, 1);
}

static bool is_paint(const wg_file *file, uint16_t index)
{
    const uint8_t *first = file->section[WG_SECTION_PAINTS].at;
    const uint8_t *r = first + (uint32_t)index * WG_PAINT_BYTES;
    uint16_t part = wg_rd16(r + WG_PAINT_PART);
    uint8_t kind = wg_rd8(r + WG_PAINT_KIND);
    for (; first < r; first += WG_PAINT_BYTES) { /* <= 63 */
        if (wg_rd16(first + WG_PAINT_PART) == part) {
            return false;
        }
    }
    if (part >= records(file, WG_SECTION_PARTS) || kind > WG_PAINT_PICTURE ||
        !wg_is_data(file, wg_rd32(r + WG_PAINT_PALETTE), WG_PALETTE_BYTES, 1)) {
        return false;
    }
    const uint8_t *of = wg_record(file, WG_SECTION_PARTS, part, WG_PART_BYTES);
    return kind == WG_PAINT_PICTURE
               ? is_picture(file, r)
               : has_skin(file, wg_rd16(of + WG_PART_SHAPE), records(file, WG_SECTION_SKINS));
}

static int check_paints(const wg_file *file)
{
    for (uint16_t i = 0; i < records(file, WG_SECTION_PAINTS); i++) {
        if (!is_paint(file, i)) {
            return WG_ERR_PAINT;
        }
    }
    return 0;
}

int wg_open_skins(const wg_file *file)
{
    int err = check_skins(file);
    if (err == 0) {
        err = check_fields(file);
    }
    return err == 0 ? check_paints(file) : err;
}
