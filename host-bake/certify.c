/* The certificate: replays the finished file with the real player.
 * Source: own (DESIGN 1, promise 4).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_parts.h"
#include "fit.h"
#include "record.h"
#include "shapes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const uint8_t *track_record(const wg_file *file, int clip, int curve)
{
    const uint8_t *c = clip_record(file, clip);
    return record(file, WG_SECTION_TRACKS, get16(c + WG_CLIP_TRACK_FIRST) + curve, WG_TRACK_BYTES);
}

static int channel_frac(const wg_file *file, int channel)
{
    return (int8_t)get8(record(file, WG_SECTION_CHANNELS, channel, WG_CHANNEL_BYTES));
}

static int same_form(const wg_file *file, int shape, const shape_form *form)
{
    const uint8_t *r = record(file, WG_SECTION_SHAPES, shape, WG_SHAPE_BYTES);
    return get16(r + WG_SHAPE_VERTICES) == form->vertex_count &&
           get16(r + WG_SHAPE_BASIS_COUNT) == form->basis_count;
}

/* The file must be a bake of this scene, or there is nothing to compare. */
static int check_match(const build *b, const wg_file *file, bake_error *error)
{
    const scene *s = b->scene;
    int good = file->section[WG_SECTION_CHANNELS].count == s->channel_count &&
               file->section[WG_SECTION_CLIPS].count == s->clip_count &&
               file->section[WG_SECTION_SERVOS].count == s->servo_count &&
               file->section[WG_SECTION_LAYERS].count == s->layer_count &&
               file->section[WG_SECTION_FILTERS].count == s->filter_count &&
               file->section[WG_SECTION_TRIGGERS].count == s->trigger_count;
    int meshes = b->shapes ? b->shapes->count : 0;
    good = good && wg_open_shapes(file) >= 0; /* or nothing may look at its vertices */
    good = good && file->section[WG_SECTION_VIEWS].count == s->view_count;
    for (int i = 0, shape = 0; good && i < meshes; shape += 1 + b->shapes->mesh[i++].has_normals) {
        good = file->section[WG_SECTION_SHAPES].count > shape &&
               same_form(file, shape, &b->shapes->mesh[i].form);
    }
    for (int i = 0; good && i < s->clip_count; i++) {
        const uint8_t *c = clip_record(file, i);
        good = get16(c + WG_CLIP_TRACK_COUNT) == s->clips[i].curve_count &&
               get16(c + WG_CLIP_TICKS) == b->clip[i].ticks &&
               get16(c + WG_CLIP_RATE) == b->clip[i].rate;
        for (int j = 0; good && j < s->clips[i].curve_count; j++) {
            good = get16(track_record(file, i, j)) == s->clips[i].curves[j].channel;
        }
    }
    return good ? 0
                : bake_fail(error,
                            "%s: the clip was not baked from this scene (other clips, channels, "
                            "layers or lengths): bake it again",
                            s->path);
}

static void count_runs(const wg_file *file, const uint8_t *track, certificate_channel *c)
{
    c->runs = get16(track + WG_TRACK_RUN_COUNT);
    for (int i = 0; i < c->runs; i++) {
        const uint8_t *run =
            record(file, WG_SECTION_RUNS, get16(track + WG_TRACK_RUN_FIRST) + i, WG_RUN_BYTES);
        int segments = get16(run + WG_RUN_SEGMENTS);
        c->segments += segments;
        c->waves += get8(run + WG_RUN_KIND) > (int)WG_KIND_CUBIC ? segments : 0;
    }
}

/* Every quarter tick, but no more than 200,000 places of a clip. */
static void replay_channel(const build *b, const wg_file *file, certificate_channel *c)
{
    const author_clip *a = &b->clip[c->clip];
    const fit_problem p = {.curve = &a->curve[c->curve], .rate = a->rate};
    const uint8_t *head = clip_record(file, c->clip);
    uint16_t track = (uint16_t)(get16(head + WG_CLIP_TRACK_FIRST) + c->curve);
    int frac = channel_frac(file, c->channel), places = 4 * a->ticks;
    double sum = 0;
    places = places > 200000 ? 200000 : places;
    for (int i = 0; i < places; i++) {
        uint32_t position = (uint32_t)(65536.0 * a->ticks * i / places);
        double value, slope;
        fit_truth(&p, position / 65536.0, &value, &slope);
        double e = fabs(ldexp(wg_track_value(file, track, position), -frac) - value);
        sum += e * e;
        if (e > c->largest) {
            c->largest = e;
            c->when = position / 65536.0 / a->rate;
        }
    }
    c->rms = sqrt(sum / places);
}

