/* Paints as bytes: pictures, and the colours of fields.
 * Source: SPEC 4.23; B. Ottosson, A perceptual color space for image processing, 2020 (Oklab).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "paint_pack.h"

#include "mesh_picture.h"
#include "wiggly_format.h"

#include <math.h>

/* ---- the colours of a field ------------------------------------------------------------------ */

/* Oklab's lightness, green to red, blue to yellow: dark blue, teal, yellow. The ramp is the
 * parabola through them, so that lightness grows evenly and all steps are alike within 15 %:
 *   0: 23 22 92   64: 10 86 125   128: 64 143 143   192: 149 196 138   255: 254 240 92 */
static const double ramp[3][3] = {{0.26, 0.01, -0.12}, {0.60, -0.075, -0.02}, {0.94, -0.04, 0.16}};

static double to_srgb(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static void ramp_colour(double t, uint8_t colour[3])
{
    static const double cone[3][3] = {{1, 0.3963377774, 0.2158037573},
                                      {1, -0.1055613458, -0.0638541728},
                                      {1, -0.0894841775, -1.2914855480}};
    static const double primary[3][3] = {{4.0767416621, -3.3077115913, 0.2309699292},
                                         {-1.2684380046, 2.6097574011, -0.3413193965},
                                         {-0.0041960863, -0.7034186147, 1.7076147010}};
    const double part[3] = {(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)};
    double lms[3];
    for (int i = 0; i < 3; i++) {
        double x = 0;
        for (int k = 0; k < 3; k++)
            x += cone[i][k] * (part[0] * ramp[0][k] + part[1] * ramp[1][k] + part[2] * ramp[2][k]);
        lms[i] = x * x * x;
    }
    for (int i = 0; i < 3; i++) {
        double linear = 0;
        for (int k = 0; k < 3; k++)
            linear += primary[i][k] * lms[k];
        colour[i] = (uint8_t)lround(255 * fmin(fmax(to_srgb(linear), 0), 1));
    }
}

/* ---- records --------------------------------------------------------------------------------- */

static uint32_t fixed(double x, int bits)
{
    return (uint32_t)(int64_t)llround(ldexp(x, bits));
}

/* All fields have one palette: that of an earlier record, or a new one. */
static uint32_t field_palette(packed *out)
{
    bytes *data = &out->at[WG_SECTION_DATA];
    for (int i = 0; i < out->count[WG_SECTION_PAINTS]; i++) {
        const uint8_t *record = out->at[WG_SECTION_PAINTS].at + (size_t)i * WG_PAINT_BYTES;
        const uint8_t *p = record + WG_PAINT_PALETTE;
        if (record[WG_PAINT_KIND] == WG_PAINT_FIELD)
            return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
                   (uint32_t)p[3] << 24;
    }
    uint32_t offset = (uint32_t)data->count;
    for (int i = 0; i < 256; i++) {
        uint8_t colour[3];
        ramp_colour(i / 255.0, colour);
        put_copy(data, colour, 3);
    }
    return offset;
}

static void pack_field(packed *out)
{
    uint32_t palette = field_palette(out);
    bytes *o = &out->at[WG_SECTION_PAINTS];
    put32(o, 0); /* width, height */
    put32(o, palette);
    for (int i = 0; i < 4; i++)
        put32(o, 0);
}

/* The shape's places are raw, from its origin. */
static void pack_picture(const shape_form *form, const mesh_picture *p, packed *out)
{
    bytes *o = &out->at[WG_SECTION_PAINTS], *data = &out->at[WG_SECTION_DATA];
    put16(o, (uint32_t)p->width);
    put16(o, (uint32_t)p->height);
    put32(o, (uint32_t)data->count);
    put_copy(data, p->palette, sizeof p->palette);
    put32(o, (uint32_t)data->count);
    put_copy(data, p->texel, (size_t)p->width * (size_t)p->height);
    put32(o, fixed(ldexp(p->step, -form->frac), 26));
    put32(o, fixed(p->corner[0] + p->step * form->origin[0], 16));
    put32(o, fixed(p->corner[1] - p->step * form->origin[1], 16));
}

void paint_pack(const build *b, const shape_mesh *m, packed *out)
{
    int rig = scene_rig_of_mesh(b->scene, m->index);
    int field = rig >= 0 && b->scene->rigs[rig].paint;
    if (!field && !m->mesh.picture)
        return;
    bytes *o = &out->at[WG_SECTION_PAINTS];
    put16(o, (uint32_t)out->count[WG_SECTION_PARTS] - 1);
    put8(o, field ? WG_PAINT_FIELD : WG_PAINT_PICTURE);
    put8(o, 0);
    if (field)
        pack_field(out);
    else
        pack_picture(&m->form, m->mesh.picture, out);
    out->count[WG_SECTION_PAINTS]++;
}
