/* The clip as C source and header, and files written whole or not at all.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "record.h"
#include "shapes.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* #define CLIP_<group>_<NAME> index, with what C does not allow in a name replaced by _. */
static void add_index(bytes *out, const char *group, const char *name, int index)
{
    put_text(out, "#define CLIP_%s_", group);
    for (const char *p = name; *p; p++) {
        put8(out, isalnum((unsigned char)*p) ? (uint32_t)toupper((unsigned char)*p) : '_');
    }
    put_text(out, " %d\n", index);
}

static int track_count(const build *b)
{
    int count = 0;
    for (int i = 0; i < b->scene->clip_count; i++) {
        count += b->scene->clips[i].curve_count;
    }
    return count;
}

static uint64_t longest_us(const build *b)
{
    uint64_t most = 0;
    for (int i = 0; i < b->scene->clip_count; i++) {
        uint64_t us = (uint64_t)b->clip[i].ticks * 1000000u / (uint64_t)b->clip[i].rate;
        most = us > most ? us : most;
    }
    return most;
}

/* Light falls on parts that no paint covers; without normals in the file they are to be recomputed. */
static int has_bare_part(const wg_file *file)
{
    for (int i = 0; i < file->section[WG_SECTION_PARTS].count; i++) {
        const uint8_t *part = record(file, WG_SECTION_PARTS, i, WG_PART_BYTES);
        int painted = 0;
        for (int k = 0; k < file->section[WG_SECTION_PAINTS].count; k++) {
            painted |=
                get16(record(file, WG_SECTION_PAINTS, k, WG_PAINT_BYTES) + WG_PAINT_PART) == i;
        }
        if (!painted && get16(part + WG_PART_NORMALS) == (int)WG_ABSENT) {
            return 1;
        }
    }
    return 0;
}

/* What a firmware links for skins, and how many bones it has room for. */
static void add_skins(const wg_file *file, bytes *out)
{
    int bones = 0;
    for (int i = 0; i < file->section[WG_SECTION_SKINS].count; i++) {
        int own = get16(record(file, WG_SECTION_SKINS, i, WG_SKIN_BYTES) + WG_SKIN_BONE_COUNT);
        bones = own > bones ? own : bones;
    }
    put_text(out,
             "#define CLIP_SKINS %d\n#define CLIP_BONES %d /* of the skin that has most */\n"
             "#define CLIP_FIELDS %d /* channels that are means of others */\n"
             "#define CLIP_PAINTS %d\n",
             file->section[WG_SECTION_SKINS].count, bones, file->section[WG_SECTION_FIELDS].count,
             file->section[WG_SECTION_PAINTS].count);
}

/* Sizes of what device/raster/picture.h works in. */
static void add_shapes(const build *b, bytes *out)
{
    wg_file file = {0};
    wg_open(&file, b->file.at, (uint32_t)b->file.count); /* the certificate has opened it before */
    int count = b->shapes ? b->shapes->count : 0, vertices = 0, bases = 0, parts = 0, records = 0;
    int smooth = 0; /* a view that wants normals */
    for (int i = 0; i < count; i++) {
        const shape_mesh *m = &b->shapes->mesh[i];
        vertices += m->mesh.vertex_count;
        bases = m->form.basis_count > bases ? m->form.basis_count : bases;
        parts += m->mesh.part_count;
        records += 1 + m->has_normals;
    }
    for (int i = 0; i < b->scene->view_count; i++) {
        smooth |= b->scene->views[i].shading == WG_SHADING_SMOOTH;
    }
    put_text(out,
             "#define CLIP_SHAPES %d\n#define CLIP_VERTICES %d /* of all shapes' positions */\n"
             "#define CLIP_BASES %d /* of the shape that has most */\n#define CLIP_PARTS %d\n"
             "#define CLIP_NORMALS %d /* vertices with recomputed normals: all or none */\n"
             "#define CLIP_VIEWS %d\n",
             records, vertices, bases, parts, has_bare_part(&file) && smooth ? vertices : 0,
             b->scene->view_count);
    add_skins(&file, out);
}

