/* Opening shapes: what must be rejected is, with the code that names the section, and nothing
 * outside the clip is read, then or when a pose is made (exact-size heap blocks, DATA at their end).
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "shape_samples.h"
#include "wiggly.h"

#define CHANNELS SAMPLE_SHAPE_CHANNELS

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

/* Every shape, in ranges of 1 to 3 vertices, as positions and as normals. */
static void pose_everything(const wg_file *file)
{
    int32_t values[CHANNELS], xyz[9];
    int16_t weights[2][WG_BASES_MAX];
    wg_pose pose, normals;
    wg_clip_sample(file, 0, 500000, values, NULL);
    for (uint8_t s = 0; s < file->section[WG_SECTION_SHAPES].count; s++) {
        wg_pose_init(&pose, file, s, weights[0]);
        wg_pose_set(&pose, values, WG_BASES_MAX, NULL);
        wg_pose_init(&normals, file, s, weights[1]);
        wg_pose_set_normals(&normals, values, WG_BASES_MAX, &pose);
        for (uint16_t first = 0; first < pose.vertices; first++) {
            for (uint16_t count = 1; count <= 3 && first + count <= pose.vertices; count++) {
                wg_pose_vertices(&pose, first, count, xyz);
                wg_pose_vertices(&normals, first, count, xyz);
            }
        }
    }
}

static void accepts_and_poses_every_kind(void)
{
    uint32_t size, last_size;
    uint8_t *clip = sample_shapes_file(&size), *last = data_last(clip, size, 0, &last_size);
    wg_file file;
    static const uint16_t COUNT[] = {3, 6, 8, 2, 2};
    CHECK_EQ(wg_open(&file, last, last_size), 0);
    CHECK_EQ(wg_open_shapes(&file), 0);
    for (unsigned k = 0; k < 5; k++) {
        CHECK_EQ(file.section[WG_SECTION_SHAPES + k].count, COUNT[k]);
    }
    pose_everything(&file);
    free(last);
    free(clip);
}

/* A clip of before 1.1. */
static void accepts_a_clip_without_shapes(void)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    wg_file file;
    CHECK_EQ(wg_open(&file, clip, size), 0);
    CHECK_EQ(wg_open_shapes(&file), 0);
    CHECK_EQ(file.section[WG_SECTION_SHAPES].count, 0);
    free(clip);
}

/* The ramp's bytes come first in DATA, so wg_open keeps accepting; shapes lack their last bytes. */
static void rejects_data_cut_at_every_byte(void)
{
    uint32_t size, cut_size;
    uint8_t *clip = sample_shapes_file(&size);
    wg_file file;
    uint32_t first_rest = build_get(clip + build_where(clip, 13, 0) + WG_SHAPE_REST, 4);
    uint32_t bytes = build_get(entry_of(clip, WG_SECTION_DATA) + 8, 4);
    CHECK(bytes - first_rest > 200);
    for (uint32_t cut = 1; cut <= bytes - first_rest; cut++) {
        uint8_t *copy = data_last(clip, size, cut, &cut_size);
        CHECK_EQ(wg_open(&file, copy, cut_size), 0);
        int err = wg_open_shapes(&file);
        CHECK(err == WG_ERR_SHAPE || err == WG_ERR_BLOCK || err == WG_ERR_PART);
        free(copy);
    }
    free(clip);
}

/* ---- one field wrong at a time --------------------------------------------------------------- */

/* Field of record `index` of section `kind`; 100 + kind: of the directory's entry. */
typedef struct {
    uint8_t kind, index, field, bytes;
    uint32_t value;
    int want;
} change;

static void check_changes(const change *changes, unsigned count)
{
    uint32_t size, last_size;
    uint8_t *clip = sample_shapes_file(&size);
    for (unsigned i = 0; i < count; i++) {
        const change *c = &changes[i];
        uint8_t *copy = build_copy(clip, size);
        uint8_t *at = c->kind > 100 ? entry_of(copy, c->kind - 100u)
                                    : copy + build_where(copy, c->kind, c->index);
        build_put(at + c->field, c->bytes, c->value);
        uint8_t *last = data_last(copy, size, 0, &last_size);
        wg_file file;
        int err = wg_open(&file, last, last_size);
        err = err == 0 ? wg_open_shapes(&file) : err;
        if (err != c->want) {
            printf("change %u: section %u field %u = %#lx\n", i, c->kind, c->field,
                   (unsigned long)c->value);
        }
        CHECK_EQ(err, c->want);
        if (err == 0) {
            pose_everything(&file);
        }
        free(last);
        free(copy);
    }
    free(clip);
}

