#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Elastic bodies and spacetime control, second hand: what a scene's bodies do, with numpy and scipy
alone, from the words of examples/README.md and the thesis. Nothing here knows a wiggly spline:

  energies    sums over triangles and hinges whose derivatives are carried along with their values
              (Jet); chains from their mass points
  motion      w(t) is piecewise quintic on fine steps, its energy (2.19) the exact integral of that.
              Between two keys the interior is eliminated, which leaves the curve of least force as a
              function of what it is at the keys; those minimise the energy of the whole (2.32), all
              in one dense system with C2 as a condition. No case distinction, no closed form.

Source: Schulz 2013, chapter 2, errata S1-S9, S14.
  x  n       coordinates [m], of chains also [rad]      M  n x n   masses [kg]
  V  n x d   basis of the reduced space, V^T M V = 1    q  d       x = origin + V q
  P  d x d   modes of one model: q = P c                z  5       (w0, w0', w1, w1', 1) of a segment"""
import numpy as np
import scipy.linalg

UNIT = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


# ---- derivatives -----------------------------------------------------------------------------------
class Jet:
    """Values of many elements with first and second derivatives by their k coordinates."""

    def __init__(self, v, g, h):
        self.v, self.g, self.h = v, g, h

    @staticmethod
    def variables(x):
        """x: elements x k; a jet for each column."""
        n, k = x.shape
        return [Jet(x[:, i], np.tile(np.eye(k)[i], (n, 1)), np.zeros((n, k, k))) for i in range(k)]

    def of(self, f, d, dd):
        g = self.g
        return Jet(f, d[:, None] * g, d[:, None, None] * self.h +
                   dd[:, None, None] * g[:, :, None] * g[:, None, :])

    def __add__(self, o):
        return Jet(self.v + o.v, self.g + o.g, self.h + o.h) if isinstance(o, Jet) else \
            Jet(self.v + o, self.g, self.h)

    def __neg__(self):
        return Jet(-self.v, -self.g, -self.h)

    def __sub__(self, o):
        return self + (-o)

    def __mul__(self, o):
        if not isinstance(o, Jet):
            o = np.broadcast_to(o, self.v.shape)
            return Jet(self.v * o, self.g * o[:, None], self.h * o[:, None, None])
        a, b = self, o
        cross = a.g[:, :, None] * b.g[:, None, :]
        return Jet(a.v * b.v, a.g * b.v[:, None] + b.g * a.v[:, None],
                   a.h * b.v[:, None, None] + b.h * a.v[:, None, None] + cross +
                   cross.transpose(0, 2, 1))

    __radd__, __rmul__ = __add__, __mul__

    def root(self):
        r = np.sqrt(self.v)
        return self.of(r, 0.5 / r, -0.25 / r ** 3)

    def over(self):
        return self.of(1 / self.v, -1 / self.v ** 2, 2 / self.v ** 3)

    def cos(self):
        c, s = np.cos(self.v), np.sin(self.v)
        return self.of(c, -s, -c)

    def sin(self):
        c, s = np.cos(self.v), np.sin(self.v)
        return self.of(s, c, -s)


def angle_of(y, x):
    """atan2, as the sum of what a turn by minus its value leaves, which is near 0, and that value."""
    a = np.arctan2(y.v, x.v)
    c, s = np.cos(a), np.sin(a)
    t = (y * c - x * s) * (x * c + y * s).over()  # tan of the rest: 0 here, atan'' is 0 there
    return t + a


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def minus(a, b):
    return [p - q for p, q in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def scatter(jet, index, n):
    """Sum over elements of value, gradient, Hessian; index: elements x k, where coordinates are."""
    g, H = np.zeros(n), np.zeros((n, n))
    np.add.at(g, index, jet.g)
    np.add.at(H, (index[:, :, None], index[:, None, :]), jet.h)
    return jet.v.sum(), g, H


# ---- shells ----------------------------------------------------------------------------------------
class Shell:
    """St. Venant-Kirchhoff in plane stress (S5), and a plate's energy of the change of curvature that
    the hinges around each triangle make, as the head of host-bake/body/shell.c has it."""

    def __init__(self, rest, triangles, young, poisson, density, thickness):
        self.rest, self.tri = np.array(rest, float).ravel(), np.array(triangles)
        self.n, at = self.rest.size, self.rest.reshape(-1, 3)
        self.young, self.poisson, self.thickness = young, poisson, thickness
        a, b = (at[self.tri[:, k]] - at[self.tri[:, 0]] for k in (1, 2))
        self.area = np.linalg.norm(np.cross(a, b), axis=1) / 2
        self.mass = np.zeros(len(at))
        for k in range(3):
            np.add.at(self.mass, self.tri[:, k], density * thickness * self.area / 3)
        self.M = np.diag(np.repeat(self.mass, 3))
        self.hinges()
        self.metric = self.flat(at, self.tri)

    def hinges(self):
        """Inner edges p q, with what is opposite to them in the triangle with p -> q and the other."""
        at, found = self.rest.reshape(-1, 3), {}
        for t, v in enumerate(self.tri):
            for k in range(3):
                found[v[k], v[k - 2]] = (t, v[k - 1])
        inner = [(p, q) for p, q in found if p < q and (q, p) in found]
        self.hinge = np.array([(p, q, found[p, q][1], found[q, p][1]) for p, q in inner])
        self.bend = self.angles(self.rest).v
        number = {frozenset(e): i for i, e in enumerate(inner)}
        self.B = np.zeros((len(inner), len(inner)))
        for v in self.tri:
            sides = [number.get(frozenset((v[k - 2], v[k - 1])), -1) for k in range(3)]
            own = [k for k in range(3) if sides[k] >= 0]
            self.B[np.ix_([sides[k] for k in own], [sides[k] for k in own])] += \
                self.bending(at[v], own)

    def bending(self, at, own):
        """Of one triangle, in the turns at its sides: L = sum turn l/(2 A) n n^T, energy
        A D/2 (nu (tr L)^2 + (1 - nu) tr L^2); border sides turn as costs least."""
        D = np.linalg.inv(self.flat(at, np.array([[0, 1, 2]]))[0])
        flat = np.array([[0, 0], D[:, 0], D[:, 1]])
        area = abs(np.linalg.det(D)) / 2
        parts = []
        for k in range(3):
            e = flat[k - 1] - flat[k - 2]
            parts.append(np.outer([e[1], -e[0]], [e[1], -e[0]]) / np.linalg.norm(e) / (2 * area))
        stiff = self.young * self.thickness ** 3 / 12 / (1 - self.poisson ** 2)
        B = area * stiff * np.array([[self.poisson * np.trace(p) * np.trace(q) +
                                      (1 - self.poisson) * np.trace(p @ q) for q in parts]
                                     for p in parts])
        loose = [k for k in range(3) if k not in own]
        pick = B[np.ix_(own, loose)]
        return B[np.ix_(own, own)] - pick @ np.linalg.pinv(B[np.ix_(loose, loose)], 1e-10) @ pick.T

    @staticmethod
    def flat(at, tri):
        """Of each triangle, the inverse of its sides from corner 0 in its own plane."""
        a, b = (at[tri[:, k]] - at[tri[:, 0]] for k in (1, 2))
        e = a / np.linalg.norm(a, axis=1)[:, None]
        along = (b * e).sum(axis=1)
        up = np.linalg.norm(b - along[:, None] * e, axis=1)
        D = np.zeros((len(a), 2, 2))
        D[:, 0, 0], D[:, 0, 1], D[:, 1, 1] = np.linalg.norm(a, axis=1), along, up
        return np.linalg.inv(D)

    @staticmethod
    def places(index):
        return (3 * index[:, :, None] + np.arange(3)).reshape(len(index), -1)

    def corners(self, index, x):
        v = Jet.variables(x[self.places(index)])
        return [v[3 * k:3 * k + 3] for k in range(len(v) // 3)]

    def angles(self, x):
        p, q, a, b = self.corners(self.hinge, x)
        e = minus(q, p)
        m, n = cross(e, minus(a, p)), cross(minus(b, p), e)
        return angle_of(dot(e, cross(m, n)) * dot(e, e).root().over(), dot(m, n))

    def membrane(self, x):
        p, a, b = self.corners(self.tri, x)
        a, b, D = minus(a, p), minus(b, p), self.metric
        F = [[a[i] * D[:, 0, j] + b[i] * D[:, 1, j] for i in range(3)] for j in range(2)]
        e = [(dot(F[0], F[0]) + -1.0) * 0.5, dot(F[0], F[1]) * 0.5, (dot(F[1], F[1]) + -1.0) * 0.5]
        nu = self.poisson
        mu, lam = self.young / (2 + 2 * nu), self.young * nu / ((1 + nu) * (1 - 2 * nu))
        trace = e[0] + e[2]
        w = trace * trace * (lam * mu / (lam + 2 * mu)) + \
            (e[0] * e[0] + e[1] * e[1] * 2.0 + e[2] * e[2]) * mu
        return w * (self.area * self.thickness)

    def potential(self, x):
        """V, dV, d2V."""
        V, dV, K = scatter(self.membrane(x), self.places(self.tri), self.n)
        turn, index = self.angles(x) + -self.bend, self.places(self.hinge)
        G = np.zeros((len(index), self.n))
        np.add.at(G, (np.arange(len(index))[:, None], index), turn.g)
        pull = self.B @ turn.v
        np.add.at(K, (index[:, :, None], index[:, None, :]), pull[:, None, None] * turn.h)
        return V + turn.v @ pull / 2, dV + G.T @ pull, K + G.T @ self.B @ G

    def at_rest_in(self, x):
        """The body that is at rest there, of the same masses."""
        other = object.__new__(Shell)
        other.__dict__.update(self.__dict__)
        other.rest, at = x, x.reshape(-1, 3)
        a, b = (at[self.tri[:, k]] - at[self.tri[:, 0]] for k in (1, 2))
        other.area = np.linalg.norm(np.cross(a, b), axis=1) / 2
        other.hinges()
        other.metric = other.flat(at, other.tri)
        return other


# ---- chains ----------------------------------------------------------------------------------------
class Chain:
    """Coordinates: root (if free), then the absolute angle of each link that is not stiff."""
    GAUSS = ((0.5 - np.sqrt(0.15), 5 / 18), (0.5, 8 / 18), (0.5 + np.sqrt(0.15), 5 / 18))

    def __init__(self, links, free_root=False, root_mass=0.0, gravity=0.0):
        """links: dicts of parent (number), length, angle [rad], mass, density, spring, stiff."""
        self.links, self.gravity = links, gravity
        self.free, self.root_mass = bool(free_root), root_mass
        self.at, self.rest = {}, [0.0, 0.0] if self.free else []
        for i, l in enumerate(links):
            if not l["stiff"]:
                self.at[i] = len(self.rest)
                self.rest.append(l["angle"])
        self.rest = np.array(self.rest)
        self.n = len(self.rest)

    def angle(self, q, i):
        """Of link i: q[coordinate] plus a constant."""
        l = self.links[i]
        if i in self.at:
            return q[self.at[i]]
        p = l["parent"]
        return self.angle(q, p) + (l["angle"] - self.links[p]["angle"]) if p >= 0 else l["angle"]

    def place(self, q, i, share, cos=np.cos, sin=np.sin):
        x, y = (q[0], q[1]) if self.free else (0.0, 0.0)
        while i >= 0:
            a, l = self.angle(q, i), share * self.links[i]["length"]
            x, y = cos(a) * l + x, sin(a) * l + y
            i, share = self.links[i]["parent"], 1.0
        return x, y

    def points(self):
        yield self.root_mass, -1, 0.0
        for i, l in enumerate(self.links):
            yield l["mass"], i, 1.0
            for s, w in self.GAUSS:
                a, b = l["density"]
                yield w * l["length"] * (a + s * (b - a)), i, s

    def jets(self, q):
        cos = lambda a: a.cos() if isinstance(a, Jet) else np.cos(a)
        sin = lambda a: a.sin() if isinstance(a, Jet) else np.sin(a)
        v = Jet.variables(np.array(q, float)[None])
        for m, i, s in self.points():
            yield m, self.place(v, i, s, cos, sin)

    def mass_matrix(self, q):
        M = np.zeros((self.n, self.n))
        for m, place in self.jets(q):
            for c in place:
                if isinstance(c, Jet):
                    M += m * np.outer(c.g[0], c.g[0])
        return M

    @property
    def M(self):
        return self.mass_matrix(self.rest)

    def potential(self, q):
        """V, dV, d2V of springs, and of springs and weights."""
        v = Jet.variables(np.array(q, float)[None])
        total = v[0] * 0.0
        for i, l in enumerate(self.links):
            if i in self.at:
                p = l["parent"]
                bend, rest = self.angle(v, i), l["angle"]
                if p >= 0:
                    bend, rest = bend - self.angle(v, p), rest - self.links[p]["angle"]
                bend = bend + -rest
                total = total + bend * bend * (l["spring"] / 2)
        for m, place in self.jets(q):
            if isinstance(place[1], Jet):
                total = total + place[1] * (m * self.gravity)
        return total.v[0], total.g[0], total.h[0]


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
        self.gap = lam[count] / lam[count - 1] if count < len(lam) else np.inf
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
        n, out = self.count, np.zeros((5, 5))
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
        self.left = np.abs(self.C @ u - self.b).max()
        N = Vt[rank:].T
        self.free = N.shape[1]
        if self.free:
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
