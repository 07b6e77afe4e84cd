#!/usr/bin/env python3
# Motions of least force, without modes and without wiggly splines: the test vectors of
# tests/test_bake_spacetime_oracle.c.
#   command   python3 tests/reference/spacetime_oracle.py > tests/vectors/spacetime_oracle.csv
#   needs     numpy, scipy
# Source: Schulz 2013, (2.10), (2.20), 2.8. In coordinates q of the space, where Phi mixes all modes:
#   one-point, blend   quintic Hermite finite elements for q(t): the integral of
#                      |q'' + D q' + K q + G|^2 and the soft keys are one linear least squares
#                      problem, the hard keys its constraints. Each result comes with what halving
#                      the elements changes.
#   couple             q'''' + (2 K - D^2) q'' + K^2 q + K G = 0 on each half gap by matrix
#                      exponentials; C2 at keys and switches and the poses are constraints. (Not by
#                      finite elements: a jump of q'' at one time can be smoothed at no cost, so
#                      that with all functions the problem is the one without that condition.)
# Each case: the settings, models, keys, then samples of q.
# SPDX-License-Identifier: AGPL-3.0-or-later
import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.linalg import expm, lstsq, qr

FREE, VELOCITY, PERIODIC = 0, 1, 3
HARD = -1.0
random = np.random.default_rng(2013)


class Model:
    def __init__(self, lam, inner, outer):
        d = len(lam)
        self.lam, self.inner, self.outer = map(np.array, (lam, inner, outer))
        self.Phi = qr(random.standard_normal((d, d)))[0]

    def matrices(self, s):
        K = s.stiffness * (self.Phi * self.lam) @ self.Phi.T
        D = s.alpha * np.eye(len(self.lam)) + s.beta * K
        return K, D, self.Phi @ (s.stiffness * self.inner + self.outer)


class Settings:
    def __init__(self, alpha=0.0, beta=0.0, stiffness=1.0, end=(VELOCITY, VELOCITY),
                 v=(None, None)):
        self.alpha, self.beta, self.stiffness = alpha, beta, stiffness
        self.end, self.v = end, v


class Key:
    """S q = p with one weight; a whole pose has S = 1"""

    def __init__(self, time, q, weight=HARD, S=None):
        self.time, self.weight, self.whole = time, weight, S is None
        self.S = np.eye(len(q)) if S is None else np.array(S, float)
        self.q = np.array(q, float)
        self.p = self.S @ self.q


def least_squares(A, b, C, e):
    """min |A x - b|^2, C x = e, C of full rank"""
    Q, R = qr(C.T)
    r = C.shape[0]
    y = np.linalg.solve(R[:r, :r].T, e)
    x0, N = Q[:, :r] @ y, Q[:, r:]
    z = lstsq(A @ N, b - A @ x0, lapack_driver="gelsy")[0]
    return x0 + N @ z


def hermite(u, h):
    """value, velocity, acceleration (rows) at u in 0..1 from (q, q', q'') at both ends"""
    V = []
    for x in (0.0, 1.0):
        for k in range(3):
            V.append([np.prod(range(j - k + 1, j + 1)) * x ** (j - k) if j >= k else 0.0
                      for j in range(6)])
    C = np.linalg.inv(np.array(V))
    scale = np.array([1.0, h, h * h] * 2)
    rows = [np.array([np.prod(range(j - k + 1, j + 1)) * u ** (j - k) if j >= k else 0.0
                      for j in range(6)]) @ C * scale / h ** k for k in range(3)]
    return np.array(rows)


