/* Exponential and sine of the evaluator in Q30.
 * Source: own minimax fits; bounds checked against mpmath by tests/reference/fix_oracle.py.
 * SPDX-License-Identifier: MIT */
#include "fix.h"
#include "wg_mem.h"

/* round(2^(30 - i/32)), i = 0..31. */
static WG_TABLE const int32_t EXP2[32] = {
    1073741824, 1050733751, 1028218693, 1006186087, 984625594, 963527098, 942880699, 922676710,
    902905651,  883558244,  864625413,  846098274,  827968132, 810226483, 792865000, 775875538,
    759250125,  742980960,  727060411,  711481005,  696235434, 681316545, 666717336, 652430958,
    638450708,  624770026,  611382493,  598281827,  585461881, 572916640, 560640218, 548626854,
};

/* 2^-p, p in UQ8.24, as Q30; 0 from p = 31 on. Error <= 2^-23.4 of 1 (the fit has 2^-23.9).
 * With z = 32 frac: 1 - 2^(-z/32) = z (a1 - a2 z); the constants are a1 2^33 and a2 2^34. */
int32_t fix_exp2n(uint32_t p_q24)
{
    if (p_q24 >= UINT32_C(0x1f000000)) {
        return 0;
    }
    int32_t step = (int32_t)wg_rd32(&EXP2[(p_q24 >> 19) & 31u]);
    int32_t z_q31 = (int32_t)((p_q24 & UINT32_C(0x7ffff)) << 12);
    int32_t drop_q32 = fix_mulh(z_q31, INT32_C(0x0b170939) - fix_mulh(z_q31, INT32_C(0x003ce234)));
    return (step - fix_mulh(step, drop_q32)) >> (p_q24 >> 24);
}

/* Sine and cosine of a phase in turns / 2^32, as Q30. Error <= 2^-20.7 (sine) and 2^-24 (cosine)
 * before the quadrant swaps them. z in [-1, 1) is the phase from the nearest quarter turn in
 * eighths: sin = z (s0 - y (s1 - y s2)), cos = 1 - y (c1 - y (c2 - y c3)) with y = z^2 in Q30. */
void fix_sincos(uint32_t phase, int32_t *sine, int32_t *cosine)
{
    uint32_t quarter = (phase + UINT32_C(0x20000000)) >> 30;
    int32_t z = (int32_t)((phase - (quarter << 30)) << 2);
    int32_t y = fix_mulh(z, z);
    int32_t odd =
        INT32_C(1686621276) - fix_mulh(y, INT32_C(693327967) - fix_mulh(y, INT32_C(83394718)));
    int32_t even =
        INT32_C(1324673091) - fix_mulh(y, INT32_C(272307757) - fix_mulh(y, INT32_C(21932517)));
    int32_t s = fix_mulh(z, odd);
    int32_t c = INT32_C(0x40000000) - fix_mulh(y, even);
    if (quarter & 1u) {
        int32_t t = s;
        s = c;
        c = -t;
    }
    *sine = (quarter & 2u) ? -s : s;
    *cosine = (quarter & 2u) ? -c : c;
}
