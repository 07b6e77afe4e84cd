# SPDX-License-Identifier: MIT
"""Three kinds of normals: what a frame costs with each, and how far they are from recomputed ones.
                                                                              [Alexa 7.3.3; Table 7.2]
    fixed         a shape of normals without bases: those of the rest pose, turned with the whole
    interpolated  a shape of normals with the weights of the positions
    recomputed    sums of the posed triangles' cross products

Costs: instructions in tests/fw_normals.c of one call of wg_picture_set (every vertex posed, projected
and shaded), on an emulated Cortex-M4 with the kernel that uses its 16-bit products, and on a Cortex-M3
with the plain one. Angles: between unit normals in the scene's axes, by the independent decoder.
"""
import os
import re
import shutil
import subprocess
import tempfile

import numpy as np

import shape_clip
import shape_frames

KINDS = ("fixed", "interpolated", "none")
NAMES = {"fixed": "fixed", "interpolated": "interpolated", "none": "recomputed"}
BOARDS = (("mps2-an386", "M4"), ("lm3s6965evb", "M3"))
VIEW = "views:\n  - {name: front, shading: smooth}\n"


def models():
    """A bar about as large as each model of the thesis's table: 1,000 and 14,268 vertices."""
    small = shape_frames.make_bar(120)
    large = shape_frames.make_bar(30, 164, 87)
    small.name, large.name = "bar1000", "bar14268"
    return [small, large]


# ---- angles --------------------------------------------------------------------------------------
def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


def recomputed(positions, corners):
    """Area-weighted normals of frames x vertices x 3."""
    p, q, r = (positions[:, corners[:, i]] for i in range(3))
    cross = np.cross(q - p, r - p)
    out = np.zeros_like(positions)
    for i in range(3):
        np.add.at(out.transpose(1, 0, 2), corners[:, i], cross.transpose(1, 0, 2))
    return unit(out)


def stored(clip):
    """The clip's own normals, posed: SPEC 6.8."""
    part = clip.clip.parts[0]
    shape = clip.clip.shapes[part.normals]
    rest, bases = np.array(shape.xyz, np.int64), np.array(shape.e, np.int64)
    out = []
    for values in clip.values:
        pose = clip.shapes.pose_normals(part.normals, values, clip.shapes.pose(part.shape, values))
        total = (rest << 15) + np.array(pose.weights, np.int64) @ bases.reshape(-1, rest.size)
        vectors = ((total + (1 << 14)) >> 15).reshape(-1, 3)
        out.append(vectors @ np.array(pose.matrix, np.int64).T)
    return unit(np.array(out, np.float64))


def degrees(a, b):
    return np.degrees(2 * np.arcsin(np.minimum(1, np.linalg.norm(a - b, axis=-1) / 2)))


def angle_rows(sequence, kind, clip):
    """Mean and largest angle over frames and vertices, for normals renewed each f-th frame."""
    positions = clip.posed(64)
    corners = np.array([c for part in clip.clip.parts for c in part.corners]).reshape(-1, 3)
    exact = recomputed(positions, corners)
    ours = exact if kind == "none" else stored(clip)
    for every in (1, 2, 4):
        shown = ours[np.arange(len(ours)) // every * every]
        off = degrees(shown, exact)
        yield every, float(off.mean()), float(off.max())


# ---- instructions --------------------------------------------------------------------------------
def image(board, stem):
    """The cost image with a clip, or None when it does not fit the board."""
    done = subprocess.run(["make", "-s", "BOARD=" + board, "PROGRAM=tests/fw_normals.c", "OPT=-O2",
                           "B=build/bench/" + board, "CLIP=" + stem + ".wgl", "image"],
                          cwd=shape_clip.ROOT, capture_output=True, text=True)
    path = "build/bench/%s/%s/fw_normals.elf" % (board, os.path.basename(stem))
    if done.returncode == 0:
        return path
    if "will not fit" in done.stderr or "overflowed" in done.stderr:
        return None
    raise RuntimeError(done.stderr)


def count(board, path, function):
    """(calls, total) instructions of a function."""
    done = subprocess.run(["/usr/bin/python3", "tests/tools/run_board.py", board, path, "--roi",
                           function, "--timeout", "60"], cwd=shape_clip.ROOT, capture_output=True,
                          text=True)
    found = re.search(r"calls (\d+) .*total (\d+)", done.stdout + done.stderr)
    if done.returncode != 0 or not found:
        raise RuntimeError("%s: %s%s" % (path, done.stdout, done.stderr))
    return int(found[1]), int(found[2])


def cost_rows(sequence, kind, stem):
    for board, core in BOARDS:
        path = image(board, stem)
        if path is None:
            yield core, 1, None
            continue
        for every in (1, 2, 4):
            calls, total = count(board, path, "cost_every_%d" % every)
            yield core, every, total / calls


# ---- both ----------------------------------------------------------------------------------------
def rows(columns):
    """Rows of the benchmark's table; prints them too."""
    if not shutil.which("arm-none-eabi-gcc") or not shutil.which("qemu-system-arm"):
        print("skipped normals: no arm-none-eabi-gcc, or no qemu-system-arm")
        return []
    out = []
    subprocess.run(["make", "-s", "tools"], cwd=shape_clip.ROOT, check=True)
    print("\n| model | normals | f | mean angle | largest | M4 instructions a frame | M3 |")
    print("|---|---|---|---|---|---|---|")
    folder = os.path.join(shape_clip.ROOT, "build", "bench")
    os.makedirs(folder, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        for sequence in models():
            for kind in KINDS:
                out += model_rows(columns, scratch, sequence, kind)
    return out


def model_rows(columns, scratch, sequence, kind):
    more = ", bits: 8, bases: 8, normals: " + kind
    path, said = shape_clip.bake(scratch, sequence, sequence.height / 100, more, VIEW)
    if path is None:
        print("%s: %s" % (sequence.name, said))
        return []
    clip = shape_clip.Clip(path, sequence)
    angles = {every: (mean, most) for every, mean, most in angle_rows(sequence, kind, clip)}
    costs = {(core, every): n for core, every, n in cost_rows(sequence, kind, path[:-4])}
    out = []
    for every, (mean, most) in angles.items():
        cost = [costs.get((core, every)) for _, core in BOARDS]
        text = ["does not fit" if n is None else "%d" % n for n in cost]
        print("| %s | %s | %d | %.2f deg | %.1f deg | %s | %s |" % (
            (sequence.name, NAMES[kind], every, mean, most) + tuple(text)))
        line = dict.fromkeys(columns, "")
        line.update(table="7.2", sequence=sequence.name, case="f = %d" % every, what=NAMES[kind],
                    k=len(clip.shape.bases), bytes=clip.clip.length, rms="%.4g" % mean,
                    max="%.4g" % most, note="instructions: M4 %s, M3 %s" % tuple(text))
        out.append(line)
    return out
