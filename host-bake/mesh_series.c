/* Files that are numbered: run_####.obj stands for run_0001.obj, run_0002.obj, ...
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { DIGITS_MAX = 9 };

static char *numbered(const char *path, const mesh_series *s, int number)
{
    const char *tail = path + s->head + s->width;
    size_t room = strlen(path) + DIGITS_MAX + 2;
    char *out = bake_alloc(room, 1);
    snprintf(out, room, "%.*s%0*d%s", s->head, path, s->width, number, tail);
    return out;
}

char *mesh_series_path(const char *path, const mesh_series *series, int index)
{
    return numbered(path, series, series->first + index);
}

/* The number that makes `name` of the pattern `base`, or -1. */
static int number_of(const char *name, const char *base, const mesh_series *s, size_t head)
{
    if (strncmp(name, base, head) != 0)
        return -1;
    size_t digits = strspn(name + head, "0123456789");
    if (digits < (size_t)s->width || digits > DIGITS_MAX ||
        (digits > (size_t)s->width && name[head] == '0') ||
        strcmp(name + head + digits, base + head + s->width) != 0)
        return -1;
    return (int)strtol(name + head, NULL, 10);
}

static int scan(const mesh_reader *r, const char *path, size_t directory, mesh_series *out)
{
    char *where = directory > 0 ? bake_copy(path) : bake_copy(".");
    if (directory > 0)
        where[directory] = '\0';
    DIR *list = opendir(where);
    free(where);
    if (list == NULL)
        return mesh_fail(r, path, "names a directory that is not there");
    int first = INT_MAX, last = -1;
    const struct dirent *entry;
    while ((entry = readdir(list)) != NULL) {
        int number = number_of(entry->d_name, path + directory, out, (size_t)out->head - directory);
        first = number >= 0 && number < first ? number : first;
        last = number > last ? number : last;
    }
    closedir(list);
    if (last < 0)
        return mesh_fail(r, path, "stands for no file: there is none with digits for the #s");
    if (last - first >= MESH_FRAMES_MAX)
        return mesh_fail(r, path, "goes from %d to %d; at most %d files are read", first, last,
                         MESH_FRAMES_MAX);
    out->first = first;
    out->count = last - first + 1;
    return 0;
}

int mesh_series_find(const mesh_reader *r, const char *path, mesh_series *out)
{
    const char *slash = strrchr(path, '/'), *base = slash != NULL ? slash + 1 : path;
    const char *mark = strchr(base, '#');
    if (mark == NULL)
        return mesh_fail(r, path, "must have its #s in the file's name");
    *out = (mesh_series){.head = (int)(mark - path), .width = (int)strspn(mark, "#")};
    if (out->width > DIGITS_MAX || strchr(mark + out->width, '#') != NULL)
        return mesh_fail(r, path, "must have one row of at most %d #s", DIGITS_MAX);
    if (scan(r, path, (size_t)(base - path), out))
        return -1;
    for (int i = 0; i < out->count; i++) {
        char *file = mesh_series_path(path, out, i);
        struct stat info;
        int there = stat(file, &info) == 0 && S_ISREG(info.st_mode);
        int err = there ? 0
                        : mesh_fail(r, path,
                                    "has a gap: there is no file '%s', but earlier and "
                                    "later ones",
                                    file);
        free(file);
        if (err)
            return -1;
    }
    return 0;
}
