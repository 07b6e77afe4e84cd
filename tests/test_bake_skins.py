#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Rigs from scene to clip: what the reference decoder shows, at times of our own, against a second
implementation of the whole way (tests/reference/skin_scene.py, skin_oracle.py): Laplacians, bounded
weights, endpoint weights, bones, skinning, fields. Meshes, drawings and scenes are written here."""
import contextlib
import io
import sys

import numpy as np
from scipy.spatial.transform import Rotation

import test_bake_cli as cli
import rig_oracle  # test_bake_cli put it on the path
import skin_meshes
import skin_scene
import wgl
import wgl_shape
import wgl_skin
from skin_baked import (BETWEEN, UNITS, Baked, agrees, agrees_as, bake, bone, keys, move, on, point,
                        scene_of, turn, write_files)

ARM = [on("upper", [10, 0, 0], [50, 0, 0], turn("a", [0, 1, 3])),
       dict(on("lower", [50, 0, 0], [90, 0, 0], turn("b")), parent="upper")]
BEND = [keys("a", 0, 20, -25), keys("b", 0, 70, -40)]
HINGES = {"a": "deg", "b": "deg"}


# ---- methods ---------------------------------------------------------------------------------------
def two_bones_bend_a_bar():
    for method in ("linear", "dual"):
        agrees("bar.obj", {"cell": 9, "bones": ARM, "method": method}, BEND, HINGES)


def bones_stretch_and_twist():
    """(6.5) and (6.6); twist beyond a turn."""
    bones = [on("upper", [10, 0, 0], [50, 0, 0], turn("a"), {"stretch": "s"}),
             dict(on("lower", [50, 0, 0], [90, 0, 0], {"twist-start": "u"}, {"twist": "v"}),
                  parent="upper")]
    curves = [keys("a", 0, 30), keys("s", 1, 1.6), keys("u", 0, 60), keys("v", 0, 400)]
    units = {"a": "deg", "s": "long", "u": "deg", "v": "deg"}
    for method in ("linear", "dual"):
        agrees("bar.obj", {"cell": 9, "bones": bones, "method": method}, curves, units)


def twists_without_endpoint_weights_move_children_alone():
    """And so do stretches, with `ends: none`."""
    bones = [on("upper", [10, 0, 0], [50, 0, 0], turn("a"), {"twist-start": "u"}, {"stretch": "s"}),
             dict(on("lower", [50, 0, 0], [90, 0, 0], {"twist": "v"}), parent="upper"),
             dict(point("tip", [98, 0, 0], turn("a")), parent="lower")]
    for method in ("linear", "dual"):
        agrees("bar.obj", {"cell": 9, "bones": bones, "method": method, "ends": "none"},
               [keys("a", 0, 30), keys("u", 0, 60), keys("v", 0, 100), keys("s", 1, 1.5)],
               {"a": "deg", "u": "deg", "v": "deg", "s": "long"})


def quaternions_of_any_length_turn_alike():
    """Between keys they are shorter, and blends of dual quaternions would weigh by that."""
    bones = [on("a", [10, 0, 0], [50, 0, 0], {"quaternion": "q"}),
             on("b", [50, 0, 0], [90, 0, 0], turn("a"))]
    for method in ("linear", "dual"):
        agrees("bar.obj", {"cell": 9, "bones": bones, "method": method},
               [keys("a", 0, 80), keys("q_w", 1, -0.5, kind="linear"),
                keys("q_z", 0, 0.8, kind="linear")],
               {"a": "deg", "q_w": "long", "q_x": "none", "q_y": "none", "q_z": "none"})


def a_bone_stretches_far():
    """All of the cigar: what one bone's end carries."""
    agrees("cigar.obj", {"cell": 8, "bones": [on("b", [-30, 0, 0], [30, 0, 0], {"stretch": "s"})]},
           [keys("s", 1, 3, 0.25)], {"s": "long"}, tolerance=1)


def endpoint_weights_come_in_four_kinds():
    bones = [on("upper", [10, 0, 0], [50, 0, 0], {"stretch": "s"}, {"twist": "v"}),
             dict(on("lower", [50, 0, 0], [90, 0, 0], {"twist": "v"}), parent="upper")]
    for kind in ("projection", "distance", "joints"):
        agrees("bar.obj", {"cell": 9, "bones": bones, "ends": kind,
                           "filter": [[0.2, 0.05], [0.5, 0.7], [0.8, 0.8]]},
               [keys("s", 1, 1.5), keys("v", 0, 90)], {"s": "long", "v": "deg"}, tolerance=0.7)


