#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Animated meshes from file to clip: what the reference decoder poses, against the frames, with
numpy. Meshes are written here as OBJ files, or are the MD2 model of examples/faerie."""
import json
import sys

import numpy as np

import test_bake_cli as cli
import pca_oracle  # test_bake_cli put it on the path

FAERIE = "/usr/share/assimp/models/MD2/faerie.md2"


def certificate(name, *options):
    code = cli.bake(name, "--quiet", "--json=" + cli.path(name + ".json"), *options)
    return code, json.loads(cli.read(name + ".json"))


def bake_mesh(name, mesh, clips, extra=""):
    """A scene of one mesh; its shown frames and the certificate's row."""
    cli.write(name + ".yaml", "name: t\nmeshes:\n  - {name: thing, %s}\nclips:\n%s%s" % (
        mesh, "".join("  - {%s}\n" % c for c in clips), extra))
    done, c = certificate(name)
    cli.expect(cli.DONE, done)
    return pca_oracle.Shown(cli.path(name + ".wgl")), c["meshes"][0]


def both_ways(shown, frames, tolerance):
    """Each vertex of the clip is one of the frames', and each of theirs is shown."""
    far = pca_oracle.matched(shown, frames)[0].max()
    assert max(far, pca_oracle.matched(frames, shown)[0].max()) <= tolerance, (far, tolerance)
    return far


# ---- frames of our own ---------------------------------------------------------------------------
def grid(n=12):
    u, v = np.meshgrid(np.linspace(0, 30, n), np.linspace(0, 20, n))
    return np.stack([u.ravel(), v.ravel(), 0 * u.ravel()], axis=1)


def cloth(count, n=12):
    """A cloth with waves of changing length, which also turns about y and moves away."""
    out = []
    for f in range(count):
        p, t = grid(n), 0.13 * f
        p[:, 2] = 2 * np.sin(0.3 * p[:, 0] + t) + 0.7 * np.cos((0.5 + 0.02 * t) * p[:, 1] - 2 * t)
        c, s = np.cos(0.2 * t), np.sin(0.2 * t)
        x, z = p[:, 0] * c + p[:, 2] * s + t, p[:, 2] * c - p[:, 0] * s
        out.append(np.stack([x, p[:, 1], z], axis=1))
    return np.array(out)


def write_series(stem, frames, n=12):
    faces = "".join("f %d %d %d\nf %d %d %d\n" % (i, i + 1, i + n + 1, i, i + n + 1, i + n)
                    for r in range(n - 1) for i in range(r * n + 1, r * n + n))
    for f, frame in enumerate(frames):
        cli.write("%s_%03d.obj" % (stem, f),
                  "".join("v %.9g %.9g %.9g\n" % tuple(p) for p in frame) + faces)
    return cli.path(stem + "_###.obj")


# ---- the model -----------------------------------------------------------------------------------
def faerie_meets_two_tolerances_as_numpy_sees_it():
    """At its frames' times, through the reference decoder, from the MD2 file read by our own reader.
    The certificate's figure is the same one: what it measured, to the digits that it prints."""
    frames, sizes = pca_oracle.md2_frames(FAERIE), []
    for tolerance in (1.5, 0.4):
        shown, row = bake_mesh("faerie%g" % tolerance, "file: %s, tolerance: %g" % (
            FAERIE, tolerance), ("name: run, end: loop, meshes: [{mesh: thing, frames: [40, 45], "
                                 "rate: 9 Hz}]", "name: hit, meshes: [{mesh: thing, frames: "
                                 "[46, 65], rate: 10 Hz}]"))
        far = max(both_ways(shown.frames(0, 9, 6), frames[40:46], tolerance),
                  both_ways(shown.frames(1, 10, 20), frames[46:66], tolerance))
        # the baker has the file's coordinates as floats: sqrt 3 times half of 2^-18 below 64
        assert far <= row["error_max"] + 4e-6 and row["error_max"] <= tolerance, (far, row)
        sizes.append(row["bytes"]["bases"])
    assert sizes[0] < sizes[1], sizes


