/* Writes the seed corpus: seeds directory
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "../shape_samples.h"

static void save(const char *directory, const char *name, build *b)
{
    char path[512];
    uint32_t size;
    uint8_t *clip = build_finish(b, &size);
    snprintf(path, sizeof path, "%s/%s.wgl", directory, name);
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(clip, 1, size, f) != size || fclose(f) != 0) {
        perror(path);
        exit(1);
    }
    free(clip);
}

static void save_minimal(const char *directory)
{
    build b = {{{0}}, 0};
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 1000, 10, WG_END_HOLD);
    save(directory, "minimal", &b);
}

/* Two clips of every kind of run, cross-faded, with self-triggers. */
static void save_waves(const char *directory)
{
    build b = {{{0}}, 0};
    build_channel(&b, 4, WG_UNIT_DEGREE, 0);
    build_channel(&b, 4, WG_UNIT_DEGREE, 0);
    for (uint8_t end = 1; end < 3; end++) {
        build_clip(&b, (uint16_t)(333u * end), 80, end);
        sample_all_kinds(&b, 0);
        sample_all_kinds(&b, 1);
        build_event(&b, 0, 0);
        build_event(&b, 0, 1);
        build_event(&b, 79, 2);
    }
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_layer(&b, 1, WG_MODE_OVERRIDE, WG_NONE, 0);
    build_trigger(&b, 0, 0, 1, 0);
    build_trigger(&b, 1, 1, 0, 65535);
    build_trigger(&b, 2, 1, WG_NONE, 9);
    save(directory, "waves", &b);
}

static void save_servos(const char *directory)
{
    build b = {{{0}}, 0};
    build_channel(&b, 0, WG_UNIT_MICROSECOND, 1500);
    build_channel(&b, 0, WG_UNIT_MICROSECOND, 1500);
    build_channel(&b, 0, WG_UNIT_MICROSECOND, 1500);
    build_clip(&b, 100, 300, WG_END_PINGPONG);
    sample_cubic(&b, 0, 300);
    sample_ramp(&b, 1, 300, 3000);
    sample_cubic(&b, 2, 300);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    for (unsigned i = 0; i < 5; i++) {
        sample_servos(&b);
    }
    sample_filters(&b);
    save(directory, "servos", &b);
}

int main(int argc, char **argv)
{
    const char *directory = argc > 1 ? argv[1] : "tests/fuzz/corpus";
    build b = {{{0}}, 0};
    sample_everything(&b);
    save(directory, "everything", &b);
    save_minimal(directory);
    save_waves(directory);
    save_servos(directory);
    sample_shapes(&b);
    b.minor = 1;
    save(directory, "shapes", &b);
    return 0;
}