def points_move_what_is_around_them():
    points = [point("p", [0, 40], move("x"), move("y", "y")), point("q", [26, 8], move("y")),
              point("r", [-26, 8], turn("a"))]
    agrees({"file": "star.svg", "cell": 9}, {"cell": 6, "bones": points},
           [keys("x", 0, 20), keys("y", 0, -15, 5), keys("a", 0, 60)],
           {"x": "mm", "y": "mm", "a": "deg"})
    agrees({"file": "star.svg", "cell": 9},
           {"cell": 6, "bones": [dict(p, joints=[j for j in p["joints"] if "move" in j])
                                 for p in points], "method": "shift"},
           [keys("x", 0, 20), keys("y", 0, -15, 5)], {"x": "mm", "y": "mm"})


def points_follow_each_other():
    points = [point("p", [0, -14], move("x"), move("y", "y"), {"follow": ["q", "r"]}),
              point("q", [26, 8], move("y"), {"follow": ["p"]}),
              point("r", [-26, 8], {"follow": ["p", "q", "s"]}), point("s", [0, 0])]
    agrees({"file": "star.svg", "cell": 9}, {"cell": 6, "bones": points},
           [keys("x", 0, 30), keys("y", 0, -25, 5)], {"x": "mm", "y": "mm"})


# ---- handles ---------------------------------------------------------------------------------------
def bones_share_joints_and_hang_loose():
    """A joint of three; one bone begins along another; one apart from all."""
    bones = [on("trunk", [20, 20], [50, 20], turn("a")),
             dict(on("left", [50, 20], [80, 34], turn("b")), parent="trunk"),
             dict(on("right", [50, 20], [80, 6], {"stretch": "s"}), parent="trunk"),
             dict(on("rib", [35, 20], [35, 32], turn("b")), parent="trunk"),
             on("loose", [4, 4], [4, 36], move("x"))]
    agrees("sheet.obj", {"cell": 4, "bones": bones},
           [keys("a", 0, 20), keys("b", 0, 50), keys("s", 1, 1.4), keys("x", 0, -12)],
           {"a": "deg", "b": "deg", "s": "long", "x": "mm"})


CORNERS = {"c0": (-10, -10), "c1": (110, -10), "c2": (110, 50), "c3": (-10, 50)}


def cage(places, *moves):
    return [{"name": n, "cage": list(p), "joints": [move(c, a) for k, c, a in moves if k == n]}
            for n, p in places.items()]


def cages_are_closed_open_or_partial():
    moves = ("c1", "x", "x"), ("c2", "y", [1, 2, 0]), ("c0", "y", "y")
    curves, units = [keys("x", 0, 30), keys("y", 0, -20)], {"x": "mm", "y": "mm"}
    names = list(CORNERS)
    ring = [[a, b] for a, b in zip(names, names[1:] + names[:1])]
    agrees("sheet.obj", {"cell": 6, "bones": cage(CORNERS, *moves), "cage": ring,
                         "method": "shift"}, curves, units)
    inner = {n: (min(max(x, 8), 92), min(max(y, 8), 32)) for n, (x, y) in CORNERS.items()}
    for facets in (ring[:3], ring[1:2]):
        agrees("sheet.obj", {"cell": 4, "bones": cage(inner, *moves), "cage": facets},
               curves, units)


def a_closed_cage_goes_around_a_solid():
    at = {"c%d%d%d" % (i, j, k): (-10 + 120 * i, -20 + 40 * j, -20 + 40 * k)
          for i in (0, 1) for j in (0, 1) for k in (0, 1)}
    c = lambda s: ["c" + w for w in s.split()]
    facets = [c(s) for s in ("000 011 010", "000 001 011", "100 110 111", "100 111 101",
                             "000 100 101", "000 101 001", "010 111 110", "010 011 111",
                             "000 110 100", "000 010 110", "001 101 111", "001 111 011")]
    moves = ("c100", "x", "x"), ("c111", "y", [1, 2, 0]), ("c001", "y", "z")
    agrees("bar.obj", {"cell": 14, "bones": cage(at, *moves), "cage": facets, "method": "shift"},
           [keys("x", 0, 40), keys("y", 0, -30)], {"x": "mm", "y": "mm"})


