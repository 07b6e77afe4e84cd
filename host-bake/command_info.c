/* wiggly info: what is in a clip file.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify.h"
#include "command.h"
#include "record.h"

#include <math.h>
#include <stdio.h>

static const char *const KIND[WG_KIND_COUNT] = {"held", "linear", "cubic", "osc",
                                                "osc0", "crit",   "exp",   "exp0"};

static void print_track(const wg_file *file, int index)
{
    const uint8_t *t = record(file, WG_SECTION_TRACKS, index, WG_TRACK_BYTES);
    int channel = get16(t + WG_TRACK_CHANNEL), first = get16(t + WG_TRACK_RUN_FIRST);
    printf("    %-16s", clip_name(file, NAME_CHANNEL, channel));
    for (int i = 0; i < get16(t + WG_TRACK_RUN_COUNT); i++) {
        const uint8_t *run = record(file, WG_SECTION_RUNS, first + i, WG_RUN_BYTES);
        printf(" %s x %d", KIND[get8(run + WG_RUN_KIND)], get16(run + WG_RUN_SEGMENTS));
    }
    putchar('\n');
}

static void print_clip(const wg_file *file, int index)
{
    static const char *const END[] = {"hold", "loop", "ping-pong"};
    const uint8_t *c = clip_record(file, index);
    printf("  clip %s: %.3f s, %d ticks of 1/%d s, %s\n", clip_name(file, NAME_CLIP, index),
           get32(c + WG_CLIP_US) * 1e-6, get16(c + WG_CLIP_TICKS), get16(c + WG_CLIP_RATE),
           END[get8(c + WG_CLIP_END)]);
    for (int i = 0; i < get16(c + WG_CLIP_TRACK_COUNT); i++) {
        print_track(file, get16(c + WG_CLIP_TRACK_FIRST) + i);
    }
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

static void print_shapes(const wg_file *file)
{
    for (int i = 0; i < file->section[WG_SECTION_SHAPES].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_SHAPES, i, WG_SHAPE_BYTES);
        int affine = get16(r + WG_SHAPE_AFFINE);
        printf("  shape %d: %d vertices, %d bases in %d blocks, steps of %g", i,
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
    for (int i = 0; i < file->section[WG_SECTION_VIEWS].count; i++) {
        const uint8_t *r = record(file, WG_SECTION_VIEWS, i, WG_VIEW_BYTES);
        printf("  view %d: %s, %s,", i, PROJECTION[get8(r + WG_VIEW_PROJECTION)],
               SHADING[get8(r + WG_VIEW_SHADING)]);
        for (int k = 0; k < (int)WG_VIEW_CHANNELS; k++) {
            printf(" %s", clip_name(file, NAME_CHANNEL, get16(r + WG_VIEW_CHANNEL + 2 * k)));
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
    printf("%s: %zu bytes, format %d.%d, %d channels, %d layers, %d filters, %d triggers\n",
           words[0], disk.size, get8((uint8_t *)disk.words + WG_HEADER_MAJOR),
           get8((uint8_t *)disk.words + WG_HEADER_MINOR), file->section[WG_SECTION_CHANNELS].count,
           file->section[WG_SECTION_LAYERS].count, file->section[WG_SECTION_FILTERS].count,
           file->section[WG_SECTION_TRIGGERS].count);
    for (int i = 0; i < file->section[WG_SECTION_CLIPS].count; i++) {
        print_clip(file, i);
    }
    print_servos(file);
    if (wg_open_shapes(file) < 0) {
        printf("  its shapes are damaged: no display will show them\n");
    } else {
        print_shapes(file);
        print_views(file);
    }
    clip_release(&disk);
    return EXIT_DONE;
}
