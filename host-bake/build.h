/* The whole bake: a scene becomes the bytes of a clip file, with all that the certificate compares.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_BUILD_H
#define BAKE_BUILD_H

#include "author.h"
#include "track.h"

struct shapes;

typedef struct {
    const scene *scene;
    const struct shapes *shapes;    /* of the scene's meshes; NULL: it has none */
    author_clip *clip;              /* scene.clip_count: the exact curves */
    bake_track **track;             /* [clip][curve] */
    int *frac;                      /* a channel */
    double *tolerance;              /* a channel, in its unit */
    double *range;                  /* a channel: the way from its smallest to its largest value */
    double (*input)[WG_MATRIX_MAX]; /* a matrix filter: how far its inputs get from 0 */
    bytes file;
} build;

/* Progress on stderr when `verbose` and it is a terminal. A scene with meshes: shapes_bake, which
 * makes `shapes` first. */
int build_make(const scene *s, int verbose, build *out, bake_error *error);
int build_make_shapes(const scene *s, const struct shapes *shapes, int verbose, build *out,
                      bake_error *error);
void build_free(build *b);

/* Chooses frac, tolerance, range and largest of every channel: after the clips are authored. */
int build_scale(build *b, bake_error *error);

/* Packs tracks and tables into b->file (SPEC 3, 4). */
int build_pack(build *b, bake_error *error);

/* The same clip as C for people who link it into flash: sizes and names, and the bytes. */
void build_header_text(const build *b, const char *stem, bytes *out);
void build_source_text(const build *b, const char *stem, bytes *out);

/* Writes `count` bytes under a temporary name and renames it: a reader never sees half a file. */
int file_replace(const char *path, const void *data, size_t count, bake_error *error);

#endif
