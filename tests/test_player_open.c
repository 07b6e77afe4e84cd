/* Opening: what must be rejected is, with the code that names the reason, and nothing outside the
 * clip is read on the way (every clip is an exact-size heap block, for the sanitizers).
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "clip_samples.h"
#include "wiggly.h"

/* wg_open on an exact-size copy of its own. */
static int open_copy(const uint8_t *bytes, uint32_t size)
{
    wg_file file;
    uint8_t *copy = build_copy(bytes, size);
    int err = wg_open(&file, copy, size);
    free(copy);
    return err;
}

static int open_built(build *b)
{
    uint32_t size;
    uint8_t *clip = build_finish(b, &size);
    int err = open_copy(clip, size);
    free(clip);
    return err;
}

static void accepts_every_section(void)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    wg_file file;
    CHECK_EQ(wg_open(&file, clip, size), 0);
    static const uint16_t COUNT[] = {0, 3, 2, 4, 11, 0, 4, 2, 2, 5, 1, 3, 3};
    for (unsigned k = 1; k <= WG_SECTION_NAMES; k++) {
        CHECK_EQ(file.section[k].count, COUNT[k]);
        CHECK(file.section[k].at == clip + build_where(clip, k, 0));
    }
    free(clip);
}

static void rejects_truncation_at_every_byte(void)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    for (uint32_t n = 0; n < size; n++) {
        CHECK_EQ(open_copy(clip, n), WG_ERR_SHORT);
    }
    free(clip);
}

/* The header says that the file is shorter, and the CRC agrees: whatever was cut must be missed. */
static void rejects_sealed_truncation_at_every_byte(void)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    uint32_t last = build_where(clip, 200, 0);
    for (uint32_t n = 0; n < last; n++) {
        uint8_t *cut = build_copy(clip, n < WG_HEADER_BYTES ? WG_HEADER_BYTES : n);
        build_put(cut + WG_HEADER_LENGTH, 4, n);
        build_seal(cut, n < WG_HEADER_BYTES ? WG_HEADER_BYTES : n);
        CHECK_EQ(open_copy(cut, n < WG_HEADER_BYTES ? WG_HEADER_BYTES : n),
                 n < WG_HEADER_BYTES ? WG_ERR_SHORT : WG_ERR_DIRECTORY);
        free(cut);
    }
    free(clip);
}

/* What byte `at` being wrong must look like. A length that grows is "short" before any CRC. */
static int corruption(uint32_t at, int err)
{
    if (at < 4) {
        return err == WG_ERR_MAGIC;
    }
    if (at == WG_HEADER_MAJOR) {
        return err == WG_ERR_VERSION;
    }
    return err == WG_ERR_CRC || (err == WG_ERR_SHORT && at >= WG_HEADER_LENGTH && at < 16);
}

static void rejects_every_single_byte_corruption(void)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    uint8_t *copy = build_copy(clip, size);
    wg_file file;
    for (uint32_t at = 0; at < size; at++) {
        for (unsigned flip = 1; flip < 256; flip++) {
            copy[at] = clip[at] ^ (uint8_t)flip;
            CHECK(corruption(at, wg_open(&file, copy, size)));
        }
        copy[at] = clip[at];
    }
    CHECK_EQ(wg_open(&file, copy, size), 0);
    free(copy);
    free(clip);
}

static void rejects_misaligned_start(void)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    wg_file file;
    for (unsigned shift = 1; shift < 4; shift++) {
        uint8_t *room = malloc(size + shift);
        memcpy(room + shift, clip, size);
        CHECK_EQ(wg_open(&file, room + shift, size), WG_ERR_ALIGN);
        free(room);
    }
    free(clip);
}

static void ignores_bytes_after_length(void)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    uint8_t *longer = malloc(size + 5u);
    wg_file file;
    memcpy(longer, clip, size);
    memset(longer + size, 0xa5, 5);
    CHECK_EQ(wg_open(&file, longer, size + 5u), 0);
    free(longer);
    free(clip);
}

