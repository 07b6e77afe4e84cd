/* For tests of scene files: loads one, or a text as one.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef SCENE_TEXT_H
#define SCENE_TEXT_H

#include "check.h"
#include "scene.h"

#include <stdio.h>

static const char scratch[] = "build/scene_text.yaml";

static scene s;
static bake_error error;

static int load(const char *path)
{
    error.text[0] = '\0';
    int err = scene_load(path, &s, &error);
    if (err == 0 ? error.text[0] != '\0'
                 : error.text[0] == '\0' || s.channels != NULL || s.bodies != NULL)
        return -99; /* a message and a scene, or neither */
    return err;
}

static int load_text(const char *text, size_t size)
{
    FILE *file = fopen(scratch, "wb");
    CHECK(file != NULL && fwrite(text, 1, size, file) == size);
    fclose(file);
    return load(scratch);
}

#endif
