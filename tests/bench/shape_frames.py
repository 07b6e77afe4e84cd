# SPDX-License-Identifier: MIT
"""Animated meshes for the benchmark of shapes: readers of MD2, MD3 and glTF morph targets, and two
sequences computed here. Independent of the baker's loader.

Source: file layouts of Quake II and III, glTF 2.0; beam modes: Euler-Bernoulli cantilever.
"""
import json
import math
import os
import struct
import zipfile

import numpy as np

ASSIMP = "/usr/share/assimp/models"
OPENARENA = "/usr/share/games/openarena/baseoa/pak0.pk3"
SARGE = "models/players/sarge/lower.md3"


class Sequence:
    """frames: n x m x 3, vertices welded as the baker does; triangles: t x 3; steps: n x 3, the
    spacing of the coordinates that the file can express, 0 where they are floats."""

    def __init__(self, name, frames, triangles, **more):
        self.name, self.rate = name, more.get("rate", 30.0)
        self.up, self.file = more.get("up", "y"), more.get("file")
        self.frames, self.triangles, self.rest = weld(np.asarray(frames, np.float64),
                                                      np.asarray(triangles, np.int64))
        sides = np.ptp(self.frames.reshape(-1, 3), axis=0)
        self.diagonal = float(np.linalg.norm(sides))
        self.height = float(np.ptp(self.frames[0], axis=0).max())
        self.steps = np.broadcast_to(more.get("steps", 0.0), (len(frames), 3))

    @property
    def count(self):
        return self.frames.shape[0]

    @property
    def vertices(self):
        return self.frames.shape[1]


