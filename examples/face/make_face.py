#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Sculpts the talking face: neutral.obj, one OBJ a base shape and face.mtl, beside this script.

A pose is a handful of numbers in millimetres (POSES); face(pose) gives the vertices of the whole
head for it, in the same order for every pose, so that all files share their triangles. What a pose
does not name stays where it is to the last digit: the lids blink and nothing else. The head is
100 mm tall, y up, it looks towards +z. Source: own; base shapes as in [Alexa 7.1.1]."""
import os

import numpy as np

HEAD = np.array([41.0, 46.0, 42.0])  # half width, height, depth
MOUTH_Y, EYE = -24.5, np.array([17.0, 3.0])  # the right half, seen from the front; mirrored
EYE_A, EYE_B, BULGE = 12.0, 13.5, 1.6  # half width and height of an eye; how far it stands out
LIP, RIM, LID = 24, 14, 8  # vertices around the mouth, around an eye, along a lid
EYE_COUNT = 1 + 4 * RIM + 7

COLOURS = {"skin": (255, 204, 164), "lips": (164, 42, 52), "mouth": (72, 16, 26),
           "teeth": (250, 246, 236), "tongue": (222, 110, 112), "eyes": (252, 252, 248),
           "iris": (40, 112, 130), "pupils": (20, 20, 32), "lids": (240, 172, 130),
           "lashes": (46, 28, 24), "brows": (74, 38, 20), "nose": (246, 162, 128),
           "hair": (132, 64, 24)}

# wide, up, down: how the mouth's opening grows; corners, pout: they, and the middle of the lips,
# rise; forward: the lips come; thin: they are pressed; jaw: it drops; cheeks: they swell; squint,
# blink: lower and upper lids close; brows, frown: they rise, their inner ends sink; look, tuft: to
# the face's left
POSES = {
    "neutral": {},
    "A": {"wide": -0.5, "up": 2.2, "down": 10.0, "jaw": 8.0},
    "E": {"wide": 3.5, "up": 2.0, "down": 4.0, "corners": 1.0, "jaw": 2.5},
    "O": {"wide": -5.0, "up": 3.2, "down": 5.5, "forward": 3.5, "jaw": 3.5},
    "M": {"wide": -1.0, "forward": -0.6, "thin": 0.55, "jaw": -0.5},
    "smile": {"wide": 4.0, "corners": 5.5, "forward": -0.4, "pout": -0.4, "squint": 3.2,
              "cheeks": 2.0},
    "grumble": {"wide": -0.5, "corners": -4.5, "forward": 0.6, "pout": 1.8, "frown": 4.5},
    "blink": {"blink": 1.0},
    "brows": {"brows": 5.5},
    "look": {"look": 2.3},
    "tuft": {"tuft": 5.0},
}


def smooth(x):
    """0 below 0, 1 above 1, flat at both."""
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def unit(v):
    return v / np.linalg.norm(v)


# ---- the head's surface --------------------------------------------------------------------------

def width(ny):
    """Cheeks low down, a narrower skull and chin."""
    return 1 + 0.09 * np.exp(-((ny + 0.42) / 0.34) ** 2) - 0.06 * np.maximum(ny, 0) ** 2


def head(direction):
    n = np.asarray(direction, float)
    out = HEAD * n
    out[..., 0] *= width(n[..., 1])
    return out


def normals_at(x, y):
    """The unit direction whose point on the head's front is (x, y)."""
    ny = np.asarray(y, float) / HEAD[1]
    nx = np.asarray(x, float) / (HEAD[0] * width(ny))
    nz = np.sqrt(np.maximum(1 - nx ** 2 - ny ** 2, 0.02))
    return np.stack(np.broadcast_arrays(nx, ny, nz), -1)


def front(x, y, out=0.0):
    """Points on the head's front at (x, y), `out` towards the viewer."""
    z = HEAD[2] * normals_at(x, y)[..., 2] + out
    return np.stack(np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float), z), -1)


