/* One performance on the host.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "stage.h"
#include "record.h"

#include <math.h>

int stage_open(const wg_file *file, bake_error *error)
{
    int code = wg_open_shapes(file);
    code = code < 0 ? code : wg_open_skins(file);
    return code < 0 ? bake_fail(error, "the clip's shapes cannot be shown: %s (error %d)",
                                clip_complaint(code), code)
                    : 0;
}

int layers_set(wg_player *player, const char *name, bake_error *error)
{
    const wg_file *file = player->file;
    int layers = file->section[WG_SECTION_LAYERS].count, clip = 0;
    if (name && (clip = clip_find(file, name)) < 0) {
        return bake_fail(error, "the file has no clip named %s; wiggly info lists them", name);
    }
    for (int i = 0; i < layers && name; i++) {
        wg_player_play(player, (uint8_t)i, WG_NONE);
    }
    if (name || layers == 0) {
        wg_player_play(player, 0, (uint8_t)clip);
        wg_player_fade(player, 0, WG_WEIGHT_ONE, 0);
        player->layers[0].mode = WG_MODE_OVERRIDE;
        player->layers[0].mask = WG_NONE;
    }
    return 0;
}

int layer_longest(const wg_player *player)
{
    int longest = -1;
    uint32_t most = 0;
    for (int i = 0; i < player->layer_count; i++) {
        int clip = player->layers[i].clip;
        uint32_t us = clip == WG_NONE ? 0 : get32(clip_record(player->file, clip) + WG_CLIP_US);
        if (clip != WG_NONE && (longest < 0 || us > most)) {
            longest = i;
            most = us;
        }
    }
    return longest;
}

int stage_set(stage *g, const wg_file *file, const option *options, bake_error *error)
{
    int layers = file->section[WG_SECTION_LAYERS].count;
    g->file = file;
    if (file->section[WG_SECTION_FIELDS].count > 0 && stage_open(file, error) < 0) {
        return -1;
    }
    wg_player_init(&g->player, file, g->layers, (uint8_t)(layers > 0 ? layers : 1));
    wg_servo_init(g->servos, file);
    if (layers_set(&g->player, option_value(options, "--clip"), error) < 0) {
        return -1;
    }
    int layer = layer_longest(&g->player);
    double longest =
        layer < 0 ? 0 : get32(clip_record(file, g->layers[layer].clip) + WG_CLIP_US) * 1e-6;
    double rate = option_number(options, "--rate", 50, error);
    double seconds = option_number(options, "--seconds", longest > 0 ? longest : 1, error);
    g->frame_us = (uint32_t)lround(1e6 / rate);
    g->frames = (long)floor(seconds * 1e6 / g->frame_us + 0.5) + 1;
    return 0;
}

void stage_step(stage *g, long index)
{
    wg_event event;
    wg_player_update(&g->player, (uint32_t)((uint64_t)index * g->frame_us));
    while (wg_player_event(&g->player, &event)) {
        fprintf(stderr, "%.3f s: event %s\n", (double)index * g->frame_us * 1e-6,
                clip_name(g->file, NAME_EVENT, event.id));
    }
    wg_player_sample(&g->player, g->values);
    wg_fields_set(g->file, g->values);
    wg_servo_step(g->file, g->servos, g->values, g->frame_us);
}

void stage_peek(const stage *g, uint32_t time_us, int32_t *values)
{
    stage copy = *g;
    copy.player.layers = copy.layers;
    wg_player_update(&copy.player, time_us);
    wg_player_sample(&copy.player, values);
    wg_fields_set(g->file, values);
}