#define CHECK_CHANGES(table) check_changes(table, sizeof table / sizeof *table)

static void rejects_bad_shapes_and_bases(void)
{
    static const change CHANGES[] = {
        {13, 2, 0, 2, 0, WG_ERR_SHAPE},
        {13, 2, 0, 2, 0xffff, WG_ERR_SHAPE}, /* rest ends outside DATA */
        {13, 0, 2, 1, 0xf8, 0},              /* -8 */
        {13, 0, 2, 1, 0xf7, WG_ERR_SHAPE},
        {13, 0, 2, 1, 20, 0},
        {13, 0, 2, 1, 21, WG_ERR_SHAPE},
        {13, 0, 2, 1, 0x80, WG_ERR_SHAPE},
        {13, 0, 3, 1, 0xff, 0}, /* reserved */
        {13, 0, 14, 2, 0xffff, 0},
        {13, 0, 4, 2, 3, 0}, /* the other shape's */
        {13, 0, 4, 2, 4, WG_ERR_SHAPE},
        {13, 0, 4, 2, 0xffff, WG_ERR_SHAPE},
        {13, 0, 6, 2, 6, 0},
        {13, 0, 6, 2, 7, WG_ERR_SHAPE},
        {13, 0, 6, 2, 65, WG_ERR_SHAPE},
        {13, 0, 6, 2, 0xffff, WG_ERR_SHAPE},
        {13, 1, 8, 2, 5, WG_ERR_SHAPE},
        {13, 1, 8, 2, 0xffff, WG_ERR_SHAPE},
        {13, 1, 10, 2, 5, WG_ERR_SHAPE},
        {13, 0, 10, 2, 8, 0},
        {13, 0, 10, 2, 0xffff, WG_ERR_SHAPE},
        {13, 0, 12, 2, 9, WG_ERR_SHAPE}, /* channels 9 .. 20 of 20 */
        {13, 0, 12, 2, 0, 0},
        {13, 0, 12, 2, 0xfffe, WG_ERR_SHAPE},
        {13, 0, 16, 4, 2, WG_ERR_SHAPE},
        {13, 0, 16, 4, 0, 0}, /* whatever lies there */
        {13, 0, 16, 4, 0xfffffffc, WG_ERR_SHAPE},
        {13, 0, 20, 4, 0x10000001, WG_ERR_SHAPE},
        {13, 1, 24, 4, 0xefffffff, WG_ERR_SHAPE},
        {13, 2, 28, 4, 0x80000000, WG_ERR_SHAPE},
        {14, 0, 0, 2, CHANNELS - 1, 0},
        {14, 0, 0, 2, CHANNELS, WG_ERR_BASIS},
        {14, 5, 0, 2, 0xffff, WG_ERR_BASIS},
        {14, 0, 2, 2, 0x8000, 0},
        {14, 0, 4, 1, 0, WG_ERR_BASIS},
        {14, 5, 4, 1, 16, WG_ERR_BASIS},
        {14, 5, 4, 1, 255, WG_ERR_BASIS},
        {14, 5, 5, 1, 255, 0},
    };
    CHECK_CHANGES(CHANGES);
}

static void rejects_bad_blocks(void)
{
    static const change CHANGES[] = {
        {15, 0, 0, 2, 3, WG_ERR_BLOCK},
        {15, 7, 0, 2, 0xffff, WG_ERR_BLOCK},
        {15, 0, 2, 2, 3, WG_ERR_BLOCK},
        {15, 0, 2, 2, 0xfffe, WG_ERR_BLOCK},
        {15, 0, 2, 2, 0, 0}, /* the same basis twice */
        {15, 0, 4, 2, 2, WG_ERR_BLOCK},
        {15, 0, 4, 2, 0, 0},
        {15, 0, 4, 2, 0xffff, WG_ERR_BLOCK},
        {15, 0, 6, 2, 0, WG_ERR_BLOCK},
        {15, 0, 6, 2, 5, WG_ERR_BLOCK},
        {15, 0, 6, 2, 0xffff, WG_ERR_BLOCK},
        {15, 0, 8, 1, 8, 0},
        {15, 0, 8, 1, 0, WG_ERR_BLOCK},
        {15, 0, 8, 1, 32, WG_ERR_BLOCK},
        {15, 2, 8, 1, 255, WG_ERR_BLOCK},
        {15, 0, 9, 1, 255, 0},
        {15, 0, 10, 2, 0xffff, 0},
        {15, 0, 12, 4, 2, WG_ERR_BLOCK},
        {15, 0, 12, 4, 0xfffffffc, WG_ERR_BLOCK},
        {15, 0, 12, 4, 0x7ffffffc, WG_ERR_BLOCK},
        {13, 0, 6, 2, 2, WG_ERR_BLOCK},  /* basis 2 is not its shape's any more */
        {13, 1, 0, 2, 4, WG_ERR_BLOCK},  /* nor is vertex 4 */
        {13, 2, 10, 2, 1, WG_ERR_SHAPE}, /* from 8 on there is none */
        {13, 2, 8, 2, 3, 0},             /* a count of 0 owns nothing */
    };
    CHECK_CHANGES(CHANGES);
}

