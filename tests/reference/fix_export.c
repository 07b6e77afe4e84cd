/* The player's arithmetic as functions that Python can call.
 * SPDX-License-Identifier: MIT */
#include "fix.h"

int32_t export_exp2n(uint32_t p_q24);
void export_sincos(uint32_t phase, int32_t *sine, int32_t *cosine);

int32_t export_exp2n(uint32_t p_q24)
{
    return fix_exp2n(p_q24);
}

void export_sincos(uint32_t phase, int32_t *sine, int32_t *cosine)
{
    fix_turn t = fix_sincos(phase);
    *sine = t.sine;
    *cosine = t.cosine;
}
