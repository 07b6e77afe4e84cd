/* Quaternions in Q29.
 * Source: own integer forms (SPEC 6.9); the unit length that matrices need is divided out where they
 * are made.
 * SPDX-License-Identifier: MIT */
#include "skin.h"

/* 8 (mulh + mulh + mulh - mulh), modulo 2^32. */
static int32_t sum3(const int32_t *a, const int32_t *b)
{
    int32_t s = fix_add(fix_mulh(a[0], b[0]), fix_mulh(a[1], b[1]));
    return fix_add(s, fix_mulh(a[2], b[2]));
}

void wg_quat_mul(int32_t q[4], const int32_t by[4])
{
    int32_t w = q[0], x = q[1], y = q[2], z = q[3];
    const int32_t plus_x[3] = {by[1], by[0], by[3]}, plus_y[3] = {by[2], by[0], by[1]};
    const int32_t plus_z[3] = {by[3], by[0], by[2]};
    const int32_t from_x[3] = {w, x, y}, from_y[3] = {w, y, z}, from_z[3] = {w, z, x};
    q[0] = fix_shl(fix_sub(fix_mulh(w, by[0]), sum3(q + 1, by + 1)), 3);
    q[1] = fix_shl(fix_sub(sum3(from_x, plus_x), fix_mulh(z, by[2])), 3);
    q[2] = fix_shl(fix_sub(sum3(from_y, plus_y), fix_mulh(x, by[3])), 3);
    q[3] = fix_shl(fix_sub(sum3(from_z, plus_z), fix_mulh(y, by[1])), 3);
}

void wg_quat_turn(int32_t q[4], const int32_t axis[3], uint32_t phase)
{
    fix_turn half = fix_sincos(phase >> 1);
    int32_t by[4];
    by[0] = half.cosine >> 1;
    for (unsigned c = 0; c < 3; c++) {
        by[c + 1u] = fix_shl(fix_mulh(half.sine, axis[c]), 1);
    }
    wg_quat_mul(q, by);
}

static uint32_t magnitude(int32_t a)
{
    return a < 0 ? 0u - (uint32_t)a : (uint32_t)a;
}

bool wg_normalise(int32_t *v, unsigned count)
{
    uint32_t all = 0; /* has as many bits as the largest */
    for (unsigned c = 0; c < count; c++) {
        all |= magnitude(v[c]);
    }
    unsigned bits = fix_bits(all);
    for (unsigned c = 0; c < count; c++) {
        uint32_t m = magnitude(v[c]);
        m = bits > 29 ? m >> (bits - 29u) : m << (29u - bits);
        v[c] = v[c] < 0 ? -(int32_t)m : (int32_t)m;
    }
    return all != 0;
}

/* n = sum of mulh(h_k, h_k) lies in 2^24 .. 2^28 - 1, so that r = sqrt(16 n) takes 15 or 16 bits. */
bool wg_quat_unit(int32_t h[4])
{
    int32_t n = 0;
    if (!wg_normalise(h, 4)) {
        return false;
    }
    for (unsigned c = 0; c < 4; c++) {
        n += fix_mulh(h[c], h[c]);
    }
    int32_t inverse = (int32_t)(wg_inverse(fix_sqrt((uint32_t)n << 4)) << 13);
    for (unsigned c = 0; c < 4; c++) {
        h[c] = fix_mulh(fix_shl(h[c], 2), inverse);
    }
    return true;
}

bool wg_quat_measure(const int32_t q[4], wg_quat_size *size)
{
    int32_t n = fix_add(fix_mulh(q[0], q[0]), sum3(q + 1, q + 1));
    if (n < INT32_C(1) << 16) { /* or beyond 2^31 */
        return false;
    }
    size->shift = 31u - fix_bits((uint32_t)n);
    n = fix_shl(n, size->shift);
    int32_t x = (int32_t)(wg_inverse((unsigned)(n >> 15)) << 13); /* within 2^-15 */
    int32_t rest = (INT32_C(1) << 28) - fix_mulh(n, x);           /* Newton: x (2 - n x) */
    size->inverse = x + fix_shl(fix_mulh(x, rest), 4);
    return true;
}

/* 2 t / |q|^2 in Q30, for a sum t of products of q's components. */
static inline int32_t part(int32_t t, const wg_quat_size *size)
{
    return fix_shl(fix_mulh(fix_shl(t, size->shift), size->inverse), 3);
}

void wg_quat_matrix(const int32_t q[4], const wg_quat_size *by, int32_t *R)
{
    const int32_t one = INT32_C(1) << 30;
    int32_t w = q[0], x = q[1], y = q[2], z = q[3];
    int32_t wx = fix_mulh(w, x), wy = fix_mulh(w, y), wz = fix_mulh(w, z);
    int32_t xx = fix_mulh(x, x), yy = fix_mulh(y, y), zz = fix_mulh(z, z);
    int32_t xy = fix_mulh(x, y), xz = fix_mulh(x, z), yz = fix_mulh(y, z);
    const wg_quat_size size = *by;
    R[0] = fix_sub(one, part(fix_add(yy, zz), &size));
    R[1] = part(fix_sub(xy, wz), &size);
    R[2] = part(fix_add(xz, wy), &size);
    R[3] = part(fix_add(xy, wz), &size);
    R[4] = fix_sub(one, part(fix_add(xx, zz), &size));
    R[5] = part(fix_sub(yz, wx), &size);
    R[6] = part(fix_sub(xz, wy), &size);
    R[7] = part(fix_add(yz, wx), &size);
    R[8] = fix_sub(one, part(fix_add(xx, yy), &size));
}

void wg_quat_rotation(const int32_t q[4], int32_t *R)
{
    wg_quat_size size;
    if (wg_quat_measure(q, &size)) {
        wg_quat_matrix(q, &size, R);
        return;
    }
    for (unsigned i = 0; i < 9; i++) {
        R[i] = i % 4u == 0 ? INT32_C(1) << 30 : 0;
    }
}

/* Products of a vector's component, 4 bits finer, with a quaternion's: raw units / 2^9. */
void wg_quat_dual(const int32_t q[4], const int32_t x[3], const int32_t o[3], int32_t dual[4])
{
    int32_t less[3], more[3]; /* (x - o) turns with w, (x + o) crosses the rest */
    for (unsigned c = 0; c < 3; c++) {
        less[c] = fix_sub(fix_shl(x[c], 4), fix_shl(o[c], 4));
        more[c] = fix_add(fix_shl(x[c], 4), fix_shl(o[c], 4));
    }
    dual[0] = fix_sub(0, sum3(less, q + 1));
    for (unsigned c = 0; c < 3; c++) {
        unsigned d = (c + 1u) % 3u, e = (c + 2u) % 3u;
        int32_t cross = fix_sub(fix_mulh(more[d], q[1u + e]), fix_mulh(more[e], q[1u + d]));
        dual[c + 1u] = fix_add(fix_mulh(less[c], q[0]), cross);
    }
}
