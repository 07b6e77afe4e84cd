/* Frames of a clip with skins: picture.h with vertices that follow bones. Apart from it, so that a
 * firmware without skins does not carry them.
 *
 *   static wg_bone bones[CLIP_BONES + 1];
 *   static wg_picture_skins skins;
 *
 *   skins.bones = bones;
 *   wg_picture_init(&picture, &file, size, &memory); // after wg_open_shapes
 *   wg_picture_paint(&picture, &skins);              // after wg_open_skins
 *   for (;;) {
 *       wg_player_sample(&player, values);
 *       wg_fields_set(&file, values);
 *       wg_picture_set_skinned(&picture, values);    // the rest as picture.h has it
 *   }
 *
 * A clip that has paints and no skins: wg_picture_paint(&picture, NULL), and wg_picture_set.
 *
 * Source: own. SPDX-License-Identifier: MIT */
#ifndef WIGGLY_PICTURE_SKIN_H
#define WIGGLY_PICTURE_SKIN_H

#include "picture.h"

#ifdef __cplusplus
extern "C" {
#endif

/* wg_picture_set and wg_picture_step for shapes with and without skins. Vertices of parts that are a
 * FIELD get its brightness; for that, the picture's memory has shades. Other parts of such a shape are
 * never smooth. A step may set all bones of a skin before its vertices. */
void wg_picture_set_skinned(wg_picture *picture, const int32_t *values);
bool wg_picture_step_skinned(wg_picture *picture);

#ifdef __cplusplus
}
#endif
#endif