static void accepts_newer_minor_and_unknown_sections(void)
{
    for (unsigned minor = 0; minor < 256; minor++) {
        build b = {{{0}}, 0};
        sample_everything(&b);
        b.minor = (uint8_t)minor;
        CHECK_EQ(open_built(&b), 0);
    }
}

/* ---- one field wrong at a time --------------------------------------------------------------- */

/* Field of record `index` of section `kind` set to `value`, CRC made right. Kind 0 is the header;
 * 100 + k is entry k - 1 of the directory, whose sections are 1, 2, ... 12, 200. */
typedef struct {
    uint8_t kind, index, field, bytes;
    uint32_t value;
    int want;
} change;

static uint32_t change_at(const uint8_t *clip, const change *c)
{
    uint32_t record = c->kind == 0    ? 0
                      : c->kind > 100 ? WG_HEADER_BYTES + (c->kind - 101u) * WG_DIRECTORY_BYTES
                                      : build_where(clip, c->kind, c->index);
    return record + c->field;
}

static void check_changes(const change *changes, unsigned count)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    for (unsigned i = 0; i < count; i++) {
        uint8_t *copy = build_copy(clip, size);
        build_put(copy + change_at(copy, &changes[i]), changes[i].bytes, changes[i].value);
        build_seal(copy, size);
        wg_file file;
        int err = wg_open(&file, copy, size);
        if (err != changes[i].want) {
            printf("change %u: section %u field %u = %#lx\n", i, changes[i].kind, changes[i].field,
                   (unsigned long)changes[i].value);
        }
        CHECK_EQ(err, changes[i].want);
        free(copy);
    }
    free(clip);
}

#define CHECK_CHANGES(table) check_changes(table, sizeof table / sizeof *table)

static void rejects_bad_header_and_directory(void)
{
    static const change CHANGES[] = {
        {0, 0, 0, 4, 0x594c4758u, WG_ERR_MAGIC},
        {0, 0, 8, 1, 0, WG_ERR_VERSION},
        {0, 0, 8, 1, 2, WG_ERR_VERSION},
        {0, 0, 10, 2, 65, WG_ERR_DIRECTORY},
        {0, 0, 10, 2, 0xffff, WG_ERR_DIRECTORY},
        {0, 0, 10, 2, 0, WG_ERR_CHANNEL},      /* nothing in it */
        {0, 0, 10, 2, 1, WG_ERR_CLIP},         /* channels only */
        {101, 0, 0, 2, 0, WG_ERR_DIRECTORY},   /* kind 0 */
        {101, 0, 0, 2, 2, WG_ERR_DIRECTORY},   /* kinds 2, 2 */
        {102, 0, 0, 2, 1, WG_ERR_DIRECTORY},   /* kinds 1, 1 */
        {112, 0, 0, 2, 201, WG_ERR_DIRECTORY}, /* kinds 201, 200 */
        {113, 0, 0, 2, 0xffff, 0},
        {113, 0, 2, 2, 0xffff, 0}, /* an unknown section's count means nothing */
        {113, 0, 4, 4, 0xfffffffcu, WG_ERR_DIRECTORY},
        {113, 0, 8, 4, 5, WG_ERR_DIRECTORY}, /* a byte past the end */
        {113, 0, 8, 4, 0xffffffffu, WG_ERR_DIRECTORY},
        {101, 0, 2, 2, 2, WG_ERR_DIRECTORY}, /* count smaller than bytes */
        {101, 0, 2, 2, 4, WG_ERR_DIRECTORY},
        {101, 0, 8, 4, 25, WG_ERR_DIRECTORY},
        {101, 0, 4, 4, 18, WG_ERR_DIRECTORY}, /* misaligned */
        {101, 0, 4, 4, 0x80000000u, WG_ERR_DIRECTORY},
        {101, 0, 4, 4, 0xfffffff0u, WG_ERR_DIRECTORY},
        {101, 0, 8, 4, 0xfffffff8u, WG_ERR_DIRECTORY},
        {107, 0, 8, 4, 5, WG_ERR_DIRECTORY}, /* two masks of three channels need 6 bytes */
        {107, 0, 2, 2, 1, WG_ERR_LAYER},     /* and a layer asks for the second */
        {107, 0, 2, 2, 3, WG_ERR_DIRECTORY},
        {112, 0, 2, 2, 2, WG_ERR_NAME},
        {112, 0, 2, 2, 4, WG_ERR_NAME},
        {112, 0, 8, 4, 10, WG_ERR_NAME}, /* the last NUL is cut off */
        {112, 0, 8, 4, 0, WG_ERR_NAME},
    };
    CHECK_CHANGES(CHANGES);
}

