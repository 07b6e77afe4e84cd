/* Opening skins: what must be rejected is, with the code that names the section, and nothing outside
 * the clip is read, then or when bones and vertices are made (exact-size heap blocks, DATA at their
 * end).
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "skin_samples.h"
#include "wiggly.h"

#define CHANNELS SAMPLE_SKIN_CHANNELS

static uint8_t *entry_of(uint8_t *clip, unsigned kind)
{
    uint8_t *entry = clip + WG_HEADER_BYTES;
    while (build_get(entry, 2) != kind) {
        entry += WG_DIRECTORY_BYTES;
    }
    return entry;
}

/* The same clip with `cut` bytes fewer in DATA, which ends where the heap block ends. */
static uint8_t *data_last(uint8_t *clip, uint32_t size, uint32_t cut, uint32_t *out_size)
{
    uint8_t *entry = entry_of(clip, WG_SECTION_DATA);
    uint32_t at = build_get(entry + 4, 4), bytes = build_get(entry + 8, 4) - cut;
    *out_size = size + bytes;
    uint8_t *out = malloc(*out_size);
    memcpy(out, clip, size);
    memcpy(out + size, clip + at, bytes);
    entry = entry_of(out, WG_SECTION_DATA);
    build_put(entry + 4, 4, size);
    build_put(entry + 8, 4, bytes);
    build_put(out + WG_HEADER_LENGTH, 4, *out_size);
    build_seal(out, *out_size);
    return out;
}

static int open_all(wg_file *file, const uint8_t *clip, uint32_t size)
{
    int err = wg_open(file, clip, size);
    err = err == 0 ? wg_open_shapes(file) : err;
    return err == 0 ? wg_open_skins(file) : err;
}

static void skin_everything(const wg_file *file)
{
    int32_t values[CHANNELS], xyz[3 * SAMPLE_SKIN_VERTICES];
    int16_t weights[WG_BASES_MAX];
    uint8_t lights[SAMPLE_SKIN_VERTICES];
    wg_bone bones[SAMPLE_SKIN_BONES];
    wg_pose pose;
    wg_skin skin;
    wg_clip_sample(file, 0, 700000, values, NULL);
    wg_fields_set(file, values);
    for (uint8_t s = 0; s < SAMPLE_SKIN_SHAPES; s++) {
        if (!wg_skin_init(&skin, file, s, bones)) {
            continue;
        }
        wg_pose_init(&pose, file, s, weights);
        wg_pose_set(&pose, values, WG_BASES_MAX, NULL);
        wg_skin_set(&skin, values, NULL);
        for (uint16_t first = 0; first < pose.vertices; first++) {
            for (uint16_t count = 1; first + count <= pose.vertices; count++) {
                wg_skin_vertices(&skin, &pose, first, count, xyz);
                wg_skin_brightness(&skin, values, first, count, lights);
            }
        }
    }
}

static void accepts_and_poses_every_kind(void)
{
    uint32_t size, last_size;
    uint8_t *clip = sample_skins_file(&size), *last = data_last(clip, size, 0, &last_size);
    static const uint16_t COUNT[] = {8, 11, 3, 4, 2, 2};
    wg_file file;
    CHECK_EQ(open_all(&file, last, last_size), 0);
    for (unsigned k = 0; k < 6; k++) {
        CHECK_EQ(file.section[WG_SECTION_BONES + k].count, COUNT[k]);
    }
    skin_everything(&file);
    free(last);
    free(clip);
}

/* A clip of before 1.2. */
static void accepts_a_clip_without_skins(void)
{
    build b = {{{0}}, 0};
    uint32_t size;
    wg_bone bones[1];
    wg_file file;
    wg_skin skin;
    int32_t value = 5;
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 1000, 1000, WG_END_HOLD);
    uint8_t *clip = build_finish(&b, &size);
    CHECK_EQ(open_all(&file, clip, size), 0);
    CHECK(!wg_skin_init(&skin, &file, 0, bones));
    wg_fields_set(&file, &value);
    CHECK_EQ(value, 5);
    free(clip);
}

