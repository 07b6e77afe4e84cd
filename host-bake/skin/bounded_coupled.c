/* Weights of all handles that sum to one.
 * Source: Jacobson 2013, (4.5).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bounded_parts.h"

int bounded_coupled(bounded_system *s, double *w, bounded_report *r, bake_error *error)
{
    (void)r;
    return bounded_approach(s, 1, w, error);
}
