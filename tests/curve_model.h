/* The evaluator's closed forms in doubles, each with a bound on how far the integers of SPEC 6 may
 * be from it: every operation adds its own rounding. The parameters are the clip's own integers.
 * SPDX-License-Identifier: MIT */
#ifndef CURVE_MODEL_H
#define CURVE_MODEL_H

#include <math.h>

#include "clip_build.h"

#define LN2  0.693147180559945309
#define TAU  6.283185307179586477
#define RATE 500u /* ticks a second of every clip here */

/* ---- arithmetic with bounds ------------------------------------------------------------------ */

/* An exact number and how far the integer may be from it, both in the integer's own unit. */
typedef struct {
    double exact, error;
} bounded;

static inline bounded make(double exact, double error)
{
    bounded r = {exact, error};
    return r;
}

static inline bounded plus(bounded a, bounded b)
{
    return make(a.exact + b.exact, a.error + b.error);
}

/* floor(a b / 2^bits): both errors, and a floor of at most 1. */
static inline bounded times(bounded a, bounded b, int bits)
{
    double error = fabs(a.exact) * b.error + fabs(b.exact) * a.error + a.error * b.error;
    return make(ldexp(a.exact * b.exact, -bits), ldexp(error, -bits) + 1);
}

static inline bounded constant(double exact)
{
    return make(exact, 0);
}

/* u as UQ32, and how much 2 U is short of it. 1/h is short by (1 + r)/h of 2^-32, r the rest of its
 * division, the product by 1, and U = u >> 1 by one more. */
static inline bounded fraction(double dt, uint16_t h)
{
    return make(ldexp(dt / h, 32), 3.0 + 0xffffffffu % h);
}

/* t(x) = 2 floor(U x / 2^32): the floor counts twice. */
static inline bounded times_u(bounded u, bounded x)
{
    bounded t = times(u, x, 32);
    t.error += 1;
    return t;
}

/* ---- pairs in Q30 ---------------------------------------------------------------------------- */

typedef struct {
    bounded even, odd;
} pair;

/* cosh and sinh about the middle, times 2^-(kappa h / 2): the bits floor by 2^-24 (2^30 LN2 2^-24 <
 * 44.4 at a slope of at most 1), exp2n is good to 2^-23.4 (< 97.1), a half floors by 1/2. */
static inline pair exp_pair(double dt, uint16_t h, const uint32_t *param, unsigned k)
{
    double lambda = LN2 * param[0] * 0x1p-24, each = 44.4 + 97.1;
    /* scale cosh and sinh (lambda (dt - h/2)) with scale = exp(-lambda h/2), free of overflow */
    double left = exp(-lambda * dt), right = exp(-lambda * (h - dt));
    pair p = {make(0x1p30 * (right + left) / 2, each + 0.5),
              make(ldexp(0x1p30 * (right - left) / 2, (int)k), ldexp(each, (int)k) + 0.5)};
    return p;
}

/* The phase floors by 2^-32 turn (TAU 2^-2 < 1.6), sine and cosine are good to 2^-20.7 (< 631). */
static inline pair trig_pair(double dt, uint16_t h, const uint32_t *param)
{
    double phase = TAU * 0x1p-32 * param[0] * (dt - h / 2.0);
    pair p = {make(0x1p30 * cos(phase), 632.6), make(0x1p30 * sin(phase), 632.6)};
    return p;
}

static inline pair unit_pair(double dt, uint16_t h)
{
    pair p = {constant(0x1p30), make(0x1p30 * (2 * dt / h - 1), fraction(dt, h).error / 2 + 0.5)};
    return p;
}

/* A segment of waves and the pairs and derivative pairs at one place in it. */
typedef struct {
    const build_run_data *run;
    uint16_t h;
    double dt;
    pair first, second;
} wave;

static inline int has_exp(uint8_t kind)
{
    return kind != WG_KIND_OSC0;
}

static const uint32_t *second_param(const build_run_data *r)
{
    return r->params + (has_exp(r->kind) ? 2 : 0);
}

static inline wave wave_at(const build_run_data *r, uint16_t h, double dt)
{
    wave w = {r, h, dt, {{0, 0}, {0, 0}}, {{0, 0}, {0, 0}}};
    w.first = has_exp(r->kind) ? exp_pair(dt, h, r->params, r->aux & 15u) : unit_pair(dt, h);
    w.second = r->kind <= WG_KIND_OSC0  ? trig_pair(dt, h, second_param(r))
               : r->kind == WG_KIND_EXP ? exp_pair(dt, h, second_param(r), r->aux >> 4)
                                        : unit_pair(dt, h);
    return w;
}

/* y in Q12 coefficient units of the four coefficients c (SPEC 6.3 step 4). */
static inline bounded contract(const int16_t *c, uint8_t kind, pair a, pair b)
{
    bounded e0 = times(a.even, constant(c[0]), 16);
    if (kind >= WG_KIND_EXP) {
        bounded s = plus(plus(e0, times(a.odd, constant(c[1]), 16)),
                         plus(times(b.even, constant(c[2]), 16), times(b.odd, constant(c[3]), 16)));
        return make(s.exact / 4, s.error / 4 + 1);
    }
    bounded p = plus(e0, times(a.odd, constant(c[2]), 16));
    bounded q = plus(times(a.even, constant(c[1]), 16), times(a.odd, constant(c[3]), 16));
    return plus(times(p, b.even, 32), times(q, b.odd, 32));
}