def slide(p, move):
    """Moves along the skin: the depth follows the head, but a jaw that drops only swings back."""
    dx, dy = move[..., 0], move[..., 1]
    z = front(p[..., 0] + dx, p[..., 1] + np.maximum(dy, 0)) - front(p[..., 0], p[..., 1])
    z[..., 0], z[..., 1] = dx, dy
    z[..., 2] += move[..., 2] - 0.25 * np.maximum(-dy, 0)
    return p + z


def flat(direction):
    """The head unrolled around its front, for triangulating: the angle to +z, in radians."""
    n = np.asarray(direction, float)
    rho = np.arccos(np.clip(n[..., 2], -1, 1))
    length = np.maximum(np.hypot(n[..., 0], n[..., 1]), 1e-12)
    return n[..., :2] * (rho / length)[..., None]


def unflat(uv):
    rho = np.hypot(uv[..., 0], uv[..., 1])
    scale = np.sinc(rho / np.pi)
    return np.stack([uv[..., 0] * scale, uv[..., 1] * scale, np.cos(rho)], -1)


def delaunay(points):
    """Triangles of points in the plane [Bowyer-Watson]; they are few, so squares do not matter."""
    far = np.array([[-99.0, -77.0], [101.0, -78.0], [1.0, 99.0]])
    p = np.vstack([points, far])
    n = len(points)
    triangles = [(n, n + 1, n + 2)]

    def holds(t, q):
        a, b, c = (p[i] - q for i in t)
        return np.linalg.det(np.array([[*a, a @ a], [*b, b @ b], [*c, c @ c]])) > 0

    for i in range(n):
        bad = [t for t in triangles if holds(t, p[i])]
        edges = [(t[k], t[(k + 1) % 3]) for t in bad for k in range(3)]
        triangles = [t for t in triangles if t not in bad]
        triangles += [(a, b, i) for a, b in edges if (b, a) not in edges]
    return [t for t in triangles if max(t) < n]


# ---- mouth ---------------------------------------------------------------------------------------

def mouth_angles():
    return np.arange(LIP) * 2 * np.pi / LIP


def contour(pose, reach, upper, lower, inner):
    """A line around the mouth: `reach`, `upper`, `lower` from the gap; inner: 1 at the gap, 0 on
    the skin, which follows the opening a little less."""
    a = mouth_angles()
    get = pose.get
    half = 11.5 + get("wide", 0) * (0.75 + 0.25 * inner)
    x = (half + reach) * np.cos(a)
    along = np.clip(np.abs(np.cos(a)), 0, 1) ** 2
    thick = 1 - get("thin", 0)
    up = get("up", 0) * (0.6 + 0.4 * inner) + upper * thick
    down = get("down", 0) * (0.9 + 0.1 * inner) + lower * thick
    lift = np.where(np.sin(a) >= 0, up, -down) * np.abs(np.sin(a)) ** 0.9
    bow = 0.22 * upper * np.exp(-(np.cos(a) / 0.16) ** 2) * (np.sin(a) > 0)  # of the upper lip
    y = MOUTH_Y + lift - bow + (1.2 + get("corners", 0)) * along + get("pout", 0) * (1 - along)
    return x, y


def lips(pose, which):
    """One of the rings: on the skin, the lips' crest, the gap, and the dark behind it."""
    reach, upper, lower, out, inner = {
        "outer": (2.2, 3.4, 3.9, 0.0, 0.0), "crest": (1.2, 2.0, 2.4, 2.2, 0.5),
        "gap": (0.0, 0.0, 0.0, 0.8, 1.0), "back": (-0.6, 0.4, 0.4, -9.0, 1.0)}[which]
    x0, y0 = contour({}, reach, upper, lower, inner)
    x, y = contour(pose, reach, upper, lower, inner)
    forward = pose.get("forward", 0) * {"outer": 0.45, "back": 0.3}.get(which, 1.0)
    move = np.stack([x - x0, y - y0, np.full(LIP, forward)], -1)
    return slide(front(x0, y0, out), move)


