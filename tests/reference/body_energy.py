#!/usr/bin/env python3
# SPDX-License-Identifier: AGPL-3.0-or-later
"""Energies and masses of shells and chains with numpy, for body_oracle.py: sums over triangles, hinges,
joints and mass points whose derivatives are carried along with their values (Jet).

Source: Schulz 2013, 2.3.1; erratum S5; the head of host-bake/body/shell.c says what its energy is.
  x  n       coordinates [m], of chains also [rad]      M  n x n   masses [kg]"""
import numpy as np


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