def levels_leave_what_eckart_and_young_say():
    """With k bases of 16 bits no clip can be better than the best k dimensions of all frames, and
    this one is hardly worse: rounding adds 2^-16 of the model's size, 50, here and there, and
    curves at most their share of the tolerance, 0.3 of 0.3. Both are below 0.1 in the mean."""
    frames = pca_oracle.md2_frames(FAERIE)[40:66]
    best = pca_oracle.left_by_bases(frames)
    _, row = bake_mesh("levels", "file: %s, tolerance: 0.3, affine: false, bits: 16" % FAERIE,
                       ("name: hit, meshes: [{mesh: thing, frames: [40, 65], rate: 10 Hz}]",))
    for level in row["levels"]:
        k, rms = level["bases"], level["error_rms"]
        assert rms >= best[k] - 0.002, (k, rms, best[k])
        assert rms ** 2 <= (1.01 * best[k]) ** 2 + 0.1 ** 2, (k, rms, best[k])
    sizes = [level["bytes"] for level in row["levels"]]
    assert len(sizes) == row["bases"] + 1 and sizes == sorted(sizes)


# ---- the whole's motion, pieces, loops -----------------------------------------------------------
def turning_cloth_is_shown_with_and_without_its_turns():
    frames, rows = cloth(40), []
    series = write_series("cloth", frames)
    for affine in ("true", "false"):
        shown, row = bake_mesh("cloth", "file: %s, tolerance: 0.05, affine: %s" % (series, affine),
                               ("name: c, meshes: [{mesh: thing, rate: 20 Hz}]",))
        both_ways(shown.frames(0, 20, 40), frames, 0.05)
        rows.append(row)
    # the cloth is nearly flat at times, so that no affine map is well conditioned
    assert rows[0]["whole"] == "rotation" and rows[1]["whole"] == "none"
    assert rows[0]["bytes"]["whole"] > 0 == rows[1]["bytes"]["whole"]
    # turned and moved, the rest shape alone is off by the waves only
    still = [row["levels"][0]["error_rms"] for row in rows]
    assert still[0] < still[1] / 2, still


def pieces_are_in_use_one_at_a_time():
    """Three motions in a row that have nothing in common: the bases of one weigh exactly 0 in the
    others, and every frame on both sides of a seam is within the tolerance."""
    n, count = 12, 60
    rest, frames = grid(n), []
    for f in range(count):
        p, third, t = grid(n), f * 3 // count, 0.31 * f
        part = rest[:, 0] // 11 == third
        p[:, 2] = part * sum(np.sin((0.2 + 0.1 * k) * (k + 1) * rest[:, 1] + (1 + 0.3 * k) * t +
                                    0.4 * rest[:, 0]) for k in range(4))
        frames.append(p)
    frames = np.array(frames)
    series = write_series("pieces", frames)
    for clip in ("name: c, meshes: [{mesh: thing, rate: 20 Hz}]",
                 "name: c, end: loop, meshes: [{mesh: thing, rate: 20 Hz}]"):
        shown, row = bake_mesh("pieces", "file: %s, tolerance: 0.05, affine: false, pieces: 3, "
                               "bits: 8" % series, (clip,))
        both_ways(shown.frames(0, 20, count), frames, 0.05)
        weights = shown.weights(0, 20, count) != 0
        assert row["bases_at_work"] < row["bases"], row
        assert weights.sum(axis=1).max() == row["bases_at_work"]
        # between frames too, well inside the pieces
        inside = np.array([shown.shapes.weights(shown.clip.shapes[0], shown.clip.sample(
            0, us)[0], 64) for us in range(1100000, 1900000, 37000)]) != 0
        assert inside.any(axis=0).sum() < row["bases"]


