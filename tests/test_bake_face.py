#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""The talking face: its base shapes against their files, through the independent decoder."""
import os
import random
import re
import sys

import numpy as np
import test_bake_cli as cli
import wgl  # test_bake_cli put them on the path
import wgl_player
import wgl_shape

FACE = os.path.join(cli.ROOT, "examples", "face")
TOLERANCE = 0.2  # mm, of the mesh in face.yaml: a posed vertex from where it should be
SHAPES = "A E O M smile grumble brows blink look tuft".split()


def scene_text():
    """face.yaml, for a scene elsewhere: its files by their whole path."""
    with open(os.path.join(FACE, "face.yaml")) as f:
        return re.sub(r"file: (\w+\.obj)", "file: " + FACE + r"/\1", f.read())


def obj(name):
    """Positions, and the corners of all triangles, counted from 0."""
    with open(os.path.join(FACE, name + ".obj")) as f:
        words = [line.split() for line in f]
    return (np.array([w[1:] for w in words if w[:1] == ["v"]], float),
            np.array([w[1:] for w in words if w[:1] == ["f"]], int) - 1)


class Face:
    """The baked clip, and which vertex of the files each of its vertices is: the baker sorts."""

    def __init__(self):
        cli.write("face.yaml", scene_text())
        self.done = cli.expect(cli.DONE, cli.bake("face"))
        self.clip = wgl.Clip(cli.read("face.wgl"))
        self.shapes = wgl_shape.Shapes(self.clip)
        self.shape = self.clip.shapes[0]
        names = [self.clip.name("channels", i) for i in range(len(self.clip.channels))]
        self.channel = {name: names.index(name) for name in SHAPES}
        self.rest = obj("neutral")[0]
        self.file = {name: obj(name)[0] - self.rest for name in SHAPES}
        self.neutral = self.posed({})
        self.moved = {name: self.posed({name: 1.0}) for name in SHAPES}
        self.match()

    def values(self, weights):
        """Raw channel values: rest, and the weights."""
        values = [c.rest for c in self.clip.channels]
        for name in SHAPES:
            channel = self.channel[name]
            values[channel] = round(weights.get(name, 0) * 2.0 ** self.clip.channels[channel].frac)
        return values

    def raw(self, weights):
        """Vertices as the decoder gives them, whole numbers."""
        pose = self.shapes.pose(0, self.values(weights))
        return np.array(self.shapes.vertices(0, pose)).reshape(-1, 3)

    def posed(self, weights):
        return self.raw(weights) / 2.0 ** (self.shape.frac + 8)

    def rounding(self, weights):
        """How far integers may take a vertex, in mm. A coordinate: half a unit in the rest pose and
        in the result; in each basis half a step of its 8 or 16 bits at full weight, and a unit and
        a half because weight and gain are whole numbers of 2^-15."""
        step = {8: 256, 16: 1}[self.clip.blocks[0].bits]
        units = 1 + sum(abs(w) * step / 2 + 1.5 for w in weights.values())
        return 3 ** 0.5 * units / 2.0 ** self.shape.frac

    def match(self):
        """A vertex is known by where it is in all eleven poses together."""
        baked = np.hstack([self.neutral] + [self.moved[n] for n in SHAPES])
        files = np.hstack([self.rest] + [self.rest + self.file[n] for n in SHAPES])
        self.distance = np.array([np.abs(files - b).reshape(len(files), -1, 3) for b in baked])
        self.distance = np.sqrt((self.distance ** 2).sum(3)).max(2)
        self.of = self.distance.argmin(1)


def every_base_shape_is_its_file():
    """Each baked vertex is an OBJ vertex in all poses, and each OBJ vertex is baked."""
    allowed = min(TOLERANCE, face.rounding({"A": 1}))
    assert face.distance.min(1).max() <= allowed, (face.distance.min(1).max(), allowed)
    assert face.distance.min(0).max() <= allowed, (face.distance.min(0).max(), allowed)
    assert len(set(map(tuple, np.round(face.neutral, 3)))) > 600
    print("a base shape: within %.3f mm of its file" % face.distance.min(1).max())


def triangles_keep_their_colours_and_corners():
    colours = {}
    with open(os.path.join(FACE, "face.mtl")) as f:
        for line in f:
            key, *words = line.split()
            if key == "newmtl":
                name = words[0]
            elif key == "Kd":
                colours[name] = tuple(round(255 * float(w)) for w in words)
    want, part = {}, None
    with open(os.path.join(FACE, "neutral.obj")) as f:
        for line in f:
            if line.startswith("usemtl"):
                part = line.split()[1]
            want[colours.get(part)] = want.get(colours.get(part), 0) + line.startswith("f ")
    want.pop(None)
    got = {}
    for p in face.clip.parts:
        colour = p.red, p.green, p.blue
        got[colour] = got.get(colour, 0) + p.triangles
    assert got == want, (got, want)
    # corner for corner and in their order, wherever the baker put the vertices and begins to count
    files = face.rest[obj("neutral")[1]]
    for p in face.clip.parts:
        for corners in face.neutral[np.array(p.corners).reshape(-1, 3)]:
            off = min(np.abs(files - np.roll(corners, k, 0)).max((1, 2)).min() for k in range(3))
            assert off <= TOLERANCE, (corners, off)


