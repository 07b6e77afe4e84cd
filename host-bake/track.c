/* A track as the clip stores it, and the real player over it.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "track.h"
#include "bake.h"

#include <stdlib.h>
#include <string.h>

int track_value_count(const track_run *run)
{
    if (run->kind > (int)WG_KIND_CUBIC) {
        return 4 * run->segments;
    }
    return (run->segments + 1) * (run->kind == (int)WG_KIND_CUBIC ? 2 : 1);
}

void track_run_free(track_run *run)
{
    free(run->end);
    free(run->value);
    memset(run, 0, sizeof *run);
}

void track_free(bake_track *track)
{
    for (int i = 0; i < track->count; i++) {
        track_run_free(&track->run[i]);
    }
    free(track->run);
    memset(track, 0, sizeof *track);
}

void track_append(bake_track *track, track_run *run)
{
    track->run = bake_grow(track->run, (size_t)track->count + 1, sizeof *track->run);
    track->run[track->count++] = *run;
    memset(run, 0, sizeof *run);
}

/* Where `part` stands in `data` on a multiple of `unit`; appended if it is not there. So poses that
 * share their key times share the table. */
static uint32_t place(bytes *data, const bytes *part, size_t unit)
{
    for (size_t i = 0; i + part->count <= data->count; i += unit) {
        if (memcmp(data->at + i, part->at, part->count) == 0) {
            return (uint32_t)i;
        }
    }
    put_align(data, unit);
    uint32_t offset = (uint32_t)data->count;
    put_copy(data, part->at, part->count);
    return offset;
}

void track_put_run(const track_run *run, bytes *runs, bytes *data)
{
    bytes times = {0}, values = {0};
    for (int i = 0; i < run->segments; i++) {
        put16(&times, run->end[i]);
    }
    for (int i = 0; i < run->param_count; i++) {
        put32(&values, run->param[i]);
    }
    for (int i = 0; i < track_value_count(run); i++) {
        put16(&values, (uint16_t)run->value[i]);
    }
    put16(runs, (uint32_t)run->start);
    put16(runs, (uint32_t)run->segments);
    put8(runs, (uint32_t)run->kind);
    put8(runs, (uint32_t)run->shift);
    put8(runs, (uint32_t)run->aux);
    put8(runs, 0);
    put32(runs, (uint32_t)run->base);
    put32(runs, place(data, &times, 2));
    put32(runs, place(data, &values, run->kind > (int)WG_KIND_CUBIC ? 4 : 2));
    bytes_free(&times);
    bytes_free(&values);
}

void replay_open(replay *r, const bake_track *track)
{
    memset(r, 0, sizeof *r);
    put16(&r->data,
          0); /* the search starts two bytes before its times, which a real clip always has */
    put16(&r->tracks, 0);
    put16(&r->tracks, 0);
    put16(&r->tracks, (uint32_t)track->count);
    for (int i = 0; i < track->count; i++) {
        track_put_run(&track->run[i], &r->runs, &r->data);
    }
    const wg_section tracks = {r->tracks.at, 0, 1};
    const wg_section runs = {r->runs.at, 0, (uint16_t)track->count};
    const wg_section data = {r->data.at, (uint32_t)r->data.count, 0};
    r->file.section[WG_SECTION_TRACKS] = tracks;
    r->file.section[WG_SECTION_RUNS] = runs;
    r->file.section[WG_SECTION_DATA] = data;
}

void replay_close(replay *r)
{
    bytes_free(&r->tracks);
    bytes_free(&r->runs);
    bytes_free(&r->data);
}

int32_t replay_value(const replay *r, uint32_t position)
{
    return wg_track_value(&r->file, 0, position);
}
