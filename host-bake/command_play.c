/* wiggly play: a clip on the host, as numbers, as a picture or live on a serial bus.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify.h"
#include "play_picture.h"
#include "plot.h"
#include "record.h"
#include "serial.h"

#include "dynamixel2.h"
#include "maestro.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

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

/* ---- pictures ------------------------------------------------------------------------------ */

static int channel_unit_of(const wg_file *file, int channel)
{
    return get8(record(file, WG_SECTION_CHANNELS, channel, WG_CHANNEL_BYTES) + WG_CHANNEL_UNIT);
}

static int play_curves(stage *g, const char *path, bake_error *error)
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

/* The first option given that only pictures have, or NULL. */
static const char *picture_option(const option *options)
{
    static const char *const NAMES[] = {"--size",    "--panel", "--view", "--bases",
                                        "--shading", "--at",    "--fps"};
    for (size_t i = 0; i < sizeof NAMES / sizeof *NAMES; i++) {
        if (option_value(options, NAMES[i])) {
            return NAMES[i];
        }
    }
    return NULL;
}

/* A clip with parts is shown, of any other there are its curves to see. */
static int play_png(stage *g, const option *options, const char *path, bake_error *error)
{
    const char *name = picture_option(options);
    if (painter_can(g->file)) {
        return play_pictures(g, options, path, error);
    }
    return name ? bake_fail(error, "%s is for clips with meshes and a view; this one has curves",
                            name)
                : play_curves(g, path, error);
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
    if (rate < 0 || seconds < 0 || option_number(options, "--baud", 115200, error) < 0 ||
        option_number(options, "--fps", 10, error) < 0) {
        return -1;
    }
    if (rate < 1 || rate > 8000) {
        return bake_fail(error, "--rate takes 1 to 8000 frames a second, not %g", rate);
    }
    return seconds > 86400
               ? bake_fail(error, "--seconds takes up to 86400 (a day), not %g", seconds)
               : 0;
}

/* Everything that is wrong whatever the clip is. */
static int check_options(const option *options, bake_error *error)
{
    painter_wish wish;
    const char *csv = option_value(options, "--csv"), *png = option_value(options, "--png");
    const char *serial = option_value(options, "--serial"), *bus = option_value(options, "--bus");
    if ((csv != NULL) + (png != NULL) + (serial != NULL) + (bus != NULL) != 1) {
        return bake_fail(error, "usage: wiggly play CLIP.wgl with one of --csv FILE, --png FILE, "
                                "--serial DEVICE, --bus FILE");
    }
    if (check_numbers(options, error) < 0 ||
        painter_options(options, (wg_size){1, 1}, &wish, error) < 0) {
        return -1;
    }
    if (png == NULL && picture_option(options)) {
        return bake_fail(error, "%s goes with --png", picture_option(options));
    }
    int series = png ? series_check(png, error) : 0;
    if (series > 0 && wish.at >= 0) {
        return bake_fail(error, "--at shows one picture: no %% in its name");
    }
    return series < 0 ? -1 : 0;
}

int command_play(int argc, char **argv, bake_error *error)
{
    option options[] = {{"--csv", 1, NULL},  {"--png", 1, NULL},  {"--serial", 1, NULL},
                        {"--bus", 1, NULL},  {"--baud", 1, NULL}, {"--clip", 1, NULL},
                        {"--rate", 1, NULL}, {"--fps", 1, NULL},  {"--seconds", 1, NULL},
                        PAINTER_OPTIONS,     {NULL, 0, NULL}};
    const char *words[1];
    int count = options_parse(argc, argv, options, (option_words){words, 1}, error);
    if (count == 0) {
        count =
            bake_fail(error, "usage: wiggly play CLIP.wgl with --csv, --png, --serial or --bus");
    }
    if (count < 0 || check_options(options, error) < 0) {
        return EXIT_USAGE;
    }
    clip_disk disk;
    if (clip_read(words[0], &disk, error) < 0) {
        return EXIT_FAILED;
    }
    const char *csv = option_value(options, "--csv"), *png = option_value(options, "--png");
    const char *serial = option_value(options, "--serial"), *bus = option_value(options, "--bus");
    stage *g = bake_alloc(1, sizeof *g);
    int err = stage_set(g, &disk.file, options, error);
    if (err == 0) {
        long baud = (long)option_number(options, "--baud", 115200, error);
        err = csv      ? play_csv(g, csv, error)
              : png    ? play_png(g, options, png, error)
              : serial ? play_line(g, serial_open(serial, baud, error), 1, error)
                       : play_line(g, serial_file(bus, error), 0, error);
    }
    free(g);
    clip_release(&disk);
    return err < 0 ? EXIT_FAILED : EXIT_DONE;
}
