#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the shapes of a clip file, and makes random ones: the other half of wgl_write.py.

    wgl_write_shape.py DIRECTORY            writes v1_shapes.wgl and v1_shapes.csv there
    wgl_write_shape.py cost BITS FILE       writes what tests/fw_pose.c measures: 16 dense bases

A file's dict has shapes [dict(frac, origin, rest, bases, blocks, affine)], parts [dict(shape,
normals, corners, sides, colour)] and views [(projection, shading, ambient, light, background,
channels)] beside what wgl_write says. rest and the components of blocks are flat: x, y, z, x, ..
A basis is (channel, gain, gain_shift), a block dict(a, first, bits, e) and, for a pair, b, f.
"""
import math
import os
import random
import struct
import sys

import wgl
import wgl_shape
import wgl_write

ABSENT = wgl_shape.ABSENT
TICKS = 120  # of the golden clip


# ---- bytes --------------------------------------------------------------------------------------
def block_bytes(block):
    """4.15: components of one basis, or of two in turns."""
    letter = "b" if block["bits"] == 8 else "h"
    e, f = list(block["e"]), block.get("f")
    if f is None:
        return struct.pack("<%d%s" % (len(e), letter), *e)
    group, flat = (2 if block["bits"] == 8 else 1), []
    e, f = e + [0] * (len(e) % group), list(f) + [0] * (len(f) % group)
    for i in range(0, len(e), group):
        flat += e[i:i + group] + f[i:i + group]
    return struct.pack("<%d%s" % (len(flat), letter), *flat)


def put_shapes(file, data):
    """{kind: records}; what they point at goes into DATA."""
    out = {kind: [] for kind in range(13, 18)}
    for s in file["shapes"]:
        rest = data.put(struct.pack("<%dh" % len(s["rest"]), *s["rest"]), 4)
        out[13].append(struct.pack(
            "<HbxHHHHHxxIiii", len(s["rest"]) // 3, s["frac"], len(out[14]), len(s["bases"]),
            len(out[15]), len(s["blocks"]), s.get("affine", ABSENT), rest,
            *s.get("origin", (0, 0, 0))))
        out[14] += [struct.pack("<HhBxxx", *basis) for basis in s["bases"]]
        out[15] += [struct.pack("<HHHHBxxxI", b["a"], b.get("b", ABSENT), b["first"],
                                len(b["e"]) // 3, b["bits"], data.put(block_bytes(b), 4))
                    for b in s["blocks"]]
    for p in file.get("parts", ()):
        at = data.put(struct.pack("<%dH" % len(p["corners"]), *p["corners"]), 2)
        out[16].append(struct.pack("<HHHBxBBBxI", p["shape"], p.get("normals", ABSENT),
                                   len(p["corners"]) // 3, p.get("sides", 0), *p["colour"], at))
    for projection, shading, ambient, light, background, channels in file.get("views", ()):
        out[17].append(struct.pack("<BBBxbbbxBBBx8H", projection, shading, ambient, *light,
                                   *background, *channels))
    return out


# ---- random valid shapes ------------------------------------------------------------------------
def any_block(rng, vertices, bases):
    first = rng.randrange(vertices)
    count = 3 * rng.choice((1, vertices - first, rng.randint(1, vertices - first)))
    block = {"a": rng.randrange(bases), "first": first, "bits": rng.choice((8, 16))}
    half, wild = 1 << block["bits"] - 1, rng.random() < 0.2

    def component():
        return rng.choice((-half, half - 1)) if wild else rng.randint(-half, half - 1)
    block["e"] = [component() for _ in range(count)]
    if rng.random() < 0.6:
        block["b"] = rng.randrange(bases)  # a again, sometimes: 4.15 does not forbid it
        block["f"] = [component() for _ in range(count)]
    return block


def any_shape(rng, channels, vertices):
    bases = rng.choice((0, 1, 2, rng.randint(3, 20), 128))
    wild = rng.choice((0.02, 0.3))
    return {"frac": rng.randint(-8, 20), "rest": [wgl_write.any_i16(rng, wild)
                                                  for _ in range(3 * vertices)],
            "origin": [wgl_write.any_limit(rng) for _ in range(3)],
            "bases": [(rng.randrange(channels), wgl_write.any_i16(rng, 0.1), rng.randint(1, 15))
                      for _ in range(bases)],
            "blocks": [any_block(rng, vertices, bases)
                       for _ in range(rng.randint(0, 12) if bases else 0)],
            "affine": rng.choice((ABSENT, rng.randint(0, channels - 12)))
            if channels >= 12 else ABSENT}


def random_shape_file(rng):
    """A valid file with shapes, parts and views. Shapes come in couples of as many vertices."""
    channels = rng.choice((1, 5, 12, 20))
    file = wgl_write.random_file(rng, channels)
    file["channels"] = [(rng.choice((f, rng.randint(0, 24))), unit, rest)
                        for f, unit, rest in file["channels"]]
    file["shapes"] = []
    for _ in range(rng.randint(1, 2)):
        vertices = rng.choice((1, 2, 3, rng.randint(4, 60)))
        file["shapes"] += [any_shape(rng, channels, vertices) for _ in range(rng.randint(1, 2))]
    file["parts"] = [any_part(rng, file["shapes"]) for _ in range(rng.randint(0, 3))]
    file["views"] = [(rng.randrange(2), rng.randrange(3), rng.randrange(256),
                      [rng.randint(-128, 127) for _ in range(3)],
                      [rng.randrange(256) for _ in range(3)],
                      [rng.randrange(channels) for _ in range(8)])
                     for _ in range(rng.randint(0, 2))]
    return file


def any_part(rng, shapes):
    shape = rng.randrange(len(shapes))
    size = len(shapes[shape]["rest"])
    normals = [i for i, s in enumerate(shapes) if len(s["rest"]) == size] + [ABSENT]
    return {"shape": shape, "normals": rng.choice(normals), "sides": rng.randrange(2),
            "colour": [rng.randrange(256) for _ in range(3)],
            "corners": [rng.randrange(size // 3) for _ in range(3 * rng.randint(1, 9))]}


def random_values(rng, file):
    """Raw channel values: of all sizes, or about 1 in their unit, as affine entries are."""
    kind = rng.randrange(3)
    if kind == 0:
        return [rng.choice((-1, 1)) * min(wgl_write.any_log(rng, 30), 1 << 29)
                for _ in file["channels"]]
    most = rng.choice((0.6, 1.4, 4, 40, 300)) if kind == 1 else 1.0
    return [max(-1 << 29, min(1 << 29, round(rng.uniform(-most, most) * 2.0 ** frac)))
            for frac, _, _ in file["channels"]]


# ---- the golden file ----------------------------------------------------------------------------
def icosphere():
    """Unit sphere: 42 vertices, 80 triangles counter-clockwise from outside."""
    g = (1 + math.sqrt(5)) / 2
    points = [p for a in (-1, 1) for b in (-g, g) for p in ((0, a, b), (a, b, 0), (b, 0, a))]
    side = 2.0
    faces = [(i, j, k) for i in range(12) for j in range(i + 1, 12) for k in range(j + 1, 12)
             if all(abs(math.dist(points[a], points[b]) - side) < 1e-9
                    for a, b in ((i, j), (j, k), (k, i)))]
    middle, corners = {}, []
    for i, j, k in faces:
        if determinant(points[i], points[j], points[k]) < 0:
            j, k = k, j
        m = []
        for a, b in ((i, j), (j, k), (k, i)):
            key = min(a, b), max(a, b)
            if key not in middle:
                middle[key] = len(points)
                points.append([x + y for x, y in zip(points[a], points[b])])
            m.append(middle[key])
        corners += [i, m[0], m[2], j, m[1], m[0], k, m[2], m[1], *m]
    return [[x / math.hypot(*p) for x in p] for p in points], corners


def determinant(a, b, c):
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))


def swing(channel, shift, *values):
    """A track of two cubic segments with level ends: raw values / 2^shift."""
    return channel, [{"kind": wgl.CUBIC, "ends": [TICKS // 2, TICKS], "shift": shift,
                      "c": [c for value in values for c in (value, 0)]}]


def golden_shapes(points, corners):
    """A ball that pulsates, bulges and leans, with blocks of every kind; its normals bend with it.
    Below it a plate without bases."""
    def flat(f, size, subset=points):
        return [round(size * x) for p in subset for x in f(*p)]
    order = sorted(range(42), key=lambda i: -points[i][1])  # the upper half first
    rank = {old: new for new, old in enumerate(order)}
    points, corners = [points[i] for i in order], [rank[i] for i in corners]
    upper = [p for p in points if p[1] > 0.3]
    lower = points[len(points) - 17:]
    bases = [(0, 32767, 1), (1, 32767, 1), (2, 32767, 1), (3, 32767, 2), (4, -32767, 1)]
    ball = {"frac": 9, "origin": (-512, 1024, 256), "affine": 5, "bases": bases,
            "rest": flat(lambda *p: p, 10000, points),
            "blocks": [
                {"a": 0, "b": 1, "first": 0, "bits": 16,
                 "e": flat(lambda *p: p, 5000, points),
                 "f": flat(lambda x, y, z: (x * y, -y, z * y), 6000, points)},
                {"a": 2, "b": 3, "first": 0, "bits": 8,
                 "e": flat(lambda x, y, z: (x * y, y * y, z * y), 40, upper),
                 "f": flat(lambda x, y, z: (0, y, 0), 30, upper)},
                {"a": 3, "first": 25, "bits": 8,
                 "e": flat(lambda x, y, z: (-z, 0, x), 30, lower)},
                {"a": 4, "first": 25, "bits": 16,
                 "e": flat(lambda x, y, z: (y, -x, 0), 4000, lower)}]}
    normals = {"frac": 14, "rest": flat(lambda *p: p, 16384, points), "bases": bases,
               "blocks": [{"a": 1, "first": 0, "bits": 8,
                           "e": flat(lambda x, y, z: (-x * y, y * y, -z * y), 60, points)}]}
    plate = {"frac": 9, "origin": (0, -13000, 0), "bases": [], "blocks": [],
             "rest": [-16000, 0, -16000, -16000, 0, 16000, 16000, 0, 16000, 16000, 0, -16000]}
    parts = [{"shape": 0, "normals": 1, "corners": corners, "colour": (230, 120, 40)},
             {"shape": 2, "corners": [0, 1, 2, 0, 2, 3], "sides": 1, "colour": (60, 70, 110)}]
    return [ball, normals, plate], parts


def golden():
    shapes, parts = golden_shapes(*icosphere())
    one = 1 << 14
    unit = [(14, 0, one if i % 4 == 0 and i < 9 else 0) for i in range(9)]
    views = [(10, 1, v << 10) for v in (25, 20, 0)] + [(9, 3, v << 9) for v in (0, -4, 0, 160, 80)]
    tracks = [swing(i, 3, *rows) for i, rows in enumerate(  # weights: 1 is 2^17
        [(0, 9000, -9000), (-9000, 0, 9000), (0, 12000, 0), (9000, -9000, 0), (0, 16384, 0)])]
    turn = [(0, one, 11585, 0), (2, 0, 11585, one), (6, 0, -11585, -one), (8, one, 11585, 0)]
    tracks += [swing(5 + i, 0, *rows) for i, *rows in turn]
    tracks += [swing(14, 0, 0, 2000, -3000), swing(17, 2, 25 << 8, 90 << 8, 25 << 8)]
    return {"channels": [(17, 0, 0)] * 5 + unit + [(9, 3, 0)] * 3 + views,
            "clips": [{"rate": 60, "ticks": TICKS, "end": wgl.PINGPONG, "tracks": tracks}],
            "layers": [(0, 0, 255, 32768)], "shapes": shapes, "parts": parts,
            "servos": [(1, 0, 0, 6000 << 8, 16384, 12, 4000, 8000, 0, 0)],
            "views": [(0, 2, 60, (40, 80, 90), (8, 8, 20), list(range(17, 25))),
                      (1, 0, 60, (0, 0, 127), (0, 0, 0), list(range(17, 25)))]}


def cost_clip(bits):
    """192 vertices, 16 bases in 8 dense pairs, and weights that are never 0."""
    rng, k, vertices = random.Random(1), 16, 192
    half = 1 << bits - 1
    blocks = [{"a": 2 * i, "b": 2 * i + 1, "first": 0, "bits": bits,
               "e": [rng.randint(-half, half - 1) for _ in range(3 * vertices)],
               "f": [rng.randint(-half, half - 1) for _ in range(3 * vertices)]}
              for i in range(k // 2)]
    shape = {"frac": 8, "rest": [rng.randint(-20000, 20000) for _ in range(3 * vertices)],
             "bases": [(i, 16384, 3) for i in range(k)], "blocks": blocks}
    return {"channels": [(17, 0, 90000 - 5000 * i) for i in range(k)], "shapes": [shape],
            "clips": [{"rate": 60, "ticks": 60, "tracks": []}], "layers": [(0, 0, 255, 32768)]}


def main(folder):
    blob = wgl_write.build(golden())
    with open(os.path.join(folder, "v1_shapes.wgl"), "wb") as out:
        out.write(blob)
    with open(os.path.join(folder, "v1_shapes.csv"), "w", encoding="ascii") as out:
        for row in wgl_shape.pose_rows(wgl.Clip(blob), 0, 370000):
            out.write(",".join(map(str, row)) + "\n")


if __name__ == "__main__":
    if len(sys.argv) == 4 and sys.argv[1] == "cost":
        with open(sys.argv[3], "wb") as output:
            output.write(wgl_write.build(cost_clip(int(sys.argv[2]))))
    elif len(sys.argv) == 2:
        main(sys.argv[1])
    else:
        sys.exit(__doc__)
