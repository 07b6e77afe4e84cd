/* Servos of a scene: from the units people write to positions of the protocol.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <string.h>

static const char example[] =
    "- {channel: jaw, protocol: maestro, id: 3, centre: 1500 us, per_unit: "
    "10 us, min: 1000 us, max: 2000 us}";

/* Positions of a protocol: the word for one, how many make it, and what its wire can say. A pulse
 * servo takes 64 .. 4080 us (Maestro's own limits); a Dynamixel in joint mode one turn. */
typedef struct {
    const char *unit;
    double per_unit; /* positions in one `unit` */
    double least, most, centre;
    int ids;
} protocol;

static const protocol protocols[WG_PROTOCOL_COUNT] = {
    [WG_PROTOCOL_NONE] = {"us", 4, 0, 32767, 6000, 255},
    [WG_PROTOCOL_MAESTRO] = {"us", 4, 256, 16320, 6000, 23},
    [WG_PROTOCOL_DYNAMIXEL2] = {"steps", 1, 0, 4095, 2048, 252},
    [WG_PROTOCOL_PCA9685] = {"us", 4, 256, 16320, 6000, 63}, /* 16 chip + output */
};

typedef struct {
    loader *l;
    const yaml_servo *from;
    scene_servo *to;
    const protocol *bus;
    double per_degree; /* positions, 0 = unknown */
} servo_reader;

/* Reads a length in positions; `order` 0 = position, 1 = velocity, 2 = acceleration. */
static int read_length(const servo_reader *r, const char *field, const char *text, int order,
                       double *out)
{
    static const char *const per[3] = {"", "/s", "/s2"};
    char suffix[LOADER_SUFFIX_BYTES];
    double value;
    if (text == NULL)
        return 0;
    if (loader_quantity(r->l, field, text, &value, suffix))
        return -1;
    size_t unit = strlen(r->bus->unit);
    int own = suffix[0] == '\0' ||
              (strncmp(suffix, r->bus->unit, unit) == 0 && strcmp(suffix + unit, per[order]) == 0);
    int degrees = strncmp(suffix, "deg", 3) == 0 && strcmp(suffix + 3, per[order]) == 0;
    if (!own && !degrees)
        return loader_fail(r->l, field, "'%s' has the unit '%s'; expected '%s%s' or 'deg%s'", field,
                           suffix, r->bus->unit, per[order], per[order]);
    if (degrees && r->per_degree <= 0)
        return loader_fail(r->l, field,
                           "degrees need a channel in deg with 'per_unit', or 'range: 180 deg'");
    *out = value * (own ? r->bus->per_unit : r->per_degree);
    return 0;
}

/* min and max: what the servo may be told, inside what its protocol can say. */
static int read_limits(servo_reader *r)
{
    const char *unit = r->bus->unit;
    double scale = r->bus->per_unit;
    if (loader_need(r->l, "min", r->from->min, example) ||
        loader_need(r->l, "max", r->from->max, example) ||
        read_length(r, "min", r->from->min, 0, &r->to->min) ||
        read_length(r, "max", r->from->max, 0, &r->to->max))
        return -1;
    if (r->to->min < r->bus->least || r->to->max > r->bus->most)
        return loader_fail(r->l, r->to->min < r->bus->least ? "min" : "max",
                           "%g .. %g %s is outside what the protocol can say, %g .. %g %s",
                           r->to->min / scale, r->to->max / scale, unit, r->bus->least / scale,
                           r->bus->most / scale, unit);
    if (r->to->min >= r->to->max)
        return loader_fail(r->l, "max",
                           "'max' must be above 'min'; for a servo that turns the "
                           "other way write 'direction: -1'");
    return 0;
}

/* How far the servo goes for one unit of the channel, and for a degree. */
static int read_gain(servo_reader *r)
{
    static const scene_measure turn = {"an angle such as '180 deg'", {{"deg", 1}}, 1, 3600};
    int unit = r->l->out->channels[r->to->channel].unit;
    double range = 0;
    if (r->from->range != NULL && r->from->per_unit != NULL)
        return loader_fail(r->l, "range", "'range' and 'per_unit' say the same; keep one");
    if (loader_number(r->l, "range", r->from->range, &turn, &range) || read_limits(r))
        return -1;
    if (range > 0 && r->to->protocol == WG_PROTOCOL_DYNAMIXEL2)
        return loader_fail(r->l, "range", "a Dynamixel's step is 360/4096 deg; remove 'range'");
    if (range > 0)
        r->per_degree = (r->to->max - r->to->min) / range;
    if (r->from->per_unit != NULL) {
        if (read_length(r, "per_unit", r->from->per_unit, 0, &r->to->gain))
            return -1;
        if (unit == WG_UNIT_DEGREE && r->per_degree <= 0)
            r->per_degree = r->to->gain;
    } else if (unit == WG_UNIT_MICROSECOND && strcmp(r->bus->unit, "us") == 0) {
        r->to->gain = r->bus->per_unit;
    } else if (unit == WG_UNIT_DEGREE) {
        r->to->gain = r->per_degree;
    }
    if (r->to->gain <= 0)
        return loader_fail(r->l, "per_unit",
                           "'per_unit' must be above 0: how far the servo goes for 1 unit of the "
                           "channel; write for example:  per_unit: 10 %s",
                           r->bus->unit);
    return 0;
}

