/* For the tests of domain.h: handles, what is made of them, and what is said on stderr.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef DOMAIN_MODEL_H
#define DOMAIN_MODEL_H

#include "domain_parts.h"
#include "tets_model.h"

#include <stdint.h>
#include <unistd.h>

enum { HANDLES = 64 };
static handle list[HANDLES];
static int facet[HANDLES][3], list_count, facet_count;
static domain d;
static held f;

static inline void no_handles(void)
{
    list_count = facet_count = 0;
}

/* On line 10 and so on. */
static inline handle *add_handle(const char *name, handle_kind kind)
{
    list[list_count] = (handle){.name = name, .line = 10 + list_count, .kind = kind};
    return &list[list_count++];
}

static inline void add_bone3(const char *name, const double *from, const double *to)
{
    handle *h = add_handle(name, HANDLE_BONE);
    memcpy(h->from, from, sizeof h->from);
    memcpy(h->to, to, sizeof h->to);
}

/* Of a flat shape; the first one. */
static inline int add_bone(const char *name, double x, double y, double to_x, double to_y)
{
    no_handles();
    add_bone3(name, (const double[]){x, y, 0}, (const double[]){to_x, to_y, 0});
    return list_count;
}

static inline void add_point(const char *name, double x, double y, double z)
{
    memcpy(add_handle(name, HANDLE_POINT)->from, (const double[]){x, y, z}, sizeof list->from);
}

static inline void add_cage(const char *name, double x, double y, double z)
{
    memcpy(add_handle(name, HANDLE_CAGE)->from, (const double[]){x, y, z}, sizeof list->from);
}

static inline void add_region(const char *name, const int *vertex, int count)
{
    handle *h = add_handle(name, HANDLE_REGION);
    h->vertex = vertex;
    h->vertex_count = count;
}

static inline void add_facet(int p, int q, int r)
{
    memcpy(facet[facet_count++], (const int[]){p, q, r}, sizeof *facet);
}

static inline handles all_handles(void)
{
    return (handles){list_count, facet_count, list, (const int(*)[3])facet};
}

/* ---- domains ---------------------------------------------------------------------------------- */

static inline int make_flat(const outline *o, double cell)
{
    const domain_options how = {cell, &origin, 0};
    const handles h = all_handles();
    int err = domain_flat(o, &h, &how, &d, &error);
    if (err)
        printf("%s\n", error.text);
    return err;
}

static inline int make_solid(double cell, int wrap)
{
    const domain_options how = {cell, &origin, wrap};
    const handles h = all_handles();
    const surface s = whole();
    return domain_solid(&s, &h, &how, &d, &error);
}

static inline void refuse_cell(const outline *o, double cell, const char *words)
{
    const domain_options how = {cell, &origin, 0};
    const handles h = all_handles();
    CHECK_EQ(domain_flat(o, &h, &how, &d, &error), -1);
    CHECK(strncmp(error.text, "scene.yaml:7: mesh thing", 24) == 0);
    CHECK(strstr(error.text, words) != NULL);
    CHECK(d.at == NULL && d.element == NULL);
    if (!check_ok)
        printf("%s\n", error.text);
}

static inline void refuse_flat(const outline *o, const char *words)
{
    refuse_cell(o, 0.1, words);
}

static inline void hold(void)
{
    const domain_options how = {0, &origin, 0};
    const handles h = all_handles();
    held_free(&f);
    CHECK_EQ(domain_hold(&d, &h, &how, &f, &error), 0);
    CHECK_EQ(f.handle_count, list_count);
    if (f.count == 0)
        printf("%s\n", error.text);
}

static inline void refuse_hold(const char *words)
{
    const domain_options how = {0, &origin, 0};
    const handles h = all_handles();
    held none;
    CHECK_EQ(domain_hold(&d, &h, &how, &none, &error), -1);
    CHECK(strstr(error.text, words) != NULL);
    CHECK(none.vertex == NULL && none.value == NULL);
    if (!check_ok)
        printf("%s\n", error.text);
}

static inline void finish(void)
{
    held_free(&f);
    domain_free(&d);
}

static inline const double *corner(int element, int k)
{
    return d.at + 3 * d.element[element][k];
}

/* Of triangles; the caller frees them. */
static inline surface as_surface(void)
{
    int(*t)[3] = bake_alloc((size_t)d.element_count, sizeof *t);
    for (int i = 0; i < d.element_count; i++)
        memcpy(t[i], d.element[i], sizeof *t);
    return (surface){d.vertex_count, d.element_count, d.at, (const int(*)[3])t};
}

/* All are means of vertices that give the point back; of the cube, where it is outside, its nearest
 * point. */
static inline void check_embedding(const double *places, int count, int cube)
{
    embedding *e = bake_alloc((size_t)count, sizeof *e);
    double far = -1, most = 0;
    CHECK_EQ(domain_embed(&d, places, count, e, &far, &error), 0);
    for (int i = 0; i < count; i++) {
        double sum = 0, want[3], got[3] = {0, 0, 0};
        memcpy(want, places + 3 * i, sizeof want);
        for (int k = 0; k < 3 && cube; k++)
            want[k] = fmax(-1, fmin(1, want[k]));
        most = fmax(most, tets_distance(want, places + 3 * i));
        for (int k = 0; k < 4; k++) {
            CHECK(e[i].weight[k] >= 0 && e[i].weight[k] <= 1);
            sum += e[i].weight[k];
            for (int x = 0; x < 3; x++)
                got[x] += e[i].weight[k] * d.at[3 * e[i].vertex[k] + x];
        }
        CHECK_NEAR(sum, 1, 1e-14);
        CHECK(tets_distance(got, want) < 1e-8); /* weights are cut off at -1e-9 */
    }
    CHECK_NEAR(far, most, 1e-12);
    free(e);
}

/* ---- numbers and words ------------------------------------------------------------------------- */

static unsigned chance_seed = 1;

/* 0 .. 1, the same everywhere. */
static inline double chance(void)
{
    chance_seed = (chance_seed * 1103515245u + 12345u) & 0x7fffffffu;
    return chance_seed / 2147483648.0;
}

static char words_said[4000];
static int real_stderr = -1;

/* From here on stderr goes to a file. */
static inline void silence(void)
{
    fflush(stderr);
    real_stderr = dup(STDERR_FILENO);
    FILE *file = tmpfile();
    dup2(fileno(file), STDERR_FILENO);
    fclose(file);
}

/* What went there. */
static inline const char *spoken(void)
{
    fflush(stderr);
    lseek(STDERR_FILENO, 0, SEEK_SET);
    ssize_t count = read(STDERR_FILENO, words_said, sizeof words_said - 1);
    words_said[count > 0 ? count : 0] = 0;
    dup2(real_stderr, STDERR_FILENO);
    close(real_stderr);
    return words_said;
}

#endif
