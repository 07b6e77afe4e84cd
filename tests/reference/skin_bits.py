# SPDX-License-Identifier: MIT
"""Skins of the C player against wgl_skin.py, bit for bit: tests for test_player_bits.py."""
import random
import struct

import wgl
import wgl_skin
import wgl_write
import wgl_write_skin
from c_player import CFile, CSkin, set_fields
from shape_bits import read_vector
from wgl_bones import FOLLOW
from wgl_shape import Shapes
from wgl_skin import PLACE


def skins_error(blob):
    """The error of each of the player's three calls, 0 behind the first, from the reference."""
    stage = 0
    try:
        clip = wgl.Clip(blob)
        stage = 1
        shapes = Shapes(clip)
        stage = 2
        wgl_skin.Skins(shapes)
        return 0, 0, 0
    except wgl.ClipError as error:
        return tuple(error.code if i == stage else 0 for i in range(3))


def errors(c):
    return c.error, c.shapes_error, c.skins_error


def compare_skins(c, skins, values, rng, check_eq, text):
    """Fields, then every skin with what they give: whole, in a range, one vertex by itself."""
    want = list(values)
    skins.set_fields(want)
    check_eq(set_fields(c, values), want, "fields, " + text)
    for i, shape in enumerate(skins.clip.shapes):
        bases = rng.choice((128, 0, rng.randint(0, 128)))
        skin, here = CSkin(c, i, want, bases), "shape %d, %s" % (i, text)
        check_eq(skin.found, i in skins.of_shape, "skin, " + here)
        if not skin.found:
            continue
        flat, light = skins.vertices(i, want, bases), skins.brightness(i, want)
        check_eq(skin.vertices(), flat, "vertices, " + here)
        check_eq(skin.brightness(), light, "brightness, " + here)
        for first, count in (cut(rng, shape.vertices), (rng.randrange(shape.vertices), 1)):
            check_eq(skin.vertices(first, count), flat[3 * first:3 * (first + count)],
                     "range %d %d, %s" % (first, count, here))
            check_eq(skin.brightness(first, count), light[first:first + count],
                     "brightness of a range, " + here)


def cut(rng, vertices):
    first = rng.randrange(vertices)
    return first, rng.randint(0, vertices - first)


def random_skins_have_the_same_vertices(seed, check_eq):
    met = {}
    for n in range(250):
        rng = random.Random("%d skins %d" % (seed, n))
        file = wgl_write_skin.random_skin_file(rng)
        blob = wgl_write.build(file)
        c, skins = CFile(blob), wgl_skin.Skins(Shapes(wgl.Clip(blob)))
        check_eq(errors(c), (0, 0, 0), "file %d" % n)
        for k in range(3):
            values = wgl_write_skin.random_values(rng, file)
            compare_skins(c, skins, values, rng, check_eq, "file %d values %d" % (n, k))
        for skin in skins.clip.skins:
            key = skin.method, skin.ends
            met[key] = met.get(key, 0) + 1
        for joint in skins.clip.joints:
            met[joint.kind] = met.get(joint.kind, 0) + 1
    kinds = [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), *range(7)]
    check_eq(min(met.get(kind, 0) for kind in kinds) > 20, True, "methods and joints met: %s" % met)


def damaged_skins_are_judged_alike(seed, check_eq):
    """A few bytes changed in the records of skins and what they point at; what all accept is
    posed."""
    accepted = refused = 0
    for n in range(3000):
        rng = random.Random("%d damaged skins %d" % (seed, n))
        if n % 10 == 0:
            file = small_file(rng)
            base = wgl_write.build(file)
            spans = [(at, size) for kind, _, at, size in
                     (struct.unpack_from("<HHII", base, 16 + 12 * i) for i in range(base[10]))
                     if kind in (5, 13, 16) or kind >= 18 and size]
        blob = bytearray(base)
        for _ in range(rng.randint(1, 3)):
            start, size = rng.choice(spans)
            at = rng.randrange(start, start + size)
            blob[at] = rng.choice((0, 1, 127, 128, 255, blob[at] ^ 1 << rng.randrange(8)))
        blob = wgl_write.fix_crc(bytes(blob))
        c, want = CFile(blob), skins_error(blob)
        check_eq(errors(c), want, "damage %d" % n)
        refused += want[2] < 0
        if want == (0, 0, 0):
            accepted += 1
            values = wgl_write_skin.random_values(rng, file)
            compare_skins(c, wgl_skin.Skins(Shapes(wgl.Clip(blob))), values, rng, check_eq,
                          "damage %d" % n)
    check_eq((accepted > 300, refused > 300), (True, True),
             "%d accepted and %d refused" % (accepted, refused))


def small_file(rng):
    """One in which damage is likely to meet what matters."""
    while True:
        file = wgl_write_skin.random_skin_file(rng)
        if max(len(s["bones"]) for s in file["skins"]) <= 40:
            return file


