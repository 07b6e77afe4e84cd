# SPDX-License-Identifier: MIT
"""Key frames as weighted bases in doubles: what [Alexa Table 7.1] would have said about errors.

    frames  n x m x 3, F_i its frames as 3 x m
    T_i     affine map that takes frame i nearest to frame 0                    [Alexa 7.2; (4.3)]
    F       T_i F_i, stacked to n x 3m, with or without their mean               [(7.6)]
    A       n x k weights, B k x 3m bases of the k largest singular values         [(7.7)]
    posed   T_i^-1 (mean + A_i B)                                                 [(7.5)]

Bytes are counted as floats of 4 bytes: k m 12 of bases, n k 4 of weights, n 48 of transforms, m 12 of
mean. The printed table counts 12 bytes a basis instead of weights and transforms.
"""
import numpy as np


def maps_to_first(frames, rigid):
    """n x 4 x 3: (x 1) M = x seen from frame 0. Where a frame is flat or mirrored, or if `rigid`, the
    best rotation [Kabsch]."""
    reference = frames[0] - frames[0].mean(0)
    out = np.zeros((len(frames), 4, 3))
    for i, frame in enumerate(frames):
        centre = frame.mean(0)
        moved = frame - centre
        turn, _, rank, sizes = np.linalg.lstsq(moved, reference, rcond=1e-9)
        if rigid or rank < 3 or np.linalg.det(turn) <= 0 or sizes[2] < 1e-3 * sizes[0]:
            u, _, vt = np.linalg.svd(moved.T @ reference)
            turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
        out[i, :3], out[i, 3] = turn, frames[0].mean(0) - centre @ turn
    return out


class Bases:
    """Singular value decomposition of a sequence; posed(k) is the animation with its first k bases.
    maps: none, rigid or affine."""

    def __init__(self, frames, maps, mean):
        self.frames, self.kind, self.mean = frames, maps, mean
        n, m = frames.shape[:2]
        moving = maps != "none"
        self.maps = maps_to_first(frames, maps == "rigid") if moving else None
        shapes = frames if not moving else (
            np.einsum("nmi,nij->nmj", frames, self.maps[:, :3]) + self.maps[:, None, 3])
        flat = shapes.reshape(n, 3 * m)
        self.rest = flat.mean(0) if mean else np.zeros(3 * m)
        self.u, self.s, self.vt = np.linalg.svd(flat - self.rest, full_matrices=False)
        self.inverse = np.linalg.inv(self.maps[:, :3]) if moving else None

    def posed(self, k):
        n, m = self.frames.shape[:2]
        shapes = (self.rest + (self.u[:, :k] * self.s[:k]) @ self.vt[:k]).reshape(n, m, 3)
        if self.maps is None:
            return shapes
        return np.einsum("nmi,nij->nmj", shapes - self.maps[:, None, 3], self.inverse)

    def error(self, k):
        """(root mean square, largest) distance of a posed vertex from where it should be."""
        off = np.linalg.norm(self.posed(k) - self.frames, axis=2)
        return float(np.sqrt(np.mean(off ** 2))), float(off.max())

    def needed(self, tolerance):
        """Smallest k whose largest error is within the tolerance; the error falls with k but for
        wiggles, so that bisection finds a border."""
        low, high = 0, len(self.s)
        while low < high:
            k = (low + high) // 2
            if self.error(k)[1] <= tolerance:
                high = k
            else:
                low = k + 1
        return low

    def bytes(self, k):
        """name -> bytes as floats of 4 bytes."""
        n, m = self.frames.shape[:2]
        return {"bases": k * m * 12, "weights": n * k * 4, "transforms": n * 48 * (self.maps is not None),
                "rest": m * 12 * self.mean}


def noise(sequence):
    """What rounding in the file left: root mean square and largest distance of a vertex, and how many
    singular values stand above the largest that such noise has by itself, s (sqrt n + sqrt 3m) for
    independent entries of deviation s [Marchenko and Pastur]; and the share of the noise's energy
    in what remains below it."""
    n, m = sequence.count, sequence.vertices
    variance = float(np.mean(np.sum(sequence.steps ** 2, axis=1) / 12))
    largest = float(np.linalg.norm(sequence.steps, axis=1).max() / 2)
    s = Bases(sequence.frames, "none", True).s
    edge = np.sqrt(variance / 3) * (np.sqrt(n) + np.sqrt(3 * m))
    above = int(np.sum(s > edge))
    rms = [float(np.sqrt(np.sum(s[k:] ** 2) / (n * m))) for k in range(len(s))] + [0.0]
    return {"noise_rms": variance ** 0.5, "noise_max": largest, "values": len(s), "above": above,
            "tail_rms": rms[above], "singular": s}


def rounded(frames):
    """What an MD2 file would hold: 255 steps along each side of each frame's box."""
    low = frames.min(1, keepdims=True)
    step = np.ptp(frames, axis=1, keepdims=True) / 255
    return np.rint((frames - low) / step) * step + low