/* Runs and shapes come first in DATA: they stay whole, and each cut takes something of skins. */
static void rejects_data_cut_at_every_byte(void)
{
    uint32_t size, cut_size;
    uint8_t *clip = sample_skins_file(&size);
    wg_file file;
    uint32_t first = build_get(clip + build_where(clip, WG_SECTION_SPANS, 0) + WG_SPAN_DATA, 4);
    uint32_t bytes = build_get(entry_of(clip, WG_SECTION_DATA) + 8, 4);
    CHECK(bytes - first > 1600);
    for (uint32_t cut = 1; cut <= bytes - first; cut++) {
        uint8_t *copy = data_last(clip, size, cut, &cut_size);
        CHECK_EQ(wg_open(&file, copy, cut_size), 0);
        CHECK_EQ(wg_open_shapes(&file), 0);
        CHECK(wg_open_skins(&file) < 0);
        free(copy);
    }
    free(clip);
}

/* ---- one field at a time: its limits, and one step beyond --------------------------------------- */

/* Field of record `index` of section `kind`. 100 + kind: of the directory's entry; 200: byte `index`
 * of the bytes in DATA that span 0 starts (field 0), that field 0 lists (1), that FOLLOW lists (2). */
typedef struct {
    uint8_t kind, index, field, bytes;
    uint32_t value;
    int want;
} change;

static uint8_t *place_of(uint8_t *copy, const change *c)
{
    static const uint8_t OF[3][3] = {{WG_SECTION_SPANS, 0, WG_SPAN_DATA},
                                     {WG_SECTION_FIELDS, 0, WG_FIELD_DATA},
                                     {WG_SECTION_JOINTS, 8, WG_JOINT_DATA}};
    if (c->kind == 200) {
        const uint8_t *of = OF[c->field];
        uint32_t data = build_get(copy + build_where(copy, of[0], of[1]) + of[2], 4);
        return copy + build_get(entry_of(copy, WG_SECTION_DATA) + 4, 4) + data + c->index;
    }
    return c->kind > 100 ? entry_of(copy, c->kind - 100u) + c->field
                         : copy + build_where(copy, c->kind, c->index) + c->field;
}

static void check_changes(const change *changes, unsigned count)
{
    uint32_t size, last_size;
    uint8_t *clip = sample_skins_file(&size);
    for (unsigned i = 0; i < count; i++) {
        const change *c = &changes[i];
        uint8_t *copy = build_copy(clip, size);
        build_put(place_of(copy, c), c->bytes, c->value);
        uint8_t *last = data_last(copy, size, 0, &last_size);
        wg_file file;
        int err = open_all(&file, last, last_size);
        if (err != c->want) {
            printf("change %u: section %u record %u field %u = %#lx\n", i, c->kind, c->index,
                   c->field, (unsigned long)c->value);
        }
        CHECK_EQ(err, c->want);
        if (err == 0) {
            skin_everything(&file);
        }
        free(last);
        free(copy);
    }
    free(clip);
}

#define CHECK_CHANGES(list) check_changes(list, sizeof list / sizeof *list)

#define BONES  WG_SECTION_BONES
#define JOINTS WG_SECTION_JOINTS
#define SKINS  WG_SECTION_SKINS
#define SPANS  WG_SECTION_SPANS
#define FIELDS WG_SECTION_FIELDS
#define PAINTS WG_SECTION_PAINTS

#define PLACE (UINT32_C(1) << 26)

