#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Elastic bodies from scene to clip: what the reference decoder shows, at times of our own, against a
second implementation of the whole way (tests/reference/body_scene.py, body_oracle.py): energies, modes,
reduced spaces, motion. Shells and chains, whose meshes are the scene's own; meshes and poses are
written here."""
import json
import os
import sys

import numpy as np
import scipy.linalg

import test_bake_cli as cli
import body_scene  # test_bake_cli put it on the path
import pca_oracle

os.environ.update(XDG_CACHE_HOME=cli.path("cache"), OPENBLAS_NUM_THREADS="1")

# mm, of sheets of 120 x 80 that move by 10 to 100. With frames, the curve between two of them may take
# a twentieth more.
TOLERANCE, BETWEEN = 0.1, 1.05

# Thick and soft: what stretches is not a hundred times as stiff as what bends.
MATERIAL = {"young": "30 kPa", "poisson": 0.3, "density": 1000}


# ---- meshes ----------------------------------------------------------------------------------------
def sheet(n=6, m=4):
    """It waves a little, so that no two of its modes share a frequency."""
    u, v = np.meshgrid(np.linspace(0, 120, n), np.linspace(0, 80, m))
    at = np.stack([u, v, 1.5 * np.sin(u / 40 + v / 70)], axis=-1).reshape(-1, 3)
    i = (np.arange(n - 1) + n * np.arange(m - 1)[:, None]).ravel()
    return at, np.concatenate([np.stack([i, i + 1, i + n + 1], 1),
                               np.stack([i, i + n + 1, i + n], 1)])


def write_obj(name, at):
    cli.write(name, "".join("v %.17g %.17g %.17g\n" % tuple(p) for p in at) +
              "".join("f %d %d %d\n" % tuple(t + 1) for t in sheet()[1]))


def write_bent(name, bend):
    """bend: displacement [mm] of places in units of the sheet's sides."""
    at = sheet()[0]
    write_obj(name, at + np.stack(np.broadcast_arrays(*bend(at[:, 0] / 120, at[:, 1] / 80)), 1))


def write_meshes():
    write_bent("rest.obj", lambda x, y: (0 * x, 0, 0))
    write_bent("arch.obj", lambda x, y: (0, 0, 14 * np.sin(np.pi * x) - 3 * y))
    write_bent("twist.obj", lambda x, y: (0, 0, 24 * (x - 0.5) * (y - 0.5) + 4 * x * x))
    write_bent("slid.obj", lambda x, y: (6 * x * x, 0, 9 * x * x * (x < 0.9)))


# ---- scenes ----------------------------------------------------------------------------------------
def rag(**more):
    return dict({
        "name": "rag", "kind": "shell", "mesh": "rag", "unit": "1 mm", "thickness": "6 mm",
        "material": MATERIAL, "modes": 6, "damping": [0.3, 0.002],
        "regions": [{"name": "left", "below": {"x": 1}}, {"name": "right", "above": {"x": 99}},
                    {"name": "far", "above": {"x": 119}}, {"name": "half", "above": {"x": 47}},
                    {"name": "corner", "ball": {"centre": [120, 80, 0], "radius": 40}}],
        "poses": [{"name": "arch", "file": "arch.obj"}, {"name": "twist", "file": "twist.obj"},
                  {"name": "slid", "file": "slid.obj"},
                  {"name": "swung", "modes": [{"mode": 1, "by": 9}, {"mode": 2, "by": -5}]},
                  {"name": "away", "of": "arch", "move": [5, 30, 8],
                   "turn": {"axis": [1, 0, 3], "angle": 4}}]}, **more)


