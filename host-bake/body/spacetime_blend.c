/* Blending: a wiggly spline through all keys for the model of each key, faded from one to the next.
 * Source: Schulz 2013, 2.8.1; errata S6 (the intervals), S7 (the fades).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spacetime_parts.h"

/* Erratum S6: model j fades out, and j + 1 in, over the middle half of the gap between their keys.
 * Near key j all others are 0, so that the sum passes through its pose. A loop's last term is its
 * first one again, a period later. */
static void set_fades(motion *m, const space_key *keys)
{
    for (int j = 0; j < m->term_count - 1; j++) {
        double gap = keys[j + 1].time - keys[j].time;
        const double fade[2] = {keys[j].time + 0.25 * gap, keys[j].time + 0.75 * gap};
        for (int i = 0; i < 2; i++)
            m->term[j].out[i] = m->term[j + 1].in[i] = fade[i];
    }
}

int motion_blend(const linear_model *const *models, const motion_input *in, motion *out,
                 bake_error *error)
{
    motion_warnings warnings = {0};
    int count = in->key_count;
    *out = (motion){0};
    if (motion_check(in, models[0]->d, 1, error))
        return -1;
    motion_begin(in, models[0]->d, count, out);
    set_fades(out, in->keys);
    for (int j = 0; j < count; j++) {
        bake_error own;
        out->term[j].model = models[out->periodic && j == count - 1 ? 0 : j];
        if (motion_solve_term(in, NULL, &out->term[j], &warnings, &own)) {
            motion_free(out);
            return bake_fail(error, "model of the key at %.6g s, %.900s", in->keys[j].time,
                             own.text);
        }
    }
    motion_warned(&warnings, error);
    return 0;
}