static void checks_bones(void)
{
    static const change CHANGES[] = {
        {BONES, 0, WG_BONE_PARENT, 2, 0, WG_ERR_BONE},
        {BONES, 1, WG_BONE_PARENT, 2, WG_ABSENT, 0},
        {BONES, 1, WG_BONE_PARENT, 2, 1, WG_ERR_BONE},
        {BONES, 2, WG_BONE_PARENT, 2, 1, 0},
        {BONES, 2, WG_BONE_PARENT, 2, 2, WG_ERR_BONE},
        {BONES, 2, WG_BONE_PARENT, 2, 0xfffe, WG_ERR_BONE},
        {BONES, 2, WG_BONE_JOINT_FIRST, 2, 11, 0},
        {BONES, 2, WG_BONE_JOINT_FIRST, 2, 12, WG_ERR_BONE},
        {BONES, 7, WG_BONE_JOINT_COUNT, 1, 0, 0},
        {BONES, 7, WG_BONE_JOINT_COUNT, 1, 2, WG_ERR_BONE},
        {BONES, 1, WG_BONE_ALONG, 1, 255, 0},
        {BONES, 1, WG_BONE_VALUE, 2, CHANNELS - 1, 0},
        {BONES, 1, WG_BONE_VALUE, 2, CHANNELS, WG_ERR_BONE},
        {BONES, 1, WG_BONE_VALUE, 2, 0xfffe, WG_ERR_BONE},
        {BONES, 1, WG_BONE_ORIGIN, 4, PLACE, 0},
        {BONES, 1, WG_BONE_ORIGIN, 4, PLACE + 1, WG_ERR_BONE},
        {BONES, 1, WG_BONE_ORIGIN + 4, 4, 0u - PLACE, 0},
        {BONES, 1, WG_BONE_ORIGIN + 4, 4, 0u - PLACE - 1u, WG_ERR_BONE},
        {BONES, 7, WG_BONE_ORIGIN + 8, 4, 0u - PLACE, 0},
        {BONES, 7, WG_BONE_ORIGIN + 8, 4, 0x80000000, WG_ERR_BONE},
        {BONES, 1, WG_BONE_LENGTH, 4, PLACE, 0},
        {BONES, 1, WG_BONE_LENGTH, 4, PLACE + 1, WG_ERR_BONE},
        {BONES, 1, WG_BONE_LENGTH, 4, 0xffffffff, WG_ERR_BONE},
        {BONES, 1, WG_BONE_FRAME, 4, 0x80008000, 0},
        {100 + BONES, 0, 2, 2, 7, WG_ERR_DIRECTORY},
        {100 + BONES, 0, 8, 4, 7 * 48, WG_ERR_DIRECTORY},
    };
    CHECK_CHANGES(CHANGES);
}

/* Joints: 0 TURN, 1 MOVE, 2 QUATERNION, 3 STRETCH, 4 TWIST_START, 5 TWIST_END, 6 MOVE, 7 TURN and 8
 * FOLLOW of bone 5, the third of its skin, which follows the second. */
static void checks_joints(void)
{
    static const change CHANGES[] = {
        {JOINTS, 0, WG_JOINT_KIND, 1, 7, WG_ERR_JOINT},
        {JOINTS, 0, WG_JOINT_KIND, 1, 255, WG_ERR_JOINT},
        {JOINTS, 0, WG_JOINT_COUNT, 1, 9, 0},
        {JOINTS, 0, WG_JOINT_CHANNEL, 2, CHANNELS - 1, 0},
        {JOINTS, 0, WG_JOINT_CHANNEL, 2, CHANNELS, WG_ERR_JOINT},
        {JOINTS, 1, WG_JOINT_CHANNEL, 2, CHANNELS, WG_ERR_JOINT},
        {JOINTS, 2, WG_JOINT_CHANNEL, 2, CHANNELS - 4, 0},
        {JOINTS, 2, WG_JOINT_CHANNEL, 2, CHANNELS - 3, WG_ERR_JOINT},
        {JOINTS, 2, WG_JOINT_CHANNEL, 2, 0xffff, WG_ERR_JOINT},
        {JOINTS, 3, WG_JOINT_CHANNEL, 2, CHANNELS, WG_ERR_JOINT},
        {JOINTS, 4, WG_JOINT_CHANNEL, 2, CHANNELS, WG_ERR_JOINT},
        {JOINTS, 5, WG_JOINT_CHANNEL, 2, CHANNELS, WG_ERR_JOINT},
        {JOINTS, 8, WG_JOINT_CHANNEL, 2, 0xffff, 0},
        {JOINTS, 0, WG_JOINT_DATA, 4, 0x80000000, WG_ERR_JOINT},
        {JOINTS, 1, WG_JOINT_DATA, 4, 0xffffffff, 0},
        {JOINTS, 4, WG_JOINT_DATA, 4, 0x7fffffff, 0},
        {JOINTS, 4, WG_JOINT_DATA, 4, 0x80000000, WG_ERR_JOINT},
        {JOINTS, 5, WG_JOINT_DATA, 4, 0x80000000, WG_ERR_JOINT},
        {JOINTS, 0, WG_JOINT_AXIS, 4, 0xc0000000, 0},
        {JOINTS, 0, WG_JOINT_AXIS, 4, 0xbfffffff, WG_ERR_JOINT},
        {JOINTS, 1, WG_JOINT_AXIS + 4, 4, 0x40000001, WG_ERR_JOINT},
        {JOINTS, 0, WG_JOINT_AXIS + 8, 4, 0x80000000, WG_ERR_JOINT},
        {JOINTS, 2, WG_JOINT_AXIS, 4, 0x80000000, 0},
        {JOINTS, 8, WG_JOINT_COUNT, 1, 0, WG_ERR_JOINT},
        {JOINTS, 8, WG_JOINT_COUNT, 1, 9, WG_ERR_JOINT},
        {JOINTS, 8, WG_JOINT_DATA, 4, 0xffffffff, WG_ERR_JOINT},
        {200, 0, 2, 1, 2, 0}, /* a bone that follows itself */
        {200, 0, 2, 1, 3, 0},
        {200, 0, 2, 1, 4, WG_ERR_JOINT},
        {BONES, 4, WG_BONE_PARENT, 2, 0, WG_ERR_JOINT}, /* the followed one has a parent */
        {BONES, 5, WG_BONE_PARENT, 2, 0, WG_ERR_JOINT}, /* the following one has */
        {BONES, 6, WG_BONE_PARENT, 2, 0, 0},
        {BONES, 6, WG_BONE_PARENT, 2, 1, WG_ERR_JOINT}, /* the followed one is a parent */
        {BONES, 6, WG_BONE_PARENT, 2, 2, WG_ERR_JOINT}, /* the following one is */
        {JOINTS, 7, WG_JOINT_KIND, 1, WG_JOINT_FOLLOW, WG_ERR_JOINT}, /* not the last */
        {100 + JOINTS, 0, 8, 4, 219, WG_ERR_DIRECTORY},
    };
    CHECK_CHANGES(CHANGES);
}

