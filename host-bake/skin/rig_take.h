/* Captures on rigs: every bone with a `node` turns as that node of the source does, relative to its
 * bind pose.
 * Source: own.
 *
 * With G(t) the node's axes in the world, B those of its bind pose and A the shortest rotation from
 * the bone's direction at rest to the node's at bind, the bone is turned by R = G(t) B^-1 A. Its
 * channels are the quaternion R_p^-1 R, p the nearest ancestor that a capture turns. A node points
 * to the node of the bone that begins where its bone ends, otherwise to its first child; where
 * neither or the bone has no length, A is that of p. Bones keep their lengths: translations of
 * nodes that are no roots are not taken. A source that is the rig's or its mesh's own file has the
 * mesh's axes and scale.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_RIG_TAKE_H
#define BAKE_RIG_TAKE_H

#include "scene.h"

/* Makes the takes of all clips curves of the bones' captured channels; each source is read once. Of
 * bones that a rig's own file named, those that the source does not have stay as they are;
 * otherwise a node that is not there is an error. */
int rig_takes(scene *s, bake_error *error);

#endif
