# SPDX-License-Identifier: AGPL-3.0-or-later
"""For tests of rigs: scenes in few words, and what the baker makes of one beside the oracle
(tests/reference/skin_scene.py)."""
import json
import os

import numpy as np

import test_bake_cli as cli
import skin_meshes  # test_bake_cli put it on the path
import skin_scene
import wgl
import wgl_player
import wgl_shape
import wgl_skin

os.environ.update(XDG_CACHE_HOME=cli.path("cache"), OPENBLAS_NUM_THREADS="1",
                  OMP_NUM_THREADS="1")

# Of the mesh's tolerance the bones' weights take nine tenths, in poses that the baker looks at; what lies
# between those may take a twentieth more, and channels what their own tolerances move.
BETWEEN = 1.05
DEGREES = 0.004

# bounded.h: every weight within 1e-4 of the exact minimiser. Endpoint weights may know another part of
# the shape where a bone's weights are about 1e-7.
WEIGHT, END = 1.5e-4, 2e-3


def write_files():
    for name, data in skin_meshes.files().items():
        cli.write(name, data)


# ---- scenes ----------------------------------------------------------------------------------------
def bone(name, start, end, **more):
    return dict({"name": name, "from": start, "to": end}, **more)


def on(name, start, end, *joints, **more):
    return bone(name, start, end, joints=list(joints), **more)


def point(name, at, *joints, **more):
    return dict({"name": name, "at": at, "joints": list(joints)}, **more)


def turn(channel, axis="z", **more):
    return dict({"turn": axis, "channel": channel}, **more)


def move(channel, axis="x"):
    return {"move": axis, "channel": channel}


def keys(channel, *values, kind="cubic", step=0.5):
    return {"channel": channel, "kind": kind,
            "keys": [{"time": step * i, "value": v} for i, v in enumerate(values)]}


DEG = dict(unit="deg", tolerance=DEGREES)
UNITS = {"deg": DEG, "mm": dict(unit="mm", tolerance=0.005), "none": dict(tolerance=1e-4),
         "long": dict(tolerance=1e-4, rest=1), "glow": dict(tolerance=0.01)}


def scene_of(mesh, rig, curves, channels, tolerance=0.5, **more):
    """channels: name=unit. curves: of one clip."""
    given = mesh if isinstance(mesh, dict) else {"file": mesh}
    return dict({"name": "t", "channels": [dict(name=n, **UNITS[u]) for n, u in channels.items()],
                 "meshes": [dict({"name": "m", "tolerance": tolerance}, **given)],
                 "rigs": [dict({"name": "r", "mesh": "m", "influences": 8}, **rig)],
                 "clips": [{"name": "c", "curves": curves}]}, **more)


def bake(scene):
    cli.write("t.yaml", json.dumps(scene))
    cli.expect(cli.DONE, cli.bake("t", "--quiet", "--json=" + cli.path("t.json")))


class Baked:
    """A scene as a clip, and as the oracle has it."""

    def __init__(self, scene, index=0):
        bake(scene)
        self.report = json.loads(cli.read("t.json"))["rigs"][index]
        self.scene, self.index, self.clip = scene, index, wgl.Clip(cli.read("t.wgl"))
        self.skins = wgl_skin.Skins(wgl_shape.Shapes(self.clip))
        self.rig = skin_scene.Rig(scene, cli.path("t.yaml"), index)
        self.captured = lambda t: {}  # channels that captures fill
        self.names = {c["name"]: i for i, c in enumerate(scene["channels"])}
        self.order = self.match()

    def match(self):
        """The oracle's vertex of each of the clip's."""
        shape = self.clip.shapes[self.index]
        rest = np.array(self.skins.shapes.deformed(shape, [0] * shape.basis_count), float)
        origin = [shape.origin_x, shape.origin_y, shape.origin_z]
        rest = (rest.reshape(-1, 3) + origin) / 2.0 ** shape.frac
        far = np.linalg.norm(rest[:, None] - self.rig.rest, axis=2)
        assert far.min(axis=1).max() < 2.0 ** -shape.frac, far.min(axis=1).max()
        order = far.argmin(axis=1)
        assert len(set(order)) == len(order) == len(self.rig.rest)
        return order

    def raw(self, c, t):
        values = self.clip.sample(c, round(t * 1e6))[0]
        wgl_player.apply_filters(self.clip.filters, values)
        self.skins.set_fields(values)
        return values

    def vertices(self, raw):
        flat, shape = self.skins.vertices(self.index, raw), self.clip.shapes[self.index]
        return np.array(flat, float).reshape(-1, 3) / 2.0 ** (shape.frac + 8)

    def times(self, c=0, count=9):
        end = self.scene["clips"][c].get("duration") or max(
            k["time"] for u in self.scene["clips"][c]["curves"] for k in u["keys"])
        return np.round(np.linspace(0, end, count) * 0.999, 6)

    def shows(self, c=0, most=1.0, times=None):
        """Every vertex where the oracle has it. most: what else is allowed, in tolerances."""
        tolerance, worst, moved = self.scene["meshes"][self.index]["tolerance"], 0, 0
        for t in self.times(c) if times is None else times:
            values = dict(skin_scene.values_at(self.scene, c, t), **self.captured(t))
            want = self.rig.vertices(values)
            far = np.linalg.norm(self.vertices(self.raw(c, t)) - want[self.order], axis=1)
            worst = max(worst, far.max())
            moved = max(moved, np.linalg.norm(want - self.rig.rest, axis=1).max())
        assert worst <= tolerance * BETWEEN * most, (c, worst)
        assert moved >= 30 * tolerance, moved
        return worst

    def weighs(self):
        """The baker's weights on the domain and on the mesh; its certificate."""
        rig, found = self.rig, self.rig.found
        off = abs(found["w"].T - rig.solved.W).max()
        assert off <= WEIGHT, off
        off = abs(found["weight"].T - rig.weight).max()
        assert off <= WEIGHT, off
        for row, energy in zip(self.report["handles"], rig.solved.energies):
            assert abs(row["energy"] - energy) <= 1e-5 * energy + 1e-9, (row, energy)
        if rig.E is not None:
            known = ~np.isnan(rig.E) & (rig.solved.W > 1e-4)
            off = abs(np.where(known, found["e"].T - rig.E, 0)).max()
            assert off <= END, off
            known = rig.weight > 1e-2
            off = abs(np.where(known, found["end"].T - rig.end, 0)).max()
            assert off <= 2 * END, off

    def stands(self):
        """Bones are where the scene says."""
        for b, (name, parent, start, end, along) in zip(self.rig.bones, self.rig.found_bones):
            assert b.name == name and parent == (self.rig.bones.index(b.parent) if b.parent else -1)
            np.testing.assert_allclose([*start, *end], [*b.at, *b.to], atol=1e-5)
            assert abs(along - b.along) < 1e-6 or parent < 0


def agrees_as(scene, index=0, **more):
    baked = Baked(scene, index)
    baked.stands()
    baked.weighs()
    baked.shows(**more)
    return baked


def agrees(*arguments, most=1.0, **more):
    return agrees_as(scene_of(*arguments, **more), most=most)
