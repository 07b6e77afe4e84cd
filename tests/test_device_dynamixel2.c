/* Dynamixel 2.0 packets against the published ones, the status parser, whole frames.
 * SPDX-License-Identifier: MIT */
#include "device_clip.h"
#include "dynamixel2.h"

typedef struct {
    const char *name;
    uint8_t id, instruction, params[12], count;
} packet;

/* Packets of the Dynamixel e-manual: what they say there, without header, length, stuffing, CRC. */
static const packet packets[] = {
    {"dxl2_ping_id1", 1, 0x01, {0}, 0},
    {"dxl2_ping_status_id1", 1, 0x55, {0, 0x06, 0x04, 0x26}, 4},
    {"dxl2_ping_status_id2", 2, 0x55, {0, 0x06, 0x04, 0x26}, 4},
    {"dxl2_ping_broadcast", 0xfe, 0x01, {0}, 0},
    {"dxl2_read_present_pos", 1, 0x02, {132, 0, 4, 0}, 4},
    {"dxl2_read_status_166", 1, 0x55, {0, 166, 0, 0, 0}, 5},
    {"dxl2_write_goal_512", 1, 0x03, {116, 0, 0, 2, 0, 0}, 6},
    {"dxl2_status_ok_id1", 1, 0x55, {0}, 1},
    {"dxl2_reg_write_vel_200", 1, 0x04, {104, 0, 200, 0, 0, 0}, 6},
    {"dxl2_action", 1, 0x05, {0}, 0},
    {"dxl2_factory_reset_opt1", 1, 0x06, {1}, 1},
    {"dxl2_reboot", 1, 0x08, {0}, 0},
    {"dxl2_clear_multiturn", 1, 0x10, {0x01, 0x44, 0x58, 0x4c, 0x22}, 5},
    {"dxl2_sync_read_pos_1_2", 0xfe, 0x82, {132, 0, 4, 0, 1, 2}, 6},
    {"dxl2_sync_read_status_id2", 2, 0x55, {0, 0x1f, 0x08, 0, 0}, 5},
    {"dxl2_bulk_read", 0xfe, 0x92, {1, 144, 0, 2, 0, 2, 146, 0, 1, 0}, 10},
    {"dxl2_bulk_status_id1", 1, 0x55, {0, 0x77, 0}, 3},
    {"dxl2_bulk_status_id2", 2, 0x55, {0, 0x24}, 2},
    {"dxl2_stuffing_goal_00FDFFFF", 1, 0x03, {116, 0, 0xff, 0xff, 0xfd, 0}, 6},
};

static int build_dynamixel(const char *name, uint8_t *out, uint16_t size)
{
    for (size_t i = 0; i < sizeof packets / sizeof *packets; i++) {
        const packet *p = &packets[i];
        wg_dynamixel2 request = {p->id, p->instruction, p->params, p->count};
        if (strcmp(p->name, name) == 0) {
            return wg_dynamixel2_packet(&request, out, size);
        }
    }
    if (strcmp(name, "dxl2_sync_write_150_170") == 0) {
        clip_clear();
        clip_servo(WG_PROTOCOL_DYNAMIXEL2, 1, 150);
        clip_servo(WG_PROTOCOL_DYNAMIXEL2, 2, 170);
        return wg_dynamixel2_frame(&file, servos, out, size);
    }
    return NO_SUCH_VECTOR;
}

static void check_dynamixel(const char *name, const uint8_t *want, int count)
{
    uint8_t out[64] = {0};

    compare(name, build_dynamixel(name, out, sizeof out), out, want, count);
    check_shorter(build_dynamixel, name, count);
}

static void dynamixel2_packets_match_every_published_one(void)
{
    CHECK_EQ(each_vector("dxl2_", check_dynamixel), 20);
}

/* ---- status packets -------------------------------------------------------------------------- */

static wg_dynamixel2_reader reader;
static wg_dynamixel2_status status;

static int feed(const uint8_t *bytes, int count)
{
    int packets_seen = 0;

    for (int i = 0; i < count; i++) {
        packets_seen += wg_dynamixel2_feed(&reader, bytes[i], &status);
    }
    return packets_seen;
}