def rod(**more):
    links = [{"name": "a", "length": 50, "angle": -90, "mass": "10 g", "density": [0.1, 0.3]},
             {"name": "b", "parent": "a", "length": 40, "angle": -70, "mass": "10 g"},
             {"name": "w", "parent": "b", "length": 20, "angle": -10, "mass": 2, "stiff": True},
             {"name": "c", "parent": "b", "length": 30, "angle": -90, "mass": "8 g"},
             {"name": "d", "parent": "a", "length": 30, "angle": 200, "density": [0.2, 0]}]
    links = [l if l.get("stiff") else dict(l, spring=0.01) for l in links]
    return dict({
        "name": "rag", "kind": "chain", "mesh": "rag", "width": 6, "gravity": [0, -9.81, 0],
        "damping": [0.5, 0.002], "links": links,
        "poses": [{"name": "up", "joints": [{"link": "a", "angle": -60},
                                            {"link": "b", "angle": "-30 deg"},
                                            {"link": "c", "angle": -20}]},
                  {"name": "sway", "modes": [{"mode": 1, "by": 8}, {"mode": 2, "by": -6}]}],
        "outputs": [{"channel": "j" + l, "joint": l} for l in "abcd"]}, **more)


JOINTS = [{"name": "j" + l, "unit": "deg", "tolerance": 0.02} for l in "abcd"]
OUTPUTS = [{"channel": "lift", "region": "right", "direction": [1, 0, 2]},
           {"channel": "tilt", "region": "corner", "turn": "y"}]
LIFTS = [{"name": "lift", "unit": "mm", "tolerance": 0.02},
         {"name": "tilt", "unit": "deg", "tolerance": 0.05}]


def key(time, pose, **more):
    return dict({"time": time, "pose": pose}, **more)


def act(*keys, **more):
    return dict({"body": "rag", "keys": list(keys)}, **more)


def clip(*actions, **more):
    return dict({"name": "c", "bodies": list(actions)}, **more)


def scene_of(body, clips, tolerance=TOLERANCE, **more):
    mesh = {"name": "rag", "tolerance": tolerance}
    if body["kind"] == "shell":
        mesh["file"] = "rest.obj"
    return dict({"name": "t", "meshes": [mesh], "bodies": [body], "clips": clips}, **more)


