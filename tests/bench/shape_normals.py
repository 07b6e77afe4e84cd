# SPDX-License-Identifier: MIT
"""Three kinds of normals: what a frame costs with each, and how far they are from recomputed ones.
                                                                              [Alexa 7.3.3; Table 7.2]
    fixed         a shape of normals without bases: those of the rest pose, turned with the whole
    interpolated  a shape of normals with the weights of the positions
    recomputed    sums of the posed triangles' cross products

Costs: instructions in tests/fw_normals.c of one call of wg_picture_set (every vertex posed, projected
and shaded), and of drawing; compiled for the Cortex-M4 with the kernel that uses its 16-bit products,
and for the Cortex-M3 with the plain one, both counted on the emulated M4. The thesis's seconds, 1 : 1.21
: 1.75 and 1 : 1.27 : 2.11, hold the drawing. Angles: between unit normals in the scene's axes, by the
independent decoder; "recomputed" are NumPy's there.
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
BOARD = "mps2-an386"
CORES = {"M4": [], "M3": ["KERNEL=plain",
                          "CPU=-mcpu=cortex-m3 -mthumb -mfloat-abi=soft -ffreestanding"]}
VIEW = "views:\n  - {name: front, shading: smooth}\n"


def models():
    """A bar about as large as each model of the thesis's table: 1,000 and 14,268 vertices."""
    small = shape_frames.make_bar(120)
    large = shape_frames.make_bar(16, 164, 87)
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
def image(core, stem):
    """The cost image with a clip."""
    folder = "build/bench/" + core
    done = subprocess.run(["make", "-s", "BOARD=" + BOARD, "PROGRAM=tests/fw_normals.c", "OPT=-O2",
                           "B=" + folder, "CLIP=" + stem + ".wgl", "image"] + CORES[core],
                          cwd=shape_clip.ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return "%s/%s/fw_normals.elf" % (folder, os.path.basename(stem))


def count(path, function):
    """Instructions of one call of a function: the mean, because each f-th call costs more."""
    done = subprocess.run(["/usr/bin/python3", "tests/tools/run_board.py", BOARD, path, "--roi",
                           function, "--timeout", "60"], cwd=shape_clip.ROOT, capture_output=True,
                          text=True)
    found = re.search(r"calls (\d+) .*total (\d+)", done.stdout + done.stderr)
    if done.returncode != 0 or not found or int(found[1]) == 0:
        raise RuntimeError("%s: %s%s" % (path, done.stdout, done.stderr))
    return round(int(found[2]) / int(found[1]))


def costs_of(stem):
    """(core, function's end) -> instructions."""
    out = {}
    for core in CORES:
        path = image(core, stem)
        for what in ("every_1", "every_2", "every_4", "draw") if core == "M4" else ("every_1",):
            out[core, what] = count(path, "cost_" + what)
    return out


# ---- both ----------------------------------------------------------------------------------------
def rows(columns):
    """Rows of the benchmark's table; prints them too."""
    if not shutil.which("arm-none-eabi-gcc") or not shutil.which("qemu-system-arm"):
        print("skipped normals: no arm-none-eabi-gcc, or no qemu-system-arm")
        return []
    out = []
    subprocess.run(["make", "-s", "tools"], cwd=shape_clip.ROOT, check=True)
    print("\n| model | normals | f | mean angle | largest | M4 instructions a frame | of fixed | M3 "
          "| of fixed | drawing 128 x 64, M4 |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    folder = os.path.join(shape_clip.ROOT, "build", "bench")
    os.makedirs(folder, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        for sequence in models():
            fixed = {}
            for kind in KINDS:
                out += model_rows(columns, scratch, sequence, (kind, fixed))
    return out


def model_rows(columns, scratch, sequence, kind_fixed):
    """One kind of normals; the first, fixed, leaves its costs for the others' ratios."""
    kind, fixed = kind_fixed
    more = ", bits: 8, bases: 8, normals: " + kind
    path, said = shape_clip.bake(scratch, sequence, sequence.height / 100, more, VIEW)
    if path is None:
        print("%s: %s" % (sequence.name, said))
        return []
    clip = shape_clip.Clip(path, sequence)
    costs = costs_of(path[:-4])
    fixed.update({} if fixed else costs)
    out = []
    for every, mean, most in angle_rows(sequence, kind, clip):
        cells = []
        for core in CORES:
            cost = costs.get((core, "every_%d" % every))
            cells += ["%d" % cost, "%.2f" % (cost / fixed[core, "every_1"])] if cost else ["", ""]
        print("| %s | %s | %d | %.2f deg | %.1f deg | %s | %s | %s | %s | %d |" % (
            (sequence.name, NAMES[kind], every, mean, most) + tuple(cells) + (costs["M4", "draw"],)))
        line = dict.fromkeys(columns, "")
        line.update(table="7.2", sequence=sequence.name, case="f = %d" % every, what=NAMES[kind],
                    k=len(clip.shape.bases), bytes=clip.clip.length, rms="%.4g" % mean,
                    max="%.4g" % most, note="angles; instructions: M4 %s, M3 %s, drawing on M4 %d" % (
                        cells[0], cells[2] or "-", costs["M4", "draw"]))
        out.append(line)
    return out
