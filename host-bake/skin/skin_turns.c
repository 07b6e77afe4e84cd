/* How exactly captured bones turn: as the mesh's tolerance asks, and not 2^-13 of each channel, which
 * takes three times the bytes.
 * Source: own.
 *
 * A part of a quaternion that is off by d takes a point at the distance r off by 2 r d, four parts by 4 r d at
 * most, and the n bones of a chain by the sum of that: 4 TURNS tolerances at most. They are never all off
 * by most at once and in one direction: the bones of examples/homer stay within 0.92 tolerances.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "skin_parts.h"

#include <math.h>
#include <stdlib.h>

/* Of the mesh's tolerance: what hangs on a bone may be off by the turns of all bones above it. */
#define TURNS    0.75
/* Of the same, for each way of a captured bone that travels. */
#define TRAVEL   0.1
/* A part of a quaternion: 6 degrees. */
#define COARSEST 0.05

/* Channels of a joint that captures fill. */
static int captured(const scene_joint *j)
{
    return !j->captured ? 0 : j->kind == (int)WG_JOINT_QUATERNION ? 4 : 1;
}

static int turns(const scene_bone *b)
{
    for (int k = 0; k < b->joint_count; k++) {
        if (captured(&b->joints[k]) == 4) {
            return 1;
        }
    }
    return 0;
}

/* What a bone carries: the vertex that is farthest from where it starts, and the most captured bones
 * between the root and a vertex. */
typedef struct {
    double far;
    int chain, captured;
} carried;

static void carry(const scene_rig *rig, const double at[3], int bone, carried *out)
{
    int chain = 0;
    for (int i = bone; i >= 0; i = rig->bones[i].parent) {
        chain += out[i].captured;
    }
    for (int i = bone; i >= 0; i = rig->bones[i].parent) {
        const double *o = rig->bones[i].from;
        double way = hypot(hypot(at[0] - o[0], at[1] - o[1]), at[2] - o[2]);
        out[i].far = fmax(out[i].far, way);
        out[i].chain = chain > out[i].chain ? chain : out[i].chain;
    }
}

static void aim(scene *s, const scene_bone *b, const carried *c, double tolerance)
{
    for (int k = 0; k < b->joint_count && c->chain > 0 && c->far > 0; k++) {
        const scene_joint *j = &b->joints[k];
        int count = captured(j);
        for (int i = 0; i < count; i++) {
            s->channels[j->channel + i].tolerance =
                count == 1 ? TRAVEL * tolerance
                           : fmin(TURNS * tolerance / (c->far * c->chain), COARSEST);
        }
    }
}

void skin_turns(const skin_work *w)
{
    const skin *k = w->out;
    carried *c = bake_alloc((size_t)k->bone_count, sizeof *c);
    for (int i = 0; i < k->bone_count; i++) {
        c[i].captured = turns(&w->rig->bones[i]);
    }
    for (int i = 0; i < k->vertex_count; i++) {
        for (int j = 0; j < k->stored[i].count; j++) {
            carry(w->rig, w->m->mesh.rest + 3 * i, k->stored[i].bone[j], c);
        }
    }
    for (int i = 0; i < k->bone_count; i++) {
        aim(w->s, &w->rig->bones[i], &c[i], w->m->tolerance);
    }
    free(c);
}