static int read_motion(servo_reader *r)
{
    static const scene_word directions[] = {{"1", 1}, {"+1", 1}, {"-1", -1}, {NULL, 0}};
    int direction = 1;
    double trim = 0;
    r->to->centre = r->bus->centre;
    if (loader_word(r->l, "direction", r->from->direction, directions, &direction) ||
        read_length(r, "centre", r->from->centre, 0, &r->to->centre) ||
        read_length(r, "trim", r->from->trim, 0, &trim) ||
        read_length(r, "velocity", r->from->velocity, 1, &r->to->velocity) ||
        read_length(r, "acceleration", r->from->acceleration, 2, &r->to->acceleration))
        return -1;
    if (fabs(trim) > r->to->max - r->to->min)
        return loader_fail(r->l, "trim", "'trim' is %g %s, more than the way from 'min' to 'max'",
                           trim / r->bus->per_unit, r->bus->unit);
    r->to->centre += trim;
    r->to->gain *= direction;
    /* 16 bits of positions a second, and of 16 positions a second squared. */
    if (r->to->velocity < 0 || r->to->velocity > 65535)
        return loader_fail(r->l, "velocity", "'velocity' must be from 0 (unlimited) to %g %s/s",
                           65535 / r->bus->per_unit, r->bus->unit);
    if (r->to->acceleration < 0 || r->to->acceleration > 16 * 65535.0)
        return loader_fail(r->l, "acceleration",
                           "'acceleration' must be from 0 (unlimited) to %g %s/s2",
                           16 * 65535 / r->bus->per_unit, r->bus->unit);
    return 0;
}

/* A servo that would leave its limits before anything moves is wired or written wrongly. */
static int check_rest(const servo_reader *r)
{
    const scene_channel *channel = &r->l->out->channels[r->to->channel];
    double scale = r->bus->per_unit, at = r->to->centre + r->to->gain * channel->rest;
    if (fabs(r->to->gain) > 32767 || fabs(r->to->centre) > 1e6)
        return loader_fail(r->l, "per_unit", "the servo would move %g %s for one unit of '%s'",
                           r->to->gain / scale, r->bus->unit, channel->name);
    if (at < r->to->min || at > r->to->max)
        return loader_fail(r->l, NULL,
                           "at rest (%g) the servo would stand at %g %s, outside %g .. %g; check "
                           "'centre', 'per_unit' and the channel's 'rest'",
                           channel->rest, at / scale, r->bus->unit, r->to->min / scale,
                           r->to->max / scale);
    return 0;
}

/* A Maestro takes the bytes of Dynamixel packets for commands. */
static int check_bus(const loader *l, int index)
{
    const scene_servo *servo = &l->out->servos[index];
    int other = servo->protocol == WG_PROTOCOL_MAESTRO      ? WG_PROTOCOL_DYNAMIXEL2
                : servo->protocol == WG_PROTOCOL_DYNAMIXEL2 ? WG_PROTOCOL_MAESTRO
                                                            : WG_PROTOCOL_COUNT;
    for (int i = 0; i < index; i++)
        if (l->out->servos[i].protocol == other)
            return loader_fail(l, "protocol",
                               "a maestro and a dynamixel2 (line %d has the other one) cannot be "
                               "in one scene: they would share one serial line, and a Maestro "
                               "takes a Dynamixel's bytes for commands",
                               l->out->servos[i].line);
    return 0;
}

static int check_id(const loader *l, int index)
{
    const scene_servo *servo = &l->out->servos[index];
    for (int i = 0; i < index; i++)
        if (l->out->servos[i].protocol == servo->protocol && l->out->servos[i].id == servo->id)
            return loader_fail(l, "id",
                               "the servo in line %d has the id %d already; every servo "
                               "of a protocol needs its own",
                               l->out->servos[i].line, servo->id);
    return 0;
}

/* Without a name a servo takes its channel's. */
static int read_name(const loader *l, int index)
{
    const yaml_scene *y = l->yaml;
    scene_servo *to = &l->out->servos[index];
    if (y->servos[index].name != NULL)
        return loader_name(l, SCENE_NAMES(y->servos, y->servos_count), index, example, &to->name);
    to->name = bake_copy(l->out->channels[to->channel].name);
    return 0;
}

int scene_read_servo(loader *l, int index)
{
    static const scene_word words[] = {{"maestro", WG_PROTOCOL_MAESTRO},
                                       {"dynamixel2", WG_PROTOCOL_DYNAMIXEL2},
                                       {"pca9685", WG_PROTOCOL_PCA9685},
                                       {"none", WG_PROTOCOL_NONE},
                                       {NULL, 0}};
    const yaml_servo *from = &l->yaml->servos[index];
    scene_servo *to = &l->out->servos[index];
    to->line = scene_tree_line(l->tree, l->node, NULL);
    if (loader_need(l, "channel", from->channel, example) ||
        loader_reference(l, "channel", from->channel,
                         SCENE_NAMES(l->out->channels, l->out->channel_count), &to->channel) ||
        read_name(l, index) || loader_need(l, "protocol", from->protocol, example) ||
        loader_word(l, "protocol", from->protocol, words, &to->protocol) ||
        loader_need(l, "id", from->id, example))
        return -1;
    const protocol *bus = &protocols[to->protocol];
    servo_reader r = {.l = l, .from = from, .to = to, .bus = bus};
    if (to->protocol == WG_PROTOCOL_DYNAMIXEL2)
        r.per_degree = 4096.0 / 360;
    const int ids[2] = {0, bus->ids};
    return check_bus(l, index) || loader_integer(l, "id", from->id, ids, &to->id) ||
                   check_id(l, index) || read_gain(&r) || read_motion(&r) || check_rest(&r)
               ? -1
               : 0;
}
