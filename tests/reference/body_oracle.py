#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Elastic bodies and spacetime control, second hand: what a scene's bodies do, with numpy and scipy
alone, from the words of examples/README.md and the thesis. Nothing here knows a wiggly spline: w(t) is
piecewise quintic on fine steps, its energy (2.19) the exact integral of that. Between two keys the
interior is eliminated, which leaves the curve of least force as a function of what it is at the keys;
those minimise the energy of the whole (2.32), all in one dense system with C2 as a condition. No case
distinction, no closed form. Energies of bodies: body_energy.py.

Source: Schulz 2013, chapter 2, errata S1-S9.
  x  n       coordinates [m], of chains also [rad]      M  n x n   masses [kg]
  V  n x d   basis of the reduced space, V^T M V = 1    q  d       x = origin + V q
  P  d x d   modes of one model: q = P c                z  5       (w0, w0', w1, w1', 1) of a segment"""
import numpy as np
import scipy.linalg


# ---- modes and reduced spaces ----------------------------------------------------------------------
def kept(n, fixed, slides):
    """Z: n x free, orthonormal: directions that are left. slides: (vertex, normal)."""
    against = [np.eye(n)[3 * v + k] for v in fixed for k in range(3)]
    for v, normal in slides:
        row = np.zeros(n)
        row[3 * v:3 * v + 3] = normal
        against.append(row)
    return scipy.linalg.null_space(np.array(against)) if against else np.eye(n)


class Modes:
    """The rigid ones, the unstable ones and k elastic ones."""

    def __init__(self, K, M, Z, k):
        lam, y = scipy.linalg.eigh(Z.T @ K @ Z, Z.T @ M @ Z)
        noise = 1e-11 * abs(lam).max()
        self.rigid = int((abs(lam) <= noise).sum())
        self.negative = int((lam < -noise).sum())
        count = min(self.rigid + self.negative + k, k + 6, len(lam))
        self.lam, self.phi = lam[:count], Z @ y[:, :count]
        self.elastic = self.lam[abs(self.lam) > noise]

    def hertz(self):
        return np.sign(self.elastic) * np.sqrt(abs(self.elastic)) / (2 * np.pi)


class Space:
    def __init__(self, origin, M, vectors):
        """Algorithm 2: an orthonormal basis of all vectors, each of length 1 first."""
        self.origin, self.M = origin, M
        half = scipy.linalg.sqrtm(M).real
        S = half @ np.array(vectors).T
        size = np.linalg.norm(S, axis=0)
        S = S[:, size > 1e-13 * np.linalg.norm(half @ origin)]
        U, s, _ = np.linalg.svd(S / np.linalg.norm(S, axis=0), full_matrices=False)
        self.V = np.linalg.solve(half, U[:, s > 1e-7 * s[0]])
        self.d = self.V.shape[1]

    def to(self, x):
        return self.V.T @ self.M @ (x - self.origin)

    def to_vector(self, u):
        return self.V.T @ self.M @ u


class Model:
    """q'' + (alpha + beta K) q' + K q + G = 0, in the modes of its own K."""

    def __init__(self, K, G, alpha, beta):
        lam, self.P = np.linalg.eigh((K + K.T) / 2)
        noise = 1e-11 * abs(lam).max()
        self.lam = np.where(abs(lam) <= noise, 0, lam)
        self.two_delta, self.g = alpha + beta * self.lam, self.P.T @ G


# ---- one mode between two knots --------------------------------------------------------------------
def hermite():
    """Coefficients in u of the six quintics of (w, w', w'') at 0 and at 1."""
    A = np.zeros((6, 6))
    for p in range(6):
        for k in range(3):
            falling = np.prod([p - i for i in range(k)]) if k else 1
            A[k, p] = falling if p == k else 0
            A[3 + k, p] = falling if p >= k else 0
    return np.linalg.inv(A).T  # row: function, column: power


HERMITE = hermite()


