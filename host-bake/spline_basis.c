/* The exact solution families of a wiggly segment, evaluated without overflow or cancellation.
 * Source: Schulz 2013, 2.5.1 (six cases); midpoint basis, HYP and SERIES are our own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_parts.h"

#include <math.h>
#include <string.h>

/* Largest coefficient of a curve of amplitude 1, maximised by linear programming over 101 points
 * (R = largest |root| H): the power series needs 4.5 at every R <= 1, OSC 48 at R = 0.5, 25 at 0.7,
 * 16 at 1 and 2..8 above 2. Beyond R = 1 OSC and EXP are as good and what the device plays. */
#define SERIES_BELOW 1.0
/* A half gap b H below this turns HYP and OSC into CRIT: cosh(b s) = 1 within b^2 H^2 / 2 = 5e-15.
 */
#define CRIT_BELOW   1e-7
/* Same measure: EXP needs 1.8 wide/gap, HYP 4 wide H growing as e^(2 gap H); they cross at a half
 * gap of 0.45/H for wide H >= 1.5 and of 0.3 wide below (at wide H = 1: both 21). */
#define HYP_BELOW    0.45
#define HYP_RATIO    0.3
/* EXP with a slow rate: rest = -g/lambda is 1/(b H) times what the force does in one segment, hence
 * 1e3 roundings above this; below, the drive answers the force without it. */
#define DRIVE_BELOW  1e-3
/* |root| H <= 1: the first term left out is below 30^3 / 30! = 1e-28. */
#define SERIES_TERMS 28

#define HALF_PI 1.57079632679489661923

/* An even and an odd function with three derivatives each. */
typedef struct {
    double even[4], odd[4];
} pair;

static pair linear_pair(double s, double H)
{
    return (pair){{1.0, 0.0, 0.0, 0.0}, {s / H, 1.0 / H, 0.0, 0.0}};
}

/* cosh(r s)/cosh(r H), sinh(r s)/sinh(r H); exponents are never positive inside the segment. */
static pair hyperbolic_pair(double r, double s, double H)
{
    double whole = expm1(-2.0 * r * H);
    if (whole == 0.0)
        return linear_pair(s, H);
    double d = fabs(s), grow = exp(r * (d - H)), inner = expm1(-2.0 * r * d);
    double tanh_H = -whole / (2.0 + whole);
    double c = grow * (2.0 + inner) / (2.0 + whole), o = copysign(grow * inner / whole, s);
    double dc = r * tanh_H * o, ds = r / tanh_H * c, r2 = r * r;
    return (pair){{c, dc, r2 * c, r2 * dc}, {o, ds, r2 * o, r2 * ds}};
}

static pair trigonometric_pair(double b, double s, double H)
{
    if (b == 0.0)
        return linear_pair(s, H);
    double scale = b * H < HALF_PI ? 1.0 / sin(b * H) : 1.0;
    double c = cos(b * s), o = sin(b * s), b2 = b * b;
    return (pair){{c, -b * o, -b2 * c, b2 * b * o},
                  {o * scale, b * c * scale, -b2 * o * scale, -b2 * b * c * scale}};
}

/* Derivatives of f g by Leibniz' rule. */
static void product(const double f[4], const double g[4], int column, double out[4][5])
{
    out[0][column] = f[0] * g[0];
    out[1][column] = f[1] * g[0] + f[0] * g[1];
    out[2][column] = f[2] * g[0] + 2.0 * f[1] * g[1] + f[0] * g[2];
    out[3][column] = f[3] * g[0] + 3.0 * (f[2] * g[1] + f[1] * g[2]) + f[0] * g[3];
}

static void products(const pair *f, const pair *g, double out[4][5])
{
    product(f->even, g->even, 0, out);
    product(f->even, g->odd, 1, out);
    product(f->odd, g->even, 2, out);
    product(f->odd, g->odd, 3, out);
}

static void sums(const pair *f, const pair *g, double out[4][5])
{
    for (int i = 0; i < 4; i++) {
        out[i][0] = f->even[i];
        out[i][1] = f->odd[i];
        out[i][2] = g->even[i];
        out[i][3] = g->odd[i];
    }
}