static void rejects_bad_channels_clips_and_tracks(void)
{
    static const change CHANGES[] = {
        {1, 0, 0, 1, 30, 0},
        {1, 2, 0, 1, 31, WG_ERR_CHANNEL},
        {1, 0, 0, 1, 226, 0},
        {1, 0, 0, 1, 225, WG_ERR_CHANNEL},
        {1, 0, 0, 1, 128, WG_ERR_CHANNEL},
        {1, 0, 1, 1, 255, 0},    /* an unknown unit */
        {1, 0, 2, 2, 0xffff, 0}, /* reserved */
        {1, 1, 4, 4, 0x10000000u, 0},
        {1, 1, 4, 4, 0x10000001u, WG_ERR_CHANNEL},
        {1, 1, 4, 4, 0xf0000000u, 0},
        {1, 1, 4, 4, 0xefffffffu, WG_ERR_CHANNEL},
        {1, 1, 4, 4, 0x80000000u, WG_ERR_CHANNEL},
        {2, 0, 0, 4, 0, WG_ERR_CLIP},
        {2, 0, 4, 1, 40, 0},
        {2, 0, 4, 1, 41, WG_ERR_CLIP},
        {2, 1, 5, 1, 3, WG_ERR_CLIP},
        {2, 0, 6, 2, 0, WG_ERR_CLIP},
        {2, 0, 6, 2, 79, WG_ERR_TIMES}, /* the runs reach beyond the end */
        {2, 0, 6, 2, 81, WG_ERR_TIMES}, /* the runs do not reach it */
        {2, 0, 8, 4, 8, 0},
        {2, 0, 8, 4, 7, WG_ERR_CLIP}, /* under 8 us */
        {2, 0, 14, 2, 0, WG_ERR_CLIP},
        {2, 1, 16, 2, 3, WG_ERR_CLIP}, /* tracks 3 and 4 of 4 */
        {2, 1, 16, 2, 0xffff, WG_ERR_CLIP},
        {2, 1, 18, 2, 3, WG_ERR_CLIP},
        {2, 1, 18, 2, 0xffff, WG_ERR_CLIP},
        {2, 1, 20, 2, 4, WG_ERR_CLIP},
        {2, 1, 22, 2, 0xffff, WG_ERR_CLIP},
        {2, 0, 18, 2, 3, WG_ERR_TRACK}, /* channels 0, 1, 1 */
        {3, 0, 0, 2, 1, WG_ERR_TRACK},
        {3, 1, 0, 2, 3, WG_ERR_TRACK},
        {3, 1, 0, 2, 0xffff, WG_ERR_TRACK},
        {3, 0, 2, 2, 1, WG_ERR_TRACK}, /* does not start at tick 0 */
        {3, 0, 2, 2, 0xffff, WG_ERR_TRACK},
        {3, 0, 4, 2, 0, WG_ERR_TRACK},
        {3, 0, 4, 2, 7, WG_ERR_TIMES}, /* ends before the clip */
        {3, 3, 4, 2, 2, WG_ERR_TRACK}, /* one run more than there are */
        {3, 0, 4, 2, 0xffff, WG_ERR_TRACK},
    };
    CHECK_CHANGES(CHANGES);
}

