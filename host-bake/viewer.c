/* wiggly view without its window.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "viewer.h"
#include "record.h"
#include "stage.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char VIEWER_HELP[] =
    "mouse: drag turns, wheel zooms, the bar below is the time\n"
    "space        pause, play (again)      left, right  one frame back, on\n"
    "+ -          faster, slower           tab          next clip on the first layer\n"
    "1 .. 8       fade a layer in or out   [ ]          fewer, more bases\n"
    "w f s        wire, flat, smooth       v            next view\n"
    "p            next panel               h            this help      q, esc  quit\n";

/* ---- time ------------------------------------------------------------------------------------ */

static uint32_t clip_us(const viewer *v, int layer)
{
    return get32(clip_record(v->file, v->layers[layer].clip) + WG_CLIP_US);
}

uint32_t viewer_time(const viewer *v)
{
    int layer = layer_longest(&v->player);
    return layer < 0 ? 0 : wg_player_time(&v->player, (uint8_t)layer);
}

uint32_t viewer_length(const viewer *v)
{
    int layer = layer_longest(&v->player);
    return layer < 0 ? 0 : clip_us(v, layer);
}

/* Where a layer is that has played from its beginning for time_us. */
static uint32_t folded(const viewer *v, int layer, uint32_t time_us)
{
    uint64_t length = clip_us(v, layer), time = time_us;
    switch (length > 0 ? v->layers[layer].end : WG_END_HOLD) {
    case WG_END_LOOP:
        return (uint32_t)(time % length);
    case WG_END_PINGPONG:
        time %= 2 * length;
        return (uint32_t)(time <= length ? time : 2 * length - time);
    default:
        return time_us;
    }
}

void viewer_seek(viewer *v, uint32_t time_us)
{
    for (int i = 0; i < v->player.layer_count; i++) {
        if (v->layers[i].clip != WG_NONE) {
            wg_player_seek(&v->player, (uint8_t)i, folded(v, i, time_us));
        }
    }
    v->paused = 1;
}

void viewer_scrub(viewer *v, double fraction)
{
    double limited = fmin(fmax(fraction, 0), 1);
    /* a loop's end is its beginning: the bar's right end is the last microsecond before it */
    double last = viewer_length(v) > 0 ? viewer_length(v) - 1.0 : 0;
    viewer_seek(v, (uint32_t)(limited * last + 0.5));
}

static void step(viewer *v, int frames)
{
    double to = (double)viewer_time(v) + frames * (double)VIEWER_STEP_US;
    viewer_seek(v, (uint32_t)fmin(fmax(to, 0), viewer_length(v)));
}

/* Nothing moves any more: playing on would show nothing. */
static int all_ended(const viewer *v)
{
    for (int i = 0; i < v->player.layer_count; i++) {
        if (v->layers[i].clip != WG_NONE && !wg_player_ended(&v->player, (uint8_t)i)) {
            return 0;
        }
    }
    return 1;
}

static void toggle_pause(viewer *v)
{
    int again = all_ended(v);
    if (again) {
        viewer_seek(v, 0);
    }
    v->paused = !again && !v->paused;
}

/* ---- layers ---------------------------------------------------------------------------------- */

/* To 0, or to the weight that the clip gives the layer (1 if that is 0: a trigger's layer). */
static void toggle_layer(viewer *v, int layer)
{
    uint16_t weight = WG_WEIGHT_ONE;
    if (layer >= v->player.layer_count) {
        return;
    }
    if (layer < v->file->section[WG_SECTION_LAYERS].count) {
        weight = (uint16_t)get16(record(v->file, WG_SECTION_LAYERS, layer, WG_LAYER_BYTES) +
                                 WG_LAYER_WEIGHT);
    }
    if (v->layers[layer].fade_to > 0) {
        weight = 0;
    } else if (weight == 0) {
        weight = WG_WEIGHT_ONE;
    }
    /* while paused no time passes in which it could fade */
    wg_player_fade(&v->player, (uint8_t)layer, weight, v->paused ? 0 : VIEWER_FADE_US);
}

