# SPDX-License-Identifier: MIT
"""Shapes of the C player against wgl_shape.py, bit for bit: tests for test_player_bits.py."""
import os
import random
import struct

import wgl
import wgl_shape
import wgl_write
import wgl_write_shape
from c_player import CFile, CPose, ROOT

VECTORS = os.path.join(ROOT, "tests", "vectors")


def read_vector(name):
    with open(os.path.join(VECTORS, name), "rb") as file:
        return file.read()


def shapes_error(blob):
    """0, or the code of the error that the reference raises in what wg_open_shapes checks."""
    try:
        wgl_shape.Shapes(wgl.Clip(blob))
        return 0
    except wgl.ClipError as error:
        return error.code


def compare_poses(c, shapes, values, rng, check_eq, text):
    """Every shape, at a level of detail, whole and in ranges; then as normals of each other."""
    clip = shapes.clip
    for i, shape in enumerate(clip.shapes):
        bases = rng.choice((128, 0, 1, rng.randint(0, 128)))
        pose, here = CPose(c, i, values, bases), "shape %d, %s" % (i, text)
        want = shapes.pose(i, values, bases)
        check_eq(list(pose.weights)[:shape.basis_count], want.weights, "weights, " + here)
        check_eq(list(pose.pose.turn), [m for row in want.matrix for m in row], "turn, " + here)
        check_eq(pose.pose.turn_bits, want.n, "turn_bits, " + here)
        flat = shapes.vertices(i, want)
        check_eq(pose.vertices(), flat, "vertices, " + here)
        first = rng.randrange(shape.vertices)
        count = rng.randint(0, shape.vertices - first)
        check_eq(pose.vertices(first, count), flat[3 * first:3 * (first + count)], "range, " + here)
        positions = rng.randrange(len(clip.shapes))
        normals = CPose(c, i, values, bases, CPose(c, positions, values))
        want = shapes.pose_normals(i, values, shapes.pose(positions, values), bases)
        check_eq(normals.vertices(), shapes.vertices(i, want), "normals, " + here)


def random_shapes_have_the_same_poses(seed, check_eq):
    blocks = affine = 0
    for n in range(300):
        rng = random.Random("%d shapes %d" % (seed, n))
        file = wgl_write_shape.random_shape_file(rng)
        blob = wgl_write.build(file)
        c, shapes = CFile(blob), wgl_shape.Shapes(wgl.Clip(blob))
        check_eq((c.error, c.shapes_error), (0, 0), "file %d" % n)
        for k in range(4):
            values = wgl_write_shape.random_values(rng, file)
            compare_poses(c, shapes, values, rng, check_eq, "file %d values %d" % (n, k))
        blocks += len(shapes.clip.blocks)
        affine += sum(s.affine != wgl_shape.ABSENT for s in shapes.clip.shapes)
    check_eq((blocks > 1000, affine > 50), (True, True), "blocks and affine shapes met")


def damaged_shapes_are_judged_alike(seed, check_eq):
    """A few bytes changed in the records of shapes, or anywhere; what both accept is posed."""
    accepted = refused = 0
    for n in range(3000):
        rng = random.Random("%d damaged shapes %d" % (seed, n))
        if n % 10 == 0:
            file = wgl_write_shape.random_shape_file(rng)
            base = wgl_write.build(file)
            spans = [(at, size) for kind, _, at, size in
                     (struct.unpack_from("<HHII", base, 16 + 12 * i) for i in range(base[10]))
                     if kind >= 13 and size]
        blob = bytearray(base)
        for _ in range(rng.randint(1, 3)):
            start, size = rng.choice(spans)
            at = rng.randrange(start, start + size)
            blob[at] = rng.choice((0, 1, 127, 128, 255, blob[at] ^ 1 << rng.randrange(8)))
        blob = wgl_write.fix_crc(bytes(blob))
        c, want = CFile(blob), shapes_error(blob)
        check_eq((c.error, c.shapes_error), (0, want), "damage %d" % n)
        refused += want < 0
        if want == 0:
            accepted += 1
            values = wgl_write_shape.random_values(rng, file)
            compare_poses(c, wgl_shape.Shapes(wgl.Clip(blob)), values, rng, check_eq,
                          "damage %d" % n)
    check_eq((accepted > 300, refused > 300), (True, True), "accepted and refused")