static void rejects_bad_runs_and_times(void)
{
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    uint32_t data = build_get(clip + WG_HEADER_BYTES + 4u * WG_DIRECTORY_BYTES + 8u, 4);
    uint32_t times = build_get(clip + build_where(clip, 4, 0) + 12, 4);
    uint32_t osc0 = build_get(clip + build_where(clip, 4, 4) + 16, 4);
    free(clip);
    const change CHANGES[] = {
        {4, 0, 0, 2, 1, WG_ERR_TRACK},
        {4, 1, 0, 2, 11, WG_ERR_TIMES}, /* a gap before it */
        {4, 1, 0, 2, 9, WG_ERR_TIMES},
        {4, 1, 2, 2, 0, WG_ERR_RUN},
        {4, 1, 2, 2, 1, WG_ERR_TIMES},
        {4, 0, 2, 2, 0xffff, WG_ERR_RUN},
        {4, 0, 4, 1, 8, WG_ERR_RUN},
        {4, 0, 4, 1, 255, WG_ERR_RUN},
        {4, 0, 5, 1, 7, 0},
        {4, 0, 5, 1, 8, WG_ERR_RUN},
        {4, 0, 6, 1, 1, WG_ERR_RUN}, /* HELD has no aux */
        {4, 1, 6, 1, 1, WG_ERR_RUN},
        {4, 2, 6, 1, 24, 0},
        {4, 2, 6, 1, 25, WG_ERR_RUN},
        {4, 3, 6, 1, 5, 0},
        {4, 3, 6, 1, 6, WG_ERR_RUN},
        {4, 3, 6, 1, 0x10, WG_ERR_RUN}, /* OSC has one sinh */
        {4, 4, 6, 1, 1, WG_ERR_RUN},    /* OSC0 none */
        {4, 5, 6, 1, 0x15, WG_ERR_RUN},
        {4, 6, 6, 1, 0x55, 0},
        {4, 6, 6, 1, 0x65, WG_ERR_RUN},
        {4, 7, 6, 1, 0x10, WG_ERR_RUN},
        {4, 0, 7, 1, 255, 0}, /* reserved */
        {4, 0, 8, 4, 0x10000000u, 0},
        {4, 0, 8, 4, 0x10000001u, WG_ERR_RUN},
        {4, 0, 8, 4, 0xefffffffu, WG_ERR_RUN},
        {4, 0, 12, 4, times + 1u, WG_ERR_RUN}, /* odd */
        {4, 0, 12, 4, data - 2u, WG_ERR_RUN},  /* one of the two lies outside */
        {4, 0, 12, 4, 0xfffffffeu, WG_ERR_RUN},
        {4, 0, 16, 4, 1, WG_ERR_RUN},
        {4, 2, 16, 4, data - 10u, WG_ERR_RUN},
        {4, 2, 16, 4, data - 12u, 0},
        {4, 3, 16, 4, 2, WG_ERR_RUN}, /* waves: multiple of 4 */
        {4, 3, 16, 4, 0xfffffffcu, WG_ERR_RUN},
        {4, 7, 16, 4, data - 20u, WG_ERR_RUN},
        {5, 0, (uint8_t)times, 2, 0, WG_ERR_TIMES}, /* a segment of no ticks */
        {5, 0, (uint8_t)times, 2, 10, WG_ERR_TIMES},
        {5, 0, (uint8_t)times, 2, 0xffff, WG_ERR_TIMES},
        {5, 0, (uint8_t)times, 2, 9, 0},
        {5, 0, (uint8_t)osc0, 4, 0x7fffffffu, 0},
        {5, 0, (uint8_t)osc0, 4, 0x80000000u, WG_ERR_RUN},
    };
    CHECK(osc0 < 256 && data < 0xffffu);
    CHECK_CHANGES(CHANGES);
}

