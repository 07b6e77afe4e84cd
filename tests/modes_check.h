/* What must hold of every result of the mode solver.
 * SPDX-License-Identifier: MIT */
#ifndef MODES_CHECK_H
#define MODES_CHECK_H

#include "check.h"
#include "modes.h"

#include <math.h>

/* Order, counts, signs, |Phi^T M Phi - 1|. */
static inline void check_modes(const modes *m, const double *M)
{
    double worst = 0;
    for (int a = 0; a < m->count; a++) {
        const double *pa = m->phi + (size_t)a * (size_t)m->n;
        double most = 0, least = 0;
        CHECK(a == 0 || m->lambda[a] >= m->lambda[a - 1]);
        CHECK((m->lambda[a] < 0) == (a < m->negative));
        CHECK((m->lambda[a] == 0) == (a >= m->negative && a < m->negative + m->rigid));
        for (int b = 0; b <= a; b++) {
            const double *pb = m->phi + (size_t)b * (size_t)m->n;
            double sum = a == b ? -1 : 0;
            for (int i = 0; i < m->n; i++) {
                sum += pa[i] * pb[i] * M[i];
            }
            worst = fmax(worst, fabs(sum));
        }
        for (int i = 0; i < m->n; i++) {
            most = fmax(most, pa[i]);
            least = fmax(least, -pa[i]);
        }
        CHECK(most >= (1 - 1e-6) * least);
    }
    CHECK(worst <= 1e-10);
}

#endif
