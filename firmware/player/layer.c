/* A layer's head on its unfolded time axis, and the events it passes.
 * Source: own (SPEC 6.7). The axis is [0, period): the duration, or twice it for a ping-pong clip,
 * whose second half shows the clip backwards. Positions are exact integers (us Q16), so no drift
 * exists.
 * SPDX-License-Identifier: MIT */
#include "layer.h"
#include "clip.h"

static uint64_t period(const wg_file *file, const wg_layer *l)
{
    uint64_t duration = wg_clip_duration(file, l->clip);
    return l->end == WG_END_PINGPONG ? 2u * duration : duration;
}

uint64_t wg_layer_shown(const wg_file *file, const wg_layer *l, uint64_t at)
{
    uint64_t duration = wg_clip_duration(file, l->clip);
    return at > duration ? 2u * duration - at : at;
}

/* *at mod length, returning the quotient. A tick covers less than 2^63 and open clips last at least
 * 2^19 (15 us in Q16), so the quotient has at most 44 bits: 44 rounds, no division routine. */
static uint64_t wrap(uint64_t *at, uint64_t length)
{
    uint64_t turns = 0;
    for (unsigned bit = 44; bit-- > 0 && *at >= length;) {
        if ((*at >> bit) >= length) {
            *at -= length << bit;
            turns |= (uint64_t)1 << bit;
        }
    }
    return turns;
}

/* The head crosses the seam forwards by reaching the axis' end, backwards by passing 0. */
void wg_layer_advance(const wg_file *file, wg_layer *l, uint32_t dt_us)
{
    uint64_t length = period(file, l);
    l->backwards = l->speed < 0;
    uint32_t pace = l->backwards ? 0u - (uint32_t)l->speed : (uint32_t)l->speed;
    uint64_t step = (uint64_t)dt_us * pace;
    uint64_t seam = l->backwards ? l->head + 1u : length - l->head;
    if (step < seam) {
        l->head += l->backwards ? 0u - step : step;
    } else if (l->end == WG_END_HOLD) {
        l->head = l->backwards ? 0 : length;
    } else {
        uint64_t beyond = step - seam;
        uint64_t turns = wrap(&beyond, length) + 1u;
        l->head = l->backwards ? length - 1u - beyond : beyond;
        l->wraps = turns > WG_WRAPS_MAX ? WG_WRAPS_MAX : (uint8_t)turns;
    }
}

/* ---- events ------------------------------------------------------------------------------------
 */

/* A stretch of the pending span inside which clip time runs one way. */
typedef struct {
    uint64_t stop;      /* where it ends on the unfolded axis */
    uint32_t low, high; /* ticks UQ16.16: events with low <= tick < high belong to it */
    bool falling;       /* clip time decreases */
    bool last;
} leg;

static uint32_t position_at(const wg_file *file, const wg_layer *l, uint64_t at)
{
    return wg_clip_position(file, l->clip, (uint32_t)(wg_layer_shown(file, l, at) >> 16));
}

static leg next_leg(const wg_file *file, const wg_layer *l)
{
    uint64_t duration = wg_clip_duration(file, l->clip);
    bool second =
        l->end == WG_END_PINGPONG && (l->backwards ? l->from > duration : l->from >= duration);
    uint64_t border = l->backwards == second ? duration : second ? 2u * duration : 0;
    leg g;
    g.last = l->wraps == 0 && (l->backwards ? l->head >= border && l->head <= l->from
                                            : l->head <= border && l->head >= l->from);
    g.stop = g.last ? l->head : border;
    g.falling = (bool)l->backwards != second;
    uint32_t a = position_at(file, l, l->from);
    uint32_t b = position_at(file, l, g.stop);
    g.low = g.falling ? b : a;
    g.high = g.falling ? a : b;
    /* A leg that ends at the clip's end takes every event up to it, whatever rounding made of it.
     */
    if (l->from != g.stop && (g.falling ? l->from : g.stop) == duration) {
        g.high = UINT32_MAX;
    }
    return g;
}

/* The next event of the current leg, in the order of play; l->event counts those looked at. */
static bool take(const wg_file *file, wg_layer *l, const leg *g, wg_event *event)
{
    const uint8_t *c = wg_clip_record(file, l->clip);
    uint16_t first = wg_rd16(c + WG_CLIP_EVENT_FIRST), count = wg_rd16(c + WG_CLIP_EVENT_COUNT);
    while (l->event < count) { /* once over the clip's events */
        uint16_t k = l->event++;
        uint32_t index = (uint32_t)first + (g->falling ? count - 1u - k : k);
        const uint8_t *e = wg_record(file, WG_SECTION_EVENTS, index, WG_EVENT_BYTES);
        uint32_t at = (uint32_t)wg_rd16(e + WG_EVENT_TICK) << 16;
        if (at >= g->low && at < g->high) {
            event->id = wg_rd16(e + WG_EVENT_ID);
            event->backwards = g->falling;
            return true;
        }
    }
    return false;
}

/* Over the seam: from the axis' end to its beginning or back. */
static void cross_seam(const wg_file *file, wg_layer *l)
{
    uint64_t length = period(file, l);
    if (l->backwards ? l->from == 0 : l->from == length) {
        l->from = l->backwards ? length : 0;
        l->wraps--;
    }
}

static bool layer_event(const wg_file *file, wg_layer *l, wg_event *event)
{
    if (l->clip == WG_NONE || wg_rd16(wg_clip_record(file, l->clip) + WG_CLIP_EVENT_COUNT) == 0) {
        return false;
    }
    /* Every whole leg holds an event and a ping-pong turn has two, so at most four rounds. */
    for (unsigned round = 0; round < 4; round++) {
        if (l->backwards && l->wraps > 0) {
            cross_seam(file, l);
        }
        leg g = next_leg(file, l);
        if (take(file, l, &g, event)) {
            return true;
        }
        if (g.last) {
            return false;
        }
        l->from = g.stop;
        l->event = 0;
        if (!l->backwards && l->wraps > 0) {
            cross_seam(file, l);
        }
    }
    return false;
}

static void pull_triggers(wg_player *p, uint16_t id)
{
    const uint8_t *t = p->file->section[WG_SECTION_TRIGGERS].at;
    for (uint16_t i = 0; i < p->file->section[WG_SECTION_TRIGGERS].count; i++) {
        uint8_t layer = wg_rd8(t + WG_TRIGGER_LAYER);
        if (wg_rd16(t + WG_TRIGGER_EVENT) == id && layer < p->layer_count) {
            if (p->layers[layer].clip == WG_NONE) {
                wg_player_fade(p, layer, 0, 0);
            }
            wg_player_play(p, layer, wg_rd8(t + WG_TRIGGER_CLIP));
            wg_player_fade(p, layer, WG_WEIGHT_ONE,
                           UINT32_C(1000) * wg_rd16(t + WG_TRIGGER_FADE_MS));
        }
        t += WG_TRIGGER_BYTES;
    }
}

int wg_player_event(wg_player *p, wg_event *event)
{
    for (uint8_t i = 0; i < p->layer_count; i++) {
        if (layer_event(p->file, &p->layers[i], event)) {
            event->layer = i;
            pull_triggers(p, event->id);
            return 1;
        }
    }
    return 0;
}