# Each MUST of 4.18 to 4.23 broken in v1_skins.wgl: error, then section, place, layout, value. Its
# skins have the shapes in order and 4, 4, 2, 2, 4 and 2 bones of 18; 23 channels. "follow", "span"
# and "field" are the bytes of the first FOLLOW joint (the 23rd joint), span and field.
MOST = (1 << 31) - 1
BROKEN = [
    ("Bone", "bones", 0, "H", 0), ("Bone", "bones", 2 * 48, "H", 2),
    ("Bone", "bones", 17 * 48, "H", 1), ("Bone", "bones", 48, "H", 65534),
    ("Bone", "bones", 2, "H", 32), ("Bone", "bones", 2, "H", 65535),
    ("Bone", "bones", 17 * 48 + 4, "B", 2), ("Bone", "bones", 6, "H", 23),
    ("Bone", "bones", 6, "H", 65534), ("Bone", "bones", 8, "i", PLACE + 1),
    ("Bone", "bones", 12, "i", -PLACE - 1), ("Bone", "bones", 16, "i", -MOST - 1),
    ("Bone", "bones", 20, "i", PLACE + 1), ("Bone", "bones", 48 + 20, "i", -1),
    ("Joint", "joints", 0, "B", 7), ("Joint", "joints", 0, "B", 255),
    ("Joint", "joints", 2, "H", 23), ("Joint", "joints", 8, "i", (1 << 30) + 1),
    ("Joint", "joints", 12, "i", -(1 << 30) - 1), ("Joint", "joints", 16, "i", -MOST - 1),
    ("Joint", "joints", 20 + 4, "I", MOST + 1), ("Joint", "joints", 20 + 16, "i", MOST),
    ("Joint", "joints", 2 * 20 + 2, "H", 65535), ("Joint", "joints", 3 * 20 + 2, "H", 23),
    ("Joint", "joints", 3 * 20 + 4, "I", MOST + 1), ("Joint", "joints", 4 * 20 + 4, "I", MOST + 1),
    ("Joint", "joints", 16 * 20 + 2, "H", 20), ("Joint", "joints", 16 * 20 + 2, "H", 65535),
    ("Joint", "joints", 22 * 20 + 1, "B", 0), ("Joint", "joints", 22 * 20 + 1, "B", 9),
    ("Joint", "joints", 22 * 20 + 4, "I", 0xFFFFFFFE), ("Joint", "follow", 0, "B", 4),
    ("Joint", "follow", 2, "B", 255), ("Joint", "bones", 12 * 48 + 4, "B", 3),
    ("Joint", "bones", 13 * 48, "H", 0), ("Joint", "bones", 15 * 48, "H", 2),
    ("Skin", "skins", 0, "H", 6), ("Skin", "skins", 0, "H", 1), ("Skin", "skins", 2, "B", 3),
    ("Skin", "skins", 3, "B", 2), ("Skin", "skins", 5 * 16 + 3, "B", 1),
    ("Skin", "skins", 2, "B", 2), ("Skin", "skins", 6, "H", 0), ("Skin", "skins", 6, "H", 257),
    ("Skin", "skins", 4, "H", 15), ("Skin", "skins", 4, "H", 65535),
    ("Skin", "skins", 8, "H", 18), ("Skin", "skins", 8, "H", 65535),
    ("Skin", "skins", 10, "H", 22), ("Skin", "skins", 10, "H", 65535),
    ("Skin", "shapes", 12, "H", 3), ("Skin", "parts", 2, "H", 5),
    ("Span", "skins", 10, "H", 3), ("Span", "skins", 10, "H", 5), ("Span", "skins", 10, "H", 0),
    ("Span", "skins", 6, "H", 3), ("Span", "spans", 0, "H", 1), ("Span", "spans", 12, "H", 7),
    ("Span", "spans", 2, "H", 0), ("Span", "spans", 2, "H", 7),
    ("Span", "spans", 3 * 12 + 2, "H", 65535), ("Span", "spans", 4, "B", 0),
    ("Span", "spans", 4, "B", 9), ("Span", "spans", 4, "B", 2),
    ("Span", "spans", 8, "I", 0xFFFFFFFF), ("Span", "span", 0, "B", 4),
    ("Span", "span", 1, "B", 254), ("Span", "span", 7 * 3 + 1, "B", 0),
    ("Field", "fields", 0, "H", 23), ("Field", "fields", 2, "B", 0), ("Field", "fields", 2, "B", 3),
    ("Field", "fields", 4, "I", 1), ("Field", "fields", 4, "I", 0xFFFFFFFE),
    ("Field", "field", 0, "H", 23), ("Field", "field", 2, "H", 65535),
    ("Field", "field", 4, "B", 101), ("Field", "field", 5, "B", 0),
    ("Paint", "paints", 0, "H", 2), ("Paint", "paints", 0, "H", 1), ("Paint", "paints", 2, "B", 2),
    ("Paint", "paints", 8, "I", 0xFFFFFFFF), ("Paint", "paints", 8, "I", 0xFFFFFD00),
    ("Paint", "paints", 28 + 4, "H", 0), ("Paint", "paints", 28 + 4, "H", 1025),
    ("Paint", "paints", 28 + 4, "H", 1024), ("Paint", "paints", 28 + 6, "H", 0),
    ("Paint", "paints", 28 + 6, "H", 1025), ("Paint", "paints", 28 + 12, "I", 0xFFFFFFFF),
]