def powers(u, k):
    """Rows of k-th derivatives of 1, u, .. u^5."""
    out = np.zeros((np.size(u), 6))
    for p in range(k, 6):
        out[:, p] = np.prod([p - i for i in range(k)]) * np.asarray(u) ** (p - k) if k else \
            np.asarray(u) ** p
    return out


def grams():
    u, w = np.polynomial.legendre.leggauss(8)
    N = [powers((u + 1) / 2, k) @ HERMITE.T for k in range(3)]
    both = [[(N[a] * (w / 2)[:, None]).T @ N[b] for b in range(3)] for a in range(3)]
    return both, [w / 2 @ N[a] for a in range(3)]


GRAM, MEAN = grams()


class Segment:
    """The curve of least force between two knots, as a function of z; and its energies."""

    def __init__(self, lam, two_delta, g, span, fine):
        rate = max(np.sqrt(abs(lam)), two_delta)
        self.count = n = max(6, int(np.ceil(fine * rate * span)))
        self.span, self.h = span, span / n
        h = self.h

        def form(c):
            """Integral of (c0 w + c1 w' + c2 w'' + c3)^2 over a step, in (dofs, 1)."""
            out = np.zeros((7, 7))
            for a in range(3):
                for b in range(3):
                    out[:6, :6] += c[a] * c[b] * h ** (1 - a - b) * GRAM[a][b]
                out[:6, 6] += c[a] * c[3] * h ** (1 - a) * MEAN[a]
            out[6, :6], out[6, 6] = out[:6, 6], c[3] ** 2 * h
            return out  # dofs are w, h w', h^2 w''
        forms = [form((lam, two_delta, 1, g)), form((1, 0, 0, 0)), form((0, 1, 0, 0)),
                 form((0, 0, 1, 0))]
        self.eliminate(forms[0])
        self.energy, *self.size = [self.reduce(f) for f in forms]

    def eliminate(self, F):
        n = self.count
        rows = 3 * (n + 1)
        band = np.zeros((6, rows))
        for i in range(6):
            for j in range(i + 1):
                band[i - j, j:j + 3 * n:3] += F[i, j]
        b = np.zeros((rows, 5))
        for i in range(6):
            b[i:i + 3 * n:3, 4] -= F[i, 6]
        ends = [0, 1, rows - 3, rows - 2]
        free = np.setdiff1d(np.arange(rows), ends)
        full = np.zeros((rows, 5))
        for c, (e, v) in enumerate(zip(ends, (1, self.h, 1, self.h))):
            full[e, c] = v
        for e, c, v in zip(ends, range(4), (1, self.h, 1, self.h)):
            for k in range(6):
                if e + k < rows:
                    b[e + k, c] -= band[k, e] * v
                if k and e - k >= 0:
                    b[e - k, c] -= band[k, e - k] * v
        for e in ends:  # unit rows in place of what is known
            band[0, e] = band[:, e].max()
            band[1:, e] = 0
            for k in range(1, 6):
                if e - k >= 0:
                    band[k, e - k] = 0
            b[e] = 0
        solved = scipy.linalg.solveh_banded(band, b, lower=True)
        full[free] = solved[free]
        self.full = full

    def reduce(self, F):
        """z^T out z: the integral."""
        n = self.count
        steps = np.stack([self.full[3 * i:3 * i + 6] for i in range(n)])
        one = np.zeros((n, 1, 5))
        one[:, 0, 4] = 1
        y = np.concatenate([steps, one], axis=1)
        return np.einsum("nia,ij,njb->ab", y, F, y)

    def bend(self, end):
        """Row of z: w'' at an end."""
        return self.full[-1 if end else 2] / self.h ** 2

    def at(self, t, z):
        """w, w', w'' at times from the start of the segment."""
        i = np.clip((t / self.h).astype(int), 0, self.count - 1)
        u = t / self.h - i
        dofs = self.full @ z
        six = dofs[3 * i[:, None] + np.arange(6)]
        return [((powers(u, k) @ HERMITE.T) * six).sum(axis=1) / self.h ** k for k in range(3)]