/* Blocks moved so that their last byte is DATA's, and 4 bytes further. Those of 9 components a basis
 * in pairs of 8 bits end with a group that is half full. */
static void rejects_blocks_that_end_outside_data(void)
{
    static const uint32_t BYTES[4] = {4 * 12, 2 * 15, 20, 3};
    uint32_t size;
    uint8_t *clip = sample_shapes_file(&size);
    uint32_t data = build_get(entry_of(clip, WG_SECTION_DATA) + 8, 4);
    free(clip);
    for (uint8_t i = 0; i < 4; i++) {
        uint32_t at = (data - BYTES[i]) & ~3u;
        const change changes[] = {{15, i, 12, 4, at, 0}, {15, i, 12, 4, at + 4u, WG_ERR_BLOCK}};
        CHECK_CHANGES(changes);
    }
}

static void rejects_bad_parts_and_views(void)
{
    static const change CHANGES[] = {
        {16, 0, 0, 2, 3, WG_ERR_PART},
        {16, 0, 0, 2, 0xffff, WG_ERR_PART},
        {16, 0, 2, 2, 3, WG_ERR_PART},
        {16, 0, 2, 2, 0xfffe, WG_ERR_PART},
        {16, 1, 2, 2, 2, WG_ERR_PART}, /* 1 vertex and 5 */
        {16, 1, 2, 2, 0, 0},
        {16, 0, 4, 2, 0, WG_ERR_PART},
        {16, 1, 4, 2, 3, WG_ERR_PART},
        {16, 1, 4, 2, 0xffff, WG_ERR_PART},
        {16, 1, 0, 2, 2, WG_ERR_PART}, /* corners of vertices it does not have */
        {16, 0, 6, 1, 1, 0},
        {16, 0, 6, 1, 2, WG_ERR_PART},
        {16, 0, 7, 1, 255, 0},
        {16, 0, 11, 1, 255, 0},
        {16, 0, 12, 4, 1, WG_ERR_PART},
        {16, 0, 12, 4, 0xfffffffe, WG_ERR_PART},
        {17, 0, 0, 1, 2, WG_ERR_VIEW},
        {17, 1, 1, 1, 3, WG_ERR_VIEW},
        {17, 1, 2, 1, 255, 0},
        {17, 0, 3, 1, 255, 0},
        {17, 0, 7, 1, 255, 0},
        {17, 0, 11, 1, 255, 0},
        {17, 0, 12, 2, CHANNELS - 1, 0},
        {17, 0, 12, 2, CHANNELS, WG_ERR_VIEW},
        {17, 0, 18, 2, CHANNELS, WG_ERR_VIEW},
        {17, 1, 26, 2, 0xffff, WG_ERR_VIEW},
        {113, 0, 8, 4, 95, WG_ERR_DIRECTORY},
        {113, 0, 2, 2, 17, WG_ERR_DIRECTORY},
        {114, 0, 2, 2, 1025, WG_ERR_DIRECTORY},
        {115, 0, 8, 4, 8 * 16 - 1, WG_ERR_DIRECTORY},
        {116, 0, 2, 2, 65, WG_ERR_DIRECTORY},
        {117, 0, 2, 2, 17, WG_ERR_DIRECTORY},
        {117, 0, 8, 4, 55, WG_ERR_DIRECTORY},
    };
    CHECK_CHANGES(CHANGES);
}

