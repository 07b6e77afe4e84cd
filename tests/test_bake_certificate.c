/* The certificate: the start-up mix beside its doubles, servos over seams, warnings.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#define _POSIX_C_SOURCE 200809L
#include "certify.h"
#include "check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* jaw runs from 0 to 20 deg in a second at a constant 20 deg/s, there and back. */
static const char CHANNELS[] = "name: small\n"
                               "channels:\n"
                               "  - {name: jaw, unit: deg, tolerance: 0.01}\n"
                               "  - {name: ear, unit: deg, rest: 2, tolerance: 0.01}\n"
                               "  - {name: brow, unit: deg, tolerance: 0.01}\n";
static const char TALK[] =
    "clips:\n"
    "  - name: talk\n"
    "    duration: 1 s\n"
    "    end: pingpong\n"
    "    events: [{time: 0.5, name: click}]\n"
    "    curves:\n"
    "      - {channel: jaw, kind: linear, keys: [{time: 0, value: 0}, {time: 1, value: 20}]}\n"
    "      - {channel: ear, kind: wiggly, frequency: 2, damping: 0.1, keys: [{time: 0, value: 0}, "
    "{time: 0.4, value: 9}, {time: 1, value: 3}]}\n"
    "  - name: nudge\n"
    "    additive: true\n"
    "    curves:\n"
    "      - {channel: ear, kind: cubic, keys: [{time: 0, value: 0}, {time: 0.3, value: 5}, "
    "{time: 0.7, value: 0}]}\n"
    "masks:\n"
    "  - {name: half, weights: {ear: 0.5}}\n"
    "layers:\n"
    "  - {name: base, clip: talk, weight: 0.9}\n"
    "  - {name: over, clip: nudge, mode: add, mask: half}\n";
static const char FILTERS[] = "filters:\n"
                              "  - {op: gain, channel: jaw, value: -1.3, about: 2}\n"
                              "  - {op: offset, channel: ear, value: 1.37}\n"
                              "  - {op: matrix, channels: [jaw, ear, brow], rows: [[1, 0.3, 0], "
                              "[0, 1, -0.13], [0.5, 0, 1]]}\n"
                              "  - {op: clamp, channel: ear, min: 0, max: 9}\n"
                              "  - {op: minimum, channel: brow, value: -8}\n";
static const char TRIGGER[] = "triggers:\n"
                              "  - {event: click, layer: over, clip: nudge, fade: 0.1}\n";
static const char SERVOS[] =
    "servos:\n"
    "  - {name: jaw, channel: jaw, protocol: none, id: 1, per_unit: 10 us, centre: 1500 us, "
    "min: 1000 us, max: 1600 us, velocity: 100 us/s}\n"
    "  - {name: brow, channel: brow, protocol: maestro, id: 2, per_unit: 10 us, centre: 1500 us, "
    "min: 1000 us, max: 2000 us}\n";

static scene s;
static build b;
static wg_file file;

/* Bakes the parts, each a piece of a scene file. */
static void bake(const char *const *parts)
{
    char path[] = "/tmp/wiggly_certificate_XXXXXX";
    bake_error error = {""};
    int line = mkstemp(path);
    FILE *to = line < 0 ? NULL : fdopen(line, "w");
    if (to == NULL) {
        perror(path);
        exit(1);
    }
    for (; *parts; parts++) {
        fputs(*parts, to);
    }
    fclose(to);
    if (scene_load(path, &s, &error) < 0 || build_make(&s, 0, &b, &error) < 0) {
        printf("%s\n", error.text);
        exit(1);
    }
    CHECK_EQ(wg_open(&file, b.file.at, (uint32_t)b.file.count), 0);
    remove(path);
}

static void done(certificate *c)
{
    certificate_free(c);
    build_free(&b);
    scene_free(&s);
}

static certificate certified(void)
{
    certificate c;
    bake_error error = {""};
    CHECK_EQ(certify(&b, &file, b.file.count, &c, &error), 0);
    return c;
}