def skin_moves(p, pose):
    """The skin around a mouth that moves, down to the chin and up to the cheeks."""
    rest = lips({}, "outer")
    moved = lips(pose, "outer") - rest
    if not pose.keys() - {"blink", "brows", "frown", "look", "tuft"}:
        return p
    distance = np.hypot(p[:, None, 0] - rest[None, :, 0], p[:, None, 1] - rest[None, :, 1])
    share = 1 / np.maximum(distance, 1e-6) ** 3
    follow = (share / share.sum(1, keepdims=True)) @ moved
    near = smooth(1 - distance.min(1) / 15) * smooth(p[:, 2] / 15)
    below = smooth((-17 - p[:, 1]) / 15) * smooth((p[:, 2] + 16) / 40)
    drop = pose.get("jaw", 0) * below[:, None] * np.array([0, -1.0, -0.3])
    apple = np.hypot((np.abs(p[:, 0]) - 24) / 13, (p[:, 1] + 16) / 10)
    raise_ = pose.get("cheeks", 0) * smooth(1 - apple)[:, None] * np.array([0, 0.8, 1.0])
    return p + near[:, None] * follow + (1 - near[:, None]) * drop + raise_ * (p[:, 2:] > 0)


# ---- eyes ----------------------------------------------------------------------------------------

def eye_rim(angle, grow=1.0):
    return front(EYE[0] + EYE_A * grow * np.cos(angle), EYE[1] + EYE_B * grow * np.sin(angle))


EYE_MIDDLE = eye_rim(np.arange(RIM) * 2 * np.pi / RIM).mean(0)
EYE_OUT = unit(normals_at(*EYE) / HEAD)


def eyeball(ex, ey, out=0.0):
    """The eye's surface at (ex, ey) from its middle: flatter than the head, so that a lid can slide
    over it on a straight line."""
    t = np.hypot(ex / EYE_A, ey / EYE_B)
    rim = eye_rim(np.arctan2(ey / EYE_B, ex / EYE_A))
    return EYE_MIDDLE + (rim - EYE_MIDDLE) * t[..., None] + \
        EYE_OUT * (BULGE * (1 - t ** 2) + out)[..., None]


def eye(pose, side):
    """Rings around the pupil (middle, pupil, iris, white, the skin's rim), then the highlight."""
    a, ring = np.arange(RIM) * 2 * np.pi / RIM, np.arange(6) * np.pi / 3
    gaze = np.array([-1.2 + side * pose.get("look", 0), -0.4])
    p = [gaze[None]]
    for t, follows in ((0.34, 1), (0.58, 1), (0.84, 0.5), (1.0, 0)):
        p.append(gaze * follows + t * np.stack([EYE_A * np.cos(a), EYE_B * np.sin(a)], -1))
    shine = gaze + [side * 2.6, 3.6]
    p += [shine[None], shine + np.stack([1.9 * np.cos(ring), 2.1 * np.sin(ring)], -1)]
    p = np.concatenate(p)
    out = np.zeros(EYE_COUNT)
    out[-7:] = 0.5
    return eyeball(p[:, 0], p[:, 1], out)


def upper_lid(pose):
    """Rows from the rim down to the lashes, open or shut."""
    a = np.arange(LID) * np.pi / (LID - 1)
    x = EYE_A * np.cos(a)
    top, bottom = EYE_B * np.sin(a), -EYE_B * np.sin(a)
    rows = [eye_rim(a)]
    # row: how far down it is open and shut (0 the rim above, 1 below), how far it stands out
    for is_open, shut, out in ((0.07, 0.46, 2.6), (0.12, 0.89, 2.3), (0.21, 1.03, 2.0)):
        ends = []
        for down, wider in ((is_open, 0.985), (shut, 1.03)):
            y = top + (bottom - top) * down
            lift = out * (0.25 + 0.75 * np.sin(a))
            ends.append(eyeball(x * wider, y) + unit(EYE_OUT + [0, 0, 1.0]) * lift[:, None])
        rows.append(ends[0] + (ends[1] - ends[0]) * pose.get("blink", 0))
    return np.concatenate(rows)


def squint(p, angle, pose):
    """The lower half of the skin's rim rises in front of the eye when the cheeks do."""
    up = pose.get("squint", 0) * smooth(-np.sin(angle))[:, None]
    return p + up * (np.array([0, 1.0, 0]) + 0.7 * EYE_OUT)


