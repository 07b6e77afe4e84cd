/* wiggly info: what is in a clip file.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify.h"
#include "command.h"
#include "record.h"

#include <math.h>
#include <stdio.h>

static const char *const KIND[WG_KIND_COUNT] = {"held", "linear", "cubic", "osc",
                                                "osc0", "crit",   "exp",   "exp0"};

/* So many weights and affine parts of one shape, one behind the other, share a line. */
#define MANY 8

static const uint8_t *track_at(const wg_file *file, int index)
{
    return record(file, WG_SECTION_TRACKS, index, WG_TRACK_BYTES);
}

/* The first shape that a channel moves, or -1. */
static int shape_of(const wg_file *file, int channel)
{
    for (int i = 0; i < file->section[WG_SECTION_SHAPES].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_SHAPES, i, WG_SHAPE_BYTES);
        int affine = get16(r + WG_SHAPE_AFFINE), first = get16(r + WG_SHAPE_BASIS_FIRST);
        if (affine != (int)WG_ABSENT && channel >= affine &&
            channel < affine + (int)WG_AFFINE_CHANNELS) {
            return i;
        }
        for (int j = 0; j < get16(r + WG_SHAPE_BASIS_COUNT); j++) {
            const uint8_t *b = record(file, WG_SECTION_BASES, first + j, WG_BASIS_BYTES);
            if (get16(b + WG_BASIS_CHANNEL) == channel) {
                return i;
            }
        }
    }
    return -1;
}

/* How many of the `count` tracks from `first` on move the shape that the first one moves. */
static int shape_tracks(const wg_file *file, int shape, int first, int count)
{
    int n = 0;
    while (shape >= 0 && n < count &&
           shape_of(file, get16(track_at(file, first + n) + WG_TRACK_CHANNEL)) == shape) {
        n++;
    }
    return n;
}

static void print_together(const wg_file *file, int shape, int first, int count)
{
    long segments = 0;
    for (int i = 0; i < count; i++) {
        const uint8_t *t = track_at(file, first + i);
        for (int j = 0; j < get16(t + WG_TRACK_RUN_COUNT); j++) {
            segments += get16(
                record(file, WG_SECTION_RUNS, get16(t + WG_TRACK_RUN_FIRST) + j, WG_RUN_BYTES) +
                WG_RUN_SEGMENTS);
        }
    }
    const uint8_t *last = track_at(file, first + count - 1);
    printf("    %s .. %s: %d channels of shape %d, %ld segments\n",
           clip_name(file, NAME_CHANNEL, get16(track_at(file, first) + WG_TRACK_CHANNEL)),
           clip_name(file, NAME_CHANNEL, get16(last + WG_TRACK_CHANNEL)), count, shape, segments);
}

static void print_track(const wg_file *file, int index)
{
    const uint8_t *t = track_at(file, index);
    int channel = get16(t + WG_TRACK_CHANNEL), first = get16(t + WG_TRACK_RUN_FIRST);
    printf("    %-16s", clip_name(file, NAME_CHANNEL, channel));
    for (int i = 0; i < get16(t + WG_TRACK_RUN_COUNT); i++) {
        const uint8_t *run = record(file, WG_SECTION_RUNS, first + i, WG_RUN_BYTES);
        printf(" %s x %d", KIND[get8(run + WG_RUN_KIND)], get16(run + WG_RUN_SEGMENTS));
    }
    putchar('\n');
}

static void print_tracks(const wg_file *file, int first, int count)
{
    for (int i = first; i < first + count;) {
        int shape = shape_of(file, get16(track_at(file, i) + WG_TRACK_CHANNEL));
        int together = shape_tracks(file, shape, i, first + count - i);
        if (together >= MANY) {
            print_together(file, shape, i, together);
            i += together;
        } else {
            print_track(file, i++);
        }
    }
}

