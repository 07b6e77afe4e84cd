/* Layers: time, weights, mixing.
 * Source: own (SPEC 6.6); filters after Alexa 2002, 7.1.2.
 * SPDX-License-Identifier: MIT */
#include "clip.h"
#include "fix.h"
#include "layer.h"

void wg_player_init(wg_player *p, const wg_file *file, wg_layer *layers, uint8_t layer_count)
{
    p->file = file;
    p->layers = layers;
    p->layer_count = layer_count;
    p->now_us = 0;
    p->started = 0;
    for (uint8_t i = 0; i < layer_count; i++) {
        wg_layer *layer = &layers[i];
        bool baked = i < file->section[WG_SECTION_LAYERS].count;
        const uint8_t *r = wg_record(file, WG_SECTION_LAYERS, i, WG_LAYER_BYTES);
        layer->mode = baked ? wg_rd8(r + WG_LAYER_MODE) : WG_MODE_OVERRIDE;
        layer->mask = baked ? wg_rd8(r + WG_LAYER_MASK) : WG_NONE;
        wg_player_play(p, i, baked ? wg_rd8(r + WG_LAYER_CLIP) : WG_NONE);
        wg_player_fade(p, i, baked ? wg_rd16(r + WG_LAYER_WEIGHT) : WG_WEIGHT_ONE, 0);
    }
}

void wg_player_play(wg_player *p, uint8_t layer, uint8_t clip)
{
    wg_layer *l = &p->layers[layer];
    l->clip = clip;
    l->end = clip == WG_NONE ? WG_END_HOLD : wg_rd8(wg_clip_record(p->file, clip) + WG_CLIP_END);
    l->speed = WG_SPEED_ONE;
    l->playing = 1;
    wg_player_seek(p, layer, 0);
}

void wg_player_pause(wg_player *p, uint8_t layer, bool paused)
{
    p->layers[layer].playing = !paused;
}

void wg_player_speed(wg_player *p, uint8_t layer, int32_t speed_q16)
{
    p->layers[layer].speed = speed_q16;
}

/* The span whose events are to be reported is empty. */
static void no_pending(wg_layer *l)
{
    l->from = l->head;
    l->wraps = 0;
    l->event = 0;
    l->backwards = 0;
}

void wg_player_seek(wg_player *p, uint8_t layer, uint32_t time_us)
{
    wg_layer *l = &p->layers[layer];
    uint64_t duration = l->clip == WG_NONE ? 0 : wg_clip_duration(p->file, l->clip);
    uint64_t head = (uint64_t)time_us << 16;
    l->head = head < duration ? head : l->end == WG_END_LOOP ? 0 : duration;
    no_pending(l);
}

/* A changed end policy keeps the place that is shown; a ping-pong clip goes on forwards from it. */
void wg_player_end(wg_player *p, uint8_t layer, uint8_t end)
{
    wg_layer *l = &p->layers[layer];
    if (l->clip != WG_NONE) {
        uint64_t shown = wg_layer_shown(p->file, l, l->head);
        l->head = end == WG_END_LOOP && shown == wg_clip_duration(p->file, l->clip) ? 0 : shown;
    }
    l->end = end;
    no_pending(l);
}

uint32_t wg_player_time(const wg_player *p, uint8_t layer)
{
    const wg_layer *l = &p->layers[layer];
    return l->clip == WG_NONE ? 0 : (uint32_t)(wg_layer_shown(p->file, l, l->head) >> 16);
}

bool wg_player_ended(const wg_player *p, uint8_t layer)
{
    const wg_layer *l = &p->layers[layer];
    if (l->clip == WG_NONE) {
        return true;
    }
    uint64_t last = l->speed < 0 ? 0 : wg_clip_duration(p->file, l->clip);
    return l->end == WG_END_HOLD && l->head == last;
}

/* ---- weights -----------------------------------------------------------------------------------
 */

/* 6 u^5 - 15 u^4 + 10 u^3 in Q15: C2 at both ends, where a cubic fade is only C1 (DESIGN 9, S7).
 * Less than 1.01 units off and never falling: test_player_layer.c tries all u. */
static uint32_t quintic_q15(uint32_t u)
{
    uint32_t square = u * u;                                                     /* Q30 */
    uint32_t cube = (uint32_t)((uint64_t)square * u >> 15);                      /* Q30 */
    uint32_t rest = (UINT32_C(10) << 27) - (15u * u << 12) + (3u * square >> 2); /* Q27, 1..10 */
    return (uint32_t)((uint64_t)cube * rest >> 42);
}