static void rejects_bad_events_layers_filters_triggers_servos(void)
{
    static const change CHANGES[] = {
        {6, 0, 0, 2, 41, WG_ERR_EVENT}, /* descends after it */
        {6, 0, 0, 2, 40, 0},
        {6, 2, 0, 2, 80, WG_ERR_EVENT},
        {6, 2, 0, 2, 39, WG_ERR_EVENT},
        {6, 3, 0, 2, 40, WG_ERR_EVENT},
        {6, 0, 2, 2, 0xffff, 0},
        {8, 0, 0, 1, 2, WG_ERR_LAYER},
        {8, 0, 0, 1, 255, 0},
        {8, 0, 1, 1, 2, WG_ERR_LAYER},
        {8, 1, 2, 1, 2, WG_ERR_LAYER},
        {8, 1, 2, 1, 254, WG_ERR_LAYER},
        {8, 1, 4, 2, 32769, WG_ERR_LAYER},
        {9, 0, 0, 1, 5, WG_ERR_FILTER},
        {9, 0, 2, 2, 3, WG_ERR_FILTER},
        {9, 0, 4, 4, 0x10000001u, WG_ERR_FILTER},
        {9, 1, 8, 4, 0xefffffffu, WG_ERR_FILTER},
        {9, 4, 1, 1, 0, WG_ERR_FILTER},
        {9, 4, 1, 1, 9, WG_ERR_FILTER},
        {9, 4, 1, 1, 3, WG_ERR_FILTER}, /* 24 bytes where 12 are left */
        {9, 4, 4, 4, 0xfffffffeu, WG_ERR_FILTER},
        {9, 4, 4, 4, 1, WG_ERR_FILTER},
        {9, 4, 4, 4, 0, WG_ERR_FILTER}, /* its channels would be 5 and 10 */
        {10, 0, 2, 1, 2, WG_ERR_TRIGGER},
        {10, 0, 3, 1, 2, WG_ERR_TRIGGER},
        {10, 0, 3, 1, 255, 0},
        {11, 0, 0, 1, 4, WG_ERR_SERVO},
        {11, 0, 2, 2, 3, WG_ERR_SERVO},
        {11, 0, 4, 4, 0x10000001u, WG_ERR_SERVO},
        {11, 0, 10, 1, 40, 0},
        {11, 0, 10, 1, 41, WG_ERR_SERVO},
        {11, 0, 12, 2, 8001, WG_ERR_SERVO}, /* min > max */
        {11, 0, 12, 2, 8000, 0},
        {11, 0, 14, 2, 0x8000, WG_ERR_SERVO},
    };
    CHECK_CHANGES(CHANGES);
}

/* wg_track_value takes every index below the count of TRACKS, so a track that no clip lists must be
 * as sound as the others. Track 1 of the sample loses its clip, then breaks. */
static void rejects_a_bad_track_of_no_clip(void)
{
    static const change BROKEN[] = {
        {3, 1, 2, 2, 0xffff, 0}, {3, 1, 4, 2, 0, 0},  {3, 1, 4, 2, 0xffff, 0},
        {4, 8, 4, 1, 8, 0},      {4, 8, 2, 2, 99, 0}, {4, 8, 16, 4, 0xfffffff0u, 0},
    };
    uint32_t size;
    uint8_t *clip = sample_everything_file(&size);
    build_put(clip + build_where(clip, 2, 0) + WG_CLIP_TRACK_COUNT, 2, 1);
    build_seal(clip, size);
    CHECK_EQ(open_copy(clip, size), 0);
    for (unsigned i = 0; i < sizeof BROKEN / sizeof *BROKEN; i++) {
        uint8_t *copy = build_copy(clip, size);
        build_put(copy + change_at(copy, &BROKEN[i]), BROKEN[i].bytes, BROKEN[i].value);
        build_seal(copy, size);
        CHECK(open_copy(copy, size) < 0);
        free(copy);
    }
    free(clip);
}

/* ---- counts ---------------------------------------------------------------------------------- */

