/* For the tests of meshes: a scene around one mesh, and what can be asked of the mesh.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef MESH_SCENE_H
#define MESH_SCENE_H

#include "check.h"
#include "mesh.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MODELS "/usr/share/assimp/models/"

static const char scratch[] = SCRATCH; /* each test its own */

static scene s;
static mesh m;
static bake_error error;

static inline void write_file(const char *path, const void *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(data, 1, size, file) != size) {
        printf("%s: cannot be written\n", path);
        exit(1);
    }
    fclose(file);
}

static inline unsigned char *read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    unsigned char *data = bake_alloc(1 << 22, 1);
    if (file == NULL) {
        printf("%s: cannot be read\n", path);
        exit(1);
    }
    *size = fread(data, 1, 1 << 22, file);
    fclose(file);
    return data;
}

/* Loads a scene with one mesh, "{name: thing, <mesh>}", and one clip with "{mesh: thing, <motion>}".
 * 0, or -1 and a message; the caller frees both when it is 0. */
static inline int load(const char *fields, const char *motion)
{
    char text[1024], here[512];
    if (getcwd(here, sizeof here) == NULL)
        exit(1);
    int length = snprintf(text, sizeof text,
                          "channels: [{name: a}, {name: b}]\n"
                          "meshes:\n- {name: thing, %s}\n"
                          "clips:\n- {name: still, duration: 1, curves: [{channel: a, kind: held, "
                          "keys: [{time: 0, value: 0}]}]}\n%s%s%s",
                          fields, motion ? "- {name: go, meshes: [{mesh: thing" : "",
                          motion ? motion : "", motion ? "}]}\n" : "");
    write_file(scratch, text, (size_t)length);
    error.text[0] = '\0';
    if (scene_load(scratch, &s, &error))
        return -1;
    int err = mesh_load(&s, 0, &m, &error);
    if (err) {
        CHECK(m.rest == NULL && m.frames == NULL && m.triangle == NULL);
        scene_free(&s);
    }
    return err;
}

static inline void unload(void)
{
    mesh_free(&m);
    scene_free(&s);
}

/* Fails as line 3 (the mesh) or 6 (the motion) of the scene. */
static inline void expect(int line, const char *words)
{
    char start[80];
    snprintf(start, sizeof start, "%s:%d: ", scratch, line);
    if (strncmp(error.text, start, strlen(start)) != 0 || strstr(error.text, words) == NULL) {
        check_ok = 0;
        printf("expected %s%s\n     got %s\n", start, words, error.text);
    }
}

static inline void refuse_at(int line, const char *fields, const char *motion, const char *words)
{
    int err = load(fields, motion);
    CHECK_EQ(err, -1);
    if (err == 0)
        unload();
    else
        expect(line, words);
}

static inline void refuse(const char *fields, const char *motion, const char *words)
{
    refuse_at(motion ? 6 : 3, fields, motion, words);
}

static inline const double *frame_at(int frame)
{
    return m.frames[0].at + 3 * (size_t)frame * (size_t)m.vertex_count;
}

/* Enclosed volume, positive when corners run counter-clockwise seen from outside. */
static inline double volume(const double *at)
{
    double sum = 0;
    for (int i = 0; i < m.triangle_count; i++) {
        const double *a = at + 3 * m.triangle[i][0], *b = at + 3 * m.triangle[i][1];
        const double *c = at + 3 * m.triangle[i][2];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

/* Every edge has one triangle on each side. */
static inline int is_closed(void)
{
    int n = 3 * m.triangle_count, open = 0;
    for (int i = 0; i < n; i++) {
        int a = m.triangle[i / 3][i % 3], b = m.triangle[i / 3][(i + 1) % 3], back = 0, same = 0;
        for (int j = 0; j < n; j++) {
            int c = m.triangle[j / 3][j % 3], d = m.triangle[j / 3][(j + 1) % 3];
            same += a == c && b == d;
            back += a == d && b == c;
        }
        open += same != 1 || back != 1;
    }
    return open == 0;
}

static inline int word(const unsigned char *at)
{
    return (int)((unsigned)at[0] | (unsigned)at[1] << 8 | (unsigned)at[2] << 16 |
                 (unsigned)at[3] << 24);
}

static inline double real(const unsigned char *at)
{
    float value;
    memcpy(&value, at, sizeof value);
    return (double)value;
}

static inline void place(double x, double y, double z, const double *got)
{
    /* Floats of at most 64 in size: two roundings of 2^-19 at most, in value x scale + offset. */
    const double tolerance = 4e-6;
    CHECK_NEAR(got[0], x, tolerance);
    CHECK_NEAR(got[1], y, tolerance);
    CHECK_NEAR(got[2], z, tolerance);
}

#endif
