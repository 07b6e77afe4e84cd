#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Hostile scenes, meshes and caches of elastic bodies: each ends with a clip within its tolerance or with
a message that names the line and what to do; nothing crashes, hangs or leaves files behind. What is on
disk never changes a clip, and what people change while they work never makes it anew."""
import concurrent.futures
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile

import test_bake_cli as cli
import test_bake_damage as damage

SECONDS = 30  # of one bake: these meshes are small

SCENE = """channels:
- {name: tip, unit: %(channel)s, tolerance: 0.05}
meshes:
- {name: m%(file)s, tolerance: %(tolerance)s}%(meshes)s
bodies:
- name: b
  kind: %(kind)s
  mesh: m
%(body)s
  poses:
  - {name: bent, %(bent)s}
  - {name: tilted, %(tilted)s}
  outputs: [{channel: tip, %(output)s}]%(bodies)s
clips:
- name: c%(clip)s
  bodies:
  - body: b
    %(action)s
    keys: [%(keys)s]
"""
ELASTIC = dict(channel="mm", tolerance="0.3", meshes="", bodies="", clip="", action="stiffness: 1",
               file=", file: m.obj", bent="drag: [{region: tip, by: [4, 0, 2]}]",
               tilted="drag: [{region: tip, by: [-1, 0, 5]}]", output="region: tip, direction: x",
               keys="{time: 0, pose: rest}, {time: 0.4, pose: bent}, {time: 1, pose: tilted}")
SOLID = dict(ELASTIC, kind="solid", body="""  unit: 1 mm
  material: {young: 20 kPa, poisson: 0.4, density: 1000}
  modes: 5
  damping: [0.5, 0.004]
  gravity: [0, 0, 0]
  regions: [{name: base, below: {y: 0.5}}, {name: tip, above: {y: 29.5}}]
  fixed: [base]""")
SHELL = dict(ELASTIC, kind="shell", bent="drag: [{region: tip, by: [0, -2, 8]}]", body="""  unit: 1 mm
  material: {young: 100 kPa, poisson: 0.3, density: 300}
  thickness: 1 mm
  modes: 5
  damping: [2, 0.02]
  regions: [{name: base, below: {y: 0.5}}, {name: tip, above: {y: 29.5}}]
  fixed: [base]""", tilted="modes: [{mode: 1, by: 5}]")
CHAIN = dict(ELASTIC, kind="chain", channel="deg", file="", body="""  gravity: [0, -9.81, 0]
  links: [{name: arm, length: 20, angle: 90, mass: 5 g, spring: 0.01}, {name: hand, parent: arm, length: 20, angle: 90, mass: 5 g, spring: 0.01}]""",
             bent="joints: [{link: arm, angle: 60}]", tilted="modes: [{mode: 1, by: 9}]", output="joint: hand")


def scene(of, *changes, **fields):
    """changes: words of the scene, and what they become."""
    text = SCENE % dict(of, **fields)
    for old, new in zip(changes[::2], changes[1::2]):
        assert text.count(old) == 1, (old, text)
        text = text.replace(old, new)
    return text


# ---- meshes ----------------------------------------------------------------------------------------
def obj(vertices, faces):
    return "".join("v %.9g %.9g %.9g\n" % tuple(v) for v in vertices) + "".join(
        "f %s\n" % " ".join(str(i + 1) for i in f) for f in faces)


def box(cells=(1, 3, 1), size=(10, 30, 10)):
    """The surface of a box: triangles counter-clockwise seen from outside."""
    index, vertices, faces = {}, [], []

    def corner(*p):
        if p not in index:
            index[p] = len(vertices)
            vertices.append([x * s / n for x, s, n in zip(p, size, cells)])
        return index[p]

    for a in range(3):
        for side in (0, cells[a]):
            for i in range(cells[(a + 1) % 3]):
                for j in range(cells[(a + 2) % 3]):
                    p = [corner(*[side if k == a else (i + u if k == (a + 1) % 3 else j + v) for k in range(3)])
                         for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))]
                    p = p if side else p[::-1]
                    faces += [p[:3], [p[0], p[2], p[3]]]
    return vertices, faces


def sheet(n=4, size=30):
    vertices = [[i * size / n, j * size / n, 0] for j in range(n + 1) for i in range(n + 1)]
    faces = []
    for a in (j * (n + 1) + i for j in range(n) for i in range(n)):
        faces += [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    return vertices, faces


BOX, SHEET = box(), sheet()
TETRAHEDRON = [[0, 0, 0], [30, 0, 0], [0, 30, 0], [0, 0, 30]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
MESH = {"solid": obj(*BOX), "shell": obj(*SHEET), "chain": ""}


# ---- baking ----------------------------------------------------------------------------------------
class Answer:
    def __init__(self, code, said, warned, clip):
        self.code, self.said, self.warned, self.clip = code, said, warned, clip


def kind_of(text):
    return re.search(r"kind: (\w+)", text + "kind: solid").group(1)


def bake(text, mesh=None, cache=None, threads="1", **files):
    """In a directory of its own, which must be left as it was, but for the clip. Whatever it answers is
    an answer that may be: this is the check of all tests here."""
    where = tempfile.mkdtemp(dir=cli.folder)
    files.update({"s_yaml": text, "m_obj": MESH.get(kind_of(text), "") if mesh is None else mesh})
    for name, content in files.items():
        with open(os.path.join(where, name.replace("_", ".")), "wb") as f:
            f.write(content if isinstance(content, bytes) else content.encode())
    before = set(os.listdir(where))
    environment = dict(os.environ, XDG_CACHE_HOME=cache or cli.path("cache"))
    environment.pop("OPENBLAS_NUM_THREADS", None)
    if threads:
        environment["OPENBLAS_NUM_THREADS"] = threads
    done = subprocess.run([cli.WIGGLY, "bake", "s.yaml", "-o", "s.wgl", "--quiet"], cwd=where, timeout=SECONDS,
                          env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    lines = done.stderr.decode(errors="replace").splitlines()
    warned = [x for x in lines if re.match(r"s\.yaml:\d+: .*warning: ", x)]
    said = [x for x in lines if x not in warned]
    left = set(os.listdir(where)) - before
    assert done.returncode in damage.ANSWERS, (done.returncode, lines)
    assert done.stdout == b"", done.stdout
    if done.returncode == cli.DONE:
        assert not said and left == {"s.wgl", "s.h", "s.c"}, (said, left)
    else:
        assert len(said) == 1 and not left, (said, left)
        assert re.match(r"wiggly bake: s\.yaml:%s " % (r"\d+:" if done.returncode == cli.FAILED else ""),
                        said[0]), said
        assert not re.search(r"\b(nan|inf)\b", said[0].replace("'nan'", "")), said
        assert all(c >= " " for c in said[0]), said
    clip = None
    if done.returncode == cli.DONE:
        with open(os.path.join(where, "s.wgl"), "rb") as f:
            clip = f.read()
    shutil.rmtree(where)
    return Answer(done.returncode, " ".join(said), warned, clip)


def all_of(jobs):
    """Two at a time: (function, arguments, keywords)."""
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return [f.result() for f in [pool.submit(j[0], *j[1], **j[2]) for j in jobs]]


def refuse(cases):
    """(scene, mesh or None, words of the message): all words are in it, and nothing is written."""
    for (text, mesh, *words), got in zip(cases, all_of([(bake, c[:2], {}) for c in cases])):
        assert got.code == cli.FAILED, (got.code, words, text)
        for word in words:
            assert word in got.said, "no '%s' in: %s" % (word, got.said)


def accept(*cases):
    for case, got in zip(cases, all_of([(bake, c, {}) for c in cases])):
        assert got.code == cli.DONE, (got.said, case[0])


# ---- meshes that are no bodies -----------------------------------------------------------------------
def moved(mesh, way):
    return [[x + d for x, d in zip(v, way)] for v in mesh[0]], mesh[1]


def both(a, b):
    return a[0] + b[0], a[1] + [[i + len(a[0]) for i in f] for f in b[1]]


def turned(faces):
    return [f[::-1] for f in faces]


def solids_that_have_no_inside_are_refused():
    solid = scene(SOLID)
    flat = [[x, y, 0] for x, y, z in BOX[0]]
    refuse([(solid, obj(BOX[0], BOX[1][2:]), "s.yaml:", "has a hole at", "close it"),
            (solid, obj(flat, BOX[1]), "more than two triangles", "remove"),
            (solid, obj(BOX[0], BOX[1] + turned(BOX[1])), "more than two triangles"),
            (solid, obj(*both(BOX, moved(BOX, (4, 4, 4)))), "cross or touch", "move what overlaps apart"),
            (solid, obj(BOX[0][:3], [[0, 1, 2]]), "closed surface"),
            (solid, obj(*SHEET), "has a hole"),
            (solid, "v nan 0 0\n" + obj(*BOX).split("\n", 1)[1], "finite"),
            (solid, "", "cannot be read"),
            (scene(SOLID, "modes: 5", "modes: 5\n  cell: 1e-6"), None, "tetrahedra", "'cell' of")])


def solids_with_odd_but_whole_surfaces_are_bodies():
    solid = scene(SOLID)
    accept((solid, obj(BOX[0], turned(BOX[1]))), (solid, obj(*both(BOX, moved(BOX, (40, 0, 0))))),
           (solid, obj(BOX[0] + [[99, 99, 99]], BOX[1])), (scene(SOLID, "modes: 5", "modes: 120"), None),
           (scene(SOLID, "modes: 5", "modes: 120\n  cell: 100", "fixed: [base]", "fixed: []"), obj(*TETRAHEDRON)))


def shells_of_more_than_a_sheet_are_refused():
    shell, corner = scene(SHELL), len(SHEET[0])
    refuse([(shell, obj(SHEET[0], SHEET[1] + [[0, 1, 2]]), "triangle 32", "no area"),
            (shell, obj(SHEET[0] + [[9, 9, 9]], SHEET[1] + [[6, 7, corner]]), "more than two triangles"),
            (shell, obj(SHEET[0], SHEET[1] + turned(SHEET[1])), "the same vertices", "remove one")])
    mixed = SHEET[1][:12] + turned(SHEET[1][12:])
    needles = [[1e-4 * x, y, z] for x, y, z in SHEET[0]]
    accept((shell, obj(SHEET[0], mixed)), (scene(SHELL, tilted="move: [0, 0, 0.1]", action="about: rest\n    fixed: []"), obj(needles, SHEET[1])))


# ---- scenes that ask for what is not to be had --------------------------------------------------------
def regions_that_hold_nothing_or_everything_are_named():
    one = ("modes: 5", "modes: 5\n  cell: 100", "tip, above: {y: 29.5}", "tip, above: {y: 29}",
           "base, below: {y: 0.5}", "base, below: {y: 5}")
    line = ("fixed: [base]", "fixed: [base]\n  sliding: [{region: tip, normal: x}, {region: tip, normal: y}]",
            "by: [4, 0, 2]", "by: [0, 0, 2]", "by: [-1, 0, 5]", "by: [0, 0, 5]")
    refuse([(scene(SOLID, "below: {y: 0.5}", "below: {y: -5}"), None, "s.yaml:14:", "'base' holds none", "between (0, 0, 0) and (10, 30, 10)"),
            (scene(SOLID, "tip, above: {y: 29.5}", "tip, vertices: [0, 900]"), None, "s.yaml:14:", "vertex 900"),
            (scene(SOLID, "below: {y: 0.5}", "below: {y: 99}"), None, "holds"),
            (scene(SOLID, *one, *line), obj(*TETRAHEDRON), "one vertex alone"),
            (scene(SHELL, "drag: [{region: tip, by: [0, -2, 8]}]", "move: [0, 0, 9]"), None, "s.yaml:25:",
             "'bent' moves by 9", "`about`"),
            (scene(SHELL, channel="deg", output="region: tip, turn: x"), None, "a line along the axis")])
    accept((scene(SOLID, *one), obj(*TETRAHEDRON)))


def poses_that_no_body_takes_say_how_far_it_got():
    refuse([(scene(SOLID, "by: [4, 0, 2]", "by: [0, -60, 0]"), None, "s.yaml:17:", "'bent'", "% of the way"),
            (scene(SOLID, "by: [4, 0, 2]", "by: [1e6, 0, 0]"), None, "s.yaml:17:", "% of the way"),
            (scene(SOLID, "region: tip, by: [4, 0, 2]", "region: tip, by: [0, -29.99, 0]"), None, "% of the way"),
            (scene(SOLID, "drag: [{region: tip, by: [4, 0, 2]}]", "modes: [{mode: 9, by: 1}]"), None, "s.yaml:17:",
             "wants mode 9 of 5", "raise"),
            (scene(SOLID, "drag: [{region: tip, by: [4, 0, 2]}]", "modes: [{mode: 5, by: 1000}]", "stiffness: 1",
                   "dynamics: blend"), None, "s.yaml:17:", "'bent'", "inside out")])


def keys_that_a_tick_cannot_part_are_named():
    near = "{time: 0, pose: rest}, {time: 0.001, pose: bent}, {time: %s, pose: tilted}"
    refuse([(scene(SOLID, keys=near % 3600), None, "s.yaml:25:", "0 s and 0.001 s", "one tick of 0.0556 s"),
            (scene(SOLID, keys=near % 0), None, "ascend"),
            (scene(SOLID, keys=near % 0.001), None, "at least 1 ms"),
            (scene(SOLID, keys="{time: 0, pose: rest}, {time: 0.001, pose: bent}"), None, "within a tick")])
    accept((scene(SOLID, keys=near % 0.002),), (scene(CHAIN, keys=near % 0.002),))


def motions_that_are_not_determined_say_so():
    free = "start: free\n    end: free"
    partial = "{time: 0, pose: rest}, {time: 0.5, pose: bent, region: base}, {time: 1, pose: rest}"
    refuse([(scene(SOLID, action=free, keys="{time: 0, pose: rest}, {time: 1, pose: bent}"), None, "s.yaml:23:",
             "mode ", " Hz)", "undetermined"),
            (scene(SOLID, action="dynamics: spline", keys="{time: 0, pose: rest}, {time: 1, pose: rest}"), None,
             "s.yaml:23:", "nothing moves"),
            (scene(SOLID, keys=partial), None, "s.yaml:23:", "cannot move"),
            (scene(SOLID, clip="\n  additive: true"), None, "additive"),
            (scene(SOLID, bodies="\n- {name: b2, kind: shell, mesh: m2, thickness: 1, material: paper}",
                   meshes="\n- {name: m2, file: x.obj}"), None, "'x.obj'")])


def extremes_of_everything_are_answered():
    """No word of the answers is expected: bake() looks at what they have in common."""
    numbers = [("young: 20 kPa", ["young: %s" % x for x in ("1 Pa", "10000 GPa", "0", "nan")]),
               ("poisson: 0.4", ["poisson: %s" % x for x in ("0.499", "-0.99", "0.5")]),
               ("density: 1000", ["density: %s" % x for x in ("1e-3", "1e5")]),
               ("unit: 1 mm", ["unit: %s" % x for x in ("1 m", "1000 m", "0.000001 m", "1e-9 m")]),
               ("gravity: [0, 0, 0]", ["gravity: [0, %s, 0]" % x for x in ("-981", "1e6")]),
               ("[0.5, 0.004]", ["[1e6, 0]", "[0, 1e6]", "[0, 0]", "[-1, 0]"]),
               ("stiffness: 1", ["stiffness: 1e-6", "stiffness: 1e6", "dynamics: blend\n    stiffness: 1e6",
                                 "dynamics: couple\n    stiffness: 1e-6", "regularise: [1e9, 1e9, 1e9]"])]
    texts = [scene(SOLID, old, new) for old, all_new in numbers for new in all_new]
    texts += [scene(SHELL, "thickness: 1 mm", "thickness: %s" % x) for x in ("0.0001 mm", "1 m", "1e-9", "-1")]
    link = "length: 20, angle: 90, mass: 5 g, spring: 0.01}]"
    texts += [scene(CHAIN, link, x) for x in (
        "length: 1e5, angle: 90, mass: 5 g, spring: 1e9}]", "length: 20, angle: 90, spring: 0.01}]",
        "length: 20, angle: 1e5, mass: 1e-9 kg}]", "length: 20, angle: 90, mass: 5 g, stiff: true}]")]
    answers = all_of([(bake, (text,), {}) for text in texts])
    assert {a.code for a in answers} >= {cli.DONE, cli.FAILED}


def motion_that_frames_cannot_show_is_warned_of():
    got = bake(scene(CHAIN, action="stiffness: 1e5\n    damping: [0, 0]",
                     keys="{time: 0, pose: rest}, {time: 1, pose: bent, velocity: [{link: arm, rate: 90000}]}"))
    assert any("swings faster than frames" in x for x in got.warned) or got.code != cli.DONE, got.said
    assert not bake(scene(CHAIN)).warned


def what_is_attached_to_a_shell_keeps_its_shape():
    """A cube that stands off a sheet: it moves with the sheet and is not pressed into it."""
    button = moved(box((1, 1, 1), (5, 5, 5)), (10, 20, 2))
    got = bake(scene(SHELL, "  unit: 1 mm", "  attached: [n]\n  unit: 1 mm",
                     meshes="\n- {name: n, file: n.obj, tolerance: 0.3}"), n_obj=obj(*button))
    assert got.code == cli.DONE, got.said  # the certificate compares with the mesh's own rest


def mutated_scenes_are_baked_or_refused():
    """The seed is fixed. Of the body's part alone: the rest of a scene has tests of its own."""
    def mutants(of, seed, count):
        text = scene(of).encode()
        start = text.index(b"bodies:")
        mutations = damage.text(text[start:], random.Random(seed))
        return [text[:start] + next(mutations) for _ in range(count)]

    texts = [t for i, of in enumerate((SOLID, SHELL, CHAIN)) for t in mutants(of, i, 40)]
    jobs = [(bake, (t.decode(errors="surrogateescape").encode(errors="surrogateescape").decode("latin-1"),),
             {"mesh": MESH[("solid", "shell", "chain")[i // 40]]}) for i, t in enumerate(texts)]
    codes = [a.code for a in all_of(jobs)]
    assert cli.DONE in codes and cli.FAILED in codes, codes


# ---- what is on disk -----------------------------------------------------------------------------------
BLEND = dict(SHELL, action="dynamics: blend\n    stiffness: 1")

# What a result may depend on.
CHANGES = [(SOLID,), (SOLID, "young: 20", "young: 21"), (SOLID, "poisson: 0.4,", "poisson: 0.41,"),
           (SOLID, "density: 1000", "density: 1001"), (SOLID, "unit: 1 mm", "unit: 1.01 mm"),
           (SOLID, "modes: 5", "modes: 6"), (SOLID, "modes: 5", "modes: 5\n  cell: 6"),
           (SOLID, "gravity: [0, 0, 0]", "gravity: [0, -0.1, 0]"), (SOLID, "by: [4, 0, 2]", "by: [4, 0, 2.1]"),
           (SOLID, "below: {y: 0.5}", "below: {y: 11}"), (SOLID, "fixed: [base]", "sliding: [{region: base, normal: y}]"),
           (SOLID, "stiffness: 1", "about: bent"), (SOLID, "stiffness: 1", "dynamics: couple"),
           (SOLID, "stiffness: 1", "dynamics: spline"), (SOLID, "time: 0.4", "time: 0.5"),
           (SOLID, "[0.5, 0.004]", "[0.6, 0.004]"), (SOLID, "stiffness: 1", "stiffness: 1.1"),
           (BLEND,), (BLEND, "thickness: 1 mm", "thickness: 1.1 mm"), (BLEND, "mode: 1, by: 5", "mode: 1, by: 5.1"),
           (BLEND, "stiffness: 1", "fixed: []\n    stiffness: 1"), (BLEND, "pose: bent}", "pose: tilted}")]

# What people change while they work: of one-point motion everything but the body and its poses.
TOUCHES = [("time: 0.4", "time: 0.45"), ("[0.5, 0.004]", "[0.1, 0.001]"), ("stiffness: 1", "stiffness: 3"),
           ("stiffness: 1", "regularise: [1, 0, 0]"), ("stiffness: 1", "end: free"),
           ("pose: bent}", "pose: bent, weight: 10}"), ("pose: bent}", "pose: bent, velocity: [9, 0, 0]}"),
           ("tolerance: 0.3", "tolerance: 0.2"), ("direction: x", "direction: z")]


def cached(name):
    folder = os.path.join(cli.path(name), "wiggly")
    return {n: os.path.join(folder, n) for n in os.listdir(folder)} if os.path.isdir(folder) else {}


def warm_and_cold_bakes_are_alike():
    """All scenes after each other on one cache, then each on none, then again on all that there is."""
    texts = [scene(*c) for c in CHANGES]
    moving = obj(moved(BOX, (0, 0, 0))[0][:-1] + [[10.5, 30, 10]], BOX[1])
    jobs = [(t, None) for t in texts] + [(texts[0], moving)]
    filled = [bake(t, mesh, cache=cli.path("warm")) for t, mesh in jobs]
    before = set(cached("warm"))
    colds = all_of([(bake, (t, mesh), {"cache": cli.path("cold%d" % i)}) for i, (t, mesh) in enumerate(jobs)])
    again = all_of([(bake, (t, mesh), {"cache": cli.path("warm")}) for t, mesh in jobs])
    for (t, _), a, b, c in zip(jobs, filled, colds, again):
        assert a.code == cli.DONE, (a.said, t)
        assert a.clip == b.clip == c.clip, t
    assert len({a.clip for a in filled}) == len(filled), "a change that does not show is no test"
    assert set(cached("warm")) == before and len(before) > 20, "a second bake computes nothing"


def work_on_a_motion_computes_nothing_anew():
    text = scene(SOLID)
    assert bake(text, cache=cli.path("touch")).code == cli.DONE
    before = set(cached("touch"))
    assert len(before) == 5, before  # tetrahedra, two poses, modes, a reduced space
    for old, new in TOUCHES:
        got = bake(scene(SOLID, old, new), cache=cli.path("touch"))
        assert got.code == cli.DONE, (got.said, new)
        assert set(cached("touch")) == before, new
    bake(scene(SOLID, "young: 20", "young: 30"), cache=cli.path("touch"))
    assert len(cached("touch")) > len(before)


def damaged_caches_cost_time_alone():
    """Every file cut, flipped, emptied, or another one's."""
    text = scene(SOLID)
    want = bake(text, cache=cli.path("hurt")).clip
    names = sorted(cached("hurt").values())
    for way in range(5):
        contents = [damage.whole(n) for n in names]
        for i, name in enumerate(names):
            data = bytearray(contents[i])
            if way == 0:
                data = data[:len(data) // 2]
            elif way == 1:
                data[len(data) // 2] ^= 1
            elif way == 2:
                data = b""
            elif way == 3:
                data = contents[i - 1]
            else:
                data[8:16] = b"\xff" * 8  # a size beyond all bounds
            with open(name, "wb") as f:
                f.write(data)
        assert bake(text, cache=cli.path("hurt")).clip == want, way
        assert [damage.whole(n) for n in names] == contents, "repaired"
    for place in ("/proc/none", os.path.join(cli.path("hurt"), "wiggly", os.path.basename(names[0]))):
        assert bake(text, cache=place).clip == want, place
    for name in names:  # directories where files should be
        os.remove(name)
        os.mkdir(name)
    assert bake(text, cache=cli.path("hurt")).clip == want
    assert sorted(cached("hurt").values()) == names, "no temporary file stays"


def bakes_at_once_on_one_cache_are_alike():
    text = scene(SOLID)
    want = bake(text, cache=cli.path("alone")).clip
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        runs = [pool.submit(bake, text, None, cli.path("shared")) for _ in range(4)]
        assert all(r.result().clip == want for r in runs)
    assert set(cached("shared")) == set(cached("alone"))


def clips_do_not_depend_on_threads():
    for of in (SOLID, BLEND, CHAIN):
        clips = {bake(scene(of), cache=cli.path("threads%s" % n), threads=n).clip for n in ("1", "2", None)}
        shutil.rmtree(cli.path("threads1"), ignore_errors=True)
        shutil.rmtree(cli.path("threads2"), ignore_errors=True)
        shutil.rmtree(cli.path("threadsNone"), ignore_errors=True)
        assert len(clips) == 1 and None not in clips, of["kind"]


TESTS = (solids_that_have_no_inside_are_refused, solids_with_odd_but_whole_surfaces_are_bodies,
         shells_of_more_than_a_sheet_are_refused, regions_that_hold_nothing_or_everything_are_named,
         poses_that_no_body_takes_say_how_far_it_got, keys_that_a_tick_cannot_part_are_named,
         motions_that_are_not_determined_say_so, extremes_of_everything_are_answered,
         motion_that_frames_cannot_show_is_warned_of, what_is_attached_to_a_shell_keeps_its_shape,
         mutated_scenes_are_baked_or_refused, warm_and_cold_bakes_are_alike,
         work_on_a_motion_computes_nothing_anew, damaged_caches_cost_time_alone,
         bakes_at_once_on_one_cache_are_alike, clips_do_not_depend_on_threads)

if __name__ == "__main__":
    sys.exit(cli.main(TESTS))
