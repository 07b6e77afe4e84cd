/* From the scene to exact curves: tick rates, solved splines, captures.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_AUTHOR_H
#define BAKE_AUTHOR_H

#include "scene.h"

/* One clip of the scene as exact curves on its tick grid. */
typedef struct {
    int rate;  /* ticks a second */
    int ticks; /* duration */
    int count;
    bake_curve *curve;          /* count, in the order of scene_clip.curves */
    bake_spline_report *report; /* of the solved ones, zero for the others */
} author_clip;

/* Solves and loads everything in clip `index`. The tick rate is the scene's, or the highest up to
 * 1000 (10000 if need be) a second on which every key and event lies exactly; key times are rounded
 * to it. A capture longer than the clip is cut at its end. */
int author_clip_make(const scene *s, int index, author_clip *out, bake_error *error);
void author_clip_free(author_clip *c);

#endif
