/* A clip's shapes as pictures on the host, drawn by the code that draws them on a device
 * (firmware/device/raster): as full colours, or exactly as a panel shows them.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_PAINTER_H
#define BAKE_PAINTER_H

#include "image.h"
/* The device's: this directory has a picture.h and a pixels.h of its own. */
#include "raster/picture_skin.h"
#include "raster/pixels.h"

/* What becomes of a pixel on its way to the glass. */
typedef enum {
    PANEL_RGB,   /* 8 bits a colour: no panel */
    PANEL_GREY4, /* 4 bits: a level l is shown as 17 l */
    PANEL_PAGES, /* 1 bit, dithered, bytes upright */
    PANEL_LINES, /* 1 bit, dithered, bytes lying */
    PANEL_565    /* 5 + 6 + 5 bits, the upper ones repeated below */
} panel_pixels;

typedef struct {
    const char *name;
    panel_pixels pixels;
    wg_size size; /* 0 x 0: any */
} panel;

/* Panel 0 is "plain", the others are those of firmware/panel. */
int panel_count(void);
const panel *panel_at(int index);
/* -1 and a message that lists them. */
int panel_find(const char *name, bake_error *error);

/* What the device's coordinates reach: a larger picture would lose its rim. */
#define PAINTER_SIZE_MAX ((int)WG_SIDE_MAX)

/* How a picture differs from what the view says. Start from PAINTER_LOOK. */
typedef struct {
    int view, shading, bases; /* shading -1: the view's */
} painter_look;
#define PAINTER_LOOK ((painter_look){0, -1, (int)WG_BASES_MAX})

typedef struct {
    wg_picture picture;
    wg_picture_memory memory;
    wg_picture_skins *skins;
    painter_look look;
    const panel *panel;
    uint32_t *pixels;
    uint8_t *packed;
    image image; /* the last one painted */
} painter;

/* Whether there is anything to paint: triangles and a view on them. */
int painter_can(const wg_file *file);

/* For an open clip that painter_can; stage_open is called here. `size` counts for panels that
 * come in any. */
int painter_open(painter *p, const wg_file *file, const panel *on, wg_size size, bake_error *error);
void painter_close(painter *p);

/* Paints p->image. */
void painter_paint(painter *p, const int32_t *values, painter_look look);

/* "wire", "flat", "smooth" to WG_SHADING_*, or -1 and a message; and back. */
int shading_find(const char *name, bake_error *error);
const char *shading_name(int shading);

/* What a clip has: its views, and the most bases of any shape. */
int view_count(const wg_file *file);
int bases_most(const wg_file *file);

#endif
