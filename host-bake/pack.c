/* Tracks and tables as the bytes of a clip file.
 * Source: SPEC 3, 4. Shapes, parts and views: shape_pack.c.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_pack.h"
#include "skin_pack.h"

#include <math.h>
#include <string.h>

/* The channel's scale holds every value that build_scale has seen. */
static int32_t raw(const build *b, int channel, double value)
{
    return (int32_t)floor(ldexp(value, b->frac[channel]) + 0.5);
}

static void pack_channels(const build *b, packed *out)
{
    for (int i = 0; i < b->scene->channel_count; i++) {
        bytes *o = &out->at[WG_SECTION_CHANNELS];
        put8(o, (uint32_t)b->frac[i]);
        put8(o, (uint32_t)b->scene->channels[i].unit);
        put16(o, 0);
        put32(o, (uint32_t)raw(b, i, b->scene->channels[i].rest));
    }
    out->count[WG_SECTION_CHANNELS] = b->scene->channel_count;
}

static void pack_time_base(const author_clip *c, bytes *o, int end)
{
    double ticks_a_us = c->rate * 65536.0 / 1e6;
    int shift = 0;
    while (shift < 40 && floor(ldexp(ticks_a_us, shift + 1) + 0.5) < 4294967296.0) {
        shift++;
    }
    uint64_t us = (uint64_t)floor(c->ticks * 1e6 / c->rate * 65536.0 + 0.5);
    put32(o, (uint32_t)floor(ldexp(ticks_a_us, shift) + 0.5));
    put8(o, (uint32_t)shift);
    put8(o, (uint32_t)end);
    put16(o, (uint32_t)c->ticks);
    put32(o, (uint32_t)(us >> 16));
    put16(o, us & 65535u);
    put16(o, (uint32_t)c->rate);
}

/* An event at the very end moves to the last tick: ticks are below the duration (SPEC 4.6). */
static void pack_events(const author_clip *a, const scene_clip *clip, packed *out)
{
    for (int i = 0; i < clip->event_count; i++) {
        int tick = (int)lround(clip->events[i].time * a->rate);
        put16(&out->at[WG_SECTION_EVENTS], (uint32_t)(tick < a->ticks ? tick : a->ticks - 1));
        put16(&out->at[WG_SECTION_EVENTS], (uint32_t)clip->events[i].id);
    }
    out->count[WG_SECTION_EVENTS] += clip->event_count;
}

static void pack_clips(const build *b, packed *out)
{
    for (int i = 0; i < b->scene->clip_count; i++) {
        const scene_clip *clip = &b->scene->clips[i];
        bytes *o = &out->at[WG_SECTION_CLIPS];
        pack_time_base(&b->clip[i], o, clip->end);
        put16(o, (uint32_t)out->count[WG_SECTION_TRACKS]);
        put16(o, (uint32_t)clip->curve_count);
        put16(o, (uint32_t)out->count[WG_SECTION_EVENTS]);
        put16(o, (uint32_t)clip->event_count);
        pack_events(&b->clip[i], clip, out);
        for (int j = 0; j < clip->curve_count; j++) {
            const bake_track *t = &b->track[i][j];
            put16(&out->at[WG_SECTION_TRACKS], (uint32_t)clip->curves[j].channel);
            put16(&out->at[WG_SECTION_TRACKS], (uint32_t)out->count[WG_SECTION_RUNS]);
            put16(&out->at[WG_SECTION_TRACKS], (uint32_t)t->count);
            for (int k = 0; k < t->count; k++) {
                track_put_run(&t->run[k], &out->at[WG_SECTION_RUNS], &out->at[WG_SECTION_DATA]);
            }
            out->count[WG_SECTION_RUNS] += t->count;
            out->count[WG_SECTION_TRACKS]++;
        }
    }
    out->count[WG_SECTION_CLIPS] = b->scene->clip_count;
}

