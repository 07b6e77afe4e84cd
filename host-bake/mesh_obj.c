/* Which vertex of an OBJ file a corner is: Assimp copies its position and forgets. So the file is
 * read a second time with every vertex line replaced by the vertex's number, which comes back as
 * the corner's position.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "mesh_read.h"

#include <assimp/cimport.h>

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE_BYTES = 32 };

/* Floats hold whole numbers up to here. */
static const int numbers_max = 1 << 24;

/* The end of a line, which goes on behind a backslash. */
static const char *line_end(const char *at, const char *end)
{
    const char *start = at;
    for (; at < end; at++) {
        if (*at != '\n')
            continue;
        const char *last = at > start && at[-1] == '\r' ? at - 1 : at;
        if (last == start || last[-1] != '\\')
            return at + 1;
    }
    return end;
}

/* The text with "v 0 0 0" for its first vertex, "v 1 0 0" for the second, ...; returns how many. */
static int number_lines(const char *text, size_t size, char **out, size_t *out_size)
{
    const char *end = text + size;
    int count = 0;
    size_t used = 0, room = size + LINE_BYTES;
    *out = bake_alloc(room, 1);
    for (const char *at = text; at < end;) {
        const char *next = line_end(at, end);
        size_t length = (size_t)(next - at);
        if (used + length + LINE_BYTES > room) {
            room = 2 * room + length;
            *out = bake_grow(*out, room, 1);
        }
        if (length > 1 && at[0] == 'v' && (at[1] == ' ' || at[1] == '\t')) {
            used += (size_t)snprintf(*out + used, LINE_BYTES, "v %d 0 0\n", count++);
        } else {
            memcpy(*out + used, at, length);
            used += length;
        }
        at = next;
    }
    *out_size = used;
    return count;
}

/* Copies the numbers; -1 if the two readings differ or a position is no number of a vertex. */
static int copy_ids(mesh_file *f, const mesh_file *numbered)
{
    if (numbered->place_count != f->place_count || numbered->vertex_count != f->vertex_count)
        return -1;
    for (int i = 0; i < f->place_count; i++) {
        const struct aiMesh *from = numbered->places[i].mesh;
        if (from->mNumVertices != f->places[i].mesh->mNumVertices)
            return -1;
        for (int j = 0; j < (int)from->mNumVertices; j++) {
            double id = (double)from->mVertices[j].x;
            if (!(id >= 0 && id < f->id_count) || id > (int)id)
                return -1;
            f->id[f->places[i].first + j] = (int)id;
        }
    }
    return 0;
}

int mesh_obj_ids(const mesh_reader *r, mesh_file *f)
{
    size_t size, numbered_size;
    char *text = mesh_read_bytes(f->path, &size), *numbered_text;
    int count = number_lines(text, size, &numbered_text, &numbered_size);
    mesh_file numbered = {.path = f->path};
    int err = -1;
    f->id_count = count;
    f->ordered = 1;
    if (count <= numbers_max && numbered_size < UINT_MAX)
        numbered.file = aiImportFileFromMemory(numbered_text, (unsigned)numbered_size, 0, "obj");
    if (numbered.file != NULL) {
        mesh_places(r, numbered.file, &numbered);
        err = copy_ids(f, &numbered);
    }
    mesh_file_close(&numbered);
    free(numbered_text);
    free(text);
    return err == 0 ? 0
                    : mesh_fail(r, f->path,
                                "has vertices that cannot be numbered: a vertex is a line of its "
                                "own that begins with 'v' and a blank, in UTF-8");
}
