/* What is opaque of a picture as closed polylines.
 * Source: own; W. Lorensen, H. Cline, Marching Cubes, 1987, in the plane; D. Douglas, T. Peucker,
 * 1973.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_OUTLINE_H
#define BAKE_OUTLINE_H

#include "domain.h"
#include "bitmap.h"

/* The border between alpha 127 and 128, in pixels from the picture's upper left corner, y
 * downwards: outer loops and holes, simplified so that no point of it is farther than `tolerance`
 * from the new one. Its loops have no point in common with each other. specks: how many are left
 * out because they are smaller than (4 tolerance)^2, in whole pixels. error: the end of a sentence
 * about the file. */
int outline_trace(const pixels *p, double tolerance, outline *out, int *specks, bake_error *error);

void outline_free(outline *o);

/* Twice the area inside of loop `i`: positive or negative as it runs. */
double outline_area(const outline *o, int i);

/* Lower and upper corner of the box around all loops. */
void outline_box(const outline *o, double box[4]);

/* A shape of 65535 vertices has no use for more, and looking for crossings takes its time. */
#define OUTLINE_POINTS_MAX 20000

/* The same loops with as few points as the tolerance allows and no crossings; or more than
 * OUTLINE_POINTS_MAX, which may cross. */
void outline_simplify(const outline *from, double tolerance, outline *out);

#endif