static void pack_layers(const build *b, packed *out)
{
    const scene *s = b->scene;
    for (int i = 0; i < s->mask_count; i++) {
        for (int c = 0; c < s->channel_count; c++) {
            put8(&out->at[WG_SECTION_MASKS], (uint32_t)lround(255 * s->masks[i].weight[c]));
        }
    }
    out->count[WG_SECTION_MASKS] = s->mask_count;
    for (int i = 0; i < s->layer_count; i++) {
        const scene_layer *l = &s->layers[i];
        bytes *o = &out->at[WG_SECTION_LAYERS];
        put8(o, l->clip < 0 ? WG_NONE : (uint32_t)l->clip);
        put8(o, (uint32_t)l->mode);
        put8(o, l->mask < 0 ? WG_NONE : (uint32_t)l->mask);
        put8(o, 0);
        put16(o, (uint32_t)lround(l->weight * WG_WEIGHT_ONE));
        put16(o, 0);
    }
    out->count[WG_SECTION_LAYERS] = s->layer_count;
    for (int i = 0; i < s->trigger_count; i++) {
        const scene_trigger *t = &s->triggers[i];
        bytes *o = &out->at[WG_SECTION_TRIGGERS];
        put16(o, (uint32_t)t->event);
        put8(o, (uint32_t)t->layer);
        put8(o, t->clip < 0 ? WG_NONE : (uint32_t)t->clip);
        put16(o, (uint32_t)fmin(65535, floor(1000 * t->fade + 0.5)));
        put16(o, 0);
    }
    out->count[WG_SECTION_TRIGGERS] = s->trigger_count;
}

/* Q12 keeps an entry to half a step; what that does to the row's sum must stay below the target's
 * tolerance, or the matrix would not do what the scene says. */
static int check_row(const build *b, int index, int i, bake_error *error)
{
    const scene_filter *f = &b->scene->filters[index];
    const double *input = b->input[index];
    const scene_channel *channels = b->scene->channels;
    int to = f->channels[i], worst = 0;
    double loss = 0, most = -1;
    for (int j = 0; j < f->n; j++) {
        int shift = 12 + b->frac[to] - b->frac[f->channels[j]];
        double stored = ldexp(floor(ldexp(f->matrix[i][j], shift) + 0.5), -shift);
        double e = fabs(stored - f->matrix[i][j]) * input[j];
        loss += e;
        worst = e > most ? j : worst;
        most = fmax(most, e);
    }
    return loss <= b->tolerance[to]
               ? 0
               : bake_fail(error,
                           "%s: matrix filter, row %d: rounding its entries to 12 bits moves "
                           "channel %s by up to %.3g, most of it through %g from channel %s, "
                           "which reaches %g; the tolerance is %.3g: raise it, or bring the "
                           "ranges of the two channels closer together",
                           b->scene->path, i + 1, channels[to].name, loss, f->matrix[i][worst],
                           channels[f->channels[worst]].name, input[worst], b->tolerance[to]);
}

/* M acts on values in their units, the player on raw ones: M_ij 2^(frac_i - frac_j), Q12. */
static int pack_matrix(const build *b, int index, packed *out, bake_error *error)
{
    const scene_filter *f = &b->scene->filters[index];
    bytes *data = &out->at[WG_SECTION_DATA];
    put_align(data, 2);
    put32(&out->at[WG_SECTION_FILTERS], (uint32_t)data->count);
    put32(&out->at[WG_SECTION_FILTERS], 0);
    for (int i = 0; i < f->n; i++) {
        put16(data, (uint32_t)f->channels[i]);
    }
    for (int i = 0; i < f->n; i++) {
        if (check_row(b, index, i, error) < 0) {
            return -1;
        }
        for (int j = 0; j < f->n; j++) {
            int shift = 12 + b->frac[f->channels[i]] - b->frac[f->channels[j]];
            double m = floor(ldexp(f->matrix[i][j], shift) + 0.5);
            if (fabs(m) > 32767) {
                return bake_fail(
                    error,
                    "%s: matrix filter, row %d, column %d: %g from channel %s to %s is "
                    "more than the format's 8 (in steps of their ranges)",
                    b->scene->path, i + 1, j + 1, f->matrix[i][j],
                    b->scene->channels[f->channels[j]].name,
                    b->scene->channels[f->channels[i]].name);
            }
            put16(data, (uint32_t)(int32_t)m & 65535u);
        }
    }
    return 0;
}