class Baked:
    """A scene as a clip, and as the oracle has it."""

    def __init__(self, body, clips, **more):
        scene = scene_of(body, clips, **more)
        cli.write("t.yaml", json.dumps(scene))
        cli.expect(cli.DONE, cli.bake("t", "--quiet", "--json=" + cli.path("t.json")))
        self.report = json.loads(cli.read("t.json"))["bodies"][0]
        self.shown = pca_oracle.Shown(cli.path("t.wgl"))
        self.tolerance = scene["meshes"][0]["tolerance"]
        self.scene, self.oracle = scene, body_scene.Body(scene, folder=cli.folder)

    def values(self, c, t, over=None):
        """All channels at t; `over`: an additive clip that plays with it."""
        file, us = self.shown.clip, round(t * 1e6)
        out = file.sample(c, us)[0]
        for k in file.clips[over].tracks if over is not None else ():
            out[file.tracks[k].channel] += file.track_value(k, file.position(over, us))
        return out

    def places(self, c, times, fine, over=None):
        x = self.oracle.x(c, times, fine)
        if over is not None:
            x = x + self.oracle.x(over, times, fine) - self.oracle.rest
        return np.stack([self.oracle.surface(v) for v in x])

    def times(self, c, count=31):
        clip_ = self.scene["clips"][c]
        end = clip_.get("duration", max(k["time"] for a in clip_["bodies"] for k in a["keys"]))
        # whole microseconds; the last tick of a loop that does not close is on its way back
        return np.round(np.linspace(0, end - (0.002 if clip_.get("end") == "loop" else 0), count), 6)

    def shows(self, c=0, over=None, times=None):
        """Every vertex where the oracle has it. The oracle's steps are halved once: its error falls by 2^4
        and more, so that what this changes is more than what is left."""
        times = self.times(c) if times is None else times
        rough, want = (self.places(c, times, fine, over) for fine in (2.5, 5))
        doubt = np.linalg.norm(rough - want, axis=2).max()
        got = np.stack([self.shown.at(self.values(c, t, over)) for t in times])
        far, one, _ = pca_oracle.matched(got, want)
        assert doubt <= self.tolerance / 20, doubt
        limit = self.tolerance * (BETWEEN if over is None else 2 * BETWEEN)  # each clip has its own
        assert far.max() <= limit + doubt, (c, far.max())
        assert one or self.oracle.chain  # bars of a chain share corners
        moved = np.linalg.norm(want - self.oracle.surface(self.oracle.rest), axis=2).max()
        assert moved >= 40 * self.tolerance, moved
        return want

    def says(self, c=0):
        """The certificate's row of each motion: dimension and energy. The oracle's energies differ by 2^-8
        and less of it when its steps are halved."""
        rows = [m for m in self.report["motions"] if m["clip"] == self.scene["clips"][c]["name"]]
        rough, runs = (self.oracle.clip_runs(c, fine) for fine in (2.5, 5))
        assert len(rows) == len(runs)
        for row, (_, m, space), (_, n, _) in zip(rows, runs, rough):
            assert row["coordinates"] == space.d, (row, space.d)
            slack = 1e-6 * m.energy + abs(m.energy - n.energy)
            assert abs(m.energy - n.energy) <= 1e-3 * m.energy, (m.energy, n.energy)
            assert abs(row["energy"] - m.energy) <= slack, (row, m.energy, slack)
            assert row["cubic_energy"] == -1 or row["cubic_energy"] >= row["energy"] * (1 - 1e-9), row

    def follows(self, c=0):
        """Outputs are within their channels' tolerances, at places of the same times."""
        times = self.times(c)
        x = self.oracle.x(c, times, 5)
        values = np.array([self.values(c, t) for t in times])
        for i, o in enumerate(self.scene["bodies"][0]["outputs"]):
            got = values[:, i] / 2.0 ** self.shown.clip.channels[i].frac
            want = np.array([self.oracle.output(o, y) for y in x])
            off = abs(got - want).max()
            assert off <= self.scene["channels"][i]["tolerance"] * BETWEEN, (o, off)
            assert np.ptp(want) > 0.2, o


def agrees(body, *clips, **more):
    clips = [dict(k, name="c%d" % i) for i, k in enumerate(clips)]
    baked = Baked(body, clips, **more)
    for c in range(len(clips)):
        baked.shows(c)
        baked.says(c)
        if "outputs" in body:
            baked.follows(c)
    return baked


THREE = (key(0, "rest"), key(0.3, "arch"), key(0.7, "twist"), key(1.0, "rest"))
PUSH = [{"region": "right", "by": [0, 0, 150]},
        {"region": "corner", "turn": {"axis": "x", "angle": 200}}]


# ---- one point -------------------------------------------------------------------------------------
def a_free_sheet_swings_as_the_oracle_has_it():
    """Its six rigid modes and its frequencies, too. Both solvers are backward stable: an eigenvalue is off
    by some eps times the largest one, 1e6 of the lowest here; frequencies print with 9 digits. Where a
    vertex is read as the neighbour of the nearest float, by 1e-7 of it."""
    baked = agrees(rag(outputs=OUTPUTS), clip(act(*THREE)), channels=LIFTS)
    report, own = baked.report, baked.oracle.own_modes()
    assert report["rigid"] == own.rigid == 6 and report["residual"] <= 1e-8
    np.testing.assert_allclose(report["hertz"], own.hertz(), rtol=1e-7)
    assert abs(report["mass_kg"] - baked.oracle.thing.mass.sum()) < 1e-8 and report["waves"]


def velocities_throw_regions():
    agrees(rag(), clip(act(key(0, "rest", velocity=PUSH), key(0.4, "arch"),
                           key(0.9, "twist", velocity=[9, 20, 90]))))