def regions_move_as_one():
    bones = [{"name": "left", "region": {"below": {"x": 15}}},
             {"name": "ball", "region": {"ball": {"centre": [100, 0, 0], "radius": 16}},
              "joints": [turn("a", "x"), move("x", "y")]}]
    for at in ({}, {"at": [90, 5, 0]}):
        agrees("bar.obj", {"cell": 9, "bones": [bones[0], dict(bones[1], **at)]},
               [keys("a", 0, 90), keys("x", 0, 25)], {"a": "deg", "x": "mm"})


def regions_hold_all_of_a_flat_shape_inside():
    """Not its border alone."""
    bones = [point("p", [8, 20], turn("a")),
             {"name": "ball", "region": {"ball": {"centre": [62, 20], "radius": 15}},
              "joints": [turn("a"), move("x", "y")]}]
    baked = agrees("sheet.obj", {"cell": 3, "bones": bones},
                   [keys("a", 0, 60), keys("x", 0, 20)], {"a": "deg", "x": "mm"})
    inside = np.linalg.norm(baked.rig.rest - [62, 20, 0], axis=1) < 15 - 3
    assert inside.sum() >= 4 and baked.rig.weight[inside, 1].min() == 1


def regions_are_lists_of_vertices():
    """By their numbers in the file."""
    far = [5 * 11 - 1, 4 * 11 - 1, 3 * 11 - 1]
    agrees("sheet.obj", {"cell": 5, "bones": [
        point("p", [10, 20], turn("a")),
        {"name": "corner", "region": {"vertices": far}, "joints": [move("x", "y")]}]},
        [keys("x", 0, 25), keys("a", 0, 30)], {"x": "mm", "a": "deg"})
    tip = [i for i, p in enumerate(skin_meshes.box((10, 2, 2), (100, 20, 20))[0]) if p[0] > 95]
    agrees("bar.obj", {"cell": 9, "bones": [
        point("p", [10, 0, 0], turn("a")),
        {"name": "tip", "region": {"vertices": tip}, "joints": [move("x", "y")]}]},
        [keys("x", 0, 25), keys("a", 0, 30)], {"x": "mm", "a": "deg"})


# ---- meshes ----------------------------------------------------------------------------------------
def flat_shapes_have_holes_and_isles():
    """A part that no handle touches follows the nearest place that has weights."""
    bones = [on("left", [10, 20], [30, 20], turn("a")), point("right", [90, 20], move("x", "y"))]
    curves, units = [keys("a", 0, 60), keys("x", 0, 25)], {"a": "deg", "x": "mm"}
    agrees("isles.obj", {"cell": 5, "bones": bones}, curves, units)
    agrees("isles.obj", {"cell": 5, "bones": bones + [point("isle", [118, 20], turn("a"))]},
           curves, units)


def broken_surfaces_are_wrapped():
    """Holes are filled; what crosses itself gets a fine surface around it: thousands of vertices."""
    for name, wrapped, kind in (("torn.obj", False, "bounded"), ("crossing.obj", True, "harmonic")):
        baked = agrees(name, {"cell": 8, "bones": ARM, "weights": kind}, BEND, HINGES)
        assert baked.report["wrapped"] == wrapped


def meshes_are_turned_and_scaled_first():
    agrees({"file": "half.obj", "up": "z", "scale": 0.5}, {"cell": 9, "bones": ARM}, BEND, HINGES)


def bones_may_leave_the_shape():
    """What is outside holds nothing; the end is then what projects there."""
    bones = [on("in", [20, 20], [50, 20], {"twist": "v"}, turn("a")),
             dict(on("out", [50, 20], [125, 30], {"stretch": "s"}), parent="in"),
             on("edge", [0, -6], [0, 46], move("x"))]
    agrees("sheet.obj", {"cell": 4, "bones": bones},
           [keys("a", 0, 40), keys("s", 1, 1.3), keys("x", 0, -15), keys("v", 0, 70)],
           {"a": "deg", "s": "long", "x": "mm", "v": "deg"})


# ---- weights ---------------------------------------------------------------------------------------
def weights_come_in_four_kinds():
    points = [point("p", [12, 10], move("x", "y")), point("q", [45, 30], turn("a")),
              on("b", [70, 20], [90, 24], move("x"))]
    for kind in ("coupled", "biharmonic", "harmonic"):
        agrees("sheet.obj", {"cell": 5, "bones": points, "weights": kind},
               [keys("x", 0, 20), keys("a", 0, 50)], {"x": "mm", "a": "deg"})