static int pack_constant(const build *b, int index, double value, packed *out, bake_error *error)
{
    static const char *const ops[] = {"offset", "gain", "clamp", "minimum"};
    const scene_filter *f = &b->scene->filters[index];
    double most = ldexp((double)WG_VALUE_LIMIT, -b->frac[f->channel]);
    if (fabs(value) > most) {
        return bake_fail(error,
                         "%s: filter %d, %s of channel %s: %g is beyond +-%g, all that the "
                         "channel's scale holds: bring it nearer to the channel's values",
                         b->scene->path, index + 1, ops[f->op], b->scene->channels[f->channel].name,
                         value, most);
    }
    put32(&out->at[WG_SECTION_FILTERS], (uint32_t)raw(b, f->channel, value));
    return 0;
}

static int pack_filters(const build *b, packed *out, bake_error *error)
{
    for (int i = 0; i < b->scene->filter_count; i++) {
        const scene_filter *f = &b->scene->filters[i];
        bytes *o = &out->at[WG_SECTION_FILTERS];
        put8(o, (uint32_t)f->op);
        put8(o, f->op == (int)WG_FILTER_MATRIX ? (uint32_t)f->n : 0);
        put16(o, f->op == (int)WG_FILTER_MATRIX ? 0 : (uint32_t)f->channel);
        int err = 0;
        if (f->op == (int)WG_FILTER_MATRIX) {
            err = pack_matrix(b, i, out, error);
        } else if (f->op == (int)WG_FILTER_GAIN) { /* the schema keeps it within +-4096 */
            put32(o, (uint32_t)(int32_t)lround(f->a * 65536));
        } else {
            err = pack_constant(b, i, f->a, out, error);
        }
        if (err == 0 && f->op != (int)WG_FILTER_MATRIX) {
            err = pack_constant(b, i, f->b, out, error);
        }
        if (err < 0) {
            return err;
        }
    }
    out->count[WG_SECTION_FILTERS] = b->scene->filter_count;
    return 0;
}

static uint32_t clamped(double x, double lo, double hi)
{
    return (uint32_t)(int32_t)lround(fmax(lo, fmin(hi, x)));
}

/* gain: positions a unit, as a 16-bit mantissa of positions Q8 a raw unit. */
static void pack_servos(const build *b, packed *out)
{
    for (int i = 0; i < b->scene->servo_count; i++) {
        const scene_servo *v = &b->scene->servos[i];
        bytes *o = &out->at[WG_SECTION_SERVOS];
        double gain = ldexp(v->gain, 8 - b->frac[v->channel]);
        int shift = 0;
        while (shift < 40 && fabs(ldexp(gain, shift + 1)) <= 32767) {
            shift++;
        }
        put8(o, (uint32_t)v->protocol);
        put8(o, (uint32_t)v->id);
        put16(o, (uint32_t)v->channel);
        put32(o, clamped(256 * v->centre, -(double)WG_VALUE_LIMIT, (double)WG_VALUE_LIMIT));
        put16(o, clamped(ldexp(gain, shift), -32767, 32767) & 65535u);
        put8(o, (uint32_t)shift);
        put8(o, 0);
        put16(o, clamped(v->min, -32768, 32767) & 65535u);
        put16(o, clamped(v->max, -32768, 32767) & 65535u);
        put16(o, clamped(v->velocity, v->velocity > 0, 65535)); /* 0 would be unlimited */
        put16(o, clamped(v->acceleration / 16, v->acceleration > 0, 65535));
    }
    out->count[WG_SECTION_SERVOS] = b->scene->servo_count;
}