# ---- a motion --------------------------------------------------------------------------------------
class Key:
    """A pose at a time. v: None = free. Weights: None = hard. rows, p: a partial pose."""

    def __init__(self, time, q, v=None, weight=None, v_weight=None, rows=None, p=None):
        self.time, self.q, self.v = time, q, v
        self.weight, self.v_weight, self.rows, self.p = weight, v_weight, rows, p


class Motion:
    """Minimises over the values and velocities at all knots, (q, q') d + d each."""

    def __init__(self, knots, models, keys, d, fine=2.5, regularise=(0, 0, 0), periodic=False,
                 stops=True):
        """models: one a segment. keys: by number of the knot. stops: where pose and velocity are both
        given between the ends, the motion is C1 only."""
        self.stops = stops
        self.knots, self.d, self.models = np.array(knots), d, models
        self.keys, self.periodic, self.regularise = keys, periodic, regularise
        self.segments = [[Segment(m.lam[i], m.two_delta[i], m.g[i], b - a, fine) for i in range(d)]
                         for m, a, b in zip(models, knots, knots[1:])]
        self.conditions()
        self.u = self.minimise()

    def rows(self, knot, what):
        """q (0) or q' (1) of a knot, as rows over all unknowns."""
        out = np.zeros((self.d, 2 * self.d * len(self.knots)))
        at = 2 * self.d * (knot % len(self.knots)) + self.d * what
        out[:, at:at + self.d] = np.eye(self.d)
        return out

    def z_rows(self, s):
        """Of segment s: (d modes) x 4 x unknowns."""
        P = self.models[s].P
        return np.stack([P.T @ self.rows(s + e, k) for e in (0, 1) for k in (0, 1)], axis=1)

    def bend_rows(self, s, end):
        """q'' at an end of a segment: rows and constant."""
        z, P = self.z_rows(s), self.models[s].P
        bend = np.array([seg.bend(end) for seg in self.segments[s]])
        return P @ np.einsum("ik,iku->iu", bend[:, :4], z), P @ bend[:, 4]

    def conditions(self):
        self.C, self.b = [], []

        def add(rows, value):
            size = np.linalg.norm(rows, axis=1, keepdims=True)
            size[size == 0] = 1
            self.C.append(rows / size)
            self.b.append(np.broadcast_to(value, len(rows)) / size[:, 0])
        last = len(self.knots) - 1
        for k, key in self.keys.items():
            if key.rows is not None and key.weight is None:  # as near as the space allows
                U, s, Vt = np.linalg.svd(key.rows, full_matrices=False)
                use = s > 1e-9 * s[0]
                want = (Vt[use].T / s[use]) @ U[:, use].T @ key.p
                add(Vt[use] @ self.rows(k, 0), Vt[use] @ want)
            elif key.weight is None:
                add(self.rows(k, 0), key.q)
            if key.v is not None and key.v_weight is None:
                add(self.rows(k, 1), key.v)
        inner = [(k - 1, k) for k in range(1, last) if not (self.stops and self.is_stop(k))]
        if self.periodic:
            inner.append((last - 1, 0))
            for what in (0, 1):
                add(self.rows(0, what) - self.rows(last, what), 0.0)
        for before, after in inner:
            (a, a0), (b, b0) = self.bend_rows(before, 1), self.bend_rows(after, 0)
            add(a - b, b0 - a0)
        self.C, self.b = np.concatenate(self.C), np.concatenate(self.b)

    def is_stop(self, k):
        key = self.keys.get(k)
        return key is not None and key.v is not None and key.v_weight is None and (
            key.weight is None or key.rows is not None)

    def minimise(self):
        size = self.C.shape[1]
        A, r = np.zeros((size, size)), np.zeros(size)
        for s, segs in enumerate(self.segments):
            z = self.z_rows(s)
            for i, seg in enumerate(segs):
                F = seg.energy + sum(w * f for w, f in zip(self.regularise, seg.size))
                A += z[i].T @ F[:4, :4] @ z[i]
                r += z[i].T @ F[:4, 4]
        for k, key in self.keys.items():
            for rows, want, weight in ((self.rows(k, 0), key.q, key.weight),
                                       (self.rows(k, 1), key.v, key.v_weight)):
                if weight is not None and want is not None:
                    if key.rows is not None and want is key.q:
                        rows, want = key.rows @ rows, key.p
                    if self.periodic and k == len(self.knots) - 1:
                        continue  # it is the first one again
                    A += weight * rows.T @ rows
                    r -= weight * rows.T @ want
        U, s, Vt = np.linalg.svd(self.C)
        rank = int((s > 1e-9 * s[0]).sum())
        u = Vt[:rank].T @ ((U[:, :rank].T @ self.b) / s[:rank])
        N = Vt[rank:].T
        if N.shape[1]:
            H = N.T @ A @ N
            scale = 1 / np.sqrt(np.diag(H))
            u = u - N @ (scale * np.linalg.solve(H * scale * scale[:, None],
                                                 scale * (N.T @ (A @ u + r))))
        return u

    def z(self, s, i):
        return np.append(self.z_rows(s)[i] @ self.u, 1)

    @property
    def energy(self):
        return sum(self.z(s, i) @ seg.energy @ self.z(s, i)
                   for s, segs in enumerate(self.segments) for i, seg in enumerate(segs))

    def at(self, times):
        """q, q', q'': times x d; clamped to its ends, or wrapped."""
        t = np.array(times, float)
        a, b = self.knots[0], self.knots[-1]
        t = a + (t - a) % (b - a) if self.periodic else np.clip(t, a, b)
        which = np.clip(np.searchsorted(self.knots, t, side="right") - 1, 0, len(self.knots) - 2)
        out = np.zeros((3, len(t), self.d))
        for s in np.unique(which):
            here = which == s
            c = np.array([seg.at(t[here] - self.knots[s], self.z(s, i))
                          for i, seg in enumerate(self.segments[s])])
            out[:, here] = np.einsum("ikt,ji->ktj", c, self.models[s].P)
        return out

    def force(self, times, model):
        """|f|^2 of a model at times."""
        c = self.at(times) @ model.P
        f = c[2] + model.two_delta * c[1] + model.lam * c[0] + model.g
        return (f ** 2).sum(axis=1)