static void checks_skins(void)
{
    static const change CHANGES[] = {
        {SKINS, 2, WG_SKIN_SHAPE, 2, 5, WG_ERR_SKIN},
        {SKINS, 2, WG_SKIN_SHAPE, 2, 1, WG_ERR_SKIN}, /* has one */
        {SKINS, 2, WG_SKIN_SHAPE, 2, 3, WG_ERR_SKIN}, /* with normals */
        {SKINS, 1, WG_SKIN_METHOD, 1, WG_SKIN_SHIFT, 0},
        {SKINS, 1, WG_SKIN_METHOD, 1, 3, WG_ERR_SKIN},
        {SKINS, 0, WG_SKIN_METHOD, 1, WG_SKIN_DUAL, 0},
        {SKINS, 0, WG_SKIN_METHOD, 1, WG_SKIN_SHIFT, WG_ERR_SKIN}, /* with ends */
        {SKINS, 0, WG_SKIN_ENDS, 1, 2, WG_ERR_SKIN},
        {SKINS, 2, WG_SKIN_ENDS, 1, 1, WG_ERR_SKIN},
        {SKINS, 2, WG_SKIN_BONE_FIRST, 2, 6, 0},
        {SKINS, 2, WG_SKIN_BONE_FIRST, 2, 8, WG_ERR_SKIN},
        {SKINS, 2, WG_SKIN_BONE_COUNT, 2, 0, WG_ERR_SKIN},
        {SKINS, 2, WG_SKIN_BONE_COUNT, 2, 2, WG_ERR_SKIN},
        {SKINS, 2, WG_SKIN_BONE_COUNT, 2, 0xffff, WG_ERR_SKIN},
        {SKINS, 1, WG_SKIN_BONE_COUNT, 2, 2, WG_ERR_SPAN}, /* the third one has weights */
        {SKINS, 0, WG_SKIN_BONE_COUNT, 2, 2, WG_ERR_SPAN},
        {SKINS, 2, WG_SKIN_SPAN_FIRST, 2, 4, WG_ERR_SKIN},
        {SKINS, 2, WG_SKIN_SPAN_COUNT, 2, 0, WG_ERR_SPAN},
        {SKINS, 2, WG_SKIN_SPAN_COUNT, 2, 2, WG_ERR_SKIN},
        {WG_SECTION_SHAPES, 1, WG_SHAPE_AFFINE, 2, 0, WG_ERR_SHAPE}, /* 12 of 9 channels */
        {100 + SKINS, 0, 2, 2, 17, WG_ERR_DIRECTORY},
    };
    CHECK_CHANGES(CHANGES);
}