static void print_clip(const wg_file *file, int index)
{
    static const char *const END[] = {"hold", "loop", "ping-pong"};
    const uint8_t *c = clip_record(file, index);
    printf("  clip %s: %.3f s, %d ticks of 1/%d s, %s\n", clip_name(file, NAME_CLIP, index),
           get32(c + WG_CLIP_US) * 1e-6, get16(c + WG_CLIP_TICKS), get16(c + WG_CLIP_RATE),
           END[get8(c + WG_CLIP_END)]);
    print_tracks(file, get16(c + WG_CLIP_TRACK_FIRST), get16(c + WG_CLIP_TRACK_COUNT));
    for (int i = 0; i < get16(c + WG_CLIP_EVENT_COUNT); i++) {
        const uint8_t *e =
            record(file, WG_SECTION_EVENTS, get16(c + WG_CLIP_EVENT_FIRST) + i, WG_EVENT_BYTES);
        printf("    event %s at %.3f s\n", clip_name(file, NAME_EVENT, get16(e + WG_EVENT_ID)),
               get16(e + WG_EVENT_TICK) / (double)get16(c + WG_CLIP_RATE));
    }
}

static void print_servos(const wg_file *file)
{
    static const char *const PROTOCOL[WG_PROTOCOL_COUNT] = {"none", "maestro", "dynamixel2",
                                                            "pca9685"};
    for (int i = 0; i < file->section[WG_SECTION_SERVOS].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_SERVOS, i, WG_SERVO_BYTES);
        int protocol = get8(r + WG_SERVO_PROTOCOL);
        double scale = servo_scale(protocol);
        printf("  servo %s: %s %d, channel %s, %g..%g %s\n", clip_name(file, NAME_SERVO, i),
               PROTOCOL[protocol], get8(r + WG_SERVO_ID),
               clip_name(file, NAME_CHANNEL, get16(r + WG_SERVO_CHANNEL)),
               scale * (int16_t)get16(r + WG_SERVO_MIN), scale * (int16_t)get16(r + WG_SERVO_MAX),
               servo_unit(protocol));
    }
}

static void print_layers(const wg_file *file)
{
    for (int i = 0; i < file->section[WG_SECTION_LAYERS].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_LAYERS, i, WG_LAYER_BYTES);
        int clip = get8(r + WG_LAYER_CLIP);
        printf("  layer %s: %s, %s, weight %g%s\n", clip_name(file, NAME_LAYER, i),
               clip == (int)WG_NONE ? "no clip" : clip_name(file, NAME_CLIP, clip),
               get8(r + WG_LAYER_MODE) == (int)WG_MODE_ADD ? "add" : "override",
               get16(r + WG_LAYER_WEIGHT) / (double)WG_WEIGHT_ONE,
               get8(r + WG_LAYER_MASK) == (int)WG_NONE ? "" : ", masked");
    }
    for (int i = 0; i < file->section[WG_SECTION_TRIGGERS].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_TRIGGERS, i, WG_TRIGGER_BYTES);
        int clip = get8(r + WG_TRIGGER_CLIP);
        printf("  event %s: layer %s plays %s, fade %g s\n",
               clip_name(file, NAME_EVENT, get16(r + WG_TRIGGER_EVENT)),
               clip_name(file, NAME_LAYER, get8(r + WG_TRIGGER_LAYER)),
               clip == (int)WG_NONE ? "no clip" : clip_name(file, NAME_CLIP, clip),
               get16(r + WG_TRIGGER_FADE_MS) * 1e-3);
    }
}

