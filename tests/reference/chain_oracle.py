#!/usr/bin/env python3
# Planar chains in high precision, from their mass points: the test vectors of tests/test_bake_chain.c.
#   command   python3 tests/reference/chain_oracle.py > tests/vectors/chain_oracle.csv
#   needs     mpmath
# Source: Schulz 2013, 2.3.1, without the matrices of its appendix (errata S14, S15). A pose is the sum of
# the links along the path to the root. Each rod is three mass points at the places of Gauss's rule, which
# is exact for its density times a squared velocity (degree 3). Velocities are numerical derivatives of
# positions; M comes from the kinetic energy by polarisation; dV, d2V are numerical derivatives of V.
# SPDX-License-Identifier: AGPL-3.0-or-later
import random

from mpmath import cos, diff, mp, mpf, pi, sin, sqrt

mp.dps = 60
GAUSS = [(mpf(1) / 2 - sqrt(mpf(3) / 20), mpf(5) / 18), (mpf(1) / 2, mpf(8) / 18),
         (mpf(1) / 2 + sqrt(mpf(3) / 20), mpf(5) / 18)]


class Link:
    def __init__(self, parent, length, angle, mass=0, density=(0, 0), spring=0, stiff=0):
        self.parent, self.length, self.angle, self.mass = parent, length, float(angle), mass
        self.density, self.spring, self.stiff = density, spring, stiff


class Chain:
    def __init__(self, name, links, free_root=0, root_mass=0, gravity=0):
        self.name, self.links, self.free_root = name, links, free_root
        self.root_mass, self.gravity = root_mass, gravity
        self.size = 2 * free_root + sum(not l.stiff for l in links)

    def angles(self, q):
        q = list(q[2 * self.free_root:])
        out = []
        for l in self.links:
            if not l.stiff:
                out.append(q.pop(0))
            elif l.parent < 0:
                out.append(mpf(l.angle))
            else:
                out.append(out[l.parent] + mpf(l.angle) - mpf(self.links[l.parent].angle))
        return out

    def place(self, q, link, share):
        """Where a link is at `share` of its length; link -1: the root."""
        x, y = (q[0], q[1]) if self.free_root else (mpf(0), mpf(0))
        angles = self.angles(q)
        while link >= 0:
            x += share * self.links[link].length * cos(angles[link])
            y += share * self.links[link].length * sin(angles[link])
            link, share = self.links[link].parent, 1
        return x, y

    def mass_points(self):
        """(mass, link, share of its length)"""
        yield mpf(self.root_mass), -1, 0
        for i, l in enumerate(self.links):
            yield mpf(l.mass), i, 1
            a, b = map(mpf, l.density)
            for share, weight in GAUSS:
                yield weight * l.length * (a + share * (b - a)), i, share

    def kinetic(self, q, v):
        total = mpf(0)
        for m, link, share in self.mass_points():
            for k in range(2):
                speed = diff(lambda t: self.place([a + t * b for a, b in zip(q, v)], link,
                                                  share)[k], 0)
                total += m * speed ** 2 / 2
        return total

    def mass_matrix(self, q):
        n = self.size
        unit = [[mpf(i == j) for j in range(n)] for i in range(n)]
        own = [self.kinetic(q, u) for u in unit]
        return [2 * own[i] if i == j else self.kinetic(
            q, [a + b for a, b in zip(unit[i], unit[j])]) - own[i] - own[j]
            for i in range(n) for j in range(n)]

    def potential(self, q):
        angles = self.angles(q)
        total = sum(mpf(self.gravity) * m * self.place(q, link, share)[1]
                    for m, link, share in self.mass_points())
        for i, l in enumerate(self.links):
            if not l.stiff:
                bend, rest = angles[i], mpf(l.angle)
                if l.parent >= 0:
                    bend -= angles[l.parent]
                    rest -= mpf(self.links[l.parent].angle)
                total += mpf(l.spring) / 2 * (bend - rest) ** 2
        return total

    def derivative(self, q, *coordinates):
        orders = tuple(coordinates.count(i) for i in range(self.size))
        return diff(lambda *x: self.potential(x), tuple(q), orders)


def numbers(tag, values):
    print(tag + "," + ",".join("%.17g" % float(v) for v in values))


def write(c, poses, rng):
    print("case,%s,%d,%d,%r,%r" % (c.name, len(c.links), c.free_root, c.root_mass, c.gravity))
    for l in c.links:
        print("link,%d,%d,%r,%r,%r,%r,%r,%r" % (l.parent, l.stiff, l.length, l.angle, l.mass,
                                                l.density[0], l.density[1], l.spring))
    n = range(c.size)
    for _ in range(poses):
        q = [mpf(round(rng.uniform(-4, 4), 3)) for _ in n]
        numbers("q", q)
        numbers("points", [v for i in range(len(c.links)) for s in (0, 1)
                           for v in (c.place(q, i, 1) if s else c.place(q, c.links[i].parent, 1))])
        numbers("mass", c.mass_matrix(q))
        numbers("energy", [c.potential(q)])
        numbers("gradient", [c.derivative(q, i) for i in n])
        numbers("hessian", [c.derivative(q, i, j) for i in n for j in n])


def main():
    rng = random.Random(2013)
    down = -pi / 2
    one = (1.0, 1.0)
    cases = [
        Chain("rod", [Link(i - 1, 1.0, down, 1.0, spring=0.5) for i in range(4)], gravity=9.81),
        Chain("free_rod", [Link(i - 1, 1.0 + i / 4, 0.3 * i, 0.5 + i, spring=2.0 - i / 2)
                           for i in range(3)], 1, 0.75, 9.81),
        Chain("luxo", [Link(-1, 1.0, 0.4, density=one), Link(0, 1.5, 2.0, density=one, spring=0.5),
                       Link(1, 1.5, 0.8, density=one, spring=0.5),
                       Link(2, 0.5, -0.2, density=one, spring=0.5),
                       Link(3, 0.75, 0.1, density=one, stiff=1),
                       Link(3, 0.75, -0.5, density=one, stiff=1)], 1),
        Chain("tree", [Link(-1, 0.3, 1.2, 0.1, (0.2, 0.7), 3.0),
                       Link(0, 0.2, 2.2, 0.0, (0.5, 0.0), 1.0),
                       Link(0, 0.4, 0.2, 0.05, (0.0, 0.3), 0.7), Link(2, 0.1, -1.0, 0.02, stiff=1),
                       Link(3, 0.25, -0.7, 0.03, (0.1, 0.1), 0.4), Link(-1, 0.15, -2.0, 0.2),
                       Link(3, 0.2, 0.5, 0.04, (0.2, 0.4), stiff=1)], 1, 0.0, 9.81),
        Chain("post", [Link(-1, 2.0, 1.5, 1.0, stiff=1), Link(0, 1.0, 1.0, 0.0, (0.3, 0.6), 5.0),
                       Link(1, 1.0, 0.2, 0.4, (0.6, 0.2), 2.0)], gravity=-3.0),
    ]
    print("# written by tests/reference/chain_oracle.py; AGPL-3.0-or-later")
    print("# case,name,links,free root,root mass,gravity")
    print("# link,parent,stiff,length,angle,end mass,density at start and end,spring")
    print("# then for some q: points (link by link x0,y0,x1,y1), mass, energy, gradient, hessian")
    for c in cases:
        write(c, 3, rng)


if __name__ == "__main__":
    main()