static void checks_spans(void)
{
    static const change CHANGES[] = {
        {SPANS, 0, WG_SPAN_FIRST, 2, 1, WG_ERR_SPAN},
        {SPANS, 1, WG_SPAN_FIRST, 2, 0, WG_ERR_SPAN},
        {SPANS, 1, WG_SPAN_FIRST, 2, 2, WG_ERR_SPAN},
        {SPANS, 0, WG_SPAN_COUNT, 2, 0, WG_ERR_SPAN},
        {SPANS, 1, WG_SPAN_COUNT, 2, 2, WG_ERR_SPAN},
        {SPANS, 1, WG_SPAN_COUNT, 2, 4, WG_ERR_SPAN},
        {SPANS, 1, WG_SPAN_COUNT, 2, 0xffff, WG_ERR_SPAN},
        {SPANS, 0, WG_SPAN_INFLUENCES, 1, 0, WG_ERR_SPAN},
        {SPANS, 2, WG_SPAN_INFLUENCES, 1, 9, WG_ERR_SPAN},
        {SPANS, 0, WG_SPAN_DATA, 4, 0xffffffff, WG_ERR_SPAN},
        {200, 0, 0, 1, 2, 0},
        {200, 0, 0, 1, 3, WG_ERR_SPAN},   /* bone */
        {200, 1, 0, 1, 101, WG_ERR_SPAN}, /* weight */
        {200, 1, 0, 1, 99, WG_ERR_SPAN},
        {200, 2, 0, 1, 255, 0}, /* end */
        {100 + SPANS, 0, 2, 2, 3, WG_ERR_DIRECTORY},
    };
    CHECK_CHANGES(CHANGES);
}

static void checks_fields_and_paints(void)
{
    static const change CHANGES[] = {
        {FIELDS, 0, WG_FIELD_CHANNEL, 2, CHANNELS - 1, 0},
        {FIELDS, 0, WG_FIELD_CHANNEL, 2, CHANNELS, WG_ERR_FIELD},
        {FIELDS, 0, WG_FIELD_COUNT, 1, 0, WG_ERR_FIELD},
        {FIELDS, 0, WG_FIELD_COUNT, 1, 3, WG_ERR_FIELD},
        {FIELDS, 1, WG_FIELD_DATA, 4, 0xffffffff, WG_ERR_FIELD},
        {FIELDS, 1, WG_FIELD_DATA, 4, 1, WG_ERR_FIELD}, /* odd */
        {200, 0, 1, 2, CHANNELS - 1, 0},
        {200, 2, 1, 2, CHANNELS, WG_ERR_FIELD},
        {200, 4, 1, 1, 6, WG_ERR_FIELD}, /* weight */
        {PAINTS, 0, WG_PAINT_PART, 2, 4, WG_ERR_PAINT},
        {PAINTS, 0, WG_PAINT_PART, 2, 1, 0},
        {PAINTS, 0, WG_PAINT_PART, 2, 3, WG_ERR_PAINT}, /* a part without a skin */
        {PAINTS, 1, WG_PAINT_PART, 2, 0, WG_ERR_PAINT}, /* is painted */
        {PAINTS, 1, WG_PAINT_PART, 2, 2, 0},
        {PAINTS, 0, WG_PAINT_KIND, 1, 2, WG_ERR_PAINT},
        {PAINTS, 0, WG_PAINT_KIND, 1, 1, WG_ERR_PAINT}, /* no picture */
        {PAINTS, 1, WG_PAINT_WIDTH, 2, 0, WG_ERR_PAINT},
        {PAINTS, 1, WG_PAINT_WIDTH, 2, 1, 0},
        {PAINTS, 1, WG_PAINT_WIDTH, 2, 3, WG_ERR_PAINT},
        {PAINTS, 1, WG_PAINT_HEIGHT, 2, 0, WG_ERR_PAINT},
        {PAINTS, 1, WG_PAINT_HEIGHT, 2, 4, WG_ERR_PAINT},
        {PAINTS, 1, WG_PAINT_HEIGHT, 2, 0xffff, WG_ERR_PAINT},
        {PAINTS, 0, WG_PAINT_PALETTE, 4, 0, 0},
        {PAINTS, 0, WG_PAINT_PALETTE, 4, 0xffffffff, WG_ERR_PAINT},
        {PAINTS, 1, WG_PAINT_TEXELS, 4, 0xffffffff, WG_ERR_PAINT},
        {PAINTS, 1, WG_PAINT_STEP, 4, 0xffffffff, 0},
        {100 + PAINTS, 0, 2, 2, 1, WG_ERR_DIRECTORY},
        {100 + FIELDS, 0, 8, 4, 8, WG_ERR_DIRECTORY},
    };
    CHECK_CHANGES(CHANGES);
}

