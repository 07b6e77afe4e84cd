/* wiggly view without its window: what time, keys and mouse do to what is shown. No SDL here, so
 * that tests can press the keys.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_VIEWER_H
#define BAKE_VIEWER_H

#include "painter_options.h"

/* Keys are characters, these besides. */
#define VIEWER_LEFT   256
#define VIEWER_RIGHT  257
#define VIEWER_ESCAPE 27

#define VIEWER_STEP_US    20000u /* left and right: one frame of the firmware */
#define VIEWER_FADE_US    250000u
#define VIEWER_SPEED_MOST 4  /* 1/16 to 16 times */
#define VIEWER_BAR        16 /* pixels: the timeline below the picture */

typedef struct {
    const wg_file *file;
    const char *name; /* of the file, for the title */
    wg_layer layers[WG_LAYERS_MAX];
    wg_player player;
    double clock_us; /* the player's: stands still while paused, and runs at `speed` */
    int32_t values[WG_CHANNELS_MAX];
    int32_t least[WG_CHANNELS_MAX], most[WG_CHANNELS_MAX]; /* over all clips */
    painter_look look;
    int panel;
    int speed; /* a power of two */
    int paused, quit, help;
    double yaw, pitch; /* degrees, added to the view's */
    double zoom;       /* divides the view's size */
} viewer;

/* Everything as the clip says, from its beginning; --clip NAME alone. */
int viewer_init(viewer *v, const wg_file *file, const char *clip, bake_error *error);

void viewer_key(viewer *v, int key);
void viewer_drag(viewer *v, int dx, int dy); /* pixels, with the button held over the picture */
void viewer_wheel(viewer *v, int clicks);    /* positive: nearer */
/* Shows the place at `fraction` of the timeline, paused. */
void viewer_scrub(viewer *v, double fraction);
/* Seeks every layer, each by what its clip does after its end, paused. */
void viewer_seek(viewer *v, uint32_t time_us);

/* Lets `real_us` pass, then samples v->values, the orbit added. */
void viewer_advance(viewer *v, double real_us);

/* Where the timeline is: of the layer whose clip lasts longest. */
uint32_t viewer_time(const viewer *v);
uint32_t viewer_length(const viewer *v);

#define VIEWER_TITLE_BYTES 256
void viewer_title(const viewer *v, char title[VIEWER_TITLE_BYTES]);

extern const char VIEWER_HELP[];

/* ---- the window's contents ------------------------------------------------------------------- */

/* Paints a window: the picture, scaled by a whole number when a panel is shown, or the channels as
 * bars when the clip has no parts; the timeline below. `p` is opened anew where that changes. */
int viewer_paint(const viewer *v, painter *p, image *window, bake_error *error);

/* Whether (x, y) is on the timeline; where of it. */
int viewer_on_bar(const image *window, int y);
double viewer_bar_fraction(const image *window, int x);

#endif