def brushes_keep_shapes():
    """By the mesh's size, wherever it is."""
    for file, dx, dy in (("sheet.obj", 0, 0), ("away.obj", 300, -200)):
        points = [point("p", [12 + dx, 10 + dy], move("x", "y")),
                  point("q", [88 + dx, 30 + dy], turn("a"))]
        at = [50 + dx, 20 + dy]
        stiff = [{"region": {"ball": {"centre": at, "radius": 16}}, "stiffness": 300},
                 {"region": {"box": [[60 + dx, 10 + dy], [80 + dx, 30 + dy]]}, "stiffness": 900}]
        for brush in (stiff, [{"region": {"vertices": [14, 25, 26, 27]}, "stiffness": 2000}]):
            agrees(file, {"cell": 5, "bones": points, "brush": brush},
                   [keys("x", 0, 20), keys("a", 0, 50)], {"x": "mm", "a": "deg"})


def colours_keep_parts_apart():
    bones = [on("trunk", [0, -35], [0, 10], turn("b")), on("arm", [-24, 0], [-4, 0], turn("a")),
             point("head", [0, 30], move("x"))]
    agrees({"file": "puppet.png", "cell": 6}, {"cell": 4, "bones": bones, "lift": 0.6},
           [keys("a", 0, 60), keys("b", 0, 25), keys("x", 0, 20)],
           {"a": "deg", "b": "deg", "x": "mm"})


# ---- what else a rig does --------------------------------------------------------------------------
def limits_hold():
    """Those of stretches too: they go from nothing to nine times the length."""
    bones = [dict(ARM[0], joints=[turn("a", [0, 1, 3], limits=[-10, 12])]), ARM[1]]
    agrees("bar.obj", {"cell": 9, "bones": bones}, BEND, HINGES)
    bones = [on("b", [-30, 0, 0], [30, 0, 0], {"stretch": "s", "limits": [0.4, 1.8]})]
    agrees("cigar.obj", {"cell": 8, "bones": bones}, [keys("s", 1, 3, -1)], {"s": "long"})
    bones = [on("b", [-30, 0, 0], [30, 0, 0], {"stretch": "s"})]
    agrees("cigar.obj", {"cell": 8, "bones": bones}, [keys("s", 1, 10, -2, kind="linear")],
           {"s": "long"}, tolerance=3)


def children_go_with_places_of_stretched_twisted_parents():
    """Weightless ones, too; depth; quaternions."""
    bones = [on("a", [10, 0, 0], [60, 0, 0], turn("a", "y"), {"stretch": "s"}, {"twist": "v"},
                {"twist-start": "b"}),
             dict(bone("w", [35, 0, 0], [35, 30, 0], parent="a", weightless=True, depth=3),
                  joints=[turn("b")]),
             dict(point("p", [70, 0, 5], turn("b"), {"quaternion": "q"}), parent="w", depth=-2),
             dict(on("e", [60, 0, 0], [90, 0, 0], {"quaternion": "q"}), parent="a")]
    agrees("bar.obj", {"cell": 9, "bones": bones},
           [keys("a", 0, 20), keys("s", 1, 1.3), keys("v", 0, 80), keys("b", 0, -30),
            keys("q_w", 1, 0.9, kind="linear"), keys("q_y", 0, 0.3, kind="linear"),
            keys("q_z", 0, -0.2, kind="linear")],
           {"a": "deg", "s": "long", "v": "deg", "b": "deg", "q_w": "long", "q_x": "none",
            "q_y": "none", "q_z": "none"}, tolerance=0.7)


def shapes_blend_below_a_rig():
    mesh = {"file": "thin.obj", "shapes": [{"channel": "k", "file": "fat.obj"},
                                           {"channel": "l", "file": "bent.obj"}]}
    bones = [on("upper", [5, 0, 0], [40, 0, 0], turn("a"), {"stretch": "s"}),
             dict(on("lower", [40, 0, 0], [75, 0, 0], turn("b")), parent="upper")]
    agrees(mesh, {"cell": 9, "bones": bones},
           BEND + [keys("k", 0, 1, 0.3), keys("l", 0, 0.5, 1), keys("s", 1, 1.2, 0.8)],
           {"a": "deg", "b": "deg", "k": "none", "l": "none", "s": "long"}, most=2)