/* A picture of 1024 texels a side, and one that is larger; DATA holds either. */
static void checks_the_size_of_pictures(void)
{
    static uint8_t palette[WG_PALETTE_BYTES], texels[1024 * 1025];
    static const int16_t REST[3] = {0, 0, 0};
    static const uint16_t CORNERS[3] = {0, 0, 0};
    for (unsigned i = 0; i < 3; i++) {
        const build_shape_data shape = {1, 0, WG_ABSENT, {0, 0, 0}, REST};
        const build_part_data part = {0, WG_ABSENT, 1, 0, {0, 0, 0}, CORNERS};
        const build_paint_data paint = {
            0,     WG_PAINT_PICTURE, i == 1 ? 1025 : 1024, i == 2 ? 1025 : 1024, palette, texels, 0,
            {0, 0}};
        build b = {{{0}}, 2};
        uint32_t size;
        wg_file file;
        build_channel(&b, 0, 0, 0);
        build_clip(&b, 1000, 1000, WG_END_HOLD);
        build_shape(&b, &shape);
        build_part(&b, &part);
        build_paint(&b, &paint);
        uint8_t *clip = build_finish(&b, &size);
        CHECK_EQ(open_all(&file, clip, size), i == 0 ? 0 : WG_ERR_PAINT);
        free(clip);
    }
}

/* 256 bones of one skin, each the child of the one before, and one bone more. */
static void checks_the_number_of_bones(void)
{
    static const int16_t REST[3] = {0, 0, 0};
    static const uint8_t LAST[2] = {255, 255};
    for (unsigned count = 256; count <= 257; count++) {
        const build_shape_data shape = {1, 0, WG_ABSENT, {0, 0, 0}, REST};
        build b = {{{0}}, 2};
        uint32_t size;
        wg_file file;
        build_channel(&b, 0, 0, 0);
        build_clip(&b, 1000, 1000, WG_END_HOLD);
        build_shape(&b, &shape);
        build_skin(&b, 0, WG_SKIN_LINEAR, 0);
        for (unsigned i = 0; i < count; i++) {
            sample_bone(&b, (uint16_t)(i ? i - 1u : WG_ABSENT), WG_ABSENT, 0);
        }
        build_span(&b, 0, 1, 1, LAST);
        uint8_t *clip = build_finish(&b, &size);
        CHECK_EQ(open_all(&file, clip, size), count == 256 ? 0 : WG_ERR_SKIN);
        free(clip);
    }
}

/* A shape that channels move as a whole has no skin. */
static void rejects_skins_of_affine_shapes(void)
{
    static const int16_t REST[3] = {0, 0, 0};
    static const uint8_t ONE[2] = {0, 255};
    for (unsigned affine = 0; affine < 2; affine++) {
        const build_shape_data shape = {1, 0, affine ? 0 : WG_ABSENT, {0, 0, 0}, REST};
        build b = {{{0}}, 2};
        uint32_t size;
        wg_file file;
        for (unsigned c = 0; c < WG_AFFINE_CHANNELS; c++) {
            build_channel(&b, 0, 0, 0);
        }
        build_clip(&b, 1000, 1000, WG_END_HOLD);
        build_shape(&b, &shape);
        build_skin(&b, 0, WG_SKIN_LINEAR, 0);
        sample_bone(&b, WG_ABSENT, WG_ABSENT, 0);
        build_span(&b, 0, 1, 1, ONE);
        uint8_t *clip = build_finish(&b, &size);
        CHECK_EQ(open_all(&file, clip, size), affine ? WG_ERR_SKIN : 0);
        free(clip);
    }
}

int main(void)
{
    TEST(accepts_and_poses_every_kind);
    TEST(accepts_a_clip_without_skins);
    TEST(rejects_data_cut_at_every_byte);
    TEST(checks_bones);
    TEST(checks_joints);
    TEST(checks_skins);
    TEST(checks_spans);
    TEST(checks_fields_and_paints);
    TEST(checks_the_size_of_pictures);
    TEST(checks_the_number_of_bones);
    TEST(rejects_skins_of_affine_shapes);
    return check_done();
}
