#!/usr/bin/env python3
# Energy, gradient and Hessian of discrete shells in high precision, straight from the definition:
# the test vectors of tests/test_bake_shell.c.
#   command   python3 tests/reference/shell_oracle.py > tests/vectors/shell_oracle.csv
#   needs     mpmath
# Source: Schulz 2013, 2.3.2, with the weights of host-bake/body/shell.c, derived anew: areas are
# Heron's, the angle is that between the heights of the two triangles, measured in a frame about the
# edge, and the least stiffness against a change of area is found by eliminating the edges' strains.
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

    def sides(self, x, t):
        return [length(x[t[i - 2]], x[t[i - 1]]) for i in range(3)]  # opposite to corner i

    def area(self, x, t):
        return heron(*self.sides(x, t))

    def area_stiffness(self, t, k):
        young, nu, _, h = self.material
        wanted = young * h * (3 * nu - 1) / (2 * (1 - nu * nu))
        # dA/A = c . eps; the least of k/3 |eps|^2 with c . eps = 1, c by Heron's formula
        s = self.sides(self.rest, t)
        area = heron(*s)
        c = []
        for i in range(3):
            moved = [[v + (v * d if i == j else 0) for j, v in enumerate(s)]
                     for d in (STEP, -STEP)]
            c.append((heron(*moved[0]) - heron(*moved[1])) / (2 * STEP * area))
        give = k / 3 / dot(c, c)
        return max(wanted, young * h / (2 * (1 - nu)) / 4 - give)

    def weigh(self):
        self.material = young, nu, density, h = [mpf(m) for m in self.material]
        k = 4 * young * h / (1 + nu)
        of_edge = {}
        for t in self.triangles:
            for i in range(3):
                edge = tuple(sorted((t[i - 2], t[i - 1])))
                of_edge.setdefault(edge, []).append((t[i], self.area(self.rest, t)))
        self.lengths, self.angles, self.areas = [], [], []
        for (p, q), around in of_edge.items():
            l, area = length(self.rest[p], self.rest[q]), sum(a for _, a in around)
            self.lengths.append((p, q, l, k * area / 3 / l ** 2))
            if len(around) == 2:
                hinge = (p, q, around[0][0], around[1][0])
                rest = angle(*[self.rest[v] for v in hinge])
                self.angles.append((hinge, rest, young * h ** 3 / 32 * 3 * l ** 2 / area))
        self.mass = [mpf(0)] * len(self.rest)
        for t in self.triangles:
            area = self.area(self.rest, t)
            self.areas.append((t, area, self.area_stiffness(t, k) / area))
            for v in t:
                self.mass[v] += density * h * area / 3

    def energy(self, x):
        total = mpf(0)
        for p, q, rest, w in self.lengths:
            total += w * (length(x[p], x[q]) - rest) ** 2
        for t, rest, w in self.areas:
            total += w * (self.area(x, t) - rest) ** 2
        for hinge, rest, w in self.angles:
            turn = angle(*[x[v] for v in hinge]) - rest
            total += w * (turn - 2 * mp.pi * mp.floor(turn / (2 * mp.pi) + mpf(1) / 2)) ** 2
        return total / 2

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
