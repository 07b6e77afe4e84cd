/* The certificate's servos: what a motion asks of them, frame by frame.
 * Source: own (DESIGN 1, promise 4).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_parts.h"
#include "record.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *servo_unit(int protocol)
{
    return protocol == (int)WG_PROTOCOL_DYNAMIXEL2 ? "steps" : "us";
}

double servo_scale(int protocol)
{
    return protocol == (int)WG_PROTOCOL_DYNAMIXEL2 ? 1 : 0.25;
}

int certify_repeats(const wg_file *file, int clip)
{
    return get8(clip_record(file, clip) + WG_CLIP_END) != (int)WG_END_HOLD;
}

uint64_t certify_period(const wg_file *file, int clip)
{
    const uint8_t *r = clip_record(file, clip);
    uint64_t once = get32(r + WG_CLIP_US);
    return get8(r + WG_CLIP_END) == (int)WG_END_PINGPONG ? 2 * once : once;
}

/* The servo's position in its own units, not rounded and not limited. */
static double servo_at(const wg_file *file, int servo, int32_t raw)
{
    const uint8_t *r = record(file, WG_SECTION_SERVOS, servo, WG_SERVO_BYTES);
    double gain = ldexp((int16_t)get16(r + WG_SERVO_GAIN), -get8(r + WG_SERVO_GAIN_SHIFT));
    return ((int32_t)get32(r + WG_SERVO_OFFSET) + raw * gain) / 256;
}

/* Peaks of the differences of four successive frames p[0..3]. */
static void peaks(const double p[4], int known, certificate_servo *c)
{
    const double dt = CERTIFY_FRAME_US * 1e-6;
    if (known > 1) {
        c->velocity = fmax(c->velocity, fabs(p[3] - p[2]) / dt);
    }
    if (known > 2) {
        c->acceleration = fmax(c->acceleration, fabs(p[3] - 2 * p[2] + p[1]) / (dt * dt));
    }
    if (known > 3) {
        c->jerk = fmax(c->jerk, fabs(p[3] - 3 * p[2] + 3 * p[1] - p[0]) / (dt * dt * dt));
    }
}

/* Limits that the last frames exceed: the limiter would alter the newest. */
static int is_limited(const scene_servo *s, const double p[4], int known)
{
    const double dt = CERTIFY_FRAME_US * 1e-6;
    return (known > 1 && s->velocity > 0 && fabs(p[3] - p[2]) > s->velocity * dt * 1.001) ||
           (known > 2 && s->acceleration > 0 &&
            fabs(p[3] - 2 * p[2] + p[1]) > s->acceleration * dt * dt * 1.001);
}

void servo_begin(certificate_servo *row)
{
    row->low = HUGE_VAL;
    row->high = -HUGE_VAL;
}

void servo_frame(const build *b, const wg_file *file, const int32_t *values, servo_watch *watch,
                 certificate_servo *row)
{
    const scene_servo *s = &b->scene->servos[row->servo];
    double *p = watch->position;
    memmove(p, p + 1, 3 * sizeof *p);
    p[3] = servo_at(file, row->servo, values[s->channel]);
    watch->known += watch->known < 4;
    row->low = fmin(row->low, p[3]);
    row->high = fmax(row->high, p[3]);
    row->clipped += p[3] < s->min - 0.5 || p[3] > s->max + 0.5;
    row->limited += is_limited(s, p, watch->known);
    peaks(p, watch->known, row);
}

void servo_end(const build *b, certificate_servo *row)
{
    double scale = servo_scale(b->scene->servos[row->servo].protocol);
    row->error *= scale;
    row->low *= scale;
    row->high *= scale;
    row->velocity *= scale;
    row->acceleration *= scale;
    row->jerk *= scale;
}

void certify_servo(const build *b, const wg_file *file, certificate_servo *row)
{
    uint64_t once = get32(clip_record(file, row->clip) + WG_CLIP_US);
    uint64_t period = certify_period(file, row->clip);
    int repeats = certify_repeats(file, row->clip);
    uint64_t frames = period / CERTIFY_FRAME_US + (repeats ? CERTIFY_SEAM_FRAMES : 0);
    int32_t *values = bake_alloc((size_t)b->scene->channel_count, sizeof *values);
    servo_watch watch = {{0}, 0};
    servo_begin(row);
    for (uint64_t f = 0; f <= frames; f++) {
        uint64_t t = repeats ? f * CERTIFY_FRAME_US % period : f * CERTIFY_FRAME_US;
        t = repeats && t > once ? 2 * once - t : t; /* the way back of a ping-pong clip */
        wg_clip_sample(file, (uint8_t)row->clip, (uint32_t)t, values, NULL);
        wg_fields_set(file, values);
        servo_frame(b, file, values, &watch, row);
    }
    servo_end(b, row);
    free(values);
}
