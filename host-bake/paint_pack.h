/* Paints as bytes.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_PAINT_PACK_H
#define BAKE_PAINT_PACK_H

#include "shape_pack.h"
#include "shapes.h"

/* The paint of the part that was packed last, which is one of mesh `m` (SPEC 4.23): the field of
 * its rig where the scene says so, its picture otherwise, or none. */
void paint_pack(const build *b, const shape_mesh *m, packed *out);

#endif
