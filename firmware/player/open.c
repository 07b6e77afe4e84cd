/* Opening a clip: the one place where anything is checked (SPEC 5).
 * Source: own. After wg_open the evaluator reads without looking: each check names the read it
 * makes safe.
 * SPDX-License-Identifier: MIT */
#include "fix.h"
#include "open.h"

/* CRC-32 (ISO-HDLC) bit by bit: no table, because it runs once. Rounds: 8 a byte. */
static uint32_t crc32(const uint8_t *at, uint32_t bytes)
{
    uint32_t crc = UINT32_C(0xffffffff);
    for (uint32_t i = 0; i < bytes; i++) {
        crc ^= wg_rd8(at + i);
        for (unsigned bit = 0; bit < 8; bit++) {
            crc = (crc >> 1) ^ (UINT32_C(0xedb88320) & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

static int check_header(const uint8_t *clip, uint32_t size)
{
    if (size < WG_HEADER_BYTES) {
        return WG_ERR_SHORT;
    }
    if (wg_rd32(clip) != WG_FORMAT_MAGIC) {
        return WG_ERR_MAGIC;
    }
    if (wg_rd8(clip + WG_HEADER_MAJOR) != WG_FORMAT_MAJOR) {
        return WG_ERR_VERSION;
    }
    uint32_t length = wg_rd32(clip + WG_HEADER_LENGTH);
    if (length > size || length < WG_HEADER_BYTES) {
        return WG_ERR_SHORT;
    }
    if (crc32(clip + WG_HEADER_MAJOR, length - WG_HEADER_MAJOR) != wg_rd32(clip + WG_HEADER_CRC)) {
        return WG_ERR_CRC;
    }
    return 0;
}

/* What a section of each kind may hold: up to 2^bits records, or one less with LESS; a record's size,
 * 0 = no fixed one. */
typedef struct {
    uint8_t bits, stride;
} section_limit;

#define LESS 0x80u
#define ANY  (16u | LESS)

static WG_TABLE const section_limit LIMIT[WG_SECTION_KNOWN + 1] = {{0, 0},
                                                                   {8, WG_CHANNEL_BYTES},
                                                                   {8 | LESS, WG_CLIP_BYTES},
                                                                   {ANY, WG_TRACK_BYTES},
                                                                   {ANY, WG_RUN_BYTES},
                                                                   {ANY, 0}, /* DATA */
                                                                   {ANY, WG_EVENT_BYTES},
                                                                   {8 | LESS, 0}, /* MASKS */
                                                                   {3, WG_LAYER_BYTES},
                                                                   {8, WG_FILTER_BYTES},
                                                                   {5, WG_TRIGGER_BYTES},
                                                                   {6, WG_SERVO_BYTES},
                                                                   {ANY, 0}, /* NAMES */
                                                                   {4, WG_SHAPE_BYTES},
                                                                   {11, WG_BASIS_BYTES},
                                                                   {ANY, WG_BLOCK_BYTES},
                                                                   {6, WG_PART_BYTES},
                                                                   {4, WG_VIEW_BYTES},
                                                                   {12, WG_BONE_BYTES},
                                                                   {ANY, WG_JOINT_BYTES},
                                                                   {4, WG_SKIN_BYTES},
                                                                   {ANY, WG_SPAN_BYTES},
                                                                   {8, WG_FIELD_BYTES},
                                                                   {6, WG_PAINT_BYTES}};

WG_STATIC_ASSERT(WG_CHANNELS_MAX == 1u << 8 && WG_CLIPS_MAX == (1u << 8) - 1u);
WG_STATIC_ASSERT(WG_MASKS_MAX == (1u << 8) - 1u && WG_LAYERS_MAX == 1u << 3);
WG_STATIC_ASSERT(WG_FILTERS_MAX == 1u << 8 && WG_TRIGGERS_MAX == 1u << 5);
WG_STATIC_ASSERT(WG_SERVOS_MAX == 1u << 6 && WG_SHAPES_MAX == 1u << 4);
WG_STATIC_ASSERT(WG_SHAPES_MAX *WG_BASES_MAX == 1u << 11 && WG_PARTS_MAX == 1u << 6);
WG_STATIC_ASSERT(WG_VIEWS_MAX == 1u << 4 && WG_BONES_ALL == 1u << 12);
WG_STATIC_ASSERT(WG_SKINS_MAX == 1u << 4 && WG_FIELDS_MAX == 1u << 8);

/* Kinds ascend strictly, sections lie inside the file on multiples of 4, records fill them. */
static int read_directory(wg_file *file, const uint8_t *clip)
{
    uint32_t length = wg_rd32(clip + WG_HEADER_LENGTH);
    uint16_t sections = wg_rd16(clip + WG_HEADER_SECTIONS);
    uint16_t previous = 0;
    uint32_t first = WG_HEADER_BYTES + sections * WG_DIRECTORY_BYTES;
    if (sections > WG_SECTIONS_MAX || first > length) {
        return WG_ERR_DIRECTORY;
    }
    const uint8_t *entry = clip + WG_HEADER_BYTES;
    for (; sections > 0; sections--, entry += WG_DIRECTORY_BYTES) {
        uint16_t kind = wg_rd16(entry), count = wg_rd16(entry + 2);
        uint32_t offset = wg_rd32(entry + 4), bytes = wg_rd32(entry + 8);
        if (kind <= previous || offset % 4u != 0 || offset < first || offset > length ||
            bytes > length - offset) {
            return WG_ERR_DIRECTORY;
        }
        previous = kind;
        if (kind > WG_SECTION_KNOWN) {
            continue; /* a newer minor version's: skipped */
        }
        uint8_t stride = wg_rd8(&LIMIT[kind].stride), bits = wg_rd8(&LIMIT[kind].bits);
        if ((uint32_t)count + (bits >> 7) > UINT32_C(1) << (bits & 31u) ||
            (stride != 0 && bytes != (uint32_t)count * stride)) {
            return WG_ERR_DIRECTORY;
        }
        wg_section section = {clip + offset, bytes, count};
        file->section[kind] = section;
    }
    return 0;
}

static int check_channels(const wg_file *file)
{
    uint16_t count = file->section[WG_SECTION_CHANNELS].count;
    for (uint16_t i = 0; i < count; i++) {
        const uint8_t *r = wg_record(file, WG_SECTION_CHANNELS, i, WG_CHANNEL_BYTES);
        uint8_t frac = wg_rd8(r + WG_CHANNEL_FRAC);
        if ((frac > 30 && frac < 256 - 30) || !wg_is_small(wg_rd32(r + WG_CHANNEL_REST))) {
            return WG_ERR_CHANNEL;
        }
    }
    return count == 0 ? WG_ERR_CHANNEL : 0;
}

/* End ticks ascend strictly from the run's start, so every segment is at least a tick long. */
static int check_times(const wg_file *file, const uint8_t *run)
{
    uint16_t count = wg_rd16(run + WG_RUN_SEGMENTS);
    const uint8_t *times = file->section[WG_SECTION_DATA].at + wg_rd32(run + WG_RUN_TIMES);
    uint16_t previous = wg_rd16(run + WG_RUN_START);
    for (uint16_t i = 0; i < count; i++) {
        uint16_t end = wg_rd16(times + 2u * i);
        if (end <= previous) {
            return WG_ERR_TIMES;
        }
        previous = end;
    }
    return 0;
}

/* Bytes of parameters and knots or coefficients of a run (SPEC 4.4). */
static uint64_t run_bytes(uint8_t kind, uint16_t segments)
{
    if (kind <= WG_KIND_CUBIC) {
        return ((uint64_t)segments + 1u) * (kind == WG_KIND_CUBIC ? 4u : 2u);
    }
    uint32_t params = kind == WG_KIND_OSC || kind == WG_KIND_EXP ? 2u : 1u;
    return params * WG_PARAM_BYTES + (uint64_t)segments * 8u;
}

static bool is_aux(uint8_t kind, uint8_t aux)
{
    if (kind <= WG_KIND_CUBIC) {
        return aux <= (kind == WG_KIND_CUBIC ? WG_RUN_VELOCITY_SHIFT_MAX : 0);
    }
    unsigned first = kind == WG_KIND_OSC0 ? 0 : WG_RUN_SINH_SHIFT_MAX;
    unsigned second = kind == WG_KIND_EXP ? WG_RUN_SINH_SHIFT_MAX : 0;
    return (aux & 15u) <= first && (aux >> 4) <= second;
}

/* Turns a tick are signed 32 bits in the evaluator. */
static bool is_trig_rate(const wg_file *file, const uint8_t *run, uint8_t kind)
{
    if (kind != WG_KIND_OSC && kind != WG_KIND_OSC0) {
        return true;
    }
    const uint8_t *data = file->section[WG_SECTION_DATA].at + wg_rd32(run + WG_RUN_DATA);
    return wg_rd32(data + (kind == WG_KIND_OSC ? WG_PARAM_BYTES : 0u) + WG_PARAM_RATE) >> 31 == 0;
}

static int check_run(const wg_file *file, const uint8_t *run)
{
    uint16_t segments = wg_rd16(run + WG_RUN_SEGMENTS);
    uint8_t kind = wg_rd8(run + WG_RUN_KIND);
    uint32_t unit = kind <= WG_KIND_CUBIC ? 2u : 4u;
    if (kind >= WG_KIND_COUNT || segments == 0 || wg_rd8(run + WG_RUN_SHIFT) > WG_RUN_SHIFT_MAX ||
        !is_aux(kind, wg_rd8(run + WG_RUN_AUX)) || !wg_is_small(wg_rd32(run + WG_RUN_BASE)) ||
        !wg_is_data(file, wg_rd32(run + WG_RUN_TIMES), 2u * (uint64_t)segments, 2) ||
        !wg_is_data(file, wg_rd32(run + WG_RUN_DATA), run_bytes(kind, segments), unit) ||
        !is_trig_rate(file, run, kind)) {
        return WG_ERR_RUN;
    }
    return 0;
}

/* Every run, used or not: once, however many tracks share it. */
static int check_runs(const wg_file *file)
{
    for (uint16_t i = 0; i < file->section[WG_SECTION_RUNS].count; i++) {
        const uint8_t *run = wg_record(file, WG_SECTION_RUNS, i, WG_RUN_BYTES);
        int err = check_run(file, run);
        if (err == 0) {
            err = check_times(file, run);
        }
        if (err < 0) {
            return err;
        }
    }
    return 0;
}

static uint16_t run_end(const wg_file *file, const uint8_t *run)
{
    uint32_t last = wg_rd16(run + WG_RUN_SEGMENTS) - 1u;
    return wg_rd16(file->section[WG_SECTION_DATA].at + wg_rd32(run + WG_RUN_TIMES) + 2u * last);
}

/* The runs of a track are contiguous from tick 0. */
static int check_track(const wg_file *file, const uint8_t *track)
{
    uint16_t first = wg_rd16(track + WG_TRACK_RUN_FIRST);
    uint16_t count = wg_rd16(track + WG_TRACK_RUN_COUNT);
    if (count == 0 || !wg_is_range(first, count, file->section[WG_SECTION_RUNS].count) ||
        wg_rd16(track + WG_TRACK_CHANNEL) >= file->section[WG_SECTION_CHANNELS].count) {
        return WG_ERR_TRACK;
    }
    const uint8_t *run = wg_record(file, WG_SECTION_RUNS, first, WG_RUN_BYTES);
    if (wg_rd16(run + WG_RUN_START) != 0) {
        return WG_ERR_TRACK;
    }
    for (uint16_t i = 1; i < count; i++, run += WG_RUN_BYTES) {
        if (run_end(file, run) != wg_rd16(run + WG_RUN_BYTES + WG_RUN_START)) {
            return WG_ERR_TIMES;
        }
    }
    return 0;
}

/* Every track, in a clip or not: wg_track_value takes them all. */
static int check_tracks(const wg_file *file)
{
    for (uint16_t i = 0; i < file->section[WG_SECTION_TRACKS].count; i++) {
        int err = check_track(file, wg_record(file, WG_SECTION_TRACKS, i, WG_TRACK_BYTES));
        if (err < 0) {
            return err;
        }
    }
    return 0;
}

/* A clip's tracks: by ascending channel, one a channel at the most, and as long as the clip. */
static int check_clip_tracks(const wg_file *file, const uint8_t *clip)
{
    uint16_t first = wg_rd16(clip + WG_CLIP_TRACK_FIRST);
    uint16_t count = wg_rd16(clip + WG_CLIP_TRACK_COUNT);
    if (!wg_is_range(first, count, file->section[WG_SECTION_TRACKS].count)) {
        return WG_ERR_CLIP;
    }
    uint32_t next_channel = 0;
    for (uint16_t i = 0; i < count; i++) {
        const uint8_t *track =
            wg_record(file, WG_SECTION_TRACKS, (uint32_t)first + i, WG_TRACK_BYTES);
        uint32_t last = (uint32_t)wg_rd16(track + WG_TRACK_RUN_FIRST) +
                        wg_rd16(track + WG_TRACK_RUN_COUNT) - 1u;
        if (wg_rd16(track + WG_TRACK_CHANNEL) < next_channel) {
            return WG_ERR_TRACK;
        }
        if (run_end(file, wg_record(file, WG_SECTION_RUNS, last, WG_RUN_BYTES)) !=
            wg_rd16(clip + WG_CLIP_TICKS)) {
            return WG_ERR_TIMES;
        }
        next_channel = (uint32_t)wg_rd16(track + WG_TRACK_CHANNEL) + 1u;
    }
    return 0;
}

static int check_events(const wg_file *file, const uint8_t *clip)
{
    uint16_t first = wg_rd16(clip + WG_CLIP_EVENT_FIRST),
             count = wg_rd16(clip + WG_CLIP_EVENT_COUNT);
    if (!wg_is_range(first, count, file->section[WG_SECTION_EVENTS].count)) {
        return WG_ERR_CLIP;
    }
    uint16_t previous = 0;
    for (uint16_t i = 0; i < count; i++) {
        uint16_t tick =
            wg_rd16(wg_record(file, WG_SECTION_EVENTS, (uint32_t)first + i, WG_EVENT_BYTES) +
                    WG_EVENT_TICK);
        if (tick < previous || tick >= wg_rd16(clip + WG_CLIP_TICKS)) {
            return WG_ERR_EVENT;
        }
        previous = tick;
    }
    return 0;
}

static int check_clips(const wg_file *file)
{
    uint16_t count = file->section[WG_SECTION_CLIPS].count;
    for (uint16_t i = 0; i < count; i++) {
        const uint8_t *clip = wg_clip_record(file, (uint8_t)i);
        if (wg_rd8(clip + WG_CLIP_END) > WG_END_PINGPONG || wg_rd16(clip + WG_CLIP_TICKS) == 0 ||
            wg_rd16(clip + WG_CLIP_RATE) == 0 || wg_rd8(clip + WG_CLIP_MUL_SHIFT) > 40 ||
            wg_rd32(clip + WG_CLIP_MUL) == 0 || wg_clip_duration(file, (uint8_t)i) >> 19 == 0) {
            return WG_ERR_CLIP;
        }
        int err = check_clip_tracks(file, clip);
        if (err == 0) {
            err = check_events(file, clip);
        }
        if (err < 0) {
            return err;
        }
    }
    return count == 0 ? WG_ERR_CLIP : 0;
}

static bool is_clip(const wg_file *file, uint8_t clip)
{
    return clip == WG_NONE || clip < file->section[WG_SECTION_CLIPS].count;
}

static int check_layers(const wg_file *file)
{
    uint16_t masks = file->section[WG_SECTION_MASKS].count;
    if ((uint32_t)masks * file->section[WG_SECTION_CHANNELS].count >
        file->section[WG_SECTION_MASKS].bytes) {
        return WG_ERR_DIRECTORY;
    }
    for (uint16_t i = 0; i < file->section[WG_SECTION_LAYERS].count; i++) {
        const uint8_t *r = wg_record(file, WG_SECTION_LAYERS, i, WG_LAYER_BYTES);
        uint8_t mask = wg_rd8(r + WG_LAYER_MASK);
        if (!is_clip(file, wg_rd8(r + WG_LAYER_CLIP)) || wg_rd8(r + WG_LAYER_MODE) > WG_MODE_ADD ||
            (mask != WG_NONE && mask >= masks) || wg_rd16(r + WG_LAYER_WEIGHT) > WG_WEIGHT_ONE) {
            return WG_ERR_LAYER;
        }
    }
    return 0;
}

static bool is_matrix(const wg_file *file, const uint8_t *filter)
{
    uint32_t n = wg_rd8(filter + WG_FILTER_N), list = wg_rd32(filter + WG_FILTER_A);
    if (n == 0 || n > WG_MATRIX_MAX || !wg_is_data(file, list, 2u * n + 2u * n * n, 2)) {
        return false;
    }
    for (uint32_t i = 0; i < n; i++) {
        if (wg_rd16(file->section[WG_SECTION_DATA].at + list + 2u * i) >=
            file->section[WG_SECTION_CHANNELS].count) {
            return false;
        }
    }
    return true;
}

static int check_filters(const wg_file *file)
{
    for (uint16_t i = 0; i < file->section[WG_SECTION_FILTERS].count; i++) {
        const uint8_t *r = wg_record(file, WG_SECTION_FILTERS, i, WG_FILTER_BYTES);
        uint8_t op = wg_rd8(r + WG_FILTER_OP);
        bool good =
            op == WG_FILTER_MATRIX
                ? is_matrix(file, r)
                : op < WG_FILTER_MATRIX && wg_is_small(wg_rd32(r + WG_FILTER_A)) &&
                      wg_is_small(wg_rd32(r + WG_FILTER_B)) &&
                      wg_rd16(r + WG_FILTER_CHANNEL) < file->section[WG_SECTION_CHANNELS].count;
        if (!good) {
            return WG_ERR_FILTER;
        }
    }
    return 0;
}

static int check_triggers(const wg_file *file)
{
    for (uint16_t i = 0; i < file->section[WG_SECTION_TRIGGERS].count; i++) {
        const uint8_t *r = wg_record(file, WG_SECTION_TRIGGERS, i, WG_TRIGGER_BYTES);
        if (wg_rd8(r + WG_TRIGGER_LAYER) >= file->section[WG_SECTION_LAYERS].count ||
            !is_clip(file, wg_rd8(r + WG_TRIGGER_CLIP))) {
            return WG_ERR_TRIGGER;
        }
    }
    return 0;
}

static int check_servos(const wg_file *file)
{
    for (uint16_t i = 0; i < file->section[WG_SECTION_SERVOS].count; i++) {
        const uint8_t *r = wg_record(file, WG_SECTION_SERVOS, i, WG_SERVO_BYTES);
        if (wg_rd8(r + WG_SERVO_PROTOCOL) >= WG_PROTOCOL_COUNT ||
            wg_rd16(r + WG_SERVO_CHANNEL) >= file->section[WG_SECTION_CHANNELS].count ||
            !wg_is_small(wg_rd32(r + WG_SERVO_OFFSET)) || wg_rd8(r + WG_SERVO_GAIN_SHIFT) > 40 ||
            (int16_t)wg_rd16(r + WG_SERVO_MIN) > (int16_t)wg_rd16(r + WG_SERVO_MAX)) {
            return WG_ERR_SERVO;
        }
    }
    return 0;
}

/* Names end inside their section: `count` NULs, the last byte one of them. */
static int check_names(const wg_file *file)
{
    const wg_section *names = &file->section[WG_SECTION_NAMES];
    uint32_t ends = 0;
    for (uint32_t i = 0; i < names->bytes; i++) {
        ends += wg_rd8(names->at + i) == 0;
    }
    if (ends != names->count || (names->bytes > 0 && wg_rd8(names->at + names->bytes - 1u) != 0)) {
        return WG_ERR_NAME;
    }
    return 0;
}

int wg_open(wg_file *file, const void *clip, uint32_t size)
{
    if ((uintptr_t)clip % 4u != 0) {
        return WG_ERR_ALIGN;
    }
    int err = check_header(clip, size);
    for (unsigned k = 0; k <= WG_SECTION_KNOWN; k++) {
        wg_section none = {clip, 0, 0};
        file->section[k] = none;
    }
    if (err == 0) {
        err = read_directory(file, clip);
    }
    if (err == 0) {
        err = check_channels(file);
    }
    if (err == 0) {
        err = check_runs(file);
    }
    if (err == 0) {
        err = check_tracks(file);
    }
    if (err == 0) {
        err = check_clips(file);
    }
    if (err == 0) {
        err = check_layers(file);
    }
    if (err == 0) {
        err = check_filters(file);
    }
    if (err == 0) {
        err = check_triggers(file);
    }
    if (err == 0) {
        err = check_servos(file);
    }
    return err == 0 ? check_names(file) : err;
}