# Each MUST of 4.13 to 4.17 broken in v1_shapes.wgl: error, then section, place, layout, value. Its
# shapes have 42, 42 and 4 vertices, 5, 5 and 0 bases, and 4, 1 and 0 blocks; 25 channels.
BROKEN = [
    ("Shape", "shapes", 0, "H", 0), ("Shape", "shapes", 2, "b", -9),
    ("Shape", "shapes", 2, "b", 21),
    ("Shape", "shapes", 4, "H", 6), ("Shape", "shapes", 4, "H", 65535),
    ("Shape", "shapes", 6, "H", 11), ("Shape", "shapes", 6, "H", 65),
    ("Shape", "shapes", 8, "H", 2), ("Shape", "shapes", 10, "H", 6),
    ("Shape", "shapes", 10, "H", 65535), ("Shape", "shapes", 12, "H", 14),
    ("Shape", "shapes", 12, "H", 65534), ("Shape", "shapes", 16, "I", 2),
    ("Shape", "shapes", 16, "I", 0xFFFFFFFC), ("Shape", "shapes", 20, "i", (1 << 28) + 1),
    ("Shape", "shapes", 28, "i", -(1 << 31)), ("Shape", "shapes", 64, "H", 65535),
    ("Basis", "bases", 0, "H", 25), ("Basis", "bases", 4, "B", 0), ("Basis", "bases", 76, "B", 16),
    ("Block", "blocks", 0, "H", 5), ("Block", "blocks", 2, "H", 5),
    ("Block", "blocks", 2, "H", 65534), ("Block", "blocks", 4, "H", 1),
    ("Block", "blocks", 6, "H", 0), ("Block", "blocks", 6, "H", 43),
    ("Block", "blocks", 8, "B", 0), ("Block", "blocks", 8, "B", 24),
    ("Block", "blocks", 12, "I", 6), ("Block", "blocks", 12, "I", 0x80000000),
    ("Block", "shapes", 6, "H", 3), ("Block", "shapes", 0, "H", 41),
    ("Part", "parts", 0, "H", 3), ("Part", "parts", 0, "H", 2), ("Part", "parts", 2, "H", 2),
    ("Part", "parts", 2, "H", 3), ("Part", "parts", 4, "H", 0), ("Part", "parts", 4, "H", 65535),
    ("Part", "parts", 6, "B", 2), ("Part", "parts", 12, "I", 1),
    ("Part", "parts", 28, "I", 0xFFFFFFFE), ("View", "views", 0, "B", 2),
    ("View", "views", 1, "B", 3), ("View", "views", 12, "H", 25),
    ("View", "views", 28 + 26, "H", 65535),
]


def every_broken_shape_is_rejected(_, check_eq):
    base = read_vector("v1_shapes.wgl")
    check_eq((CFile(base).shapes_error, shapes_error(base)), (0, 0), "v1_shapes.wgl")
    place = {kind: at for kind, _, at, _ in
             (struct.unpack_from("<HHII", base, 16 + 12 * i) for i in range(base[10]))}
    for name, section, at, layout, value in BROKEN:
        blob = bytearray(base)
        struct.pack_into("<" + layout, blob, place[wgl.SECTIONS.index(section) + 1] + at, value)
        blob = wgl_write.fix_crc(bytes(blob))
        want = getattr(wgl_shape, "Bad" + name).code
        c = CFile(blob)
        check_eq((c.error, c.shapes_error, shapes_error(blob)), (0, want, want),
                 "%s %d = %s" % (section, at, value))


def golden_shapes_keep_their_vertices(_, check_eq):
    """tests/vectors/v1_shapes.csv: clip, time, shape, vertex, then where it is."""
    blob = read_vector("v1_shapes.wgl")
    clip, c = wgl.Clip(blob), CFile(blob)
    rows = read_vector("v1_shapes.csv").decode().splitlines()
    check_eq(rows, [",".join(map(str, row)) for row in wgl_shape.pose_rows(clip, 0, 370000)],
             "reference")
    turns_with, cache = wgl_shape.normals_of(clip), {}
    for row in rows[1:]:
        index, time_us, shape, vertex, *want = map(int, row.split(","))
        if (time_us, shape) not in cache:
            values = c.sample(index, time_us)[0]
            positions = CPose(c, turns_with.get(shape, shape), values)
            pose = CPose(c, shape, values, 128, positions) if shape in turns_with else positions
            cache[time_us, shape] = pose.vertices()
        check_eq(cache[time_us, shape][3 * vertex:3 * vertex + 3], want, row)
    check_eq(len(rows), 1 + 88 * 7, "rows")


def a_clip_without_shapes_opens(_, check_eq):
    """1.0 files have no sections from 13 on."""
    for name in ("v1_worked.wgl", "v1_all.wgl"):
        c = CFile(read_vector(name))
        check_eq((c.error, c.shapes_error), (0, 0), name)
        check_eq([c.file.section[kind].count for kind in range(13, 18)], [0] * 5, name)


def tests(seed, check_eq):
    def bound(test):
        def run():
            test(seed, check_eq)
        run.__name__ = test.__name__
        return run
    return [bound(test) for test in (
        random_shapes_have_the_same_poses, damaged_shapes_are_judged_alike,
        every_broken_shape_is_rejected, golden_shapes_keep_their_vertices,
        a_clip_without_shapes_opens)]