static void every_corner_is_checked(void)
{
    uint32_t size, data;
    uint8_t *clip = sample_shapes_file(&size);
    data = build_where(clip, WG_SECTION_DATA, 0) +
           build_get(clip + build_where(clip, 16, 1) + WG_PART_DATA, 4);
    for (unsigned corner = 0; corner < 6; corner++) {
        for (unsigned vertex = 4; vertex < 7; vertex++) {
            uint8_t *copy = build_copy(clip, size);
            wg_file file;
            build_put(copy + data + 2u * corner, 2, vertex);
            build_seal(copy, size);
            CHECK_EQ(wg_open(&file, copy, size), 0);
            CHECK_EQ(wg_open_shapes(&file), vertex < 5 ? 0 : WG_ERR_PART);
            free(copy);
        }
    }
    free(clip);
}

/* ---- counts ---------------------------------------------------------------------------------- */

/* A clip whose section `kind` has `count` records. */
static int open_with(unsigned kind, unsigned count)
{
    static const int16_t REST[3] = {0, 0, 0};
    static const uint16_t ZEROS[8] = {0};
    const build_shape_data shape = {1, 0, WG_ABSENT, {0, 0, 0}, REST};
    const build_part_data part = {0, WG_ABSENT, 1, 0, {0, 0, 0}, ZEROS};
    build b = {{{0}}, 1};
    uint32_t size;
    wg_file file;
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 60, 60, WG_END_HOLD);
    build_shape(&b, &shape);
    for (unsigned i = 0; i < count; i++) {
        if (kind == WG_SECTION_SHAPES && i > 0) {
            build_shape(&b, &shape);
        } else if (kind == WG_SECTION_BASES) {
            if (i % WG_BASES_MAX == 0 && i > 0 && i < 2048) {
                build_shape(&b, &shape);
            }
            build_basis(&b, 0, 1, 1);
        } else if (kind == WG_SECTION_PARTS) {
            build_part(&b, &part);
        } else if (kind == WG_SECTION_VIEWS) {
            build_view(&b, 0, 0, ZEROS);
        }
    }
    uint8_t *clip = build_finish(&b, &size);
    int err = wg_open(&file, clip, size);
    err = err == 0 ? wg_open_shapes(&file) : err;
    free(clip);
    return err;
}

static void accepts_the_most_records_and_no_more(void)
{
    static const struct {
        uint8_t kind;
        uint16_t most;
    } LIMITS[] = {{WG_SECTION_SHAPES, 16},
                  {WG_SECTION_BASES, 2048},
                  {WG_SECTION_PARTS, 64},
                  {WG_SECTION_VIEWS, 16}};
    for (unsigned i = 0; i < sizeof LIMITS / sizeof *LIMITS; i++) {
        CHECK_EQ(open_with(LIMITS[i].kind, LIMITS[i].most), 0);
        CHECK_EQ(open_with(LIMITS[i].kind, LIMITS[i].most + 1u), WG_ERR_DIRECTORY);
    }
}

static void a_shape_has_128_bases_at_most(void)
{
    static const int16_t REST[3] = {0, 0, 0};
    const build_shape_data shape = {1, 0, WG_ABSENT, {0, 0, 0}, REST};
    for (unsigned bases = 128; bases <= 129; bases++) {
        build b = {{{0}}, 1};
        uint32_t size;
        wg_file file;
        build_channel(&b, 0, 0, 0);
        build_clip(&b, 60, 60, WG_END_HOLD);
        build_shape(&b, &shape);
        for (unsigned i = 0; i < bases; i++) {
            build_basis(&b, 0, 1, 1);
        }
        uint8_t *clip = build_finish(&b, &size);
        CHECK_EQ(wg_open(&file, clip, size), 0);
        CHECK_EQ(wg_open_shapes(&file), bases == 128 ? 0 : WG_ERR_SHAPE);
        free(clip);
    }
}

int main(void)
{
    TEST(accepts_and_poses_every_kind);
    TEST(accepts_a_clip_without_shapes);
    TEST(rejects_data_cut_at_every_byte);
    TEST(rejects_bad_shapes_and_bases);
    TEST(rejects_bad_blocks);
    TEST(rejects_blocks_that_end_outside_data);
    TEST(rejects_bad_parts_and_views);
    TEST(every_corner_is_checked);
    TEST(accepts_the_most_records_and_no_more);
    TEST(a_shape_has_128_bases_at_most);
    return check_done();
}