/* round(y / 2^(bits - shift)) + base: halves go up, so 1/2 is the most. */
static inline bounded raw_value(bounded y, const build_run_data *r, int bits)
{
    int down = bits - r->shift;
    return make(r->base + ldexp(y.exact, -down), ldexp(y.error, -down) + 0.5);
}

static inline bounded wave_value(const wave *w)
{
    return raw_value(contract(w->run->values, w->run->kind, w->first, w->second), w->run, 12);
}

/* ---- derivatives ----------------------------------------------------------------------------- */

/* A pair's derivative over its scale, as the evaluator keeps it (SPEC 6.5): scale rate 2^k. */
typedef struct {
    pair over;
    bounded rate_q16;
    int k;
} slope;

/* The rate is delta or eta to the nearest 2^-16 (an error of 1/2) of the true lambda a second. */
static inline slope exp_slope(pair p, const uint32_t *param, unsigned k)
{
    slope d = {{make(ldexp(p.odd.exact, -2 * (int)k), ldexp(p.odd.error, -2 * (int)k) + 1), p.even},
               make(65536.0 * RATE * LN2 * 0x1p-24 * param[0], 0.5),
               (int)k};
    return d;
}

static inline slope trig_slope(pair p, const uint32_t *param)
{
    slope d = {{make(-p.odd.exact, p.odd.error), p.even},
               make(65536.0 * RATE * TAU * 0x1p-32 * param[0], 0.5),
               0};
    return d;
}

/* floor(RATE 2^16 / h) segments a second; x goes through 2 of its units in one. */
static inline bounded segment_rate(uint16_t h)
{
    return make(65536.0 * RATE / h, 1);
}

static inline slope unit_slope(uint16_t h)
{
    slope d = {{constant(0), constant(0x1p30)}, segment_rate(h), 1};
    return d;
}

static inline bounded scaled(bounded y, const slope *d)
{
    bounded v = times(y, d->rate_q16, 16);
    return make(ldexp(v.exact, d->k), ldexp(v.error, d->k));
}

static inline bounded wave_velocity(const wave *w)
{
    static const pair none = {{0, 0}, {0, 0}};
    const build_run_data *r = w->run;
    int sum = r->kind >= WG_KIND_EXP;
    slope da = has_exp(r->kind) ? exp_slope(w->first, r->params, r->aux & 15u) : unit_slope(w->h);
    slope db = r->kind <= WG_KIND_OSC0  ? trig_slope(w->second, second_param(r))
               : r->kind == WG_KIND_EXP ? exp_slope(w->second, second_param(r), r->aux >> 4)
                                        : unit_slope(w->h);
    bounded v = plus(scaled(contract(r->values, r->kind, da.over, sum ? none : w->second), &da),
                     scaled(contract(r->values, r->kind, sum ? none : w->first, db.over), &db));
    int down = 12 - r->shift;
    return make(ldexp(v.exact, -down), ldexp(v.error, -down) + 1);
}

/* ---- knots ----------------------------------------------------------------------------------- */

/* The cubic of a segment, Q10: v + u (m + u (b + u a)). */
typedef struct {
    double v, m, b, a;
} cubic;

/* The integers of SPEC 6.3 step 3 are exact up to here: m0, m1 floor as the text says. */
static inline cubic cubic_of(const build_run_data *r, unsigned index, uint16_t h)
{
    unsigned stride = r->kind == WG_KIND_CUBIC ? 2 : 1;
    const int16_t *left = r->values + index * stride;
    cubic y = {1024.0 * left[0], 0, 0, 0};
    double rise = 1024.0 * left[stride] - y.v;
    if (r->kind == WG_KIND_LINEAR) {
        y.m = rise;
    } else if (r->kind == WG_KIND_CUBIC) {
        double m0 = floor(ldexp((double)left[1] * h, 8 - r->aux));
        double m1 = floor(ldexp((double)left[3] * h, 8 - r->aux));
        y.m = m0;
        y.a = m0 + m1 - 2 * rise;
        y.b = rise - m0 - y.a;
    }
    return y;
}

static inline bounded knots_value(const build_run_data *r, const cubic *y, bounded u)
{
    bounded t = plus(constant(y->b), times_u(u, constant(y->a)));
    t = plus(constant(y->m), times_u(u, t));
    return raw_value(plus(constant(y->v), times_u(u, t)), r, 10);
}

static inline bounded knots_velocity(const build_run_data *r, const cubic *y, bounded u, uint16_t h)
{
    bounded t = plus(constant(2 * y->b), times_u(u, constant(3 * y->a)));
    t = times(plus(constant(y->m), times_u(u, t)), segment_rate(h), 16);
    int down = 10 - r->shift;
    return make(ldexp(t.exact, -down), ldexp(t.error, -down) + 1);
}

#endif
