/* Warnings beside the certificate: loops that do not meet, servos asked for more than they may do.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_parts.h"
#include "shapes.h"

#include <math.h>

/* Value and velocity [1/s] at the ends of the clip; a curve rests outside its keys. */
static void clip_ends(const author_clip *a, int curve, double first[4], double last[4])
{
    const bake_curve *c = &a->curve[curve];
    double end = c->segment[c->count - 1].t1, duration = (double)a->ticks / a->rate;
    bake_curve_eval(c, 0, first);
    /* ticks / rate may lie a rounding beyond the curve's end, where velocities are 0 */
    bake_curve_eval(c, fabs(duration - end) < 1e-9 ? end : duration, last);
}

/* A jump of value counts when the tolerance does not hide it; one of velocity when the motion is
 * off by more than the tolerance a frame later. Held curves jump at every key and linear ones bend,
 * so that is what their author wants at the seam too. */
static int warn_seam(const build *b, int clip, int curve, FILE *to)
{
    const scene_clip *s = &b->scene->clips[clip];
    const scene_curve *c = &s->curves[curve];
    const scene_channel *channel = &b->scene->channels[c->channel];
    double first[4], last[4], tolerance = b->tolerance[c->channel];
    clip_ends(&b->clip[clip], curve, first, last);
    double jump = first[0] - last[0], kick = first[1] - last[1];
    int jumps = c->kind != CURVE_HELD && fabs(jump) > tolerance;
    int kicks = c->kind != CURVE_HELD && c->kind != CURVE_LINEAR &&
                fabs(kick) * CERTIFY_FRAME_US * 1e-6 > tolerance;
    if (!jumps && !kicks) {
        return 0;
    }
    const char *unit = unit_name(channel->unit);
    fprintf(to, "%s:%d: warning: clip %s, channel %s: where the loop begins again", b->scene->path,
            c->line, s->name, channel->name);
    if (jumps) {
        fprintf(to, " the value jumps by %.3g %s%s", jump, unit, kicks ? " and" : "");
    }
    if (kicks) {
        fprintf(to, " the velocity jumps by %.3g %s/s", kick, unit);
    }
    fprintf(to, "; %s\n",
            c->kind == CURVE_CAPTURED ? "cut the capture where it repeats (from, to)"
            : c->kind == CURVE_LINEAR ? "let the last key repeat the first at the clip's end"
                                      : "let the last key repeat the first at the clip's end and "
                                        "set periodic: true");
    return 1;
}

static const char *clip_word(const certificate_servo *row)
{
    return row->clip == CERTIFY_MIX ? "the layers " : "clip ";
}

/* The rows of one servo that exceed most. */
static void warn_servo(const build *b, const certificate *c, int servo, FILE *to)
{
    const scene_servo *s = &b->scene->servos[servo];
    const certificate_servo *clipped = NULL, *limited = NULL;
    for (int i = 0; i < c->servo_count; i++) {
        const certificate_servo *row = &c->servo[i];
        if (row->servo == servo && row->clipped > (clipped ? clipped->clipped : 0)) {
            clipped = row;
        }
        if (row->servo == servo && row->limited > (limited ? limited->limited : 0)) {
            limited = row;
        }
    }
    if (!clipped && !limited) {
        return;
    }
    fprintf(to, "%s:%d: warning: servo %s:", b->scene->path, s->line, s->name);
    if (clipped) {
        fprintf(
            to,
            " %d frames of %s%s lie beyond its end stops and will be cut off: widen min and max "
            "or make the motion smaller%s",
            clipped->clipped, clip_word(clipped), certificate_clip(b, clipped->clip),
            limited ? ";" : "");
    }
    if (limited) {
        fprintf(to,
                " %d frames of %s%s ask for more than its velocity or acceleration and will lag: "
                "move keys apart, or raise the limits if the servo can do it",
                limited->limited, clip_word(limited), certificate_clip(b, limited->clip));
    }
    fputc('\n', to);
}

void certificate_warn(const build *b, const certificate *c, FILE *to)
{
    const scene *s = b->scene;
    for (int i = 0; i < s->clip_count; i++) {
        const scene_clip *clip = &s->clips[i];
        int made = 0; /* the modes of a body jump together: one of them says so */
        for (int j = 0; j < clip->curve_count && clip->end == (int)WG_END_LOOP && !made; j++) {
            int own = !b->shapes || clip->curves[j].channel < b->shapes->channel_first;
            made = warn_seam(b, i, j, to) && !own;
        }
    }
    for (int i = 0; i < s->servo_count; i++) {
        warn_servo(b, c, i, to);
    }
}