# ---- pieces: vertices for a pose, and triangles by part ------------------------------------------

def mirrored(p):
    return p * np.array([-1.0, 1, 1])


def bands(rows, columns, first=0, closed=True):
    """Triangles between rows of vertices that run counter-clockwise, outer after inner."""
    out = []
    for r in range(rows - 1):
        for c in range(columns if closed else columns - 1):
            a, b = first + r * columns + c, first + r * columns + (c + 1) % columns
            out += [(a, a + columns, b + columns), (a, b + columns, b)]
    return out


def fan(middle, ring, count):
    return [(middle, ring + c, ring + (c + 1) % count) for c in range(count)]


class Skin:
    """The face's skin, triangulated once, on the right half, and mirrored."""

    def __init__(self):
        a = mouth_angles()
        half = np.cos(a) > -1e-9
        self.lip = np.nonzero(half)[0]
        rim = np.arange(RIM) * 2 * np.pi / RIM
        around = np.arange(14) * 2 * np.pi / 14 + 0.2
        wide = (np.arange(9) - 4) * np.pi / 9.0
        mouth = lips({}, "outer")[half]
        fixed = [front(mouth[:, 0], mouth[:, 1]), eye_rim(rim), eye_rim(around, 1.3),
                 front(np.abs(20.5 * np.cos(wide)), MOUTH_Y + 10 * np.sin(wide))]
        uv = [flat(normals_at(p[:, 0], p[:, 1])) for p in fixed]
        uv[2] = uv[2][uv[2][:, 0] > 0.1]
        self.rim = len(uv[0]) + np.arange(RIM)
        self.rim_angle = rim
        uv = np.concatenate(uv)
        uv[np.abs(uv[:, 0]) < 1e-6, 0] = 0
        self.uv = np.concatenate([uv, self.fill(uv)])
        self.cut()

    @staticmethod
    def fill(uv):
        """Points between the features, wider apart behind; the last ring lies under the hair."""
        points = []
        for rho in (0, 0.16, 0.34, 0.52, 0.72, 0.93, 1.15, 1.4, 1.75, 2.25):
            count = max(1, round(np.pi * np.sin(min(rho, 1.6)) / (0.19 + 0.07 * rho)))
            for k in range(count + 1):
                phi = -np.pi / 2 + np.pi * k / count
                q = rho * np.array([np.cos(phi), np.sin(phi)])
                q[0] = 0 if q[0] < 1e-9 else q[0]
                if k and rho == 0:
                    continue
                if np.hypot(*(uv - q).T).min() > 0.12 + 0.03 * rho and not Skin.inside(q):
                    points.append(q)
        return np.array(points)

    @staticmethod
    def inside(q):
        p = head(unflat(q))
        in_eye = np.hypot((p[0] - EYE[0]) / EYE_A, (p[1] - EYE[1]) / EYE_B) < 1.1
        return in_eye or np.hypot(p[0] / 16, (p[1] - MOUTH_Y) / 6) < 1.1 and p[2] > 0

    def cut(self):
        """The triangles of both halves; a triangle on one feature's line alone is its hole."""
        n = len(self.uv)
        lip, rim = set(range(len(self.lip))), set(self.rim)
        right = [t for t in delaunay(self.uv)
                 if not set(t) <= lip and not set(t) <= rim and self.area(t) > 1e-6]
        self.beside = np.nonzero(self.uv[:, 0] != 0)[0]  # not on the midline: these have a twin
        twin = np.arange(n)
        twin[self.beside] = n + np.arange(len(self.beside))
        self.triangles = right + [(twin[a], twin[c], twin[b]) for a, b, c in right]

    def area(self, t):
        (ax, ay), (bx, by), (cx, cy) = self.uv[list(t)]
        return 0.5 * ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))

    def at(self, pose):
        rest = head(unflat(self.uv))
        p = skin_moves(rest, pose)
        p[:len(self.lip)] = lips(pose, "outer")[self.lip]
        p[self.rim] = squint(eye_rim(self.rim_angle), self.rim_angle, pose)
        p[self.uv[:, 0] == 0, 0] = 0
        return np.concatenate([p, mirrored(p[self.beside])])