def a_velocity_between_the_ends_parts_a_motion():
    """C1 there: each side is what it would be alone."""
    agrees(rag(), clip(act(key(0, "rest"), key(0.4, "arch", velocity=PUSH), key(0.9, "twist"))))


def soft_keys_pull_by_their_weights():
    agrees(rag(), clip(act(key(0, "rest"), key(0.4, "arch", weight=2000),
                           key(0.9, "twist", weight=1000, velocity=[0, 0, 100], velocity_weight=5),
                           key(1.2, "rest"))))


def parts_of_poses_leave_the_rest_to_least_force():
    """As near as the space allows where hard; `missed` is the root mean square over them."""
    agrees(rag(), clip(act(key(0, "rest"), key(0.5, "twist", region="corner", weight=3000),
                           key(1, "rest"))))
    baked = agrees(rag(), clip(act(key(0, "rest"), key(0.4, "arch", region="half"), key(0.8, "twist"),
                                   key(1.2, "rest"), end="free")))
    x = baked.oracle.x(0, [0.4], 5)[0] - baked.oracle.pose("arch")
    off = x.reshape(-1, 3)[baked.oracle.region("half")] * 1e3
    missed = baked.report["motions"][0]["missed"]
    assert missed > 0.01 and abs(missed - np.sqrt((off ** 2).sum(axis=1).mean())) < 1e-3 * missed


def free_ends_take_the_least_of_all():
    """Hardly damped: a free end of what is damped much is not determined by keys."""
    agrees(rag(damping=[0.3, 0]), clip(act(key(0, "arch"), key(0.5, "twist"), key(1.1, "rest"),
                                           start="free", end="free")))


def loops_close():
    agrees(rag(outputs=OUTPUTS), clip(act(*THREE, periodic=True), end="loop"), channels=LIFTS)


def damping_and_stiffness_belong_to_the_motion():
    agrees(rag(), clip(act(*THREE, damping=[0, 0])), clip(act(*THREE, stiffness=3, damping=[1, 0.01])),
           clip(act(*THREE, stiffness=0.3)))


def gravity_pulls_what_is_held():
    """The pose at rest is not in equilibrium; weights do not get stiffer with the springs."""
    body = rag(gravity=[0, -2, -4], fixed=["left"], material=dict(MATERIAL, young="200 kPa"))
    keys = key(0, "rest"), key(0.2, "swung"), key(0.5, "rest")
    baked = agrees(body, clip(act(*keys, end="free")), clip(act(*keys, stiffness=2)))
    report, own, thing = baked.report, baked.oracle.own_modes(), baked.oracle.thing
    # relative to the lowest eigenvalue, 64 roundings of a bound of the largest are allowed as well
    S = thing.potential(thing.rest)[2] / np.sqrt(np.outer(*2 * [np.diag(thing.M)]))
    limit = max(1e-8, 64 * 2.0 ** -52 * abs(S).sum(axis=0).max() / own.lam[0])
    assert report["rigid"] == 0 and report["residual"] <= limit, (report, limit)
    np.testing.assert_allclose(report["hertz"], own.hertz(), rtol=1e-7)


def regions_are_fixed_and_slide():
    slides = [{"region": "far", "normal": "z"}, {"region": "right", "normal": [0, 1, 0]}]
    agrees(rag(fixed=["left"], sliding=slides),
           clip(act(key(0, "rest", velocity=[50, 60, 70]), key(0.5, "slid"), key(1, "rest"))),
           clip(act(key(0, "rest", velocity=[50, 60, 70]), key(0.5, "slid"), key(1, "rest"),
                    sliding=slides[:1])))


def regularisers_tame():
    keys = THREE[:1] + (key(0.3, "arch", weight=1000),) + THREE[2:]
    agrees(rag(), clip(act(*THREE, regularise=[300, 20, 0.5])),
           clip(act(*keys, regularise=[30, 2, 0.05], end="free")))


def a_model_may_be_about_another_pose():
    agrees(rag(gravity=[0, -3, -6], modes=3), clip(act(*THREE[:3], about="arch", stiffness=2)))


