/* Names in arrays: finding one, and advice when it is not there.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SCENE_NAMES_H
#define BAKE_SCENE_NAMES_H

#include <stddef.h>

/* A view on the names of an array whose elements begin with a `const char *`. */
typedef struct {
    const void *first;
    size_t stride;
    int count;
} scene_names;
#define SCENE_NAMES(array, n) ((scene_names){(array), sizeof *(array), (int)(n)})

const char *scene_names_at(const scene_names *names, int index);

/* Index of `name`, or -1. */
int scene_names_find(const scene_names *names, const char *name);

/* Index of a name that makes the same C macro as `name` (case is nothing, - is _), or -1. */
int scene_names_find_macro(const scene_names *names, const char *name);

/* Writes advice for a name that is not there: 'did you mean "jaw"?' when one is near, and the
 * nearest six of what there is. Returns `text`. */
#define SCENE_HINT_BYTES 320
const char *scene_names_hint(const scene_names *names, const char *wrong,
                             char text[SCENE_HINT_BYTES]);

#endif
