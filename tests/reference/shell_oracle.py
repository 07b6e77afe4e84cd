#!/usr/bin/env python3
# Energy, gradient and Hessian of discrete shells in high precision, straight from the definition:
# the test vectors of tests/test_bake_shell.c.
#   command   python3 tests/reference/shell_oracle.py > tests/vectors/shell_oracle.csv
#   needs     mpmath
# Source: the energy of host-bake/body/shell.c, derived anew: strains from squared lengths of sides,
# each triangle's change of curvature in a frame of its own with the border's angles found by
# minimising, angles between the heights of two triangles, measured in a frame about the edge.
# Derivatives are central differences with step 1e-25 in 90 digits: exact to some 45 digits.
# SPDX-License-Identifier: AGPL-3.0-or-later
import itertools
import random

from mpmath import mp, mpf, matrix

mp.dps = 90
STEP = mpf(10) ** -25


def sub(a, b):
    return [p - q for p, q in zip(a, b)]


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def length(a, b):
    return mp.sqrt(dot(sub(a, b), sub(a, b)))


def heron(a, b, c):
    s = (a + b + c) / 2
    return mp.sqrt(s * (s - a) * (s - b) * (s - c))


def height(edge, foot, top):
    """From the line of the edge to a vertex."""
    w = sub(top, foot)
    t = dot(w, edge) / dot(edge, edge)
    return [w[i] - t * edge[i] for i in range(3)]


def angle(p, q, a, b):
    """Of the triangles p q a and p q b: 0 when they lie flat."""
    edge = sub(q, p)
    first, second = height(edge, p, a), height(edge, p, b)
    across = cross([c / mp.sqrt(dot(edge, edge)) for c in edge], first)
    # the far height of a flat hinge is -first: half a turn is 0
    return mp.atan2(-dot(second, across), -dot(second, first))


class Case:
    def __init__(self, name, rest, triangles, material, at):
        self.name, self.triangles, self.material = name, triangles, material
        self.rest_float, self.at_float = rest, at
        self.rest = [[mpf(c) for c in p] for p in rest]
        self.at = [[mpf(c) for c in p] for p in at]
        self.weigh()

    def area(self, x, t):
        return heron(*[length(x[t[i - 2]], x[t[i - 1]]) for i in range(3)])

    def turns(self, x, t):
        """A triangle's three angles, about its own normal; None: border."""
        out = []
        for i in range(3):
            p, q = t[i - 2], t[i - 1]
            behind = [v for other in self.triangles if other is not t and {p, q} <= set(other)
                      for v in other if v not in (p, q)]
            out.append(angle(x[p], x[q], x[t[i]], x[behind[0]]) if behind else None)
        return out

    def weigh(self):
        self.material = young, nu, density, h = [mpf(m) for m in self.material]
        self.stretch = young * h / (1 - nu * nu)
        self.stiffness = young * h ** 3 / (12 * (1 - nu * nu))
        self.mass = [mpf(0)] * len(self.rest)
        self.faces = []
        for t in self.triangles:
            area = self.area(self.rest, t)
            for v in t:
                self.mass[v] += density * h * area / 3
            self.faces.append((t, area, self.flat(t), self.turns(self.rest, t)))

    def flat(self, t):
        """Sides in the plane of the triangle, each opposite to a corner."""
        side = [sub(self.rest[t[i - 1]], self.rest[t[i - 2]]) for i in range(3)]
        first = [c / mp.sqrt(dot(side[0], side[0])) for c in side[0]]
        up = height(first, [mpf(0)] * 3, side[1])
        second = [c / mp.sqrt(dot(up, up)) for c in up]
        return [(dot(s, first), dot(s, second)) for s in side]

    def density(self, xx, yy, xy):
        """nu tr^2 + (1 - nu) tr(square), for strains and for curvatures."""
        nu = self.material[1]
        return nu * (xx + yy) ** 2 + (1 - nu) * (xx * xx + yy * yy + 2 * xy * xy)

    def stretching(self, x, face):
        """side . E side is half of what the side's square grew by."""
        t, area, flat, _ = face
        rows, grown = matrix(3, 3), matrix(3, 1)
        for i, (u, v) in enumerate(flat):
            rows[i, 0], rows[i, 1], rows[i, 2] = u * u, v * v, 2 * u * v
            now = sub(x[t[i - 1]], x[t[i - 2]])
            grown[i] = (dot(now, now) - u * u - v * v) / 2
        return self.stretch * area / 2 * self.density(*mp.lu_solve(rows, grown))

    def bending(self, x, face):
        t, area, flat, rest = face
        known, free = [mpf(0)] * 3, []
        for turn, before, (u, v) in zip(self.turns(x, t), rest, flat):
            size = mp.sqrt(u * u + v * v)
            shape = [v * v / size, u * u / size, -u * v / size]  # length times normal squared
            if turn is None:
                free.append(shape)
                continue
            turn -= before
            turn -= 2 * mp.pi * mp.floor(turn / (2 * mp.pi) + mpf(1) / 2)
            known = [k + turn * s / (2 * area) for k, s in zip(known, shape)]
        if len(free) == 3:
            return mpf(0)
        if free:
            def product(a, b):
                return (self.density(*[p + q for p, q in zip(a, b)]) -
                        self.density(*[p - q for p, q in zip(a, b)])) / 4
            rows = matrix(len(free), len(free))
            right = matrix(len(free), 1)
            for i, a in enumerate(free):
                right[i] = -product(a, known)
                for j, b in enumerate(free):
                    rows[i, j] = product(a, b)
            for c, a in zip(mp.lu_solve(rows, right), free):
                known = [k + c * s for k, s in zip(known, a)]
        return self.stiffness * area / 2 * self.density(*known)

    def energy(self, x):
        return sum(self.stretching(x, f) + self.bending(x, f) for f in self.faces)

    def moved(self, *steps):
        x = [list(p) for p in self.at]
        for i, d in steps:
            x[i // 3][i % 3] += d
        return self.energy(x)

    def gradient(self):
        return [(self.moved((i, STEP)) - self.moved((i, -STEP))) / (2 * STEP)
                for i in range(3 * len(self.at))]

    def hessian(self):
        n = 3 * len(self.at)
        H = matrix(n, n)
        for i in range(n):
            for j in range(i + 1):
                signs = itertools.product((1, -1), repeat=2)
                H[i, j] = sum(a * b * self.moved((i, a * STEP), (j, b * STEP))
                              for a, b in signs) / (4 * STEP ** 2)
                H[j, i] = H[i, j]
        return H

    def write(self):
        m = ','.join(repr(float(v)) for v in self.material)
        print(f'case,{self.name},{len(self.rest)},{len(self.triangles)},{m},'
              f'{float(self.energy(self.at))!r}')
        for t in self.triangles:
            print('triangle,' + ','.join(map(str, t)))
        H, g = self.hessian(), self.gradient()
        for v, p in enumerate(self.rest_float):
            q = list(p) + list(self.at_float[v]) + [float(self.mass[v])]
            q += [float(x) for x in g[3 * v:3 * v + 3]]
            print('vertex,' + ','.join(repr(c) for c in q))
        for i in range(H.rows):
            print('row,' + ','.join(repr(float(H[i, j])) for j in range(H.rows)))


def shaken(points, amount, dice):
    return [tuple(c + dice.uniform(-amount, amount) for c in p) for p in points]


def hinge(degrees, wide=0.9, high=0.7):
    """Two triangles about the x axis; the second is turned up by so much from flat."""
    t = mp.radians(degrees)
    up = (float(high * mp.cos(t)), float(high * mp.sin(t)))
    return [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.4, -wide, 0.0), (0.7, up[0], up[1])]


