/* One performance on the host: the player as the firmware runs it, frame after frame.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_STAGE_H
#define BAKE_STAGE_H

#include "command.h"
#include "servo.h"

typedef struct {
    const wg_file *file;
    wg_layer layers[WG_LAYERS_MAX];
    wg_player player;
    int32_t values[WG_CHANNELS_MAX];
    wg_servo servos[WG_SERVOS_MAX];
    uint32_t frame_us;
    long frames;
} stage;

/* Checks shapes, skins and paints, once: before fields are set and before anything is painted. */
int stage_open(const wg_file *file, bake_error *error);

/* Layers as baked, or the clip `name` alone on the first layer; NULL: as baked. A file without
 * layers plays its first clip. */
int layers_set(wg_player *player, const char *name, bake_error *error);

/* The layer whose clip lasts longest, the first of them, or -1 when all are silent. */
int layer_longest(const wg_player *player);

/* --clip, --rate and --seconds of `options`. */
int stage_set(stage *g, const wg_file *file, const option *options, bake_error *error);

/* Moves the stage to frame `index`; events go to stderr. */
void stage_step(stage *g, long index);

/* The values at a moment after the last frame, which itself stays the last: events on the way are
 * not taken, as on a device between two frames. */
void stage_peek(const stage *g, uint32_t time_us, int32_t *values);

#endif