def mouth_pieces(pose):
    rings = np.concatenate([lips(pose, k) for k in ("outer", "crest", "gap")])
    gap_back = np.concatenate([lips(pose, "gap"), lips(pose, "back")])
    middle = lips(pose, "back").mean(0, keepdims=True) - [[0, 0, 4.0]]
    x = np.linspace(-12, 12, 7)
    arch = front(x, MOUTH_Y + 0 * x, -2.6)
    teeth = np.concatenate([arch + [0, 7.0, 0], arch + [0, -0.8, 0.3]])
    opening = pose.get("down", 0)
    a = np.arange(8) * np.pi / 4
    top = np.array([[0, MOUTH_Y - 1.0, 22.5]])
    edge = top + np.stack([6.5 * np.cos(a), -2.2 + 0 * a, 4.5 * np.sin(a)], -1)
    tongue = np.concatenate([top, edge, edge + [0, -4.0, 0]]) + \
        [0, -0.62 * opening, 0.12 * opening]
    return [("lips", rings, inside_out(bands(3, LIP))),
            ("mouth", np.concatenate([gap_back, middle]),
             inside_out(bands(2, LIP)) + fan(2 * LIP, LIP, LIP)),
            ("teeth", teeth, bands(2, 7, closed=False)),
            ("tongue", tongue, inside_out(fan(0, 1, 8) + bands(2, 8, 1)))]


def inside_out(triangles):
    return [t[::-1] for t in triangles]


def twice(triangles, count):
    """The triangles of `count` vertices and of their mirror images behind them."""
    return triangles + [(a + count, c + count, b + count) for a, b, c in triangles]


def both(part, p, triangles):
    """A piece of the right half and its mirror image."""
    return [(part, np.concatenate([p, mirrored(p)]), twice(triangles, len(p)))]


def eye_pieces(pose):
    p = np.concatenate([eye(pose, 1), mirrored(eye(pose, -1))])
    parts = {"pupils": fan(0, 1, RIM), "iris": bands(2, RIM, 1),
             "eyes": bands(3, RIM, 1 + RIM) + fan(EYE_COUNT - 7, EYE_COUNT - 6, 6)}
    pieces = [(None, p, [])]
    for part, triangles in parts.items():
        pieces.append((part, None, twice(triangles, EYE_COUNT)))
    rows = inside_out(bands(4, LID, 0, False))
    edge = 4 * (LID - 1)
    return pieces + both("lids", upper_lid(pose), rows[:edge]) + \
        [("lashes", None, twice(rows[edge:], 4 * LID))]


def brow(pose):
    s = np.linspace(0, 1, 6)  # from the nose outwards
    x, y = 7.5 + 21 * s, 21.2 + 4.2 * np.sin(np.pi * (0.15 + 0.75 * s))
    y = y + pose.get("brows", 0) * (0.8 + 0.3 * np.sin(np.pi * s)) - \
        pose.get("frown", 0) * (1 - s) ** 1.5
    thick = 2.3 * (1 - 0.55 * s ** 2)
    x = x - 0.35 * pose.get("frown", 0) * (1 - s)
    rows = [front(x, y + thick, 0.2), front(x, y, 2.2), front(x, y - thick, 0.2)]
    return both("brows", np.concatenate(rows), bands(3, 6, 0, False))


def dome(middle, radii, axes, rings, columns):
    """Part of an ellipsoid around axes[2]; `rings`: angles from there."""
    a = np.arange(columns) * 2 * np.pi / columns
    p = [np.array([[0, 0, 1.0]])]
    for r in rings:
        p.append(np.stack([np.sin(r) * np.cos(a), np.sin(r) * np.sin(a), np.cos(r) + 0 * a], -1))
    p = middle + (np.concatenate(p) * radii) @ np.asarray(axes, float)
    return p, fan(0, 1, columns) + bands(len(rings), columns, 1)