static uint16_t weight(const wg_layer *l)
{
    if (l->faded_us >= l->fade_us) {
        return l->fade_to;
    }
    uint32_t faded = l->faded_us, fade = l->fade_us;
    while (fade >> 17) { /* <= 15 rounds; above 17 bits 1/fade would have too few */
        faded >>= 1;
        fade >>= 1;
    }
    uint32_t u_q15 = (faded * (UINT32_C(0xffffffff) / fade)) >> 17;
    int32_t step = ((int32_t)l->fade_to - l->fade_from) * (int32_t)quintic_q15(u_q15);
    return (uint16_t)(l->fade_from + (step >> 15));
}

void wg_player_fade(wg_player *p, uint8_t layer, uint16_t to, uint32_t fade_us)
{
    wg_layer *l = &p->layers[layer];
    l->fade_from = fade_us ? weight(l) : to;
    l->fade_to = to;
    l->fade_us = fade_us;
    l->faded_us = 0;
}

void wg_player_crossfade(wg_player *p, uint8_t lower, uint8_t clip, uint32_t fade_us)
{
    uint8_t upper = (uint8_t)(lower + 1u);
    bool uncover =
        weight(&p->layers[upper]) > WG_WEIGHT_ONE / 2 && p->layers[upper].clip != WG_NONE;
    wg_player_play(p, uncover ? lower : upper, clip);
    if (uncover) {
        wg_player_fade(p, lower, WG_WEIGHT_ONE, 0);
    } else {
        wg_player_fade(p, upper, 0, 0);
    }
    wg_player_fade(p, upper, uncover ? 0 : WG_WEIGHT_ONE, fade_us);
}

/* ---- time --------------------------------------------------------------------------------------
 */

void wg_player_update(wg_player *p, uint32_t now_us)
{
    uint32_t dt = p->started ? now_us - p->now_us : 0;
    p->now_us = now_us;
    p->started = 1;
    for (uint8_t i = 0; i < p->layer_count; i++) {
        wg_layer *l = &p->layers[i];
        uint32_t left = l->fade_us - l->faded_us;
        l->faded_us += dt < left ? dt : left;
        no_pending(l);
        if (l->playing && l->clip != WG_NONE) {
            wg_layer_advance(p->file, l, dt);
        }
    }
}

/* ---- sampling ----------------------------------------------------------------------------------
 */

/* A layer's weight on one channel: mask bytes run from 0 to 255 = 1. */
static uint16_t channel_weight(const wg_file *file, const wg_layer *l, uint16_t layer_weight,
                               uint16_t channel)
{
    if (l->mask == WG_NONE) {
        return layer_weight;
    }
    uint32_t channels = file->section[WG_SECTION_CHANNELS].count;
    uint32_t m = wg_rd8(file->section[WG_SECTION_MASKS].at + l->mask * channels + channel);
    return (uint16_t)((layer_weight * (m + (m >> 7))) >> 8);
}

static void mix_layer(const wg_file *file, const wg_layer *l, int32_t *values)
{
    const uint8_t *c = wg_clip_record(file, l->clip);
    uint32_t position =
        wg_clip_position(file, l->clip, (uint32_t)(wg_layer_shown(file, l, l->head) >> 16));
    uint16_t layer_weight = weight(l);
    uint16_t track = wg_rd16(c + WG_CLIP_TRACK_FIRST);
    for (uint16_t n = wg_rd16(c + WG_CLIP_TRACK_COUNT); n > 0; n--, track++) {
        const uint8_t *t = wg_record(file, WG_SECTION_TRACKS, track, WG_TRACK_BYTES);
        uint16_t channel = wg_rd16(t + WG_TRACK_CHANNEL);
        uint16_t w = channel_weight(file, l, layer_weight, channel);
        int32_t v = wg_track_value(file, track, position);
        int32_t below = values[channel];
        int32_t change = fix_weigh(l->mode == WG_MODE_ADD ? v : v - below, w);
        values[channel] = fix_clamp(below + change, -FIX_VALUE_MAX, FIX_VALUE_MAX);
    }
}

void wg_player_sample(const wg_player *p, int32_t *values)
{
    wg_rest(p->file, values);
    for (uint8_t i = 0; i < p->layer_count; i++) {
        if (p->layers[i].clip != WG_NONE) {
            mix_layer(p->file, &p->layers[i], values);
        }
    }
    wg_filter(p->file, values);
}
