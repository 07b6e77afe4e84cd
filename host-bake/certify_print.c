/* The certificate for people and as JSON.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify.h"

#include <stdlib.h>

static const char *const SECTION[WG_SECTION_KNOWN + 1] = {
    "",      "channels", "clips",   "tracks",   "runs",   "data", "events",
    "masks", "layers",   "filters", "triggers", "servos", "names"};
static const char *const UNIT[] = {"", "deg", "us", "mm"};

static void print_channel(const build *b, const certificate_channel *h, FILE *to)
{
    const scene_channel *c = &b->scene->channels[h->channel];
    fprintf(to, "  %-12s %-14s %9.3g %9.3g %-4s at %8.3f s %9.3g %5d %6d%s\n",
            b->scene->clips[h->clip].name, c->name, h->largest, h->rms, UNIT[c->unit], h->when,
            h->tolerance, h->segments, h->waves, h->largest > h->tolerance ? "  OVER" : "");
}

static void print_servo(const build *b, const certificate_servo *v, FILE *to)
{
    const scene_servo *s = &b->scene->servos[v->servo];
    fprintf(to, "  %-12s %-14s %9.3g %-5s %8.1f..%-8.1f %9.0f %10.0f %11.0f",
            b->scene->clips[v->clip].name, s->name, v->error, servo_unit(s->protocol), v->low,
            v->high, v->velocity, v->acceleration, v->jerk);
    if (v->clipped) {
        fprintf(to, "  %d frames beyond its end stops", v->clipped);
    }
    if (v->limited) {
        fprintf(to, "  %d frames beyond its limits", v->limited);
    }
    fputc('\n', to);
}

void certificate_print(const build *b, const certificate *c, FILE *to)
{
    fprintf(to, "played against authored (every quarter tick)\n"
                "  clip         channel          largest       rms                   tolerance "
                "segs  waves\n");
    for (int i = 0; i < c->channel_count; i++) {
        print_channel(b, &c->channel[i], to);
    }
    if (c->servo_count > 0) {
        fprintf(to,
                "servos (frames of 20 ms)\n"
                "  clip         servo              error       position            per s      per "
                "s^2      per s^3\n");
    }
    for (int i = 0; i < c->servo_count; i++) {
        print_servo(b, &c->servo[i], to);
    }
    fprintf(to, "bytes %zu:", c->file_bytes);
    for (unsigned k = 1; k <= WG_SECTION_KNOWN; k++) {
        if (c->section_bytes[k] > 0) {
            fprintf(to, " %s %zu", SECTION[k], c->section_bytes[k]);
        }
    }
    fprintf(to,
            "\nRAM %zu bytes; a layer's tick: at most %d search rounds, %d multiplications, %d "
            "divisions\n",
            c->ram_bytes, c->search_rounds, c->multiplications, c->divisions);
    for (int i = 0; i < c->channel_count; i++) {
        const certificate_channel *h = &c->channel[i];
        if (h->largest > h->tolerance) {
            fprintf(
                to,
                "FAILED: clip %s, channel %s is off by %.3g %s at %.3f s; the tolerance is %.3g\n",
                b->scene->clips[h->clip].name, b->scene->channels[h->channel].name, h->largest,
                UNIT[b->scene->channels[h->channel].unit], h->when, h->tolerance);
        }
    }
}

/* A JSON string; names may hold anything. */
static void add_name(bytes *out, const char *key, const char *name)
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

void certificate_json(const build *b, const certificate *c, bytes *out)
{
    const scene *s = b->scene;
    put_text(out, "{\n  \"passed\": %s,\n  \"bytes\": %zu,\n  \"sections\": {",
             c->failed ? "false" : "true", c->file_bytes);
    for (unsigned k = 1; k <= WG_SECTION_KNOWN; k++) {
        put_text(out, "%s\"%s\": %zu", k > 1 ? ", " : "", SECTION[k], c->section_bytes[k]);
    }
    put_text(
        out,
        "},\n  \"ram_bytes\": %zu,\n  \"tick\": {\"search_rounds\": %d, \"multiplications\": %d, "
        "\"divisions\": %d},\n  \"channels\": [",
        c->ram_bytes, c->search_rounds, c->multiplications, c->divisions);
    for (int i = 0; i < c->channel_count; i++) {
        const certificate_channel *h = &c->channel[i];
        put_text(out, "%s\n    {", i ? "," : "");
        add_name(out, "clip", s->clips[h->clip].name);
        add_name(out, "channel", s->channels[h->channel].name);
        put_text(
            out,
            "\"unit\": \"%s\", \"error_max\": %.9g, \"error_at_s\": %.6f, \"error_rms\": %.9g, "
            "\"tolerance\": %.9g, \"range\": %.9g, \"runs\": %d, \"segments\": %d, \"waves\": %d}",
            UNIT[s->channels[h->channel].unit], h->largest, h->when, h->rms, h->tolerance, h->range,
            h->runs, h->segments, h->waves);
    }
    put_text(out, "\n  ],\n  \"servos\": [");
    for (int i = 0; i < c->servo_count; i++) {
        const certificate_servo *v = &c->servo[i];
        put_text(out, "%s\n    {", i ? "," : "");
        add_name(out, "clip", s->clips[v->clip].name);
        add_name(out, "servo", s->servos[v->servo].name);
        put_text(out,
                 "\"unit\": \"%s\", \"error_max\": %.9g, \"low\": %.3f, \"high\": %.3f, "
                 "\"velocity\": %.3f, "
                 "\"acceleration\": %.3f, \"jerk\": %.3f, \"frames_clipped\": %d, "
                 "\"frames_limited\": %d}",
                 servo_unit(s->servos[v->servo].protocol), v->error, v->low, v->high, v->velocity,
                 v->acceleration, v->jerk, v->clipped, v->limited);
    }
    put_text(out, "\n  ]\n}\n");
}