static void print_shapes(const wg_file *file)
{
    for (int i = 0; i < file->section[WG_SECTION_SHAPES].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_SHAPES, i, WG_SHAPE_BYTES);
        int affine = get16(r + WG_SHAPE_AFFINE);
        printf("  shape %d: %d vertices, %d bases in %d blocks, coordinates in steps of %g", i,
               get16(r + WG_SHAPE_VERTICES), get16(r + WG_SHAPE_BASIS_COUNT),
               get16(r + WG_SHAPE_BLOCK_COUNT), ldexp(1, -(int8_t)get8(r + WG_SHAPE_FRAC)));
        if (affine != (int)WG_ABSENT) {
            printf(", moved by %s ..", clip_name(file, NAME_CHANNEL, affine));
        }
        putchar('\n');
    }
    for (int i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_PARTS, i, WG_PART_BYTES);
        const uint8_t *c = r + WG_PART_COLOUR;
        int normals = get16(r + WG_PART_NORMALS);
        printf("  part %d: %d triangles of shape %d, colour %d %d %d%s", i,
               get16(r + WG_PART_TRIANGLES), get16(r + WG_PART_SHAPE), get8(c), get8(c + 1),
               get8(c + 2), get8(r + WG_PART_SIDES) ? ", both sides" : "");
        printf(normals == (int)WG_ABSENT ? "\n" : ", normals are shape %d\n", normals);
    }
}

static void print_views(const wg_file *file)
{
    static const char *const PROJECTION[] = {"perspective", "orthographic"};
    static const char *const SHADING[] = {"wireframe", "flat", "smooth"};
    static const char *const WHAT[WG_VIEW_CHANNELS] = {"yaw", "pitch", "roll",     "x",
                                                       "y",   "z",     "distance", "size"};
    for (int i = 0; i < file->section[WG_SECTION_VIEWS].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_VIEWS, i, WG_VIEW_BYTES);
        printf("  view %d: %s, %s\n   ", i, PROJECTION[get8(r + WG_VIEW_PROJECTION)],
               SHADING[get8(r + WG_VIEW_SHADING)]);
        for (int k = 0; k < (int)WG_VIEW_CHANNELS; k++) {
            int channel = get16(r + WG_VIEW_CHANNEL + 2 * k);
            const uint8_t *c = record(file, WG_SECTION_CHANNELS, channel, WG_CHANNEL_BYTES);
            printf(" %s %.4g %s", WHAT[k],
                   channel_unit(file, channel, (int32_t)get32(c + WG_CHANNEL_REST)),
                   clip_name(file, NAME_CHANNEL, channel));
            fputs(k + 1 < (int)WG_VIEW_CHANNELS ? "," : "", stdout);
        }
        putchar('\n');
    }
}

int command_info(int argc, char **argv, bake_error *error)
{
    option options[] = {{NULL, 0, NULL}};
    const char *words[1];
    int count = options_parse(argc, argv, options, (option_words){words, 1}, error);
    clip_disk disk;
    if (count != 1) {
        return count < 0 ? EXIT_USAGE
                         : (bake_fail(error, "usage: wiggly info CLIP.wgl"), EXIT_USAGE);
    }
    if (clip_read(words[0], &disk, error) < 0) {
        return EXIT_FAILED;
    }
    const wg_file *file = &disk.file;
    int damaged = wg_open_shapes(file) < 0;
    for (unsigned k = WG_SECTION_SHAPES; k <= WG_SECTION_VIEWS && damaged; k++) {
        disk.file.section[k].count = 0; /* nothing below may look at them */
    }
    printf("%s: %zu bytes, format %d.%d, %d channels, %d layers, %d filters, %d triggers\n",
           words[0], disk.size, get8((uint8_t *)disk.words + WG_HEADER_MAJOR),
           get8((uint8_t *)disk.words + WG_HEADER_MINOR), file->section[WG_SECTION_CHANNELS].count,
           file->section[WG_SECTION_LAYERS].count, file->section[WG_SECTION_FILTERS].count,
           file->section[WG_SECTION_TRIGGERS].count);
    for (int i = 0; i < file->section[WG_SECTION_CLIPS].count; i++) {
        print_clip(file, i);
    }
    print_layers(file);
    print_servos(file);
    print_shapes(file);
    print_views(file);
    if (damaged) {
        printf("  its shapes are damaged: no display will show them\n");
    }
    clip_release(&disk);
    return EXIT_DONE;
}