/* One channel and one clip without tracks, and `count` more records in section `kind`. */
static int open_with(unsigned kind, unsigned count)
{
    static const build_servo_data SERVO = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    static const uint8_t ONE[256] = {255};
    build b = {{{0}}, 0};
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 1000, 10, 0);
    build_layer(&b, 0, 0, WG_NONE, 32768);
    for (unsigned i = 0; i < count; i++) {
        switch (kind) {
        case WG_SECTION_CHANNELS:
            build_channel(&b, 0, 0, 0);
            break;
        case WG_SECTION_CLIPS:
            build_clip(&b, 1000, 10, 0);
            break;
        case WG_SECTION_MASKS:
            build_mask(&b, ONE);
            break;
        case WG_SECTION_LAYERS:
            build_layer(&b, 0, 0, WG_NONE, 0);
            break;
        case WG_SECTION_FILTERS:
            build_filter(&b, 0, 0, 0, 0);
            break;
        case WG_SECTION_TRIGGERS:
            build_trigger(&b, 0, 0, 0, 0);
            break;
        default:
            build_servo(&b, &SERVO);
            break;
        }
    }
    return open_built(&b);
}

static void accepts_the_most_records_and_no_more(void)
{
    static const struct {
        uint8_t kind;
        uint16_t most; /* besides the one that is there already */
    } LIMITS[] = {{WG_SECTION_CHANNELS, 255}, {WG_SECTION_CLIPS, 254},   {WG_SECTION_MASKS, 255},
                  {WG_SECTION_LAYERS, 7},     {WG_SECTION_FILTERS, 256}, {WG_SECTION_TRIGGERS, 32},
                  {WG_SECTION_SERVOS, 64}};
    for (unsigned i = 0; i < sizeof LIMITS / sizeof *LIMITS; i++) {
        CHECK_EQ(open_with(LIMITS[i].kind, LIMITS[i].most), 0);
        CHECK_EQ(open_with(LIMITS[i].kind, LIMITS[i].most + 1u), WG_ERR_DIRECTORY);
    }
}

/* Every record count of 65535 in a file that is far too small for it. */
static void rejects_absurd_counts(void)
{
    for (uint8_t kind = 1; kind <= WG_SECTION_NAMES; kind++) {
        change c = {0, 0, 2, 2, 0xffffu, WG_ERR_DIRECTORY};
        c.kind = (uint8_t)(100u + kind);
        c.want = kind == WG_SECTION_NAMES ? WG_ERR_NAME : WG_ERR_DIRECTORY;
        if (kind != WG_SECTION_DATA) {
            check_changes(&c, 1);
        }
    }
}

static void rejects_absurd_lengths(void)
{
    static const change CHANGES[] = {
        {0, 0, 12, 4, 0, WG_ERR_SHORT},
        {0, 0, 12, 4, 15, WG_ERR_SHORT},
        {0, 0, 12, 4, 0xffffffffu, WG_ERR_SHORT},
        {0, 0, 12, 4, 0x80000000u, WG_ERR_SHORT},
    };
    CHECK_CHANGES(CHANGES);
    wg_file file;
    CHECK_EQ(wg_open(&file, &file, 0), WG_ERR_SHORT);
}

int main(void)
{
    TEST(accepts_every_section);
    TEST(rejects_truncation_at_every_byte);
    TEST(rejects_sealed_truncation_at_every_byte);
    TEST(rejects_every_single_byte_corruption);
    TEST(rejects_misaligned_start);
    TEST(ignores_bytes_after_length);
    TEST(accepts_newer_minor_and_unknown_sections);
    TEST(rejects_bad_header_and_directory);
    TEST(rejects_bad_channels_clips_and_tracks);
    TEST(rejects_bad_runs_and_times);
    TEST(rejects_bad_events_layers_filters_triggers_servos);
    TEST(rejects_a_bad_track_of_no_clip);
    TEST(accepts_the_most_records_and_no_more);
    TEST(rejects_absurd_counts);
    TEST(rejects_absurd_lengths);
    return check_done();
}