class Elements:
    def __init__(self, model, s, keys, per_gap):
        self.d, self.s = len(keys[0].q), s
        self.t = np.concatenate([np.linspace(a.time, b.time, per_gap + 1)[:-1]
                                 for a, b in zip(keys, keys[1:])] + [[keys[-1].time]])
        self.n, self.per_gap = len(self.t), per_gap
        K, D, G = model.matrices(s)
        self.solve(K, D, G, keys)

    def columns(self, node):
        if self.s.end[0] == PERIODIC:
            node %= self.n - 1
        return slice(3 * self.d * node, 3 * self.d * (node + 1))

    def row(self, element, u):
        """3 d x size: q, q', q''"""
        h = self.t[element + 1] - self.t[element]
        H, out = hermite(u, h), np.zeros((3 * self.d, self.size))
        for end in range(2):
            out[:, self.columns(element + end)] += np.kron(H[:, 3 * end:3 * end + 3],
                                                           np.eye(self.d))
        return out

    def solve(self, K, D, G, keys):
        d, loop = self.d, self.s.end[0] == PERIODIC
        self.size = 3 * d * (self.n - loop)
        A, b, C, e = [], [], [], []
        nodes, weights = leggauss(8)
        for k in range(self.n - 1):
            h = self.t[k + 1] - self.t[k]
            for x, w in zip(nodes, weights):
                R = self.row(k, 0.5 + 0.5 * x)
                root = np.sqrt(0.5 * h * w)
                A.append(root * (R[2 * d:] + D @ R[d:2 * d] + K @ R[:d]))
                b.append(-root * G)
        force_rows = len(A) * d
        for k, key in enumerate(keys[:-1] if loop else keys):
            R = np.zeros((d, self.size))
            R[:, self.columns(k * self.per_gap).start:][:, :d] = np.eye(d)
            hard = key.weight == HARD
            root = 1.0 if hard else np.sqrt(key.weight)
            (C if hard else A).append(root * key.S @ R)
            (e if hard else b).append(root * key.p)
        for side, node in ((0, 0), (1, self.n - 1)):
            if self.s.end[side] == VELOCITY:
                R = np.zeros((d, self.size))
                R[:, self.columns(node).start + d:][:, :d] = np.eye(d)
                C.append(R)
                e.append(np.zeros(d) if self.s.v[side] is None else self.s.v[side])
        A, b = np.vstack(A), np.concatenate(b)
        self.x = least_squares(A, b, np.vstack(C), np.concatenate(e))
        self.energy = np.sum((A @ self.x - b)[:force_rows] ** 2)

    def at(self, t):
        k = min(max(np.searchsorted(self.t, t, side="right") - 1, 0), self.n - 2)
        return (self.row(k, (t - self.t[k]) / (self.t[k + 1] - self.t[k])) @ self.x)[:self.d]


def fade(u):
    u = min(max(u, 0.0), 1.0)
    return u ** 3 * (10 + u * (6 * u - 15))


def blended(parts, keys, t):
    """erratum S6: the middle half of each gap"""
    for k in range(len(keys) - 1):
        a, b = keys[k].time, keys[k + 1].time
        if t <= b:
            h = fade(((t - a) / (b - a) - 0.25) / 0.5)
            return (1 - h) * parts[k].at(t) + h * parts[k + 1].at(t)