static void next_clip(viewer *v)
{
    int clips = v->file->section[WG_SECTION_CLIPS].count, clip = v->layers[0].clip;
    wg_player_play(&v->player, 0, (uint8_t)(clip == WG_NONE ? 0 : (clip + 1) % clips));
    if (v->layers[0].fade_to == 0) {
        wg_player_fade(&v->player, 0, WG_WEIGHT_ONE, 0);
    }
}

/* ---- keys and mouse -------------------------------------------------------------------------- */

static int limit(int value, int least, int most)
{
    return value < least ? least : value > most ? most : value;
}

static void look_key(viewer *v, int key)
{
    int most = bases_most(v->file), views = view_count(v->file);
    switch (key) {
    case '[':
    case ']':
        v->look.bases = limit(limit(v->look.bases, 0, most) + (key == ']' ? 1 : -1), 0, most);
        break;
    case 'w':
        v->look.shading = WG_SHADING_WIRE;
        break;
    case 'f':
        v->look.shading = WG_SHADING_FLAT;
        break;
    case 's':
        v->look.shading = WG_SHADING_SMOOTH;
        break;
    case 'v':
        v->look.view = views > 0 ? (v->look.view + 1) % views : 0;
        break;
    case 'p':
        v->panel = (v->panel + 1) % panel_count();
        break;
    default:
        break;
    }
}

void viewer_key(viewer *v, int key)
{
    switch (key) {
    case ' ':
        toggle_pause(v);
        break;
    case VIEWER_LEFT:
        step(v, -1);
        break;
    case VIEWER_RIGHT:
        step(v, 1);
        break;
    case '+':
    case '=':
        v->speed = limit(v->speed + 1, -VIEWER_SPEED_MOST, VIEWER_SPEED_MOST);
        break;
    case '-':
        v->speed = limit(v->speed - 1, -VIEWER_SPEED_MOST, VIEWER_SPEED_MOST);
        break;
    case '\t':
        next_clip(v);
        break;
    case 'h':
        v->help = 1;
        break;
    case 'q':
    case VIEWER_ESCAPE:
        v->quit = 1;
        break;
    default:
        if (key >= '1' && key <= '8') {
            toggle_layer(v, key - '1');
        } else {
            look_key(v, key);
        }
    }
}

/* What is seen follows the mouse: the camera goes the other way. */
void viewer_drag(viewer *v, int dx, int dy)
{
    v->yaw -= 0.5 * dx;
    v->pitch += 0.5 * dy;
}

void viewer_wheel(viewer *v, int clicks)
{
    v->zoom = fmin(fmax(v->zoom * pow(1.1, clicks), 1.0 / 64), 64);
}

/* ---- what is shown --------------------------------------------------------------------------- */

static int32_t saturated(double raw)
{
    const double most = 1 << 29;
    return (int32_t)lround(fmin(fmax(raw, -most), most));
}

static int32_t *view_value(viewer *v, int what)
{
    const uint8_t *r = record(v->file, WG_SECTION_VIEWS, v->look.view, WG_VIEW_BYTES);
    return &v->values[get16(r + WG_VIEW_CHANNEL + 2 * what)];
}

static void add_degrees(viewer *v, int what, double degrees)
{
    int32_t *value = view_value(v, what);
    double one = 1 / channel_unit(v->file, (int)(value - v->values), 1);
    *value = saturated(*value + degrees * one);
}

static void sample(viewer *v)
{
    wg_player_sample(&v->player, v->values);
    wg_fields_set(v->file, v->values);
    if (view_count(v->file) > 0) {
        int32_t *size = view_value(v, WG_VIEW_SIZE);
        add_degrees(v, WG_VIEW_YAW, v->yaw);
        add_degrees(v, WG_VIEW_PITCH, v->pitch);
        *size = saturated(*size / v->zoom);
    }
}