def cases():
    dice = random.Random(7)
    rubber, paper, foam = (1e6, 0.45, 1100.0, 0.05), (2e9, 0.2, 800.0, 3e-4), (5e4, -0.4, 30., 0.1)
    cork = (2e7, 0.0, 200.0, 0.2)
    two = [(0, 1, 3), (1, 0, 2)]
    yield Case('triangle', hinge(0)[:3], [(0, 1, 2)], rubber, shaken(hinge(0)[:3], 0.2, dice))
    yield Case('flat hinge at rest', hinge(0), two, cork, hinge(0))
    yield Case('bent hinge at rest', hinge(70), two, cork, hinge(70))
    yield Case('hinge folded by 120 degrees', hinge(0), two, rubber, shaken(hinge(120), 0.1, dice))
    yield Case('hinge folded by 179 degrees', hinge(0), two, rubber, hinge(179))
    yield Case('hinge beyond half a turn', hinge(165), two, cork, shaken(hinge(195), 0.05, dice))
    yield Case('neighbours wound against each other', hinge(30), [(0, 1, 3), (0, 1, 2)], paper,
               shaken(hinge(-50), 0.1, dice))
    solid = [(0.0, 0.0, 0.0), (1.0, 0.1, 0.0), (0.3, 0.9, 0.1), (0.4, 0.3, 0.8)]
    skin = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    yield Case('closed skin', solid, skin, rubber, shaken(solid, 0.15, dice))
    fan = [(0.0, 0.0, 0.2), (1.0, 0.0, 0.0), (0.5, 0.9, 0.0), (-0.4, 0.8, 0.1), (-1.0, 0.1, 0.0),
           (-0.1, -0.3, 0.1)]  # the last two triangles are obtuse
    fans = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 1)]
    flaps = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.3, 0.9, 0.0), (0.9, 0.8, 0.2), (-0.5, 0.6, 0.3),
             (0.6, -0.7, 0.1)]
    yield Case('flaps around a triangle', flaps, [(0, 1, 2), (1, 2, 3), (0, 2, 4), (0, 5, 1)], cork,
               shaken(flaps, 0.15, dice))
    for name, material in (('rubber', rubber), ('paper', paper), ('foam', foam), ('cork', cork)):
        yield Case(f'fan of {name}', fan, fans, material, shaken(fan, 0.1, dice))
    yield Case('fan at rest', fan, fans, foam, fan)


if __name__ == '__main__':
    print('# written by tests/reference/shell_oracle.py; AGPL-3.0-or-later')
    print('# case,name,vertices,triangles,young,poisson,density,thickness,energy')
    print('# triangle,3 vertices')
    print('# vertex,rest,deformed,mass,gradient')
    print('# row,of the Hessian')
    for case in cases():
        case.write()
