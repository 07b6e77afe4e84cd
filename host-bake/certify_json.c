/* The certificate as JSON.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_parts.h"

void json_name(bytes *out, const char *key, const char *name)
{
    put_text(out, "\"%s\": \"", key);
    for (const char *p = name; *p; p++) {
        if (*p == '"' || *p == '\\') {
            put8(out, '\\');
            put8(out, (unsigned char)*p);
        } else if ((unsigned char)*p < 32) {
            put_text(out, "\\u%04x", (unsigned char)*p);
        } else {
            put8(out, (unsigned char)*p);
        }
    }
    put_text(out, "\", ");
}

static void add_channels(const build *b, const certificate *c, int mix, bytes *out)
{
    const char *comma = "";
    for (int i = 0; i < c->channel_count; i++) {
        const certificate_channel *h = &c->channel[i];
        const scene_channel *channel = &b->scene->channels[h->channel];
        if ((h->clip == CERTIFY_MIX) != mix) {
            continue;
        }
        put_text(out, "%s\n    {", comma);
        comma = ",";
        json_name(out, "clip", certificate_clip(b, h->clip));
        json_name(out, "channel", channel->name);
        put_text(
            out,
            "\"unit\": \"%s\", \"error_max\": %.9g, \"error_at_s\": %.6f, \"error_rms\": %.9g, "
            "\"tolerance\": %.9g, \"range\": %.9g, \"runs\": %d, \"segments\": %d, \"waves\": %d}",
            unit_name(channel->unit), h->largest, h->when, h->rms, h->tolerance, h->range, h->runs,
            h->segments, h->waves);
    }
}

static void add_servos(const build *b, const certificate *c, int mix, bytes *out)
{
    const char *comma = "";
    for (int i = 0; i < c->servo_count; i++) {
        const certificate_servo *v = &c->servo[i];
        const scene_servo *servo = &b->scene->servos[v->servo];
        if ((v->clip == CERTIFY_MIX) != mix) {
            continue;
        }
        put_text(out, "%s\n    {", comma);
        comma = ",";
        json_name(out, "clip", certificate_clip(b, v->clip));
        json_name(out, "servo", servo->name);
        put_text(out,
                 "\"unit\": \"%s\", \"error_max\": %.9g, \"low\": %.3f, \"high\": %.3f, "
                 "\"velocity\": %.3f, \"acceleration\": %.3f, \"jerk\": %.3f, "
                 "\"frames_clipped\": %d, \"frames_limited\": %d}",
                 servo_unit(servo->protocol), v->error, v->low, v->high, v->velocity,
                 v->acceleration, v->jerk, v->clipped, v->limited);
    }
}

void certificate_json(const build *b, const certificate *c, bytes *out)
{
    put_text(out, "{\n  \"passed\": %s,\n  \"bytes\": %zu,\n  \"sections\": {",
             c->failed ? "false" : "true", c->file_bytes);
    for (unsigned k = 1; k <= WG_SECTION_KNOWN; k++) {
        put_text(out, "%s\"%s\": %zu", k > 1 ? ", " : "", section_name(k), c->section_bytes[k]);
    }
    put_text(
        out,
        "},\n  \"ram_bytes\": %zu,\n  \"tick\": {\"search_rounds\": %d, \"multiplications\": %d, "
        "\"divisions\": %d},\n  \"channels\": [",
        c->ram_bytes, c->search_rounds, c->multiplications, c->divisions);
    add_channels(b, c, 0, out);
    put_text(out, "\n  ],\n  \"servos\": [");
    add_servos(b, c, 0, out);
    put_text(out,
             "\n  ],\n  \"mix\": {\"seconds\": %.3f, \"compared_seconds\": %.3f, \"channels\": [",
             c->mix_seconds, c->mix_compared);
    add_channels(b, c, 1, out);
    put_text(out, "\n  ], \"servos\": [");
    add_servos(b, c, 1, out);
    put_text(out, "\n  ]},\n  ");
    certificate_json_meshes(b, c, out);
    put_text(out, ",\n  ");
    certificate_json_bodies(b, out);
    put_text(out, ",\n  ");
    certificate_json_skins(b, out);
    put_text(out, "\n}\n");
}
