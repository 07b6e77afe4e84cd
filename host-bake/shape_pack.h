/* Shapes, parts and views as bytes.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SHAPE_PACK_H
#define BAKE_SHAPE_PACK_H

#include "build.h"

/* Sections of a file under way: bytes and records of each kind. */
typedef struct {
    bytes at[WG_SECTION_KNOWN + 1];
    int count[WG_SECTION_KNOWN + 1];
} packed;

/* Appends sections 13 to 17 and 23 (SPEC 4.13-4.17, 4.23) and their data. */
int shapes_pack(const build *b, packed *out, bake_error *error);

#endif
