/* wiggly play: a clip on the host, as numbers, as a picture or live on a serial bus.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify.h"
#include "command.h"
#include "plot.h"
#include "record.h"
#include "serial.h"

#include "dynamixel2.h"
#include "maestro.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* One performance: the player as the firmware runs it, frame after frame. */
typedef struct {
    const wg_file *file;
    wg_layer layers[WG_LAYERS_MAX];
    wg_player player;
    int32_t values[WG_CHANNELS_MAX];
    wg_servo servos[WG_SERVOS_MAX];
    uint32_t frame_us;
    long frames;
} stage;

/* All layers as baked, or one clip alone on the first layer. */
static int stage_set(stage *g, const wg_file *file, const option *options, bake_error *error)
{
    const char *name = option_value(options, "--clip");
    int layers = file->section[WG_SECTION_LAYERS].count, clip = 0;
    g->file = file;
    wg_player_init(&g->player, file, g->layers, (uint8_t)(layers > 0 ? layers : 1));
    wg_servo_init(g->servos, file);
    if (name && (clip = clip_find(file, name)) < 0) {
        return bake_fail(error, "the file has no clip named %s; wiggly info lists them", name);
    }
    for (int i = 0; i < layers && name; i++) {
        wg_player_play(&g->player, (uint8_t)i, WG_NONE);
    }
    if (name || layers == 0) {
        wg_player_play(&g->player, 0, (uint8_t)clip);
        wg_player_fade(&g->player, 0, WG_WEIGHT_ONE, 0);
        g->layers[0].mode = WG_MODE_OVERRIDE;
        g->layers[0].mask = WG_NONE;
    }
    double longest = 0;
    for (int i = 0; i < g->player.layer_count; i++) {
        if (g->layers[i].clip != WG_NONE) {
            longest =
                fmax(longest, get32(clip_record(file, g->layers[i].clip) + WG_CLIP_US) * 1e-6);
        }
    }
    double rate = option_number(options, "--rate", 50, error);
    double seconds = option_number(options, "--seconds", longest > 0 ? longest : 1, error);
    g->frame_us = (uint32_t)lround(1e6 / rate);
    g->frames = (long)floor(seconds * 1e6 / g->frame_us + 0.5) + 1;
    return 0;
}

/* Moves the stage to frame `index`; returns the number of events on the way. */
static int stage_step(stage *g, long index)
{
    wg_event event;
    int events = 0;
    wg_player_update(&g->player, (uint32_t)((uint64_t)index * g->frame_us));
    while (wg_player_event(&g->player, &event)) {
        fprintf(stderr, "%.3f s: event %s\n", (double)index * g->frame_us * 1e-6,
                clip_name(g->file, NAME_EVENT, event.id));
        events++;
    }
    wg_player_sample(&g->player, g->values);
    wg_servo_step(g->file, g->servos, g->values, g->frame_us);
    return events;
}

/* ---- numbers --------------------------------------------------------------------------------- */

static void csv_header(const stage *g, FILE *to)
{
    fprintf(to, "time");
    for (int i = 0; i < g->file->section[WG_SECTION_CHANNELS].count; i++) {
        fprintf(to, ",%s", clip_name(g->file, NAME_CHANNEL, i));
    }
    for (int i = 0; i < g->file->section[WG_SECTION_SERVOS].count; i++) {
        const uint8_t *r = record(g->file, WG_SECTION_SERVOS, i, WG_SERVO_BYTES);
        fprintf(to, ",servo %s [%s]", clip_name(g->file, NAME_SERVO, i),
                servo_unit(get8(r + WG_SERVO_PROTOCOL)));
    }
    fputc('\n', to);
}

static void csv_row(const stage *g, long index, FILE *to)
{
    fprintf(to, "%.6f", (double)index * g->frame_us * 1e-6);
    for (int i = 0; i < g->file->section[WG_SECTION_CHANNELS].count; i++) {
        fprintf(to, ",%.9g", channel_unit(g->file, i, g->values[i]));
    }
    for (int i = 0; i < g->file->section[WG_SECTION_SERVOS].count; i++) {
        const uint8_t *r = record(g->file, WG_SECTION_SERVOS, i, WG_SERVO_BYTES);
        fprintf(to, ",%g",
                servo_scale(get8(r + WG_SERVO_PROTOCOL)) * wg_servo_position(&g->servos[i]));
    }
    fputc('\n', to);
}

static int play_csv(stage *g, const char *path, bake_error *error)
{
    FILE *to = csv_open(path, error);
    if (to == NULL) {
        return -1;
    }
    csv_header(g, to);
    for (long i = 0; i < g->frames; i++) {
        stage_step(g, i);
        csv_row(g, i, to);
    }
    return csv_close(to, path, error);
}

/* ---- a picture ------------------------------------------------------------------------------- */

static int channel_unit_of(const wg_file *file, int channel)
{
    return get8(record(file, WG_SECTION_CHANNELS, channel, WG_CHANNEL_BYTES) + WG_CHANNEL_UNIT);
}