def free_vibration_costs_nothing():
    """Two poses that a vibration passes, ends free: the motion is that vibration."""
    body, seconds = rag(fixed=["left"], damping=[0.5, 0]), 0.31
    start = body_scene.Body(scene_of(body, []), folder=cli.folder)
    own, u = start.own_modes(), start.pose("swung") - start.rest
    c = own.phi.T @ start.M @ u

    def vibration(t):
        turn = [scipy.linalg.expm(t * np.array([[0, 1], [-l, -0.5]]))[0] @ [1, 0.7]
                for l in own.lam]
        return own.phi @ (c * turn) / start.unit
    at = sheet()[0]
    write_obj("first.obj", at + vibration(0).reshape(-1, 3))
    write_obj("last.obj", at + vibration(seconds).reshape(-1, 3))
    body["poses"] = [{"name": n, "file": n + ".obj"} for n in ("first", "last")]
    baked = Baked(body, [clip(act(key(0, "first"), key(seconds, "last"), start="free", end="free"))])
    times = baked.times(0)
    got = np.stack([baked.shown.at(baked.values(0, t)) for t in times])
    want = np.stack([at + vibration(t).reshape(-1, 3) for t in times])
    assert pca_oracle.matched(got, want)[0].max() <= TOLERANCE
    row = baked.report["motions"][0]
    # rounding: 1e-16 of the largest lambda over the lowest, squared
    assert 0 <= row["energy"] <= 1e-9 * row["cubic_energy"], row


# ---- without physics, on top of each other, in a row -----------------------------------------------
def splines_know_no_physics():
    """The body's damping and gravity do not matter, and regions that are held move."""
    agrees(rag(gravity=[0, 0, -5], fixed=["left"]),
           clip(act(key(0, "rest"), key(0.4, "away"), key(1, "twist"), dynamics="spline")),
           clip(act(key(0, "rest"), key(0.4, "away", velocity=PUSH), key(1, "twist"),
                    dynamics="spline")))


def what_adds_is_a_difference_from_rest():
    main = act(key(0, "arch"), key(0.5, "away"), key(1, "twist"), dynamics="spline")
    more = key(0.1, "rest", velocity=PUSH), key(0.4, "arch"), key(0.7, "rest")
    baked = agrees(rag(), clip(main, act(*more, add=True)))
    assert baked.report["waves"]
    baked = agrees(rag(modes=3), clip(main, act(*more, add=True, about="arch")))
    assert not baked.report["waves"]


def an_additive_clip_plays_over_another():
    main = act(key(0, "rest"), key(0.5, "away"), key(1, "twist"), dynamics="spline")
    over = act(key(0, "rest", velocity=PUSH), key(0.4, "arch"), key(0.9, "rest"))
    baked = Baked(rag(), [clip(main), clip(over, name="over", additive=True)],
                  layers=[{"name": "a", "clip": "c"}, {"name": "b", "clip": "over", "mode": "add"}])
    baked.shows(0)
    baked.shows(0, over=1)
    baked.says(0)
    baked.says(1)


def motions_follow_each_other():
    """As in examples/block: held, free, held again; the landing is a kink."""
    up, down = [{"by": [0, 90, 0]}], [{"by": [0, -90, 0]}]
    agrees(rag(modes=4),
           clip(act(key(0, "rest"), key(0.3, "rest", velocity=up), fixed=["left"]),
                act(key(0.3, "rest", velocity=up), key(0.6, "rest", velocity=down)),
                act(key(0.6, "rest", velocity=down), key(1.1, "rest"), fixed=["left"])))


# ---- several points --------------------------------------------------------------------------------
def blended_models_fade():
    agrees(rag(modes=2), clip(act(*THREE[:3], dynamics="blend")),
           clip(act(*THREE, dynamics="blend", periodic=True), end="loop"), tolerance=0.25)


