# SPDX-License-Identifier: AGPL-3.0-or-later
"""Small clips with a mesh, for the tests that look at pictures: written from SPEC.md by tests/reference, without
the baker.

An egg with a nose turns once in two seconds (clip turn, loops), wags to both sides (basis 0), is puffed up by a
layer that adds (clip puff, ends after one second; basis 1) and, a trigger wants it so, jumps (basis 2) from 0.5 s on.
"""
import math
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tests", "reference"))
import wgl  # noqa: E402
import wgl_write  # noqa: E402

FRAC, DEGREES, LENGTH = 18, 8, 8  # of weights, angles, lengths
WAG, PUFF, JUMP, YAW, PITCH, ROLL, X, Y, Z, DISTANCE, SIZE = range(11)
YAW_REST, PITCH_REST = 20, 15
SKIN, NOSE, GROUND = (250, 200, 60), (220, 40, 30), (10, 20, 60)
RINGS, AROUND = 9, 12


def egg():
    """Positions in units of length, and triangles, counter-clockwise from outside."""
    points, corners = [(0, -40, 0)], []
    for ring in range(1, RINGS):
        a = math.pi * ring / RINGS
        for k in range(AROUND):
            b = 2 * math.pi * k / AROUND
            points.append((28 * math.sin(a) * math.sin(b), -40 * math.cos(a), 28 * math.sin(a) * math.cos(b)))
    points.append((0, 40, 0))
    top = len(points) - 1

    def at(ring, k):
        return 0 if ring == 0 else top if ring == RINGS else 1 + (ring - 1) * AROUND + k % AROUND
    for ring in range(RINGS):
        for k in range(AROUND):
            if ring > 0:
                corners += [at(ring, k), at(ring, k + 1), at(ring + 1, k)]
            if ring < RINGS - 1:
                corners += [at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)]
    return points, corners


def raw(points):
    return [round(c * 2 ** LENGTH) for p in points for c in p]


def nose(first):
    """A pyramid on the side that looks along z."""
    points = [(-6, -6, 24), (6, -6, 24), (6, 6, 24), (-6, 6, 24), (0, 0, 44)]
    return points, [first + i for i in (0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4)]


def linear(ends, values, base=0):
    return [dict(kind=wgl.LINEAR, ends=ends, c=values, shift=7, base=base)]


def degrees(value):
    return round(value * 2 ** DEGREES)


def mesh():
    points, corners = egg()
    more, tip = nose(len(points))
    points += more
    rest = raw(points)
    wag = raw([(p[1] / 2, 0, 0) for p in points])
    puff = raw([(p[0] / 2, 0, p[2] / 2) for p in points])
    jump = raw([(0, 20, 0) for p in points])
    shape = dict(frac=LENGTH, rest=rest,
                 bases=[(WAG, 16383, 1), (PUFF, 16383, 1), (JUMP, 16383, 1)],
                 blocks=[dict(a=0, b=1, first=0, bits=16, e=wag, f=puff), dict(a=2, first=0, bits=16, e=jump)])
    return shape, [dict(shape=0, corners=corners, colour=SKIN), dict(shape=0, corners=tip, colour=NOSE, sides=1)]


def show(yaw=0, pitch=0, size=120, layers=True):
    """A file for wgl_write.build; yaw and pitch add to the rest of view 0, whose clip adds to that."""
    one = 1 << FRAC - 7  # of a weight, in units of shift 7
    shape, parts = mesh()
    turn = linear([2000], [0, 360 * 2 ** DEGREES >> 7], degrees(YAW_REST + yaw))
    file = {
        "channels": [(FRAC, 0, 0)] * 3 + [(DEGREES, 1, degrees(YAW_REST + yaw)), (DEGREES, 1, degrees(PITCH_REST + pitch)),
                                          (DEGREES, 1, 0)] + [(LENGTH, 3, 0)] * 3 +
                    [(LENGTH, 3, 300 << LENGTH), (LENGTH, 3, round(size * 2 ** LENGTH))],
        "clips": [
            dict(rate=1000, ticks=2000, end=wgl.LOOP, events=[(500, 0)],
                 tracks=[(WAG, linear([500, 1500, 2000], [0, one, -one, 0])), (YAW, turn)]),
            dict(rate=1000, ticks=1000, end=wgl.HOLD, tracks=[(PUFF, linear([1000], [0, one]))]),
            dict(rate=1000, ticks=400, end=wgl.HOLD, tracks=[(JUMP, linear([200, 400], [0, one, 0]))])],
        "names": [b"wag", b"puff", b"jump", b"yaw", b"pitch", b"roll", b"x", b"y", b"z", b"distance", b"size",
                  b"turn", b"puff", b"jump", b"base", b"over", b"act", b"now"],
        "shapes": [shape], "parts": parts,
        "views": [(0, 1, 60, (40, 70, 90), GROUND, range(YAW, SIZE + 1)),
                  (1, 2, 90, (0, 80, 90), (255, 255, 255), range(YAW, SIZE + 1))]}
    if layers:
        file["layers"] = [(0, 0, 255, 32768), (1, 1, 255, 32768), (255, 0, 255, 32768)]
        file["triggers"] = [(0, 2, 2, 100)]
    else:
        file["names"] = file["names"][:14] + file["names"][17:]
    return file


def write(path, file):
    with open(path, "wb") as f:
        f.write(wgl_write.build(file))
    return path
