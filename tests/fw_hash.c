/* Determinism image: everything the player says about the linked clip, hashed to one number that
 * must be the same on every target, compiler and optimisation level. Builds like firmware/main.c.
 *   logs "hash XXXXXXXX" (FNV-1a, 32 bits, over little-endian bytes) and stops with 0
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "wiggly.h"
#include "wg_mem.h"
#include "clip.h"

#define PURE_STEP_US 10000u
#define PLAY_TICK_US 20000u
#define PLAY_TICKS   150u /* 3 s */

static wg_file file;
static wg_layer layers[CLIP_LAYERS];
static wg_player player;
static int32_t values[CLIP_CHANNELS];
static int32_t velocities[CLIP_CHANNELS];

static uint32_t hash_u32(uint32_t hash, uint32_t word)
{
    for (uint8_t byte = 0; byte < 4; byte++) {
        hash = (hash ^ (word & 0xffu)) * UINT32_C(16777619);
        word >>= 8;
    }
    return hash;
}

static uint32_t hash_values(uint32_t hash, const int32_t *v)
{
    for (uint16_t channel = 0; channel < CLIP_CHANNELS; channel++) {
        hash = hash_u32(hash, (uint32_t)v[channel]);
    }
    return hash;
}

/* Every clip from its start to one step past its end. */
static uint32_t hash_clips(uint32_t hash)
{
    const wg_section *clips = &file.section[WG_SECTION_CLIPS];
    for (uint8_t clip = 0; clip < clips->count; clip++) {
        uint32_t last_us = wg_rd32(clips->at + (uint32_t)clip * WG_CLIP_BYTES + WG_CLIP_US);
        for (uint32_t steps = last_us / PURE_STEP_US + 2u, i = 0; i < steps; i++) {
            wg_clip_sample(&file, clip, i * PURE_STEP_US, values, velocities);
            hash = hash_values(hash_values(hash, values), velocities);
        }
    }
    return hash;
}

/* What an application does with layers, at fixed ticks: ramps, a cross-fade, reverse play, a seek.
 */
static void act(uint32_t tick)
{
    switch (tick) {
    case 30:
        wg_player_fade(&player, 0, WG_WEIGHT_ONE / 3u, 700000u);
        break;
    case 60:
        wg_player_speed(&player, CLIP_LAYERS - 1, -WG_SPEED_ONE / 2 * 3);
        break;
    case 80:
        if (CLIP_LAYERS > 1) {
            wg_player_crossfade(&player, 0, CLIP_CLIPS - 1, 450000u);
        }
        break;
    case 110:
        wg_player_seek(&player, 0, 123456u);
        break;
    default:
        break;
    }
}

static uint32_t hash_player(uint32_t hash)
{
    wg_event event;
    wg_player_init(&player, &file, layers, CLIP_LAYERS);
    for (uint32_t tick = 0; tick < PLAY_TICKS; tick++) {
        act(tick);
        wg_player_update(&player, tick * PLAY_TICK_US);
        while (wg_player_event(&player, &event)) {
            hash = hash_u32(hash, (uint32_t)event.id << 16 | event.layer);
        }
        wg_player_sample(&player, values);
        hash = hash_values(hash, values);
    }
    return hash;
}

static void log_hash(uint32_t hash)
{
    char text[] = "hash 00000000";
    for (uint8_t digit = 0; digit < 8; digit++) {
        text[12 - digit] = "0123456789abcdef"[hash & 15u];
        hash >>= 4;
    }
    hal_log(text);
}

int main(void)
{
    hal_init();
    if (wg_open(&file, CLIP_DATA, CLIP_BYTES) < 0) {
        hal_log("clip refused");
        hal_stop(1);
    }
    log_hash(hash_player(hash_clips(UINT32_C(2166136261))));
    hal_stop(0);
    return 0;
}