/* 32-bit multiplications and divisions of one evaluation, counted in firmware/player/curve.c. */
static void count_operations(const wg_file *file, int clip, certificate *c)
{
    static const int MULTIPLY[WG_KIND_COUNT] = {4, 4, 6, 22, 15, 15, 20, 13};
    static const int DIVIDE[WG_KIND_COUNT] = {1, 1, 1, 0, 1, 1, 0, 1};
    const uint8_t *head = clip_record(file, clip);
    int rounds = 0, multiply = 0, divide = 0;
    for (int j = 0; j < get16(head + WG_CLIP_TRACK_COUNT); j++) {
        const uint8_t *track = track_record(file, clip, j);
        int runs = get16(track + WG_TRACK_RUN_COUNT), most[3] = {0};
        for (int i = 0; i < runs; i++) {
            const uint8_t *run =
                record(file, WG_SECTION_RUNS, get16(track + WG_TRACK_RUN_FIRST) + i, WG_RUN_BYTES);
            int kind = get8(run + WG_RUN_KIND);
            int need = (int)ceil(log2(get16(run + WG_RUN_SEGMENTS)));
            most[0] = need > most[0] ? need : most[0];
            most[1] = MULTIPLY[kind] > most[1] ? MULTIPLY[kind] : most[1];
            most[2] = DIVIDE[kind] > most[2] ? DIVIDE[kind] : most[2];
        }
        rounds += most[0] + (int)ceil(log2(runs));
        multiply += most[1] + 1; /* and the layer's weight */
        divide += most[2];
    }
    if (multiply > c->multiplications) {
        c->search_rounds = rounds;
        c->multiplications = multiply;
        c->divisions = divide;
    }
}

/* wg_file, wg_player, wg_layer, wg_servo on a 32-bit processor: tests/fw_size.c asserts them. */
static size_t ram(const scene *s)
{
    size_t layers = s->layer_count > 0 ? (size_t)s->layer_count : 1;
    return 12 * (WG_SECTION_KNOWN + 1) + 16 + 48 * layers + 4 * (size_t)s->channel_count +
           12 * (size_t)s->servo_count;
}

static void certify_clip(const build *b, const wg_file *file, int i, certificate *c)
{
    const scene *s = b->scene;
    for (int j = 0; j < s->clips[i].curve_count; j++) {
        certificate_channel *h = &c->channel[c->channel_count++];
        h->clip = i;
        h->curve = j;
        h->channel = s->clips[i].curves[j].channel;
        h->tolerance = b->tolerance[h->channel];
        h->range = b->range[h->channel];
        count_runs(file, track_record(file, i, j), h);
        replay_channel(b, file, h);
        c->failed += h->largest > h->tolerance;
        for (int k = 0; k < s->servo_count && !s->clips[i].additive; k++) {
            if (s->servos[k].channel == h->channel) {
                certificate_servo *v = &c->servo[c->servo_count++];
                v->clip = i;
                v->servo = k;
                v->error = h->largest * fabs(s->servos[k].gain);
                certify_servo(b, file, v);
            }
        }
    }
    count_operations(file, i, c);
}

static void certify_meshes(const build *b, const wg_file *file, certificate *c)
{
    c->mesh_count = b->shapes ? b->shapes->count : 0;
    c->mesh = bake_alloc((size_t)c->mesh_count + 1, sizeof *c->mesh);
    for (int i = 0; i < c->mesh_count; i++) {
        certify_mesh(b, file, i, &c->mesh[i]);
        certify_levels(b, file, i, &c->mesh[i]);
        c->failed += c->mesh[i].largest > c->mesh[i].tolerance;
    }
}

int certify(const build *b, const wg_file *file, size_t file_bytes, certificate *c,
            bake_error *error)
{
    const scene *s = b->scene;
    size_t curves = 1;
    memset(c, 0, sizeof *c);
    if (check_match(b, file, error) < 0) {
        return -1;
    }
    for (int i = 0; i < s->clip_count; i++) {
        curves += (size_t)s->clips[i].curve_count;
    }
    c->channel = bake_alloc(curves + (size_t)s->channel_count, sizeof *c->channel);
    c->servo = bake_alloc((curves + 1) * ((size_t)s->servo_count + 1), sizeof *c->servo);
    c->file_bytes = file_bytes;
    c->ram_bytes = ram(s);
    for (unsigned k = 1; k <= WG_SECTION_KNOWN; k++) {
        c->section_bytes[k] = file->section[k].bytes;
    }
    for (int i = 0; i < s->clip_count; i++) {
        certify_clip(b, file, i, c);
    }
    certify_mix(b, file, c);
    certify_meshes(b, file, c);
    c->failed += certify_skins(b);
    c->picture_ram = certify_picture_ram(b);
    c->over_flash = s->flash_bytes > 0 && (double)file_bytes > s->flash_bytes;
    c->over_ram = s->ram_bytes > 0 && (double)(c->ram_bytes + c->picture_ram) > s->ram_bytes;
    c->failed += c->over_flash + c->over_ram;
    return 0;
}

void certificate_free(certificate *c)
{
    for (int i = 0; i < c->mesh_count; i++) {
        certificate_mesh_free(&c->mesh[i]);
    }
    free(c->mesh);
    free(c->channel);
    free(c->servo);
    memset(c, 0, sizeof *c);
}