static int play_png(stage *g, const char *path, bake_error *error)
{
    int n = g->file->section[WG_SECTION_CHANNELS].count;
    size_t frames = (size_t)g->frames;
    double *t = bake_alloc(frames, sizeof *t), *v = bake_alloc(frames * (size_t)n, sizeof *v);
    plot_panel *panels = bake_alloc((size_t)n, sizeof *panels);
    for (long i = 0; i < g->frames; i++) {
        stage_step(g, i);
        t[i] = (double)i * g->frame_us * 1e-6;
        for (int c = 0; c < n; c++) {
            v[(size_t)c * frames + (size_t)i] = channel_unit(g->file, c, g->values[c]);
        }
    }
    for (int c = 0; c < n; c++) {
        panels[c] = (plot_panel){
            clip_name(g->file, NAME_CHANNEL, c),
            unit_name(channel_unit_of(g->file, c)),
            1,
            {{"played", "lines lw 2 lc rgb '#1d4f91'", (int)g->frames, t, v + (size_t)c * frames}}};
    }
    int err = plot_png(path, "played: all layers and filters", panels, n, error);
    free(t);
    free(v);
    free(panels);
    return err;
}

/* ---- live ------------------------------------------------------------------------------------ */

static int send(int line, const uint8_t *frame, int count, bake_error *error)
{
    return count > 0 ? serial_write(line, frame, (size_t)count, error) : 0;
}

static int send_frame(stage *g, int line, uint8_t *frame, size_t size, bake_error *error)
{
    uint16_t room = (uint16_t)size;
    int count = wg_maestro_frame(g->file, g->servos, wg_maestro_options(g->file), frame, room);
    if (send(line, frame, count, error) < 0) {
        return -1;
    }
    return send(line, frame, wg_dynamixel2_frame(g->file, g->servos, frame, room), error);
}

/* Dynamixels do not move before their torque is on; what hangs on I2C is not reached from here. */
static int send_start(stage *g, int line, uint8_t *frame, size_t size, bake_error *error)
{
    static const uint8_t torque_on[] = {WG_DYNAMIXEL2_TORQUE_ENABLE, 0, 1};
    const wg_dynamixel2 packet = {WG_DYNAMIXEL2_BROADCAST, WG_DYNAMIXEL2_WRITE, torque_on,
                                  sizeof torque_on};
    int others = wg_bus_count(g->file, WG_PROTOCOL_PCA9685);
    if (others > 0) {
        fprintf(stderr, "%d servos are on I2C (pca9685) and are not driven from here\n", others);
    }
    if (wg_bus_count(g->file, WG_PROTOCOL_DYNAMIXEL2) == 0) {
        return 0;
    }
    return send(line, frame, wg_dynamixel2_packet(&packet, frame, (uint16_t)size), error);
}

/* Frames leave at their scheduled times where something listens; a file gets them at once. */
static int play_line(stage *g, int line, int paced, bake_error *error)
{
    uint8_t frame[WG_BUS_BYTES(WG_SERVOS_MAX)];
    struct timespec next;
    int err = line < 0 ? -1 : send_start(g, line, frame, sizeof frame, error);
    clock_gettime(CLOCK_MONOTONIC, &next);
    for (long i = 0; i < g->frames && err == 0; i++) {
        stage_step(g, i);
        err = send_frame(g, line, frame, sizeof frame, error);
        next.tv_nsec += (long)(g->frame_us % 1000000u) * 1000;
        next.tv_sec += (time_t)(g->frame_us / 1000000u) + next.tv_nsec / 1000000000;
        next.tv_nsec %= 1000000000;
        if (paced) {
            clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
        }
    }
    if (line >= 0) {
        serial_close(line);
    }
    return err;
}

/* What a mistyped number would do is long: a day of frames, or a picture of them. */
static int check_numbers(const option *options, bake_error *error)
{
    double rate = option_number(options, "--rate", 50, error);
    double seconds = option_number(options, "--seconds", 1, error);
    if (rate < 0 || seconds < 0 || option_number(options, "--baud", 115200, error) < 0) {
        return -1;
    }
    if (rate < 1 || rate > 8000) {
        return bake_fail(error, "--rate takes 1 to 8000 frames a second, not %g", rate);
    }
    return seconds > 86400
               ? bake_fail(error, "--seconds takes up to 86400 (a day), not %g", seconds)
               : 0;
}

int command_play(int argc, char **argv, bake_error *error)
{
    option options[] = {{"--csv", 1, NULL},  {"--png", 1, NULL},     {"--serial", 1, NULL},
                        {"--bus", 1, NULL},  {"--baud", 1, NULL},    {"--clip", 1, NULL},
                        {"--rate", 1, NULL}, {"--seconds", 1, NULL}, {NULL, 0, NULL}};
    const char *words[1];
    int count = options_parse(argc, argv, options, (option_words){words, 1}, error);
    const char *csv = option_value(options, "--csv"), *png = option_value(options, "--png");
    const char *serial = option_value(options, "--serial"), *bus = option_value(options, "--bus");
    int ways = (csv != NULL) + (png != NULL) + (serial != NULL) + (bus != NULL);
    if (count >= 0 && (count != 1 || ways != 1)) {
        count = bake_fail(error, "usage: wiggly play CLIP.wgl with one of --csv FILE, --png FILE, "
                                 "--serial DEVICE, --bus FILE");
    }
    if (count < 0 || check_numbers(options, error) < 0) {
        return EXIT_USAGE;
    }
    clip_disk disk;
    if (clip_read(words[0], &disk, error) < 0) {
        return EXIT_FAILED;
    }
    stage *g = bake_alloc(1, sizeof *g);
    int err = stage_set(g, &disk.file, options, error);
    if (err == 0) {
        long baud = (long)option_number(options, "--baud", 115200, error);
        err = csv      ? play_csv(g, csv, error)
              : png    ? play_png(g, png, error)
              : serial ? play_line(g, serial_open(serial, baud, error), 1, error)
                       : play_line(g, serial_file(bus, error), 0, error);
    }
    free(g);
    clip_release(&disk);
    return err < 0 ? EXIT_FAILED : EXIT_DONE;
}