static const certificate_servo *servo_row(const certificate *c, int clip, int servo)
{
    for (int i = 0; i < c->servo_count; i++) {
        if (c->servo[i].clip == clip && c->servo[i].servo == servo) {
            return &c->servo[i];
        }
    }
    printf("no row of servo %d in clip %d\n", servo, clip);
    exit(1);
}

static const certificate_channel *mix_row(const certificate *c, int channel)
{
    return &c->channel[c->channel_count - s.channel_count + channel];
}

/* Every operation is in the scene; the player stays within the bound carried through them, and the
 * bound stays near the sum it is derived from: brow has no tolerance of its own but gets jaw's,
 * 0.9 times 4/3, gain 1.3 and then 0.5; ear's, 0.9 + 0.5 times. */
static void mix_is_within_its_bound(void)
{
    bake((const char *const[]){CHANNELS, TALK, FILTERS, SERVOS, NULL});
    certificate c = certified();
    CHECK_EQ(c.failed, 0);
    CHECK_NEAR(c.mix_seconds, 2.08, 1e-9);
    CHECK_NEAR(c.mix_compared, 2.08, 1e-9);
    const double tolerance = 0.01 * 4 / 3, jaw = 1.3 * 0.9 * tolerance, ear = 1.4 * tolerance;
    CHECK_NEAR(mix_row(&c, 0)->tolerance, jaw + 0.3 * ear, 0.005);
    CHECK_NEAR(mix_row(&c, 1)->tolerance, ear, 0.005);
    CHECK_NEAR(mix_row(&c, 2)->tolerance, 0.5 * jaw, 0.005);
    for (int i = 0; i < s.channel_count; i++) {
        CHECK_EQ(mix_row(&c, i)->clip, CERTIFY_MIX);
        CHECK_EQ(mix_row(&c, i)->channel, i);
        CHECK(mix_row(&c, i)->largest > 0);
    }
    done(&c);
}

/* The same file against a scene that differs in one number: each makes the mix fail. */
static void mix_notices_every_wrong_number(void)
{
    double *wrong[8];
    for (int k = 0; k < 8; k++) {
        bake((const char *const[]){CHANNELS, TALK, FILTERS, SERVOS, NULL});
        wrong[0] = &s.filters[0].a;
        wrong[1] = &s.filters[0].b;
        wrong[2] = &s.filters[1].a;
        wrong[3] = &s.filters[2].matrix[2][0];
        wrong[4] = &s.filters[3].b;
        wrong[5] = &s.filters[4].a;
        wrong[6] = &s.layers[0].weight;
        wrong[7] = &s.masks[0].weight[1];
        *wrong[k] *= 1.05;
        certificate c = certified();
        CHECK(c.failed > 0);
        done(&c);
    }
}

static void mix_is_compared_until_a_trigger_fires(void)
{
    bake((const char *const[]){CHANNELS, TALK, FILTERS, TRIGGER, SERVOS, NULL});
    certificate c = certified();
    CHECK_EQ(c.failed, 0);
    CHECK_NEAR(c.mix_seconds, 2.08, 1e-9);
    CHECK_NEAR(c.mix_compared, 0.5, 1e-9); /* the head leaves the event in the frame after it */
    done(&c);
}

/* A scene without layers plays its first clip on one of its own. */
static void no_layers_mean_the_first_clip(void)
{
    char clips[sizeof TALK];
    memcpy(clips, TALK, sizeof TALK);
    *strstr(clips, "layers:") = 0;
    bake((const char *const[]){CHANNELS, clips, SERVOS, NULL});
    certificate c = certified();
    CHECK(c.mix_seconds > 0);
    CHECK_EQ(s.layer_count, 1);
    CHECK_EQ(s.layers[0].clip, 0);
    CHECK(strcmp(s.layers[0].name, "base") == 0);
    done(&c);
}

