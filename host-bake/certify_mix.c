/* The certificate's start-up mix: layers, masks and filters as the firmware plays them from the
 * first frame, beside the same mix in doubles of the authored curves.
 * Source: own (SPEC 4.9, 6.6).
 *
 * Both sides share the times and what the file holds as whole numbers by intention: the player's
 * position in each clip, and a layer's weight times its mask byte (SPEC 6.6). Everything else is
 * taken from the scene. A trigger starts a fade in the player only, so the comparison ends with
 * the first one that fires; the servos are watched to the end.
 *
 * The bound is carried along with each value, in the channel's unit; q is one raw unit:
 *
 *   rest       q/2                                  rounded to a raw unit
 *   track      T = 4/3 of the channel's tolerance   certified at places at most 1/3 tick apart;
 *                                                   between those the error u^2 (1 - u)^2 of the
 *                                                   shortest piece, one tick, is at most 1.27
 *                                                   times what they show
 *   override   (1 - W) E + W T + q                  floor of the weighted difference
 *   add        E + W T + q
 *   offset     E + q/2                              the constant is rounded
 *   gain a     |a| E + |1 - a| q/2 + |v - b| 2^-17 + q    b and a (Q16) are rounded, floor
 *   clamp, minimum     max(E, q/2)                  1-Lipschitz; the constants are rounded
 *   matrix     sum_j |M_ij| E_j + |dM_ij| (|r_j| + E_j), + q_i    dM: what is lost where M becomes
 *              Q12 of raw units, M_ij q_j/q_i; floor
 *
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_parts.h"
#include "command.h"
#include "fit.h"
#include "record.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const build *b;
    const wg_file *file;
    wg_layer layers[WG_LAYERS_MAX];
    wg_player player;
    int32_t *played;       /* a channel: raw */
    double *value, *bound; /* a channel: authored, and how far the player may be off it */
} mix;

static double raw_unit(const build *b, int channel)
{
    return ldexp(1, -b->frac[channel]);
}

/* W of SPEC 6.6, from 0 to 1. */
static double layer_share(const scene *s, const scene_layer *l, int channel)
{
    long weight = lround(l->weight * WG_WEIGHT_ONE);
    if (l->mask >= 0) {
        long m = lround(255 * s->masks[l->mask].weight[channel]);
        weight = weight * (m + (m >> 7)) >> 8;
    }
    return (double)weight / WG_WEIGHT_ONE;
}

static void author_layer(const mix *m, int index)
{
    const build *b = m->b;
    const scene_layer *l = &b->scene->layers[index];
    if (l->clip < 0) {
        return;
    }
    const scene_clip *clip = &b->scene->clips[l->clip];
    const author_clip *a = &b->clip[l->clip];
    uint32_t position =
        wg_clip_position(m->file, (uint8_t)l->clip, wg_player_time(&m->player, (uint8_t)index));
    for (int j = 0; j < clip->curve_count; j++) {
        const fit_problem p = {.curve = &a->curve[j], .rate = a->rate};
        int channel = clip->curves[j].channel, over = l->mode == (int)WG_MODE_OVERRIDE;
        double w = layer_share(b->scene, l, channel), v, slope;
        double *value = &m->value[channel], *bound = &m->bound[channel];
        fit_truth(&p, position / 65536.0, &v, &slope);
        *value += w * (over ? v - *value : v);
        *bound =
            (over ? 1 - w : 1) * *bound + w * 4 / 3 * b->tolerance[channel] + raw_unit(b, channel);
    }
}

static void author_matrix(const mix *m, const scene_filter *f)
{
    double value[WG_MATRIX_MAX] = {0}, bound[WG_MATRIX_MAX];
    for (int i = 0; i < f->n; i++) {
        double q = raw_unit(m->b, f->channels[i]);
        bound[i] = q;
        for (int j = 0; j < f->n; j++) {
            double r = m->value[f->channels[j]], e = m->bound[f->channels[j]];
            double unit = q / raw_unit(m->b, f->channels[j]) / 4096;
            double lost = remainder(f->matrix[i][j], unit);
            value[i] += f->matrix[i][j] * r;
            bound[i] += fabs(f->matrix[i][j]) * e + fabs(lost) * (fabs(r) + e);
        }
    }
    for (int i = 0; i < f->n; i++) {
        m->value[f->channels[i]] = value[i];
        m->bound[f->channels[i]] = bound[i];
    }
}

static void author_filter(const mix *m, const scene_filter *f)
{
    if (f->op == (int)WG_FILTER_MATRIX) {
        author_matrix(m, f);
        return;
    }
    double *value = &m->value[f->channel], *bound = &m->bound[f->channel];
    double q = raw_unit(m->b, f->channel), away = fabs(*value - f->b);
    switch (f->op) {
    case (int)WG_FILTER_OFFSET:
        *value += f->a;
        *bound += q / 2;
        break;
    case (int)WG_FILTER_GAIN:
        *value = f->b + (*value - f->b) * f->a;
        *bound = fabs(f->a) * *bound + fabs(1 - f->a) * q / 2 + ldexp(away + *bound, -17) + q;
        break;
    case (int)WG_FILTER_CLAMP:
        *value = fmin(fmax(*value, f->a), f->b);
        *bound = fmax(*bound, q / 2);
        break;
    default: /* WG_FILTER_MIN */
        *value = fmax(*value, f->a);
        *bound = fmax(*bound, q / 2);
    }
}

