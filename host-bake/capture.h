/* The readers behind capture_load. They deliver raw samples in source time: strictly ascending,
 * finite, at least two; rotations in degrees and unwrapped.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_CAPTURE_H
#define BAKE_CAPTURE_H

#include "scene.h"

/* What a reader knows: where the curve stands in the scene file, its source, and where samples go.
 */
typedef struct {
    const char *scene_path;
    const scene_source *source;
    const scene_curve *curve;
    capture *out;
    int room;
    bake_error *error;
} capture_reader;

int capture_read_csv(capture_reader *r);
int capture_read_node(capture_reader *r);

/* Appends one sample. */
void capture_add(capture_reader *r, double time, double value);

#endif