class Coupled:
    def __init__(self, models, s, keys, points):
        d = self.d = len(keys[0].q)
        loop = s.end[0] == PERIODIC
        self.pieces = []
        for k in range(len(keys) - 1):
            middle = 0.5 * (keys[k].time + keys[k + 1].time)
            self.pieces.append((keys[k].time, middle, models[k]))
            self.pieces.append((middle, keys[k + 1].time, models[k + 1]))
        self.size = 4 * d * len(self.pieces)
        self.flow = []
        A, b, C, e = [], [], [], []
        nodes, weights = leggauss(points)
        for i, (t0, t1, model) in enumerate(self.pieces):
            K, D, G = model.matrices(s)
            self.flow.append(self.generator(K, D, G))
            for x, w in zip(nodes, weights):
                R, shift = self.state(i, 0.5 * (t0 + t1) + 0.5 * (t1 - t0) * x)
                root, rows = np.sqrt(0.5 * (t1 - t0) * w), (R[:d], R[d:2 * d], R[2 * d:3 * d])
                A.append(root * (rows[2] + D @ rows[1] + K @ rows[0]))
                b.append(-root * (shift[2 * d:3 * d] + D @ shift[d:2 * d] + K @ shift[:d] + G))

        def equal(left, right, rows):
            C.append((left[0] - right[0])[rows])
            e.append((right[1] - left[1])[rows])
        last = len(self.pieces) - 1
        for i in range(0 if loop else 1, last + 1):
            previous = i - 1 if i else last
            equal(self.state(previous, self.pieces[previous][1]), self.state(i, self.pieces[i][0]),
                  slice(0, 3 * d))
        for k, key in enumerate(keys[:-1] if loop else keys):
            i = min(2 * k, last)
            R, shift = self.state(i, key.time)
            C.append(R[:d])
            e.append(key.q - shift[:d])
        for side, i in ((0, 0), (1, last)):
            if s.end[side] == VELOCITY:
                R, shift = self.state(i, self.pieces[i][side])
                C.append(R[d:2 * d])
                v = np.zeros(d) if s.v[side] is None else s.v[side]
                e.append(v - shift[d:2 * d])
        A, b = np.vstack(A), np.concatenate(b)
        self.x = least_squares(A, b, np.vstack(C), np.concatenate(e))
        self.energy = np.sum((A @ self.x - b) ** 2)

    def generator(self, K, D, G):
        d = self.d
        M = np.zeros((4 * d + 1, 4 * d + 1))
        for i in range(3):
            M[i * d:(i + 1) * d, (i + 1) * d:(i + 2) * d] = np.eye(d)
        M[3 * d:4 * d, :d], M[3 * d:4 * d, 2 * d:3 * d] = -K @ K, D @ D - 2 * K
        M[3 * d:4 * d, 4 * d] = -K @ G
        return M

    def state(self, i, t):
        """4 d x size and 4 d: the state at t from those at the pieces' midpoints"""
        d4 = 4 * self.d
        t0, t1, _ = self.pieces[i]
        E = expm(self.flow[i] * (t - 0.5 * (t0 + t1)))
        R = np.zeros((d4, self.size))
        R[:, d4 * i:d4 * (i + 1)] = E[:d4, :d4]
        return R, E[:d4, d4]

    def at(self, t):
        i = min([k for k, p in enumerate(self.pieces) if t <= p[1]] + [len(self.pieces) - 1])
        R, shift = self.state(i, t)
        return R[:self.d] @ self.x + shift[:self.d]


def numbers(values):
    return [repr(float(x)).removesuffix(".0") for x in np.ravel(values)]


ONE, BLEND, COUPLE = range(3)


def write(name, kind, models, s, keys, per_gap=12):
    times = np.linspace(keys[0].time, keys[-1].time, 16)[1:-1]
    runs = []
    for finer in (1, 2):
        if kind == COUPLE:
            whole = Coupled(models, s, keys, 16 + 8 * finer)
            at, energy = whole.at, whole.energy
        else:
            parts = [Elements(m, s, keys, per_gap * finer) for m in models]
            energy = parts[0].energy if kind == ONE else -1.0
            at = parts[0].at if kind == ONE else lambda t: blended(parts, keys, t)
        runs.append((np.array([at(t) for t in times]), energy))
    size = np.max(np.abs(runs[1][0]))
    changed = np.max(np.abs(runs[1][0] - runs[0][0])) / size
    assert changed < 2e-6, (name, changed)
    print("case", name, *numbers([kind, len(keys[0].q), len(keys), s.alpha, s.beta, s.stiffness,
                                  *s.end, changed, size, runs[1][1], runs[0][1]]), sep=",")
    for m in models:
        print("model", *numbers([*m.lam, *m.inner, *m.outer, *m.Phi.T.ravel()]), sep=",")
    for side in range(2):
        if s.v[side] is not None:
            print("end", *numbers([side, *s.v[side]]), sep=",")
    for key in keys:
        rows = 0 if key.whole else len(key.p)
        print("key", *numbers([key.time, key.weight, rows, *key.q]), sep=",")
        for r in range(rows):
            print("row", *numbers([*key.S[r], key.p[r]]), sep=",")
    for t, q in zip(times, runs[1][0]):
        print("at", *numbers([t, *q]), sep=",")


def vector(d, size=1.0):
    return np.round(random.uniform(-size, size, d), 3)


def make_keys(d, count, gap=0.5, loop=False):
    times = np.round(np.cumsum([0.0] + list(random.uniform(0.7 * gap, 1.3 * gap, count - 1))), 3)
    keys = [Key(t, vector(d)) for t in times]
    if loop:
        keys[-1] = Key(times[-1], keys[0].q)
    return keys


