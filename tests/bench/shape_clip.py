# SPDX-License-Identifier: MIT
"""Our side of the benchmark of shapes: a sequence baked by build/wiggly, and what the clip holds,
by the decoder of tests/reference (written from SPEC.md), so that neither the baker's loader nor the
player nor the certificate takes part in the figures."""
import json
import os
import shutil
import subprocess
import sys

import numpy as np

import shape_frames

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "tests", "reference"))
import wgl  # noqa: E402
import wgl_shape  # noqa: E402

RECORD = dict(zip(wgl.SECTIONS, wgl.RECORD))

SCENE = """name: %(name)s
meshes:
  - {name: %(name)s, file: %(name)s.obj, tolerance: %(tolerance).9g%(more)s}
clips:
  - name: all
    end: hold
    meshes:
      - {mesh: %(name)s, file: %(name)s.pc2, rate: %(rate)g Hz}
layers:
  - {name: base, clip: all}
%(view)s"""


def baker(folder):
    """A copy for the whole run, so that every figure is of the same one."""
    own = os.path.join(folder, "wiggly")
    if not os.path.exists(own):
        shutil.copy(os.path.join(ROOT, "build", "wiggly"), own + "_")
        os.rename(own + "_", own)
    return own


def bake(folder, sequence, tolerance, more="", view=""):
    """(path of the clip, certificate), or (None, what the baker said)."""
    stem = os.path.join(folder, sequence.name)
    if not os.path.exists(stem + ".pc2"):
        shape_frames.write_cache(sequence, stem)
    with open(stem + ".yaml", "w") as f:
        f.write(SCENE % {"name": sequence.name, "tolerance": tolerance, "more": more,
                         "rate": sequence.rate, "view": view})
    done = subprocess.run([baker(folder), "bake", stem + ".yaml", "-o", stem + ".wgl", "--json",
                           stem + ".json", "--quiet"], capture_output=True, text=True)
    if done.returncode != 0:
        return None, done.stderr.strip()
    with open(stem + ".json") as f:
        return stem + ".wgl", json.load(f)


class Clip:
    """A baked clip of one mesh and one clip."""

    def __init__(self, path, sequence):
        with open(path, "rb") as f:
            self.clip = wgl.Clip(f.read())
        self.shapes = wgl_shape.Shapes(self.clip)
        self.sequence = sequence
        self.shape = self.clip.shapes[self.clip.parts[0].shape]
        self.bits = sorted({b.bits for b in self.blocks(self.shape)}) or [0]
        self.e = np.array(self.shape.e, np.int64).reshape(self.shape.basis_count, -1)
        self.values = [self.sample(round(i * 1e6 / sequence.rate)) for i in range(sequence.count)]
        self.places = self.match(self.posed(len(self.shape.bases)))

    def blocks(self, shape):
        return self.clip.blocks[shape.block_first:shape.block_first + shape.block_count]

    def sample(self, time_us):
        """Raw values of all channels: SPEC 6.4."""
        position, clip = self.clip.position(0, time_us), self.clip.clips[0]
        values = [c.rest for c in self.clip.channels]
        for k in clip.tracks:
            values[self.clip.tracks[k].channel] = self.clip.track_value(k, position)
        return values

    def posed(self, bases):
        """Every frame with the first so many bases, in units of length: SPEC 6.8 on arrays."""
        poses = [self.shapes.pose(self.clip.parts[0].shape, v, bases) for v in self.values]
        weights = np.array([p.weights for p in poses], np.int64).reshape(len(poses), -1)
        total = (np.array(self.shape.xyz, np.int64) << 15) + weights @ self.e
        p = (((total + (1 << 14)) >> 15) + 32768) % 65536 - 32768
        p = p.reshape(len(poses), -1, 3)
        matrix = np.array([pose.matrix for pose in poses], np.int64)
        shift = np.array([pose.n - 8 for pose in poses], np.int64)[:, None, None]
        move = np.array([pose.move for pose in poses], np.int64)[:, None]
        out = (np.einsum("nrc,nmc->nmr", matrix, p) >> shift) + move
        return out / 2.0 ** (self.shape.frac + 8)

    def match(self, posed):
        """Which of the sequence's vertices each of the clip's is: the one with the nearest path."""
        ours = posed.transpose(1, 0, 2).reshape(posed.shape[1], -1)
        theirs = self.sequence.frames.transpose(1, 0, 2).reshape(self.sequence.vertices, -1)
        apart = (ours ** 2).sum(1)[:, None] + (theirs ** 2).sum(1) - 2 * ours @ theirs.T
        places = apart.argmin(1)
        if len(set(places)) != self.sequence.vertices:
            raise ValueError("%s: %d of %d vertices found" % (
                self.sequence.name, len(set(places)), self.sequence.vertices))
        return places

    def error(self, bases=64):
        """(root mean square, largest) distance of a posed vertex from the sequence's."""
        off = np.linalg.norm(self.posed(bases) - self.sequence.frames[:, self.places], axis=2)
        return float(np.sqrt(np.mean(off ** 2))), float(off.max())

    # ---- where the bytes are ---------------------------------------------------------------------
    def parts(self, bases=64):
        """name -> bytes; every byte of the file counts once. With fewer bases, what those that are
        left out hold is not there."""
        owner = Owner(self.clip)
        shape = self.shape
        kept = {b.channel for b in shape.bases[:bases]}
        gone = {b.channel for b in shape.bases[bases:]}
        affine = set() if shape.affine == wgl_shape.ABSENT else set(
            range(shape.affine, shape.affine + 12))
        owner.records("shapes", 0, self.clip.count["shapes"], "rest")
        owner.data(shape.rest, 6 * shape.vertices, "rest")
        owner.records("bases", shape.basis_first, shape.basis_count, "bases")
        for i, block in enumerate(self.blocks(shape), shape.block_first):
            late = block.a >= bases and (block.b >= bases or block.b == wgl_shape.ABSENT)
            owner.records("blocks", i, 1, "gone" if late else "bases")
            owner.data(block.data, self.shapes.block_size(block), "gone" if late else "bases")
        for i, part in enumerate(self.clip.parts):
            owner.records("parts", i, 1, "triangles")
            owner.data(part.data, 6 * part.triangles, "triangles")
        for names, name in ((gone, "gone"), (affine, "transforms"), (kept, "weights")):
            self.own_channels(owner, names, name)
        return owner.sums()

    def own_channels(self, owner, channels, name):
        """Later ones overwrite: key times that are shared with a channel that stays, stay."""
        for i, track in enumerate(self.clip.tracks):
            if track.channel not in channels:
                continue
            owner.records("tracks", i, 1, name)
            owner.records("runs", track.run_first, track.run_count, name)
            for run in track.runs:
                owner.data(run.times, 2 * run.segments, name)
                owner.data(run.data, wgl.Clip.data_bytes(run), name)
        for channel in channels:
            owner.records("channels", channel, 1, name)


class Owner:
    """A name for each byte of a clip."""

    def __init__(self, clip):
        self.clip, self.names = clip, ["other"]
        self.bytes = np.zeros(clip.length, np.uint8)

    def mark(self, at, size, name):
        if name not in self.names:
            self.names.append(name)
        self.bytes[at:at + size] = self.names.index(name)

    def records(self, section, first, count, name):
        size = RECORD[section]
        self.mark(self.clip.offset[section] + first * size, count * size, name)

    def data(self, at, size, name):
        self.mark(self.clip.offset["data"] + at, size, name)

    def sums(self):
        return {name: int(np.sum(self.bytes == i)) for i, name in enumerate(self.names)}