def hair():
    """A cap around a pole behind the crown: a fringe in front, the ears free, down to the nape."""
    columns = 20
    pole = unit(np.array([0, 0.80, -0.60]))
    ahead = np.array([0, 0.60, 0.80])
    a = np.arange(columns) * 2 * np.pi / columns
    forward = np.cos(a)
    line = np.interp(forward, [-1, -0.5, 0, 0.35, 0.7, 1], [98, 98, 78, 92, 82, 76])
    zigzag = 7.0 * np.where(np.arange(columns) % 2, 1, -1) * smooth((forward - 0.3) * 3)
    p = [head(pole)[None] * 1.09]
    for r, out in ((0.33, 1.10), (0.68, 1.12), (0.9, 1.11), (1.0, 1.07), (1.01, 0.95)):
        angle = np.radians(line * r + zigzag * max(0, (r - 0.5) * 2))[:, None]
        around = np.cos(a)[:, None] * ahead + np.sin(a)[:, None] * np.array([1.0, 0, 0])
        p.append(head(np.cos(angle) * pole + np.sin(angle) * around) * out)
    return np.concatenate(p), fan(0, 1, columns) + bands(5, columns, 1)


def tuft(pose):
    """A curl on the crown, which swings."""
    a = np.arange(6) * np.pi / 3
    p = [np.array([[0, 58.0, 15.5]])]
    for y, z, radius in ((55.5, 11.5, 2.6), (51.0, 9.0, 4.2), (46.0, 9.0, 5.0)):
        p.append(np.stack([radius * np.cos(a), y + 0 * a, z - radius * np.sin(a)], -1))
    p = np.concatenate(p)
    p[:, 0] += pose.get("tuft", 0) * smooth((p[:, 1] - 46) / 14)
    return p, fan(0, 1, 6) + bands(3, 6, 1)


SKIN = Skin()


def face(pose):
    """[(part, vertices or None to reuse the last ones, triangles)] of the whole head."""
    nose = dome(front(0, -9.5, -0.5), (6.2, 5.2, 7.0), np.eye(3), np.radians([35, 68, 95]), 10)
    ear = dome(np.array([41.5, -2.5, -3.0]), (5.0, 9.5, 5.5),
               [[0.4, 0, -0.92], [0, 1, 0], [0.92, 0, 0.4]], np.radians([45, 90]), 8)
    return [("skin", SKIN.at(pose), SKIN.triangles)] + mouth_pieces(pose) + eye_pieces(pose) + \
        brow(pose) + [("nose", *nose)] + both("skin", *ear) + \
        [("hair", *hair()), ("hair", *tuft(pose))]


def assemble(pose):
    """(vertices rounded to 0.01 mm, {part: triangles})"""
    vertices, parts, first, base = [], {}, 0, 0
    for part, p, triangles in face(pose):
        if p is not None:
            base, first = first, first + len(p)
            vertices.append(p)
        if part:
            parts.setdefault(part, []).extend((a + base, b + base, c + base)
                                              for a, b, c in triangles)
    return np.round(np.concatenate(vertices), 2) + 0.0, parts


def write_obj(path, vertices, parts):
    lines = ["# SPDX-License-Identifier: MIT", "mtllib face.mtl"]
    lines += ["v %g %g %g" % tuple(v) for v in vertices]
    for part, triangles in parts.items():
        lines.append("usemtl " + part)
        lines += ["f %d %d %d" % (a + 1, b + 1, c + 1) for a, b, c in triangles]
    with open(path, "w", encoding="ascii") as out:
        out.write("\n".join(lines) + "\n")


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "face.mtl"), "w", encoding="ascii") as out:
        out.write("# SPDX-License-Identifier: MIT\n")
        for name, colour in COLOURS.items():
            out.write("newmtl %s\nKd %.4f %.4f %.4f\n" % (name, *(c / 255 for c in colour)))
    for name, pose in POSES.items():
        vertices, parts = assemble(pose)
        write_obj(os.path.join(here, name + ".obj"), vertices, parts)
    print("%d vertices, %d triangles, %d shapes" % (
        len(vertices), sum(map(len, parts.values())), len(POSES) - 1))


if __name__ == "__main__":
    main()
