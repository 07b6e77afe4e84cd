/* The certificate for people.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_parts.h"
#include "shapes.h"

const char *unit_name(int unit)
{
    static const char *const NAME[] = {"", "deg", "us", "mm"};
    return unit >= 0 && unit < (int)(sizeof NAME / sizeof *NAME) ? NAME[unit] : "";
}

const char *certificate_clip(const build *b, int clip)
{
    return clip == CERTIFY_MIX ? "(mix)" : b->scene->clips[clip].name;
}

const char *section_name(unsigned kind)
{
    static const char *const NAME[WG_SECTION_KNOWN + 1] = {
        "",       "channels", "clips",    "tracks", "runs",  "data",   "events", "masks",
        "layers", "filters",  "triggers", "servos", "names", "shapes", "bases",  "blocks",
        "parts",  "views",    "bones",    "joints", "skins", "spans",  "fields", "paints"};
    return NAME[kind];
}

/* Weights of meshes are many, and what counts is the surface they make. */
static int is_made(const build *b, int channel)
{
    return b->shapes && channel >= b->shapes->channel_first;
}

/* What no clip moves rests in the mix as well. */
static int is_still(const build *b, int channel)
{
    const scene *s = b->scene;
    for (int i = 0; i < s->clip_count; i++) {
        for (int j = 0; j < s->clips[i].curve_count; j++) {
            if (s->clips[i].curves[j].channel == channel) {
                return 0;
            }
        }
    }
    return 1;
}

static void print_channel(const build *b, const certificate_channel *h, FILE *to)
{
    const scene_channel *c = &b->scene->channels[h->channel];
    fprintf(to, "  %-12s %-14s %9.3g %9.3g %-4s at %8.3f s %9.3g", certificate_clip(b, h->clip),
            c->name, h->largest, h->rms, unit_name(c->unit), h->when, h->tolerance);
    if (h->clip != CERTIFY_MIX) {
        fprintf(to, " %5d %6d", h->segments, h->waves);
    }
    fputs(h->largest > h->tolerance ? "  OVER\n" : "\n", to);
}

static void print_servo(const build *b, const certificate_servo *v, FILE *to)
{
    const scene_servo *s = &b->scene->servos[v->servo];
    fprintf(to, "  %-12s %-14s %9.3g %-5s %8.1f..%-8.1f %9.0f %10.0f %11.0f",
            certificate_clip(b, v->clip), s->name, v->error, servo_unit(s->protocol), v->low,
            v->high, v->velocity, v->acceleration, v->jerk);
    if (v->clipped) {
        fprintf(to, "  %d frames beyond its end stops", v->clipped);
    }
    if (v->limited) {
        fprintf(to, "  %d frames beyond its limits", v->limited);
    }
    fputc('\n', to);
}

static void print_failures(const build *b, const certificate *c, FILE *to)
{
    for (int i = 0; i < c->channel_count; i++) {
        const certificate_channel *h = &c->channel[i];
        if (h->largest > h->tolerance) {
            fprintf(
                to,
                "FAILED: clip %s, channel %s is off by %.3g %s at %.3f s; the tolerance is %.3g\n",
                certificate_clip(b, h->clip), b->scene->channels[h->channel].name, h->largest,
                unit_name(b->scene->channels[h->channel].unit), h->when, h->tolerance);
        }
    }
}

void certificate_print(const build *b, const certificate *c, FILE *to)
{
    fprintf(to,
            "played against authored (at quarter ticks, 200,000 at most)%s\n"
            "  clip         channel          largest       rms                   tolerance "
            "segs  waves\n",
            c->mesh_count > 0 ? ", without the weights of meshes" : "");
    for (int i = 0; i < c->channel_count; i++) {
        const certificate_channel *h = &c->channel[i];
        if ((!is_made(b, h->channel) && !is_still(b, h->channel)) || h->largest > h->tolerance) {
            print_channel(b, h, to);
        }
    }
    if (c->mix_seconds > 0) {
        fprintf(to, "  (mix): all layers and filters, every 20 ms of %.3f s; compared %s%.3f s\n",
                c->mix_seconds,
                c->mix_compared < c->mix_seconds ? "until a trigger fires after " : "for ",
                c->mix_compared);
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
    certificate_print_meshes(b, c, to);
    certificate_print_bodies(b, to);
    certificate_print_skins(b, to);
    fprintf(to, "bytes %zu:", c->file_bytes);
    for (unsigned k = 1; k <= WG_SECTION_KNOWN; k++) {
        if (c->section_bytes[k] > 0) {
            fprintf(to, " %s %zu", section_name(k), c->section_bytes[k]);
        }
    }
    fprintf(to,
            "\nRAM %zu bytes; a layer's tick: at most %d search rounds, %d multiplications, %d "
            "divisions\n",
            c->ram_bytes, c->search_rounds, c->multiplications, c->divisions);
    if (c->picture_ram > 0) {
        fprintf(to, "pictures: %zu bytes of RAM, and a band of pixels\n", c->picture_ram);
    }
    print_failures(b, c, to);
    certificate_print_mesh_failures(b, c, to);
    certificate_print_skin_failures(b, to);
    certificate_print_target(b, c, to);
}