def fields_and_paints_mean_values():
    """A servo follows one."""
    points = [point("p", [12, 10], value="u"), point("q", [88, 30], turn("a"), value="v"),
              point("r", [50, 20], value="k")]
    fields = [{"channel": "f", "at": [40, 20]}, {"channel": "g", "at": [70, 25]}]
    servo = {"name": "s", "channel": "f", "protocol": "maestro", "id": 1, "per_unit": "400 us",
             "centre": "1200 us", "min": "1000 us", "max": "2000 us"}
    baked = agrees("sheet.obj", {"cell": 5, "bones": points, "fields": fields, "paint": True},
                   [keys("u", 0, 1), keys("v", 0.5, 0.2, 1), keys("a", 0, 80), keys("k", 0.3, 0.9)],
                   {"u": "glow", "v": "glow", "k": "glow", "a": "deg", "f": "glow", "g": "glow"},
                   servos=[servo])
    for t in baked.times():
        values, raw = skin_scene.values_at(baked.scene, 0, t), baked.raw(0, t)
        for f in fields:
            channel = baked.names[f["channel"]]
            got = raw[channel] / 2.0 ** baked.clip.channels[channel].frac
            want = baked.rig.field(f["at"], values)
            assert abs(got - want) <= UNITS["glow"]["tolerance"] * BETWEEN, (f, t, got, want)
            if f["channel"] == "f":
                at = baked.clip.servo_q8(0, raw[channel]) / 256 / 4
                assert abs(at - 1200 - 400 * got) <= 0.5, (at, got)
        # four levels by pruning, one by rounding down
        want = np.clip(256 * baked.rig.brightness(values)[baked.order], 0, 255)
        assert abs(np.array(baked.skins.brightness(0, raw)) - want).max() <= 5, t


# ---- several rigs, files, captures -----------------------------------------------------------------
def rigs_do_not_mix():
    """Bones, lists of follows, spans and fields are each rig's own."""
    points = [point("p", [0, 40], move("x"), {"follow": ["q"]}),
              point("q", [26, 8], move("y", "y")), point("r", [-26, 8], {"follow": ["p", "q"]})]
    scene = scene_of("bar.obj", {"cell": 9, "bones": ARM}, BEND + [keys("x", 0, 25), keys("y", 0, 20)],
                     dict(HINGES, x="mm", y="mm"))
    scene["meshes"].append({"name": "n", "file": "star.svg", "cell": 9, "tolerance": 0.5})
    scene["rigs"].append({"name": "second", "mesh": "n", "cell": 6, "bones": points})
    for index in (0, 1):
        agrees_as(scene, index)


def shortest_turn(a, b):
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    return Rotation.from_rotvec(np.cross(a, b) / np.linalg.norm(np.cross(a, b)) * np.arccos(a @ b))


def captures_turn_bones_that_point_elsewhere():
    """R = G B^-1 A, of each bone against its parent's; B is no turn in a BVH file."""
    bones = [dict(bone("upper", [10, 0, 0], [50, 0, 0]), node="Hips"),
             dict(bone("lower", [50, 0, 0], [90, 0, 0]), node="Arm", parent="upper",
                  joints=[{"twist": "v"}])]
    rate = 0.0333333333
    scene = scene_of("bar.obj", {"cell": 9, "bones": bones}, [keys("v", 0, 60)], {"v": "deg"},
                     sources=[{"name": "go", "file": "go.bvh"}])
    scene["clips"][0].update(duration=20 * rate, rigs=[
        {"rig": "r", "source": "go", "from": 5 * rate, "to": 25 * rate, "travel": True, "scale": 0.5}])
    place, turns, _ = rig_oracle.bvh_poses(cli.path("go.bvh"))
    node = [shortest_turn([1, 0, 0], way) for way in ([0, 30, 10], [20, 20, 0])]

    def captured(t):
        k = 5 + round(t / rate)
        R = [Rotation.from_matrix(turns[i][k]) * node[i] for i in (0, 1)]
        out = {}
        for name, q in (("upper", R[0]), ("lower", R[0].inv() * R[1])):
            out.update(zip(["r_%s_%s" % (name, c) for c in "xyzw"], q.as_quat()))
        way = 0.5 * (place[0][k] - place[0][5])
        out.update(zip(["r_upper_move_" + c for c in "xyz"], way))
        return out
    baked = Baked(scene)
    baked.captured = captured
    baked.weighs()
    baked.shows(times=[k * rate for k in range(0, 21, 2)])


