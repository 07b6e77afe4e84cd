/* For tests of what is said about wrong scenes: each is a good scene with one text replaced.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef SCENE_WRONG_H
#define SCENE_WRONG_H

#include "scene_text.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { GOOD_BYTES = 8192 };

/* A text that stands in the good scene once, what takes its place, how many lines below the change's
 * first the message points, and a part of the message. */
typedef struct {
    const char *find, *replace;
    int lines;
    const char *message;
} wrong;

static void check_wrong(const char *text, const wrong *w)
{
    const char *at = strstr(text, w->find);
    int line = 1;
    CHECK(at != NULL && (at == NULL || strstr(at + 1, w->find) == NULL));
    if (at == NULL || strstr(at + 1, w->find) != NULL) {
        printf("the good scene must have this once: %s\n", w->find);
        return;
    }
    for (const char *c = text; c < at; c++)
        line += *c == '\n';
    char changed[2 * GOOD_BYTES], start[80];
    int size = snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - text), text, w->replace,
                        at + strlen(w->find));
    snprintf(start, sizeof start, "%s:%d: ", scratch, line + w->lines);
    int err = load_text(changed, (size_t)size);
    if (err != -1 || strncmp(error.text, start, strlen(start)) != 0 ||
        strstr(error.text, w->message) == NULL) {
        check_ok = 0;
        printf("%s\n  expected %s%s\n       got %s\n", w->replace, start, w->message,
               err == 0 ? "a scene" : error.text);
    }
    if (err == 0)
        scene_free(&s);
}

/* The good scene, its files named absolutely: the changed ones are elsewhere. */
static char *read_good(const char *path)
{
    static const char key[] = ", file: ";
    FILE *file = fopen(path, "r");
    char line[1024], here[512];
    char *text = bake_alloc(GOOD_BYTES, 1);
    size_t used = 0;
    if (file == NULL || getcwd(here, sizeof here) == NULL)
        exit(1);
    while (fgets(line, sizeof line, file) != NULL) {
        char *place = strstr(line, key);
        size_t before = place ? (size_t)(place - line) + sizeof key - 1 : strlen(line);
        used += (size_t)snprintf(text + used, GOOD_BYTES - used, "%.*s%s%s%s", (int)before, line,
                                 place ? here : "", place ? "/tests/scenes/" : "", line + before);
        CHECK(used < GOOD_BYTES);
    }
    fclose(file);
    return text;
}

static void check_wrongs(const char *path, const wrong *wrongs_of, int count)
{
    char *text = read_good(path);
    CHECK_EQ(load_text(text, strlen(text)), 0);
    scene_free(&s);
    for (int i = 0; i < count; i++)
        check_wrong(text, &wrongs_of[i]);
    free(text);
}

/* A damaged scene either still is one, or its message begins with "path:line: ". */
static void check_flips(const char *path)
{
    char *text = read_good(path);
    size_t size = strlen(text);
    unsigned long random = 1;
    for (int i = 0; i < 3000; i++) {
        random = (random * 1103515245 + 12345) & 0x7fffffff;
        size_t at = (random >> 8) % size;
        random = (random * 1103515245 + 12345) & 0x7fffffff;
        char before = text[at];
        text[at] =
            random & 1024 ? "{}[]:,-#&*!|>'\"%@`\n\t ?"[(random >> 12) % 23] : (char)(random >> 12);
        int err = load_text(text, size), line = 0;
        if (err == 0)
            scene_free(&s);
        else
            CHECK(err == -1 && strncmp(error.text, scratch, sizeof scratch - 1) == 0 &&
                  sscanf(error.text + sizeof scratch - 1, ":%d: ", &line) == 1 && line >= 1);
        text[at] = before;
    }
    free(text);
}

#endif
