#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Hostile rigs: wrong scenes, damaged pictures, drawings, rigged files and captures, handles where they
cannot be, damaged caches. Each ends with a clip or with one line that names the scene's line; nothing
crashes, hangs or leaves files behind (test_bake_body_damage.py: bake)."""
import os
import random
import re
import sys
import zlib

import test_bake_body_damage as body
import test_bake_cli as cli
import test_bake_damage as damage

SIMPLE_SKIN = damage.whole("/usr/share/assimp/models/glTF2/simple_skin/simple_skin.gltf")
PNG, SVG, BVH = (damage.whole(os.path.join(damage.SCENES, n)) for n in ("flat.png", "flat.svg", "arm.bvh"))

SCENE = """channels:
- {name: bend, unit: deg}
- {name: slide, unit: mm}
- {name: longer, rest: 1}
- {name: glow}
- {name: led}
%(sources)smeshes:
- {name: m, file: %(file)s, tolerance: %(tolerance)s}
rigs:
- name: r
  mesh: m
%(how)s
  bones:
%(bones)s
clips:
- name: c
%(takes)s  curves:
  - {channel: bend, kind: cubic, keys: [{time: 0, value: 0}, {time: 1, value: 60}]}
"""
BONES = """  - {name: low, from: [5, 2, 5], to: [5, 15, 5]}
  - {name: high, to: [5, 28, 5], parent: low, joints: [{turn: z, channel: bend, limits: [-90, 90]}]}"""
FLAT = """  - {name: low, at: [-3, 0], value: glow}
  - {name: high, at: [3, 0], joints: [{move: x, channel: slide}]}"""
MANY = """  tolerance: 0.4
  cell: 4
  influences: 3
  ends: projection
  filter: [[0.2, 0.1], [0.8, 0.9]]
  brush: [{region: {ball: {centre: [5, 8, 5], radius: 3}}, stiffness: 9}]
  fields: [{channel: led, at: [5, 9, 5]}]"""
MANY_BONES = """  - {name: low, from: [5, 2, 5], to: [5, 15, 5], value: glow, depth: 0.5}
  - {name: high, to: [5, 28, 5], parent: low, joints: [{turn: z, channel: bend}, {stretch: longer}]}
  - {name: foot, region: {below: {y: 0.5}}, at: [5, 0, 5], value: glow}"""
TAKE = {"sources": "sources:\n- {name: w, file: a.bvh}\n",
        "takes": "  rigs: [{rig: r, source: w, travel: true}]\n",
        "bones": "  - {name: low, from: [5, 2, 5], to: [5, 15, 5], node: Upper}\n"
                 "  - {name: high, to: [5, 28, 5], parent: low, node: Lower}"}
SKIN_FILE = {"file": "m.gltf", "how": "  file: m.gltf\n  weights: file", "bones": "  - {name: nodes_1_, value: glow}"}
BOX = body.obj(*body.BOX)


def scene(*changes, **fields):
    """changes: words of the scene, and what they become."""
    text = SCENE % dict(dict(file="m.obj", tolerance=1, how="  cell: 5", bones=BONES, sources="", takes=""), **fields)
    for old, new in zip(changes[::2], changes[1::2]):
        assert text.count(old) == 1, (old, text)
        text = text.replace(old, new)
    return text


def points(*places, kind="at"):
    return "\n".join("  - {name: p%d, %s: %s}" % (i, kind, list(p)) for i, p in enumerate(places))


def bake_all(texts, **files):
    return body.all_of([(body.bake, (t, BOX), files) for t in texts])


def bake_flat(cases):
    """(scene, name of the file, its bytes)"""
    return body.all_of([(body.bake, (t, ""), {name: data}) for t, name, data in cases])


# ---- handles -----------------------------------------------------------------------------------------
def handles_that_cannot_hold_are_named():
    def bones(text):
        return scene(bones=text)

    body.refuse([
        (scene("to: [5, 28, 5]", "to: [5, 900, 5]"), BOX, "s.yaml:15:", "bone high", "nearer"),
        (bones(points((50, 2, 5))), BOX, "s.yaml:14:", "'p0' holds nothing", "outside of mesh m, 40 away"),
        (bones(points((5, 2, 5), (5, 2, 5))), BOX, "s.yaml:15:", "'p0'", "'p1'", "in one place"),
        (bones(BONES.replace("to: [5, 28, 5], parent: low", "from: [5, 2, 5], to: [5, 15, 5]")), BOX, "in one place"),
        (scene("cell: 5", "cell: 2", bones="  - {name: a, from: [5, 2, 5], to: [5, 20, 5]}\n"
               "  - {name: b, from: [2, 10, 5], to: [8, 10, 5]}"), BOX, "s.yaml:15:", "let bones meet at their ends"),
        (bones("  - {name: a, region: {below: {y: -1}}}"), BOX, "s.yaml:14:", "'a' holds no vertex"),
        (bones("  - {name: a, region: {vertices: [3, 900]}}"), BOX, "s.yaml:14:", "'a' names the vertex 900"),
        (bones("  - {name: a, region: {below: {y: 20}}}\n  - {name: b, region: {above: {y: 10}}}"), BOX,
         "region 'a' and region 'b'"),
        (bones(points(*[(1 + i % 9, 1 + i // 9 % 28, 4 + i // 252) for i in range(252)]).replace(
            "]}", "], depth: 1}")), BOX, "the depth of 'p243' is a channel", "256 already"),
        (scene("cell: 5", "cell: 1e-6"), BOX, "s.yaml:10:", "'cell'"),
        (scene("cell: 5", "cell: 5\n  fields: [{channel: led, at: [5, 9, 5]}]"), BOX, "no bone with a `value`")])


def cages_that_cross_or_end_nowhere_are_refused():
    corners, faces = body.box((1, 1, 1), (14, 36, 14))
    corners = [[x - 2, y - 3, z - 2] for x, y, z in corners]
    facets = "  cell: 5\n  cage: [%s]" % ", ".join("[%s]" % ", ".join("p%d" % i for i in f) for f in faces)
    crossed = list(corners)
    crossed[0], crossed[7] = crossed[7], crossed[0]
    body.refuse([(scene(how=facets, bones=points(*crossed, kind="cage")), BOX, "mesh cage", "cross or touch"),
                 (scene("p3, cage: %s" % corners[3], "p3, cage: %s, weightless: true" % corners[3], how=facets,
                        bones=points(*corners, kind="cage")), BOX, "'p3' of a cage is 'weightless'")])
    body.accept((scene(how=facets, bones=points(*corners, kind="cage")), BOX),
                (scene(how="  cell: 5\n  cage: [[p0, p1, p2]]",  # inside, open
                       bones=points((2, 2, 2), (8, 2, 5), (5, 28, 5), kind="cage")), BOX))


def odd_rigs_are_baked():
    """One bone, very many, very short ones, points that follow one another, all of a mesh in one region."""
    grid = [(1 + 4 * (i % 3), 1 + i // 9, 1 + 4 * (i // 3 % 3)) for i in range(256)]
    follow = "  - {name: a, at: [5, 2, 5], joints: [{follow: [b]}]}\n" \
             "  - {name: b, at: [5, 28, 5], joints: [{move: x, channel: slide}]}"
    body.accept((scene(bones=points((5, 2, 5))), BOX),
                (scene(bones=points(*grid), how="  cell: 2\n  influences: 1"), BOX),
                (scene(bones="  - {name: a, from: [5, 2, 5], to: [5, 2.00001, 5]}\n" + points((5, 20, 5))), BOX),
                (scene(bones=follow), BOX), (scene(bones=follow, how="  cell: 5\n  method: dual"), BOX),
                (scene(bones="  - {name: a, region: {below: {y: 100}}}\n  - {name: b, at: [5, 5, 5]}"), BOX),
                (scene(bones=MANY_BONES, how=MANY), BOX), (scene(how="  weights: coupled\n  cell: 8"), BOX))


def broken_meshes_are_wrapped_with_a_warning():
    one = body.obj([[0, 0, 0], [9, 0, 0], [0, 9, 0]], [[0, 1, 2]])
    two = body.obj(*body.both(body.BOX, body.moved(body.BOX, (40, 0, 0))))
    open_box = body.obj(body.BOX[0], body.BOX[1][2:])
    upright = body.obj([[z, x, y] for x, y, z in body.SHEET[0]], body.SHEET[1])
    jobs = [(scene(), two, "touches no handle"), (scene(), open_box, "warning: "),
            (scene(bones=points((0, 5, 5), (0, 25, 25))), upright, "wrapped"),
            (scene(bones=points((0, 0, 0), (9, 0, 0))), one, None)]
    for (_, _, word), got in zip(jobs, body.all_of([(body.bake, j[:2], {}) for j in jobs])):
        assert got.code == cli.DONE and (word is None) == (not got.warned), (got.said, got.warned)
        assert word is None or word in got.warned[0], got.warned
    body.refuse([(scene("cell: 5", "wrap: false"), open_box, "has a hole at")])


def sizes_of_all_kinds_are_answered():
    """Tiny, huge, far off: a clip, or what is too far or too small."""
    def sized(k, way):
        def place(m):
            return ", ".join("%.9g" % (k * float(x) + d) for x, d in zip(m.group().split(","), way))

        return (scene("cell: 5", "cell: %.9g" % (5 * k), tolerance=0.1 * k,
                      bones=re.sub(r"-?\d+, -?\d+, -?\d+", place, BONES)),
                body.obj([[k * x + d for x, d in zip(v, way)] for v in body.BOX[0]], body.BOX[1]))

    jobs = [sized(k, (0, 0, 0)) for k in (1e-6, 1e-3, 1e3, 3e4, 1e6)]
    jobs += [sized(1, (d, 0, 0)) for d in (-100, 1e3, 9e5)]
    codes = [a.code for a in body.all_of([(body.bake, j, {}) for j in jobs])]
    assert codes[1:4] == [cli.DONE] * 3 and codes[5] == cli.DONE, codes


# ---- files -------------------------------------------------------------------------------------------
def png(data, r):
    """Rows, or another chunk, with some bytes changed; most of the time the checks are right again."""
    parts, at = [], 8
    while at < len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        parts.append((data[at + 4:at + 8], data[at + 8:at + 8 + size]))
        at += 12 + size
    rows = zlib.decompress(b"".join(c for kind, c in parts if kind == b"IDAT"))
    parts = [p for p in parts if p[0] not in (b"IDAT", b"IEND")] + [(b"IDAT", rows), (b"IEND", b"")]
    while True:
        out, hurt = data[:8], b"IDAT" if r.random() < 0.5 else r.choice(parts[:-2])[0]
        for kind, content in parts:
            content = bytearray(content)
            for _ in range(r.choice((1, 9)) if kind == hurt else 0):
                content[r.randrange(len(content))] = r.randrange(256)
            content = zlib.compress(bytes(content)) if kind == b"IDAT" else bytes(content)
            check = zlib.crc32(kind + content) if r.random() < 0.95 else 0
            out += len(content).to_bytes(4, "big") + kind + content + check.to_bytes(4, "big")
        yield out if r.random() < 0.9 else out[:r.randrange(len(out))]


def damaged_files_are_baked_or_refused():
    """The seeds are fixed."""
    pngs, svgs, gltfs, bvhs = (f(d, random.Random(i)) for i, (f, d) in enumerate(
        ((png, PNG), (damage.text, SVG), (damage.text, SIMPLE_SKIN), (damage.text, BVH))))
    picture, drawing = (scene(file="m." + k, how="  influences: 2", bones=FLAT) for k in ("png", "svg"))
    cases = [(picture, "m_png", next(pngs)) for _ in range(30)] + [(drawing, "m_svg", next(svgs)) for _ in range(30)]
    cases += [(scene(**SKIN_FILE), "m_gltf", next(gltfs)) for _ in range(60)]
    codes = [a.code for a in bake_flat(cases)]
    for part in (codes[:30], codes[30:60], codes[60:]):
        assert cli.DONE in part and cli.FAILED in part, codes
    texts = [next(bvhs) for _ in range(40)]
    codes = [a.code for a in body.all_of([(body.bake, (scene(**TAKE), BOX), {"a_bvh": t}) for t in texts])]
    assert cli.DONE in codes and cli.FAILED in codes, codes


def weights_of_files_do_with_fields_and_captures():
    own = {"sources": "sources:\n- {name: w, file: m.gltf}\n", "takes": "  rigs: [{rig: r, source: w}]\n"}
    field = SKIN_FILE["how"] + "\n  fields: [{channel: led, at: [0, 1, 0]}]"
    cases = [scene(**SKIN_FILE), scene(**dict(SKIN_FILE, how=field)), scene(**dict(SKIN_FILE, **own)),
             scene(**dict(SKIN_FILE, how=SKIN_FILE["how"] + "\n  method: shift", **own)),
             scene(**dict(SKIN_FILE, how=SKIN_FILE["how"] + "\n  ends: bounded"))]
    got = bake_flat([(t, "m_gltf", SIMPLE_SKIN) for t in cases])
    assert [a.code for a in got] == [cli.DONE] * 3 + [cli.FAILED] * 2, [a.said for a in got]
    assert "only moves them" in got[3].said and "`ends: projection`" in got[4].said, [a.said for a in got]


# ---- scenes ------------------------------------------------------------------------------------------
WRONG = ("NaN", "1e300", "-1", "''", "[]", "{}", "[[[1]]]", "x", "~")


def every_value_of_a_rig_may_be_wrong():
    """Each key of a rig with each wrong value, without it, and twice."""
    text = scene(how=MANY, bones=MANY_BONES)
    start, end = text.index("  mesh: m\n"), text.index("clips:")
    found = list(re.finditer(r"([a-z]+): ([^\[{},\n]+|\[[^\[\]{}]*\])", text[start:end]))
    assert len(found) > 20
    mutants = []
    for k, m in enumerate(found):
        a, b = start + m.start(), start + m.end()
        inside = "{" in text[text.rindex("\n", 0, a):a]
        news = ["%s: %s" % (m.group(1), w) for w in WRONG[k % 3::3]]
        news += [m.group() + (", " if inside else "\n  ") + m.group()]
        b += 2 if text[b:b + 2] == ", " else 0  # and without it
        news += [""] if inside else ["wrap: true"]
        mutants += [text[:a] + new + (", " if new and text[b - 2:b] == ", " else "") + text[b:] for new in news]
    codes = [a.code for a in bake_all(mutants)]
    assert cli.DONE in codes and codes.count(cli.FAILED) > len(codes) / 2, codes


def mutated_rigs_are_baked_or_refused():
    """The seed is fixed."""
    text = scene(how=MANY, bones=MANY_BONES).encode()
    start, end = text.index(b"  tolerance: 0.4"), text.index(b"clips:")
    mutations = damage.text(text[start:end], random.Random(3))
    codes = [a.code for a in bake_all([text[:start] + next(mutations) + text[end:] for _ in range(150)])]
    assert cli.DONE in codes and cli.FAILED in codes, codes


# ---- caches ------------------------------------------------------------------------------------------
def damaged_weights_cost_time_alone():
    text, name = scene(how=MANY, bones=MANY_BONES), "skins"
    want = body.bake(text, BOX, cache=cli.path(name)).clip
    files = sorted(body.cached(name).values())
    contents = [damage.whole(f) for f in files]
    assert files
    for way in range(4):
        for f, data in zip(files, contents):
            hurt = bytearray(data)
            hurt = (hurt[:len(hurt) // 2], hurt[:-8] + b"\0\0\0\0\0\0\xf8\x7f", b"", b"\xff" * len(hurt))[way]
            with open(f, "wb") as out:
                out.write(hurt)
        assert body.bake(text, BOX, cache=cli.path(name)).clip == want, way
        assert [damage.whole(f) for f in files] == contents, "repaired"


TESTS = (handles_that_cannot_hold_are_named, cages_that_cross_or_end_nowhere_are_refused, odd_rigs_are_baked,
         broken_meshes_are_wrapped_with_a_warning, sizes_of_all_kinds_are_answered, damaged_files_are_baked_or_refused,
         weights_of_files_do_with_fields_and_captures, every_value_of_a_rig_may_be_wrong,
         mutated_rigs_are_baked_or_refused, damaged_weights_cost_time_alone)

if __name__ == "__main__":
    sys.exit(cli.main(TESTS))