def shapes_add_up():
    """V(r + s) - V0 = (V(r) - V0) + (V(s) - V0), and both are what the files say [Alexa 7.1.1]."""
    pick = random.Random(7)
    largest = 0.0
    for _ in range(40):
        names = pick.sample(SHAPES, 6)
        r = {name: pick.random() for name in names[:3]}
        s = {name: pick.random() for name in names[3:]}
        both, one, other, none = (face.raw(w) for w in ({**r, **s}, r, s, {}))
        # the sums are exact; each of the four results is rounded once, by half a unit at the most
        unit = 1 << 8
        assert np.abs(both - one - other + none).max() <= 2 * unit
        want = face.rest + sum(w * face.file[n] for n, w in {**r, **s}.items())
        off = np.sqrt(((face.posed({**r, **s}) - want[face.of]) ** 2).sum(1)).max()
        assert off <= face.rounding({**r, **s}), off
        largest = max(largest, off)
    assert np.abs(face.posed({"A": 1.0}) - face.neutral).max() > 5  # something moves
    print("six shapes at once: within %.3f mm of their files" % largest)


def a_shape_leaves_all_others_vertices_alone():
    first, count = face.shape.block_first, face.shape.block_count
    blocks = face.clip.blocks[first:first + count]
    neutral = face.raw({})
    for j, basis in enumerate(face.shape.bases):
        name = next(n for n in SHAPES if face.channel[n] == basis.channel)
        inside = np.zeros(face.shape.vertices, bool)
        for b in blocks:
            if j in (b.a, b.b):
                inside[b.first:b.first + b.count] = True
        moved = (face.raw({name: 1.0}) != neutral).any(1)
        assert moved.any() and not (moved & ~inside).any(), name
        still = (face.file[name] == 0).all(1)[face.of]
        assert still.any() and not (moved & still).any(), name
        print("%-8s %3d of %d vertices move, its blocks hold %d" % (
            name, (~still).sum(), len(still), inside.sum()))
    lids = (face.file["blink"] != 0).any(1)
    assert lids.sum() < len(lids) / 10


def filters_clamp_and_it_always_smiles():
    limits = {**dict.fromkeys("A E O M brows blink".split(), (0, 1)), "smile": (0.15, 1),
              "look": (-1, 1), "tuft": (-1, 1)}
    for x in (-2.0, -0.3, 0.1, 0.6, 2.0):
        values = face.values(dict.fromkeys(SHAPES, x))
        wgl_player.apply_filters(face.clip.filters, values)
        for name, (low, high) in limits.items():
            frac = face.clip.channels[face.channel[name]].frac
            # a constant is rounded to a whole raw unit
            assert abs(values[face.channel[name]] - min(max(x, low), high) * 2.0 ** frac) <= 1, name


def it_blinks_when_it_is_told_to():
    done = cli.wiggly("play", cli.path("face.wgl"), "--csv", "-", "--seconds", "4")
    head, rows = cli.rows_of(done.stdout)
    got = {h: np.array([float(r[i]) for r in rows]) for i, h in enumerate(head)}
    shut = got["time"][got["blink"] > 0.9]
    # shut from 80 to 120 ms after the events at 0.75, 2.5 and 2.85 s
    for event in (0.75, 2.5, 2.85):
        near = shut[(shut > event) & (shut < event + 0.3)]
        assert len(near) and abs(near.mean() - event - 0.1) <= 0.03, (event, near)
    assert got["blink"].min() >= 0 and got["blink"].max() <= 1 and got["smile"].min() > 0.149
    talks = got["A"] > 0.8
    assert talks.any() and got["smile"][talks].min() > 0.45


def the_swap_in_the_comment_works():
    """[Alexa 7.1.2]: a matrix makes every smile a grumble."""
    text = scene_text().replace("  # - {op: matrix", "  - {op: matrix")
    cli.write("swap.yaml", text)
    cli.expect(cli.DONE, cli.bake("swap", "--quiet"))
    plain, swap = (cli.wiggly("play", cli.path(n + ".wgl"), "--csv", "-", "--seconds", "2")
                   for n in ("face", "swap"))
    head, rows = cli.rows_of(plain.stdout)
    _, swapped = cli.rows_of(swap.stdout)
    smile, grumble = head.index("smile"), head.index("grumble")
    for a, b in zip(rows[10:], swapped[10:]):
        # before the clamp the smile grows from 0, so compare once it is above the minimum
        if float(a[smile]) > 0.17:
            assert abs(float(b[grumble]) - float(a[smile])) <= 0.02, (a, b)
            assert abs(float(b[smile]) - 0.15) <= 0.001, b


def committed_meshes_are_what_the_script_makes():
    sys.path.insert(0, FACE)
    import make_face
    for name, pose in make_face.POSES.items():
        vertices, parts = make_face.assemble(pose)
        # the last printed digit may differ where another numpy rounds a tie the other way
        assert np.abs(obj(name)[0] - vertices).max() <= 0.011, name
        assert len(obj(name)[1]) == sum(map(len, parts.values()))
        assert os.path.getsize(os.path.join(FACE, name + ".obj")) < 40000


TESTS = (every_base_shape_is_its_file, triangles_keep_their_colours_and_corners, shapes_add_up,
         a_shape_leaves_all_others_vertices_alone, filters_clamp_and_it_always_smiles,
         it_blinks_when_it_is_told_to, the_swap_in_the_comment_works,
         committed_meshes_are_what_the_script_makes)

if __name__ == "__main__":
    face = Face()
    print("clip: %d bytes, %d of them data" % (len(cli.read("face.wgl")), len(face.clip.data)))
    sys.exit(cli.main(TESTS))
