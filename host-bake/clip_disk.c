/* Clips from disk, for the commands that look at them.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "command.h"
#include "record.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Clips are offsets of 32 bits; nobody bakes one of this size by intention. */
#define CLIP_MOST (1u << 28)

const char *clip_complaint(int code)
{
    switch (code) {
    case WG_ERR_SHORT:
        return "it is cut short";
    case WG_ERR_MAGIC:
        return "it is not a wiggly clip; a scene is baked first: wiggly bake SCENE.yaml -o "
               "CLIP.wgl";
    case WG_ERR_VERSION:
        return "it has another major format version: bake it again with this program";
    case WG_ERR_CRC:
        return "its checksum is wrong: it was damaged on the way, copy or bake it again";
    default:
        return "its contents contradict the specification: bake it again";
    }
}

int clip_read(const char *path, clip_disk *out, bake_error *error)
{
    memset(out, 0, sizeof *out);
    FILE *f = fopen(path, "rb");
    if (f == NULL) {
        return bake_fail(error, "%s: %s", path, strerror(errno));
    }
    size_t room = 0, got;
    do {
        room = room ? 2 * room : 65536;
        out->words = bake_grow(out->words, room, 1);
        got = fread((char *)out->words + out->size, 1, room - out->size, f);
        out->size += got;
    } while (got > 0 && out->size == room && room < CLIP_MOST);
    int bad = ferror(f) ? errno : 0; /* a directory, a broken disk */
    fclose(f);
    if (bad) {
        clip_release(out);
        return bake_fail(error, "%s: cannot be read: %s", path, strerror(bad));
    }
    int code = wg_open(&out->file, out->words, (uint32_t)out->size);
    if (code < 0) {
        clip_release(out);
        return bake_fail(error, "%s: %s (error %d)", path, clip_complaint(code), code);
    }
    return 0;
}

void clip_release(clip_disk *c)
{
    free(c->words);
    memset(c, 0, sizeof *c);
}

const char *clip_name(const wg_file *file, name_kind kind, int index)
{
    static const unsigned SECTION[] = {WG_SECTION_CHANNELS, WG_SECTION_CLIPS, WG_SECTION_SERVOS,
                                       WG_SECTION_LAYERS};
    const wg_section *names = &file->section[WG_SECTION_NAMES];
    for (unsigned k = 0; k < (unsigned)kind; k++) {
        index += file->section[SECTION[k]].count;
    }
    const char *at = (const char *)names->at;
    if (index >= names->count) {
        return "";
    }
    for (; index > 0; index--) { /* wg_open has counted the NULs */
        at += strlen(at) + 1;
    }
    return at;
}

int clip_find(const wg_file *file, const char *name)
{
    for (int i = 0; i < file->section[WG_SECTION_CLIPS].count; i++) {
        if (name == NULL || strcmp(clip_name(file, NAME_CLIP, i), name) == 0) {
            return i;
        }
    }
    return -1;
}

double channel_unit(const wg_file *file, int channel, int32_t raw)
{
    const uint8_t *r = record(file, WG_SECTION_CHANNELS, channel, WG_CHANNEL_BYTES);
    return ldexp(raw, -(int8_t)get8(r + WG_CHANNEL_FRAC));
}
