# SPDX-License-Identifier: MIT
"""Where the bones of a skin are: SPEC.md 6.9.

Nothing follows the C player; `s32` stands where the text lets sums wrap. Quaternions are
(w, x, y, z), matrices are lists of rows.
"""
import math

import wgl
from wgl import M32, mulh, mulq, s32
from wgl_shape import ABSENT, SAT30, clamp

TURN, MOVE, QUATERNION, STRETCH, TWIST_START, TWIST_END, FOLLOW = range(7)
ONE = (1 << 29, 0, 0, 0)


# ---- the operations of 6.9 ----------------------------------------------------------------------
def qmul(a, b):
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    return (s32(8 * (mulh(aw, bw) - mulh(ax, bx) - mulh(ay, by) - mulh(az, bz))),
            s32(8 * (mulh(aw, bx) + mulh(ax, bw) + mulh(ay, bz) - mulh(az, by))),
            s32(8 * (mulh(aw, by) - mulh(ax, bz) + mulh(ay, bw) + mulh(az, bx))),
            s32(8 * (mulh(aw, bz) + mulh(ax, by) - mulh(ay, bx) + mulh(az, bw))))


def about(axis, phase):
    s, c = wgl.sincos((phase & M32) // 2)
    return (c >> 1,) + tuple(s32(2 * mulh(s, x)) for x in axis)


def inverse_square(q):
    """n, k and X of matrix(q), or None where n < 2^16."""
    n = s32(sum(mulh(x, x) for x in q))
    if n < 1 << 16:
        return None
    k = 31 - n.bit_length()
    norm = n << k
    x = ((1 << 32) - 1) // (norm >> 15) << 13
    return n, k, s32(x + 16 * mulh(x, s32((1 << 28) - mulh(norm, x))))


def matrix(q):
    found = inverse_square(q)
    if found is None:
        return [[(r == c) << 30 for c in range(3)] for r in range(3)]
    _, k, inverse = found
    w, x, y, z = q

    def part(t):
        return s32(8 * mulh(s32(t << k), inverse))
    xx, yy, zz = mulh(x, x), mulh(y, y), mulh(z, z)
    xy, xz, yz, wx, wy, wz = (mulh(x, y), mulh(x, z), mulh(y, z), mulh(w, x), mulh(w, y),
                              mulh(w, z))
    one = 1 << 30
    return [[s32(one - part(yy + zz)), part(xy - wz), part(xz + wy)],
            [part(xy + wz), s32(one - part(xx + zz)), part(yz - wx)],
            [part(xz - wy), part(yz + wx), s32(one - part(xx + yy))]]


def normal(v):
    """None for a vector 0."""
    b = max(map(abs, v)).bit_length()
    if b == 0:
        return None

    def shifted(x):
        m = abs(x) << 29 - b if b <= 29 else abs(x) >> b - 29
        return m if x >= 0 else -m
    return tuple(map(shifted, v))


def unit(h):
    h = normal(h)
    r = math.isqrt(16 * sum(mulh(x, x) for x in h))
    return tuple(mulh(4 * x, ((1 << 32) - 1) // r << 13) for x in h)


def rotate(m, p):
    return [s32(sum(mulh(row[c], s32(4 * p[c])) for c in range(3))) for row in m]


def scale(v, b):
    return clamp(v << b if b >= 0 else v >> -b, SAT30)


def weigh(a, w):
    return (a * w) >> 15


def minus(a, b):
    return [s32(x - y) for x, y in zip(a, b)]


def plus(a, b):
    return [s32(x + y) for x, y in zip(a, b)]


def parts_of_256(byte):
    return byte + (byte >> 7)


# ---- the steps ----------------------------------------------------------------------------------
class Moved:
    """A bone at one moment: the letters of 6.9 and 6.10."""

    def __init__(self, q, a):
        self.q, self.a = q, a
        self.l = self.t0 = self.t1 = 0
        self.S = self.A = self.B = 0


def place(skin, values, clip):
    """The bones of a skin, moved."""
    out = []
    for bone in skin.bones:
        if bone.parent == ABSENT:
            moved = Moved(ONE, list(bone.origin))
        else:
            moved = carried(bone, skin.bones[bone.parent], out[bone.parent])
        for joint in bone.joints:
            apply(joint, moved, values, clip.shapes[skin.shape].frac, clip.channels)
        moved.S = s32(4 * mulh(16 * bone.length, moved.l << 12))
        moved.A, moved.B = (moved.t0 << 8) & M32, (moved.t1 - moved.t0) & M32
        out.append(moved)
    for bone, moved in zip(skin.bones, out):
        if bone.joints and bone.joints[-1].kind == FOLLOW:
            follow(bone, moved, skin, out)
    return out


def carried(bone, parent, p):
    """Step 1, with a parent: its record and where it is."""
    e, q = parts_of_256(bone.along), p.q
    if p.A or p.B:
        q = qmul(q, about([x << 16 for x in parent.frame[0]], p.A + p.B * e))
    d = [mulq(s32(4 * weigh(p.S, 128 * e)), x) for x in parent.frame[0]]
    here = plus(minus(bone.origin, parent.origin), d)
    return Moved(q, plus(p.a, rotate(matrix(q), here)))


def apply(joint, moved, values, shape_frac, channels):
    """Step 2."""
    if joint.kind == FOLLOW:
        return
    v, f = values[joint.channel], channels[joint.channel].frac
    turned = ((v * joint.data) >> 16) & M32
    if joint.kind == TURN:
        moved.q = qmul(moved.q, about(joint.axis, turned))
    elif joint.kind == MOVE:
        m = s32(4 * scale(v, 8 + shape_frac - f))
        along = [mulh(x, m) for x in joint.axis]
        moved.a = plus(moved.a, rotate(matrix(moved.q), along))
    elif joint.kind == QUATERNION:
        h = [scale(values[k], 29 - channels[k].frac)
             for k in range(joint.channel, joint.channel + 4)]
        if any(h):
            moved.q = qmul(moved.q, unit(h))
    elif joint.kind == STRETCH:
        moved.l = max(-1 << 14, min(1 << 17, scale(v, 14 - f) - (1 << 14)))
    elif joint.kind == TWIST_START:
        moved.t0 = turned
    else:
        moved.t1 = turned


def follow(bone, moved, skin, all_moved):
    """Step 4."""
    total, pairs = [0] * 4, 0
    for j in bone.joints[-1].bones:
        u = normal(minus(skin.bones[j].origin, bone.origin))
        w = normal(minus(all_moved[j].a, moved.a))
        if u is None or w is None:
            continue
        uu, ww, uw = (sum(mulh(x, y) for x, y in zip(a, b)) for a, b in
                      ((u, u), (w, w), (u, w)))
        s = (math.isqrt(16 * uu) * math.isqrt(16 * ww)) >> 4
        h = [s32(x) for x in (s + uw, mulh(u[1], w[2]) - mulh(u[2], w[1]),
                              mulh(u[2], w[0]) - mulh(u[0], w[2]),
                              mulh(u[0], w[1]) - mulh(u[1], w[0]))]
        if any(h):
            total, pairs = [t + (x >> 3) for t, x in zip(total, unit(h))], pairs + 1
    if pairs and any(total):
        moved.q = qmul(moved.q, unit(total))