def files_bring_bones_and_weights():
    """glTF poses them; fields take the weights of the nearest place."""
    rig_oracle.gltf_make(cli.path("m.gltf"), False, False)
    tolerance, times = 0.01, np.arange(0, 2.4, 0.3)
    scene = {"name": "t", "channels": [{"name": "u", "tolerance": 1e-4}, {"name": "f"}],
             "meshes": [{"name": "m", "file": "m.gltf", "tolerance": tolerance}],
             "sources": [{"name": "go", "file": "m.gltf"}],
             "rigs": [{"name": "r", "mesh": "m", "file": "m.gltf", "weights": "file",
                       "influences": 8, "bones": [{"name": "Spine", "value": "u"}]}],
             "clips": [{"name": "c", "curves": [keys("u", 0, 1, step=2.4)],
                        "rigs": [{"rig": "r", "source": "go", "travel": True}]}]}
    bake(scene)
    clip = wgl.Clip(cli.read("t.wgl"))
    skins = wgl_skin.Skins(wgl_shape.Shapes(clip))
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        rig_oracle.gltf_skin(cli.path("m.gltf"), times)
    lines = text.getvalue().splitlines()
    count, joints = map(int, lines[0].split())
    rest = np.array([l.split()[:3] for l in lines[1 + joints:1 + joints + count]], float)
    shape, order = clip.shapes[0], None
    for t, line in zip(times, lines[1 + joints + count:]):
        want = np.array(line.split(), float).reshape(-1, 3)
        got = np.array(skins.vertices(0, clip.sample(0, round(t * 1e6))[0]), float)
        got = got.reshape(-1, 3) / 2.0 ** (shape.frac + 8)
        if order is None:
            flat = np.array(skins.shapes.deformed(shape, []), float).reshape(-1, 3)
            flat = (flat + [shape.origin_x, shape.origin_y, shape.origin_z]) / 2.0 ** shape.frac
            order = np.linalg.norm(flat[:, None] - rest, axis=2).argmin(axis=1)
            assert len(set(order)) == len(order) == count
        far = np.linalg.norm(got - want[order], axis=1).max()
        assert far <= tolerance * 1.5, (t, far)
    # a vertex that hangs on the spine alone takes its value
    weights = np.array([l.split()[3:] for l in lines[1 + joints:1 + joints + count]], float)
    spine = lines[1:1 + joints].index("Spine")
    on_spine = rest[weights[:, spine].argmax()]
    assert weights[:, spine].max() > 0.5
    scene["rigs"][0]["fields"] = [{"channel": "f", "at": list(on_spine)}]
    bake(scene)
    clip = wgl.Clip(cli.read("t.wgl"))
    values = clip.sample(0, 2400000)[0]
    wgl_skin.Skins(wgl_shape.Shapes(clip)).set_fields(values)
    assert abs(values[1] / 2.0 ** clip.channels[1].frac - 1) < 0.01, values


TESTS = (two_bones_bend_a_bar, bones_stretch_and_twist,
         twists_without_endpoint_weights_move_children_alone, quaternions_of_any_length_turn_alike,
         a_bone_stretches_far, endpoint_weights_come_in_four_kinds, points_move_what_is_around_them,
         points_follow_each_other, bones_share_joints_and_hang_loose,
         cages_are_closed_open_or_partial, a_closed_cage_goes_around_a_solid, regions_move_as_one,
         regions_hold_all_of_a_flat_shape_inside, regions_are_lists_of_vertices,
         flat_shapes_have_holes_and_isles, broken_surfaces_are_wrapped,
         meshes_are_turned_and_scaled_first, bones_may_leave_the_shape, weights_come_in_four_kinds,
         brushes_keep_shapes, colours_keep_parts_apart, limits_hold,
         children_go_with_places_of_stretched_twisted_parents, shapes_blend_below_a_rig,
         fields_and_paints_mean_values, rigs_do_not_mix, captures_turn_bones_that_point_elsewhere,
         files_bring_bones_and_weights)

if __name__ == "__main__":
    write_files()
    skin_scene.build_export()
    sys.exit(cli.main(TESTS))