class Blend:
    """h_j weighs the motion through all poses as model j has it; fades in the middle half (S6, S7)."""

    def __init__(self, motions, times):
        self.motions, self.times = motions, np.array(times)

    def weight(self, j, t):
        def rise(a, b):
            u = np.clip((t - (a + (b - a) / 4)) / ((b - a) / 2), 0, 1)
            return u ** 3 * (10 + u * (6 * u - 15))
        T, h = self.times, np.ones_like(t)
        if j > 0:
            h = h * rise(T[j - 1], T[j])
        if j + 1 < len(T):
            h = h * (1 - rise(T[j], T[j + 1]))
        return h

    def at(self, times):
        t = np.clip(np.array(times, float), self.times[0], self.times[-1])
        return sum(self.weight(j, t)[:, None] * m.at(t)[0] for j, m in enumerate(self.motions))[None]

    @property
    def energy(self):
        u, w = np.polynomial.legendre.leggauss(6)
        edges = np.concatenate([np.linspace(a, b, 401)[:-1] for a, b in
                                zip(self.times, self.times[1:])] + [self.times[-1:]])
        half = np.diff(edges) / 2
        t = (edges[:-1, None] + half[:, None] * (1 + u)).ravel()
        w = (half[:, None] * w).ravel()
        return sum((w * self.weight(j, t) * m.force(t, m.models[0])).sum()
                   for j, m in enumerate(self.motions))