static void check_status(const char *name, const uint8_t *bytes, int count)
{
    int is_status = strstr(name, "status") != NULL;

    memset(&reader, 0, sizeof reader);
    CHECK_EQ(feed(bytes, count), is_status);
    for (size_t i = 0; is_status && i < sizeof packets / sizeof *packets; i++) {
        const packet *p = &packets[i];
        if (strcmp(p->name, name) == 0) {
            CHECK_EQ(status.id, p->id);
            CHECK_EQ(status.error, p->params[0]);
            CHECK_EQ(status.param_count, p->count - 1);
            CHECK(memcmp(status.params, p->params + 1, (size_t)p->count - 1) == 0);
            CHECK_EQ(reader.dropped, 0);
        }
    }
}

static void dynamixel2_reader_takes_status_packets_and_nothing_else(void)
{
    CHECK_EQ(each_vector("dxl2_", check_status), 20);
}

static int make_status(uint8_t id, const uint8_t *params, uint16_t count, uint8_t *out)
{
    wg_dynamixel2 request = {id, WG_DYNAMIXEL2_STATUS, params, count};

    return wg_dynamixel2_packet(&request, out, 64);
}

static void dynamixel2_reader_removes_stuffing(void)
{
    static const uint8_t params[] = {0,    0xff, 0xff, 0xfd, 0xff, 0xff, 0xfd,
                                     0xff, 0xff, 0xfd, 0xff, 0xff, 0xfd};
    uint8_t out[64];
    int n = make_status(7, params, 13, out);

    CHECK_EQ(n, 8 + 13 + 4 + 2);
    memset(&reader, 0, sizeof reader);
    CHECK_EQ(feed(out, n), 1);
    CHECK_EQ(status.param_count, 12);
    CHECK(memcmp(status.params, params + 1, 12) == 0);
}

static void dynamixel2_reader_finds_packets_behind_and_inside_garbage(void)
{
    static const uint8_t params[] = {0, 1, 2};
    uint8_t line[64] = {0xff, 0xff, 0xff, 0xfd, 0, 9, 12, 0, 0x55}; /* a start that is none */
    int n = make_status(7, params, 3, line + 9);

    memset(&reader, 0, sizeof reader);
    CHECK_EQ(feed(line, 9 + n), 1);
    CHECK_EQ(status.id, 7);
    CHECK_EQ(reader.dropped, 9);
}

static void dynamixel2_reader_refuses_packets_without_error_byte_or_with_too_many_parameters(void)
{
    static const uint8_t params[2 + WG_DYNAMIXEL2_PARAMS_MAX] = {0};
    uint8_t out[64];

    memset(&reader, 0, sizeof reader);
    CHECK_EQ(feed(out, make_status(1, params, 0, out)), 0);
    CHECK_EQ(feed(out, make_status(1, params, sizeof params, out)), 0);
    CHECK_EQ(feed(out, make_status(1, params, sizeof params - 1, out)), 1);
    CHECK_EQ(status.param_count, WG_DYNAMIXEL2_PARAMS_MAX);
}

static void dynamixel2_reader_refuses_every_flipped_bit(void)
{
    static const uint8_t params[] = {0, 0xa6, 0, 0, 0};
    uint8_t out[64], bad[64];
    int n = make_status(1, params, 5, out);

    for (int bit = 0; bit < 8 * n; bit++) {
        memcpy(bad, out, sizeof bad);
        bad[bit / 8] = (uint8_t)(bad[bit / 8] ^ 1 << bit % 8);
        memset(&reader, 0, sizeof reader);
        CHECK_EQ(feed(bad, n), 0);
        /* A flipped length may leave the reader waiting: 40 quiet bytes free it. */
        memset(bad, 0, sizeof bad);
        CHECK_EQ(feed(bad, 40), 0);
        CHECK_EQ(feed(out, n), 1);
    }
}

static void dynamixel2_reader_survives_random_bytes(void)
{
    static const uint8_t alphabet[] = {0xff, 0xff, 0xff, 0xfd, 0xfd, 0, 0, 4, 5, 0x55, 1};
    uint8_t out[64], params[] = {0};
    uint32_t x = 88172645u;
    int n = make_status(3, params, 1, out);

    memset(&reader, 0, sizeof reader);
    for (int i = 0; i < 400000; i++) {
        x ^= x << 13;
        x ^= x >> 17;
        x ^= x << 5;
        wg_dynamixel2_feed(&reader, alphabet[x % sizeof alphabet], &status);
        CHECK(reader.count < WG_DYNAMIXEL2_READER_BYTES);
    }
    memset(params, 0, sizeof params);
    for (int i = 0; i < 40; i++) {
        wg_dynamixel2_feed(&reader, 0, &status);
    }
    CHECK_EQ(feed(out, n), 1);
}