static void pack_name(const char *name, packed *out)
{
    put_copy(&out->at[WG_SECTION_NAMES], name, strlen(name) + 1);
    out->count[WG_SECTION_NAMES]++;
}

static void pack_names(const scene *s, packed *out)
{
    for (int i = 0; i < s->channel_count; i++) {
        pack_name(s->channels[i].name, out);
    }
    for (int i = 0; i < s->clip_count; i++) {
        pack_name(s->clips[i].name, out);
    }
    for (int i = 0; i < s->servo_count; i++) {
        pack_name(s->servos[i].name, out);
    }
    for (int i = 0; i < s->layer_count; i++) {
        pack_name(s->layers[i].name, out);
    }
    for (int i = 0; i < s->event_name_count; i++) {
        pack_name(s->event_names[i], out);
    }
}

static uint32_t crc32(const uint8_t *at, size_t count)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < count; i++) {
        crc ^= at[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

static void write32(uint8_t *at, uint32_t value)
{
    for (int i = 0; i < 4; i++) {
        at[i] = (uint8_t)(value >> 8 * i);
    }
}

/* Header and directory, then the sections that have something in them. */
static void assemble(const packed *s, bytes *file)
{
    uint32_t count = 0;
    for (unsigned k = 1; k <= WG_SECTION_KNOWN; k++) {
        count += s->at[k].count > 0;
    }
    put32(file, WG_FORMAT_MAGIC);
    put32(file, 0);
    put8(file, WG_FORMAT_MAJOR);
    put8(file, WG_FORMAT_MINOR);
    put16(file, count);
    put32(file, 0);
    uint32_t offset = WG_HEADER_BYTES + count * WG_DIRECTORY_BYTES;
    for (unsigned k = 1; k <= WG_SECTION_KNOWN; k++) {
        if (s->at[k].count > 0) {
            put16(file, k);
            put16(file, (uint32_t)s->count[k]);
            put32(file, offset);
            put32(file, (uint32_t)s->at[k].count);
            offset += ((uint32_t)s->at[k].count + 3u) & ~3u;
        }
    }
    for (unsigned k = 1; k <= WG_SECTION_KNOWN; k++) {
        put_copy(file, s->at[k].at, s->at[k].count);
        put_align(file, 4);
    }
    write32(file->at + WG_HEADER_LENGTH, (uint32_t)file->count);
    write32(file->at + WG_HEADER_CRC,
            crc32(file->at + WG_HEADER_MAJOR, file->count - WG_HEADER_MAJOR));
}

/* The finished file is opened by the real player: what it refuses is not delivered. */
int build_pack(build *b, bake_error *error)
{
    packed s;
    memset(&s, 0, sizeof s);
    pack_channels(b, &s);
    pack_clips(b, &s);
    pack_layers(b, &s);
    int err = pack_filters(b, &s, error);
    pack_servos(b, &s);
    pack_names(b->scene, &s);
    if (err == 0) {
        err = shapes_pack(b, &s, error);
    }
    if (err == 0) {
        err = skins_pack(b, &s, error);
    }
    for (unsigned k = 1; k <= WG_SECTION_KNOWN && err == 0; k++) {
        if (s.count[k] > 65535) {
            err = bake_fail(error,
                            "%s: %d records in section %u, the format has room for 65535: split "
                            "the clip",
                            b->scene->path, s.count[k], k);
        }
    }
    if (err == 0) {
        assemble(&s, &b->file);
        wg_file file;
        int code = wg_open(&file, b->file.at, (uint32_t)b->file.count);
        code = code < 0 ? code : wg_open_shapes(&file);
        code = code < 0 ? code : wg_open_skins(&file);
        if (code < 0) {
            err = bake_fail(error,
                            "%s: the player refuses the baked file with code %d; this is a fault "
                            "of the baker, please report it with the scene",
                            b->scene->path, code);
        }
    }
    for (unsigned k = 0; k <= WG_SECTION_KNOWN; k++) {
        bytes_free(&s.at[k]);
    }
    return err;
}
