#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Frames of meshes, their principal components and what a clip shows of them, with numpy and the
reference decoder: nothing of the baker or the player.

    pca_oracle.py clip.wgl CLIP RATE FIRST LAST model.md2     largest and rms distance"""
import struct
import sys

import numpy as np

import wgl
import wgl_shape


def md2_frames(path):
    """frames x vertices x 3 of an MD2 file, y up: (x, y, z) becomes (x, z, -y)."""
    with open(path, "rb") as file:
        blob = file.read()
    head = struct.unpack_from("<17i", blob)
    assert head[0] == 0x32504449 and head[1] == 8
    size, vertices, frames, at = head[4], head[6], head[10], head[14]
    out = np.empty((frames, vertices, 3))
    for f in range(frames):
        base = at + f * size
        scale, move = struct.unpack_from("<3f", blob, base), struct.unpack_from("<3f", blob,
                                                                                base + 12)
        raw = np.frombuffer(blob, np.uint8, 4 * vertices, base + 40).reshape(vertices, 4)
        x, y, z = (raw[:, k] * np.float64(scale[k]) + move[k] for k in range(3))
        out[f] = np.stack([x, z, -y], axis=1)
    return out


def left_by_bases(frames, mean=True):
    """rms distance of a vertex that the best k bases leave, for k = 0, 1, ... [Eckart, Young]."""
    F = frames.reshape(len(frames), -1).T
    F = F - F.mean(axis=1, keepdims=True) if mean else F
    s = np.linalg.svd(F, compute_uv=False)
    tails = np.append(np.cumsum((s ** 2)[::-1])[::-1], 0)
    return np.sqrt(tails / (frames.shape[0] * frames.shape[1]))


class Shown:
    """Posed vertices of an open clip, in units of length."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self.clip = wgl.Clip(file.read())
        self.shapes = wgl_shape.Shapes(self.clip)

    def at(self, values, shape=0, bases=64):
        flat = self.shapes.vertices(shape, self.shapes.pose(shape, values, bases))
        frac = self.clip.shapes[shape].frac
        return np.array(flat, float).reshape(-1, 3) / 2.0 ** (frac + 8)

    def frames(self, clip, rate, count, shape=0, bases=64):
        return np.stack([self.at(self.clip.sample(clip, round(i / rate * 1e6))[0], shape, bases)
                         for i in range(count)])

    def weights(self, clip, rate, count, shape=0):
        return np.array([self.shapes.weights(self.clip.shapes[shape], self.clip.sample(
            clip, round(i / rate * 1e6))[0], 64) for i in range(count)])


def matched(shown, frames):
    """The largest distance of each vertex from its own, whatever order the clip has them in: the
    vertex of `frames` that stays nearest over all frames. Also: whether that is one to one."""
    worst = np.zeros((shown.shape[1], frames.shape[1]))
    for a, b in zip(shown, frames):
        worst = np.maximum(worst, np.linalg.norm(a[:, None] - b[None], axis=2))
    nearest = worst.argmin(axis=1)
    return worst.min(axis=1), len(set(nearest)) == len(nearest), nearest


def main(argv):
    clip, rate, first, last = int(argv[2]), float(argv[3]), int(argv[4]), int(argv[5])
    frames = md2_frames(argv[6])[first:last + 1]
    shown = Shown(argv[1]).frames(clip, rate, len(frames))
    far, one, nearest = matched(shown, frames)
    rms = np.sqrt(((shown - frames[:, nearest]) ** 2).sum(axis=2).mean())
    print("largest %.6g, rms %.6g, vertices one to one: %s" % (far.max(), rms, one))


if __name__ == "__main__":
    main(sys.argv)