def weld(frames, triangles):
    """Vertices that coincide in every frame are one; degenerate triangles, unused vertices go."""
    flat = np.ascontiguousarray(frames.transpose(1, 0, 2).reshape(frames.shape[1], -1))
    _, first, inverse = np.unique(flat, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # the file's order, not that of the values
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    triangles = rank[inverse.reshape(-1)][triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    used = np.unique(triangles)
    where = np.full(len(order), -1)
    where[used] = np.arange(len(used))
    kept = first[order][used]
    return frames[:, kept], where[triangles], kept


def read_md2(path, name):
    with open(path, "rb") as f:
        data = f.read()
    head = struct.unpack_from("<4s16i", data)
    assert head[0] == b"IDP2" and head[1] == 8
    size, points, faces, count = head[4], head[6], head[8], head[10]
    face_at, frame_at = head[13], head[14]
    corners = np.frombuffer(data, "<i2", faces * 6, face_at).reshape(faces, 6)[:, :3]
    frames, steps = [], []
    for i in range(count):
        at = frame_at + i * size
        scale, move = np.frombuffer(data, "<f4", 6, at).reshape(2, 3)
        raw = np.frombuffer(data, "u1", points * 4, at + 40).reshape(points, 4)[:, :3]
        frames.append(raw * scale.astype(np.float64) + move)
        steps.append(scale)
    # clockwise seen from outside: turned around here
    return Sequence(name, frames, corners[:, ::-1], rate=9.0, up="z", file=path,
                    steps=np.array(steps))


def read_md3(path, name):
    with open(path, "rb") as f:
        data = f.read()
    head = struct.unpack_from("<4si64s9i", data)
    assert head[0] == b"IDP3" and head[1] == 15
    count, surfaces, at = head[4], head[6], head[10]
    parts, faces, base = [], [], 0
    for _ in range(surfaces):
        s = struct.unpack_from("<4s64s10i", data, at)
        assert s[0] == b"IDP3"
        points, triangles, face_at, xyz_at, end = s[5], s[6], s[7], s[10], s[11]
        raw = np.frombuffer(data, "<i2", count * points * 4, at + xyz_at)
        parts.append(raw.reshape(count, points, 4)[:, :, :3] / 64.0)
        corners = np.frombuffer(data, "<i4", triangles * 3, at + face_at).reshape(triangles, 3)
        faces.append(corners[:, ::-1] + base)
        base, at = base + points, at + end
    return Sequence(name, np.concatenate(parts, 1), np.concatenate(faces), rate=15.0, up="z",
                    file=path, steps=1 / 64)


def gltf_array(document, folder, index):
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    with open(os.path.join(folder, document["buffers"][view["buffer"]]["uri"]), "rb") as f:
        data = f.read()
    kind = {5126: "<f4", 5125: "<u4", 5123: "<u2"}[accessor["componentType"]]
    width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
    at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return np.frombuffer(data, kind, accessor["count"] * width, at).reshape(-1, width)


def read_gltf(path, name, rate=30.0):
    """The first mesh and the first animation's weights, linear between their keys."""
    folder = os.path.dirname(path)
    with open(path) as f:
        document = json.load(f)
    part = document["meshes"][0]["primitives"][0]
    base = gltf_array(document, folder, part["attributes"]["POSITION"]).astype(np.float64)
    targets = [gltf_array(document, folder, t["POSITION"]) for t in part["targets"]]
    sampler = document["animations"][0]["samplers"][0]
    times = gltf_array(document, folder, sampler["input"])[:, 0]
    keys = gltf_array(document, folder, sampler["output"]).reshape(len(times), len(targets))
    at = np.arange(int(math.floor(times[-1] * rate + 1e-6)) + 1) / rate
    weights = np.stack([np.interp(at, times, keys[:, j]) for j in range(len(targets))], 1)
    frames = base + np.einsum("nj,jmc->nmc", weights, np.array(targets, np.float64))
    corners = gltf_array(document, folder, part["indices"]).reshape(-1, 3)
    return Sequence(name, frames, corners, rate=rate, file=path)


def grid_triangles(rows, columns, closed):
    """Of rows x columns vertices; closed: the last column meets the first."""
    out = []
    for r in range(rows - 1):
        for c in range(columns if closed else columns - 1):
            a, b = r * columns + c, r * columns + (c + 1) % columns
            out += [(a, b + columns, b), (a, a + columns, b + columns)]
    return out


def beam_mode(beta, s):
    """Shape and slope of a cantilever's mode at s in [0, 1], 1 at its free end."""
    k = (math.cosh(beta) + math.cos(beta)) / (math.sinh(beta) + math.sin(beta))
    shape = np.cosh(beta * s) - np.cos(beta * s) - k * (np.sinh(beta * s) - np.sin(beta * s))
    slope = np.sinh(beta * s) + np.sin(beta * s) - k * (np.cosh(beta * s) - np.cos(beta * s))
    return shape / 2, slope * beta / 2


def make_bar(count=400, rings=50, around=20):
    """A bar of 1,000 vertices, 100 long, that swings in its six lowest bending modes (three a
    plane) while it turns and travels as a rigid body."""
    s = np.repeat(np.linspace(0, 1, rings), around)
    angle = np.tile(np.arange(around) * 2 * math.pi / around, rings)
    rest = np.stack([5 * np.cos(angle), 100 * s, 4 * np.sin(angle)], 1)
    t = np.arange(count) / 30.0
    moved = np.repeat(rest[None], count, 0)
    for i, beta in enumerate((1.875104, 4.694091, 7.854757)):
        shape, slope = beam_mode(beta, s)
        for axis, stiff in ((0, 1.0), (2, 0.8)):
            hertz = 0.4 * stiff * (beta / 1.875104) ** 2
            reach = (12.0, 3.0, 0.8)[i]
            swing = reach * np.cos(2 * math.pi * hertz * t + i + axis) * np.exp(-0.05 * hertz * t)
            moved[:, :, axis] += swing[:, None] * shape
            moved[:, :, 1] -= swing[:, None] * (slope / 100 * rest[:, axis])
    turn = rotations(1.2 * np.sin(0.7 * t), 0.5 * t)
    travel = np.stack([30 * np.sin(0.6 * t), 8 * np.cos(1.1 * t), 20 * np.sin(0.4 * t)], 1)
    frames = np.einsum("nij,nmj->nmi", turn, moved) + travel[:, None]
    return Sequence("bar", frames, grid_triangles(rings, around, True))


def rotations(about_x, about_y):
    zero, one = np.zeros_like(about_x), np.ones_like(about_x)
    cx, sx, cy, sy = np.cos(about_x), np.sin(about_x), np.cos(about_y), np.sin(about_y)
    x = np.array([[one, zero, zero], [zero, cx, -sx], [zero, sx, cx]])
    y = np.array([[cy, zero, sy], [zero, one, zero], [-sy, zero, cy]])
    return np.einsum("ijn,jkn->nik", y, x)


def make_cloth(count=400, side=32):
    """A flag of 1,024 vertices and constant length: its tangent's angle is a sum of running waves
    that grow from the pole and differ with height. It loops."""
    s = np.linspace(0, 1, side)
    t = np.arange(count) * 2 * math.pi / count
    up = np.linspace(-1, 1, side)
    angle = np.zeros((count, side, side))
    modes = ((0.5, 1.0, 7, 0.4), (0.3, 1.7, 12, -0.6), (0.12, 2.9, 20, 0.9))
    for reach, waves, turns, skew in modes:
        phase = (2 * math.pi * waves * s[None, None, :] + skew * up[None, :, None]
                 - turns * t[:, None, None])
        angle += reach * np.sqrt(s) * np.sin(phase)
    step = 100.0 / (side - 1)
    middle = (angle[:, :, 1:] + angle[:, :, :-1]) / 2
    frames = np.zeros((count, side, side, 3))
    frames[:, :, 1:, 0] = np.cumsum(np.cos(middle), 2) * step
    frames[:, :, 1:, 2] = np.cumsum(np.sin(middle), 2) * step
    frames[:, :, :, 1] = 35 * up[None, :, None]
    return Sequence("cloth", frames.reshape(count, -1, 3), grid_triangles(side, side, False))


def load_all(folder):
    """(sequences, messages about those that are not there). The bench's own files go to `folder`."""
    out, missing = [], []
    for name in ("faerie", "sydney"):
        path = os.path.join(ASSIMP, "MD2", name + ".md2")
        if os.path.exists(path):
            out.append(read_md2(path, name))
        else:
            missing.append("%s: no %s (package assimp-testmodels)" % (name, path))
    if os.path.exists(OPENARENA):
        with zipfile.ZipFile(OPENARENA) as pak:
            path = os.path.join(folder, "sarge_lower.md3")
            with open(path, "wb") as f:
                f.write(pak.read(SARGE))
        out.append(read_md3(path, "sarge"))
    else:
        missing.append("sarge: no %s (package openarena-data)" % OPENARENA)
    cube = os.path.join(ASSIMP, "glTF2/glTF-Sample-Models/AnimatedMorphCube-glTF",
                        "AnimatedMorphCube.gltf")
    if os.path.exists(cube):
        out.append(read_gltf(cube, "cube"))
    else:
        missing.append("cube: no %s (package assimp-testmodels)" % cube)
    return out + [make_bar(), make_cloth()], missing


def write_cache(sequence, stem):
    """Frames as a point cache (PC2) over an OBJ, both for the baker."""
    with open(stem + ".obj", "w") as f:
        f.writelines("v %.9g %.9g %.9g\n" % tuple(np.float32(v)) for v in sequence.frames[0])
        f.writelines("f %d %d %d\n" % tuple(t + 1) for t in sequence.triangles)
    with open(stem + ".pc2", "wb") as f:
        f.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, sequence.vertices, 0.0, 1.0,
                            sequence.count))
        f.write(sequence.frames.astype("<f4").tobytes())