def coupled_models_meet_c2():
    agrees(rag(modes=2), clip(act(*THREE[:3], dynamics="couple", end="free")),
           clip(act(*THREE, dynamics="couple", periodic=True), end="loop"), tolerance=0.25)


def coupled_models_take_velocities_at_keys():
    agrees(rag(modes=2, damping=[0, 0]),
           clip(act(key(0, "rest"), key(0.4, "arch", velocity=[0, 0, 40]), key(0.9, "twist"),
                    dynamics="couple")), tolerance=0.25)


def several_models_feel_gravity():
    body = rag(modes=2, gravity=[0, 0, -2], fixed=["left"], material=dict(MATERIAL, young="200 kPa"))
    keys = key(0, "rest"), key(0.2, "swung"), key(0.4, "rest", velocity=[0, 0, 30])
    agrees(body, clip(act(*keys, dynamics="blend", stiffness=2)),
           clip(act(*keys, dynamics="couple", stiffness=2)))


def ends_of_stiff_motions_are_shown():
    """What is damped most decays within some ms of an end: frames must be near each other there, and
    what follows an end holds still."""
    baked = Baked(rag(modes=3, damping=[0.3, 0.004]),
                  [clip(act(key(0, "rest"), key(0.4, "arch"), dynamics="blend"), duration=0.6, **end)
                   for end in ({}, {"name": "d", "end": "loop"})])
    for c in (0, 1):
        baked.shows(c, times=np.round(np.arange(0.3, 0.597, 0.003), 6))
        baked.shows(c)


def loops_that_do_not_close_jump_in_their_last_tick():
    """Outputs as well as meshes."""
    agrees(rag(outputs=OUTPUTS), clip(act(*THREE[:3]), end="loop"), channels=LIFTS)


# ---- chains ----------------------------------------------------------------------------------------
def chains_swing_as_the_oracle_has_it():
    keys = key(0, "rest"), key(0.6, "up"), key(1.1, "sway")
    baked = agrees(rod(), clip(act(*keys)), clip(act(*keys[:2], about="up", stiffness=2)),
                   clip(act(*keys, dynamics="blend")), clip(act(*keys, dynamics="couple")),
                   channels=JOINTS)
    np.testing.assert_allclose(baked.report["hertz"], baked.oracle.own_modes().hertz(), rtol=1e-7)


def thrown_chains_fly():
    throw = [{"by": [50, 300, 0]}, {"link": "b", "rate": -300}]
    body = rod(free_root=True, root_mass=5)
    body["poses"].append({"name": "hop", "of": "up", "move": [20, 60, 0]})
    agrees(body, clip(act(key(0, "rest", velocity=throw), key(0.3, "hop", weight=3000),
                          key(0.6, "rest"))),
           clip(act(key(0, "rest", velocity=throw), key(0.3, "hop"), key(0.6, "rest"))),
           channels=JOINTS)


TESTS = (a_free_sheet_swings_as_the_oracle_has_it, velocities_throw_regions,
         a_velocity_between_the_ends_parts_a_motion, soft_keys_pull_by_their_weights,
         parts_of_poses_leave_the_rest_to_least_force, free_ends_take_the_least_of_all, loops_close,
         damping_and_stiffness_belong_to_the_motion, gravity_pulls_what_is_held,
         regions_are_fixed_and_slide, regularisers_tame, a_model_may_be_about_another_pose,
         free_vibration_costs_nothing, splines_know_no_physics, what_adds_is_a_difference_from_rest,
         an_additive_clip_plays_over_another, motions_follow_each_other, blended_models_fade,
         coupled_models_meet_c2, coupled_models_take_velocities_at_keys, several_models_feel_gravity,
         ends_of_stiff_motions_are_shown, loops_that_do_not_close_jump_in_their_last_tick,
         chains_swing_as_the_oracle_has_it, thrown_chains_fly)

if __name__ == "__main__":
    write_meshes()
    sys.exit(cli.main(TESTS))