void viewer_advance(viewer *v, double real_us)
{
    wg_event event;
    if (!v->paused) {
        v->clock_us = fmod(v->clock_us + ldexp(real_us, v->speed), 4294967296.0);
    }
    wg_player_update(&v->player, (uint32_t)v->clock_us);
    while (wg_player_event(&v->player, &event)) { /* triggers act */
    }
    sample(v);
}

/* The least and the most of every channel over all clips, for the bars. */
static void measure(viewer *v)
{
    const int count = 64;
    int channels = v->file->section[WG_SECTION_CHANNELS].count;
    memcpy(v->least, v->values, sizeof v->least);
    memcpy(v->most, v->values, sizeof v->most);
    for (int clip = 0; clip < v->file->section[WG_SECTION_CLIPS].count; clip++) {
        double us = get32(clip_record(v->file, clip) + WG_CLIP_US);
        for (int i = 0; i <= count; i++) {
            int32_t values[WG_CHANNELS_MAX];
            wg_clip_sample(v->file, (uint8_t)clip, (uint32_t)(us * i / count), values, NULL);
            wg_fields_set(v->file, values);
            for (int c = 0; c < channels; c++) {
                v->least[c] = values[c] < v->least[c] ? values[c] : v->least[c];
                v->most[c] = values[c] > v->most[c] ? values[c] : v->most[c];
            }
        }
    }
}

int viewer_init(viewer *v, const wg_file *file, const char *clip, bake_error *error)
{
    int layers = file->section[WG_SECTION_LAYERS].count;
    memset(v, 0, sizeof *v);
    v->file = file;
    v->name = "";
    v->look = PAINTER_LOOK;
    v->zoom = 1;
    if (stage_open(file, error) < 0) {
        return -1;
    }
    wg_player_init(&v->player, file, v->layers, (uint8_t)(layers > 0 ? layers : 1));
    if (layers_set(&v->player, clip, error) < 0) {
        return -1;
    }
    viewer_advance(v, 0);
    measure(v);
    return 0;
}

/* ---- the title ------------------------------------------------------------------------------- */

static int shading_now(const viewer *v)
{
    const uint8_t *r = record(v->file, WG_SECTION_VIEWS, v->look.view, WG_VIEW_BYTES);
    return v->look.shading >= 0 ? v->look.shading : get8(r + WG_VIEW_SHADING);
}

/* Layers that are seen, or on their way to be: "13". */
static void layers_text(const viewer *v, char text[WG_LAYERS_MAX + 1])
{
    int n = 0;
    for (int i = 0; i < v->player.layer_count; i++) {
        if (v->layers[i].clip != WG_NONE && v->layers[i].fade_to > 0) {
            text[n++] = (char)('1' + i);
        }
    }
    text[n] = 0;
}

void viewer_title(const viewer *v, char title[VIEWER_TITLE_BYTES])
{
    char layers[WG_LAYERS_MAX + 1], look[96] = "";
    int layer = layer_longest(&v->player), most = bases_most(v->file);
    layers_text(v, layers);
    if (painter_can(v->file)) {
        snprintf(look, sizeof look, " | bases %d/%d | %s | view %d | %s",
                 limit(v->look.bases, 0, most), most, shading_name(shading_now(v)), v->look.view,
                 panel_at(v->panel)->name);
    }
    snprintf(title, VIEWER_TITLE_BYTES, "%.60s | %.40s | %.3f / %.3f s | speed %g%s | layers %s%s",
             v->name, layer < 0 ? "" : clip_name(v->file, NAME_CLIP, v->layers[layer].clip),
             viewer_time(v) * 1e-6, viewer_length(v) * 1e-6, ldexp(1, v->speed), look, layers,
             v->paused ? " | paused" : "");
}