def a_loop_joins_its_end_to_its_first_frame():
    """A frame behind the last one the clip shows the first again, and gets there smoothly: the step
    over the seam is like those beside it."""
    count = 24
    frames = []
    for f in range(count):
        p, t = grid(), 2 * np.pi * f / count
        p[:, 2] = 3 * np.sin(0.3 * p[:, 0] + t)
        frames.append(p)
    series = write_series("loop", frames)
    shown, _ = bake_mesh("loop", "file: %s, tolerance: 0.02" % series,
                         ("name: c, end: loop, meshes: [{mesh: thing, rate: 24 Hz}]",))
    assert shown.clip.clips[0].ticks == shown.clip.clips[0].tick_rate
    end = shown.at(shown.clip.sample(0, 1000000)[0])
    assert abs(end - shown.at(shown.clip.sample(0, 0)[0])).max() <= 0.002
    steps = [shown.at(shown.clip.sample(0, us)[0]) for us in range(980000, 1000001, 5000)] + \
            [shown.at(shown.clip.sample(0, us)[0]) for us in range(5000, 20001, 5000)]
    speed = [abs(b - a).max() for a, b in zip(steps, steps[1:])]
    # 3 sin at 2 pi a second moves by at most 0.094 in 5 ms; curves may add 0.02 to either end
    assert max(speed) <= 0.094 + 0.04 and min(speed) >= 0.094 / 2 - 0.04, speed


# ---- normals -------------------------------------------------------------------------------------
def unit(n):
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def vertex_normals(at, corners):
    """Each triangle counts by its area."""
    a, b, c = (at[corners[:, k]] for k in range(3))
    out = np.zeros_like(at)
    for k in range(3):
        np.add.at(out, corners[:, k], np.cross(b - a, c - a))
    return unit(out)


def normal_error(shown, us):
    """rms angle in degrees between the normals shown and those of the surface shown."""
    values = shown.clip.sample(0, us)[0]
    pose = shown.shapes.pose(0, values)
    got = np.array(shown.shapes.vertices(1, shown.shapes.pose_normals(1, values, pose)), float)
    corners = np.array(shown.clip.parts[0].corners).reshape(-1, 3)
    cosine = (unit(got.reshape(-1, 3)) * vertex_normals(shown.at(values), corners)).sum(axis=1)
    return np.degrees(np.sqrt((np.arccos(np.minimum(cosine, 1)) ** 2).mean()))


def normals_follow_the_surface():
    """Interpolated normals do [Alexa 7.3.3]; fixed ones turn with the whole and no more. 8 bits of
    a basis are about half a degree; the rest is what is not linear."""
    series, errors = write_series("normals", cloth(40)), {}
    for kind in ("fixed", "interpolated"):
        shown, _ = bake_mesh("normals", "file: %s, tolerance: 0.05, affine: true, normals: %s" %
                             (series, kind), ("name: c, meshes: [{mesh: thing, rate: 20 Hz}]",))
        errors[kind] = [normal_error(shown, us) for us in range(0, 1950001, 150000)]
    assert max(errors["interpolated"]) < 5 and max(errors["fixed"]) > 20, errors
    assert np.mean(errors["interpolated"]) < np.mean(errors["fixed"]) / 5, errors


