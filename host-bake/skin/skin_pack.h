/* Bones, skins and fields as bytes.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_SKIN_PACK_H
#define BAKE_SKIN_PACK_H

#include "shape_pack.h"

/* Appends sections 18 to 22 (SPEC 4.18-4.22) and their data: after shapes_pack. */
int skins_pack(const build *b, packed *out, bake_error *error);

#endif
