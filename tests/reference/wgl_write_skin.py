#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the bones, skins, fields and paints of a clip file, and makes random ones: beside
wgl_write.py and wgl_write_shape.py.

    wgl_write_skin.py DIRECTORY             writes v1_skins.wgl and v1_skins.csv there
    wgl_write_skin.py seeds DIRECTORY       writes seeds for fuzzing, skins_METHOD.wgl

A file's dict has skins [dict(shape, method, ends, bones, spans)], fields [(channel, [(channel,
weight)])] and paints [dict(part, kind, width, height, palette, texels, step, corner)] beside what
wgl_write_shape says. A bone is dict(origin, frame, and parent, along, value, length, joints where
they are not none or 0), frame three rows; a joint is dict(kind, and channel, data, axis or, for
FOLLOW, bones). A span is a list of vertices, a vertex a list of (bone, weight, end).
"""
import math
import os
import random
import struct
import sys

import wgl
import wgl_skin
import wgl_write
import wgl_write_shape
from wgl_bones import (FOLLOW, MOVE, QUATERNION, STRETCH, TURN, TWIST_END, TWIST_START)
from wgl_shape import ABSENT
from wgl_skin import DUAL, FIELD, LINEAR, PICTURE, PLACE, SHIFT

ORDER = ((0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1), (0, 2), (1, 2), (2, 2))  # of F in 4.18
STRAIGHT = [[16384, 0, 0], [0, 16384, 0], [0, 0, 16384]]


# ---- bytes --------------------------------------------------------------------------------------
def joint_bytes(joint, data):
    at, count = joint.get("data", 0), 0
    if joint["kind"] == FOLLOW:
        at, count = data.put(bytes(joint["bones"]), 1), len(joint["bones"])
    return struct.pack("<BBHIiii", joint["kind"], count, joint.get("channel", 0), at,
                       *joint.get("axis", (0, 0, 0)))


def bone_bytes(bone, joint_first):
    return struct.pack("<HHBBHiiii10hxxxx", bone.get("parent", ABSENT), joint_first,
                       len(bone.get("joints", ())), bone.get("along", 0),
                       bone.get("value", ABSENT), *bone["origin"], bone.get("length", 0),
                       *(bone["frame"][r][c] for r, c in ORDER), 0)


def put_skins(file, data):
    """{kind: records}; what they point at goes into DATA."""
    out = {kind: [] for kind in range(18, 24)}
    for s in file["skins"]:
        bone_first, span_first, first = len(out[18]), len(out[21]), 0
        for bone in s["bones"]:
            out[18].append(bone_bytes(bone, len(out[19])))
            out[19] += [joint_bytes(joint, data) for joint in bone.get("joints", ())]
        for span in s["spans"]:
            flat = [x for vertex in span for influence in vertex
                    for x in influence[:3 if s["ends"] else 2]]
            out[21].append(struct.pack("<HHBxxxI", first, len(span), len(span[0]),
                                       data.put(bytes(flat), 1)))
            first += len(span)
        out[20].append(struct.pack("<HBBHHHHxxxx", s["shape"], s["method"], s["ends"], bone_first,
                                   len(s["bones"]), span_first, len(s["spans"])))
    for channel, means in file.get("fields", ()):
        channels, weights = zip(*means)
        at = data.put(struct.pack("<%dH" % len(means), *channels) + bytes(weights), 2)
        out[22].append(struct.pack("<HBxI", channel, len(means), at))
    for p in file.get("paints", ()):
        texels = data.put(p["texels"], 1) if "texels" in p else 0
        out[23].append(struct.pack("<HBxHHIIiii", p["part"], p["kind"], p.get("width", 0),
                                   p.get("height", 0), data.put(p["palette"], 1), texels,
                                   p.get("step", 0), *p.get("corner", (0, 0))))
    return out


# ---- random valid skins -------------------------------------------------------------------------
def any_unit(rng, one):
    v = [rng.gauss(0, 1) for _ in range(3)]
    return [round(x / math.hypot(*v) * one) for x in v]


def any_frame(rng, wild):
    if wild:
        return [[wgl_write.any_i16(rng, 0.2) for _ in range(3)] for _ in range(3)]
    a, b = any_unit(rng, 1 << 20), any_unit(rng, 1 << 20)
    rows = [a, cross(a, b)]
    rows.append(cross(*rows))
    return [[round(x / math.hypot(*row) * 16384) for x in row] for row in rows]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def any_place(rng, wild):
    """Of 6.9: raw units / 2^8."""
    if wild:
        return rng.choice((-1, 1)) * min(wgl_write.any_log(rng, 27), PLACE)
    return rng.randint(-3 << 20, 3 << 20)


def any_joint(rng, channels, wild):
    kind = rng.randrange(FOLLOW if channels >= 4 else QUATERNION)
    last = channels - (4 if kind == QUATERNION else 1)
    joint = {"kind": kind, "channel": rng.randint(0, last)}
    if kind in (TURN, TWIST_START, TWIST_END):
        joint["data"] = rng.choice((wgl_write.any_log(rng, 31), 1 << rng.randrange(31)))
    if kind in (TURN, MOVE):
        joint["axis"] = any_axis(rng, wild)
    return joint


def any_axis(rng, wild):
    """One of length 0 makes a TURN's quaternion as short as its cosine."""
    if not wild:
        return any_unit(rng, 1 << 30)
    if rng.random() < 0.2:
        return 0, 0, 0
    return [rng.choice((-1, 1)) * min(wgl_write.any_log(rng, 31), 1 << 30) for _ in range(3)]


