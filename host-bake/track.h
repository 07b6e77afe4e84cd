/* A track as the clip stores it, and the real player over it.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_TRACK_H
#define BAKE_TRACK_H

#include "bytes.h"
#include "wiggly.h"

/* A run of SPEC 4.4 without its offsets. value: knots (v or v, d), or 4 coefficients a segment. */
typedef struct {
    int start, segments;
    int kind, shift, aux;
    int32_t base;
    int param_count;
    uint32_t param[4]; /* pairs of rate and per-second value */
    uint16_t *end;     /* segments end ticks */
    int16_t *value;
} track_run;

typedef struct {
    int count;
    track_run *run;
} bake_track;

int track_value_count(const track_run *run);
void track_run_free(track_run *run);
void track_free(bake_track *track);

/* Moves `run` to the end of `track`. */
void track_append(bake_track *track, track_run *run);

/* Appends a run's record, and its times and values to `data` unless equal bytes are there. */
void track_put_run(const track_run *run, bytes *runs, bytes *data);

/* A track on its own, read by the player: what the device will show. */
typedef struct {
    bytes tracks, runs, data;
    wg_file file;
} replay;

void replay_open(replay *r, const bake_track *track);
void replay_close(replay *r);

/* Raw value at a position (ticks UQ16.16). */
int32_t replay_value(const replay *r, uint32_t position);

#endif