# ---- additive shapes -----------------------------------------------------------------------------
def additive_shapes_add_up():
    """V(r + s) - V_0 = (V(r) - V_0) + (V(s) - V_0) [Alexa 7.1.1], at any values. Each V is rounded
    to a step of the coordinates, the weights too: 4 roundings of at most two half steps."""
    base = grid()
    a, b = base.copy(), base.copy()
    a[base[:, 0] < 14, 2] += 3
    b[base[:, 0] > 10, 1] -= 2
    for name, p in (("rest", base), ("a", a), ("b", b)):
        write_series("add_" + name, [p])
    text = ("name: t\nchannels: [{name: a}, {name: b}]\nmeshes:\n  - {name: thing, file: "
            "add_rest_000.obj, tolerance: 0.01, shapes: [{channel: a, file: add_a_000.obj}, "
            "{channel: b, file: add_b_000.obj}]}\nclips:\n  - {name: c, curves: [{channel: a, "
            "kind: linear, keys: [{time: 0, value: 0}, {time: 1, value: 1}]}]}\n")
    cli.write("add.yaml", text)
    done, c = certificate("add")
    cli.expect(cli.DONE, done)
    shown = pca_oracle.Shown(cli.path("add.wgl"))
    fracs = [ch.frac for ch in shown.clip.channels]
    shape = shown.clip.shapes[0]

    def posed(r, s):
        values = [ch.rest for ch in shown.clip.channels]
        values[0], values[1] = round(r * 2 ** fracs[0]), round(s * 2 ** fracs[1])
        return shown.at(values)
    zero = posed(0, 0)
    for r, s in ((1, 1), (0.3, 0.7), (0.5, 0.01), (1, 0.25)):
        error = (posed(r, s) - zero) - ((posed(r, 0) - zero) + (posed(0, s) - zero))
        assert abs(error).max() <= 4 * 2.0 ** -shape.frac
    both = posed(1, 1)
    both_ways(both[None], (a + b - base)[None], 0.01)
    blocks = shown.clip.blocks
    assert sum(3 * k.count for k in blocks) < 2 * 3 * len(base)  # each shape moves a part only
    assert c["meshes"][0]["error_max"] <= 0.01


# ---- views ---------------------------------------------------------------------------------------
def highest(frames, yaw, pitch, rest):
    """How far from the picture's middle a vertex gets, in halves of its height (SPEC 4.17)."""
    (cy, sy), (cx, sx) = ((np.cos(np.radians(a)), np.sin(np.radians(a))) for a in (yaw, pitch))
    turn = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]]) @ \
        np.array([[cy, 0, -sy], [0, 1, 0], [sy, 0, cy]])
    q = (frames - np.array(rest[:3])) @ turn.T
    return (abs(q[..., 1]) * rest[3] / (rest[3] - q[..., 2])).max() / (rest[4] / 2)


def views_show_all_of_it():
    """A view that says nothing of where it looks fills the picture's height but for a border of 6 %;
    one that goes round shows all from every side."""
    frames = cloth(40)
    series = write_series("view", frames)
    for yaw in (0, 50):
        shown, _ = bake_mesh("view", "file: %s, tolerance: 0.05" % series,
                             ("name: c, meshes: [{mesh: thing, rate: 20 Hz}]",),
                             "views: [{name: v, yaw: %d, pitch: 20}]\n" % yaw)
        view, channels = shown.clip.views[0], shown.clip.channels
        rest = [channels[c].rest / 2.0 ** channels[c].frac for c in
                (view.x, view.y, view.z, view.distance, view.size)]
        # with z of the highest vertex in sizes: (2.5 - z) / (2.65 - z), for |z| below 3/4
        assert 0.92 <= highest(frames, yaw, 20, rest) <= 0.957
    text = cli.read("view.yaml").decode().replace("yaw: 50", "yaw: turn").replace("name: t\n", (
        "name: t\nchannels: [{name: turn, unit: deg}]\n")).replace("rate: 20 Hz}]", (
            "rate: 20 Hz}], curves: [{channel: turn, kind: linear, keys: [{time: 0, value: 0}, "
            "{time: 1, value: 360}]}]"))
    cli.write("round.yaml", text)
    cli.expect(cli.DONE, cli.bake("round", "--quiet"))
    shown = pca_oracle.Shown(cli.path("round.wgl"))
    view, channels = shown.clip.views[0], shown.clip.channels
    rest = [channels[c].rest / 2.0 ** channels[c].frac for c in
            (view.x, view.y, view.z, view.distance, view.size)]
    assert max(highest(frames, yaw, 20, rest) for yaw in range(0, 360, 10)) <= 1