static void dynamixel2_refuses_ids_253_and_255(void)
{
    uint8_t out[32];
    wg_dynamixel2 request = {253, WG_DYNAMIXEL2_PING, NULL, 0};

    CHECK_EQ(wg_dynamixel2_packet(&request, out, sizeof out), WG_ERR_ADDRESS);
    request.id = 255;
    CHECK_EQ(wg_dynamixel2_packet(&request, out, sizeof out), WG_ERR_ADDRESS);
    request.id = 252;
    CHECK_EQ(wg_dynamixel2_packet(&request, out, sizeof out), 10);
}

/* ---- whole frames ---------------------------------------------------------------------------- */

static void dynamixel2_frame_leaves_out_servos_that_are_off(void)
{
    uint8_t out[64];

    clip_clear();
    clip_servo(WG_PROTOCOL_DYNAMIXEL2, 1, 0);
    CHECK_EQ(wg_dynamixel2_frame(&file, servos, out, sizeof out), 0);
    clip_servo(WG_PROTOCOL_DYNAMIXEL2, 2, 100);
    CHECK_EQ(wg_dynamixel2_frame(&file, servos, out, sizeof out), 19);
    CHECK_EQ(out[12], 2);
}

static void dynamixel2_frame_leaves_out_ids_that_no_servo_has(void)
{
    uint8_t out[64];

    clip_clear();
    clip_servo(WG_PROTOCOL_DYNAMIXEL2, 253, -1);
    clip_servo(WG_PROTOCOL_DYNAMIXEL2, 254, -1);
    clip_servo(WG_PROTOCOL_DYNAMIXEL2, 255, -1);
    CHECK_EQ(wg_dynamixel2_frame(&file, servos, out, sizeof out), 0);
}

/* FF FF FD in the goals would take an id of 253 or 255, so every position needs the same bytes. */
static void dynamixel2_frames_never_need_stuffing(void)
{
    uint8_t out[64];

    for (int32_t position = -32768; position < 32768; position++) {
        int16_t at = (int16_t)(position ? position : 1);
        int got;
        clip_clear();
        clip_servo(WG_PROTOCOL_DYNAMIXEL2, 252, at);
        clip_servo(WG_PROTOCOL_DYNAMIXEL2, 0, at);
        got = wg_dynamixel2_frame(&file, servos, out, sizeof out);
        CHECK_EQ(got, 24);
        CHECK_EQ(out[5] | out[6] << 8, 17);
        CHECK_EQ((int16_t)(out[13] | out[14] << 8), at);
        CHECK_EQ(out[15] | out[16], position < 0 ? 0xff : 0);
    }
}

static void dynamixel2_frames_of_every_length_fit_the_macro(void)
{
    static uint8_t out[WG_BUS_BYTES(SERVOS)];

    for (uint16_t n = 1; n <= SERVOS; n++) {
        clip_clear();
        for (int i = 0; i < n; i++) {
            clip_servo(WG_PROTOCOL_DYNAMIXEL2, (uint8_t)(252 - i), (int16_t)(i % 2 ? 0xfdff : -1));
        }
        CHECK_EQ(wg_dynamixel2_frame(&file, servos, out, (uint16_t)WG_BUS_BYTES(n)), 14 + 5 * n);
        CHECK_EQ(wg_dynamixel2_frame(&file, servos, out, (uint16_t)(13 + 5 * n)), WG_ERR_SPACE);
    }
}

int main(void)
{
    TEST(dynamixel2_packets_match_every_published_one);
    TEST(dynamixel2_reader_takes_status_packets_and_nothing_else);
    TEST(dynamixel2_reader_removes_stuffing);
    TEST(dynamixel2_reader_finds_packets_behind_and_inside_garbage);
    TEST(dynamixel2_reader_refuses_packets_without_error_byte_or_with_too_many_parameters);
    TEST(dynamixel2_reader_refuses_every_flipped_bit);
    TEST(dynamixel2_reader_survives_random_bytes);
    TEST(dynamixel2_refuses_ids_253_and_255);
    TEST(dynamixel2_frame_leaves_out_servos_that_are_off);
    TEST(dynamixel2_frame_leaves_out_ids_that_no_servo_has);
    TEST(dynamixel2_frames_never_need_stuffing);
    TEST(dynamixel2_frames_of_every_length_fit_the_macro);
    return check_done();
}