def every_broken_skin_is_rejected(_, check_eq):
    base = read_vector("v1_skins.wgl")
    check_eq((errors(CFile(base)), skins_error(base)), ((0, 0, 0),) * 2, "v1_skins.wgl")
    entries = [struct.unpack_from("<HHII", base, 16 + 12 * i) for i in range(base[10])]
    place = {wgl.SECTIONS[kind - 1]: at for kind, _, at, _ in entries}
    clip = wgl_skin.Skins(Shapes(wgl.Clip(base))).clip
    follow = next(joint for joint in clip.joints if joint.kind == FOLLOW)
    for name, record in (("follow", follow), ("span", clip.spans[0]), ("field", clip.fields[0])):
        place[name] = place["data"] + record.data
    for name, section, at, layout, value in BROKEN:
        blob = bytearray(base)
        struct.pack_into("<" + layout, blob, place[section] + at, value)
        blob = wgl_write.fix_crc(bytes(blob))
        want = 0, 0, getattr(wgl_skin, "Bad" + name).code
        check_eq((errors(CFile(blob)), skins_error(blob)), (want, want),
                 "%s %d = %s" % (section, at, value))


def what_a_skin_has_to_have_is_looked_for(_, check_eq):
    """What takes more than one field: a paint of a part without skin, data that ends too early."""
    file = wgl_write_skin.golden()
    file["skins"] = file["skins"][:4] + file["skins"][5:]
    want = 0, 0, wgl_skin.BadPaint.code
    blob = wgl_write.build(file)
    check_eq((errors(CFile(blob)), skins_error(blob)), (want, want), "FIELD without a skin")
    file = {"channels": [(0, 0, 0)], "clips": [{"rate": 1, "ticks": 1, "tracks": []}],
            "shapes": [{"frac": 0, "rest": [1, 2, 3], "bases": [], "blocks": []}],
            "skins": [{"shape": 0, "method": wgl_skin.LINEAR, "ends": 1, "spans": [[[(0, 255, 9)]]],
                       "bones": [{"origin": [0, 0, 0], "frame": wgl_write_skin.STRAIGHT}]}]}
    blob = wgl_write.build(file)
    entries = [struct.unpack_from("<HHII", blob, 16 + 12 * i) for i in range(blob[10])]
    at, size = next((16 + 12 * i + 8, e[3]) for i, e in enumerate(entries) if e[0] == 5)
    for less, want in ((0, 0), (1, wgl_skin.BadSpan.code)):
        cut = bytearray(blob)
        struct.pack_into("<I", cut, at, size - less)
        cut = wgl_write.fix_crc(bytes(cut))
        check_eq((errors(CFile(cut)), skins_error(cut)), ((0, 0, want),) * 2, "DATA - %d" % less)


def golden_skins_keep_their_vertices(_, check_eq):
    """tests/vectors/v1_skins.csv: clip, time, shape, vertex, where it is, how bright; fields."""
    blob = read_vector("v1_skins.wgl")
    clip, c = wgl.Clip(blob), CFile(blob)
    rows = read_vector("v1_skins.csv").decode().splitlines()
    check_eq(rows, [",".join(map(str, row)) for row in wgl_skin.pose_rows(clip, 0, 370000)],
             "reference")
    cache = {}
    for row in rows[1:]:
        index, time_us, shape, vertex, *want = row.split(",")
        values = set_fields(c, c.sample(int(index), int(time_us))[0])
        if shape == "field":
            check_eq(values[int(vertex)], int(want[0]), row)
            continue
        key, vertex = (time_us, int(shape)), int(vertex)
        if key not in cache:
            skin = CSkin(c, int(shape), values)
            cache[key] = skin.vertices(), skin.brightness()
        flat, light = cache[key]
        check_eq(flat[3 * vertex:3 * vertex + 3] + [light[vertex]], list(map(int, want)), row)
    check_eq(len(rows), 1 + 7 * (2 + 2 * 28 + 2 * 16 + 2 * 9), "rows")


def a_clip_without_skins_opens(_, check_eq):
    """1.0 and 1.1 files have no sections from 18 on."""
    for name in ("v1_worked.wgl", "v1_all.wgl", "v1_shapes.wgl"):
        c = CFile(read_vector(name))
        check_eq(errors(c), (0, 0, 0), name)
        check_eq([c.file.section[kind].count for kind in range(18, 24)], [0] * 6, name)


def tests(seed, check_eq):
    def bound(test):
        def run():
            test(seed, check_eq)
        run.__name__ = test.__name__
        return run
    return [bound(test) for test in (
        random_skins_have_the_same_vertices, damaged_skins_are_judged_alike,
        every_broken_skin_is_rejected, what_a_skin_has_to_have_is_looked_for,
        golden_skins_keep_their_vertices, a_clip_without_skins_opens)]