/* 1 / (n (n - 1)) */
#define PAIR(n) (1.0 / ((n) * ((n)-1.0)))
static const double pair_inverse[SERIES_TERMS + 1] = {
    0,        0,        PAIR(2),  PAIR(3),  PAIR(4),  PAIR(5),  PAIR(6),  PAIR(7),
    PAIR(8),  PAIR(9),  PAIR(10), PAIR(11), PAIR(12), PAIR(13), PAIR(14), PAIR(15),
    PAIR(16), PAIR(17), PAIR(18), PAIR(19), PAIR(20), PAIR(21), PAIR(22), PAIR(23),
    PAIR(24), PAIR(25), PAIR(26), PAIR(27), PAIR(28)};

/* P_j = x^j + c_(j+2) x^(j+2) + ...: entire in lambda and delta. With x = s/H the equation is
 * w'''' + p w'' + q w = 0, so  n(n-1)(n-2)(n-3) c_n = -p (n-2)(n-3) c_(n-2) - q c_(n-4).
 * j = 4 starts above the four free coefficients: it answers the constant right side 24.
 * Horner in y = x^2 with three derivatives F', F''/2, F'''/6; P_j is F or x F. */
static void series(double p, double q, double x, int j, double out[4][5])
{
    double c[SERIES_TERMS + 1] = {0.0}, F[4] = {0.0}, y = x * x;
    int odd = j & 1;
    c[j] = 1.0;
    for (int n = j == 4 ? 6 : 4 + odd; n <= SERIES_TERMS; n += 2)
        c[n] = -(p * c[n - 2] + q * c[n - 4] * pair_inverse[n - 2]) * pair_inverse[n];
    for (int n = SERIES_TERMS - odd; n >= 0; n -= 2) {
        F[3] = F[3] * y + F[2];
        F[2] = F[2] * y + F[1];
        F[1] = F[1] * y + F[0];
        F[0] = F[0] * y + c[n];
    }
    out[0][j] = odd ? x * F[0] : F[0];
    out[1][j] = odd ? F[0] + 2.0 * y * F[1] : 2.0 * x * F[1];
    out[2][j] = odd ? x * (6.0 * F[1] + 8.0 * y * F[2]) : 2.0 * F[1] + 8.0 * y * F[2];
    out[3][j] =
        odd ? 6.0 * F[1] + 48.0 * y * (F[2] + y * F[3]) : x * (24.0 * F[2] + 48.0 * y * F[3]);
}

/* EXP's drive: P_4 = 2 (cosh(b s) - 1)/(b H)^2, which is x^2 for b = 0. */
static void exponential_drive(const bake_segment *segment, double s, double H, double out[4][5])
{
    double b = segment->b, x = b * s, scale = 2.0 * segment->drive / (H * H);
    double half = x == 0.0 ? 0.5 * s : s * sinh(0.5 * x) / x;
    double slope = x == 0.0 ? s : s * sinh(x) / x;
    out[0][4] = scale * 2.0 * half * half;
    out[1][4] = scale * slope;
    out[2][4] = scale * cosh(x);
    out[3][4] = scale * b * sinh(x);
}

static void scale_derivatives(double H, double out[4][5])
{
    double scale = 1.0;
    for (int i = 0; i < 4; i++, scale /= H)
        for (int j = 0; j < 5; j++)
            out[i][j] *= scale;
}

static void series_functions(const bake_segment *segment, double s, double H, double out[4][5])
{
    double p = segment->a * H * H, q = segment->b * H * H * H * H;
    for (int j = 0; j < 5; j++)
        series(p, q, s / H, j, out);
    for (int i = 0; i < 4; i++)
        out[i][4] *= segment->drive;
    scale_derivatives(H, out);
}

static void poly_functions(double x, double H, double out[4][5])
{
    static const double power[4][4] = {{1, 1, 1, 1}, {0, 1, 2, 3}, {0, 0, 2, 6}, {0, 0, 0, 6}};
    double x_n[4] = {1.0, x, x * x, x * x * x};
    for (int i = 0; i < 4; i++)
        for (int j = i; j < 4; j++)
            out[i][j] = power[i][j] * x_n[j - i];
    scale_derivatives(H, out);
}

