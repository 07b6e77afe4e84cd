/* Which segments of a curve become waves and which become cubics.
 * Source: own; a shortest path over the segments (Viterbi): a segment costs its bytes, a change of
 * kind or scale costs the head of a new run.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "fit.h"

#include <stdlib.h>
#include <string.h>

#define STATES      (FIT_CUBIC + 1)
#define UNREACHABLE (1L << 40)

#define WAVE_BYTES  10                      /* end tick and four coefficients */
#define CUBIC_BYTES 6                       /* end tick, value and velocity */
#define CUBIC_HEAD  ((int)WG_RUN_BYTES + 4) /* and the first knot */

static long segment_cost(int pieces, unsigned shifts, int state)
{
    if (state == FIT_CUBIC) {
        return pieces > 0 ? (long)pieces * CUBIC_BYTES : UNREACHABLE;
    }
    return shifts >> state & 1u ? WAVE_BYTES : UNREACHABLE;
}

static int cheapest(const long *cost)
{
    int best = 0;
    for (int s = 1; s < STATES; s++) {
        best = cost[s] < cost[best] ? s : best;
    }
    return best;
}

long fit_path(const int *pieces, const unsigned *shifts, int count, int wave_head, int *way)
{
    unsigned char(*from)[STATES] = bake_alloc((size_t)count + 1, sizeof *from);
    long cost[STATES] = {0}, next[STATES];
    for (int k = 0; k < count; k++) {
        int least = cheapest(cost);
        for (int s = 0; s < STATES; s++) {
            long change = cost[least] + (s == FIT_CUBIC ? CUBIC_HEAD : wave_head);
            int stay = k > 0 && cost[s] <= change;
            from[k][s] = (unsigned char)(stay ? s : least);
            next[s] = (stay ? cost[s] : change) + segment_cost(pieces[k], shifts[k], s);
            next[s] = next[s] < UNREACHABLE ? next[s] : UNREACHABLE;
        }
        memcpy(cost, next, sizeof cost);
    }
    int s = cheapest(cost);
    long total = cost[s];
    for (int k = count - 1; k >= 0; k--) {
        way[k] = s;
        s = from[k][s];
    }
    free(from);
    return total < UNREACHABLE ? total : -1;
}