# ---- what does not fit ---------------------------------------------------------------------------
def a_mesh_over_its_tolerance_fails_and_says_what_was_reached():
    series = write_series("few", cloth(40))
    cli.write("few.yaml", "name: t\nmeshes: [{name: rag, file: %s, tolerance: 0.02, bases: 2, "
              "affine: false}]\nclips: [{name: c, meshes: [{mesh: rag, rate: 20 Hz}]}]\n" % series)
    done = cli.expect(cli.OVER, cli.bake("few"), "misses its tolerance")
    line = [x for x in done.stdout.splitlines() if x.startswith("FAILED: mesh rag is off by")]
    assert len(line) == 1 and "with 2 bases" in line[0] and "`bases`" in line[0], done.stdout
    assert "few.wgl" not in cli.os.listdir(cli.folder)


def a_target_that_is_too_small_says_what_would_fit():
    """Flash: the advice holds when it is taken. RAM: 6 bytes a vertex and more."""
    series = write_series("target", cloth(40))
    text = ("name: t\nmeshes: [{name: rag, file: %s, tolerance: %%g, affine: false, bits: 8}]\n"
            "clips: [{name: c, meshes: [{mesh: rag, rate: 20 Hz}]}]\ntarget: {%%s}\n" % series)
    cli.write("target.yaml", text % (0.02, "flash: 6000 B"))
    done = cli.expect(cli.OVER, cli.bake("target"), "too small")
    line = [x for x in done.stdout.splitlines() if x.startswith("FAILED: the clip takes")][0]
    assert "6000 of flash" in line and "bases of mesh rag would fit" in line, line
    advised = float(line.split("set its tolerance to ")[1].split(",")[0])
    cli.write("target.yaml", text % (advised, "flash: 6000 B"))
    cli.expect(cli.DONE, cli.bake("target", "--quiet"))
    assert len(cli.read("target.wgl")) <= 6000
    cli.write("target.yaml", text % (0.02, "ram: 1 KB"))
    done = cli.expect(cli.OVER, cli.bake("target"), "too small")
    line = [x for x in done.stdout.splitlines() if x.startswith("FAILED: playing takes")][0]
    fits = int(line.split("meshes of ")[1].split()[0])
    assert 0 < fits < 144 and "instead of 144" in line, line


def check_and_info_know_meshes():
    series = write_series("known", cloth(20))
    shown, row = bake_mesh("known", "file: %s, normals: fixed" % series,
                           ("name: c, meshes: [{mesh: thing, rate: 20 Hz}]",),
                           "views: [{name: front, shading: smooth}]\n")
    text = cli.wiggly("info", cli.path("known.wgl")).stdout
    assert "shape 0: 144 vertices, %d bases" % row["bases"] in text, text
    assert "part 0: 242 triangles" in text and "view front" not in text and "view 0:" in text, text
    done = cli.wiggly("check", cli.path("known.yaml"), cli.path("known.wgl"), "--quiet")
    cli.expect(cli.DONE, done)
    header = cli.read("known.h").decode()
    for line in ("CLIP_SHAPES 2", "CLIP_VERTICES 144", "CLIP_BASES %d" % row["bases"],
                 "CLIP_PARTS 1", "CLIP_VIEWS 1", "CLIP_SHAPE_THING 0", "CLIP_VIEW_FRONT 0"):
        assert "#define " + line in header, line


TESTS = (faerie_meets_two_tolerances_as_numpy_sees_it, levels_leave_what_eckart_and_young_say,
         turning_cloth_is_shown_with_and_without_its_turns, pieces_are_in_use_one_at_a_time,
         a_loop_joins_its_end_to_its_first_frame, normals_follow_the_surface,
         additive_shapes_add_up, views_show_all_of_it,
         a_mesh_over_its_tolerance_fails_and_says_what_was_reached,
         a_target_that_is_too_small_says_what_would_fit, check_and_info_know_meshes)

if __name__ == "__main__":
    sys.exit(cli.main(TESTS))