def make_models(count, lam):
    d = len(lam)
    return [Model(np.array(lam) * np.round(random.uniform(0.7, 1.4, d), 2), vector(d, 5.0),
                  vector(d, 2.0)) for _ in range(count)]


def ones():
    kinds = {"under": ([9, 60, 250], 0.4, 0.01), "undamped": ([9, 60, 250], 0, 0),
             "unstable": ([-30, -4, 80], 0.3, 0.01), "rigid": ([0, 0, 40], 0, 0.02),
             "rigid_drag": ([0, 0, 40], 1.5, 0.0), "over": ([9, 60, 250], 15, 0.05),
             "critical": ([25, 100, 100], 0.0, 0.2), "stiff": ([20, 400, 2000], 2.0, 0.002)}
    for name, (lam, alpha, beta) in kinds.items():
        m = make_models(1, lam)
        fine = 40 if name in ("stiff", "over", "critical") else 16
        for end in ((VELOCITY, VELOCITY), (FREE, FREE), (PERIODIC, PERIODIC)):
            if end[0] == FREE and name in ("stiff", "over"):
                continue  # grows backward in time to hundreds: too much for elements this coarse
            v = [vector(3) if e == VELOCITY else None for e in end]
            s = Settings(alpha, beta, 1.25 if end[0] == FREE else 1.0, end, v)
            keys = make_keys(3, 4, loop=end[0] == PERIODIC)
            write(f"{name}_{end[0]}", ONE, m, s, keys, fine)


def parts(keys, end):
    """keys 1 and 2 of 4 become partial in turn, hard and soft; in a loop also 0 and 3"""
    S1, S2 = np.round(random.uniform(-1, 1, (1, 4)), 2), np.round(random.uniform(-1, 1, (2, 4)), 2)
    yield "soft", [keys[0], Key(keys[1].time, keys[1].q, 40.0), *keys[2:]]
    yield "hard1", [keys[0], Key(keys[1].time, keys[1].q, HARD, S1), *keys[2:]]
    yield "hard2", [keys[0], Key(keys[1].time, keys[1].q, HARD, S2),
                    Key(keys[2].time, keys[2].q, HARD, S1), keys[3]]
    yield "soft1", [keys[0], Key(keys[1].time, keys[1].q, 300.0, S1), *keys[2:]]
    yield "mixed", [keys[0], Key(keys[1].time, keys[1].q, 25.0, S2),
                    Key(keys[2].time, keys[2].q, HARD, S1), keys[3]]
    if end == PERIODIC:
        yield "first", [Key(keys[0].time, keys[0].q, HARD, S2), *keys[1:3],
                        Key(keys[3].time, keys[0].q, HARD, S2)]
    else:
        yield "last", [*keys[:3], Key(keys[3].time, keys[3].q, HARD, S2)]


def partial():
    for lam, alpha, beta in (([6, 30, 60, 120], 0.5, 0.01), ([-9, 0, 40, 90], 0.0, 0.0)):
        for end in (VELOCITY, FREE, PERIODIC):
            m, keys = make_models(1, lam), make_keys(4, 4, loop=end == PERIODIC)
            for name, some in parts(keys, end):
                s = Settings(alpha, beta, end=(end, end))
                write(f"part_{name}_{end}_{lam[0]}", ONE, m, s, some, 14)


def several():
    for end in (VELOCITY, FREE, PERIODIC):
        for lam, alpha, beta in (([9, 60, 250], 0.4, 0.01), ([-10, 0, 150], 0.0, 0.002)):
            keys = make_keys(3, 4, loop=end == PERIODIC)
            m = make_models(4, lam)
            if end == PERIODIC:
                m[3] = m[0]
            v = [vector(3) if end == VELOCITY else None for _ in range(2)]
            s = Settings(alpha, beta, 1.1, (end, end), v)
            write(f"blend_{end}_{lam[0]}", BLEND, m, s, keys, 16)
            write(f"couple_{end}_{lam[0]}", COUPLE, m, s, keys)
    write("couple_two_keys", COUPLE, make_models(2, [9, 60, 250]), Settings(0.4, 0.01),
          make_keys(3, 2))


ones()
partial()
several()