static void author_frame(const mix *m)
{
    const scene *s = m->b->scene;
    for (int c = 0; c < s->channel_count; c++) {
        m->value[c] = s->channels[c].rest;
        m->bound[c] = raw_unit(m->b, c) / 2;
    }
    for (int i = 0; i < s->layer_count; i++) {
        author_layer(m, i);
    }
    for (int i = 0; i < s->filter_count; i++) {
        author_filter(m, &s->filters[i]);
    }
}

/* Takes the frame's events as the firmware does; 1 when one of them pulled a trigger. */
static int take_events(mix *m)
{
    wg_event event;
    int fired = 0;
    while (wg_player_event(&m->player, &event)) {
        for (int i = 0; i < m->file->section[WG_SECTION_TRIGGERS].count; i++) {
            const uint8_t *t = record(m->file, WG_SECTION_TRIGGERS, i, WG_TRIGGER_BYTES);
            fired |= get16(t + WG_TRIGGER_EVENT) == event.id;
        }
    }
    return fired;
}

/* rms holds the sum of squares until the end; tolerance is the largest bound of any frame. */
static void compare(const mix *m, double seconds, certificate_channel *row)
{
    for (int c = 0; c < m->b->scene->channel_count; c++, row++) {
        double e = fabs(channel_unit(m->file, c, m->played[c]) - m->value[c]);
        row->rms += e * e;
        row->tolerance = fmax(row->tolerance, m->bound[c]);
        if (e > row->largest) {
            row->largest = e;
            row->when = seconds;
        }
    }
}

/* The longest layer's way, and over its seam. */
static long frame_count(const mix *m)
{
    const scene *s = m->b->scene;
    uint64_t longest = 0;
    for (int i = 0; i < s->layer_count; i++) {
        if (s->layers[i].clip >= 0) {
            int clip = s->layers[i].clip;
            uint64_t frames = certify_period(m->file, clip) / CERTIFY_FRAME_US +
                              (certify_repeats(m->file, clip) ? CERTIFY_SEAM_FRAMES : 0);
            longest = frames > longest ? frames : longest;
        }
    }
    return (long)longest;
}

/* All frames; returns how many were compared. */
static long play(mix *m, certificate_channel *channel, certificate_servo *servo)
{
    const scene *s = m->b->scene;
    servo_watch *watch = bake_alloc((size_t)s->servo_count + 1, sizeof *watch);
    long frames = frame_count(m), compared = 0;
    int fired = 0;
    for (long f = 0; f <= frames; f++) {
        wg_player_update(&m->player, (uint32_t)((uint64_t)f * CERTIFY_FRAME_US));
        fired |= take_events(m);
        wg_player_sample(&m->player, m->played);
        if (!fired) {
            author_frame(m);
            compare(m, (double)f * CERTIFY_FRAME_US * 1e-6, channel);
            compared++;
        }
        wg_fields_set(m->file, m->played);
        for (int i = 0; i < s->servo_count; i++) {
            servo_frame(m->b, m->file, m->played, &watch[i], &servo[i]);
        }
    }
    free(watch);
    return compared;
}

static void finish(const build *b, long compared, certificate *c)
{
    certificate_channel *channel = &c->channel[c->channel_count];
    certificate_servo *servo = &c->servo[c->servo_count];
    for (int i = 0; i < b->scene->channel_count; i++) {
        channel[i].rms = sqrt(channel[i].rms / (double)compared); /* frame 0 always is */
        c->failed += channel[i].largest > channel[i].tolerance;
    }
    for (int i = 0; i < b->scene->servo_count; i++) {
        const scene_servo *s = &b->scene->servos[i];
        servo[i].error = channel[s->channel].largest * fabs(s->gain);
        servo_end(b, &servo[i]);
    }
    c->channel_count += b->scene->channel_count;
    c->servo_count += b->scene->servo_count;
}

void certify_mix(const build *b, const wg_file *file, certificate *c)
{
    const scene *s = b->scene;
    size_t channels = (size_t)s->channel_count;
    if (s->layer_count == 0) {
        return; /* nothing plays until the program says so */
    }
    mix m = {.b = b, .file = file};
    m.played = bake_alloc(channels, sizeof *m.played);
    m.value = bake_alloc(channels, sizeof *m.value);
    m.bound = bake_alloc(channels, sizeof *m.bound);
    for (int i = 0; i < s->channel_count; i++) {
        c->channel[c->channel_count + i] = (certificate_channel){
            .clip = CERTIFY_MIX, .curve = -1, .channel = i, .range = b->range[i]};
    }
    for (int i = 0; i < s->servo_count; i++) {
        certificate_servo *row = &c->servo[c->servo_count + i];
        *row = (certificate_servo){.clip = CERTIFY_MIX, .servo = i};
        servo_begin(row);
    }
    wg_player_init(&m.player, file, m.layers, (uint8_t)s->layer_count);
    long compared = play(&m, &c->channel[c->channel_count], &c->servo[c->servo_count]);
    c->mix_seconds = (double)frame_count(&m) * CERTIFY_FRAME_US * 1e-6;
    c->mix_compared = (double)(compared - 1) * CERTIFY_FRAME_US * 1e-6;
    finish(b, compared, c);
    free(m.played);
    free(m.value);
    free(m.bound);
}