/* A mesh's name is that of its positions. */
static void add_shape_names(const build *b, bytes *out)
{
    int shape = 0;
    for (int i = 0; b->shapes && i < b->shapes->count; i++) {
        const shape_mesh *m = &b->shapes->mesh[i];
        add_index(out, "SHAPE", b->scene->meshes[m->index].name, shape);
        shape += 1 + m->has_normals;
    }
    for (int i = 0; i < b->scene->view_count; i++) {
        add_index(out, "VIEW", b->scene->views[i].name, i);
    }
}

void build_header_text(const build *b, const char *stem, bytes *out)
{
    const scene *s = b->scene;
    put_text(out,
             "/* Baked from %s by wiggly: sizes and names of the clip in %s.c. Do not edit. */\n",
             s->name ? s->name : stem, stem);
    put_text(out, "#ifndef CLIP_H\n#define CLIP_H\n\n#include <stdint.h>\n\n");
    put_text(out, "#define CLIP_BYTES %zu\n#define CLIP_CHANNELS %d\n#define CLIP_CLIPS %d\n",
             b->file.count, s->channel_count, s->clip_count);
    put_text(out, "#define CLIP_TRACKS %d\n", track_count(b));
    put_text(out, "#define CLIP_LAYERS %d\n#define CLIP_SERVOS %d\n#define CLIP_EVENTS %d\n",
             s->layer_count > 0 ? s->layer_count : 1, s->servo_count, s->event_name_count);
    add_shapes(b, out);
    put_text(out, "#define CLIP_DURATION_US UINT32_C(%llu) /* of the longest clip */\n",
             (unsigned long long)longest_us(b));
    put_text(out, "#define CLIP_TICK_US UINT32_C(20000)\n#define CLIP_FRAMES (CLIP_DURATION_US / "
                  "CLIP_TICK_US + 1u) /* of CLIP_TICK_US: once through the longest clip */\n\n");
    for (int i = 0; i < s->channel_count; i++) {
        add_index(out, "CHANNEL", s->channels[i].name, i);
    }
    for (int i = 0; i < s->clip_count; i++) {
        add_index(out, "CLIP", s->clips[i].name, i);
    }
    for (int i = 0; i < s->layer_count; i++) {
        add_index(out, "LAYER", s->layers[i].name, i);
    }
    for (int i = 0; i < s->event_name_count; i++) {
        add_index(out, "EVENT", s->event_names[i], i);
    }
    add_shape_names(b, out);
    put_text(out, "\n/* On AVR it lies in program memory: read it through the player only. */\n"
                  "extern const uint32_t clip_words[];\n#define CLIP_DATA ((const void "
                  "*)clip_words)\n\n#endif\n");
}

void build_source_text(const build *b, const char *stem, bytes *out)
{
    put_text(out, "/* Baked by wiggly: the clip's bytes as little-endian words. Do not edit. */\n");
    put_text(
        out,
        "#include \"%s.h\"\n#include \"wg_mem.h\"\n\n/* A clip starts on a multiple of 4, which "
        "8-bit compilers do not give a uint32_t by themselves. */\n#ifdef __GNUC__\n"
        "__attribute__((aligned(4)))\n#endif\nWG_TABLE const uint32_t clip_words[] = {",
        stem);
    for (size_t i = 0; i + 4 <= b->file.count; i += 4) {
        const uint8_t *p = b->file.at + i;
        put_text(out, "%s0x%02x%02x%02x%02x,", i % 32 == 0 ? "\n    " : " ", p[3], p[2], p[1],
                 p[0]);
    }
    put_text(out, "\n};\n");
}

int file_replace(const char *path, const void *data, size_t count, bake_error *error)
{
    size_t size = strlen(path) + 16;
    char *temporary = bake_alloc(size, 1);
    snprintf(temporary, size, "%s.%ld.tmp", path, (long)getpid());
    FILE *f = fopen(temporary, "wb");
    int good = f != NULL && fwrite(data, 1, count, f) == count;
    good = f != NULL && fclose(f) == 0 && good;
    good = good && rename(temporary, path) == 0;
    int reason = errno;
    if (!good) {
        remove(temporary);
        bake_fail(error, "%s: cannot be written: %s", path, strerror(reason));
    }
    free(temporary);
    return good ? 0 : -1;
}