/* 20 deg/s are 200 us/s, in quarter microseconds for protocol none too. Where a ping-pong clip
 * turns, velocity changes by 400 us/s within a frame of 20 ms. 100 us/s is exceeded by all frames
 * after the first of 105 (0 .. 2.08 s), 1600 us from 0.52 to 1.48 s: both ways. */
static void ping_pong_turns_within_a_frame(void)
{
    bake((const char *const[]){CHANNELS, TALK, SERVOS, NULL});
    certificate c = certified();
    const certificate_servo *row = servo_row(&c, 0, 0);
    CHECK(strcmp(servo_unit(s.servos[0].protocol), "us") == 0);
    CHECK_NEAR(row->low, 1500, 0.2);
    CHECK_NEAR(row->high, 1700, 0.2);
    CHECK_NEAR(row->velocity, 200, 2);
    CHECK_NEAR(row->acceleration, 400 / 0.02, 200);
    CHECK_EQ(row->limited, 104);
    CHECK_EQ(row->clipped, 49);
    done(&c);
}

/* A servo on a channel that only a matrix moves has a row: 0.9 of 20 deg mirrored about 2 with
 * 1.3, by half: 0.5 (4.6 - 1.3 0.9 q) deg, q up to 20 -> down to -9.4, held at -8. */
static void filtered_servos_are_certified_filtered(void)
{
    bake((const char *const[]){CHANNELS, TALK, FILTERS, SERVOS, NULL});
    certificate c = certified();
    const certificate_servo *row = servo_row(&c, CERTIFY_MIX, 1);
    CHECK_NEAR(row->high, 1500 + 10 * 2.3, 0.2);
    CHECK_NEAR(row->low, 1500 - 10 * 8.0, 0.2);
    CHECK_NEAR(row->velocity, 0.5 * 1.3 * 0.9 * 200, 2);
    CHECK_EQ(row->clipped, 0);
    done(&c);
}

static int count(const char *text, const char *word)
{
    int n = 0;
    for (; (text = strstr(text, word)) != NULL; text++) {
        n++;
    }
    return n;
}

static void warnings_name_seams_and_servos(void)
{
    static const char LOOP[] =
        "clips:\n"
        "  - name: walk\n"
        "    duration: 1 s\n"
        "    end: loop\n"
        "    curves:\n"
        "      - {channel: jaw, kind: linear, keys: [{time: 0, value: 0}, {time: 1, value: 3}]}\n"
        "      - {channel: ear, kind: cubic, end: free, keys: [{time: 0, value: 0}, {time: 0.4, "
        "value: 9}, "
        "{time: 1, value: 0}]}\n"
        "      - {channel: brow, kind: cubic, periodic: true, keys: [{time: 0, value: 0}, {time: "
        "0.4, value: 9}, {time: 1, value: 0}]}\n"
        "layers:\n"
        "  - {name: base, clip: walk}\n";
    char text[4096] = "";
    bake((const char *const[]){CHANNELS, LOOP, SERVOS, NULL});
    certificate c = certified();
    FILE *to = tmpfile();
    certificate_warn(&b, &c, to);
    rewind(to);
    text[fread(text, 1, sizeof text - 1, to)] = 0;
    fclose(to);
    CHECK_EQ(count(text, "warning: "), 3);
    CHECK_EQ(count(text, "clip walk, channel jaw: where the loop begins again the value jumps by "
                         "-3 deg;"),
             1);
    CHECK_EQ(count(text, "channel ear: where the loop begins again the velocity jumps by"), 1);
    CHECK_EQ(count(text, "servo jaw: 1 frames"), 1);
    CHECK_EQ(count(text, "servo brow"), 0);
    done(&c);
}

int main(void)
{
    TEST(mix_is_within_its_bound);
    TEST(mix_notices_every_wrong_number);
    TEST(mix_is_compared_until_a_trigger_fires);
    TEST(no_layers_mean_the_first_clip);
    TEST(ping_pong_turns_within_a_frame);
    TEST(filtered_servos_are_certified_filtered);
    TEST(warnings_name_seams_and_servos);
    return check_done();
}