void bake_segment_functions(const bake_segment *segment, double s, double out[4][5])
{
    double H = 0.5 * (segment->t1 - segment->t0);
    pair f, g;
    memset(out, 0, sizeof(double[4][5]));
    switch (segment->family) {
    case BAKE_POLY:
        poly_functions(s / H, H, out);
        break;
    case BAKE_SERIES:
        series_functions(segment, s, H, out);
        break;
    case BAKE_EXP:
        f = hyperbolic_pair(segment->a, s, H);
        g = hyperbolic_pair(segment->b, s, H);
        sums(&f, &g, out);
        if (segment->drive != 0.0)
            exponential_drive(segment, s, H, out);
        break;
    default:
        f = hyperbolic_pair(segment->a, s, H);
        g = segment->family == BAKE_OSC   ? trigonometric_pair(segment->b, s, H)
            : segment->family == BAKE_HYP ? hyperbolic_pair(segment->b, s, H)
                                          : linear_pair(s, H);
        products(&f, &g, out);
    }
    out[0][4] += segment->rest;
}

/* Exactly +-H at the ends, however far from 0 the segment lies. */
static double from_middle(const bake_segment *segment, double t)
{
    double H = 0.5 * (segment->t1 - segment->t0), before = t - segment->t0, after = segment->t1 - t;
    return before < after ? before - H : H - after;
}

void bake_segment_eval(const bake_segment *segment, double t, double out[4])
{
    double all[4][5];
    bake_segment_functions(segment, from_middle(segment, t), all);
    for (int i = 0; i < 4; i++) {
        out[i] = all[i][4];
        for (int j = 0; j < 4; j++)
            out[i] += all[i][j] * segment->w[j];
    }
}

static void choose(bake_segment *segment, bake_family family, double a, double b)
{
    segment->family = family;
    segment->a = a;
    segment->b = b;
}

/* lambda may be anything down to 0 here, so g/lambda is used only where it is harmless. */
static void choose_exponential(bake_segment *segment, const bake_mode *mode, double fast)
{
    double H = 0.5 * (segment->t1 - segment->t0), slow = fabs(mode->lambda) / fast;
    choose(segment, BAKE_EXP, fast, slow);
    if (slow * H >= DRIVE_BELOW)
        return;
    segment->rest = 0.0;
    segment->drive = 0.5 * mode->g * mode->lambda * H * H / (fast * fast);
}

void bake_segment_prepare(bake_segment *segment, const bake_mode *mode, double t0, double t1)
{
    double lambda = mode->lambda, delta = fabs(mode->delta), H = 0.5 * (t1 - t0);
    double square = delta * delta - lambda, eta = sqrt(fabs(square));
    double fast = square < 0.0 ? sqrt(lambda) : delta + eta;
    *segment = (bake_segment){.t0 = t0, .t1 = t1};
    if (fast == 0.0)
        return;
    if (fast * H < SERIES_BELOW) {
        choose(segment, BAKE_SERIES, 2.0 * (lambda - 2.0 * delta * delta), lambda * lambda);
        segment->drive = -lambda * mode->g * H * H * H * H / 24.0;
        return;
    }
    segment->rest = lambda == 0.0 ? 0.0 : -mode->g / lambda;
    if (square < 0.0 && eta * H >= CRIT_BELOW) {
        choose(segment, BAKE_OSC, delta, eta);
        return;
    }
    /* The rates are delta +- eta; delta - eta would cancel, the product of the two is |lambda|. */
    double wide = fmax(delta, eta), half_gap = fmin(delta, eta);
    if (half_gap * H < CRIT_BELOW)
        choose(segment, BAKE_CRIT, wide, 0.0);
    else if (half_gap < fmin(HYP_BELOW / H, HYP_RATIO * wide))
        choose(segment, BAKE_HYP, wide, half_gap);
    else
        choose_exponential(segment, mode, fast);
}