def any_bones(rng, channels, wild):
    """Bones in trees, and some that stand alone, of which some follow others."""
    count = rng.choice((1, 2, 3, rng.randint(4, 20), rng.randint(4, 20), 256))
    loose = [rng.random() < 0.3 for _ in range(count)]
    alone = [i for i in range(count) if loose[i]]
    bones = []
    for i in range(count):
        parents = [j for j in range(max(0, i - 9), i) if not loose[j]]
        bone = {"origin": [any_place(rng, wild) for _ in range(3)], "frame": any_frame(rng, wild),
                "length": abs(any_place(rng, wild)), "along": rng.choice((0, 255, 127, 128,
                                                                          rng.randrange(256))),
                "value": rng.choice((ABSENT, rng.randrange(channels))),
                "joints": [any_joint(rng, channels, wild) for _ in range(rng.randint(0, 4))]}
        if parents and not loose[i] and rng.random() < 0.8:
            bone["parent"] = rng.choice(parents)
        if loose[i] and rng.random() < 0.6:
            bone["joints"].append({"kind": FOLLOW, "bones": [rng.choice(alone) for _ in
                                                             range(rng.randint(1, 8))]})
        bones.append(bone)
    return bones


def any_parts_of(rng, total, count):
    """`count` numbers >= 0 with a sum."""
    cuts = sorted(rng.choice((0, total, rng.randint(0, total))) for _ in range(count - 1))
    return [b - a for a, b in zip([0] + cuts, cuts + [total])]


def any_spans(rng, vertices, bones):
    out = []
    while vertices:
        count, influences = rng.randint(1, vertices), rng.randint(1, 8)
        out.append([[(rng.randrange(bones), w, rng.choice((0, 255, rng.randrange(256))))
                     for w in any_parts_of(rng, 255, influences)] for _ in range(count)])
        vertices -= count
    return out


def any_skin(rng, shape, vertices, channels):
    method, wild = rng.choice((LINEAR, LINEAR, DUAL, SHIFT)), rng.random() < 0.4
    bones = any_bones(rng, channels, wild)
    return {"shape": shape, "method": method, "ends": rng.randrange(2) if method != SHIFT else 0,
            "bones": bones, "spans": any_spans(rng, vertices, len(bones))}


def any_field(rng, channels):
    weights = any_parts_of(rng, 255, rng.choice((1, 2, 8, 255)))
    return rng.randrange(channels), [(rng.randrange(channels), w) for w in weights]


