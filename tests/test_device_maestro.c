/* Maestro commands against the published ones, whole frames.
 * SPDX-License-Identifier: MIT */
#include "device_clip.h"
#include "maestro.h"

typedef struct {
    const char *name;
    uint16_t options;
    uint8_t command, channel;
    int16_t value; /* -1: a command without arguments */
} maestro;

#define PLAIN   WG_MAESTRO_COMPACT
#define CHECKED (WG_MAESTRO_COMPACT | WG_MAESTRO_CRC)
static const maestro maestros[] = {
    {"maestro_set_target_ch0_1500us_compact", PLAIN, WG_MAESTRO_TARGET, 0, 6000},
    {"maestro_set_target_ch2_1500us_compact", PLAIN, WG_MAESTRO_TARGET, 2, 6000},
    {"maestro_set_target_ch0_1500us_pololu_dev12", 12, WG_MAESTRO_TARGET, 0, 6000},
    {"maestro_set_speed_ch5_140", PLAIN, WG_MAESTRO_SPEED, 5, 140},
    {"maestro_set_target_ch0_1500us_crc", CHECKED, WG_MAESTRO_TARGET, 0, 6000},
    {"maestro_set_target_ch2_1500us_crc", CHECKED, WG_MAESTRO_TARGET, 2, 6000},
    {"maestro_set_target_pololu_crc", 12 | WG_MAESTRO_CRC, WG_MAESTRO_TARGET, 0, 6000},
    {"maestro_go_home_crc", CHECKED, WG_MAESTRO_GO_HOME, 0, -1},
    {"maestro_get_errors_crc", CHECKED, WG_MAESTRO_GET_ERRORS, 0, -1},
};

static int build_maestro(const char *name, uint8_t *out, uint16_t size)
{
    wg_bytes bytes = {out, size, 0};

    for (size_t i = 0; i < sizeof maestros / sizeof *maestros; i++) {
        const maestro *m = &maestros[i];
        if (strcmp(m->name, name) == 0 && m->value < 0) {
            wg_maestro_command(&bytes, m->options, m->command);
            return wg_bytes_result(&bytes);
        }
        if (strcmp(m->name, name) == 0) {
            wg_maestro_set(&bytes, m->options, m->command, m->channel, m->value);
            return wg_bytes_result(&bytes);
        }
    }
    if (strcmp(name, "maestro_minissc_servo0_neutral") == 0) {
        wg_maestro_minissc(&bytes, 0, 127);
        return wg_bytes_result(&bytes);
    }
    if (strcmp(name, "maestro_crc7_example") == 0) {
        out[0] = 0x83;
        out[1] = 0x01;
        out[2] = wg_maestro_crc7(out, 2);
        return 3;
    }
    if (strcmp(name, "maestro_set_multiple_3off_4_6000") == 0) {
        clip_clear();
        clip_servo(WG_PROTOCOL_MAESTRO, 3, 0);
        clip_servo(WG_PROTOCOL_MAESTRO, 4, 6000);
        return wg_maestro_frame(&file, servos, PLAIN, out, size);
    }
    return NO_SUCH_VECTOR;
}

static void check_maestro(const char *name, const uint8_t *want, int count)
{
    uint8_t out[64] = {0};

    compare(name, build_maestro(name, out, sizeof out), out, want, count);
    if (strcmp(name, "maestro_crc7_example") != 0) { /* the bare sum has no buffer */
        check_shorter(build_maestro, name, count);
    }
}

static void maestro_commands_match_every_published_one(void)
{
    CHECK_EQ(each_vector("maestro_", check_maestro), 12);
}

static void maestro_frame_joins_consecutive_ids_only(void)
{
    static const uint8_t want[] = {0x84, 9, 0x70, 0x2e, 0x9f, 3,  4,    0x70, 0x2e,
                                   0,    0, 0x71, 0x2e, 0x84, 12, 0x70, 0x2e};
    uint8_t out[64];

    clip_clear();
    clip_servo(WG_PROTOCOL_MAESTRO, 9, 6000);
    clip_servo(WG_PROTOCOL_MAESTRO, 4, 6000);
    clip_servo(WG_PROTOCOL_MAESTRO, 5, 0);
    clip_servo(WG_PROTOCOL_MAESTRO, 6, 6001);
    clip_servo(WG_PROTOCOL_DYNAMIXEL2, 7, 100);
    clip_servo(WG_PROTOCOL_MAESTRO, 12, 6000);
    CHECK_EQ(wg_maestro_frame(&file, servos, PLAIN, out, sizeof out), sizeof want);
    CHECK(memcmp(out, want, sizeof want) == 0);
    CHECK_EQ(wg_maestro_frame(&file, servos, PLAIN | WG_MAESTRO_SINGLE, out, sizeof out), 20);
    CHECK_EQ(wg_bus_count(&file, WG_PROTOCOL_MAESTRO), 5);
    CHECK_EQ(wg_bus_count(&file, WG_PROTOCOL_PCA9685), 0);
}

static void maestro_options_avoid_what_the_smallest_one_lacks(void)
{
    clip_clear();
    CHECK_EQ(wg_maestro_options(&file), WG_MAESTRO_COMPACT | WG_MAESTRO_SINGLE);
    for (uint8_t id = 0; id < 6; id++) {
        clip_servo(WG_PROTOCOL_MAESTRO, id, 6000);
    }
    clip_servo(WG_PROTOCOL_DYNAMIXEL2, 6, 100);
    CHECK_EQ(wg_maestro_options(&file), WG_MAESTRO_COMPACT | WG_MAESTRO_SINGLE);
    clip_servo(WG_PROTOCOL_MAESTRO, 6, 6000);
    CHECK_EQ(wg_maestro_options(&file), WG_MAESTRO_COMPACT);
}

static void maestro_bytes_after_the_command_have_seven_bits(void)
{
    uint8_t out[64];
    int n;

    for (int32_t position = -32768; position <= 32767; position += 7) {
        clip_clear();
        clip_servo(WG_PROTOCOL_MAESTRO, 0x97, (int16_t)(position ? position : 1));
        n = wg_maestro_frame(&file, servos, 12 | WG_MAESTRO_CRC, out, sizeof out);
        CHECK_EQ(n, 7);
        for (int i = 1; i < n; i++) {
            CHECK(out[i] < 0x80);
        }
    }
}

static void maestro_frames_of_every_length_fit_the_macro(void)
{
    static uint8_t out[WG_BUS_BYTES(SERVOS)];

    for (uint16_t n = 1; n <= SERVOS; n++) {
        for (int pairs = 0; pairs < 2; pairs++) {
            int got, runs = pairs ? n / 2 : 0, singles = n - 2 * runs;
            clip_clear();
            for (int i = 0; i < n; i++) {
                clip_servo(WG_PROTOCOL_MAESTRO, (uint8_t)(pairs ? i + i / 2 : 2 * i), 6000);
            }
            got = wg_maestro_frame(&file, servos, 12 | WG_MAESTRO_CRC, out,
                                   (uint16_t)WG_BUS_BYTES(n));
            CHECK_EQ(got, 10 * runs + 7 * singles);
        }
    }
}

int main(void)
{
    TEST(maestro_commands_match_every_published_one);
    TEST(maestro_frame_joins_consecutive_ids_only);
    TEST(maestro_options_avoid_what_the_smallest_one_lacks);
    TEST(maestro_bytes_after_the_command_have_seven_bits);
    TEST(maestro_frames_of_every_length_fit_the_macro);
    return check_done();
}