def any_paint(rng, part, skinned):
    paint = {"part": part, "kind": rng.choice((FIELD, PICTURE)) if skinned else PICTURE,
             "palette": rng.randbytes(768)}
    if paint["kind"] == PICTURE or rng.random() < 0.2:
        paint["width"], paint["height"] = (rng.choice((1, 2, rng.randint(3, 40), 1024))
                                           for _ in range(2))
        if paint["width"] * paint["height"] > 4000:
            paint["height"] = 1
        paint["texels"] = rng.randbytes(paint["width"] * paint["height"])
        paint["step"] = wgl.s32(wgl_write.any_log(rng, 32))
        paint["corner"] = [rng.randint(-1 << 31, (1 << 31) - 1) for _ in range(2)]
    return paint


def random_values(rng, file):
    """As for shapes; some are powers of two, which make quarter turns."""
    values = wgl_write_shape.random_values(rng, file)
    return [v if rng.random() < 0.7 else rng.choice((-1, 1)) << rng.randrange(30) for v in values]


def random_skin_file(rng):
    """A valid file with shapes of which most have skins."""
    file = wgl_write_shape.random_shape_file(rng)
    channels, skinned = len(file["channels"]), set()
    file["skins"] = []
    for i, shape in enumerate(file["shapes"]):
        if i == 0 or rng.random() < 0.7:
            skinned.add(i)
            shape["affine"] = ABSENT
            if rng.random() < 0.5:  # a shape near its bones
                shape["origin"] = [rng.randint(-9000, 9000) for _ in range(3)]
            file["skins"].append(any_skin(rng, i, len(shape["rest"]) // 3, channels))
    for part in file["parts"]:
        if part["shape"] in skinned:
            part["normals"] = ABSENT
    file["fields"] = [any_field(rng, channels) for _ in range(rng.choice((0, 1, 2, 5)))]
    file["paints"] = [any_paint(rng, i, part["shape"] in skinned)
                      for i, part in enumerate(file["parts"]) if rng.random() < 0.5]
    rng.shuffle(file["skins"])
    return file


# ---- the golden file ----------------------------------------------------------------------------
TICKS = wgl_write_shape.TICKS
ONE = 1 << 12  # of most channels below


def tube(rings, radius, length):
    """Rings of four along x: rest, and how far along each vertex is."""
    rest, along = [], []
    for ring in range(rings):
        for y, z in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            rest += [length * ring // (rings - 1), radius * y, radius * z]
            along.append(ring / (rings - 1))
    return rest, along


def blend(along, bones):
    """A vertex between two neighbours of a chain of `bones` equal ones, with endpoint weights."""
    at = min(max(along * bones - 0.5, 0), bones - 1)
    i = min(int(at), max(bones - 2, 0))
    w = 255 - round(255 * (at - i))
    ends = [round(255 * min(max(along * bones - j, 0), 1)) for j in (i, i + 1)]
    if bones == 1 or w == 255:
        return [(i, 255, ends[0])]
    return [(i, w, ends[0]), (i + 1, 255 - w, ends[1])]


def by_influences(vertices):
    """Spans of vertices with equally many influences."""
    spans = []
    for vertex in vertices:
        if spans and len(spans[-1][0]) == len(vertex):
            spans[-1].append(vertex)
        else:
            spans.append([vertex])
    return spans


def chain(lengths, origin, joints):
    """Bones along x, each at the end of the one before; `joints` of each."""
    bones, x = [], origin[0]
    for i, (length, own) in enumerate(zip(lengths, joints)):
        bones.append({"origin": [x << 8, origin[1] << 8, origin[2] << 8], "length": length << 8,
                      "frame": STRAIGHT, "joints": own, "along": 255})
        if i:
            bones[-1]["parent"] = i - 1
        x += length
    return bones


def turn(channel, axis):
    """By degrees of which a raw unit is 2^-12."""
    return {"kind": TURN, "channel": channel, "data": round(2 ** 36 / 360), "axis": axis}


def twist(kind, channel):
    """By degrees of which a raw unit is 2^-8."""
    return {"kind": kind, "channel": channel, "data": round(2 ** 32 / 360)}


def plain(kind, channel, axis=(0, 0, 0)):
    return {"kind": kind, "channel": channel, "axis": axis}


X, Y, Z = ([(1 << 30) * (i == j) for j in range(3)] for i in range(3))


def golden_tubes():
    """An arm that stretches, twists by several turns and bends, with a basis below (LINEAR with
    ends); a tail that rolls up (DUAL with ends); legs turned by quaternions (LINEAR, DUAL)."""
    shapes, skins = [], []
    stretched = [plain(STRETCH, 4), twist(TWIST_START, 5), twist(TWIST_END, 6)]
    joints = {LINEAR: [[plain(MOVE, 3, Y), turn(0, Z)], stretched, [turn(1, Z), turn(2, X)]],
              DUAL: [[turn(1, Y)], stretched, [turn(0, Z), twist(TWIST_END, 5)]]}
    for method in (LINEAR, DUAL):
        rest, along = tube(7, 500, 6000)
        swell = [v if i % 3 else 0 for i, v in enumerate(rest)]
        shapes.append({"frac": 6, "origin": (100, 3000 * method, -50), "rest": rest,
                       "bases": [(7, 32767, 1)],
                       "blocks": [{"a": 0, "first": 8, "bits": 16, "e": swell[24:60]}]})
        bones = chain((2000, 2000, 2000), shapes[-1]["origin"], joints[method])
        bones.append({"origin": [(100 + 3000) << 8, (3000 * method + 500) << 8, -50 << 8],
                      "frame": [[0, 16384, 0], [-16384, 0, 0], [0, 0, 16384]], "length": 500 << 8,
                      "parent": 1, "along": 128, "joints": [plain(STRETCH, 4)], "value": 7})
        vertices = [blend(t, 3) for t in along]
        vertices[12] = [(3, 100, 20), (1, 155, 128)]
        skins.append({"shape": len(shapes) - 1, "method": method, "ends": 1, "bones": bones,
                      "spans": by_influences(vertices)})
    for method in (LINEAR, DUAL):
        rest, along = tube(4, 300, 3000)
        shapes.append({"frac": 6, "origin": (0, -3000 - 1500 * method, 0), "rest": rest,
                       "bases": [], "blocks": []})
        bones = chain((1500, 1500), shapes[-1]["origin"],
                      [[turn(0, Y)], [plain(QUATERNION, 8), twist(TWIST_END, 6)]])
        skins.append({"shape": len(shapes) - 1, "method": method, "ends": 0, "bones": bones,
                      "spans": by_influences([blend(t, 2) for t in along])})
    return shapes, skins


def golden_sheets():
    """A sheet in a cage whose corners follow their neighbours, lit by a field; one in layers."""
    places = [(x, y, 0) for y in (-900, 0, 900) for x in (-1200, 0, 1200)]
    rest = [v for place in places for v in place]
    corners = [v for i in (0, 1, 3, 4) for v in (i, i + 1, i + 4, i, i + 4, i + 3)]
    sheet = {"frac": 6, "rest": rest, "bases": [], "blocks": []}
    cage = [{"origin": [x << 8, y << 8, 0], "frame": STRAIGHT, "value": 8 + i % 2,
             "joints": [plain(MOVE, 3 + i % 2, Y), plain(MOVE, 11, Z)][:1 + i % 2]
             + [{"kind": FOLLOW, "bones": [(i + 1) % 4, (i + 3) % 4, i]}]}
            for i, (x, y) in enumerate(((-1200, -900), (1200, -900), (1200, 900), (-1200, 900)))]
    mean = [[(0, 64, 0), (1, 64, 0), (2, 64, 0), (3, 63, 0)]] * 9
    near = [[(0, 255, 0)], [(0, 127, 0), (1, 128, 0)], [(1, 255, 0)]] * 3
    layers = [{"origin": [0, 0, 0], "frame": STRAIGHT, "joints": [plain(MOVE, 12, Z)]},
              {"origin": [5, -7, 11], "frame": STRAIGHT, "joints": [plain(MOVE, 11, Z)]}]
    skins = [{"shape": 4, "method": LINEAR, "ends": 0, "bones": cage,
              "spans": [mean[:5], mean[5:]]},
             {"shape": 5, "method": SHIFT, "ends": 0, "bones": layers,
              "spans": by_influences(near)}]
    parts = [{"shape": 4, "corners": corners, "sides": 1, "colour": (200, 60, 60)},
             {"shape": 5, "corners": corners, "sides": 1, "colour": (60, 200, 60)}]
    palette = bytes(v for i in range(256) for v in (i, 255 - i, i // 2))
    paints = [{"part": 0, "kind": FIELD, "palette": palette},
              {"part": 1, "kind": PICTURE, "palette": palette, "width": 6, "height": 5,
               "texels": bytes(7 * i % 256 for i in range(30)), "step": (5 << 26) // 2400,
               "corner": (3 << 16, (5 << 16) // 2)}]
    return [sheet, {**sheet, "origin": (0, 0, -400)}], skins, parts, paints


def golden():
    (shapes, skins), (sheets, more, parts, paints) = golden_tubes(), golden_sheets()
    swing, half = wgl_write_shape.swing, ONE // 2
    tracks = [swing(c, 5, *(128 * d for d in degrees)) for c, degrees in enumerate(
        ((0, 60, -100), (0, -50, 80), (0, 200, -20)))]
    tracks += [swing(c, 4, *(16 * d for d in degrees)) for c, degrees in (
        (5, (0, 90, -45)), (6, (0, -360, 1080)))]
    tracks += [swing(3, 5, 0, ONE, -half), swing(4, 0, ONE, 2 * ONE, half),
               swing(7, 5, 0, ONE, -ONE), swing(8, 0, ONE, half, -ONE), swing(9, 0, 0, half, 0),
               swing(11, 5, 0, ONE, half), swing(12, 5, half, -half, ONE)]
    channels = [(8 if i in (5, 6) else 12, 0, ONE if i in (4, 8) else 0) for i in range(13)]
    channels += [(17, 0, 0), (5, 0, 0)] + [(9, 3, v << 9) for v in (0, 0, 0, 20, 0, 0, 900, 250)]
    tracks.sort(key=lambda track: track[0])
    return {"channels": channels,
            "clips": [{"rate": 60, "ticks": TICKS, "end": wgl.LOOP, "tracks": tracks}],
            "layers": [(0, 0, 255, 32768)], "shapes": shapes + sheets, "skins": skins + more,
            "servos": [(1, 0, 0, 6000 << 8, 20480, 15, 4000, 8000, 0, 0)],
            "parts": parts, "paints": paints,
            "views": [(0, 1, 60, (40, 80, 90), (8, 8, 20), list(range(15, 23)))],
            "fields": [(13, [(11, 100), (12, 155)]), (14, [(13, 0), (0, 200), (4, 55)])]}


def main(folder):
    blob = wgl_write.build(golden())
    with open(os.path.join(folder, "v1_skins.wgl"), "wb") as out:
        out.write(blob)
    with open(os.path.join(folder, "v1_skins.csv"), "w", encoding="ascii") as out:
        for row in wgl_skin.pose_rows(wgl.Clip(blob), 0, 370000):
            out.write(",".join(map(str, row)) + "\n")


def seeds(folder):
    """The first small random file of each method that has a FOLLOW, a field and a paint."""
    names = {(LINEAR, 0): "linear", (LINEAR, 1): "ends", (DUAL, 1): "dual", (SHIFT, 0): "shift"}
    for n in range(100000):
        file = random_skin_file(random.Random("seed %d" % n))
        kinds = {joint["kind"] for s in file["skins"] for bone in s["bones"]
                 for joint in bone["joints"]}
        key = file["skins"][0]["method"], file["skins"][0]["ends"]
        if key not in names or FOLLOW not in kinds or len(file["skins"]) > 1:
            continue
        blob = wgl_write.build(file) if file["fields"] and file["paints"] else None
        if blob and len(blob) < 4000:
            with open(os.path.join(folder, "skins_%s.wgl" % names.pop(key)), "wb") as out:
                out.write(blob)
        if not names:
            return


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "seeds":
        seeds(sys.argv[2])
    elif len(sys.argv) == 2:
        main(sys.argv[1])
    else:
        sys.exit(__doc__)
